"""A process with all choices made: the machine that determinism is looked for with, where the whole is not at hand."""

from __future__ import annotations

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int64Array, distinct
from cspcheck.checker.budget import Budget, Incomplete
from cspcheck.checker.checks.context import CHUNK
from cspcheck.checker.kernels.jit import kernels_for
from cspcheck.checker.lts import Lts
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.exploration import Successors, successors
from cspcheck.checker.search.part import Rows
from cspcheck.cspm.process.events import TAU, TICK


def chosen_part(packed: PackedNetwork, budget: Budget, deepest: int | None = None) -> tuple[Lts, BoolArray]:
    """What a process does if it takes its first tau as long as it has any, and for each event the first target.

    Of all its states only those are met that these choices lead to: of taus that commute, one order instead of all.

    Args:
        packed: the process. It must not diverge, up to where it is looked at.
        budget: what may be used.
        deepest: after how many events it is looked at, if not after any number; it may diverge after as many.

    Returns:
        The machine, and of which of its states nothing is known: they come later, or diverge.

    Raises:
        Incomplete: a limit was reached.
    """
    choosing = _Choosing(packed, budget)
    here: Int64Array = np.zeros(1, dtype=np.int64)
    depth = 0
    while len(here) and (deepest is None or depth <= deepest):
        by_taus, by_events = choosing.look_at(here)
        if deepest is None:
            by_events = distinct(np.concatenate([by_taus, by_events]))
        else:
            while len(by_taus):
                by_taus, more = choosing.look_at(by_taus)
                by_events = distinct(np.concatenate([by_events, more]))
        here = choosing.not_looked_at(by_events)
        depth += 1
    return choosing.machine()


class _Choosing:
    """The states that choices lead to, numbered as they are met."""

    def __init__(self, packed: PackedNetwork, budget: Budget) -> None:
        self._packed = packed
        self._budget = budget
        self._rows = Rows(kernels_for(0), packed.words)
        self._rows.add(packed.initial)
        self._done: BoolArray = np.zeros(1, dtype=np.bool_)
        self._sources: list[Int64Array] = []
        self._labels: list[Int64Array] = []
        self._targets: list[Int64Array] = []
        self._taken = 0

    def look_at(self, states: Int64Array) -> tuple[Int64Array, Int64Array]:
        """Where their taus and where their events lead, if nobody has looked at that yet."""
        found = [self._look_at(states[first : first + CHUNK]) for first in range(0, len(states), CHUNK)]
        labels, targets = (np.concatenate(parts) for parts in zip(*found, strict=True))
        return self.not_looked_at(targets[labels == TAU]), self.not_looked_at(targets[labels != TAU])

    def not_looked_at(self, states: Int64Array) -> Int64Array:
        """Those of some states that nobody has looked at, each once."""
        states = distinct(states)
        return states[~self._done[states]]

    def machine(self) -> tuple[Lts, BoolArray]:
        """All that was looked at, and of what nothing is known."""
        states = self._rows.visited.known
        sources = np.concatenate(self._sources)
        order = np.argsort(sources, kind="stable")
        sources, labels = sources[order], np.concatenate(self._labels)[order]
        targets = np.concatenate(self._targets)[order]
        unknown = ~self._done[:states]
        taus = np.flatnonzero(labels == TAU)
        end = np.arange(states)
        end[sources[taus]] = targets[taus]
        for _ in range(states.bit_length()):
            end = end[end]
        # From an unstable state the only tau leads on: who has not come to a stable one by now goes round.
        unstable = np.zeros(states, dtype=np.bool_)
        unstable[sources[taus]] = True
        goes_round = unstable & unstable[end]
        unknown |= goes_round
        kept = ~goes_round[sources]
        offsets: Int64Array = np.concatenate([[0], np.cumsum(np.bincount(sources[kept], minlength=states))])
        return Lts(offsets.astype(np.int64), labels[kept], targets[kept]), unknown

    def _look_at(self, states: Int64Array) -> tuple[Int64Array, Int64Array]:
        """The labels and targets of what is chosen at some states."""
        budget = self._budget
        budget.check_time("looking for nondeterminism")
        # The machine is made into a normal form, which takes as much again.
        left = budget.remaining().memory_bytes
        if left is not None and left < self._taken:
            raise Incomplete(
                f"{budget.memory_reached()}: with all choices made, to be compared with, the process has more than "
                f"{self._rows.visited.known:,} states"
            )
        found = successors(self._packed, self._rows.visited.states[states])
        kept = _chosen(found)
        goals = found.targets[kept].reshape(-1)
        self._rows.add(goals)
        numbers = self._rows.numbers(goals)
        self._done[states] = True
        if self._rows.visited.known > len(self._done):
            self._done = np.concatenate([self._done, np.zeros(self._rows.visited.known, dtype=np.bool_)])
        self._sources.append(states[np.searchsorted(found.offsets, kept, side="right") - 1])
        self._labels.append(found.events[kept])
        self._targets.append(numbers)
        self._taken += 9 * len(states) + 24 * len(kept)
        return found.events[kept], numbers


def _chosen(found: Successors) -> Int64Array:
    """The places of the transitions that are taken: the first tau, else a tick, else the first of each event."""
    sources = np.repeat(np.arange(len(found.offsets) - 1), np.diff(found.offsets))
    first = np.ones(len(sources), dtype=np.bool_)
    first[1:] = (sources[1:] != sources[:-1]) | (found.events[1:] != found.events[:-1])
    states = len(found.offsets) - 1
    unstable, ticking = (_having(event, found, sources, states) for event in (TAU, TICK))
    wanted = np.where(unstable[sources], found.events == TAU, ~ticking[sources] | (found.events == TICK))
    return np.flatnonzero(first & wanted)


def _having(event: int, found: Successors, sources: Int64Array, states: int) -> BoolArray:
    """Which states can perform an event."""
    able = np.zeros(states, dtype=np.bool_)
    able[sources[found.events == event]] = True
    return able
