"""Counterexamples are canonical, shortest, replayed, and told component by component."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.checker.budget import Budget
from cspcheck.checker.checks.store import Machines
from cspcheck.checker.explain.behaviour import Behaviour, local_event
from cspcheck.checker.explain.replay import ReplayFailure
from cspcheck.checker.network.compiler import compile_network
from cspcheck.checker.packing.packed import PackedNetwork, pack
from cspcheck.checker.search.exploration import explore
from cspcheck.checker.search.paths import PathStep, shortest_path, tau_loop
from cspcheck.checker.verdict import Counterexample, Limits
from cspcheck.cspm.process.definitions import Definition
from cspcheck.cspm.process.events import TAU, EventSet, EventTable, FieldDomain
from cspcheck.cspm.process.terms import DIV, SKIP, STOP, Prefix, Process, Reference
from cspcheck.cspm.source import Source
from tests.checker import explicit
from tests.checker.terms import compositions, processes, reference
from tests.checker.textbook import (
    EVENTS,
    a,
    b,
    c,
    checker,
    choose,
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
)

terms = st.one_of(processes(size=8), compositions(size=5, components=3))


def counterexample(process: Process, kind: str, model: str | None = None) -> Counterexample:
    found = checker().check_property(process, kind, model).counterexample
    assert found is not None
    return found


class TestShortest:
    """Fewest visible events, then the order of the events, then fewest taus. (Traces: see the other tests.)"""

    @settings(deadline=None)
    @given(terms)
    def test_no_deadlock_after_the_same_trace_needs_fewer_taus(self, process: Process) -> None:
        found = checker().check_property(process, "deadlock free", "F").counterexample
        if found is not None:
            rows = rows_of(process)
            dead = {s for s, row in enumerate(rows) if not row} - explicit.terminated(rows)
            least = explicit.fewest_taus(rows, identifiers(found.trace), dead)
            assert found.trace.count("tau") == least

    @settings(deadline=None)
    @given(terms)
    def test_no_loop_after_the_same_trace_needs_fewer_taus(self, process: Process) -> None:
        found = checker().check_property(process, "divergence free").counterexample
        if found is not None and found.loop is not None:
            rows = rows_of(process)

            def returns(s: int) -> int | None:
                reached = {s}
                for steps in range(1, len(rows) + 1):
                    reached = {t for r in reached for label, t in rows[r] if label == TAU}
                    if s in reached:
                        return steps
                return None

            loops = {s: returns(s) for s in range(len(rows))}
            cyclic = {s for s, steps in loops.items() if steps is not None}
            assert found.trace.count("tau") == explicit.fewest_taus(rows, identifiers(found.trace), cyclic)
            assert len(found.loop) in loops.values()

    def test_the_earlier_declared_event_is_taken(self) -> None:
        """b -> STOP [] a -> STOP deadlocks after either; a was declared first."""
        assert counterexample(choose(then(b, STOP), then(a, STOP)), "deadlock free").trace == ("a",)

    def test_a_deadlock_is_told_rather_than_a_divergence_after_the_same_trace(self) -> None:
        assert counterexample(then(a, perhaps(DIV, STOP)), "deadlock free").kind == "deadlock"

    def test_a_divergence_after_a_shorter_trace_is_told_rather_than_a_deadlock(self) -> None:
        process = choose(then(a, c, STOP), then(b, DIV))
        assert counterexample(process, "deadlock free").kind == "divergence"
        assert counterexample(process, "deadlock free", "F").trace == ("a", "c")


class TestReplay:
    """What the operational semantics does not do is never told."""

    def behaviour(self, process: Process) -> Behaviour:
        exploration = Machines().exploration(process, "deadlock", Budget(Limits()))
        path = shortest_path(exploration, exploration.deadlocked(exploration.deadlock_level or 0))
        return Behaviour(process, exploration.packed, path, EVENTS)

    def test_a_true_deadlock_is_confirmed(self) -> None:
        self.behaviour(then(a, b, STOP)).confirm(lambda row: not row, "a deadlock")

    def test_a_path_that_ends_too_early_is_not(self) -> None:
        found = self.behaviour(then(a, b, STOP))
        early = Behaviour(found.process, found.packed, found.path[:1], EVENTS)
        with pytest.raises(ReplayFailure, match="does not end in a deadlock"):
            early.confirm(lambda row: not row, "a deadlock")

    def test_a_path_with_another_event_is_not(self) -> None:
        found = self.behaviour(then(a, b, STOP))
        wrong = tuple(replace(step, event=c) if step.event == b else step for step in found.path)
        with pytest.raises(ReplayFailure, match="no transition"):
            Behaviour(found.process, found.packed, wrong, EVENTS).confirm(lambda row: not row, "a deadlock")

    def test_a_loop_that_does_not_return_is_not(self) -> None:
        """One tau of a loop of two leads to the other state."""
        process = hidden(forever(a, b), a, b)
        exploration = Machines().exploration(process, "divergence", Budget(Limits()))
        loop = tau_loop(exploration, 0)
        assert len(loop) == 2
        behaviour = Behaviour(process, exploration.packed, (), EVENTS)
        behaviour.confirm(bool, "a state with transitions", loop)
        with pytest.raises(ReplayFailure, match="does not end in a cycle of taus"):
            behaviour.confirm(bool, "a state with transitions", loop[:1])

    def test_many_equal_components_are_told_apart_by_their_states(self) -> None:
        """Five components that each pass through taus: hundreds of terms share the labels of the path."""
        cells = [hidden(then(a, b, c, STOP), a, b) for _ in range(5)]
        found = counterexample(hidden(interleave(*cells), c), "deadlock free", "F")
        assert found.trace == ("tau",) * 15


def named(name: str, body: Callable[[], Process]) -> Reference:
    return reference(name, body)


def first_deadlock(packed: PackedNetwork) -> tuple[PathStep, ...]:
    exploration = explore(packed)
    assert exploration.deadlock_level is not None
    return shortest_path(exploration, exploration.deadlocked(exploration.deadlock_level))


def table(**channels: int) -> tuple[EventTable, dict[str, list[int]]]:
    """Channels with one field from 0 up, and their events."""
    events = EventTable()
    made = {}
    for name, size in channels.items():
        channel = events.declare(name, (FieldDomain(range(size)),) if size else ())
        made[name] = list(events.completions(channel))
    return events, made


class TestComponents:
    """Who did what, where they stand, what they offer and whom they wait for."""

    @pytest.fixture
    def philosophers(self) -> Counterexample:
        """Two philosophers, each with the fork on the left in hand.

        take.0 and take.1: philosopher 0 takes fork 0, then 1; take.2 and take.3: philosopher 1 takes fork 1, then 0.
        """
        names, made = table(take=4, put=4)
        take, put = made["take"], made["put"]
        source = Source("philosophers.csp", "channel take, put\nPhil(i) = ...\nFork(i) = ...\n")
        line = {"Phil": source.span(18, 31), "Fork": source.span(32, 45)}
        processes: dict[str, Reference] = {}

        def named(name: str, body: object) -> Reference:
            processes[name] = Reference((name, id(names)), Definition(name, line[name[:4]], body))  # type: ignore[arg-type]
            return processes[name]

        phils = [
            named(
                f"Phil({i})",
                lambda i=i: then(take[2 * i], take[2 * i + 1], put[2 * i], put[2 * i + 1], processes[f"Phil({i})"]),
            )
            for i in range(2)
        ]
        users = {0: (0, 3), 1: (1, 2)}
        forks = [
            named(
                f"Fork({i})",
                lambda i=i: Prefix(tuple((take[user], then(put[user], processes[f"Fork({i})"])) for user in users[i])),
            )
            for i in range(2)
        ]
        system = share(EventSet.of(take + put), interleave(*phils), interleave(*forks))
        found = checker(names).check_property(system, "deadlock free").counterexample
        assert found is not None
        return found

    def test_the_trace_of_each_is_aligned_with_the_whole(self, philosophers: Counterexample) -> None:
        assert philosophers.trace == ("take.0", "take.2")
        assert [(part.name, part.trace) for part in philosophers.components] == [
            ("Phil(0)", ("take.0", None)),
            ("Phil(1)", (None, "take.2")),
            ("Fork(0)", ("take.0", None)),
            ("Fork(1)", (None, "take.2")),
        ]

    def test_where_each_stands(self, philosophers: Counterexample) -> None:
        assert [(part.state, part.line) for part in philosophers.components] == [
            ("take.1 -> put.0 -> put.1 -> Phil(0)", 2),
            ("take.3 -> put.2 -> put.3 -> Phil(1)", 2),
            ("put.0 -> Fork(0)", 3),
            ("put.2 -> Fork(1)", 3),
        ]

    def test_what_each_offers_and_whom_it_waits_for(self, philosophers: Counterexample) -> None:
        assert [(part.offers, part.waiting_for) for part in philosophers.components] == [
            (("take.1",), ("Fork(1)",)),
            (("take.3",), ("Fork(0)",)),
            (("put.0",), ("Phil(0)",)),
            (("put.2",), ("Phil(1)",)),
        ]

    def test_the_cycle_of_waiting(self, philosophers: Counterexample) -> None:
        assert philosophers.waiting_cycle == ("Phil(0)", "Fork(1)", "Phil(1)", "Fork(0)")

    def test_a_deadlock_refuses_the_whole_alphabet(self, philosophers: Counterexample) -> None:
        assert philosophers.refusal == tuple(f"{name}.{i}" for name in ("take", "put") for i in range(4))

    def test_events_are_named_as_the_component_sees_them(self) -> None:
        """A hidden hand-over is a tau of the whole and c for the two."""
        system = hidden(share(events(c), forever(a, c, name="In"), then(c, STOP)), c)
        found = counterexample(system, "deadlock free")
        assert found.trace == ("a", "tau", "a")
        assert found.causes == (None, "c", None)
        assert [part.trace for part in found.components] == [("a", "c", "a"), (None, "c", None)]
        assert found.components[0].offers == ("c",)
        assert len(found.components[0].waiting_for) == 1
        assert found.waiting_cycle is None

    def test_components_that_have_passed_on_are_told_without_a_state(self) -> None:
        first = interleave(named("P", lambda: then(a, SKIP)), named("Q", lambda: then(b, SKIP)))
        second = interleave(named("R", lambda: then(c, STOP)), named("S", lambda: STOP))
        network = compile_network(sequence(first, second), slot_states=2)
        assert network.formats > 1
        path = first_deadlock(pack(network))
        behaviour = Behaviour(sequence(first, second), pack(network), path, EVENTS)
        assert behaviour.trace == ("a", "b", "tau", "c")
        told = {part.name: (part.trace, part.state, part.waiting_for) for part in behaviour.components()}
        assert told == {
            "P": (("a", None, "tick", None), "", ()),
            "Q": ((None, "b", "tick", None), "", ()),
            "R": ((None, None, None, "c"), "STOP", ()),
            "S": ((None, None, None, None), "STOP", ()),
        }

    @settings(deadline=None)
    @given(compositions(size=4, components=3))
    def test_each_trace_is_one_of_its_component(self, process: Process) -> None:
        """Where the components stay the same, what each did and where it stands is a run of its own machine."""
        machines = Machines()
        found = checker().check_property(process, "deadlock free").counterexample
        if found is None:
            return
        network = machines.packed(process, Budget(Limits())).network
        if network.formats > 1:
            return
        assert len(found.components) == len(network.slots)
        for part, slot in zip(found.components, network.slots, strict=True):
            assert len(part.trace) == len(found.trace)
            rows = [
                {(EVENTS.name(local_event(network, label)), target) for label, target in slot.lts.successors(s)}
                for s in range(slot.lts.states)
            ]
            reached = {slot.lts.root}
            for name in part.trace:
                if name is not None:
                    reached = {t for s in reached for label, t in rows[s] if label == name}
            assert any(set(part.offers) == {label for label, _ in rows[s]} for s in reached)
