"""A limit that is reached while a failure is being explained takes nothing away from the verdict."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest

import cspcheck
from cspcheck.checker.explain.behaviour import Behaviour
from cspcheck.checking import NoWatch, Settings, checker_for
from cspcheck.cli import run

SCRIPT = """
channel a, b, c
P = a -> b -> STOP
D = a -> (let L = b -> L within L \\ {b})
N = a -> (b -> STOP |~| c -> STOP)
S = a -> c -> S
E(n) = a -> E(n + 1) [] n == 1 & b -> STOP
"""

FAILURES = {
    "P :[deadlock free]": ("deadlock", "`P` deadlocks after 2 events"),
    "E(0) :[deadlock free]": ("deadlock", "`E(0)` deadlocks after 2 events"),
    "D :[divergence free]": ("divergence", "`D` diverges after 1 event"),
    "D :[deterministic]": ("divergence", "`D` diverges after 1 event"),
    "N :[deterministic]": ("nondeterminism", "after 1 event it can perform an event, and it can refuse"),
    "N :[has trace [F]]: <a, b>": (None, "It does not hold, and that is all that is known"),
    "S [T= P": ("trace", "`P` performs `b` after 1 event"),
    "S [F= N": ("trace", "`N` performs `b` after"),
    "S [FD= D": ("divergence", "`D` diverges after 1 event"),
    "S [V= P": (None, "It does not hold, and that is all that is known"),
}


@pytest.mark.parametrize("assertion", FAILURES)
def test_memory_that_runs_out_while_explaining(assertion: str, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = cspcheck.loads(SCRIPT).check(assertion)

    def full(*_: Any, **__: Any) -> None:
        raise MemoryError

    monkeypatch.setattr(Behaviour, "confirm", full)
    result = cspcheck.loads(SCRIPT).check(assertion)

    assert (result.verdict, result.states, result.transitions) == (whole.verdict, whole.states, whole.transitions)
    assert result.verdict == "fail"
    kind, sentence = FAILURES[assertion]
    assert sentence in " ".join(result.explain().split())
    assert "out of memory" in (result.reason or result.remarks[0])
    assert (result.counterexample and result.counterexample.kind) == kind
    if kind is not None:
        assert result.counterexample is not None
        assert whole.counterexample is not None
        visible = [event for event in whole.counterexample.trace if event != "tau"]
        assert [event for event in result.counterexample.trace if event != "tau"] == visible


def test_a_time_that_is_over_while_explaining(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def slow(self: Behaviour) -> None:
        while True:
            time.sleep(0.01)

    monkeypatch.setattr(Behaviour, "components", slow)
    script = tmp_path / "s.csp"
    script.write_text(SCRIPT + "assert P :[deadlock free]\nassert not S [T= P\nassert STOP [T= STOP\n")
    monkeypatch.chdir(tmp_path)

    assert run(["s.csp", "--timeout", "0.5s"]) == 1
    out = capsys.readouterr().out
    lines = [" ".join(line.split()) for line in out.splitlines()]
    assert [line[:1] for line in lines if " :[" in line or "[T=" in line] == ["✗", "✓", "✓"]
    assert "`P` deadlocks after 2 events: nothing can happen, and it has not terminated." in lines
    said = "the failure was not explained to its end: time limit of 0.5 s (`--timeout`) reached"
    assert said in " ".join(out.split())


def test_what_is_sure_of_one_assertion_is_not_of_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    from cspcheck.checker.check import Checker

    script = cspcheck.loads(SCRIPT + "assert P :[deadlock free]\nassert P [T= P\n")._script
    checker = checker_for(script, Settings(), NoWatch())
    first, second = (assertion.node for assertion in script.assertions)
    assert checker.check(first).verdict == "fail"

    def full(*_: Any) -> None:
        raise MemoryError

    monkeypatch.setattr(Checker, "check", full)
    assert checker.check(second).verdict == "unknown"
