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
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=click.Path(allow_dash=True))
@click.option("--kind", "kinds", multiple=True, type=click.Choice(KINDS), help="Only changes of this kind.")
@click.option("--system", is_flag=True, help="Only changes of what is checked, none of what is only required.")
@click.option("--sample", metavar="N", type=click.IntRange(min=1), help="Only N changes, drawn by chance.")
@click.option("--seed", type=int, default=0, show_default=True, help="Draws other changes for --sample.")
@click.option("--format", "form", type=click.Choice(FORMATS), default="full", show_default=True, help="Output form.")
@output_option
@assert_option
@script_options
@limit_options
@manner_options
def command(**options: Any) -> None:
    """Change scripts in one place after the other, and check their assertions on each of these mutants.

    A change after which every assertion has the verdict that it had before is told, unless it changes nothing: where
    all processes that the assertions speak of have the failures and divergences that they had, it is equivalent.
    FILE:LINE asks the assertion on that line alone; a folder stands for all scripts below it, and a change in a file
    that several include is tried in each of them. Exit codes: 0 every change is noticed or equivalent; 1 one is not;
    3 not decided; 5 nothing to change, or no assertion with a verdict.
    """
    from cspcheck import __version__
    from cspcheck.cli.interrupt import Interrupts
    from cspcheck.cli.progress import Heartbeat, ProgressLine
    from cspcheck.cli.streams import Remarks, output_to
    from cspcheck.cspm.diagnostics import ScriptError
    from cspcheck.messages import nothing_to_mutate
    from cspcheck.mutating import Mutant, Mutation, NothingToNotice
    from cspcheck.report.mutate import document, listing, summary
    from cspcheck.report.style import is_terminal, style_for
    from cspcheck.result import Exit
    from cspcheck.selection import AssertionPattern, EmptyFolder, targets

    chosen: list[tuple[str, frozenset[int] | None]] = []
    for target in targets(options["files"]):
        if isinstance(target, EmptyFolder):
            raise click.UsageError(f"there are no scripts in `{target.path}`")
        chosen.append((target.path, target.lines))
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
                    chosen,
                    settings(options, definitions(options)),
                    patterns=[AssertionPattern(text) for text in options["patterns"]],
                    kinds=options["kinds"],
                    system=options["system"],
                    watch=line,
                )
                sample = options["sample"]
                for mutant in (
                    mutation.tried(mutation.changes()) if sample is None else mutation.sample(sample, options["seed"])
                ):
                    found.append(mutant)
                    interrupts.poll()
        except NothingToNotice:
            raise ScriptError(nothing_to_mutate(chosen[0][0])) from None
        except KeyboardInterrupt:
            interrupted = True
        finally:
            line.done()
        found.sort(key=lambda mutant: (mutant.change.span.source.name, mutant.change.span.start))
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
        if fates & {"noticed", "equivalent"}
        else Exit.NOTHING
    )
