"""A violation that is a few steps away is found although internal steps lead nearly everywhere before any event."""

from __future__ import annotations

from functools import partial
from unittest.mock import patch

from hypothesis import given, settings, strategies as st

from cspcheck.checker.checks import refinement
from cspcheck.checker.verdict import BY_STEPS, Verdict
from cspcheck.cspm.process.terms import STOP, Process
from tests.checker import explicit
from tests.checker.terms import compositions, processes, reference
from tests.checker.textbook import a, b, checker, choose, hidden, identifiers, interleave, rows_of, then
from tests.examples import examples

terms = st.one_of(processes(size=6), compositions(size=4, components=2))


@settings(deadline=None, max_examples=examples(100))
@given(terms, st.sampled_from(("T", "F", "FD")), terms)
def test_what_is_found_is_a_violation_and_nothing_is_missed(spec: Process, model: str, impl: Process) -> None:
    little = patch.multiple(refinement, FIRST_LOOK=1, BEFORE_STEPS=1, _reduced=lambda *_: None)
    with little:
        outcome = checker().check_refinement(spec, model, impl)
    expected = explicit.refinement_violation(rows_of(spec), rows_of(impl), model)
    assert outcome.verdict is (Verdict.PASS if expected is None else Verdict.FAIL)
    found = outcome.counterexample
    if found is None or found.kind != "trace":
        return
    trace = identifiers(found.trace)
    allowed = explicit.after(rows_of(spec), trace)
    actual = explicit.after(rows_of(impl), trace)
    (event,) = identifiers([found.event or ""])
    assert event in explicit.events(rows_of(impl), actual) - explicit.events(rows_of(spec), allowed)
    if model == "FD":
        prefixes = [trace[:length] for length in range(len(trace) + 1)]
        assert not any(explicit.diverges(rows_of(spec), explicit.after(rows_of(spec), each)) for each in prefixes)


def test_with_no_event_before_there_are_none_fewer() -> None:
    """The note is of the events that come before; whatever internal steps do, there are no fewer than none."""
    system = hidden(then(100, then(100, a, b, STOP)), 100)
    with patch.multiple(refinement, FIRST_LOOK=1, BEFORE_STEPS=1, _reduced=lambda *_: None):
        first = checker().check_refinement(then(b, STOP), "T", system)
        second = checker().check_refinement(then(a, STOP), "T", system)
    assert [first.verdict, second.verdict] == [Verdict.FAIL] * 2
    assert first.remarks == ()
    assert second.remarks == (BY_STEPS,)


def test_behind_internal_steps_without_number() -> None:
    tick, length, clocks = 100, 9, 12
    hands: dict[tuple[int, int], Process] = {}

    def clock(number: int, hand: int) -> Process:
        return then(tick + number, hands[number, (hand + 1) % length])

    for number in range(clocks):
        for hand in range(length):
            hands[number, hand] = reference(f"Clock{number}_{hand}", partial(clock, number, hand))
    ticks = [tick + number for number in range(clocks)]
    system = hidden(interleave(then(a, ticks[0], b, STOP), *(hands[number, 0] for number in range(clocks))), *ticks)
    with patch.object(refinement, "_reduced", lambda *_: None):
        outcome = checker(states=1_500_000).check_refinement(choose(then(a, STOP), then(b, STOP)), "T", system)
    assert outcome.verdict is Verdict.FAIL
    assert outcome.counterexample is not None
    assert identifiers(outcome.counterexample.trace) == (a,)
    assert outcome.states < 10_000
    assert outcome.remarks == (BY_STEPS,)
