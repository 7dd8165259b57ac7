"""Places that are joined: held against NetworkX."""

from __future__ import annotations

import networkx
from hypothesis import given, settings, strategies as st

from cspcheck.checker.network.placement import first_of_joined
from tests.examples import examples

NUMBERS = st.integers(0, 9)


@given(st.lists(st.tuples(NUMBERS, NUMBERS), max_size=12))
@settings(max_examples=examples(200))
def test_joined_as_the_components_of_a_graph(pairs: list[tuple[int, int]]) -> None:
    """Whoever can be reached along the pairs has the same first one."""
    graph = networkx.Graph(pairs)
    graph.add_nodes_from(range(10))
    first = {one: min(together) for together in networkx.connected_components(graph) for one in together}
    assert first_of_joined(10, pairs) == [first[one] for one in range(10)]


def test_nothing_is_joined() -> None:
    """Not even one place."""
    assert first_of_joined(0, []) == []
