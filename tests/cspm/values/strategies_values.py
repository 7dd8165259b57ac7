"""Hypothesis strategies for values: each with what it is in plain Python."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

from cspcheck.cspm.values.sets import set_of
from cspcheck.cspm.values.thunks import Thunk
from cspcheck.cspm.values.values import FALSE, TRUE, Map, Sequence

integers = st.integers(-5, 20)
booleans = st.sampled_from([FALSE, TRUE])
characters = st.sampled_from("abcz'\"\\\n")
atoms = st.one_of(integers, booleans, characters)


def values(depth: int = 2) -> st.SearchStrategy[Any]:
    """Any values of data, evaluated."""
    if depth == 0:
        return atoms
    inner = values(depth - 1)
    return st.one_of(
        atoms,
        st.lists(inner, max_size=4).map(Sequence.of),
        st.lists(inner, max_size=4).map(set_of),
        st.lists(inner, min_size=2, max_size=3).map(tuple),
        st.dictionaries(inner, inner, max_size=3).map(Map),
    )


@st.composite
def sequences(draw: st.DrawFn, items: st.SearchStrategy[Any] = integers) -> tuple[Sequence, list[Any]]:
    """A sequence in some state of evaluation, and its elements."""
    expected = draw(st.lists(items, max_size=8))
    return _built(draw, expected), expected


def _built(draw: st.DrawFn, items: list[Any]) -> Sequence:
    way = draw(st.integers(0, 4))
    if way == 0 or not items:
        return Sequence.of(items)
    if way == 1:
        result = Sequence.of(())
        for item in reversed(items):
            result = result.cons(item)
        return result
    cut = draw(st.integers(0, len(items)))
    if way == 2:
        return _built(draw, items[:cut]).concat(_built(draw, items[cut:]))
    if way == 3:
        rest = _built(draw, items[cut:])
        return Sequence.lazy(list(items[:cut]), Thunk(lambda env: rest, ()))
    longer = _built(draw, [0, *items])
    step = longer.uncons()
    assert step is not None
    tail = step[1]
    return tail.force() if isinstance(tail, Thunk) else tail  # type: ignore[no-any-return]
