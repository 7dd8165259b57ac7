"""The language server as an editor sees it, over standard input and output.

The client is that of pygls: the plugin of pytest-lsp lets no item of another plugin run, and the assertions of scripts
are such items.
"""

from __future__ import annotations

import asyncio
import json
import signal
import subprocess
import sys
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from lsprotocol import types
from pygls.lsp.client import LanguageClient

TEXT = """\
channel a, b
P = a -> P
Q = b->Q
assert P [| {a, b} |] Q :[deadlock free]
assert P :[deadlock free]
"""
CLASS = r"""\documentclass{article}
\begin{document}
A counter, which counts.
\begin{class}{Counter}
\chan count : [ n! : 0 \upto 1 ]
\end{class}
\end{document}
"""


class Client(LanguageClient):
    """An editor that keeps what it is told."""

    def __init__(self) -> None:
        super().__init__("test", "1")
        self.diagnostics: dict[str, list[types.Diagnostic]] = {}
        self._fresh: set[str] = set()
        self._told = asyncio.Event()

        @self.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def _published(params: types.PublishDiagnosticsParams) -> None:
            self.diagnostics[params.uri] = list(params.diagnostics)
            self._fresh.add(params.uri)
            self._told.set()

        @self.feature(types.WINDOW_SHOW_MESSAGE)
        def _shown(params: types.ShowMessageParams) -> None:
            pass

        @self.feature(types.WORKSPACE_CODE_LENS_REFRESH)
        def _refreshed(params: None) -> None:
            pass

    async def told(self, about: str) -> None:
        """Wait until mistakes in a text have been told, and forget that, for the next time."""
        while about not in self._fresh:
            await self._told.wait()
            self._told.clear()
        self._fresh.discard(about)


@asynccontextmanager
async def editor(folder: Path) -> AsyncIterator[Client]:
    """An editor that has opened *folder*."""
    client = Client()
    await client.start_io(sys.executable, "-m", "cspcheck", "lsp")
    try:
        await client.initialize_async(types.InitializeParams(types.ClientCapabilities(), root_uri=folder.as_uri()))
        client.initialized(types.InitializedParams())
        yield client
    finally:
        await client.shutdown_async(None)
        client.exit(None)
        await client.stop()


async def opened(client: Client, path: Path, text: str, language: str) -> types.TextDocumentIdentifier:
    """A file that the editor shows, once its mistakes are told."""
    path.write_text(text, encoding="utf-8")
    item = types.TextDocumentItem(path.as_uri(), language, 1, text)
    client.text_document_did_open(types.DidOpenTextDocumentParams(item))
    await client.told(item.uri)
    return types.TextDocumentIdentifier(item.uri)


def found(client: Client, document: types.TextDocumentIdentifier) -> list[types.Diagnostic]:
    return client.diagnostics[document.uri]


def in_an_editor(work: Callable[[Client, Path], Coroutine[None, None, None]]) -> Callable[[Path], None]:
    """The work of an editor as a test."""

    def test(tmp_path: Path) -> None:
        async def session() -> None:
            async with editor(tmp_path) as client:
                await work(client, tmp_path)

        asyncio.run(session())

    return test


@in_an_editor
async def test_a_script(client: Client, tmp_path: Path) -> None:
    document = await opened(client, tmp_path / "x.csp", TEXT, "cspm")
    assert found(client, document) == []

    lenses = await client.text_document_code_lens_async(types.CodeLensParams(document)) or []
    commands = [lens.command for lens in lenses if lens.command is not None]
    assert [command.title for command in commands] == ["Check", "Probe", "Check", "Probe"]
    for command in commands[:2]:
        answer = await client.workspace_execute_command_async(
            types.ExecuteCommandParams(command.command, command.arguments)
        )
    assert answer == f"cspcheck probe --at {tmp_path}/x.csp:4"
    await client.told(document.uri)
    (failed,) = found(client, document)
    assert failed.message == "P [| {a, b} |] Q :[deadlock free]: fail (deadlock after <>)"
    assert failed.range.start.line == 3
    related = [(told.location.range.start.line, told.message) for told in failed.related_information or ()]
    assert related == [(1, "P is a -> P, waits for Q"), (2, "Q is b -> Q, waits for P")]

    hover = await client.text_document_hover_async(types.HoverParams(document, types.Position(3, 1)))
    assert hover is not None
    assert isinstance(hover.contents, types.MarkupContent)
    assert "**fail**" in hover.contents.value
    place = types.Position(4, 7)
    definition = await client.text_document_definition_async(types.DefinitionParams(document, place))
    assert isinstance(definition, list)
    assert [at.range.start.line for at in definition if isinstance(at, types.Location)] == [1]
    asked = types.ReferenceParams(types.ReferenceContext(include_declaration=True), document, place)
    references = await client.text_document_references_async(asked) or []
    assert sorted(at.range.start.line for at in references) == [1, 1, 3, 4]
    renamed = await client.text_document_rename_async(types.RenameParams(document, place, "R"))
    assert renamed is not None
    assert [len(edits) for edits in (renamed.changes or {}).values()] == [4]
    symbols = await client.text_document_document_symbol_async(types.DocumentSymbolParams(document)) or []
    assert {"a", "P", "Q"} <= {symbol.name for symbol in symbols}
    completed = await client.text_document_completion_async(types.CompletionParams(document, types.Position(1, 9)))
    assert isinstance(completed, list)
    assert {"P", "Q", "STOP"} <= {item.label for item in completed}
    options = types.FormattingOptions(tab_size=2, insert_spaces=True)
    edits = await client.text_document_formatting_async(types.DocumentFormattingParams(document, options)) or []
    assert [(edit.range.start.line, edit.new_text) for edit in edits] == [(2, "Q = b -> Q\n")]

    change = types.TextDocumentContentChangePartial(types.Range(types.Position(1, 4), types.Position(1, 5)), "aa")
    client.text_document_did_change(
        types.DidChangeTextDocumentParams(types.VersionedTextDocumentIdentifier(2, document.uri), [change])
    )
    await client.told(document.uri)
    assert [told.code for told in found(client, document)] == ["CSP201", "fail"]


@in_an_editor
async def test_documents(client: Client, tmp_path: Path) -> None:
    document = await opened(client, tmp_path / "x.tex", CLASS, "latex")
    assert [told.code for told in found(client, document)] == []
    symbols = await client.text_document_document_symbol_async(types.DocumentSymbolParams(document)) or []
    assert [symbol.name for symbol in symbols] == ["Counter"]

    letter = await opened(client, tmp_path / "y.tex", "\\documentclass{letter}\n", "latex")
    assert found(client, letter) == []


def told(method: str, number: int | None = None, **params: object) -> bytes:
    """A message to a server, as it goes over the line."""
    message = {"jsonrpc": "2.0", "method": method, **({} if number is None else {"id": number, "params": params})}
    text = json.dumps(message).encode()
    return b"Content-Length: %d\r\n\r\n%s" % (len(text), text)


@pytest.mark.parametrize(("end", "code"), [("exit", 0), ("closed", 0), ("terminated", 130)])
def test_its_end(end: str, code: int) -> None:
    server = subprocess.Popen(
        [sys.executable, "-m", "cspcheck", "lsp"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert server.stdin is not None
    assert server.stdout is not None
    server.stdin.write(told("initialize", 1, capabilities={}, processId=None, rootUri=None))
    server.stdin.flush()
    assert server.stdout.readline().startswith(b"Content-Length")
    if end == "exit":
        server.stdin.write(told("shutdown", 2) + told("exit"))
        server.stdin.flush()
    elif end == "terminated":
        server.send_signal(signal.SIGTERM)
    _, said = server.communicate(timeout=60)
    assert (server.returncode, said) == (code, b"")
