"""``cspcheck cspm FILE``: a script as plain CSPm."""

from __future__ import annotations

from typing import Any

import click

from cspcheck.cli import finish
from cspcheck.cli.options import class_options, output_option, script_options


@click.command(short_help="Write a script as plain CSPm, for FDR.")
@click.argument("file", metavar="FILE", type=click.Path(allow_dash=True))
@output_option
@script_options
@class_options
@click.option("--color", type=click.Choice(["auto", "always", "never"]), default="auto", help="Colour of errors.")
def command(**options: Any) -> None:
    """Write a script as plain CSPm, in one file: the data of a class becomes a process with its state variables for
    parameters.

    What the assertions use is written, with the same verdicts, and the same states up to strong bisimulation.
    Assertions about the data of classes (`C :[obligations]`, `A [OZ= C via R`) are left out with a warning.
    Assertions about values (`assert 1 == 1`), which FDR does not read, become assertions about processes.
    """
    from cspcheck.checking import Settings, load
    from cspcheck.cli.streams import Remarks, output_to
    from cspcheck.cspm.diagnostics import ScriptError
    from cspcheck.exporting import plain_text
    from cspcheck.report.diagnostics import render_diagnostics
    from cspcheck.report.style import style_for
    from cspcheck.result import Exit

    settings = Settings(
        definitions=dict(options["definitions"]),
        view=options["view"],
        outputs=options["outputs"],
        include_roots=options["include_roots"],
    )
    try:
        exported = plain_text(load(options["file"], settings))
    except ScriptError as error:
        remarks = Remarks()
        remarks.write(render_diagnostics(error.diagnostics, style_for(remarks.stream, options["color"])))
        finish(Exit.NOT_RUN)
    if exported.warnings:
        remarks = Remarks()
        remarks.write(render_diagnostics(exported.warnings, style_for(remarks.stream, options["color"])))
    with output_to(options["output"]) as output:
        output.write(exported.text)
    finish(Exit.OK)
