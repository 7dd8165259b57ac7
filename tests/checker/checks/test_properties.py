"""Deadlock freedom, divergence freedom, and the possession of a trace."""

from __future__ import annotations

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.checker.verdict import Outcome, Verdict
from cspcheck.cspm.process.terms import DIV, SKIP, STOP, Chaos, Process, Run
from cspcheck.cspm.syntax.tree import PropertyKind
from tests.checker import explicit
from tests.checker.terms import compositions, processes
from tests.checker.textbook import (
    a,
    b,
    c,
    checker,
    choose,
    d,
    events,
    forever,
    hidden,
    identifiers,
    interleave,
    perhaps,
    rows_of,
    sequence,
    share,
    then,
    timeout,
)

ab = events(a, b)
terms = st.one_of(processes(size=8), compositions(size=5, components=3))

PASS, FAIL = Verdict.PASS, Verdict.FAIL


def holds(outcome: Outcome) -> bool:
    assert outcome.verdict in (PASS, FAIL)
    assert (outcome.counterexample is None) == (outcome.verdict is PASS)
    return outcome.verdict is PASS


class TestDeadlockFree:
    @pytest.mark.parametrize(
        ("process", "in_f", "in_fd"),
        [
            pytest.param(STOP, False, False, id="STOP"),
            pytest.param(SKIP, True, True, id="SKIP terminates"),
            pytest.param(DIV, True, False, id="DIV is never stable"),
            pytest.param(Run(ab), True, True, id="RUN"),
            pytest.param(Chaos(ab), False, False, id="CHAOS"),
            pytest.param(forever(a, b), True, True, id="a loop"),
            pytest.param(hidden(forever(a, b), a), True, True, id="a loop with a hidden event"),
            pytest.param(hidden(forever(a, b), a, b), True, False, id="a hidden loop"),
            pytest.param(sequence(then(a, SKIP), STOP), False, False, id="termination into STOP"),
            pytest.param(interleave(then(a, SKIP), then(b, SKIP)), True, True, id="distributed termination"),
            pytest.param(interleave(then(a, SKIP), then(b, STOP)), False, False, id="one side does not terminate"),
            pytest.param(share(ab, forever(a, b), forever(b, a)), False, False, id="each waits for the other"),
            pytest.param(choose(SKIP, then(a, STOP)), False, False, id="a choice that may not terminate"),
            pytest.param(timeout(then(a, SKIP), SKIP), True, True, id="a timeout into SKIP"),
        ],
    )
    def test_textbook(self, process: Process, in_f: bool, in_fd: bool) -> None:
        assert holds(checker().check_property(process, "deadlock free", "F")) == in_f
        assert holds(checker().check_property(process, "deadlock free", "FD")) == in_fd
        assert holds(checker().check_property(process, "deadlock free")) == in_fd

    @settings(deadline=None)
    @given(terms, st.booleans())
    def test_in_f_the_first_trace_to_a_state_without_transitions(self, process: Process, full: bool) -> None:
        outcome = checker(full=full).check_property(process, "deadlock free", "F")
        expected = explicit.first_deadlock(rows_of(process))
        assert holds(outcome) == (expected is None)
        if outcome.counterexample is not None:
            assert outcome.counterexample.kind == "deadlock"
            assert identifiers(outcome.counterexample.trace) == expected

    @settings(deadline=None)
    @given(terms, st.booleans())
    def test_in_fd_the_first_trace_to_a_deadlock_or_divergence(self, process: Process, full: bool) -> None:
        outcome = checker(full=full).check_property(process, "deadlock free", "FD")
        rows = rows_of(process)
        deadlock, divergence = explicit.first_deadlock(rows), explicit.first_divergence(rows)
        assert holds(outcome) == (deadlock is None and divergence is None)
        if outcome.counterexample is not None:
            ordered = sorted(
                ((len(trace), trace, kind))
                for kind, trace in (("deadlock", deadlock), ("divergence", divergence))
                if trace is not None
            )
            _, trace, kind = ordered[0]
            assert identifiers(outcome.counterexample.trace) == trace
            assert outcome.counterexample.kind == kind

    @pytest.mark.parametrize("kind", ["deadlock free", "deterministic"])
    @pytest.mark.parametrize("process", [STOP, DIV, Run(ab), then(a, Run(ab)), perhaps(then(a, STOP), STOP)])
    def test_the_model_t_is_answered_in_f_and_the_result_says_so(self, kind: PropertyKind, process: Process) -> None:
        outcome = checker().check_property(process, kind, "T")
        assert outcome.verdict is checker().check_property(process, kind, "F").verdict
        assert outcome.remarks[-1] == (
            f"`{kind}` is no property of traces, which say nothing of what is refused: checked in F"
        )

    @settings(deadline=None)
    @given(terms)
    def test_states_and_transitions_are_those_of_the_terms(self, process: Process) -> None:
        rows = rows_of(process)
        outcome = checker(full=True).check_property(process, "deadlock free")
        assert outcome.states == len(rows)
        assert outcome.transitions == sum(map(len, rows))


class TestDivergenceFree:
    @pytest.mark.parametrize(
        ("process", "expected"),
        [
            pytest.param(DIV, False, id="DIV"),
            pytest.param(STOP, True, id="STOP"),
            pytest.param(Chaos(ab), True, id="CHAOS"),
            pytest.param(hidden(forever(a), a), False, id="a hidden loop"),
            pytest.param(hidden(forever(a, b), a), True, id="a half hidden loop"),
            pytest.param(then(b, hidden(then(a, DIV), a)), False, id="divergence behind a hidden event"),
            pytest.param(choose(then(a, STOP), DIV), False, id="a choice does not resolve divergence"),
            pytest.param(hidden(Chaos(ab), a), False, id="hidden CHAOS"),
        ],
    )
    def test_textbook(self, process: Process, expected: bool) -> None:
        for model in (None, "T", "F", "FD", "R"):
            assert holds(checker().check_property(process, "divergence free", model)) == expected

    @settings(deadline=None)
    @given(terms)
    def test_the_first_trace_to_endless_taus_and_their_loop(self, process: Process) -> None:
        outcome = checker().check_property(process, "divergence free")
        rows = rows_of(process)
        expected = explicit.first_divergence(rows)
        assert holds(outcome) == (expected is None)
        found = outcome.counterexample
        if found is not None:
            assert found.kind == "divergence"
            assert identifiers(found.trace) == expected
            assert found.loop

    def test_the_loop_is_the_shortest_through_its_state(self) -> None:
        """After a: a hidden d leads into a loop of two hidden events, b and c."""
        found = checker().check_property(hidden(then(a, d, forever(b, c)), b, c, d), "divergence free").counterexample
        assert found is not None
        assert found.trace == ("a", "tau")
        assert found.causes == (None, "d")
        assert found.loop == ("b", "c")


class TestHasTrace:
    @pytest.mark.parametrize(
        ("process", "trace", "models"),
        [
            pytest.param(STOP, (), "T F FD", id="every process has the empty trace"),
            pytest.param(DIV, (), "T F FD", id="even DIV"),
            pytest.param(STOP, (a,), "", id="STOP has no other"),
            pytest.param(then(a, b, STOP), (a, b), "T F FD", id="a prefix"),
            pytest.param(then(a, b, STOP), (a, a), "", id="not that one"),
            pytest.param(perhaps(then(a, STOP), then(b, STOP)), (a,), "T", id="an internal choice may refuse it"),
            pytest.param(choose(then(a, STOP), then(b, STOP)), (a,), "T F FD", id="an external choice may not"),
            pytest.param(timeout(then(a, STOP), then(b, STOP)), (a,), "T", id="a timeout may come first"),
            pytest.param(choose(then(a, STOP), SKIP), (a,), "T", id="termination may come first"),
            pytest.param(hidden(then(a, b, STOP), a), (b,), "T F FD", id="hidden events are no matter"),
            pytest.param(choose(then(a, STOP), DIV), (a,), "T F", id="divergence refuses nothing in F"),
            pytest.param(then(a, DIV), (a,), "T F FD", id="divergence behind the trace does not matter"),
            pytest.param(then(a, DIV), (a, b), "", id="divergence performs nothing"),
            pytest.param(
                choose(then(a, b, STOP), then(a, c, STOP)), (a, b), "T", id="the same event into two branches"
            ),
        ],
    )
    def test_textbook(self, process: Process, trace: tuple[int, ...], models: str) -> None:
        found = [
            model for model in ("T", "F", "FD") if holds(checker().check_property(process, "has trace", model, trace))
        ]
        assert found == models.split()

    @settings(deadline=None)
    @given(terms, st.lists(st.sampled_from((a, b, c)), max_size=4), st.sampled_from(("T", "F", "FD")))
    def test_as_defined(self, process: Process, trace: list[int], model: str) -> None:
        outcome = checker().check_property(process, "has trace", model, trace)
        rows = rows_of(process)
        assert holds(outcome) == explicit.has_trace(rows, tuple(trace), model)
        found = outcome.counterexample
        if found is not None:
            done = len(identifiers(found.trace))
            assert identifiers(found.trace) == tuple(trace[:done])
            assert explicit.has_trace(rows, tuple(trace[:done]), model)
            assert not explicit.has_trace(rows, tuple(trace[: done + 1]), model)
            if found.kind == "refusal":
                assert identifiers([found.event or ""]) == (trace[done],)

    def test_what_is_said(self) -> None:
        process = then(a, perhaps(then(b, STOP), then(c, STOP)))
        found = checker().check_property(process, "has trace", "F", (a, b)).counterexample
        assert found is not None
        assert (found.kind, found.trace, found.event, found.refusal) == ("refusal", ("a", "tau"), "b", ("b",))
        assert found.allowed == (("b", "c"),)
