"""The prompt: expressions, types, assertions."""

import io
from pathlib import Path

import pytest

from cspcheck.cli import run


def said(
    lines: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *arguments: str
) -> tuple[int, str]:
    monkeypatch.setattr("sys.stdin", io.StringIO("\n".join(lines) + "\n"))
    code = run(["repl", *arguments])
    return code, capsys.readouterr().out


def test_a_session(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "x.csp"
    path.write_text("channel a : {0..2}\nf(x) = x + 1\nP = a?x -> P\nassert P :[deadlock free]\n")
    lines = [
        "f(2)",
        "card({| a |})",
        ":type f",
        ":assertions",
        ":run 1",
        "assert STOP :[deadlock free]",
        ":quit",
        "f(3)",
    ]
    code, text = said(lines, capsys, monkeypatch, str(path))
    assert code == 0
    assert text.startswith(f"{path}: 1 assertion\n3\n3\nf :: (Int) -> Int\n  1  P :[deadlock free]\n")
    assert "✓ P :[deadlock free]" in text
    assert "`STOP` deadlocks" in text
    assert not text.endswith("4\n")


def test_without_a_script(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    assert said(["<1..3>"], capsys, monkeypatch) == (0, "<1, 2, 3>\n")


def test_mistakes(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    code, text = said(["1 +", ":asertions", ":run 7", "true"], capsys, monkeypatch)
    assert code == 1
    assert "error[CSP" in text
    assert "did you mean `:assertions`?" in text
    assert "there is no assertion 7" in text
    assert text.endswith("true\n")


def test_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "x.svg"
    assert said([f":graph STOP {out}"], capsys, monkeypatch) == (0, f"{out}\n")
    assert out.read_text().startswith("<svg")


def test_what_is_typed_never_acts_on_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    escape = "\x1b[31m\x07"
    lines = [f'"{escape}"', f":{escape}", f":type {escape}", f":run {escape}", f":load {escape}", f"assert {escape}"]
    lines += [f":graph STOP {tmp_path}/{escape}.svg", f":graph {escape}", f":probe {escape}", escape]
    code, text = said(lines, capsys, monkeypatch)
    assert code == 1
    assert len(text.splitlines()) >= len(lines)
    assert not {character for character in text if character < " "} - {"\n"}


def test_numbers_and_pictures_that_are_not_said_well(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    code, text = said(
        [f":run {'9' * 5_000}", ":run \u00b2", ":graph", ":graph STOP", "(" * 100_000], capsys, monkeypatch
    )
    assert code == 1
    assert text.count("there is no assertion") == 2
    assert text.count("say which process and which file") == 2
    assert text.count("error[CSP") == 1
