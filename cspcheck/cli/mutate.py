"""``cspcheck mutate FILE``: which changes of a script does no assertion notice?"""

from __future__ import annotations

import sys
import time
from typing import Any

import click

from cspcheck.cli import finish
from cspcheck.cli.options import (
    ConfiguredCommand,
    assert_option,
    definitions,
    limit_options,
    manner_options,
    output_option,
    script_options,
    settings,
)

FORMATS = ("full", "json")
KINDS = ("synchronisation", "guard", "event", "constant", "operator", "hiding", "renaming", "predicate")


@click.command(cls=ConfiguredCommand, short_help="Say which changes of a script no assertion notices.")
@click.argument("file", metavar="FILE", type=click.Path(allow_dash=True))
@click.option("--kind", "kinds", multiple=True, type=click.Choice(KINDS), help="Only changes of this kind.")
@click.option("--format", "form", type=click.Choice(FORMATS), default="full", show_default=True, help="Output form.")
@output_option
@assert_option
@script_options
@limit_options
@manner_options
def command(**options: Any) -> None:
    """Change the script FILE in one place after the other, and check its assertions on each of these mutants.

    A change after which every assertion has the verdict that it had before is told: nothing in the script says that
    it must not be so. FILE:LINE asks the assertion on that line alone. Exit codes: 0 every change is noticed; 1 one is
    not; 3 not decided; 5 nothing to change, or no assertion with a verdict.
    """
    from cspcheck import __version__
    from cspcheck.cli.interrupt import Interrupts
    from cspcheck.cli.progress import Heartbeat, ProgressLine
    from cspcheck.cli.streams import Remarks, output_to
    from cspcheck.cspm.diagnostics import ScriptError
    from cspcheck.messages import nothing_to_mutate
    from cspcheck.mutating import Mutant, Mutation, Nothing
    from cspcheck.report.mutate import document, listing, summary
    from cspcheck.report.style import is_terminal, style_for
    from cspcheck.result import Exit
    from cspcheck.selection import EmptyFolder, Pattern, targets

    (target,) = targets([options["file"]])[:1]
    if isinstance(target, EmptyFolder) or len(targets([options["file"]])) > 1:
        raise click.UsageError(f"`{options['file']}` is a folder: name one script")
    start = time.perf_counter()
    verbosity = options["verbose"] - options["quiet"]
    interrupts = Interrupts()
    line = ProgressLine(
        Remarks().write,
        style_for(sys.stderr, options["color"]),
        live=is_terminal(sys.stderr),
        quiet=verbosity < 0,
        poll=interrupts.poll,
    )
    found: list[Mutant] = []
    interrupted = False
    with output_to(options["output"]) as output:
        try:
            with interrupts, Heartbeat(line.beat):
                mutation = Mutation(
                    target.path,
                    settings(options, definitions(options)),
                    lines=target.lines,
                    patterns=[Pattern(text) for text in options["patterns"]],
                    kinds=options["kinds"],
                    watch=line,
                )
                for mutant in mutation.tried(mutation.changes()):
                    found.append(mutant)
                    interrupts.poll()
        except Nothing:
            raise ScriptError(nothing_to_mutate(target.path)) from None
        except KeyboardInterrupt:
            interrupted = True
        finally:
            line.done()
        if options["form"] == "json":
            output.write(document(found, __version__, interrupted=interrupted) + "\n")
        else:
            style = style_for(output.stream, options["color"])
            text = listing(found, style, verbosity)
            if verbosity >= 0:
                text += [*([""] if text else []), summary(found, time.perf_counter() - start, interrupted=interrupted)]
            output.write("".join(f"{one}\n" for one in text))
    fates = {mutant.fate for mutant in found}
    if interrupted:
        finish(Exit.INTERRUPTED)
    finish(
        Exit.FAILED
        if "unnoticed" in fates
        else Exit.UNKNOWN
        if "undecided" in fates
        else Exit.OK
        if "noticed" in fates
        else Exit.NOTHING
    )
