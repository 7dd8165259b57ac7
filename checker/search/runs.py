"""Sets of states on disk, as sorted runs of rows that are read and written in order.

Duplicates are detected late (Korf, "Delayed duplicate detection", IJCAI 2003; Stern and Dill before, for verification):
what a level leads to is sorted, and held against all that is there in one pass. Files are read block by block and not
mapped, so that what they take of memory is known.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.kernels.jit import Kernels

BLOCK = 1 << 15
"""Rows that are read at a time."""


def ordered(rows: Int64Array, stride: int) -> Int64Array:
    """Flat rows in ascending order: the same array if a row is a word, else a copy."""
    if stride == 1:
        rows.sort()
        return rows
    columns = rows.reshape(-1, stride)
    # Words are natural numbers, so that their order is the same with a sign and without.
    return columns[np.lexsort(columns.T[::-1])].reshape(-1)


@dataclass(eq=False, slots=True)
class SortedRun:
    """Ascending distinct rows in a part of a file.

    Attributes:
        path, first, count: the file, the row in it where they begin, and how many they are.
        stride: words of a row.
        heads: the first row of each block, shape (blocks, stride).
        own: whether the file has nothing else, and goes when the run is of no use any more.
    """

    path: Path
    first: int
    count: int
    stride: int
    heads: list[Int64Array] = field(default_factory=list)
    own: bool = False

    def block(self, number: int) -> Int64Array:
        """The rows of a block, flat."""
        first = number * BLOCK
        return read_rows(self.path, self.first + first, min(BLOCK, self.count - first), self.stride)

    @property
    def blocks(self) -> int:
        """How many blocks there are."""
        return -(-self.count // BLOCK)

    def drop(self) -> None:
        """Remove the file, if it is the run's own."""
        if self.own:
            self.path.unlink(missing_ok=True)


def read_rows(path: Path, first: int, count: int, stride: int) -> Int64Array:
    """Rows of a file, flat.

    Raises:
        OSError: they cannot be read, or are not there.
    """
    rows = np.fromfile(path, dtype=np.int64, count=count * stride, offset=8 * first * stride)
    if len(rows) != count * stride:
        raise OSError(5, "there is less in the file than was written", str(path))
    return rows


class RunWriter:
    """Writes ascending rows behind those of a file."""

    def __init__(self, path: Path, first: int, stride: int, *, own: bool) -> None:
        self._file = open(path, "ab")  # noqa: SIM115  (closed by `finished`)
        self._run = SortedRun(path, first, 0, stride, own=own)

    def add(self, rows: Int64Array) -> None:
        """Write rows, flat."""
        run = self._run
        count = len(rows) // run.stride
        for place in range(-run.count % BLOCK, count, BLOCK):
            run.heads.append(rows[place * run.stride : (place + 1) * run.stride].copy())
        self._file.write(np.ascontiguousarray(rows).data.cast("B"))
        run.count += count

    def finished(self) -> SortedRun:
        """What was written."""
        self._file.close()
        return self._run


class Sieve:
    """Goes through a run once, to tell which of ascending rows are in it."""

    def __init__(self, kernels: Kernels, run: SortedRun) -> None:
        self._kernels = kernels
        self._run = run
        self._number = -1
        self._rows: Int64Array = np.zeros(0, dtype=np.int64)
        self._place = 0

    def sift(self, rows: Int64Array, *, wanted: bool) -> Int64Array:
        """Those of the rows that are in the run, or that are not: the beginning of the same array."""
        stride = self._run.stride
        begin, kept, end = 0, 0, len(rows) // stride
        while True:
            stop = len(self._rows) // stride
            begin, kept, self._place = self._kernels.sift(
                rows, begin, end, kept, self._rows, self._place, stop, stride, int(wanted)
            )
            if begin == end:
                return rows[: kept * stride]
            if not self._load(rows[begin * stride : (begin + 1) * stride]):
                break
        if wanted:
            return rows[: kept * stride]
        left = len(rows) - begin * stride
        rows[kept * stride : kept * stride + left] = rows[begin * stride :].copy()
        return rows[: kept * stride + left]

    def _load(self, row: Int64Array) -> bool:
        """Have the block in which a row must be that is beyond this one; False if the run is at its end."""
        if self._number + 1 >= self._run.blocks:
            return False
        wanted = row.tolist()
        # The last block that begins with nothing greater.
        number = bisect_right(self._run.heads, wanted, lo=self._number + 1, key=lambda head: head.tolist()) - 1
        self._number = max(number, self._number + 1)
        self._rows, self._place = self._run.block(self._number), 0
        return True


def blocks_of(run: SortedRun) -> Iterator[Int64Array]:
    """The rows of a run, block by block."""
    for number in range(run.blocks):
        yield run.block(number)


def pieces_of(rows: Int64Array, stride: int) -> Iterator[Int64Array]:
    """Rows in memory, some at a time."""
    for place in range(0, len(rows), BLOCK * stride):
        yield rows[place : place + BLOCK * stride]


def united(kernels: Kernels, sources: Iterable[Iterator[Int64Array]], stride: int) -> Iterator[Int64Array]:
    """The union of ascending sets of rows, ascending, in pieces of flat rows; each set comes in pieces itself."""
    streams = [_Stream(source) for source in sources]
    while True:
        streams = [stream for stream in streams if stream.load()]
        if not streams:
            return
        if len(streams) == 1:
            yield streams[0].take(len(streams[0].rows))
            continue
        # Whatever comes later is greater than the last row of the piece that ends first.
        pivot = min((stream.rows[-stride:] for stream in streams), key=lambda row: tuple(row.tolist()))
        pieces = []
        for stream in streams:
            end = len(stream.rows) // stride
            count = kernels.rows_before(stream.rows, 0, end, pivot, 0, stride)
            if count < end and np.array_equal(stream.rows[count * stride : (count + 1) * stride], pivot):
                count += 1
            pieces.append(stream.take(count * stride))
        pieces = [piece for piece in pieces if len(piece)]
        while len(pieces) > 1:
            pieces.sort(key=len, reverse=True)
            one, other = pieces.pop(), pieces.pop()
            union: Int64Array = np.empty(len(one) + len(other), dtype=np.int64)
            count = kernels.unite(one, 0, len(one) // stride, other, 0, len(other) // stride, stride, union)
            pieces.append(union[: count * stride])
        yield pieces[0]


class _Stream:
    """Pieces of rows, of which the beginning may be taken away."""

    def __init__(self, source: Iterator[Int64Array]) -> None:
        self._source = source
        self.rows: Int64Array = np.zeros(0, dtype=np.int64)

    def load(self) -> bool:
        """Have some rows; False if there are no more."""
        while not len(self.rows):
            piece = next(self._source, None)
            if piece is None:
                return False
            self.rows = piece
        return True

    def take(self, length: int) -> Int64Array:
        """The first *length* words, which are gone then."""
        taken, self.rows = self.rows[:length], self.rows[length:]
        return taken


class RunSet:
    """Distinct rows in several runs, the larger ones first; runs that come close to each other in size become one.

    Args:
        folder: where united runs are written.
        stride: words of a row.
    """

    def __init__(self, folder: Path, stride: int) -> None:
        self.runs: list[SortedRun] = []
        self._folder = folder
        self._stride = stride
        self._number = 0

    def add(self, kernels: Kernels, run: SortedRun) -> None:
        """Add a run that has nothing in common with what is there."""
        if run.count:
            self.runs.append(run)
        # Each at least twice as large as the next: so few that a piece of rows can be held against all of them, and few
        # times that a row is copied (O'Neil et al., "The log-structured merge-tree", 1996).
        while len(self.runs) > 1 and self.runs[-2].count < 2 * self.runs[-1].count:
            last, before = self.runs.pop(), self.runs.pop()
            self.runs.append(self._union(kernels, before, last))

    def _union(self, kernels: Kernels, one: SortedRun, other: SortedRun) -> SortedRun:
        self._number += 1
        writer = RunWriter(self._folder / f"run-{self._number}", 0, self._stride, own=True)
        for piece in united(kernels, [blocks_of(one), blocks_of(other)], self._stride):
            writer.add(piece)
        one.drop()
        other.drop()
        return writer.finished()

    def new_ones(self, kernels: Kernels, pieces: Iterable[Int64Array]) -> Iterator[Int64Array]:
        """Those of the ascending rows, which come in pieces, that are in no run."""
        sieves = [Sieve(kernels, run) for run in self.runs]
        for piece in pieces:
            for sieve in sieves:
                piece = sieve.sift(piece, wanted=False)
            if len(piece):
                yield piece
