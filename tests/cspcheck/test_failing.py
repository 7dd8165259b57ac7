"""Failures of every kind as people read them: one script a kind, word for word."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from syrupy.assertion import SnapshotAssertion

from cspcheck.checker.verdict import Verdict
from cspcheck.cli import run
from cspcheck.report.style import columns

FOLDER = Path(__file__).parent / "failing"
SCRIPTS = sorted(path.stem for path in FOLDER.glob("*.csp"))


def shown(name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *options: str) -> str:
    monkeypatch.chdir(FOLDER)
    code = run([f"{name}.csp", "--color", "never", *options])

    assert code == 1
    return re.sub(r"\d+\.\d\d s\b", "... s", capsys.readouterr().out)


@pytest.mark.parametrize("name", SCRIPTS)
def test_every_assertion_fails_and_says_why(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], snapshot: SnapshotAssertion
) -> None:
    text = shown(name, monkeypatch, capsys)

    assert "pass" not in text.splitlines()[-1]
    assert max(map(columns, text.splitlines())) <= 80
    assert text == snapshot


@pytest.mark.parametrize("name", ["phases", "long", "memory"])
def test_with_v_nothing_is_folded(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], snapshot: SnapshotAssertion
) -> None:
    assert shown(name, monkeypatch, capsys, "-v") == snapshot


@pytest.mark.parametrize("name", SCRIPTS)
def test_the_specification_is_aligned_with_the_implementation(name: str) -> None:
    """Its run has the visible events of the counterexample, in order."""
    import cspcheck

    for result in cspcheck.load(FOLDER / f"{name}.csp").check():
        counterexample = result.counterexample
        if counterexample is None or counterexample.specification is None:
            continue
        assert result.verdict is Verdict.FAIL
        run_of_it = counterexample.specification
        assert [e for e in run_of_it.trace if e != "tau"] == [e for e in counterexample.trace if e != "tau"]
        assert len(run_of_it.states) == len(run_of_it.trace) + 1 == len(run_of_it.causes) + 1
