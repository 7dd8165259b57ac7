"""Specifications as the pair search needs them: a guide in arrays, extended node by node where it is lazy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from cspcheck.checker.arrays import Int32Array, Int64Array, among, distinct
from cspcheck.checker.guard import afford
from cspcheck.checker.kernels.arrays import Guide
from cspcheck.checker.packing.layout import Layout
from cspcheck.checker.specification.normal_form import NormalForm

NODE_BITS = 31
"""Bits that a node needs when nobody knows how many there will be."""


class LazyNormalForm(Protocol):
    """A normal form whose nodes are extended as a search reaches them. ``Normaliser`` is one.

    Nodes are numbered densely from 0, the root; ``extend`` may bring new ones into being. The search asks for each
    node at most once.
    """

    @property
    def events(self) -> Int64Array:
        """The events of the specification as identifiers, ascending."""

    def extend(self, node: int) -> Sequence[tuple[int, int]]:
        """The node's transitions: (position in ``events``, node), ascending."""

    def is_divergent(self, node: int) -> bool:
        """Whether the node allows everything."""

    def acceptance_set(self, node: int) -> int:
        """Which of ``acceptance_sets`` is the node's."""

    @property
    def acceptance_sets(self) -> Sequence[Sequence[Sequence[int]]]:
        """Sets of minimal acceptances as positions in ``events``; may grow."""


class Column:
    """An array of integers that grows at its end, or wherever it is written to.

    Attributes:
        array: the numbers, and room behind them filled with ``fill``.
        length: how many numbers there are.
    """

    __slots__ = ("array", "fill", "length")

    def __init__(self, numbers: npt.NDArray[Any], fill: int = 0) -> None:
        # A copy if need be: the kernels want one kind of array, contiguous and writable.
        self.array = np.require(numbers, requirements=["C", "W"])
        self.fill = fill
        self.length = len(numbers)

    def reserve(self, length: int) -> None:
        """Have room for so many numbers."""
        if length > len(self.array):
            afford(2 * length * self.array.itemsize)
            grown = np.full(max(64, 2 * length), self.fill, dtype=self.array.dtype)
            grown[: self.length] = self.array[: self.length]
            self.array = grown

    def extend(self, numbers: Sequence[int] | npt.NDArray[Any]) -> None:
        """Put numbers at the end."""
        self.reserve(self.length + len(numbers))
        self.array[self.length : self.length + len(numbers)] = numbers
        self.length += len(numbers)

    def put(self, place: int, number: int) -> None:
        """Write a number at a place, which may be behind the end."""
        self.reserve(place + 1)
        self.array[place] = number
        self.length = max(self.length, place + 1)


class Pairs:
    """A specification beside an implementation.

    Attributes:
        guide: the specification in arrays. It changes when a lazy one is extended.
        stride: words of a pair.
        root: the node of the empty trace.
    """

    def __init__(self, specification: NormalForm | LazyNormalForm, layout: Layout, events: Int64Array) -> None:
        lazy = None if isinstance(specification, NormalForm) else specification
        free, top = layout.free_bits()
        bits = NODE_BITS
        if isinstance(specification, NormalForm):
            bits = max(1, (specification.nodes - 1).bit_length())
            self.root = specification.root
            self._starts = Column(specification.offsets[:-1], -1)
            self._ends = Column(specification.offsets[1:])
            self._columns = Column(specification.columns)
            self._targets = Column(specification.targets)
            self._divergent = Column(specification.divergent.astype(np.uint8))
            self._sets = Column(specification.acceptance_set)
        else:
            self.root = 0
            self._starts, self._ends = Column(np.zeros(0, dtype=np.int64), -1), Column(np.zeros(0, dtype=np.int64))
            self._columns, self._targets = Column(_NONE), Column(_NONE)
            self._divergent, self._sets = Column(np.zeros(0, dtype=np.uint8)), Column(_NONE)
            self._starts.reserve(1)
        self._lazy: LazyNormalForm | None = lazy
        self._set_offsets = Column(np.zeros(1, dtype=np.int64))
        self._acceptance_offsets = Column(np.zeros(1, dtype=np.int64))
        self._members = Column(_NONE)
        self._add_acceptances(specification.acceptance_sets)

        shares_word = free >= bits
        self.stride = layout.words if shares_word else layout.words + 1
        self._word = layout.words - 1 if shares_word else layout.words
        self._shift = top if shares_word else 0
        self._mask = (1 << bits) - 1
        self._words = layout.words
        positions = np.searchsorted(specification.events, events)
        known = among(events, specification.events)
        self._event_columns = np.where(known, positions, -1).astype(np.int32)
        self._offered = np.full(len(specification.events), -1, dtype=np.int64)
        self.guide = self._guide()

    def _guide(self) -> Guide:
        return Guide(
            self._word,
            self._shift,
            self._mask,
            self._event_columns,
            self._starts.array,
            self._ends.array,
            self._columns.array,
            self._targets.array,
            self._divergent.array,
            self._sets.array,
            self._set_offsets.array,
            self._acceptance_offsets.array,
            self._members.array,
            self._offered,
        )

    def _add_acceptances(self, sets: Sequence[Sequence[Sequence[int]]]) -> None:
        members: list[int] = []
        acceptance_ends: list[int] = []
        set_ends: list[int] = []
        for acceptances in sets[self._set_offsets.length - 1 :]:
            for acceptance in acceptances:
                members += acceptance
                acceptance_ends.append(self._members.length + len(members))
            set_ends.append(self._acceptance_offsets.length - 1 + len(acceptance_ends))
        self._members.extend(members)
        self._acceptance_offsets.extend(acceptance_ends)
        self._set_offsets.extend(set_ends)

    def prepare(self, rows: Int64Array, first: int, last: int) -> bool:
        """Extend the nodes of the pairs in the rows *first* to *last*; whether ``guide`` has changed."""
        if self._lazy is None:
            return False
        nodes = distinct(self.nodes(rows[first * self.stride : last * self.stride]))
        missing = nodes[self._starts.array[nodes] < 0].tolist()
        for node in missing:
            self._extend(self._lazy, node)
        if missing:
            self._add_acceptances(self._lazy.acceptance_sets)
            self.guide = self._guide()
        return bool(missing)

    def _extend(self, lazy: LazyNormalForm, node: int) -> None:
        divergent = lazy.is_divergent(node)
        transitions = [] if divergent else lazy.extend(node)
        self._starts.put(node, self._columns.length)
        self._columns.extend([column for column, _ in transitions])
        self._targets.extend([target for _, target in transitions])
        self._ends.put(node, self._columns.length)
        self._divergent.put(node, int(divergent))
        self._sets.put(node, lazy.acceptance_set(node))
        highest = max((target for _, target in transitions), default=0)
        if highest > self._mask:
            raise OverflowError(f"more than {self._mask:,} nodes of a specification")
        self._starts.reserve(highest + 1)

    @property
    def is_lazy(self) -> bool:
        """Whether nodes get their numbers as the search reaches them."""
        return self._lazy is not None

    def join(self, states: Int64Array, nodes: Int64Array) -> Int64Array:
        """Pairs as flat rows, from packed states of shape (pairs, words) and nodes of shape (pairs,)."""
        rows = np.zeros((len(states), self.stride), dtype=np.int64)
        rows[:, : self._words] = states
        rows[:, self._word] |= nodes << self._shift
        return rows.reshape(-1)

    def nodes(self, rows: Int64Array) -> Int64Array:
        """The nodes of pairs given as flat rows."""
        nodes: Int64Array = rows.reshape(-1, self.stride)[:, self._word] >> self._shift & self._mask
        return nodes

    def states(self, rows: Int64Array) -> Int64Array:
        """The packed states of pairs given as flat rows, shape (pairs, words)."""
        states = rows.reshape(-1, self.stride)[:, : self._words].copy()
        if self._word < self._words:
            states[:, self._word] &= ~(self._mask << self._shift)
        return states


_NONE: Int32Array = np.zeros(0, dtype=np.int32)
