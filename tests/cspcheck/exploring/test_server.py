"""The explorer's server: for this machine and who knows the token; and its page in a real browser."""

import json
import shutil
import socket
import subprocess
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

import pytest

from cspcheck import checking
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from cspcheck.exploring.model import Explorer, Unanswerable
from cspcheck.exploring.server import ExplorerServer

SCRIPT = """\
channel pick, put : {0..1}.{0..1}
Phil(i) = pick.i.i -> pick.i.(1 - i) -> put.i.i -> put.i.(1 - i) -> Phil(i)
Fork(i) = pick?p!i -> put!p!i -> Fork(i)
Table = (Phil(0) ||| Phil(1)) [| {| pick, put |} |] (Fork(0) ||| Fork(1))
assert Table :[deadlock free]
"""
BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ExplorerServer]:
    path: Path = tmp_path_factory.mktemp("x") / "table.csp"
    path.write_text(SCRIPT)
    script = checking.load(str(path), checking.Settings())
    found = ExplorerServer(Explorer(script, checking.Settings()))
    thread = threading.Thread(target=found.serve_forever, daemon=True)
    thread.start()
    yield found
    found.shutdown()
    found.server_close()


def get(server: ExplorerServer, path: str, **headers: str) -> tuple[int, str]:
    request = urllib.request.Request(f"http://127.0.0.1:{server.port}{path}", headers=headers)
    try:
        with urllib.request.urlopen(request) as response:
            return response.status, response.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def test_the_token_is_needed(server: ExplorerServer) -> None:
    assert get(server, "/")[0] == 403
    assert get(server, "/?token=guess")[0] == 403
    assert get(server, "/api/script")[0] == 403
    assert get(server, f"/?token={server.token}")[0] == 200


def test_a_name_of_somebody_else_for_this_machine_is_refused(server: ExplorerServer) -> None:
    assert get(server, f"/?token={server.token}", Host=f"evil.example:{server.port}")[0] == 403


def test_only_this_machine_is_listened_to(server: ExplorerServer) -> None:
    assert server.server_address[0] == "127.0.0.1"


def test_answers(server: ExplorerServer) -> None:
    status, text = get(server, f"/api/place?root=Table&way=&token={server.token}")
    assert status == 200
    assert [step["event"] for step in json.loads(text)["steps"]] == ["pick.0.0", "pick.1.1"]
    assert get(server, f"/api/place?root=Nobody&token={server.token}")[0] == 400
    assert get(server, f"/else?token={server.token}")[0] == 404


def dumped(address: str, tmp_path: Path) -> str:
    """The page as it is after its script has run."""
    assert BROWSER is not None
    done = subprocess.run(
        [
            BROWSER,
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            f"--user-data-dir={tmp_path}",
            "--virtual-time-budget=15000",
            "--dump-dom",
            address,
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.skipif(BROWSER is None, reason="no Chromium: the page is not tried in a browser")
def test_the_page_in_a_browser(server: ExplorerServer, tmp_path: Path) -> None:
    page = dumped(f"{server.address}#root=Table&way=1.1", tmp_path)
    assert "Deadlock: nothing can happen" in page
    assert "waits for" in page
    assert 'class="here"' in page  # the state in the picture of the machine
    assert page.count("<svg") == 2
    assert "Phil(0)" in page


@pytest.mark.skipif(BROWSER is None, reason="no Chromium: the page is not tried in a browser")
def test_a_way_that_is_none_goes_as_far_as_it_goes(server: ExplorerServer, tmp_path: Path) -> None:
    page = dumped(f"{server.address}#root=Table&way=1.7.1", tmp_path)
    assert "the way of the address ends after 1: there is no step 7" in page
    assert "pick.0.0</a>" in page
    assert "waits for" in page
    assert "there are no data to be shown" in page


@pytest.mark.skipif(BROWSER is None, reason="no Chromium: the page is not tried in a browser")
def test_a_picture_in_a_browser_is_fitted(tmp_path: Path) -> None:
    from cspcheck.cli import run

    script = tmp_path / "x.csp"
    script.write_text("channel a : {0..40}\nP(n) = n < 40 & a.n -> P(n + 1)\n")
    out = tmp_path / "x.html"
    assert run(["graph", str(script), "P(0)", "-o", str(out)]) == 0
    page = dumped(out.as_uri(), tmp_path / "profile")
    scale = float(page.split("scale(")[1].split(")")[0])
    assert scale < 0.5


@pytest.mark.skipif(BROWSER is None, reason="no Chromium: the report is not tried in a browser")
def test_a_report_in_a_browser(server: ExplorerServer, tmp_path: Path) -> None:
    from cspcheck.cli import run

    (tmp_path / "table.csp").write_text(SCRIPT)
    out = tmp_path / "report.html"
    assert run(["check", str(tmp_path / "table.csp"), "--format", "html", "-o", str(out)]) == 1
    page = dumped(out.as_uri(), tmp_path / "profile")
    assert "deadlocks after 2 events" in page
    assert "<figcaption>the run, component by component" in page
    assert page.count("<svg") == 2  # the chart, and the machine


def test_a_way_of_thousands_of_steps_is_gone(server: ExplorerServer) -> None:
    """As a counterexample may have them; the address of a page may have 65,536 characters."""
    way = ".".join(["1"] * 5_000)
    code, text = get(server, f"/api/place?token={server.token}&root={quote('pick?x?y -> STOP; X')}&way=1")
    assert code == 400
    root = quote("let R = pick?x?y -> R within R")
    code, text = get(server, f"/api/place?token={server.token}&root={root}&way={way}")
    assert (code, len(json.loads(text)["trace"])) == (200, 5_000)
    code, text = get(server, f"/api/place?token={server.token}&root={root}&way={way}.9")
    assert (code, json.loads(text)) == (400, {"error": "the way of the address ends after 5000: there is no step 9"})


def test_what_is_no_request_is_refused_in_words(server: ExplorerServer, capfd: pytest.CaptureFixture[str]) -> None:
    """And whoever goes away before the answer has come leaves no trace on the terminal."""
    with socket.create_connection(("127.0.0.1", server.port)) as asking:
        asking.sendall(b"GET http://[::1 HTTP/1.0\r\n\r\n")
        assert b"there is no such address" in asking.makefile("rb").read()
    for error in (ConnectionResetError(), BrokenPipeError()):
        try:
            raise error
        except ConnectionError:
            server.handle_error(None, None)
    assert capfd.readouterr().err == ""


def test_a_limit_holds_for_whatever_is_asked() -> None:
    text = (
        "channel a\nfib(n) = if n < 2 then n else fib(n - 1) + fib(n - 2)\nP = if fib(60) == 1 then STOP else a -> P\n"
    )
    explorer = Explorer(load(Source("p.csp", text)), checking.Settings(limits=checking.limits(seconds=0.1)))
    with pytest.raises(Unanswerable, match=r"time limit of 0.1 s .* reached while "):
        explorer.answer("place", {"root": "P", "way": ""})
    explorer._settings = checking.Settings()
    assert len(explorer.answer("place", {"root": "a -> STOP", "way": ""})["steps"]) == 1
