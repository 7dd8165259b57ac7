"""What is known of how a process treats the values of one type."""

from __future__ import annotations

from dataclasses import dataclass


class Dependent(Exception):
    """A process may depend on how many values the type has, or on which they are; the text says why."""


def total(counts: list[int | None]) -> int | None:
    """The sum of some numbers; None where one is not known."""
    found = 0
    for count in counts:
        if count is None:
            return None
        found += count
    return found


@dataclass(slots=True)
class Use:
    """How a process that is data independent in a type treats its values.

    Attributes:
        tests: whether it may compare two of them, be it because two parties must output the same.
        chosen: the most new values of one step that are not fields of its event; None: no bound is known.
    """

    tests: bool = False
    chosen: int | None = 0

    def choose(self, count: int | None) -> None:
        """A step may choose so many new values."""
        self.chosen = None if count is None or self.chosen is None else max(self.chosen, count)


@dataclass(frozen=True, slots=True)
class DataUse:
    """How the data part of a class treats the values of a type.

    Attributes:
        tests, chosen: as in :class:`Use`.
        held: the most values that a state holds; None: no bound is known.
        outputs: the channels on which it says what value it is.
        normal: whether its state is determined by what has happened.
    """

    tests: bool
    chosen: int | None
    held: int | None
    outputs: frozenset[str]
    normal: bool
