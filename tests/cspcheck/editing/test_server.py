"""The language server as an editor sees it, over standard input and output."""

import asyncio
import sys
from pathlib import Path

from lsprotocol import types
from pygls.lsp.client import LanguageClient

TEXT = """\
channel a, b
P = a -> P
Q = b -> Q
assert P [| {a, b} |] Q :[deadlock free]
assert P :[deadlock free]
"""


class Client(LanguageClient):
    """An editor that keeps what it is told."""

    def __init__(self) -> None:
        super().__init__("test", "1")
        self.told: asyncio.Queue[list[types.Diagnostic]] = asyncio.Queue()

        @self.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def _told(params: types.PublishDiagnosticsParams) -> None:
            self.told.put_nowait(list(params.diagnostics))

        @self.feature(types.WINDOW_SHOW_MESSAGE)
        def _shown(params: types.ShowMessageParams) -> None:
            pass

        @self.feature(types.WORKSPACE_CODE_LENS_REFRESH)
        def _refreshed(params: None) -> None:
            pass


async def session(folder: Path) -> dict[str, object]:
    path = folder / "x.csp"
    path.write_text(TEXT)
    uri = path.as_uri()
    client = Client()
    found: dict[str, object] = {}
    await client.start_io(sys.executable, "-m", "cspcheck", "lsp")
    try:
        await client.initialize_async(types.InitializeParams(types.ClientCapabilities(), root_uri=folder.as_uri()))
        client.initialized(types.InitializedParams())
        item = types.TextDocumentItem(uri, "cspm", 1, TEXT)
        client.text_document_did_open(types.DidOpenTextDocumentParams(item))
        found["at first"] = await client.told.get()
        document = types.TextDocumentIdentifier(uri)
        lenses = await client.text_document_code_lens_async(types.CodeLensParams(document))
        found["lenses"] = [lens.command.title for lens in lenses or () if lens.command]
        commands = [lens.command for lens in lenses or () if lens.command]
        await client.workspace_execute_command_async(
            types.ExecuteCommandParams(commands[0].command, commands[0].arguments)
        )
        found["checked"] = await client.told.get()
        found["hover"] = await client.text_document_hover_async(types.HoverParams(document, types.Position(3, 1)))
        found["probe"] = await client.workspace_execute_command_async(
            types.ExecuteCommandParams(commands[1].command, commands[1].arguments)
        )
        change = types.TextDocumentContentChangePartial(types.Range(types.Position(1, 4), types.Position(1, 5)), "aa")
        client.text_document_did_change(
            types.DidChangeTextDocumentParams(types.VersionedTextDocumentIdentifier(2, uri), [change])
        )
        found["after"] = await client.told.get()
        await client.shutdown_async(None)
        client.exit(None)
    finally:
        await client.stop()
    return found


def test_a_session(tmp_path: Path) -> None:
    found = asyncio.run(session(tmp_path))
    assert found["at first"] == []
    assert found["lenses"] == ["Check", "Probe", "Check", "Probe"]
    (failed,) = found["checked"]  # type: ignore[misc]
    assert failed.message == "P [| {a, b} |] Q :[deadlock free]: fail (deadlock after <>)"
    assert failed.range.start.line == 3
    assert [i.message for i in failed.related_information] == [
        "P is a -> P, waits for Q",
        "Q is b -> Q, waits for P",
    ]
    assert "**fail**" in found["hover"].contents.value  # type: ignore[attr-defined]
    assert found["probe"] == f"cspcheck probe --at {tmp_path}/x.csp:4"
    assert [d.code for d in found["after"]] == ["CSP201", "fail"]  # type: ignore[attr-defined]
