"""Places for the values of an infinite type: numbers that keep the order of the values, whichever is met first.

Small integers lie at fixed places in the middle. All other values are placed between their neighbours among those that
have a place already, with gaps left for what may come between (order maintenance by labels; Dietz and Sleator, 1987,
without the relabelling: an event keeps its number). So the order of two places never depends on what else was met.
Where no gap is left a value has no place.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Hashable
from typing import Any

_NEAR = 16
"""A value right beside the one placed last takes this part of the gap: more like it are likely to follow."""


class Places:
    """Places in ``range(width)`` for the values of one field; *order* is a key that compares as the values do."""

    def __init__(self, width: int, order: Callable[[Any], Any]) -> None:
        self._width = width
        self._order = order
        self._first = -(width >> 2)
        self._middle = width >> 1
        self._step = 1 << (width.bit_length() // 2)  # between values that grow, each behind the last
        self._known: dict[Hashable, int | None] = {}
        self._values: dict[int, Hashable] = {}
        self._keys: list[Any] = []
        self._places: list[int] = []
        self._last = -1

    def __len__(self) -> int:
        return self._width

    def place(self, value: Hashable) -> int | None:
        """The place of a value, the same each time; None if there is none left for it."""
        if type(value) is int and self._first <= value < -self._first:
            return self._middle + value
        if value not in self._known:
            found = self._known[value] = self._between(self._order(value))
            if found is not None:
                self._values[found] = value
        return self._known[value]

    def _between(self, key: Any) -> int | None:
        position = bisect_left(self._keys, key)
        before = key < self._order(0)
        low, high = (-1, self._middle + self._first) if before else (self._middle - self._first - 1, self._width)
        left = max(low, self._places[position - 1]) if position else low
        right = min(high, self._places[position]) if position < len(self._places) else high
        gap = right - left
        if gap < 2:
            return None
        if left == low and right == high:
            place = left + gap // 2
        elif right == high:
            place = left + min(self._step, gap // 2)
        elif left == low:
            place = right - min(self._step, gap // 2)
        elif left == self._last:
            place = left + max(gap // _NEAR, 1)
        elif right == self._last:
            place = right - max(gap // _NEAR, 1)
        else:
            place = left + gap // 2
        self._keys.insert(position, key)
        self._places.insert(position, place)
        self._last = place
        return place

    def value(self, place: int) -> Hashable:
        """The value at a place. Raises KeyError if there is none."""
        number = place - self._middle
        return number if self._first <= number < -self._first else self._values[place]
