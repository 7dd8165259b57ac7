"""The language server: keeps the texts of the editor analysed, answers from that, and checks assertions on demand.

An assertion is checked by the command itself, in a process of its own: it may take long or much memory, and can be
stopped. What is checked is the file as saved.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import os
import shlex
import signal
import sys
from contextlib import redirect_stdout
from types import FrameType
from typing import Any

from lsprotocol import types
from pygls.exceptions import JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer

from cspcheck import __version__
from cspcheck.cspm.source import Source
from cspcheck.editing import answers
from cspcheck.editing.analysis import Analysis, analyse
from cspcheck.editing.places import path_of, range_of, uri_of
from cspcheck.result import Exit

PAUSE = 0.15
"""Seconds without a key before a text is analysed."""


class EditorServer(LanguageServer):
    """The server of one editor.

    Attributes:
        verdicts: by file and assertion, what the last check said.
    """

    def __init__(self) -> None:
        super().__init__("cspcheck", __version__)
        self._analyses: dict[str, tuple[int | None, str, Analysis]] = {}
        self._last: dict[str, Analysis] = {}
        self._waiting: dict[str, asyncio.Task[None]] = {}
        self._checked: dict[str, dict[str, types.Diagnostic]] = {}
        self._told: dict[str, set[str]] = {}
        self._running: dict[tuple[str, int], asyncio.subprocess.Process] = {}
        self.verdicts: dict[str, dict[str, str]] = {}

    def opened(self, path: str) -> str | None:
        """The text of a file that is open."""
        uri = uri_of(path)
        document = self.workspace.text_documents.get(uri)
        return None if document is None else document.source.replace("\r\n", "\n").replace("\r", "\n")

    def analysis(self, uri: str) -> Analysis:
        """What is known of the text as it is now."""
        document = self.workspace.get_text_document(uri)
        text = document.source.replace("\r\n", "\n").replace("\r", "\n")
        known = self._analyses.get(uri)
        if known is None or known[0] != document.version or known[1] != text:
            found = analyse(path_of(uri), text, self.opened)
            self._analyses[uri] = known = (document.version, text, found)
            if found.names is not None:
                self._last[uri] = found
        return known[2]

    def last(self, uri: str) -> Analysis | None:
        """The newest analysis in which names were known."""
        return self._last.get(uri)

    # --- diagnostics -----------------------------------------------------------------------------------------

    def changed(self, uri: str, pause: float = PAUSE) -> None:
        """Analyse a text once nothing has been typed for a while."""
        waiting = self._waiting.pop(uri, None)
        if waiting is not None:
            waiting.cancel()
        self._waiting[uri] = asyncio.ensure_future(self._after(uri, pause))

    async def _after(self, uri: str, pause: float) -> None:
        await asyncio.sleep(pause)
        self.publish(uri)

    def publish(self, uri: str) -> None:
        """Tell what is wrong with a text and with what it includes, and what checks of it have found."""
        found = self.analysis(uri)
        told = answers.diagnostics(found)
        texts = {claim.text for claim in found.claims}
        checked = self._checked.get(uri, {})
        for text in [text for text in checked if text not in texts]:
            del checked[text]
        for claim in found.claims:
            if claim.text in checked:
                checked[claim.text].range = range_of(claim.span)
        told[uri] = [*told.get(uri, []), *checked.values()]
        for other in self._told.get(uri, set()) - set(told):
            self._send(other, [])
        self._told[uri] = set(told)
        for other, items in told.items():
            if other == uri or other not in self.workspace.text_documents:
                self._send(other, items)

    def closed(self, uri: str) -> None:
        """Forget a text."""
        for other in self._told.pop(uri, set()):
            self._send(other, [])
        for known in (self._analyses, self._last, self._checked, self.verdicts):
            known.pop(uri, None)

    def _send(self, uri: str, items: list[types.Diagnostic]) -> None:
        self.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, items))

    # --- checking --------------------------------------------------------------------------------------------

    def stop_checks(self) -> None:
        """End the checks that run."""
        for running in self._running.values():
            with contextlib.suppress(ProcessLookupError):
                running.terminate()
        self._running.clear()

    async def check(self, uri: str, line: int | None) -> dict[str, Any] | None:
        """Check the assertion on a line, or all, with the command; the document that it writes."""
        key = (uri, line or 0)
        running = self._running.pop(key, None)
        if running is not None:
            with contextlib.suppress(ProcessLookupError):
                running.terminate()
        path = path_of(uri)
        where = path if line is None else f"{path}:{line}"
        process = await asyncio.create_subprocess_exec(
            sys.executable,
            "-m",
            "cspcheck",
            "check",
            where,
            "--format",
            "json",
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.DEVNULL,
        )
        self._running[key] = process
        output, _ = await process.communicate()
        if self._running.get(key) is process:
            del self._running[key]
        try:
            document: dict[str, Any] = json.loads(output)
        except ValueError:
            return None
        for result in document["results"]:
            self._take(uri, result)
        self.publish(uri)
        with contextlib.suppress(Exception):  # an editor that has no lenses
            self.workspace_code_lens_refresh(None)
        return document

    def _take(self, uri: str, result: dict[str, Any]) -> None:
        text = result["assertion"]
        as_expected = result["verdict"] == result["expected"]
        said = f"**{result['verdict']}**" + (" (as expected)" if as_expected and result["verdict"] != "pass" else "")
        if result["states"]:
            said += f", {result['states']:,} states"
        said += f", {result['seconds']:.2f} s"
        self.verdicts.setdefault(uri, {})[text] = said
        checked = self._checked.setdefault(uri, {})
        checked.pop(text, None)
        if as_expected:
            return
        message = f"{text}: {result['verdict']}" + (f": {result['reason']}" if result["reason"] else "")
        found = result["counterexample"]
        related: list[types.DiagnosticRelatedInformation] = []
        if found is not None:
            trace = [cause or event for event, cause in zip(found["trace"], found["causes"], strict=True)]
            message += f" ({found['kind']} after <{', '.join(trace)}{_last(found)}>)"
            related = _related(self.analysis(uri).source, found)
        start = types.Position(max(0, result["line"] - 1), 0)
        checked[text] = types.Diagnostic(
            types.Range(start, types.Position(start.line, 1_000)),
            message,
            severity=types.DiagnosticSeverity.Error
            if result["verdict"] in ("fail", "error", "pass")
            else types.DiagnosticSeverity.Warning,
            source="cspcheck",
            code=result["verdict"],
            related_information=related,
        )


def _last(counterexample: dict[str, Any]) -> str:
    event = counterexample["event"]
    if event is None or counterexample["kind"] != "trace":
        return ""
    return f"{', ' if counterexample['trace'] else ''}{event}"


def _related(source: Source, counterexample: dict[str, Any]) -> list[types.DiagnosticRelatedInformation]:
    """What each component is at the end, at its definition."""
    related = []
    for component in counterexample["components"]:
        if not component["line"]:
            continue
        line = component["line"] - 1
        width = len(source.line_text(component["line"]))
        said = f"{component['name']} is {component['state'] or 'terminated'}"
        if component["waiting_for"]:
            said += f", waits for {', '.join(component['waiting_for'])}"
        where = types.Location(uri_of(source.name), types.Range(types.Position(line, 0), types.Position(line, width)))
        related.append(types.DiagnosticRelatedInformation(where, said))
    return related


server = EditorServer()


@server.feature(types.TEXT_DOCUMENT_DID_OPEN)
def _open(ls: EditorServer, params: types.DidOpenTextDocumentParams) -> None:
    ls.publish(params.text_document.uri)


@server.feature(types.TEXT_DOCUMENT_DID_CHANGE)
async def _change(ls: EditorServer, params: types.DidChangeTextDocumentParams) -> None:
    ls.changed(params.text_document.uri)


@server.feature(types.TEXT_DOCUMENT_DID_SAVE)
async def _save(ls: EditorServer, params: types.DidSaveTextDocumentParams) -> None:
    for uri in list(ls.workspace.text_documents):
        ls.changed(uri, 0)


@server.feature(types.TEXT_DOCUMENT_DID_CLOSE)
def _close(ls: EditorServer, params: types.DidCloseTextDocumentParams) -> None:
    ls.closed(params.text_document.uri)


@server.feature(types.TEXT_DOCUMENT_HOVER)
def _hover(ls: EditorServer, params: types.HoverParams) -> types.Hover | None:
    uri = params.text_document.uri
    return answers.hover(ls.analysis(uri), params.position, ls.verdicts.get(uri, {}))


@server.feature(types.TEXT_DOCUMENT_DEFINITION)
def _definition(ls: EditorServer, params: types.DefinitionParams) -> list[types.Location]:
    return answers.definitions(ls.analysis(params.text_document.uri), params.position)


@server.feature(types.TEXT_DOCUMENT_REFERENCES)
def _references(ls: EditorServer, params: types.ReferenceParams) -> list[types.Location]:
    found = ls.analysis(params.text_document.uri)
    return answers.references(found, params.position, declarations=params.context.include_declaration)


@server.feature(types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT)
def _highlight(ls: EditorServer, params: types.DocumentHighlightParams) -> list[types.DocumentHighlight]:
    uri = params.text_document.uri
    found = answers.references(ls.analysis(uri), params.position)
    return [types.DocumentHighlight(place.range) for place in found if place.uri == uri_of(path_of(uri))]


@server.feature(types.TEXT_DOCUMENT_PREPARE_RENAME)
def _prepare_rename(ls: EditorServer, params: types.PrepareRenameParams) -> types.Range | None:
    try:
        return answers.renameable(ls.analysis(params.text_document.uri), params.position)
    except answers.CannotRename:
        return None


@server.feature(types.TEXT_DOCUMENT_RENAME, types.RenameOptions(prepare_provider=True))
def _rename(ls: EditorServer, params: types.RenameParams) -> types.WorkspaceEdit:
    found = ls.analysis(params.text_document.uri)
    try:
        return types.WorkspaceEdit(changes=answers.renamed(found, params.position, params.new_name, ls.opened))
    except answers.CannotRename as error:
        raise JsonRpcInvalidParams(str(error)) from None


@server.feature(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
def _symbols(ls: EditorServer, params: types.DocumentSymbolParams) -> list[types.DocumentSymbol]:
    return answers.symbols(ls.analysis(params.text_document.uri))


@server.feature(types.TEXT_DOCUMENT_COMPLETION, types.CompletionOptions(trigger_characters=[":", "["]))
def _completion(ls: EditorServer, params: types.CompletionParams) -> list[types.CompletionItem]:
    uri = params.text_document.uri
    text = ls.workspace.get_text_document(uri).source
    return answers.completions(ls.analysis(uri), text, params.position, ls.last(uri))


@server.feature(types.TEXT_DOCUMENT_FORMATTING)
def _formatting(ls: EditorServer, params: types.DocumentFormattingParams) -> list[types.TextEdit]:
    return answers.formatted(ls.analysis(params.text_document.uri).source)


@server.feature(types.TEXT_DOCUMENT_CODE_LENS)
def _lenses(ls: EditorServer, params: types.CodeLensParams) -> list[types.CodeLens]:
    return answers.lenses(ls.analysis(params.text_document.uri))


@server.command("cspcheck.check")
async def _check(ls: EditorServer, uri: str, line: int | None = None) -> dict[str, Any] | None:
    document = await ls.check(uri, line)
    if document is None:
        ls.window_show_message(types.ShowMessageParams(types.MessageType.Error, "the check did not come to an end"))
        return None
    for result in document["results"]:
        kind = types.MessageType.Info if result["verdict"] == result["expected"] else types.MessageType.Warning
        ls.window_show_message(types.ShowMessageParams(kind, f"{result['assertion']}: {result['verdict']}"))
    return {"results": document["results"]}


@server.command("cspcheck.probe")
def _probe(ls: EditorServer, uri: str, line: int) -> str:
    """For editors without a terminal of their own: the command to be typed."""
    command = f"cspcheck probe --at {shlex.quote(f'{path_of(uri)}:{line}')}"
    ls.window_show_message(types.ShowMessageParams(types.MessageType.Info, command))
    return command


def serve(port: int | None = None) -> None:
    """Serve an editor over standard input and output, or the one that connects to *port* of this machine.

    Checks that still run end with it.
    """
    logging.getLogger("pygls").setLevel(logging.ERROR)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _leave)
    try:
        if port is not None:
            server.start_tcp("127.0.0.1", port)
            return
        # The streams of the protocol are closed in the end; and what is printed must not get into it.
        with open(os.dup(0), "rb") as requests, open(os.dup(1), "wb") as answered, redirect_stdout(sys.stderr):
            server.start_io(requests, answered)
    finally:
        server.stop_checks()


def _leave(number: int, frame: FrameType | None) -> None:
    """End at once: the thread that waits for the editor's next request cannot be interrupted."""
    server.stop_checks()
    os._exit(Exit.INTERRUPTED)
