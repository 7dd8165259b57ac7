"""``cspcheck explain``: every mistake that can be told has its explanation, example and repair."""

from __future__ import annotations

import pytest
from syrupy.assertion import SnapshotAssertion

from cspcheck.cli import run
from cspcheck.register import PHASES, all_mistakes


def test_a_code(capsys: pytest.CaptureFixture[str], snapshot: SnapshotAssertion) -> None:
    assert run(["explain", "CSP903"]) == 0
    assert capsys.readouterr() == (snapshot, "")


@pytest.mark.parametrize("written", ["CSP903", "csp903", "903", "error[CSP903]"])
def test_however_it_is_written(capsys: pytest.CaptureFixture[str], written: str) -> None:
    assert run(["explain", written]) == 0
    assert capsys.readouterr().out.startswith("CSP903: no assertion selected\n")


def test_several_codes(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["explain", "CSP903", "CSP001"]) == 0
    out = capsys.readouterr().out
    assert "CSP903: " in out
    assert "\n\nCSP001: " in out


def test_a_code_in_color(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["explain", "CSP903", "--color", "always"]) == 0
    assert capsys.readouterr().out.startswith("\x1b[1;31mCSP903\x1b[0m")


def test_an_unknown_code(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["explain", "CSP90"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error[CSP906]: there is no code `CSP90`\n  = help: did you mean `CSP9")


def test_without_a_code_all_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["explain"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines == [f"{mistake.code}  {mistake.title}" for mistake in all_mistakes()]
    assert lines == sorted(lines)


def test_every_mistake_is_told_in_full() -> None:
    for mistake in all_mistakes():
        assert len(mistake.code) == 6
        assert mistake.code[3] in PHASES
        for text in (mistake.title, mistake.explanation, mistake.example, mistake.repair):
            assert text.strip(), mistake.code
        assert not mistake.title.endswith("."), mistake.code
