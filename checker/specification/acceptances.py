"""What the states of a machine can be relied on: acceptances, the minimal ones among them, and divergence."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int64Array
from cspcheck.checker.lts import Lts
from cspcheck.checker.sparse_rows import gather_rows, intern_rows
from cspcheck.cspm.process.events import TAU, TICK

Acceptance = tuple[int, ...]
"""The events of an acceptance as ascending columns."""
AcceptanceSet = tuple[Acceptance, ...]


def divergent_states(lts: Lts) -> BoolArray:
    """Which states have an infinite path of taus. Shape (states,).

    States from which every path of taus ends are peeled off from the ends; what stays cannot stop. Linear in
    the taus.
    """
    sources = np.repeat(np.arange(lts.states), np.diff(lts.offsets))
    tau = lts.labels == TAU
    sources, targets = sources[tau], lts.targets[tau]
    remaining = np.bincount(sources, minlength=lts.states)
    order = np.argsort(targets, kind="stable")
    predecessors = sources[order]
    starts = np.searchsorted(targets[order], np.arange(lts.states + 1))
    ended = np.flatnonzero(remaining == 0)
    while len(ended):
        losing, losses = np.unique(predecessors[gather_rows(starts, ended)], return_counts=True)
        remaining[losing] -= losses
        ended = losing[remaining[losing] == 0]
    diverging: BoolArray = remaining > 0
    return diverging


class StateAcceptances:
    """The acceptance of each state that has one.

    Attributes:
        number: shape (states,): which acceptance the state has; -1 for an unstable state that cannot tick.
        acceptances: the distinct acceptances as ascending columns (positions in the ascending visible labels).
    """

    __slots__ = ("acceptances", "number")

    def __init__(self, lts: Lts, columns: Int64Array) -> None:
        sources = np.repeat(np.arange(lts.states), np.diff(lts.offsets))
        ticking = np.zeros(lts.states, dtype=np.bool_)
        ticking[sources[lts.labels == TICK]] = True
        unstable = np.zeros(lts.states, dtype=np.bool_)
        unstable[sources[lts.labels == TAU]] = True
        kept = np.where(ticking[sources], lts.labels == TICK, ~unstable[sources])
        # A nondeterministic state offers an event once however many targets it has.
        again = np.zeros(lts.transitions, dtype=np.bool_)
        again[1:] = (lts.labels[1:] == lts.labels[:-1]) & (sources[1:] == sources[:-1])
        kept &= ~again
        offsets = np.concatenate([[0], np.cumsum(np.bincount(sources[kept], minlength=lts.states))])
        values = columns[kept]
        self.number, first = intern_rows(offsets, values)
        self.acceptances = [tuple(values[offsets[row] : offsets[row + 1]].tolist()) for row in first.tolist()]
        self.number[unstable & ~ticking] = -1


def minimal(acceptances: Iterable[Acceptance]) -> AcceptanceSet:
    """Those of some acceptances that contain no other, in the order of size and then of events."""
    kept: list[Acceptance] = []
    masks: list[int] = []
    for acceptance in sorted(set(acceptances), key=lambda acceptance: (len(acceptance), acceptance)):
        mask = sum(1 << column for column in acceptance)
        if not any(smaller & mask == smaller for smaller in masks):
            kept.append(acceptance)
            masks.append(mask)
    return tuple(kept)


class AcceptanceSets:
    """Sets of minimal acceptances, numbered as they are met.

    Attributes:
        sets: the sets.
    """

    __slots__ = ("_numbers", "sets")

    def __init__(self) -> None:
        self._numbers: dict[AcceptanceSet, int] = {}
        self.sets: list[AcceptanceSet] = []

    def number(self, acceptances: AcceptanceSet) -> int:
        """The number of a set that is minimal and in order."""
        number = self._numbers.setdefault(acceptances, len(self.sets))
        if number == len(self.sets):
            self.sets.append(acceptances)
        return number
