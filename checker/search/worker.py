"""A worker of a search: it expands a share of a level."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cspcheck.checker.arrays import Int64Array, UInt8Array
from cspcheck.checker.kernels.arrays import MAY_BRANCH, MAY_REPEAT, Guide, Index, no_guide
from cspcheck.checker.kernels.jit import Kernels
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.expansion import CAPACITY, Expander
from cspcheck.checker.search.pairs import Pairs

_NO_VERDICTS: UInt8Array = np.zeros(0, dtype=np.uint8)


@dataclass(slots=True)
class Wave:
    """What is to be expanded: the tau transitions of a wave or the visible ones of a level.

    Attributes:
        index: the rules.
        visible: whether they are the visible ones.
        rows: the visited rows.
        start: the first row of the level.
        moved: which rows of the level have taus; empty if none can.
        elsewhere: whether *rows* are others than those of the visited states.
    """

    index: Index
    visible: bool
    rows: Int64Array
    start: int
    moved: UInt8Array
    elsewhere: bool = False


class Worker:
    """What expands a share of a level: buffers, and a tally of what was seen since it was last asked.

    Attributes:
        expander: the buffers.
        transitions, deadlocks: how many were met.
        violated: what pairs violated, ``TRACE | REFUSAL``.
    """

    __slots__ = ("_guide", "_pairs", "_source", "deadlocks", "expander", "transitions", "violated")

    def __init__(self, packed: PackedNetwork, pairs: Pairs | None, capacity: int = CAPACITY) -> None:
        if pairs is None:
            self.expander = Expander(packed, packed.words, care=MAY_REPEAT | MAY_BRANCH, capacity=capacity)
        else:
            self.expander = Expander(packed, pairs.stride, care=MAY_REPEAT, detail=True, capacity=capacity)
        self.transitions = 0
        self.deadlocks = 0
        self.violated = 0
        self._pairs = pairs
        self._source: Guide | None = None
        self._guide = no_guide()

    @property
    def guide(self) -> Guide:
        """The specification, with scratch of this worker's own."""
        if self._pairs is not None and self._source is not self._pairs.guide:
            self._source = self._pairs.guide
            self._guide = self._source._replace(offered=self._source.offered.copy())
        return self._guide

    def produce(self, kernels: Kernels, step: Wave, first: int, last: int) -> int:
        """Expand rows of a step as far as they fit; the first row not expanded. The transitions are in ``expander``."""
        made = self.expander
        reached = made.run(kernels, step.index, step.rows, first, last)
        packed = made.packed
        if not step.visible and len(step.moved):
            kernels.note_movers(made.offsets, made.rows, step.moved, first - step.start)
        if self._pairs is not None:
            self.violated |= kernels.follow(
                self.guide,
                step.rows,
                first,
                made.rows,
                made.stride,
                int(step.visible),
                step.moved,
                first - step.start,
                made.offsets,
                made.targets,
                made.events,
                made.fired,
                _NO_VERDICTS,
            )
        elif step.visible:
            self.deadlocks += kernels.count_deadlocks(
                made.offsets,
                first,
                made.rows,
                step.moved,
                first - step.start,
                step.rows,
                packed.words,
                made.stride,
                packed.terminated.reshape(-1),
            )
        self.transitions += made.count
        return reached


def drop_at_divergent_nodes(kernels: Kernels, made: Expander, guide: Guide, rows: Int64Array, first: int) -> None:
    """Drop those of the taus in *made* that start from pairs whose node allows everything."""
    kernels.follow(
        guide,
        rows,
        first,
        made.rows,
        made.stride,
        0,
        _NO_VERDICTS,
        0,
        made.offsets,
        made.targets,
        made.events,
        made.fired,
        _NO_VERDICTS,
    )
