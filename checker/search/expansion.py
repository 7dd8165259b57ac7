"""Buffers in which the successors of a run of states are made."""

from __future__ import annotations

import numpy as np

from cspcheck.checker.arrays import Int32Array, Int64Array
from cspcheck.checker.kernels.arrays import MAY_REPEAT, Index, Scratch
from cspcheck.checker.kernels.jit import Kernels
from cspcheck.checker.packing.packed import PackedNetwork

CAPACITY = 1 << 15
"""Transitions that a buffer holds at first."""
SMALL_CAPACITY = 1 << 8
"""Transitions that the buffer for a few rows holds at first."""


class Expander:
    """Expands runs of rows. After :meth:`run` the attributes hold the transitions of the rows expanded.

    Attributes:
        rows: how many rows were expanded.
        offsets: the transitions of the ``i``-th row are the slice ``offsets[i]:offsets[i + 1]``.
        targets: flat rows.
        events: dense events; filled only if *detail* was asked for or the network needs it.
        fired: rules; likewise.
        scratch: see ``kernel_tables``.
    """

    __slots__ = (
        "_care",
        "_detail",
        "capacity",
        "events",
        "fired",
        "offsets",
        "packed",
        "rows",
        "scratch",
        "stride",
        "targets",
    )

    def __init__(
        self, packed: PackedNetwork, stride: int, *, care: int = 0, detail: bool = False, capacity: int = CAPACITY
    ) -> None:
        self.packed = packed
        self.stride = stride
        self.rows = 0
        self._care = care & int(np.bitwise_or.reduce(packed.rules.care))
        self._detail = detail or self._care != 0
        self._take_room(capacity)

    def _take_room(self, capacity: int) -> None:
        self.capacity = capacity
        self.offsets: Int64Array = np.zeros(capacity + 2, dtype=np.int64)
        self.targets: Int64Array = np.empty(capacity * self.stride, dtype=np.int64)
        detailed = capacity if self._detail else 0
        self.events: Int32Array = np.empty(detailed, dtype=np.int32)
        self.fired: Int32Array = np.empty(detailed, dtype=np.int32)
        participants = self.packed.participants
        narrowed = len(self.packed.rules.stubborn.word)
        self.scratch = Scratch(
            seen=np.full(2 << capacity.bit_length() if self._care & MAY_REPEAT else 1, -1, dtype=np.int32),
            last_row=np.full(len(self.packed.events), -1, dtype=np.int64),
            branching=np.zeros(1, dtype=np.int64),
            table_row=np.zeros(participants, dtype=np.int64),
            odometer=np.zeros(participants, dtype=np.int64),
            within=np.zeros(narrowed + 1, dtype=np.int64),
            waiting=np.zeros(narrowed, dtype=np.int64),
        )

    @classmethod
    def for_rows(cls, packed: PackedNetwork, stride: int, rows: int) -> Expander:
        """One that shows events and rules, for so many rows."""
        return cls(packed, stride, detail=True, capacity=min(CAPACITY, SMALL_CAPACITY + 8 * rows))

    @property
    def count(self) -> int:
        """How many transitions there are."""
        return int(self.offsets[self.rows])

    @property
    def nbytes(self) -> int:
        """The memory that the buffers take."""
        arrays = (self.offsets, self.targets, self.events, self.fired, *self.scratch)
        return sum(array.nbytes for array in arrays)

    def run(self, kernels: Kernels, index: Index, states: Int64Array, first: int, last: int) -> int:
        """Expand rows from *first* on, up to *last* or as many as fit, at least one; the first row not expanded."""
        last = min(last, first + self.capacity)
        while True:
            self.clean()
            reached: int = kernels.expand(
                self.packed.rules,
                index,
                self.packed.words,
                self.stride,
                states,
                first,
                last,
                self.capacity,
                self._care,
                self.offsets,
                self.targets,
                self.events,
                self.fired,
                self.scratch,
            )
            if reached > first:
                self.rows = reached - first
                return reached
            self.enlarge()

    def clean(self) -> None:
        """Forget what earlier calls left in the scratch arrays."""
        if self._care:
            self.scratch.seen.fill(-1)
            # A row that did not fit is expanded again, and its events must not look like second ones.
            self.scratch.last_row.fill(-1)

    def enlarge(self) -> None:
        """Make the buffers twice as large; what is in them is lost."""
        self.reserve(2 * self.capacity)

    def reserve(self, capacity: int) -> None:
        """Have room for at least so many transitions; what is in the buffers is lost."""
        if capacity > self.capacity:
            branching = self.scratch.branching
            self._take_room(capacity)
            self.scratch = self.scratch._replace(branching=branching)
