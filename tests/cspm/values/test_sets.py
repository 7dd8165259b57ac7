"""Sets of every form obey the algebra of sets; the infinite ones as far as a window of values can see."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any, TypeVar

import pytest
from hypothesis import given, strategies as st

from cspcheck.cspm.process.events import EventSet, EventTable
from cspcheck.cspm.values.dots import ChannelHead, Channels
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.set_algebra import difference, intersection, same, subset, union
from cspcheck.cspm.values.sets import EMPTY_SET, EventsSet, FiniteSet, Range, Set, event_set, set_of
from cspcheck.cspm.values.symbolic_sets import INTEGERS, Integers, Maps, Product, Sequences, Subsets
from cspcheck.cspm.values.text import show
from cspcheck.cspm.values.values import FALSE, TRUE, Map, Sequence

T = TypeVar("T")
WINDOW = range(-3, 12)
"""The integers by which infinite sets are told apart."""

listed = st.frozensets(st.integers(-2, 8), max_size=6).map(set_of)
ranges = st.tuples(st.integers(-2, 6), st.integers(-2, 8)).map(lambda pair: Range(*pair))
endless = st.one_of(st.just(INTEGERS), st.integers(-2, 8).map(Integers))


@st.composite
def unions(draw: st.DrawFn) -> Set:
    return union(draw(endless), draw(st.one_of(listed, ranges)))


integer_sets = st.one_of(listed, ranges, endless, unions())


def seen(found: Set) -> frozenset[int]:
    """The elements of a set of integers inside the window."""
    return frozenset(x for x in WINDOW if found.contains(x))


@given(integer_sets, integer_sets)
def test_union_intersection_difference_and_inclusion(a: Set, b: Set) -> None:
    assert seen(union(a, b)) == seen(a) | seen(b)
    assert seen(intersection(a, b)) == seen(a) & seen(b)
    assert subset(a, union(a, b))
    assert subset(intersection(a, b), b)
    # Of all integers, and of what has no least element, nothing can be taken away that could be written down.
    left = decided(lambda: difference(a, b), not a.contains(-(10**9)))
    if left is not None:
        assert seen(left) == seen(a) - seen(b)
        assert intersection(left, b).is_empty()
    assert subset(a, b) == (seen(a) <= seen(b) and _ends(a, b))


def decided(question: Callable[[], T], must_be: bool) -> T | None:
    """The answer to a question about sets; None if it was refused, which it must not be for finite ones."""
    refused: Failure
    try:
        return question()
    except Failure as failure:
        refused = failure
    assert refused.diagnostic.code == "CSP412"
    assert not must_be
    return None


def _ends(a: Set, b: Set) -> bool:
    """Whether what a holds beyond the window b holds too."""
    return a.is_finite() or not b.is_finite()


@given(integer_sets, integer_sets)
def test_equality(a: Set, b: Set) -> None:
    expected = seen(a) == seen(b) and a.is_finite() == b.is_finite() and lowest(a) == lowest(b)
    assert same(a, b) == expected


def lowest(found: Set) -> bool:
    """Whether the set goes down without end."""
    return found.contains(-(10**9))


@given(integer_sets)
def test_finite_sets_are_listed_in_order(a: Set) -> None:
    if a.is_finite():
        assert a.elements() == sorted(seen(a))
        assert a.size() == len(seen(a))
        assert a.finite() == set_of(seen(a))
        assert hash(a.finite()) == hash(set_of(seen(a)))
    else:
        with pytest.raises(Failure):
            a.elements()


# --- sets made of other sets -----------------------------------------------------------------------------------

small = st.frozensets(st.integers(0, 3), max_size=3)


@given(small)
def test_subsets(items: frozenset[int]) -> None:
    found = Subsets(set_of(items))
    expected = {frozenset(c) for n in range(len(items) + 1) for c in itertools.combinations(items, n)}
    assert {frozenset(s.elements()) for s in found.elements()} == expected
    assert found.size() == len(expected)
    assert all(found.contains(set_of(s)) for s in expected)
    assert not found.contains(set_of([7]))
    assert same(found, set_of([set_of(s) for s in expected]))


@given(small, small)
def test_maps(keys: frozenset[int], values: frozenset[int]) -> None:
    found = Maps(set_of(keys), set_of(values))
    assert found.size() == (len(values) + 1) ** len(keys)
    elements = found.elements()
    assert len(set(elements)) == found.size()
    assert all(found.contains(m) for m in elements)
    assert not found.contains(Map({9: 9}))


@given(st.lists(small, min_size=2, max_size=3), st.sampled_from(["tuple", "dot"]))
def test_products(sets: list[frozenset[int]], kind: Any) -> None:
    found = Product(kind, tuple(set_of(s) for s in sets))
    expected = set(itertools.product(*sets))
    assert found.size() == len(expected)
    parts = [element if kind == "tuple" else element.parts for element in found.elements()]
    assert set(parts) == expected
    assert all(found.contains(element) for element in found.elements())


@given(small, st.lists(st.integers(0, 4), max_size=3))
def test_sequences_over_a_set(items: frozenset[int], sequence: list[int]) -> None:
    assert Sequences(set_of(items)).contains(Sequence.of(sequence)) is (set(sequence) <= items)
    assert Sequences(set_of(items)).is_finite() is (not items)


@given(small, small)
def test_inclusion_of_sets_made_of_others(a: frozenset[int], b: frozenset[int]) -> None:
    for form in (Sequences, Subsets):
        assert subset(form(set_of(a)), form(set_of(b))) is (a <= b)
        both = intersection(form(set_of(a)), form(set_of(b)))
        assert same(both, form(set_of(a & b)))


# --- sets of events --------------------------------------------------------------------------------------------


def channel(size: int) -> ChannelHead:
    channels = Channels(EventTable(show))
    head = ChannelHead("c", None, lambda: (Range(0, size - 1),), channels)
    assert head.declared.size == size
    return head


numbers = st.frozensets(st.integers(0, 19), max_size=12)


@given(numbers, numbers)
def test_sets_of_events_are_sets(a: frozenset[int], b: frozenset[int]) -> None:
    head = channel(20)

    def made(chosen: frozenset[int]) -> Set:
        return set_of([head.complete((n,)) for n in chosen])

    def back(found: Set) -> frozenset[int]:
        return frozenset(event.parts[1][0] for event in found.elements())

    assert back(union(made(a), made(b))) == a | b
    assert back(intersection(made(a), made(b))) == a & b
    assert back(difference(made(a), made(b))) == a - b
    assert subset(made(a), made(b)) is (a <= b)
    assert same(made(a), made(b)) is (a == b)
    assert (made(a) == made(b)) is (a == b)
    assert len(event_set(made(a))) == len(a)
    if a == b:
        assert hash(made(a)) == hash(made(b))
    assert set_of([made(a), made(b)]).size() == len({a, b})
    mixed = set_of([1, *made(a).elements()])
    assert difference(mixed, set_of([1])) == made(a)
    assert intersection(mixed, made(b)) == made(a & b)


def test_the_events_of_a_large_channel_are_one_range() -> None:
    head = channel(10**9)
    everything = EventsSet.of_ranges([(head.declared.base, head.declared.base + 10**9)], head.channels)
    assert everything.size() == 10**9
    one = set_of([head.complete((77,))])
    assert difference(everything, one).size() == 10**9 - 1
    assert union(difference(everything, one), one) == everything
    assert subset(one, everything)
    assert not difference(everything, one).contains(head.complete((77,)))


def test_an_empty_set_of_events_is_the_empty_set() -> None:
    head = channel(3)
    assert EventsSet.of(EventSet(), head.channels) is EMPTY_SET
    assert same(difference(set_of([head.complete((0,))]), set_of([head.complete((0,))])), EMPTY_SET)


def test_sets_of_mixed_values_keep_them_apart() -> None:
    assert set_of([0, FALSE, 1, TRUE]).size() == 4
    assert isinstance(set_of([0, FALSE]), FiniteSet)
    assert set_of([TRUE]) != set_of([1])


def test_what_cannot_be_listed_says_so() -> None:
    for found, code in ((INTEGERS, "CSP411"), (Subsets(Range(0, 40)), "CSP425"), (Range(0, 1 << 30), "CSP425")):
        with pytest.raises(Failure) as raised:
            found.elements()
        assert raised.value.diagnostic.code == code


ASTRONOMICAL = Range(1, 10**12)


@pytest.mark.parametrize(
    "large",
    [
        ASTRONOMICAL,
        Subsets(ASTRONOMICAL),
        Subsets(Subsets(Range(1, 100))),
        Maps(ASTRONOMICAL, Range(0, 1)),
        Maps(Range(0, 1), ASTRONOMICAL),
        Product("tuple", (ASTRONOMICAL, ASTRONOMICAL)),
    ],
)
def test_what_is_astronomical_is_compared_as_it_is_written_and_never_listed(large: Set) -> None:
    assert not large.is_empty()
    assert same(large, large)
    assert subset(large, large)
    assert not same(large, set_of([1]))
    assert not subset(large, set_of([1]))
    assert large.canonical() is large
    with pytest.raises(Failure) as refused:
        large.elements()
    assert refused.value.diagnostic.code == "CSP425"


@given(st.integers(0, 6), st.integers(0, 4), st.integers(0, 300))
def test_a_set_exceeds_what_is_less_than_its_size(a: int, b: int, limit: int) -> None:
    small, other = Range(1, a), Range(1, b)
    for found in (small, Subsets(small), Maps(small, other), Product("dot", (small, other))):
        assert found.exceeds(limit) == (len(found.elements()) > limit)
