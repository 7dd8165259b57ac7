"""``cspcheck latex FILE``: a script as a LaTeX document, or a document as a script."""

from __future__ import annotations

from typing import Any

import click

from cspcheck.cli import finish
from cspcheck.cli.options import output_option


@click.command(short_help="Write classes as LaTeX, or LaTeX as text.")
@click.argument("file", metavar="FILE", type=click.Path(allow_dash=True))
@output_option
@click.option("--text", is_flag=True, help="Write the text notation instead.")
@click.option("--symbols", is_flag=True, help="With --text: write mathematical symbols instead of ASCII.")
@click.option("--color", type=click.Choice(["auto", "always", "never"]), default="auto", help="Colour of errors.")
def command(file: str, output: str | None, text: bool, symbols: bool, color: Any) -> None:
    """Write the classes and other Object-Z paragraphs of a script in the markup of oz.sty, its CSPm as it is.

    FILE is a script, a LaTeX document with classes (which comes out tidied), or `-` for standard input.
    """
    from cspcheck.checking import read
    from cspcheck.cli.streams import Remarks, output_to
    from cspcheck.cspm.diagnostics import ScriptError
    from cspcheck.cspm.oz.writing.latex_writer import write_latex
    from cspcheck.cspm.parsing.reading import parse_alone
    from cspcheck.cspm.printing.printer import print_script
    from cspcheck.report.diagnostics import render_diagnostics
    from cspcheck.report.style import style_for
    from cspcheck.result import Exit

    remarks = Remarks()
    code = Exit.OK
    try:
        script = parse_alone(read(file))
        if script.remarks:
            remarks.write(render_diagnostics(script.remarks, style_for(remarks.stream, color)))
        with output_to(output) as out:
            out.write(print_script(script, symbols=symbols) if text else write_latex(script))
    except ScriptError as error:
        remarks.write(render_diagnostics(error.diagnostics, style_for(remarks.stream, color)))
        code = Exit.NOT_RUN
    finish(code)
