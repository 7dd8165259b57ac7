"""Searches that are larger than memory: what they have found, and what is still to be looked at, is on disk.

A search begins in memory, as any other. When that is used up, its rows go to a file: every level, and every wave of
taus in it, as ascending runs. From then on the successors of a wave are gathered in memory, sorted, and held against
all that is there in one pass at its end. What is found, what is counted and what is told is the same.
"""

from __future__ import annotations

import errno
import weakref
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.guard import machine_memory, process_memory
from cspcheck.checker.kernels.arrays import Index
from cspcheck.checker.kernels.jit import Kernels
from cspcheck.checker.search.checkpoint import Tally
from cspcheck.checker.search.crew import DIVIDED_BITS
from cspcheck.checker.search.expansion import CAPACITY
from cspcheck.checker.search.levels import INTERPRETED_ROWS, LevelSearch
from cspcheck.checker.search.part import Part, cyclic_rows
from cspcheck.checker.search.runs import (
    BLOCK,
    RunSet,
    RunWriter,
    Sieve,
    SortedRun,
    blocks_of,
    ordered,
    pieces_of,
    read_rows,
    united,
)
from cspcheck.checker.search.visited import LOAD, Visited
from cspcheck.checker.search.walk import Walk
from cspcheck.checker.search.worker import Wave, drop_at_divergent_nodes

GATHERED = 0.5
"""The part of the memory in which successors are gathered."""
LEVEL = 0.6
"""The part of the memory that a level may take in which cycles of taus are looked for."""
ROWS = 4 * BLOCK
"""Rows that are read to be expanded at a time."""
SORTED = 1 << 20
"""Rows that are sorted at a time when a search goes to disk: sorting must not need much memory then."""


class Spill:
    """Where searches may go when there is no more memory for them.

    Args:
        folder: made if it is not there; each search has a folder of its own in it, which goes with the search.
        rows: how many rows of a kind may be in memory; by default as many as the memory limit allows.

    Raises:
        OSError: the folder cannot be written.
    """

    def __init__(self, folder: Path, rows: int | None = None) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix="cspcheck-", dir=folder):
            self.folder = folder
        self.rows = rows


class Store:
    """The rows that a search has found, on disk.

    Attributes:
        stride: words of a row.
        known: how many rows there are.
        segments: the runs of the file of rows, in the order of discovery.
    """

    def __init__(self, spill: Spill, stride: int) -> None:
        self.stride = stride
        self.known = 0
        self.segments: list[SortedRun] = []
        self._room = TemporaryDirectory(prefix="cspcheck-", dir=spill.folder)
        self._end = weakref.finalize(self, self._room.cleanup)
        self.folder = Path(self._room.name)
        self._path = self.folder / "rows"
        self._runs = RunSet(self.folder, stride)
        self._waiting: list[SortedRun] = []
        self._number = 0

    def close(self) -> None:
        """Remove everything."""
        self._end()

    def rows(self, first: int, last: int) -> Int64Array:
        """Some of the rows, flat."""
        return read_rows(self._path, first, last - first, self.stride)

    def span(self, first: int, last: int) -> Iterator[Int64Array]:
        """Consecutive rows in the order of discovery, some at a time."""
        for place in range(first, last, ROWS):
            yield self.rows(place, min(last, place + ROWS))

    def segments_of(self, first: int, last: int) -> list[SortedRun]:
        """The runs that make up these rows."""
        return [run for run in self.segments if first <= run.first < last]

    def append(self, kernels: Kernels, pieces: Iterator[Int64Array]) -> int:
        """Add ascending rows that are not there yet behind the others; how many."""
        writer = RunWriter(self._path, self.known, self.stride, own=False)
        for piece in pieces:
            writer.add(piece)
        run = writer.finished()
        if run.count:
            self.segments.append(run)
            self._runs.add(kernels, run)
            self.known += run.count
        return run.count

    @property
    def is_settled(self) -> bool:
        """Whether nothing was put aside."""
        return not self._waiting

    def put_aside(self, rows: Int64Array) -> None:
        """Keep ascending rows that may be new until they are settled."""
        self._waiting.append(self.written(pieces_of(rows, self.stride)))

    def written(self, pieces: Iterator[Int64Array]) -> SortedRun:
        """Ascending rows as a run in a file of its own."""
        self._number += 1
        writer = RunWriter(self.folder / f"part-{self._number}", 0, self.stride, own=True)
        for piece in pieces:
            writer.add(piece)
        return writer.finished()

    def gathered(self, kernels: Kernels, rows: Int64Array) -> Iterator[Int64Array]:
        """All that was put aside and these ascending rows, ascending; afterwards nothing is waiting."""
        waiting, self._waiting = self._waiting, []
        yield from united(kernels, [*map(blocks_of, waiting), pieces_of(rows, self.stride)], self.stride)
        for run in waiting:
            run.drop()

    def settle(self, kernels: Kernels, rows: Int64Array) -> None:
        """Add what is new of all that was put aside and of these ascending rows."""
        self.append(kernels, self._runs.new_ones(kernels, self.gathered(kernels, rows)))


class _Full(Exception):
    """The search has to go on on disk."""


class SpillSearch(LevelSearch):
    """A search that goes on on disk when there is no more memory.

    Attributes:
        store: the rows; None as long as they are in memory. ``visited`` has the successors then that were gathered
            since the last wave.
    """

    def __init__(self, *arguments: Any, spill: Spill, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.store: Store | None = None
        self._spill = spill
        self._before: list[tuple[int, int]] = []
        self._most_bits = 0
        self._is_over = False
        # What the process may have: kernels that are loaded meanwhile count as well.
        limit, now = self._limits.memory_bytes, process_memory()
        self._ceiling = None if limit is None or now is None else now + limit

    @property
    def known(self) -> int:
        """How many states have been found."""
        return self.visited.known if self.store is None else self.store.known

    def _memory_reached(self) -> None:
        if self.store is None:
            raise _Full
        super()._memory_reached()

    def _check(self, frontier: int) -> None:
        if self._is_over:
            return  # What ended the search does not end what is told of it.
        if self.store is None and self._spill.rows is not None and self.visited.known > self._spill.rows:
            raise _Full
        if self.store is None and self._left_over(self._other_bytes()) < 0:
            raise _Full
        super()._check(frontier)

    def _left_over(self, more: int) -> float:
        """How many bytes the process may have yet, if it takes so many more."""
        now = process_memory()
        return float("inf") if self._ceiling is None or now is None else self._ceiling - now - more

    def _before_rows(self) -> None:
        self._before = [(worker.transitions, worker.deadlocks) for worker in self._all_workers()]

    def _expand(self, index: Index, *, visible: bool, start: int) -> None:
        if self.store is None:
            try:
                super()._expand(index, visible=visible, start=start)
                return
            except _Full:
                # The rows that were being expanded will be again.
                before = [*self._before, *[(0, 0)] * len(self._all_workers())]
                for worker, counted in zip(self._all_workers(), before, strict=False):
                    worker.transitions, worker.deadlocks = counted
                self._go_to_disk(start)
        self._expand_from_disk(index, visible=visible, start=start)

    def _go_to_disk(self, start: int) -> None:
        """Write what was found down: the rows up to where the level, or the wave, ends as runs, the rest put aside."""
        store, visited, at = Store(self._spill, self.visited.stride), self.visited, self._at
        stride = store.stride
        cuts = sorted({*self.levels, at.first, at.end, visited.known})
        for first, last in pairwise(cuts):
            for begin in range(first, last, SORTED):
                end = min(last, begin + SORTED)
                rows = visited.rows[begin * stride : end * stride].reshape(-1, stride)
                order = np.lexsort(rows.T[::-1])
                ascending = np.ascontiguousarray(rows[order]).reshape(-1)
                if first >= at.end:
                    store.put_aside(ascending)
                    continue
                if begin >= start and len(at.moved):
                    at.moved[begin - start : end - start] = at.moved[begin - start : end - start][order]
                store.append(self._kernels, pieces_of(ascending, stride))
        self._note_peak()
        if self._checkpoint is not None:
            self._checkpoint.in_another_order()
        self._go_on_with(store)
        self._level_bytes = at.moved.nbytes

    def _go_on_with(self, store: Store) -> None:
        """Have the rows in a store."""
        self.store = store
        self.visited.clear(min(DIVIDED_BITS, self.visited.bits))
        self._most_bits = _table_bits(self._memory(), store.stride, self._spill.rows)
        if self._workers > 1:
            self._most_bits = max(self._most_bits, DIVIDED_BITS)
        self._clear()

    def _take_up(self, tally: Tally) -> bool:
        checkpoint = self._checkpoint
        assert checkpoint is not None
        if checkpoint.runs is None:
            return super()._take_up(tally)
        store = Store(self._spill, self.visited.stride)
        stride, first = store.stride, 0
        if not checkpoint.take_up(tally.known * stride, tally.known * stride):
            return False

        def pieces(first: int, last: int) -> Iterator[Int64Array]:
            for place in range(first, last, ROWS):
                yield np.concatenate([*checkpoint.rows(place * stride, min(last, place + ROWS) * stride)])

        for count in checkpoint.runs:
            store.append(self._kernels, pieces(first, first + count))
            first += count
        self._go_on_with(store)
        return True

    def _write_last_checkpoint(self) -> None:
        if self.store is None:
            super()._write_last_checkpoint()

    def _write_between_waves(self) -> None:
        """Write a checkpoint if it is time to, and nothing of the wave that begins has been gathered yet."""
        store, checkpoint = self.store, self._checkpoint
        assert store is not None
        if checkpoint is None or not store.is_settled or self.visited.known or not checkpoint.is_due():
            return
        stride = store.stride

        def pieces(begin: int) -> Iterator[Int64Array]:
            return store.span(begin // stride, store.known)

        runs = [run.count for run in store.segments]
        checkpoint.write_some(pieces, store.known * stride, runs, self._tally(), self._at)

    def _memory(self) -> int:
        """Bytes that the search may use."""
        limit = self._limits.memory_bytes
        if limit is None:
            return (machine_memory() or 2 << 30) // 2
        return int(max(0, min(limit, self._left_over(0))))

    def _clear(self) -> None:
        """Have an empty table for successors, about as large as was needed last."""
        bits = self.visited.bits
        if self.visited.known < self.visited.room >> 4:
            bits -= 2
        self.visited.clear(min(max(bits, DIVIDED_BITS), self._most_bits))

    def run(self) -> None:
        """Search, as far as memory and disk allow."""
        try:
            super().run()
        except OSError as error:
            if not is_full(error):
                raise
            self.stop = "disk"

    def _expand_from_disk(self, index: Index, *, visible: bool, start: int) -> None:
        assert self.store is not None
        self._write_between_waves()
        at = self._at
        while at.first < at.end:
            first, last = at.first, min(at.end, at.first + ROWS)
            rows = self.store.rows(first, last)
            if self.pairs is not None:
                self.pairs.prepare(rows, 0, last - first)
                for worker in self._all_workers():
                    # Marked by rows that had the same place in other blocks.
                    worker.guide.offered.fill(-1)
            step = Wave(index, visible, rows, start - first, at.moved, elsewhere=True)
            place = 0
            while place < last - first:
                self._check(at.end - first - place)
                place = self._expand_some(step, place, last - first)
            at.first = last
        self.store.settle(self._kernels, self._gathered_rows())
        self._clear()
        self._check_states()

    def _gathered_rows(self) -> Int64Array:
        """What was gathered in memory, in order."""
        return ordered(self.visited.rows[: self.visited.known * self.visited.stride], self.visited.stride)

    def _make_room(self) -> None:
        if self.store is None:
            grown = self.visited.bytes_after_growth()
            if self._left_over(grown - self.visited.bytes) < 0:
                raise _Full
            super()._make_room()
        elif self.visited.bits < self._most_bits:
            if self._crew is not None:
                self._crew.grow(self._kernels)
            else:
                self.visited.grow(self._kernels)
        else:
            self.store.put_aside(self._gathered_rows())
            self.visited.clear(self.visited.bits)

    def _has_tau_cycle(self, start: int) -> bool:
        if self.store is None:
            try:
                return super()._has_tau_cycle(start)
            except _Full:
                self._go_to_disk(start)
        left = self.on_or_behind_cycles(start, self.known)
        self._clear()
        return left is None or self._goes_round(left, 0)

    def on_or_behind_cycles(self, first: int, last: int, *, whatever_it_takes: bool = False) -> Visited | None:
        """The rows of a level without those at which no tau arrives from the others, until they fit into memory.

        None if they never do, and all that are left have taus that arrive: then some go round. To show these
        *whatever it takes*, they are loaded all the same.
        """
        assert self.store is not None
        store, kernels = self.store, self._kernels
        run = store.written(united(kernels, [blocks_of(part) for part in store.segments_of(first, last)], store.stride))
        while run.count > self._fitting():
            before = run.count
            for rows in blocks_of(run):
                self._add_successors(rows)
            sieve = Sieve(kernels, run)
            pieces = store.gathered(kernels, self._gathered_rows())
            following = store.written(sieve.sift(piece, wanted=True) for piece in pieces)
            run.drop()
            run = following
            self.visited.clear(self.visited.bits)
            if run.count == before and whatever_it_takes:
                break
            if run.count == before:
                run.drop()
                return None
        self.visited.clear(min(DIVIDED_BITS, self._most_bits))
        left = Visited(store.stride)

        def fill(rows: Int64Array) -> bool:
            place = 0
            for piece in blocks_of(run):
                rows[place : place + len(piece)] = piece
                place += len(piece)
            return True

        left.take(kernels, run.count, fill)
        run.drop()
        return left

    def _fitting(self) -> int:
        """How many rows of a level may be in memory."""
        if self._spill.rows is not None:
            return self._spill.rows
        return int(LEVEL * self._memory()) // (8 * self.visited.stride + 22)

    def _add_successors(self, rows: Int64Array) -> None:
        """Gather what taus that might go round lead to from some rows."""
        made, stride = self._worker.expander, self.visited.stride
        first, end = 0, len(rows) // stride
        if self.pairs is not None:
            self.pairs.prepare(rows, 0, end)
        most = CAPACITY if self._kernels.compiled else INTERPRETED_ROWS
        while first < end:
            self._check(end - first)
            reached = made.run(self._kernels, self.packed.cycling, rows, first, min(end, first + most))
            if self.pairs is not None:
                drop_at_divergent_nodes(self._kernels, made, self._worker.guide, rows, first)
            self._insert(made.targets, made.count)
            first = reached

    def walk(self) -> Walk:
        """What the search has found, to be walked about in: all of it, or the ways to what was looked for."""
        if self.store is None:
            return super().walk()
        self._is_over = True
        self.visited.clear(min(DIVIDED_BITS, self._most_bits))
        return Part(self._kernels, self, _OnDisk(self)).ways()


class _OnDisk:
    """The rows of a search on disk, to take a part of."""

    def __init__(self, search: SpillSearch) -> None:
        self._search = search

    def blocks(self, level: int) -> Iterator[Int64Array]:
        """The rows of a level."""
        assert self._search.store is not None
        return self._search.store.span(self._search.levels[level], self._search.levels[level + 1])

    def all_of(self, rows: Int64Array) -> Int64Array:
        """The same rows: there are no others."""
        return rows

    def cyclic(self, level: int) -> Int64Array:
        """The rows of a level that lie on cycles of taus."""
        search = self._search
        first, last = search.levels[level], search.levels[level + 1]
        left = search.on_or_behind_cycles(first, last, whatever_it_takes=True)
        assert left is not None
        return cyclic_rows(search.packed, search.pairs, left)


def is_full(error: OSError) -> bool:
    """Whether a disk has no more room, or none for this user or this file."""
    return error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def _table_bits(memory: int, stride: int, rows: int | None) -> int:
    """The size of the table for gathering: the largest for which the memory is enough, with its rows and for sorting.

    With *rows* it is one that holds at least so many.
    """
    if rows is not None:
        bits = 1
        while (LOAD[0] << bits) // LOAD[1] < rows:
            bits += 1
        return bits
    words = stride if stride == 1 else 2 * stride + 1
    bits = DIVIDED_BITS
    while (4 << (bits + 1)) + ((LOAD[0] << (bits + 1)) // LOAD[1]) * 8 * words <= GATHERED * memory:
        bits += 1
    return bits
