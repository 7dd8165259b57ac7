"""A priority over a composition is a network whose rules give way to each other: the machine of the terms."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.checker.network.compiler import Compiler, compile_network
from cspcheck.checker.packing.packed import pack
from cspcheck.checker.search import exploration
from cspcheck.checker.semantics.transitions import explore
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.events import FIRST_EVENT, EventSet
from cspcheck.cspm.process.terms import External, Hide, Parallel, Prioritised, Process, Rename
from tests.checker.exploring import rows_of, strongly_bisimilar
from tests.checker.network.test_composition import assert_same_machine, loop
from tests.checker.terms import compositions, event_sets, layered
from tests.examples import examples

a, b, c = FIRST_EVENT, FIRST_EVENT + 1, FIRST_EVENT + 2
NOTHING = EventSet()


def by_levels(process: Process, levels: Sequence[EventSet]) -> Process:
    return Prioritised(process, tuple(levels))


def by_order(process: Process, *pairs: tuple[int, int], maximal: EventSet = NOTHING) -> Process:
    return External("prioritisepo", process, (EventSet.of([a, b, c]), frozenset(pairs), maximal))


levels = st.lists(event_sets(3), min_size=1, max_size=3)
orders = st.sampled_from([(), ((a, b),), ((a, b), (a, c)), ((a, b), (b, c), (a, c))])
wholes = st.one_of(compositions(size=5, components=4), layered(size=5))


@st.composite
def prioritised(draw: st.DrawFn) -> Process:
    """A priority over a composition, often with hiding and renaming around it."""
    process = draw(wholes)
    if draw(st.booleans()):
        process = by_levels(process, draw(levels))
    else:
        process = by_order(process, *draw(orders), maximal=EventSet.of([a]) if draw(st.booleans()) else NOTHING)
    if draw(st.booleans()):
        process = Rename(process, ((a, b), (a, c)) if draw(st.booleans()) else ((b, a),))
    return Hide(process, draw(event_sets(3))) if draw(st.booleans()) else process


class TestSameMachine:
    @settings(max_examples=examples(150), deadline=None)
    @given(prioritised())
    def test_of_any_composition(self, process: Process) -> None:
        assert_same_machine(process)

    @settings(max_examples=examples(100), deadline=None)
    @given(prioritised())
    def test_of_small_components(self, process: Process) -> None:
        assert_same_machine(process, lambda term: Compiler(slot_states=3).network(term, Limits(states=5_000)))

    @pytest.mark.parametrize("products", [False, True])
    @settings(max_examples=examples(80), deadline=None)
    @given(process=prioritised())
    def test_of_packed_states(self, process: Process, products: bool) -> None:
        """With rules as masks and as products of tables, one word a state and several."""
        expected = explore(process, Limits(states=2_000)).lts
        packed = pack(compile_network(process), instances_per_rule=0 if products else 4_096)
        found = exploration.explore(packed)
        assert (found.levels[-1], found.transitions) == (expected.states, expected.transitions)
        assert strongly_bisimilar(rows_of(found.to_lts()), rows_of(expected))


class TestRules:
    def test_of_levels(self) -> None:
        """Tau comes first, c before b, and a is not affected."""
        network = compile_network(
            by_levels(
                Parallel(NOTHING, (loop(a, 1), loop(b, 1), loop(c, 1))), [NOTHING, EventSet.of([c]), EventSet.of([b])]
            )
        )
        assert [(rule.result, rule.raises, rule.yields) for rule in network.rules] == [(a, 0, 0), (b, 4, 3), (c, 2, 1)]
        assert network.is_prioritised

    def test_what_is_hidden_outside_keeps_its_rank(self) -> None:
        both = by_levels(Parallel(NOTHING, (loop(a, 1), loop(b, 1))), [EventSet.of([a]), EventSet.of([b])])
        rules = compile_network(Hide(both, EventSet.of([a, b]))).rules
        assert [(rule.raises, rule.yields) for rule in rules] == [(1, 0), (2, 1)]

    def test_a_network_without_priority_has_none(self) -> None:
        assert not compile_network(Parallel(NOTHING, (loop(a, 1), loop(b, 1)))).is_prioritised

    def test_a_priority_that_bounds_what_is_endless_without_it(self) -> None:
        """What the priority never lets happen may have no end: then the whole is explored with it."""
        from tests.checker.terms import reference

        def more(n: int) -> Process:
            return reference(f"More({n})", lambda: prefix(b, more(n + 1)))

        process = by_levels(Parallel(NOTHING, (loop(a, 1), more(0))), [EventSet.of([a]), EventSet.of([b])])
        assert_same_machine(process, lambda term: compile_network(term, Limits(states=1_000)))
