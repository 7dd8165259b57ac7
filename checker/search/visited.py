"""The set of visited states: rows in the order of discovery, and a table to find them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.kernels.jit import Kernels
from cspcheck.checker.search.reserve import Reserve, reserve

FIRST_BITS = 10
"""The first table has this many bits."""
LOAD = (5, 8)
"""How full a table may become: a fraction."""
WIDE_BITS = 31
"""Tables of this many bits and more have 64-bit entries."""
RESERVE_BITS = 20
"""From a table of this many bits on the arrays grow where they are, if the system can do that."""

NO_NUMBERS: Int64Array = np.zeros(0, dtype=np.int64)


def one_after_another(jobs: Iterable[Callable[[], Any]]) -> list[Any]:
    """Run jobs in this thread; their results."""
    return [job() for job in jobs]


def _entry_bytes(bits: int) -> int:
    """The size of an entry of a table of so many bits."""
    return 8 if bits >= WIDE_BITS else 4


def _if_large_enough(space: Reserve | None, nbytes: int) -> Reserve | None:
    return space if space is not None and space.holds(nbytes) else None


def _array(space: Reserve | None, count: int, dtype: type[np.signedinteger[Any]]) -> npt.NDArray[Any]:
    """An array in a reserve, or one by itself; its contents are what happens to be there."""
    return np.empty(count, dtype=dtype) if space is None else space.array(count, dtype)


class Visited:
    """Distinct rows of words, numbered as they come.

    Attributes:
        stride: words of a row.
        rows: flat; the states are the first ``known * stride`` entries. The room behind them is not touched before
            it is needed, and so takes no memory.
        known: how many states there are.
        room: how many fit.
        table, bits, entry_bits, partition_bits: see ``cspcheck.checker.kernels.table``.
        peak_bytes: the most memory that the arrays have taken.
    """

    __slots__ = (
        "_row_space",
        "_table_space",
        "bits",
        "entry_bits",
        "known",
        "partition_bits",
        "peak_bytes",
        "room",
        "rows",
        "stride",
        "table",
    )

    def __init__(self, stride: int, bits: int = FIRST_BITS) -> None:
        self.stride = stride
        self.known = 0
        self.bits = 0
        self.partition_bits = 0
        self.peak_bytes = 0
        self.rows: Int64Array = np.zeros(0, dtype=np.int64)
        self._row_space: Reserve | None = None
        self._table_space: Reserve | None = None
        self._take_room(bits)
        self.table.fill(-1)

    def _take_room(self, bits: int) -> None:
        """Make a table, whose entries are to be written, and room for as many rows as it may hold."""
        reserved = self._row_space
        if bits >= RESERVE_BITS > self.bits:
            self._row_space, self._table_space = reserve(), reserve()
        self.bits = bits
        self.entry_bits = 63 if bits >= WIDE_BITS else 31
        self.room = (LOAD[0] << bits) // LOAD[1]
        self._row_space = _if_large_enough(self._row_space, self._row_bytes(bits))
        self._table_space = _if_large_enough(self._table_space, _entry_bytes(bits) << bits)

        rows = _array(self._row_space, self.room * self.stride, np.int64)
        if self._row_space is None or self._row_space is not reserved:
            used = self.known * self.stride
            rows[:used] = self.rows[:used]
            self.peak_bytes = max(self.peak_bytes, 2 * used * 8)
        self.rows = rows
        self.table: npt.NDArray[Any] = _array(self._table_space, 1 << bits, np.int64 if bits >= WIDE_BITS else np.int32)

    def _row_bytes(self, bits: int) -> int:
        """The address space of the rows that a table of so many bits may hold."""
        return ((LOAD[0] << bits) // LOAD[1]) * self.stride * 8

    @property
    def bytes(self) -> int:
        """The memory that the arrays take now."""
        return self.known * self.stride * 8 + self.table.nbytes

    @property
    def states(self) -> Int64Array:
        """The states, shape (known, stride); a view."""
        return self.rows[: self.known * self.stride].reshape(self.known, self.stride)

    def note_peak(self) -> None:
        """Count what the arrays take now for ``peak_bytes``."""
        self.peak_bytes = max(self.peak_bytes, self.bytes)

    def bytes_after_growth(self) -> int:
        """The memory that growing would take at its height."""
        used, bits = self.known * self.stride * 8, self.bits + 1
        in_place = self._row_space is not None and self._row_space.holds(self._row_bytes(bits))
        return max(used if in_place else 2 * used, used + (_entry_bytes(bits) << bits))

    def grow(self, kernels: Kernels) -> None:
        """Make room for at least twice as many."""
        self.rebuild(kernels, self.bits + (2 if self.bits < 20 else 1), 0)

    def rebuild(
        self,
        kernels: Kernels,
        bits: int,
        partition_bits: int,
        together: Callable[[Iterable[Callable[[], Any]]], list[Any]] = one_after_another,
        workers: int = 1,
    ) -> None:
        """Change to a table of another size or division; *together* runs the jobs of that many workers.

        Should the states fall into the partitions so unevenly that one of them cannot hold its own, the table ends up
        undivided.
        """
        self.note_peak()
        # The old table goes before the new arrays come: the rows are enough to make another.
        del self.table
        self._take_room(bits)
        self.partition_bits = partition_bits
        cuts = [(w << partition_bits) // workers for w in range(workers + 1)]

        def enter(first: int, last: int) -> Callable[[], Any]:
            def job() -> Any:
                # Memory is taken when it is first written to, which is much of the work: each thread takes its own.
                entries = bits - self.partition_bits
                self.table[first << entries : last << entries].fill(-1)
                return kernels.enter_all(
                    self.rows,
                    self.known,
                    self.stride,
                    self.table,
                    self.bits,
                    self.entry_bits,
                    self.partition_bits,
                    first,
                    last,
                )

            return job

        if not all(together(enter(first, last) for first, last in pairwise(cuts))):
            self.partition_bits = 0
            enter(0, 1)()
        self.note_peak()

    def take(self, kernels: Kernels, known: int, fill: Callable[[Int64Array], bool]) -> bool:
        """Hold *known* distinct rows, which were held by another one before, and nothing else.

        *fill* writes them, flat, and says whether it could; if not, nothing is held.
        """
        bits = self.bits
        while (LOAD[0] << bits) // LOAD[1] <= known:
            bits += 1
        self.known = 0
        del self.table
        self._take_room(bits)
        filled = fill(self.rows[: known * self.stride])
        self.known = known if filled else 0
        self.rebuild(kernels, bits, 0)
        return filled

    def clear(self, bits: int) -> None:
        """Forget all rows, and have a table of so many bits; what is not needed for it is given back."""
        self.note_peak()
        self.known = 0
        if bits == self.bits:
            self.table.fill(-1)
            return
        del self.table
        self.rows = np.zeros(0, dtype=np.int64)
        self._row_space = self._table_space = None
        self.bits = 0
        self._take_room(bits)
        self.table.fill(-1)

    def insert(
        self, kernels: Kernels, targets: Int64Array, begin: int, end: int, numbers: Int64Array = NO_NUMBERS
    ) -> int:
        """Add rows as long as there is room; the first row not added, *end* if all were."""
        position: int
        position, self.known = kernels.insert(
            targets,
            begin,
            end,
            self.stride,
            self.rows,
            self.known,
            self.room,
            self.table,
            self.bits,
            self.entry_bits,
            self.partition_bits,
            numbers,
        )
        return position

    def find(self, kernels: Kernels, targets: Int64Array, count: int, numbers: Int64Array) -> None:
        """Write the numbers of the first *count* rows of *targets* to *numbers*, -1 for those that are not there."""
        kernels.find(
            targets,
            count,
            self.stride,
            self.rows,
            self.table,
            self.bits,
            self.entry_bits,
            self.partition_bits,
            numbers,
        )
