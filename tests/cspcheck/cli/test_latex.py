"""``cspcheck latex`` and documents as scripts."""

from __future__ import annotations

from pathlib import Path

import pytest

from cspcheck.cli import run

SCRIPT = """given G

reading G = 2

class C
  chan c : [g? : G]
  main = c -> main
end

assert C :[deadlock free]
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_document_is_checked_like_the_script_that_it_was_made_from(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "c.csp").write_text(SCRIPT)

    assert run(["latex", "c.csp", "-o", "c.tex"]) == 0
    assert run(["c.tex", "--color", "never"]) == 0

    told = capsys.readouterr().out
    assert "C :[deadlock free]" in told
    assert "reading G = 2" in told
    assert run(["latex", "c.tex", "--text"]) == 0
    assert capsys.readouterr().out == SCRIPT


def test_odd_markup_is_read_with_a_warning(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "c.tex").write_text("\\begin{class}{C} \\begin{state} n : \\mathbb{N} \\end{state} \\end{class}")

    assert run(["latex", "--text", "--symbols", "--color", "never", "c.tex"]) == 0

    told = capsys.readouterr()
    assert told.out == "class C\n  state\n    n : ℕ\nend\n"
    assert told.err.startswith("warning[CSP620]: `\\mathbb{N}` is read as `\\nat`")


def test_a_document_is_not_formatted(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "c.tex").write_text("\\begin{class}{C} \\end{class}")

    assert run(["fmt", "c.tex"]) == 2
    assert "CSP627" in capsys.readouterr().err
