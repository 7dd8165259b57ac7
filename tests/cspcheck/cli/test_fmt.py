"""``cspcheck fmt``: scripts in the standard layout."""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from cspcheck.cli import run

UNTIDY = "-- kept\nchannel a,b\nP=a->b->P  -- kept, too\nassert P:[deadlock free]\n"
TIDY = "-- kept\nchannel a, b\nP = a -> b -> P  -- kept, too\nassert P :[deadlock free]\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "untidy.csp").write_text(UNTIDY)
    (tmp_path / "tidy.csp").write_text(TIDY)
    return tmp_path


def test_it_prints_and_changes_nothing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["fmt", "untidy.csp"]) == 0
    assert capsys.readouterr() == (TIDY, "")
    assert (folder / "untidy.csp").read_text() == UNTIDY


def test_standard_input(folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(UNTIDY.encode())))

    assert run(["fmt", "-"]) == 0
    assert capsys.readouterr() == (TIDY, "")


def test_in_place(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = (folder / "tidy.csp").stat().st_mtime_ns

    assert run(["fmt", "-i", "untidy.csp", "tidy.csp"]) == 0
    assert capsys.readouterr() == ("", "")
    assert (folder / "untidy.csp").read_text() == TIDY
    assert (folder / "tidy.csp").stat().st_mtime_ns == before


def test_check_names_what_would_change(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["fmt", "--check", "untidy.csp", "tidy.csp"]) == 1
    assert capsys.readouterr() == ("", "would change untidy.csp\n")
    assert run(["fmt", "--check", "tidy.csp"]) == 0
    assert (folder / "untidy.csp").read_text() == UNTIDY


def test_diff(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["fmt", "--diff", "untidy.csp", "tidy.csp"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "--- untidy.csp",
        "+++ untidy.csp",
        "@@ -1,4 +1,4 @@",
        " -- kept",
        "-channel a,b",
        "-P=a->b->P  -- kept, too",
        "-assert P:[deadlock free]",
        "+channel a, b",
        "+P = a -> b -> P  -- kept, too",
        "+assert P :[deadlock free]",
    ]


def test_diff_of_a_file_without_a_last_line_break(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "untidy.csp").write_text("P = STOP")

    assert run(["fmt", "--diff", "untidy.csp"]) == 0
    assert capsys.readouterr().out.splitlines()[3:] == [
        "-P = STOP",
        "\\ No newline at end of file",
        "+P = STOP",
    ]


def test_a_bad_file_does_not_stop_the_others_and_stays_as_it_is(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "bad.csp").write_text("P = (")

    assert run(["fmt", "-i", "bad.csp", "missing.csp", "untidy.csp"]) == 2
    err = capsys.readouterr().err
    assert "error[CSP102]" in err
    assert "error[CSP001]: cannot read `missing.csp`" in err
    assert (folder / "bad.csp").read_text() == "P = ("
    assert (folder / "untidy.csp").read_text() == TIDY


def test_a_folder_means_every_script_below_it(folder: Path) -> None:
    (folder / "parts").mkdir()
    (folder / "parts" / "main.csp").write_text('include "part.csp"\n')
    (folder / "parts" / "part.csp").write_text("P=STOP\n")

    assert run(["fmt", "-i", "."]) == 0
    assert (folder / "parts" / "part.csp").read_text() == "P = STOP\n"
    assert (folder / "untidy.csp").read_text() == TIDY


@pytest.mark.parametrize(
    ("encoding", "start"), [("utf-8", b""), ("cp1252", b""), ("utf-8", b"\xef\xbb\xbf")], ids=["utf-8", "cp1252", "bom"]
)
@pytest.mark.parametrize("line_break", ["\n", "\r\n"])
def test_encoding_and_line_breaks_stay(folder: Path, encoding: str, start: bytes, line_break: str) -> None:
    def content(line: str) -> bytes:
        return start + f"-- Käse{line_break}{line}{line_break}".encode(encoding)

    (folder / "cheese.csp").write_bytes(content("P=STOP"))

    assert run(["fmt", "-i", "cheese.csp"]) == 0
    assert (folder / "cheese.csp").read_bytes() == content("P = STOP")


def test_bytes_that_would_be_lost_are_not_touched(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "odd.csp").write_bytes(b"-- \x81\nP=STOP\n")

    assert run(["fmt", "-i", "odd.csp"]) == 2
    assert "CSP905" in capsys.readouterr().err
    assert (folder / "odd.csp").read_bytes() == b"-- \x81\nP=STOP\n"
