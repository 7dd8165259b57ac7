"""Walking about in what a search has found: the transitions of chosen rows, again and in detail."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int64Array, distinct
from cspcheck.checker.kernels.arrays import Index
from cspcheck.checker.kernels.jit import Kernels, kernels_for
from cspcheck.checker.kernels.pairs import REFUSAL
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.expansion import Expander
from cspcheck.checker.search.pairs import Pairs
from cspcheck.checker.search.visited import Visited
from cspcheck.checker.sparse_rows import gather_rows
from cspcheck.cspm.process.events import TAU

CHUNK = 1 << 16
"""Rows that are expanded in detail at a time."""
FEW = 1 << 12
"""Of so few rows all transitions are kept: a path through them asks for the same ones again and again."""


@dataclass(frozen=True, eq=False, slots=True)
class Transitions:
    """Transitions of some rows, with those that several rules give once for each.

    Attributes:
        sources: shape (transitions,): which of the rows, ascending.
        events: dense events.
        rules: rules of the network.
        targets: flat rows. Where the specification forbids the event, the row has the node from before.
        nodes: the specification's nodes afterwards, -1 where it forbids the event; 0 without a specification.
    """

    sources: Int64Array
    events: Int64Array
    rules: Int64Array
    targets: Int64Array
    nodes: Int64Array

    def select(self, chosen: BoolArray | Int64Array) -> Transitions:
        """Some of them."""
        stride = len(self.targets) // max(1, len(self.sources))
        targets = self.targets.reshape(len(self.sources), stride)[chosen].reshape(-1)
        return Transitions(self.sources[chosen], self.events[chosen], self.rules[chosen], targets, self.nodes[chosen])


def transitions_of(
    packed: PackedNetwork, pairs: Pairs | None, rows: Int64Array, indexes: Sequence[Index] | None = None
) -> Transitions:
    """All transitions of the given flat rows: by the taus first, then by the visible events, or by chosen indexes."""
    stride = packed.words if pairs is None else pairs.stride
    size = len(rows) // stride
    kernels = kernels_for(size)
    rows = np.ascontiguousarray(rows)
    made = Expander.for_rows(packed, stride, size)
    parts: list[tuple[Int64Array, Int64Array, Int64Array, Int64Array]] = []
    for index in (packed.tau, packed.visible) if indexes is None else indexes:
        first = 0
        while first < size and len(index.items):
            reached = made.run(kernels, index, rows, first, size)
            count = made.count
            sources = np.repeat(np.arange(first, reached), np.diff(made.offsets[: made.rows + 1]))
            events, fired = made.events[:count].astype(np.int64), made.fired[:count].astype(np.int64)
            parts.append((sources, events, fired, made.targets[: count * stride].copy()))
            first = reached
    sources, events, fired, targets = (
        (np.concatenate([np.zeros(0, dtype=np.int64), *columns]) for columns in zip(*parts, strict=True))
        if parts
        else (np.zeros(0, dtype=np.int64),) * 4
    )
    found = Transitions(sources, events, fired, targets, np.zeros(len(sources), dtype=np.int64))
    if pairs is not None:
        found = _with_nodes(kernels, pairs, rows, found)
    order = np.argsort(sources, kind="stable")
    return found.select(order)


def _with_nodes(kernels: Kernels, pairs: Pairs, rows: Int64Array, found: Transitions) -> Transitions:
    """The same with the nodes of the specification afterwards."""
    pairs.prepare(rows, 0, len(rows) // pairs.stride)
    before = np.ascontiguousarray(pairs.nodes(rows))
    nodes = np.zeros(len(found.sources), dtype=np.int64)
    events = found.events.astype(np.int32)
    kernels.nodes_after(pairs.guide, before, found.sources, events, len(nodes), nodes)
    targets = pairs.join(pairs.states(found.targets), np.where(nodes < 0, before[found.sources], nodes))
    return Transitions(found.sources, found.events, found.rules, targets, nodes)


def refusing_rows(packed: PackedNetwork, pairs: Pairs, rows: Int64Array) -> Int64Array:
    """Which of the given flat rows of pairs refuse more than their node allows."""
    size = len(rows) // pairs.stride
    kernels = kernels_for(size)
    moved = np.zeros(size, dtype=np.uint8)
    moved[transitions_of(packed, pairs, rows, [packed.tau]).sources] = 1
    made = Expander.for_rows(packed, pairs.stride, size)
    verdicts = np.zeros(size, dtype=np.uint8)
    offered = np.full_like(pairs.guide.offered, -1)
    guide = pairs.guide._replace(offered=offered)
    first = 0
    while first < size:
        reached = made.run(kernels, packed.visible, rows, first, size)
        judged = np.zeros(made.rows, dtype=np.uint8)
        kernels.follow(
            guide,
            rows,
            first,
            made.rows,
            made.stride,
            1,
            moved,
            first,
            made.offsets,
            made.targets,
            made.events,
            made.fired,
            judged,
        )
        verdicts[first:reached] = judged
        first = reached
    return np.flatnonzero(verdicts & REFUSAL)


@dataclass(frozen=True, eq=False, slots=True)
class Numbered:
    """Transitions of rows, with the numbers of their targets; -1 for those that are not in a completed level."""

    found: Transitions
    targets: Int64Array

    def select(self, chosen: BoolArray | Int64Array) -> Numbered:
        """Some of them."""
        return Numbered(self.found.select(chosen), self.targets[chosen])


class _Kept:
    """The transitions of the first rows of a walk.

    Attributes:
        starts: shape (rows + 1,): where those of each row begin.
        everything, taus, visible: shape (transitions,): which of them each question means.
    """

    def __init__(
        self, known: Numbered, may_be_taken: Callable[[Transitions, Int64Array], BoolArray], count: int
    ) -> None:
        self._known = known
        self.starts = np.searchsorted(known.found.sources, np.arange(count + 1))
        self.everything = np.ones(len(known.targets), dtype=np.bool_)
        taken = may_be_taken(known.found, np.arange(count))
        self.taus = taken & (known.found.events == TAU)
        self.visible = taken & (known.found.events != TAU)

    def has(self, numbers: Int64Array) -> bool:
        """Whether all these rows are among the first."""
        return len(numbers) > 0 and int(numbers.max()) < len(self.starts) - 1

    def of(self, numbers: Int64Array, wanted: BoolArray) -> Numbered:
        """Those of some rows."""
        chosen = gather_rows(self.starts, numbers)
        sources = np.repeat(np.arange(len(numbers)), self.starts[numbers + 1] - self.starts[numbers])
        those = wanted[chosen]
        found = self._known.found.select(chosen[those])
        found = Transitions(sources[those], found.events, found.rules, found.targets, found.nodes)
        return Numbered(found, self._known.targets[chosen[those]])


class Walk:
    """The rows of an exploration and their transitions.

    Attributes:
        packed, pairs: what was explored.
        visited: the rows.
        levels: see ``Exploration``; rows past the last level do not count.
    """

    __slots__ = ("_kept", "levels", "packed", "pairs", "visited")

    def __init__(self, packed: PackedNetwork, pairs: Pairs | None, visited: Visited, levels: Sequence[int]) -> None:
        self.packed = packed
        self.pairs = pairs
        self.visited = visited
        self.levels = levels
        self._kept: _Kept | None = None

    def keep(self, count: int) -> None:
        """Be ready for many questions about the first *count* rows, if these are few."""
        if count <= FEW and (self._kept is None or count >= len(self._kept.starts)):
            self._kept = _Kept(self._with_numbers(np.arange(count), None), self._may_be_taken, count)

    def transitions(self, numbers: Int64Array) -> Numbered:
        """All transitions of some of the rows, also those that the search did not take."""
        if self._kept is not None and self._kept.has(numbers):
            return self._kept.of(numbers, self._kept.everything)
        return self._with_numbers(numbers, None)

    def steps(self, numbers: Int64Array, *, taus: bool) -> Numbered:
        """The taus or the visible events that the search took from some of the rows."""
        if self._kept is not None and self._kept.has(numbers):
            return self._kept.of(numbers, self._kept.taus if taus else self._kept.visible)
        found = self._with_numbers(numbers, [self.packed.tau if taus else self.packed.visible])
        return found if self.pairs is None else found.select(self._may_be_taken(found.found, numbers))

    def _with_numbers(self, numbers: Int64Array, indexes: Sequence[Index] | None) -> Numbered:
        found = transitions_of(self.packed, self.pairs, self.rows(numbers), indexes)
        return Numbered(found, self.find(found.targets))

    def _may_be_taken(self, found: Transitions, numbers: Int64Array) -> BoolArray:
        """Which transitions of rows with these numbers the search took."""
        if self.pairs is None:
            return np.ones(len(found.sources), dtype=np.bool_)
        divergent = self.pairs.guide.divergent[self.pairs.nodes(self.rows(numbers))] != 0
        taken: BoolArray = (found.nodes >= 0) & ~divergent[found.sources]
        return taken

    def rows(self, indices: Int64Array) -> Int64Array:
        """Some of the rows, flat."""
        rows: Int64Array = self.visited.states[indices].reshape(-1)
        return rows

    def span(self, first: int, last: int) -> Int64Array:
        """Consecutive rows, flat; a view."""
        return self.visited.rows[first * self.visited.stride : last * self.visited.stride]

    def find(self, rows: Int64Array) -> Int64Array:
        """For each of the given flat rows its number; -1 for those that are not in a completed level."""
        count = len(rows) // self.visited.stride
        numbers = np.full(count, -1, dtype=np.int64)
        self.visited.find(kernels_for(count), np.ascontiguousarray(rows), count, numbers)
        numbers[numbers >= self.levels[-1]] = -1
        return numbers

    def moves(self, rows: Int64Array, indexes: Sequence[Index] | None = None) -> Transitions:
        """The transitions that the search took from the given flat rows: none forbidden, none at divergent nodes."""
        found = transitions_of(self.packed, self.pairs, rows, indexes)
        if self.pairs is None:
            return found
        divergent = self.pairs.guide.divergent[self.pairs.nodes(rows)] != 0
        return found.select((found.nodes >= 0) & ~divergent[found.sources])

    def edges(self, first: int, last: int, indexes: Sequence[Index] | None = None) -> Iterator[Edges]:
        """The transitions of consecutive rows by numbers, in chunks; those to rows that do not count are left out."""
        if self._kept is not None and last < len(self._kept.starts) and indexes is not None and len(indexes) == 1:
            steps = self.steps(np.arange(first, last), taus=indexes[0] is self.packed.tau)
            known = steps.targets >= 0
            yield Edges(first + steps.found.sources[known], steps.found.events[known], steps.targets[known])
            return
        for start in range(first, last, CHUNK):
            found = self.moves(self.span(start, min(last, start + CHUNK)), indexes)
            targets = self.find(found.targets)
            known = targets >= 0
            yield Edges(start + found.sources[known], found.events[known], targets[known])

    def tau_edges(self, level: int) -> tuple[Int64Array, Int64Array]:
        """The taus of a level's states as (sources, targets); a target may be in an earlier level."""
        first, last = self.levels[level], self.levels[level + 1]
        none: Int64Array = np.zeros(0, dtype=np.int64)
        if not len(self.packed.tau.items):
            return none, none
        parts = list(self.edges(first, last, [self.packed.tau]))
        sources = np.concatenate([none, *(part.sources for part in parts)])
        targets = np.concatenate([none, *(part.targets for part in parts)])
        return sources, targets

    def level_of(self, indices: Int64Array) -> Int64Array:
        """The levels of some rows."""
        return np.searchsorted(np.array(self.levels), indices, side="right") - 1


@dataclass(frozen=True, eq=False, slots=True)
class Edges:
    """Transitions by the numbers of their rows: sources ascending, dense events, targets."""

    sources: Int64Array
    events: Int64Array
    targets: Int64Array


def backwards(sources: Int64Array, targets: Int64Array, first: int, last: int, seeds: Int64Array) -> Int64Array:
    """How many edges at least lead from each of the nodes *first* to *last* to a seed; -1 where none do.

    Args:
        sources, targets: the edges; those that leave the range do not count.
        seeds: numbers in the range.
    """
    inside = (targets >= first) & (targets < last) & (sources >= first) & (sources < last)
    sources, targets = sources[inside] - first, targets[inside] - first
    order = np.argsort(targets, kind="stable")
    sources, starts = sources[order], np.searchsorted(targets[order], np.arange(last - first + 1))
    distance = np.full(last - first, -1, dtype=np.int64)
    frontier = distinct(seeds) - first
    steps = 0
    while len(frontier):
        distance[frontier] = steps
        steps += 1
        reached = distinct(sources[gather_rows(starts, frontier)])
        frontier = reached[distance[reached] < 0]
    return distance
