"""A process with all choices made: the machine that determinism is looked for with, where the whole is not at hand."""

from __future__ import annotations

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int64Array
from cspcheck.checker.budget import Budget, Incomplete
from cspcheck.checker.checks.context import CHUNK
from cspcheck.checker.kernels.jit import kernels_for
from cspcheck.checker.lts import Lts
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.exploration import Successors, successors
from cspcheck.checker.search.part import Rows
from cspcheck.cspm.process.events import TAU, TICK


def chosen_part(packed: PackedNetwork, budget: Budget) -> Lts:
    """What a process does if it takes its first tau as long as it has any, and for each event the first target.

    It must not diverge. Of all its states only those are met that these choices lead to: of taus that commute, one
    order instead of all.

    Raises:
        Incomplete: a limit was reached.
    """
    rows = Rows(kernels_for(0), packed.words)
    rows.add(packed.initial)
    lengths: list[Int64Array] = [np.zeros(1, dtype=np.int64)]
    labels: list[Int64Array] = []
    targets: list[Int64Array] = []
    first, taken = 0, 0
    while first < rows.visited.known:
        budget.check_time("looking for nondeterminism")
        # The machine is made into a normal form, which takes as much again.
        left = budget.remaining().memory_bytes
        if left is not None and left < taken:
            states = rows.visited.known
            raise Incomplete(
                f"{budget.memory_reached()}: with all choices made, to be compared with, the process has more than "
                f"{states:,} states"
            )
        until = min(rows.visited.known, first + CHUNK)
        found = successors(packed, rows.visited.states[first:until])
        kept = _chosen(found)
        goals = found.targets[kept].reshape(-1)
        rows.add(goals)
        numbers: Int64Array = np.full(len(kept), -1, dtype=np.int64)
        rows.visited.find(kernels_for(0), np.ascontiguousarray(goals), len(kept), numbers)
        sources = np.searchsorted(found.offsets, kept, side="right") - 1
        lengths.append(np.bincount(sources, minlength=until - first))
        labels.append(found.events[kept])
        targets.append(numbers)
        taken += 8 * (until - first) + 16 * len(kept)
        first = until
    offsets: Int64Array = np.concatenate(lengths).cumsum()
    return Lts(offsets, np.concatenate(labels), np.concatenate(targets))


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
