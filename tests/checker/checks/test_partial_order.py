"""``:[partial order reduce]``: the same verdicts from fewer states, and a word on when it makes no difference."""

from __future__ import annotations

import pytest

from cspcheck.checker.check import Checker
from cspcheck.checker.verdict import (
    BY_PARTIAL_ORDER,
    UNORDERED_FULL,
    UNORDERED_KIND,
    UNORDERED_PROCESS,
    Outcome,
    Verdict,
)
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source

CELLS = """
external prioritise
N = 7
ID = {0..N-1}
channel a, b, c : ID
Once(i) = b.i -> c.i -> a.i -> STOP
Cycle(i) = a.i -> b.i -> Cycle(i)
Once_All = (||| i : ID @ Once(i)) \\ {| b, c |}
Cycles = ||| i : ID @ Cycle(i)
Urgent = prioritise(Cycles, <{| b |}, {| a |}>)
Some(k) = k > 0 & ([] i : ID @ a.i -> Some(k-1)) [] k > 0 & STOP
Ready(k) = k > 0 & ([] i : ID @ a.i -> Ready(k-1))
"""


def both(assertion: str, **options: bool) -> tuple[Outcome, Outcome]:
    """What an assertion gives with the option and without."""
    script = load(Source("s.csp", f"{CELLS}\nassert {assertion} :[partial order reduce]\nassert {assertion}\n"))
    with_it, without = (
        Checker(script, workers=1, as_written=not options, **options).check(assertion.node)
        for assertion in script.assertions
    )
    assert with_it.verdict is without.verdict
    assert without.reduction is None
    return with_it, without


@pytest.mark.parametrize(
    ("assertion", "verdict", "states"),
    [
        ("Cycles :[deadlock free [F]]", Verdict.PASS, 2),
        ("Cycles :[deadlock free]", Verdict.PASS, 2),
        ("Once_All :[deadlock free [F]]", Verdict.FAIL, 22),
        ("Once_All :[divergence free]", Verdict.PASS, 22),
        ("Some(N) [T= Once_All", Verdict.PASS, 142),
        ("Some(N-1) [T= Once_All", Verdict.FAIL, 141),
        ("Ready(N) [FD= Once_All", Verdict.FAIL, 22),
    ],
)
def test_it_leaves_states_out(assertion: str, verdict: Verdict, states: int) -> None:
    found, whole = both(assertion)
    assert found.verdict is verdict
    assert (found.states, found.reduction) == (states, "partial order")
    assert found.states < whole.states // 10 or whole.states <= 128
    assert BY_PARTIAL_ORDER in found.remarks
    if whole.counterexample is not None:
        assert found.counterexample is not None
        assert found.counterexample.kind == whole.counterexample.kind
        lengths = [
            sum(event != "tau" for event in shown.trace) for shown in (found.counterexample, whole.counterexample)
        ]
        assert lengths[0] == lengths[1]


@pytest.mark.parametrize(
    ("assertion", "why", "options"),
    [
        ("Urgent :[deadlock free [F]]", UNORDERED_PROCESS, {}),
        ("Cycle(1) :[deadlock free [F]]", UNORDERED_PROCESS, {}),
        ("Ready(N) [F= Cycles", UNORDERED_PROCESS, {}),
        ("Cycles :[deterministic]", UNORDERED_KIND, {}),
        ("Cycles :[has trace]: <a.0>", UNORDERED_KIND, {}),
        ("Ready(1) [V= Cycle(0)", UNORDERED_KIND, {}),
        ("Cycles :[deadlock free [F]]", UNORDERED_FULL, {"full": True}),
    ],
)
def test_where_it_makes_no_difference_the_answer_says_so(assertion: str, why: str, options: dict[str, bool]) -> None:
    found, whole = both(assertion, **options)
    assert (found.states, found.transitions, found.reduction) == (whole.states, whole.transitions, None)
    assert found.counterexample == whole.counterexample
    assert found.remarks[-1] == f"partial order changes nothing here: {why}"


def test_what_few_states_tell_is_told_by_them() -> None:
    script = load(Source("s.csp", f"{CELLS}\nassert Cycles :[deadlock free] :[partial order reduce]"))
    found = Checker(script, workers=1).check(script.assertions[0].node)
    assert (found.verdict, found.states, found.reduction, found.remarks) == (Verdict.PASS, 128, None, ())
