"""The part of a search that is told of: the states that matter, taken out of more than one process can hold.

Of a search whose rows are on disk, or with others, only the shortest ways to what was found are needed in memory: the
states of the level that are deadlocked, that violate a specification or that lie on cycles of taus, and before them
those from which taus and one visible event a level lead there. Canonical paths through the part are those through the
whole, for all shortest ways are in it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Protocol

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int64Array, distinct
from cspcheck.checker.kernels.jit import Kernels
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.findings import Findings
from cspcheck.checker.search.pairs import Pairs
from cspcheck.checker.search.tau_cycles import tau_cyclic_states
from cspcheck.checker.search.visited import Visited
from cspcheck.checker.search.walk import CHUNK, Walk, refusing_rows, transitions_of


class Whole(Protocol):
    """The rows of a search, wherever they are."""

    def blocks(self, level: int) -> Iterator[Int64Array]:
        """The rows of a level that this process looks at, some at a time, flat."""

    def all_of(self, rows: Int64Array) -> Int64Array:
        """The rows that the processes have found, together."""

    def cyclic(self, level: int) -> Int64Array:
        """Rows of a level, flat: at least those that lie on cycles of taus, if they can be held."""


class Rows:
    """A set of rows in memory."""

    def __init__(self, compiled: Kernels, stride: int) -> None:
        self.visited = Visited(stride)
        self._kernels = compiled

    def add(self, rows: Int64Array) -> None:
        """Add rows, flat."""
        count = len(rows) // self.visited.stride
        rows, place = np.ascontiguousarray(rows), 0
        while True:
            place = self.visited.insert(self._kernels, rows, place, count)
            if place == count:
                return
            self.visited.grow(self._kernels)

    def numbers(self, rows: Int64Array) -> Int64Array:
        """The number of each row, in the order in which they were added; -1 of those that were not."""
        count = len(rows) // self.visited.stride
        numbers: Int64Array = np.full(count, -1, dtype=np.int64)
        self.visited.find(self._kernels, np.ascontiguousarray(rows), count, numbers)
        return numbers

    def has(self, rows: Int64Array) -> BoolArray:
        """Which of some rows are in the set."""
        found: BoolArray = self.numbers(rows) >= 0
        return found


class Part:
    """Takes the part out of a search.

    Args:
        compiled: the kernels, in either form.
        found: the search.
        whole: its rows.
    """

    def __init__(self, compiled: Kernels, found: Findings, whole: Whole) -> None:
        self._packed = found.packed
        self._pairs = found.pairs
        self._found = found
        self._whole = whole
        self._stride = found.visited.stride
        self._kernels = compiled

    def ways(self) -> Walk:
        """The ways to what was found first; the walk has as many levels as the search, empty ones at its end."""
        found = self._found
        marked: list[Int64Array] = []
        ahead = Rows(self._kernels, self._stride)
        for level in range(len(found.levels) - 2, -1, -1):
            goals: list[Int64Array] = []
            if level == found.deadlock_level:
                goals += self._chosen(level, self._deadlocked)
            if level == found.violation_level:
                goals += self._chosen(level, self._violating)
            if level == found.told_divergence:
                goals.append(self._whole.cyclic(level))
            if ahead.visited.known:
                goals += self._chosen(level, partial(self._leading, goals=ahead, visible=True))
            if level == 0:
                goals.append(found.initial)
            here = Rows(self._kernels, self._stride)
            here.add(self._whole.all_of(_joined(goals)))
            self._close_under_tau(level, here)
            marked.append(here.visited.states.reshape(-1).copy())
            ahead = here
        return self._walk(marked[::-1])

    def _walk(self, rows: Sequence[Int64Array]) -> Walk:
        taken = Rows(self._kernels, self._stride)
        # The first row is where paths begin.
        taken.add(self._found.initial)
        ends = [0]
        for level in rows:
            taken.add(level)
            ends.append(taken.visited.known)
        return Walk(self._packed, self._pairs, taken.visited, tuple(ends))

    def _chosen(self, level: int, choose: Callable[[Int64Array], Int64Array]) -> list[Int64Array]:
        found: list[Int64Array] = []
        for block in self._whole.blocks(level):
            for place in range(0, len(block), CHUNK * self._stride):
                rows = block[place : place + CHUNK * self._stride]
                chosen = choose(rows)
                if len(chosen):
                    found.append(rows.reshape(-1, self._stride)[chosen].reshape(-1))
        return found

    def _deadlocked(self, rows: Int64Array) -> Int64Array:
        size = len(rows) // self._stride
        moving = transitions_of(self._packed, self._pairs, rows).sources
        idle = np.flatnonzero(np.bincount(moving, minlength=size) == 0)
        return idle[~self._packed.are_terminated(rows.reshape(size, self._stride)[idle])]

    def _violating(self, rows: Int64Array) -> Int64Array:
        assert self._pairs is not None
        found = transitions_of(self._packed, self._pairs, rows, [self._packed.visible])
        return distinct(
            np.concatenate([found.sources[found.nodes < 0], refusing_rows(self._packed, self._pairs, rows)])
        )

    def _leading(self, rows: Int64Array, goals: Rows, *, visible: bool) -> Int64Array:
        """Which rows lead to a goal by one transition."""
        walk = Walk(self._packed, self._pairs, goals.visited, (0,))
        found = walk.moves(rows, [self._packed.visible if visible else self._packed.tau])
        return distinct(found.sources[goals.has(found.targets)])

    def _close_under_tau(self, level: int, here: Rows) -> None:
        """Add the rows of a level from which taus lead to those that are there."""
        while here.visited.known and len(self._packed.tau.items):
            before = here.visited.known
            found = self._chosen(level, partial(self._leading, goals=here, visible=False))
            here.add(self._whole.all_of(_joined(found)))
            if here.visited.known == before:
                return


def _joined(parts: list[Int64Array]) -> Int64Array:
    return np.concatenate([np.zeros(0, dtype=np.int64), *parts])


def cyclic_rows(packed: PackedNetwork, pairs: Pairs | None, left: Visited) -> Int64Array:
    """Those of some rows of a level that lie on cycles of taus, flat."""
    walk = Walk(packed, pairs, left, (0, left.known))
    return walk.rows(tau_cyclic_states(walk, 0))
