"""``cspcheck typecheck FILE...``: read scripts and check names and types, nothing more."""

from __future__ import annotations

from typing import Any

import click

from cspcheck.cli import finish
from cspcheck.cli.options import (
    ConfiguredCommand,
    definitions,
    files_argument,
    manner_options,
    output_options,
    script_options,
)


@click.command(cls=ConfiguredCommand, short_help="Read scripts and check their names and types.")
@files_argument
@output_options
@script_options
@manner_options
def command(**options: Any) -> None:
    """Read scripts and check their names and types, without checking an assertion.

    FILE is a CSPm script, a folder (the scripts below it), or `-` for standard input.
    """
    from cspcheck.checking import Settings
    from cspcheck.cli.session import Session
    from cspcheck.cli.streams import output_to
    from cspcheck.report import scripts_report
    from cspcheck.report.style import style_for
    from cspcheck.selection import targets

    verbosity = options["verbose"] - options["quiet"]
    with output_to(options["output"]) as output:
        session = Session(
            Settings(definitions=definitions(options), include_roots=options["include_roots"]),
            scripts_report(options["form"], output.write, style_for(output.stream, options["color"]), verbosity),
            color=options["color"],
            verbosity=verbosity,
        )
        code = session.typecheck(targets(options["files"]))
    finish(code)
