"""``cspcheck check FILE...``: check the assertions of scripts."""

from __future__ import annotations

from typing import Any

import click

from cspcheck.cli import finish
from cspcheck.cli.options import DURATION, SIZE, files_argument, manner_options, output_options, script_options


@click.command(short_help="Check the assertions of scripts (the default).")
@files_argument
@output_options
@click.option(
    "--assert",
    "patterns",
    multiple=True,
    metavar="PATTERN",
    help="Only the assertions whose text contains PATTERN; `*` stands for any characters, blanks do not count.",
)
@script_options
@click.option("--full", is_flag=True, help="Explore the whole state space: no reduction, no early stop, exact counts.")
@click.option("--timeout", type=DURATION, metavar="TIME", help="Give up an assertion after TIME (90s, 5m, 1h30m).")
@click.option(
    "--max-memory",
    type=SIZE,
    metavar="SIZE",
    help="Give up an assertion that needs more than SIZE (512MiB, 8GiB).  [default: 80% of the machine's memory]",
)
@click.option(
    "--max-states", type=click.IntRange(min=1), metavar="N", help="Give up an assertion with more than N states."
)
@click.option(
    "--workers", type=click.IntRange(min=1), metavar="N", help="Search threads.  [default: the machine's cores]"
)
@click.option("--no-typecheck", is_flag=True, help="Skip the type checker, for the odd script that only FDR2 accepted.")
@manner_options
def command(**options: Any) -> None:
    """Check every assertion of every script.

    FILE is a CSPm script, a folder (the scripts below it), FILE:LINE (the assertion on that line), or `-` for
    standard input.
    """
    from cspcheck.checking import Settings, limits
    from cspcheck.cli.session import Session
    from cspcheck.cli.streams import output_to
    from cspcheck.report import report
    from cspcheck.report.style import style_for
    from cspcheck.selection import Pattern, targets

    verbosity = options["verbose"] - options["quiet"]
    settings = Settings(
        limits=limits(options["max_states"], options["timeout"], options["max_memory"]),
        workers=options["workers"],
        full=options["full"],
        definitions=dict(options["definitions"]),
        typecheck=not options["no_typecheck"],
    )
    with output_to(options["output"]) as output:
        session = Session(
            settings,
            report(options["form"], output.write, style_for(output.stream, options["color"]), verbosity),
            patterns=[Pattern(text) for text in options["patterns"]],
            color=options["color"],
            verbosity=verbosity,
        )
        code = session.check(targets(options["files"]))
    finish(code)
