"""Typed data: what is outside its range is said with owner, variable, value and range."""

from __future__ import annotations

from enum import Enum
from typing import ClassVar

import pytest

from cspcheck.codegen.runtime import (
    BOOLEANS,
    Constructed,
    DataType,
    Integers,
    Members,
    OutOfRange,
    Reals,
    Sequences,
    Sets,
    Tagged,
    Tuples,
    Variables,
)


class Colour(Enum):
    RED = "red"
    GREEN = "green"


DATA = Integers(0, 10, "DATA")
COLOURS = Members(tuple(Colour), "Colour")
MESSAGES = Constructed((("Empty", ()), ("Full", (DATA, COLOURS))), "Message")


class State(Variables):
    OWNER = "Producer"
    TYPES: ClassVar[dict[str, DataType]] = {"my_data": DATA, "colour": COLOURS}
    my_data: int
    colour: Colour


@pytest.mark.parametrize(
    ("declared", "inside", "outside"),
    [
        (DATA, [0, 10], [-1, 11, True, 1.0, "1"]),
        (Integers(), [-(10**30), 0], [1.0]),
        (Reals(0.0, 360.0), [0, 0.5, 360.0], [-0.1, float("nan"), float("inf"), True, "x"]),
        (BOOLEANS, [True, False], [1, 0]),
        (COLOURS, [Colour.RED], ["red", 1, []]),
        (Tuples((DATA, BOOLEANS)), [(1, True)], [(1, 1), (11, True), (1,), [1, True]]),
        (Sequences(DATA, 2), [(), (1, 2)], [(1, 2, 3), (11,), [1]]),
        (Sets(DATA), [frozenset(), frozenset({1, 2})], [{1}, frozenset({11})]),
        (MESSAGES, [Tagged("Empty"), Tagged("Full", (3, Colour.RED))], [Tagged("Full"), Tagged("No"), "Empty"]),
    ],
)
def test_membership(declared: DataType, inside: list[object], outside: list[object]) -> None:
    assert [declared.contains(value) for value in inside] == [True] * len(inside)
    assert [declared.contains(value) for value in outside] == [False] * len(outside)
    assert declared.contains(declared.default)


def test_what_can_be_listed_is_what_belongs() -> None:
    for declared, count in [
        (DATA, 11),
        (COLOURS, 2),
        (Tuples((DATA, BOOLEANS)), 22),
        (Sequences(BOOLEANS, 3), 15),
        (Sets(COLOURS), 4),
        (MESSAGES, 23),
    ]:
        values = list(declared.values() or ())
        assert len(values) == len(set(values)) == count
        assert all(map(declared.contains, values))
    assert Reals().values() is None
    assert Integers(0).values() is None
    assert Sequences(DATA).values() is None


def test_values_are_printed_as_a_specification_writes_them() -> None:
    assert Sequences(DATA).text((1, 2)) == "<1, 2>"
    assert Tuples((DATA, BOOLEANS)).text((1, True)) == "(1, true)"
    assert Sets(COLOURS).text(frozenset(Colour)) == "{green, red}"
    assert MESSAGES.text(Tagged("Full", (3, Colour.RED))) == "Full.3.red"


def test_every_assignment_is_checked() -> None:
    state = State()
    assert (state.my_data, state.colour) == (0, Colour.RED)
    state.my_data = 10
    with pytest.raises(OutOfRange) as raised:
        state.my_data = 11
    assert str(raised.value) == "Producer: my_data = 11 is outside DATA = 0..10"
    with pytest.raises(OutOfRange) as raised:
        state.my_data = "7"  # type: ignore[assignment]
    assert str(raised.value) == "Producer: my_data = '7' (str) is outside DATA = 0..10"
    assert state.my_data == 10
    with pytest.raises(AttributeError, match="Producer has no variable 'mydata'"):
        state.mydata = 1
    with pytest.raises(AttributeError, match="Producer has no variable 'x'"):
        State(x=1)
    with pytest.raises(OutOfRange):
        State(my_data=-1)
