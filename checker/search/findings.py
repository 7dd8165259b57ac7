"""What every search has to show, wherever its states are: in memory, on disk, or with other processes."""

from __future__ import annotations

from typing import Literal

import numpy as np

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.pairs import Pairs
from cspcheck.checker.search.visited import Visited

StopReason = Literal["states", "seconds", "memory", "disk", "found", "depth"]
"""Why a search ended early: a limit, the first level with what was looked for, or the last that was to be looked at."""


class Findings:
    """What a search has found so far; the attributes are those of ``Exploration``."""

    def __init__(self, packed: PackedNetwork, pairs: Pairs | None) -> None:
        self.packed = packed
        self.pairs = pairs
        self.levels = [0]
        self.transitions_at: list[int] = []
        self.transitions = 0
        self.stop: StopReason | None = None
        self.complete = False
        self.deadlock_level: int | None = None
        self.divergence_level: int | None = None
        self.violation_level: int | None = None
        self.has_tau = False
        self.visited = Visited(packed.words if pairs is None else pairs.stride)
        self.peak_memory_bytes = 0
        self.seconds = 0.0

    @property
    def initial(self) -> Int64Array:
        """The row that the search begins with."""
        if self.pairs is None:
            return self.packed.initial
        return self.pairs.join(self.packed.initial.reshape(1, -1), np.array([self.pairs.root]))

    @property
    def has_found(self) -> bool:
        """Whether there is something to be told of."""
        return any(level is not None for level in (self.deadlock_level, self.divergence_level, self.violation_level))

    @property
    def told_divergence(self) -> int | None:
        """The level whose divergences are told of: with a specification only those that violate it."""
        return self.divergence_level if self.pairs is None or self.divergence_level == self.violation_level else None
