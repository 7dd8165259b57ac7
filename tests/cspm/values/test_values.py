"""Values behave as what they stand for: sequences as lists, maps as dictionaries, Booleans as no numbers."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from cspcheck.cspm.values.comparison import equal, less
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.order import in_order, order_key
from cspcheck.cspm.values.sets import Set, set_of
from cspcheck.cspm.values.text import show, show_short
from cspcheck.cspm.values.thunks import Thunk, force
from cspcheck.cspm.values.values import FALSE, TRUE, Map, Sequence, counting_from, deep
from tests.cspm.values.strategies_values import integers, sequences, values
from tests.examples import examples

EMPTY = load(Source("empty.csp", ""), typecheck=False)


# --- sequences -----------------------------------------------------------------------------------------------


@given(sequences())
def test_a_sequence_has_its_elements(pair: tuple[Sequence, list[int]]) -> None:
    sequence, expected = pair
    assert sequence.is_empty() is (not expected)
    assert sequence.values() == expected
    assert len(sequence) == len(expected)


@given(sequences())
def test_taking_a_sequence_apart_from_the_front(pair: tuple[Sequence, list[int]]) -> None:
    sequence, expected = pair
    found: list[int] = []
    rest: Any = sequence
    while (step := force(rest).uncons()) is not None:
        found.append(force(step[0]))
        rest = step[1]
    assert found == expected
    assert sequence.values() == expected


@given(sequences(), sequences(), sequences(), integers)
def test_sequences_share_and_never_change(
    a: tuple[Sequence, list[int]], b: tuple[Sequence, list[int]], c: tuple[Sequence, list[int]], x: int
) -> None:
    made = [(a[0].concat(b[0]), a[1] + b[1]), (a[0].concat(c[0]), a[1] + c[1]), (c[0].concat(b[0]), c[1] + b[1])]
    made += [(b[0].cons(x), [x, *b[1]]), (b[0].cons(x + 1), [x + 1, *b[1]]), (b[0].cons(x), [x, *b[1]])]
    made += [(made[3][0].concat(made[4][0]), made[3][1] + made[4][1]), a, b, c]
    for sequence, expected in made:
        assert sequence.values() == expected


@given(sequences(), sequences())
def test_equality_order_and_hashes_of_sequences(a: tuple[Sequence, list[int]], b: tuple[Sequence, list[int]]) -> None:
    assert equal(a[0], b[0]) is (a[1] == b[1])
    assert less(a[0], b[0], strict=False) is (b[1][: len(a[1])] == a[1])
    assert less(a[0], b[0], strict=True) is (b[1][: len(a[1])] == a[1] and a[1] != b[1])
    again = Sequence.of(a[1])
    assert a[0] == again
    assert hash(deep(a[0])) == hash(again)


def test_an_endless_sequence_can_be_looked_at_but_not_to_its_end() -> None:
    numbers = counting_from(3)
    taken = []
    rest: Any = numbers
    for _ in range(100):
        step = force(rest).uncons()
        taken.append(step[0])
        rest = step[1]
    assert taken == list(range(3, 103))
    for look in (len, deep, list):
        with pytest.raises(Failure):
            look(numbers)  # type: ignore[operator]
    assert not equal(numbers, Sequence.of([3, 4]))
    assert less(Sequence.of([3, 4]), numbers, strict=True)


def test_elements_are_evaluated_when_they_are_needed() -> None:
    asked: list[int] = []

    def element(i: int) -> Thunk:
        return Thunk(lambda env: asked.append(i) or i, ())  # type: ignore[func-returns-value]

    sequence = Sequence.of([element(1), element(2), element(3)])
    assert len(sequence) == 3
    assert asked == []
    assert equal(sequence, Sequence.of([1, 7, 3])) is False
    assert asked == [1, 2]
    assert sequence == Sequence.of([1, 2, 3])
    assert asked == [1, 2, 3]


def test_a_tail_and_a_new_head_cost_no_copy() -> None:
    sequence = Sequence.of(range(1000))
    step = sequence.uncons()
    assert step is not None
    assert step[1]._items is sequence._items
    assert step[1].cons(0)._items is sequence._items


# --- any values ----------------------------------------------------------------------------------------------


@given(values(), values())
def test_equal_values_have_equal_hashes_and_one_order(a: Any, b: Any) -> None:
    assert equal(a, b) is (a == b)
    if a == b:
        assert hash(a) == hash(b)
        assert order_key(a) == order_key(b)
    else:
        assert order_key(a) != order_key(b)


@given(st.lists(values(), max_size=8), st.randoms(use_true_random=False))
def test_the_order_does_not_depend_on_where_one_begins(found: list[Any], random: Any) -> None:
    shuffled = list(found)
    random.shuffle(shuffled)
    assert in_order(shuffled) == in_order(found)


@settings(max_examples=examples(500))
@given(values())
def test_what_is_shown_is_read_back_as_the_same_value(value: Any) -> None:
    read = EMPTY._evaluator.run(lambda: deep(EMPTY._evaluator.value(EMPTY._tied(show(value))[0], EMPTY._top)(())))
    assert read == value


@given(values())
def test_a_value_in_few_words(value: Any) -> None:
    assert len(show_short(value, 20)) <= 20 + 15


def test_one_is_not_true() -> None:
    assert not equal(1, TRUE)
    assert set_of([1, TRUE]).size() == 2
    assert set_of([(1, 0), (TRUE, FALSE)]).size() == 2
    assert len({Sequence.of([1]): 0, Sequence.of([TRUE]): 1}) == 2
    assert len({Map({1: 0}), Map({TRUE: 0})}) == 2


@given(st.dictionaries(integers, integers, max_size=5), st.dictionaries(integers, integers, max_size=5))
def test_maps_are_ordered_by_what_they_hold(a: dict[int, int], b: dict[int, int]) -> None:
    assert equal(Map(a), Map(b)) is (a == b)
    smaller = all(key in b and a[key] <= b[key] for key in a)
    assert less(Map(dict(a)), Map(dict(b)), strict=False) is smaller
    assert less(Map(dict(a)), Map(dict(b)), strict=True) is (smaller and a != b)


@given(st.tuples(integers, integers, integers), st.tuples(integers, integers, integers))
def test_tuples_are_ordered_lexicographically(a: tuple[int, ...], b: tuple[int, ...]) -> None:
    assert less(a, b, strict=True) is (a < b)
    assert less(a, b, strict=False) is (a <= b)


# --- thunks --------------------------------------------------------------------------------------------------


def test_a_thunk_is_evaluated_once() -> None:
    asked: list[int] = []
    thunk = Thunk(lambda env: asked.append(env[0]) or env[0], (5,))  # type: ignore[func-returns-value]
    assert [thunk.force(), thunk.force(), force(thunk)] == [5, 5, 5]
    assert asked == [5]


def test_a_thunk_that_fails_fails_again() -> None:
    script = load(Source("x.csp", "x = 1 / 0\nf(y) = 0"))
    for _ in range(2):
        with pytest.raises(ScriptError) as raised:
            script.evaluate("x")
        assert raised.value.diagnostics[0].code == "CSP401"
    assert script.evaluate("f(x)") == 0


def test_a_thunk_that_needs_itself_says_so() -> None:
    thunk = Thunk(lambda env: env, ())
    thunk.code = lambda env: thunk.force()
    with pytest.raises(Failure) as raised:
        thunk.force()
    assert raised.value.diagnostic.code == "CSP421"


@given(values(1))
def test_sets_hold_what_was_put_in(value: Any) -> None:
    found = set_of([value])
    assert isinstance(found, Set)
    assert found.contains(value)
    assert found.elements() == [value]
