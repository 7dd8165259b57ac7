"""The explorer's own small web server: for this machine alone, and for who knows the token in the address."""

from __future__ import annotations

import json
import secrets
import sys
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from typing import Any
from urllib.parse import parse_qsl, urlsplit

from cspcheck.drawing.html import VIEW_SCRIPT, VIEW_STYLE
from cspcheck.exploring.model import Explorer, Unanswerable

HOST = "127.0.0.1"
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class ExplorerServer(ThreadingHTTPServer):
    """Serves one explorer.

    Attributes:
        token: without it nothing is answered.
    """

    daemon_threads = True

    def __init__(self, explorer: Explorer, port: int = 0, token: str | None = None) -> None:
        self.explorer = explorer
        self.token = token or secrets.token_urlsafe(16)
        super().__init__((HOST, port), _Handler)

    @property
    def port(self) -> int:
        """The port that it listens on."""
        return int(self.server_address[1])

    @property
    def address(self) -> str:
        """What to open in a browser."""
        return f"http://{HOST}:{self.port}/?token={self.token}"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that goes away before its answer has come is no mistake of anybody."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    server: ExplorerServer
    server_version = "cspcheck"
    sys_version = ""

    def do_GET(self) -> None:
        try:
            parts = urlsplit(self.path)
            arguments = dict(parse_qsl(parts.query))
        except ValueError:
            self._refuse(HTTPStatus.BAD_REQUEST, "there is no such address")
            return
        # A page of somebody else can make a browser ask here: by a name of its own for this address, or blindly.
        if self.headers.get("Host") not in (f"{HOST}:{self.server.port}", f"localhost:{self.server.port}"):
            self._refuse(HTTPStatus.FORBIDDEN, "this server is for this machine alone")
            return
        if not secrets.compare_digest(arguments.pop("token", "").encode(), self.server.token.encode()):
            self._refuse(HTTPStatus.FORBIDDEN, "the address needs the token that `cspcheck explore` has printed")
            return
        if parts.path == "/":
            self._page()
        elif parts.path.startswith("/api/"):
            self._answer(parts.path.removeprefix("/api/"), arguments)
        else:
            self._refuse(HTTPStatus.NOT_FOUND, "there is no such page")

    def _page(self) -> None:
        nonce = secrets.token_urlsafe(16)
        page = files("cspcheck.exploring").joinpath("page.html").read_text(encoding="utf-8")
        for name, text in (("VIEW_STYLE", VIEW_STYLE), ("VIEW_SCRIPT", VIEW_SCRIPT), ("NONCE", nonce)):
            page = page.replace(f"/*{name}*/", text)
        policy = f"default-src 'none'; script-src 'nonce-{nonce}'; style-src 'unsafe-inline'; connect-src 'self'"
        self._send(HTTPStatus.OK, "text/html; charset=utf-8", page, {"Content-Security-Policy": policy})

    def _answer(self, question: str, arguments: dict[str, str]) -> None:
        try:
            found: dict[str, Any] = self.server.explorer.answer(question, arguments)
        except Unanswerable as error:
            self._refuse(HTTPStatus.BAD_REQUEST, str(error))
            return
        except Exception as error:
            from cspcheck.failure import InternalErrors

            report = InternalErrors(["explore"]).report(error, f"answering `{question}`")
            self._refuse(HTTPStatus.INTERNAL_SERVER_ERROR, report.message)
            return
        self._send(HTTPStatus.OK, "application/json", json.dumps(found))

    def _refuse(self, status: HTTPStatus, message: str) -> None:
        self._send(status, "application/json", json.dumps({"error": message}))

    def _send(self, status: HTTPStatus, kind: str, text: str, headers: dict[str, str] | None = None) -> None:
        content = text.encode()
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        for name, value in {**_HEADERS, **(headers or {})}.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, format: str, *args: Any) -> None:
        """Nothing: the terminal shows the address alone."""
