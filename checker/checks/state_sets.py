"""What a process can do after each trace, by the sets of states that traces lead to, kept outside memory.

The subset construction (Roscoe, "Understanding Concurrent Systems", section 16.1) for a process whose states do not
fit into memory. A set is written down once and read again when it is looked at; in memory are its place, its hash, and
the event and the set that it came by.
"""

from __future__ import annotations

import weakref
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import BinaryIO

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int64Array, UInt64Array, distinct
from cspcheck.checker.budget import Budget, Incomplete
from cspcheck.checker.checks.context import CHUNK
from cspcheck.checker.kernels.jit import kernels_for
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.beyond import Beyond
from cspcheck.checker.search.exploration import Successors, successors
from cspcheck.checker.search.pairs import Column
from cspcheck.checker.search.part import Rows
from cspcheck.checker.search.runs import ordered, read_rows
from cspcheck.checker.search.spill import Spill
from cspcheck.cspm.process.events import TAU, TICK

BATCH = 1 << 15
"""Sets are looked at together until they have so many states."""


class StateSets:
    """The sets of states that traces lead to, in the order of (length, trace): of those that more lead to, the first.

    Of a set only those states are kept that can perform an event or have an acceptance: others make no difference.

    Args:
        packed: the process, which may diverge.
        budget: what may be used.
        beyond: where there is room if memory is not enough.
    """

    def __init__(self, packed: PackedNetwork, budget: Budget, beyond: Beyond | None) -> None:
        self._packed = packed
        self._budget = budget
        self._members = _OnDisk(beyond, packed.words) if isinstance(beyond, Spill) else _InMemory(packed.words)
        self._known = Rows(kernels_for(0), 3)
        """Two halves of a hash and a size for each set, by which it is found."""
        self._starts = Column(np.zeros(1, dtype=np.int64))
        self._came_from = Column(np.zeros(0, dtype=np.int64))
        self._came_by = Column(np.zeros(0, dtype=np.int64))

    def first_nondeterminism(self) -> tuple[int, ...] | None:
        """The first trace after which an event is possible that a state refuses which can be relied on, or None.

        Raises:
            Incomplete: a limit was reached; the states that one trace leads to have to fit into memory.
            OSError: the disk is full.
        """
        self._add(self._closed(np.concatenate([[0], self._packed.initial])), -1)
        first = 0
        while first < self._known.visited.known:
            last, rows, owners = self._batch(first)
            found = self._nondeterministic(rows, owners, last - first)
            if found.any():
                return self._trace(first + int(np.argmax(found)))
            self._add(self._closed(self._after_events(rows, owners)), first)
            first = last
        return None

    def _trace(self, number: int) -> tuple[int, ...]:
        trace: list[int] = []
        while self._came_from.array[number] >= 0:
            trace.append(int(self._came_by.array[number]))
            number = int(self._came_from.array[number])
        return tuple(reversed(trace))

    def _batch(self, first: int) -> tuple[int, Int64Array, Int64Array]:
        """Some sets from the *first* on: the first that is not among them, their states, and whose these are."""
        starts = self._starts.array[: self._known.visited.known + 1]
        last = max(first + 1, int(np.searchsorted(starts, starts[first] + BATCH, side="right")) - 1)
        rows = self._members.read(int(starts[first]), int(starts[last])).reshape(-1, self._packed.words)
        return last, rows, np.repeat(np.arange(last - first), np.diff(starts[first : last + 1]))

    def _nondeterministic(self, rows: Int64Array, owners: Int64Array, sets: int) -> BoolArray:
        """Which of some sets have an event that is possible and refused: where a state accepts less than all can do."""
        possible: list[Int64Array] = [np.zeros(0, dtype=np.int64)]
        accepting: list[Int64Array] = [np.zeros(0, dtype=np.int64)]
        accepted: list[Int64Array] = [np.zeros(0, dtype=np.int64)]
        events = len(self._packed.events)
        for first in range(0, len(rows), CHUNK):
            found, own = self._successors(rows[first : first + CHUNK]), owners[first : first + CHUNK]
            sources = _sources(found)
            visible = found.events != TAU
            labels = np.searchsorted(self._packed.events, found.events)
            possible.append(distinct(own[sources[visible]] * events + labels[visible]))
            fresh = visible.copy()
            fresh[1:] &= (sources[1:] != sources[:-1]) | (labels[1:] != labels[:-1])
            offers = np.bincount(sources[fresh], minlength=len(own))
            ticking, unstable = _having(TICK, found), _having(TAU, found)
            settled = ticking | ~unstable
            accepting.append(own[settled])
            accepted.append(np.where(ticking, 1, offers)[settled])
        offered = np.bincount(distinct(np.concatenate(possible)) // events, minlength=sets)
        less = np.concatenate(accepted) < offered[np.concatenate(accepting)]
        found_in = np.zeros(sets, dtype=np.bool_)
        found_in[np.concatenate(accepting)[less]] = True
        return found_in

    def _after_events(self, rows: Int64Array, owners: Int64Array) -> Int64Array:
        """Where the events of some sets lead, as rows of a state behind (set, event) as one number."""
        marked = Rows(kernels_for(0), self._packed.words + 1)
        for first in range(0, len(rows), CHUNK):
            found, own = self._successors(rows[first : first + CHUNK]), owners[first : first + CHUNK]
            visible = found.events != TAU
            labels = np.searchsorted(self._packed.events, found.events[visible])
            after = own[_sources(found)[visible]] * len(self._packed.events) + labels
            marked.add(np.column_stack([after, found.targets[visible]]).reshape(-1))
            self._check(marked)
        return marked.visited.states.reshape(-1)

    def _closed(self, rows: Int64Array) -> Int64Array:
        """All that taus lead to from rows of (number, state), and these: ascending, what makes a difference."""
        marked, stride = Rows(kernels_for(0), self._packed.words + 1), self._packed.words + 1
        marked.add(rows)
        kept: list[Int64Array] = [np.zeros((0, stride), dtype=np.int64)]
        first = 0
        while first < marked.visited.known:
            last = min(marked.visited.known, first + CHUNK)
            some = marked.visited.states[first:last].copy()
            found = self._successors(np.ascontiguousarray(some[:, 1:]))
            silent = found.events == TAU
            number = some[_sources(found)[silent], 0]
            marked.add(np.column_stack([number, found.targets[silent]]).reshape(-1))
            idle = np.zeros(last - first, dtype=np.bool_)
            idle[_sources(found)[silent]] = True
            idle[_sources(found)[~silent]] = False
            kept.append(some[~idle])
            first = last
            self._check(marked)
        return ordered(np.concatenate(kept).reshape(-1), stride)

    def _add(self, rows: Int64Array, first: int) -> None:
        """Add the sets among ascending rows of (number, state) that are new; *first* is the set that 0 stands for."""
        table = rows.reshape(-1, self._packed.words + 1)
        states = np.ascontiguousarray(table[:, 1:])
        numbers, starts = np.unique(table[:, 0], return_index=True)
        ends = np.append(starts, len(table))[1:]
        keys = np.column_stack([*_hashes(states, starts, ends), ends - starts])
        for number, start, end, key in zip(numbers.tolist(), starts.tolist(), ends.tolist(), keys, strict=True):
            self._add_set(states[start:end], key, first, number)

    def _add_set(self, states: Int64Array, key: Int64Array, first: int, number: int) -> None:
        while True:
            known = self._known.visited.known
            self._known.add(key)
            place = int(self._known.numbers(key)[0])
            if place == known:
                break
            start, end = self._starts.array[place : place + 2].tolist()
            if np.array_equal(self._members.read(start, end), states.reshape(-1)):
                return
            key[0] = (key[0] + 1) & np.iinfo(np.int64).max  # another set with the same hash
        self._members.append(states.reshape(-1))
        self._starts.extend([int(self._starts.array[known]) + len(states)])
        events = len(self._packed.events)
        self._came_from.extend([-1 if first < 0 else first + number // events])
        self._came_by.extend([int(self._packed.events[number % events])])

    def _successors(self, rows: Int64Array) -> Successors:
        self._budget.check_time("looking for nondeterminism")
        return successors(self._packed, rows)

    def _check(self, marked: Rows) -> None:
        """Hold the states of some sets against the memory that is left for sorting them."""
        left = self._budget.remaining().memory_bytes
        if left is not None and left < 2 * 8 * marked.visited.known * marked.visited.stride:
            raise Incomplete(
                f"{self._budget.memory_reached()}: a trace leads to {marked.visited.known:,} states and more at once, "
                "and the process diverges, so that all of them have to be looked at together"
            )


class _InMemory:
    """The states of all sets, one after another."""

    def __init__(self, words: int) -> None:
        self._words = words
        self._column = Column(np.zeros(0, dtype=np.int64))

    def append(self, rows: Int64Array) -> None:
        """Add states, flat."""
        self._column.extend(rows)

    def read(self, first: int, last: int) -> Int64Array:
        """Some of the states, flat."""
        return self._column.array[first * self._words : last * self._words]


class _OnDisk:
    """The states of all sets in a file, which goes with this."""

    def __init__(self, spill: Spill, words: int) -> None:
        self._words = words
        room = TemporaryDirectory(prefix="cspcheck-", dir=spill.folder)
        self._path = Path(room.name) / "sets"
        self._file = open(self._path, "wb")  # noqa: SIM115  (open as long as this is there)
        self._end = weakref.finalize(self, _leave, self._file, room)

    def append(self, rows: Int64Array) -> None:
        """Add states, flat."""
        self._file.write(np.ascontiguousarray(rows).data.cast("B"))

    def read(self, first: int, last: int) -> Int64Array:
        """Some of the states, flat."""
        self._file.flush()
        return read_rows(self._path, first, last - first, self._words)


def _leave(file: BinaryIO, room: TemporaryDirectory[str]) -> None:
    with suppress(OSError):  # what could not be written is of no use to anybody now
        file.close()
    room.cleanup()


def _sources(found: Successors) -> Int64Array:
    return np.repeat(np.arange(len(found.offsets) - 1), np.diff(found.offsets))


def _having(event: int, found: Successors) -> BoolArray:
    """Which states can perform an event."""
    able = np.zeros(len(found.offsets) - 1, dtype=np.bool_)
    able[_sources(found)[found.events == event]] = True
    return able


def _hashes(states: Int64Array, starts: Int64Array, ends: Int64Array) -> tuple[Int64Array, Int64Array]:
    """Two numbers for each set: sums of what its states are mixed to, in any order."""
    mixed: UInt64Array = np.zeros(len(states), dtype=np.uint64)
    for column in states.T:
        mixed = _mixed(mixed ^ column.astype(np.uint64))
    sums = []
    for numbers in (mixed, _mixed(mixed)):
        before = np.concatenate([np.zeros(1, dtype=np.uint64), np.cumsum(numbers, dtype=np.uint64)])
        sums.append(((before[ends] - before[starts]) >> np.uint64(1)).astype(np.int64))
    return sums[0], sums[1]


def _mixed(numbers: UInt64Array) -> UInt64Array:
    """Steele, Lea and Flood, "Fast splittable pseudorandom number generators" (OOPSLA 2014): SplitMix64."""
    numbers = numbers + np.uint64(0x9E3779B97F4A7C15)
    numbers = (numbers ^ (numbers >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    numbers = (numbers ^ (numbers >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return numbers ^ (numbers >> np.uint64(31))
