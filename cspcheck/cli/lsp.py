"""``cspcheck lsp``: the language server for editors."""

from __future__ import annotations

import click


@click.command(short_help="Serve an editor: diagnostics, navigation, checks (LSP).")
@click.option("--port", type=click.IntRange(1, 65535), metavar="N", help="Listen there, on this machine alone.")
@click.option("--stdio", is_flag=True, help="Standard input and output, which is what is used if nothing is said.")
def command(port: int | None, stdio: bool) -> None:
    """Serve an editor by the Language Server Protocol.

    Needs the extra `lsp`: pip install 'cspcheck[lsp]'.
    """
    from cspcheck.cspm.diagnostics import ScriptError
    from cspcheck.messages import missing_extra

    try:
        import pygls  # noqa: F401
    except ImportError:
        raise ScriptError(missing_extra("lsp", "pygls")) from None
    from cspcheck.editing.server import serve

    serve(port)
