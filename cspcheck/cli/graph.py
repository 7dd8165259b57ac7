"""``cspcheck graph FILE PROCESS``: pictures of machines, architectures and counterexamples."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import click

from cspcheck.cli import finish
from cspcheck.cli.options import ConfiguredCommand, defined_names, definitions, script_options
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.messages import no_counterexample, too_large_to_draw, unknown_picture_format

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

    output: str | None = options["output"]
    suffix = ".svg" if output in (None, "-") else os.path.splitext(str(output))[1].lower()
    if suffix not in FORMATS:
        raise ScriptError(unknown_picture_format(str(output)))
    settings = checking.Settings(definitions=definitions(options), include_roots=options["include_roots"])
    script = checking.load(options["file"], settings)
    if options["trace"]:
        text = _chart(script, settings, options["process"], suffix)
    elif options["architecture"]:
        text = _rendered(_architecture(script, options["process"]), suffix)
    else:
        text = _rendered(_machine(script, options["process"], options["most_states"]), suffix)
    with output_to(output) as stream:
        stream.write(text)
    finish(0)


def _rendered(picture: Picture, suffix: str) -> str:
    from cspcheck.drawing import dot, html, svg

    if suffix == ".dot":
        return dot.render(picture)
    drawn = svg.render(picture)
    return html.page(picture.title, drawn) if suffix == ".html" else drawn


def _machine(script: Script, text: str, most: int) -> Picture:
    from cspcheck.checker.semantics.transitions import LimitReached, explore
    from cspcheck.checker.verdict import Limits
    from cspcheck.cspm.process.text import describe
    from cspcheck.drawing.machines import machine_picture

    try:
        lts, terms = explore(script.process(text), Limits(states=most))
    except LimitReached:
        raise ScriptError(too_large_to_draw(text, most)) from None
    return machine_picture(text, lts, script.events, lambda state: describe(terms[state], script.events))


def _architecture(script: Script, text: str) -> Picture:
    from cspcheck.checker.budget import LimitReached
    from cspcheck.checker.network.compiler import Compiler
    from cspcheck.checker.verdict import Limits
    from cspcheck.drawing.machines import architecture_picture, without_priority

    process = script.process(text)
    try:
        network = Compiler().network(process, Limits(), lambda _: None)
        if len(network.slots) == 1:
            # What is one component to the engine need not be one to the reader.
            network = Compiler(slot_states=2).network(without_priority(process), Limits(), lambda _: None)
    except LimitReached as limit:
        raise ScriptError(limit.diagnostic) from None
    return architecture_picture(text, network, script.events)


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
