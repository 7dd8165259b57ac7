"""The order in which declarations are typed, held against the components that a library finds."""

from __future__ import annotations

from itertools import pairwise

import networkx
from hypothesis import given, strategies as st

from cspcheck.cspm.naming.resolve import resolve
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.source import Source
from cspcheck.cspm.typing.inference.dependencies import components, units_of

NAMES = [f"f{i}" for i in range(7)]


@given(st.lists(st.sets(st.sampled_from(NAMES)), min_size=len(NAMES), max_size=len(NAMES)))
def test_users_come_behind_what_they_use_and_together_with_what_uses_them(uses: list[set[str]]) -> None:
    text = "".join(f"{name} = {' + '.join(['1', *sorted(used)])}\n" for name, used in zip(NAMES, uses, strict=True))
    tree = parse(Source("x.csp", text))
    names = resolve(tree)
    found = [
        [unit.declaration.span.text.split()[0] for unit in component]
        for component in components(units_of(tree.declarations, names))
    ]

    graph = networkx.DiGraph((name, other) for name, used in zip(NAMES, uses, strict=True) for other in used)
    graph.add_nodes_from(NAMES)
    expected = {frozenset(component) for component in networkx.strongly_connected_components(graph)}
    assert {frozenset(component) for component in found} == expected
    assert sum(map(len, found)) == len(NAMES)
    place = {name: i for i, component in enumerate(found) for name in component}
    assert all(place[name] >= place[other] for name, other in graph.edges)
    assert all(NAMES.index(a) < NAMES.index(b) for component in found for a, b in pairwise(component))
