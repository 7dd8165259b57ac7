"""``cspcheck explore FILE [PROCESS]``: a script in the browser."""

from __future__ import annotations

import contextlib
import webbrowser
from typing import Any

import click

from cspcheck.cli import finish
from cspcheck.cli.options import (
    ConfiguredCommand,
    defined_names,
    definitions,
    limit_options,
    script_options,
    settings,
)


@click.command(cls=ConfiguredCommand, short_help="Explore a script in the browser.")
@click.argument("file", metavar="FILE", type=click.Path())
@click.argument("process", metavar="[PROCESS]", required=False, shell_complete=defined_names)
@click.option("--port", type=click.IntRange(0, 65535), default=0, metavar="N", help="Where to listen.  [default: free]")
@click.option("--browser/--no-browser", default=True, help="Whether a browser is opened.")
@script_options
@limit_options
def command(**options: Any) -> None:
    """Open a page on which processes are stepped through: what each component offers and who waits, the machine and the
    architecture beside each other, verdicts and counterexamples.

    The page is for this machine alone; its address has a token, and says where one is, so that it can be kept.
    """
    from cspcheck import checking
    from cspcheck.cli.streams import StandardOutput
    from cspcheck.exploring.model import Explorer
    from cspcheck.exploring.server import ExplorerServer

    used = settings(options, definitions(options))
    script = checking.load(options["file"], used)
    if options["process"] is not None:
        script.process(options["process"])
    server = ExplorerServer(Explorer(script, used, options["process"]), options["port"])
    StandardOutput().write(f"{server.address}\n(Ctrl-C ends it)\n")
    if options["browser"]:
        webbrowser.open(server.address)
    with contextlib.suppress(KeyboardInterrupt):
        server.serve_forever()
    server.server_close()
    finish(0)
