"""Cycles of components that wait for each other: held against all simple cycles that NetworkX finds."""

from __future__ import annotations

import networkx
from hypothesis import given, settings, strategies as st

from cspcheck.checker.explain.blocked_slots import shortest_cycle
from tests.examples import examples

SLOTS = st.integers(0, 6)


@given(st.dictionaries(SLOTS, st.sets(SLOTS, min_size=1), max_size=7))
@settings(max_examples=examples(200))
def test_the_shortest_cycle_from_the_earliest_slot(waits_for: dict[int, set[int]]) -> None:
    """There is none that is shorter, and none as short with an earlier slot."""
    graph = networkx.DiGraph([(slot, other) for slot, others in waits_for.items() for other in others])
    cycles = list(networkx.simple_cycles(graph))
    found = shortest_cycle(waits_for)
    if not cycles:
        assert found is None
        return
    assert found is not None
    shortest = min(map(len, cycles))
    assert len(found) == shortest == len(set(found))
    assert all(other in waits_for[slot] for slot, other in zip(found, (*found[1:], found[0]), strict=True))
    assert found[0] == min(slot for cycle in cycles if len(cycle) == shortest for slot in cycle)
