"""``cspcheck sweep FILE... -D N=2..8``: check scripts for several values of their constants."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

import click

from cspcheck.cli import finish
from cspcheck.cli.options import (
    ConfiguredCommand,
    DefineOption,
    assert_option,
    configured_definitions,
    files_argument,
    include_root_option,
    limit_options,
    manner_options,
    output_option,
    settings,
)

FORMATS = ("table", "json", "csv")


@click.command(cls=ConfiguredCommand, short_help="Check scripts for several values of their constants.")
@files_argument
@click.option(
    "-D",
    "definitions",
    type=DefineOption(),
    multiple=True,
    metavar="NAME=VALUES",
    help="The values of a constant: 2..8, or 2,4,8; several -D are combined.",
)
@click.option("--format", "form", type=click.Choice(FORMATS), default="table", show_default=True, help="Output form.")
@output_option
@assert_option
@include_root_option
@limit_options
@manner_options
def command(**options: Any) -> None:
    """Check every assertion of the scripts for each combination of the values, and tell the verdicts side by side.

    FILE is what it is for `check`. The exit code is the worst of all.
    """
    from cspcheck import __version__
    from cspcheck.cli.session import Session
    from cspcheck.cli.streams import Remarks, output_to
    from cspcheck.cspm.diagnostics import ScriptError
    from cspcheck.messages import nothing_to_sweep
    from cspcheck.report.diagnostics import render_diagnostics
    from cspcheck.report.style import style_for
    from cspcheck.report.sweep import Collected, comma_separated, document, table
    from cspcheck.result import Exit, worst
    from cspcheck.selection import AssertionPattern, targets
    from cspcheck.sweeping import Swept, combinations, parse_sweep, varying

    try:
        sweeps = [parse_sweep(name, text) for name, text in dict(options["definitions"]).items()]
    except ValueError as error:
        raise click.UsageError(str(error)) from None
    if not sweeps:
        raise ScriptError(nothing_to_sweep())
    base = settings(options, configured_definitions())
    verbosity = options["verbose"] - options["quiet"]
    names = varying(sweeps)
    chosen = targets(options["files"])
    done: list[Swept] = []
    codes: list[Exit] = []
    told: set[tuple[object, ...]] = set()
    remarks = Remarks()
    with output_to(options["output"]) as output:
        for values in combinations(sweeps):
            swept = Swept(values)
            where = ", ".join(f"{name}={values[name]}" for name in names)
            session = Session(
                replace(base, definitions={**base.definitions, **values}),
                Collected(swept),
                patterns=[AssertionPattern(text) for text in options["patterns"]],
                color=options["color"],
                verbosity=verbosity,
                label=where,
            )
            codes.append(session.check(chosen))
            done.append(swept)
            if options["form"] == "table":
                for diagnostic in swept.diagnostics:
                    # Scripts are read anew for each combination, and most of what is to be said is said each time.
                    span = diagnostic.span
                    key = (diagnostic.code, diagnostic.message, span and (span.source.name, span.start))
                    if key not in told:
                        told.add(key)
                        noted = diagnostic.with_notes(f"with {where}")
                        remarks.write(render_diagnostics([noted], style_for(sys.stderr, options["color"])))
            if codes[-1] is Exit.INTERRUPTED:
                break
        if options["form"] == "json":
            output.write(document(done, __version__, interrupted=codes[-1] is Exit.INTERRUPTED))
        elif options["form"] == "csv":
            output.write(comma_separated(done, names))
        else:
            output.write(table(done, names, style_for(output.stream, options["color"])))
    finish(worst(codes))
