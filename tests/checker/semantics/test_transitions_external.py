"""The external functions, each held against its definition."""

from __future__ import annotations

import pytest
from hypothesis import assume, given, settings, strategies as st

from cspcheck.checker.semantics.transitions import LimitReached, explore, transitions
from cspcheck.checker.verdict import Limits, Verdict
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.process.events import TAU, TICK, EventSet
from cspcheck.cspm.process.terms import (
    DIV,
    SKIP,
    STOP,
    TERMINATED,
    External,
    ExternalChoice,
    Hide,
    Parallel,
    Prioritised,
    Process,
    Reference,
    Watchdog,
)
from tests.checker.explicit import Rows, closure, diverges, first_nondeterminism, refinement_violation
from tests.checker.terms import BASIC, CHOICE, PARALLEL, event_sets, processes, reference, told
from tests.checker.textbook import a, b, c, checker, d, e, events, forever, hidden, interleave, perhaps, then
from tests.examples import examples

MANY = settings(max_examples=examples(150))
small = processes(size=6)
endless = processes(operators=BASIC - {type(SKIP)} | CHOICE | PARALLEL, size=5)
"""Processes that seldom terminate."""


def rows_of(process: Process, most: int = 1_000) -> Rows:
    try:
        machine = explore(process, Limits(states=most)).lts
    except LimitReached:
        assume(False)
        raise
    return [set(machine.successors(state)) for state in range(machine.states)]


def function(name: str, process: Process) -> External:
    return External(name, process, ())


class TestChase:
    def test_the_first_tau_is_followed_to_its_end(self) -> None:
        process = perhaps(perhaps(then(a, STOP), then(b, STOP)), then(c, STOP))
        assert transitions(function("chase", process)) == ((a, function("chase", STOP)),)

    def test_what_is_visible_is_ignored_while_there_is_a_tau(self) -> None:
        process = ExternalChoice((then(b, STOP), perhaps(then(a, STOP), DIV)))
        assert [event for event, _ in transitions(function("chase", process))] == [a, b]

    def test_states_after_an_event_have_been_chased_too(self) -> None:
        process = ExternalChoice((then(a, perhaps(then(c, STOP))), then(b, perhaps(perhaps(then(c, STOP))))))
        (_, one), (_, other) = transitions(function("chase", process))
        assert one is other is function("chase", then(c, STOP))

    def test_a_cycle_of_taus_is_a_divergence(self) -> None:
        process = function("chase", hidden(forever(a), a))
        ((event, after),) = transitions(explore(process).terms[0])
        assert event == TAU
        assert (TAU, after) in transitions(after)

    def test_to_chase_twice_is_to_chase(self) -> None:
        process = reference("P", lambda: then(a, function("chase", process)))
        assert explore(function("chase", process)).lts.states == 1

    def test_what_terminates_is_left_alone(self) -> None:
        assert transitions(function("chase", perhaps(SKIP))) == ((TICK, TERMINATED),)
        assert transitions(function("chase", then(a, SKIP))) == ((a, SKIP),)

    @MANY
    @given(small, st.sampled_from(("chase", "chase_nocache")))
    def test_it_is_the_process_with_one_choice_of_taus(self, process: Process, name: str) -> None:
        """Each state of the result is one of the process, without a tau unless it can only go round in taus."""
        original, chased = rows_of(process), rows_of(function(name, process))
        assert refinement_violation(original, chased, "T") is None
        for row in chased:
            assert TAU not in {event for event, _ in row} or len(row) == 1
        if not any(diverges(original, frozenset({s})) for s in range(len(original))):
            assert refinement_violation(original, chased, "FD") is None

    @MANY
    @given(small)
    def test_of_a_deterministic_process_it_changes_nothing(self, process: Process) -> None:
        original = rows_of(process)
        assume(first_nondeterminism(original) is None and not diverges(original, closure(original, {0})))
        assume(not any(diverges(original, frozenset({s})) for s in range(len(original))))
        assert refinement_violation(rows_of(function("chase", process)), original, "FD") is None


class TestDeter:
    def test_one_stable_state_and_one_target_are_chosen(self) -> None:
        process = perhaps(ExternalChoice((then(a, STOP), then(a, b, STOP))), then(c, STOP))
        assert transitions(function("deter", process)) == ((a, function("deter", STOP)),)

    def test_a_way_out_of_a_cycle_of_taus_is_taken(self) -> None:
        process = hidden(ExternalChoice((forever(a), then(a, b, STOP))), a)
        assert [event for event, _ in transitions(function("deter", process))] == [b]

    def test_termination_is_all_that_happens_where_it_can(self) -> None:
        assert transitions(function("deter", ExternalChoice((SKIP, then(a, STOP))))) == ((TICK, TERMINATED),)

    @MANY
    @given(small)
    def test_the_result_is_a_deterministic_refinement(self, process: Process) -> None:
        original, chosen = rows_of(process), rows_of(function("deter", process))
        for model in ("T", "F", "FD"):
            assert refinement_violation(original, chosen, model) is None, told(process)
        assert first_nondeterminism(chosen) is None
        if not any(diverges(original, frozenset({s})) for s in range(len(original))):
            assert not any(diverges(chosen, frozenset({s})) for s in range(len(chosen)))


class TestLoop:
    def test_it_begins_again_after_each_end(self) -> None:
        from cspcheck.cspm.script import load
        from cspcheck.cspm.source import Source

        script = load(Source("loop.csp", "channel a, b\nexternal loop\nP = a -> b -> SKIP\nQ = a -> b -> Q"))
        looping = script.assertion("loop(P) [FD= Q").node
        from cspcheck.checker.check import Checker

        assert Checker(script).check(looping).verdict is Verdict.PASS
        assert Checker(script).check(script.assertion("Q [FD= loop(P)").node).verdict is Verdict.PASS


ORDER = ((a, b), (a, c), (b, c))
"""a above b above c, closed."""


def by_order(process: Process, maximal: EventSet = EventSet()) -> External:  # noqa: B008
    return External("prioritisepo", process, (events(a, b, c), ORDER, maximal))


class TestPrioritiseByOrder:
    def test_an_event_gives_way_to_a_greater_one(self) -> None:
        def possible(process: Process) -> list[int]:
            return [event for event, _ in transitions(by_order(process))]

        assert possible(ExternalChoice((then(a, STOP), then(c, STOP), then(d, STOP)))) == [a, d]
        assert possible(ExternalChoice((then(b, STOP), then(c, STOP)))) == [b]
        assert possible(then(c, STOP)) == [c]

    def test_what_is_not_maximal_gives_way_to_tau_and_tick(self) -> None:
        def possible(process: Process, *maximal: int) -> list[int]:
            return [event for event, _ in transitions(by_order(process, events(*maximal)))]

        with_tau = ExternalChoice((then(a, STOP), then(d, STOP), perhaps(STOP)))
        assert possible(with_tau) == [TAU, d]
        assert possible(with_tau, a) == [TAU, a, d]
        assert possible(ExternalChoice((then(a, STOP), then(d, STOP), SKIP))) == [TICK, d]

    @MANY
    @given(small, event_sets(3, min_size=1), event_sets(3), event_sets(3))
    def test_a_linear_order_of_levels_is_prioritise(
        self, process: Process, first: EventSet, second: EventSet, third: EventSet
    ) -> None:
        levels = tuple(
            events(*(x for x in level if not any(x in higher for higher in before)))
            for level, before in ((first, ()), (second, (first,)), (third, (first, second)))
        )
        order = tuple(
            sorted((x, y) for i, high in enumerate(levels) for low in levels[i + 1 :] for x in high for y in low)
        )
        everything = events(*(x for level in levels for x in level))
        by_levels = rows_of(Prioritised(process, levels))
        assert rows_of(External("prioritisepo", process, (everything, order, levels[0]))) == by_levels


ALPHABET = events(a, b, c)


def watched(specification: Process, implementation: Process, kind: str) -> Process:
    return Parallel(ALPHABET, (implementation, External(kind, specification, (ALPHABET, e))))


def barks(rows: Rows) -> bool:
    return any(event == e for row in rows for event, _ in row)


def is_deadlocked(rows: Rows) -> bool:
    """Whether some state has no transition (none is terminated, for a watchdog never terminates)."""
    return any(not row for row in rows)


def terminates(rows: Rows) -> bool:
    return any(event == TICK for row in rows for event, _ in row)


class TestWatchdogs:
    @settings(max_examples=examples(250))
    @given(endless, endless)
    def test_the_watchdog_for_traces_barks_at_what_the_specification_cannot_do(
        self, specification: Process, implementation: Process
    ) -> None:
        spec, impl = rows_of(specification), rows_of(implementation)
        assume(not terminates(spec) and not terminates(impl))
        watching = rows_of(watched(specification, implementation, "trace_watchdog"), 5_000)
        assert barks(watching) == (refinement_violation(spec, impl, "T") is not None)

    @settings(max_examples=examples(250))
    @given(endless, endless)
    def test_the_watchdog_for_failures_barks_or_is_stuck_with_what_the_specification_cannot_refuse(
        self, specification: Process, implementation: Process
    ) -> None:
        spec, impl = rows_of(specification), rows_of(implementation)
        assume(not terminates(spec) and not terminates(impl))
        watching = rows_of(watched(specification, implementation, "failure_watchdog"), 5_000)
        refines = refinement_violation(spec, impl, "F") is None
        assert (not barks(watching) and not is_deadlocked(watching)) == refines

    def test_the_verdict_from_a_script(self) -> None:
        spec = forever(a, b)
        for kind, allowed, forbidden in (
            ("trace_watchdog", perhaps(spec, STOP), then(a, a, STOP)),
            ("failure_watchdog", spec, perhaps(spec, STOP)),
        ):
            for implementation, verdict in ((allowed, Verdict.PASS), (forbidden, Verdict.FAIL)):
                whole = watched(spec, implementation, kind)
                bark_free = checker().check_refinement(STOP, "T", Hide(whole, ALPHABET))
                alive = checker().check_property(whole, "deadlock free", "F")
                if kind == "trace_watchdog":
                    assert bark_free.verdict is verdict
                else:
                    assert (Verdict.FAIL in (bark_free.verdict, alive.verdict)) == (verdict is Verdict.FAIL)

    def test_it_insists_on_a_least_choice_of_what_must_be_offered(self) -> None:
        must = perhaps(ExternalChoice((then(a, STOP), then(b, STOP))), ExternalChoice((then(a, STOP), then(c, STOP))))
        steps = transitions(External("failure_watchdog", must, (ALPHABET, e)))
        insisting = [state for event, state in steps if event == TAU]
        assert all(isinstance(state, Watchdog) for state in insisting)
        assert [sorted(state.insists) for state in insisting] == [[a], [b, c]]  # type: ignore[attr-defined]


class TestRunning:
    """The functions within compositions and around them."""

    @settings(max_examples=examples(60))
    @given(processes(size=5), processes(size=5), st.sampled_from(("chase", "deter", "prioritisepo", "trace_watchdog")))
    def test_a_composition_with_a_function_has_the_machine_of_the_terms(
        self, p: Process, q: Process, name: str
    ) -> None:
        arguments = {"prioritisepo": (ALPHABET, ORDER, EventSet()), "trace_watchdog": (ALPHABET, e)}.get(name, ())
        whole = Hide(Parallel(events(a), (External(name, p, arguments), q)), events(b))
        terms = rows_of(whole)
        machine = checker(full=True).lts(whole)
        assert (machine.states, machine.transitions) == (len(terms), sum(map(len, terms)))

    def test_counterexamples_are_replayed_through_functions(self) -> None:
        chased = function("chase", hidden(interleave(forever(a, b), forever(c, b)), a, c))
        outcome = checker().check_refinement(then(b, STOP), "T", Parallel(events(), (chased, forever(d))))
        assert outcome.counterexample is not None
        assert outcome.counterexample.event == "d"

    def test_a_function_that_refers_to_itself_at_once_is_unguarded(self) -> None:
        process: Reference = reference("P", lambda: function("chase", process))
        with pytest.raises(ScriptError, match="calls itself before any event"):
            explore(process)
