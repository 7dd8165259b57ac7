"""``cspcheck graph FILE PROCESS``: pictures of machines, architectures and counterexamples."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import click

from cspcheck.cli import finish
from cspcheck.cli.options import ConfiguredCommand, defined_names, definitions, script_options
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.messages import no_counterexample, unknown_picture_format

if TYPE_CHECKING:
    from cspcheck.checking import Settings
    from cspcheck.cspm.script import Script
    from cspcheck.drawing.picture import Picture

MOST_STATES = 300
FORMATS = (".svg", ".html", ".dot")


@click.command(cls=ConfiguredCommand, short_help="Draw a machine, an architecture or a counterexample.")
@click.argument("file", metavar="FILE", type=click.Path(allow_dash=True))
@click.argument("process", metavar="PROCESS", shell_complete=defined_names)
@click.option(
    "-o", "--output", metavar="FILE", type=click.Path(), help="x.svg, x.html or x.dot [default: SVG to stdout]."
)
@click.option("--architecture", is_flag=True, help="Draw the components and the channels between them.")
@click.option("--trace", is_flag=True, help="PROCESS is an assertion: draw its counterexample as a sequence chart.")
@click.option(
    "--max-states",
    "most_states",
    type=click.IntRange(1),
    default=MOST_STATES,
    show_default=True,
    help="Draw no machine larger than this.",
)
@script_options
def command(**options: Any) -> None:
    """Draw the machine of PROCESS, any process expression of the script FILE.

    With --architecture its components and their channels; with --trace the counterexample of the assertion PROCESS.
    """
    from cspcheck import checking
    from cspcheck.cli.streams import output_to
    from cspcheck.drawing import parts

    output: str | None = options["output"]
    suffix = ".svg" if output in (None, "-") else os.path.splitext(str(output))[1].lower()
    if suffix not in FORMATS:
        raise ScriptError(unknown_picture_format(str(output)))
    settings = checking.Settings(definitions=definitions(options), include_roots=options["include_roots"])
    script = checking.load(options["file"], settings)
    if options["trace"]:
        text = _chart(script, settings, options["process"], suffix)
    elif options["architecture"]:
        shown = options["process"]
        text = _rendered(parts.architecture(shown, script.process(shown), script.events), suffix)
    else:
        shown = options["process"]
        picture = parts.machine(shown, script.process(shown), script.events, options["most_states"])
        text = _rendered(picture, suffix)
    with output_to(output) as stream:
        stream.write(text)
    finish(0)


def _rendered(picture: Picture, suffix: str) -> str:
    from cspcheck.drawing import dot, html, svg

    if suffix == ".dot":
        return dot.render(picture)
    drawn = svg.render(picture)
    return html.page(picture.title, drawn) if suffix == ".html" else drawn


def _chart(script: Script, settings: Settings, text: str, suffix: str) -> str:
    from cspcheck import checking
    from cspcheck.drawing import html, sequence

    assertion = script.assertion(text)
    result = checking.check(checking.checker_for(script, settings, checking.NoWatch()), assertion)
    if result.counterexample is None:
        raise ScriptError(no_counterexample(assertion.text, str(result.verdict)))
    if suffix == ".dot":
        raise ScriptError(unknown_picture_format("a sequence chart in DOT"))
    chart = sequence.render(assertion.text, result.counterexample)
    return html.page(assertion.text, chart) if suffix == ".html" else chart
