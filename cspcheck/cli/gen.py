"""``cspcheck gen FILE -o FOLDER``: a program of tasks and channels from a script."""

from __future__ import annotations

from shlex import quote
from typing import Any

import click

from cspcheck.cli import finish
from cspcheck.cli.options import script_options

QUEUED = 4
"""How long a queue is if nothing else is said."""
MOST_QUEUED = 255


def _queue(text: str) -> tuple[str, int]:
    """A channel and the length of its queue."""
    channel, equals, length = text.partition("=")
    if equals and not (length.isascii() and length.isdigit() and 0 < int(length) <= MOST_QUEUED):
        raise click.BadParameter(
            f"the length of the queue of `{channel}` is a number from 1 to {MOST_QUEUED}, not `{length}`",
            param_hint="--queue",
        )
    return channel.strip(), int(length) if equals else QUEUED


@click.command(short_help="Generate a program of tasks and channels.")
@click.argument("file", type=click.Path(allow_dash=True))
@click.option("-o", "--output", required=True, metavar="FOLDER", help="Where the program goes.")
@click.option("--process", metavar="NAME", help="The process to generate, if the script leaves a choice.")
@click.option(
    "--target",
    type=click.Choice(["python", "freertos", "ada"]),
    default="python",
    show_default=True,
    help="A Python package, C for FreeRTOS, or Ada under the Ravenscar profile.",
)
@click.option(
    "--internal-choice",
    type=click.Choice(["refuse", "policy"]),
    default="refuse",
    show_default=True,
    help="What becomes of `|~|`: not generated, or decided by the program's policy when it runs.",
)
@click.option(
    "--queue",
    "queues",
    multiple=True,
    metavar="CHANNEL[=LENGTH]",
    help="Make a channel a queue of LENGTH values (4), if that is shown to refine the process (for FreeRTOS).",
)
@click.option("--need", metavar="PROCESS", help="What the process with queues must refine.  [default: itself]")
@click.option("--force", is_flag=True, help="Replace generated files that were edited; they stay as NAME.edited.")
@script_options
@click.option("--color", type=click.Choice(["auto", "always", "never"]), default="auto", help="Colour of messages.")
def command(**options: Any) -> None:
    """Generate a program of tasks and channels, in Python, C or Ada, that runs as it is.

    FILE is a script; what is composed in parallel in it becomes tasks. Generated files are written anew each time; the
    files that end in `_methods.py`, `methods.c` or `methods.adb` are yours and are written once. Exit code 1 says that
    one of these does not fit the specification any more.
    """
    from cspcheck.buffering import queued
    from cspcheck.checker.semantics.transitions import Semantics
    from cspcheck.checking import Settings, load
    from cspcheck.cli.streams import Remarks, StandardOutput
    from cspcheck.codegen.design.candidates import candidates
    from cspcheck.codegen.design.program import design
    from cspcheck.codegen.design.system import system
    from cspcheck.codegen.emit import ada, freertos
    from cspcheck.codegen.emit.keeping import orphans, write
    from cspcheck.codegen.emit.project import project
    from cspcheck.codegen.messages import no_process
    from cspcheck.cspm.diagnostics import ScriptError
    from cspcheck.messages import cannot_write
    from cspcheck.report.diagnostics import render_diagnostics
    from cspcheck.report.style import style_for
    from cspcheck.result import Exit

    if options["queues"] and options["target"] != "freertos":
        raise click.BadOptionUsage("queues", "--queue is for --target freertos")
    if options["need"] and not options["queues"]:
        raise click.BadOptionUsage("need", "--need is for --queue")
    remarks = Remarks()
    say = StandardOutput().write
    try:
        settings = Settings(definitions=dict(options["definitions"]), include_roots=options["include_roots"])
        script = load(options["file"], settings)
        name = options["process"]
        if name is None:
            found = candidates(script)
            if len(found) != 1:
                raise ScriptError(no_process(found))
            (name,) = found
        if options["target"] == "freertos":
            made = system(script, name, Semantics(), options["internal_choice"])
            buffers = queued(made, script, [_queue(text) for text in options["queues"]], options["need"])
            texts = freertos.project(made, options["output"], buffers)
        elif options["target"] == "ada":
            made = system(script, name, Semantics(), options["internal_choice"])
            texts = ada.project(made, options["output"], script)
        else:
            texts = project(design(script, name, options["internal_choice"], Semantics()), options["output"])
        try:
            result = write(texts, options["output"], force=options["force"])
        except OSError as error:
            raise ScriptError(cannot_write(options["output"], error.strerror or str(error))) from None
    except ScriptError as error:
        remarks.write(render_diagnostics(error.diagnostics, style_for(remarks.stream, options["color"])))
        finish(Exit.NOT_RUN)
    remarks.write(render_diagnostics(result.warnings, style_for(remarks.stream, options["color"])))
    for what, names in (("wrote", result.written), ("removed", result.removed), ("saved as", result.saved)):
        if names:
            say(f"{what} {', '.join(sorted(names))}\n")
    if result.kept:
        say(f"yours, not touched: {', '.join(sorted(result.kept))}\n")
    for left in orphans(texts, options["output"]):
        say(f"yours, and no task uses it any more: {left}\n")
    folder = options["output"].rstrip("/")
    how = f"make -C {quote(folder)} host" if options["target"] != "python" else f"python {quote(f'{folder}/main.py')}"
    say(f"run it with: {how}\n")
    finish(Exit.FAILED if result.warnings else Exit.OK)
