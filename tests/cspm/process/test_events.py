"""Events of infinite types: the order of their identifiers is that of their values, whichever is met first."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given, strategies as st

from cspcheck.cspm.process.events import TAU, TICK, UNBOUNDED, EventTable, FieldDomain
from cspcheck.cspm.process.places import Places


def order(value: object) -> list[object]:
    """As the language orders its values: flat lists that begin with the kind."""
    return [4, *value] if isinstance(value, tuple) else [1, value]


NUMBERS = st.one_of(st.integers(-9, 9), st.integers(), st.integers(-(10**30), 10**30))
SEQUENCES = st.lists(st.integers(0, 2), max_size=8).map(tuple)


@given(st.lists(NUMBERS, unique=True), st.randoms(use_true_random=False))
def test_identifiers_keep_the_order_of_numbers(numbers, random) -> None:
    table = EventTable()
    channel = table.declare("n", [None])
    after = table.declare("after")
    met = list(numbers)
    random.shuffle(met)
    identifiers = {number: table.event(channel, [number]) for number in met}
    assert [identifiers[number] for number in sorted(met)] == sorted(identifiers.values())
    assert all(table.parts(identifiers[number]) == (channel, (number,)) for number in met)
    assert all(1 < identifier < after.base for identifier in identifiers.values())


@given(st.lists(st.tuples(st.integers(0, 3), SEQUENCES, NUMBERS), unique=True))
def test_identifiers_keep_the_order_of_the_fields(met) -> None:
    table = EventTable(order=order)
    channel = table.declare("m", [FieldDomain(range(4)), None, None])
    identifiers = {fields: table.event(channel, fields) for fields in met}
    placed = [fields for fields in met if identifiers[fields] < UNBOUNDED]
    assert sorted(placed, key=identifiers.__getitem__) == sorted(placed)
    assert len(met) > 5 or placed == met
    assert all(table.parts(number) == (channel, fields) for fields, number in identifiers.items())


def test_values_that_grow_or_shrink_do_not_run_out_of_places() -> None:
    """The habits of endless models: counting up beyond 64 bits, and sequences that get longer, at both ends."""
    for values in (
        [2**60 + i for i in range(5_000)],
        [-(2**60) - i for i in range(5_000)],
        [(0,) * i for i in range(200)],
        [(0,), (1,), *[(0,) * i for i in range(2, 150)]],
        [(1,), *[(*[0] * i, 1) for i in range(1, 150)]],
    ):
        places = Places(1 << 50, order)
        found = {value: places.place(value) for value in values}
        assert None not in found.values()
        assert all(found[left] < found[right] for left, right in pairwise(sorted(values, key=order)))


def test_without_a_place_an_event_is_numbered_as_it_is_met() -> None:
    """Thirteen fields leave four bits for each; the events stay different ones."""
    few = EventTable()
    narrow = few.declare("n", [None] * 13)
    numbers = [few.event(narrow, [100 + i, *[0] * 12]) for i in range(60)]
    assert max(numbers) >= UNBOUNDED
    assert len(set(numbers)) == 60
    assert [few.parts(number)[1][0] for number in numbers] == [100 + i for i in range(60)]


def test_one_channel_of_too_many_events_keeps_their_order() -> None:
    table = EventTable()
    channel = table.declare("c", [FieldDomain(range(10**6))] * 4)
    assert channel.size is None
    met = [(5, 0, 0, 0), (4, 999_999, 999_999, 3), (4, 999_999, 999_999, 2), (0, 0, 0, 1)]
    assert sorted(met, key=lambda fields: table.event(channel, fields)) == sorted(met)


def test_the_missing_finite_fields_of_an_infinite_channel_are_a_range() -> None:
    table = EventTable()
    channel = table.declare("dd", [None, FieldDomain("ab")])
    found = table.completions(channel, [10**40])
    assert [table.parts(number)[1] for number in found] == [(10**40, "a"), (10**40, "b")]
    assert list(found) == [table.event(channel, [10**40, "a"]), table.event(channel, [10**40, "b"])]


def test_what_happens_inside_has_a_name_that_no_channel_has() -> None:
    table = EventTable()
    assert (table.name(TAU), table.name(TICK)) == ("tau", "tick")
    mine = [table.declare("tau"), table.declare("tick")]
    assert [table.name(table.event(channel)) for channel in mine] == ["tau", "tick"]
    assert (table.name(TAU), table.name(TICK)) == ("τ", "✓")
