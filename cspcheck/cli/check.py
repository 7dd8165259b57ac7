"""``cspcheck check FILE...``: check the assertions of scripts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from cspcheck.cli import finish
from cspcheck.cli.options import (
    ConfiguredCommand,
    assert_option,
    definitions,
    files_argument,
    limit_options,
    manner_options,
    output_options,
    script_options,
    settings,
)

if TYPE_CHECKING:
    from cspcheck.result import Exit
    from cspcheck.selection import EmptyFolder, Target


@click.command(cls=ConfiguredCommand, short_help="Check the assertions of scripts (the default).")
@files_argument
@output_options
@assert_option
@script_options
@limit_options
@click.option("--coverage", is_flag=True, help="Say what never happens in a check that passes.")
@click.option("--cluster", is_flag=True, help="Search with all processes that `mpiexec` has started (needs MPI).")
@click.option("--watch", is_flag=True, help="Check again what changes, until Ctrl-C.")
@manner_options
def command(**options: Any) -> None:
    """Check every assertion of every script.

    FILE is a CSPm script, a folder (the scripts below it), FILE:LINE (the assertion on that line), or `-` for
    standard input.
    """
    from cspcheck.selection import targets

    if options["cluster"]:
        finish(_checked_together(options, targets(options["files"])))
    if not options["watch"]:
        finish(_check(options, targets(options["files"])))
    finish(_watch(options))


def _checked_together(options: dict[str, Any], goals: Sequence[Target | EmptyFolder]) -> int:
    """Check with all processes that were started; the exit code, which the first one has."""
    from cspcheck.cli.cluster import together

    for option in ("spill", "watch"):
        if options[option]:
            raise click.UsageError(f"`--{option}` is for one process, `--cluster` for several: say which")
    code = 0
    with together() as first:
        if first:
            code = int(_check(options, goals))
    return code


def _check(options: dict[str, Any], goals: Sequence[Target | EmptyFolder]) -> Exit:
    from cspcheck.cli.session import Session
    from cspcheck.cli.streams import output_to
    from cspcheck.report import report
    from cspcheck.report.style import style_for
    from cspcheck.selection import AssertionPattern

    verbosity = options["verbose"] - options["quiet"]
    with output_to(options["output"]) as output:
        session = Session(
            replace(
                settings(options, definitions(options)),
                coverage=options["coverage"],
                machines=options["form"] == "html",
            ),
            report(options["form"], output.write, style_for(output.stream, options["color"]), verbosity),
            patterns=[AssertionPattern(text) for text in options["patterns"]],
            color=options["color"],
            verbosity=verbosity,
        )
        return session.check(goals)


def _watch(options: dict[str, Any]) -> Exit:
    """Check, and check again. A document or a file is written for all scripts, lines for those that have changed."""
    from cspcheck.cli.streams import Remarks
    from cspcheck.cli.watching import watch
    from cspcheck.selection import STDIN, targets

    if STDIN in options["files"]:
        raise click.UsageError("standard input cannot be watched: name a file")
    whole = options["output"] is not None or options["form"] not in ("full", "concise", "jsonl")
    remarks = Remarks()

    def check(changed: Sequence[Target | EmptyFolder]) -> Exit:
        return _check(options, targets(options["files"]) if whole else changed)

    def notify(line: str) -> None:
        if not options["quiet"]:
            remarks.write(f"{line}\n")

    return watch(lambda: targets(options["files"]), check, notify)
