"""Priority on explicit machines: the transitions that give way to others of the same state are taken out.

What the operators mean is said by their rules (``cspcheck.checker.semantics``); here the same is done to all states of
a machine at once.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from cspcheck.checker.arrays import BoolArray
from cspcheck.checker.lts import Lts, reachable, sources
from cspcheck.cspm.process.events import TAU, TICK, EventSet


def prioritised(lts: Lts, levels: Sequence[EventSet]) -> Lts:
    """``prioritise(P, levels)``: only the highest level that a state has something of, and the events of no level."""
    events, columns = np.unique(lts.labels, return_inverse=True)
    lowest = len(levels)
    ranks = np.full(len(events), -1, dtype=np.int64)
    for column, event in enumerate(events.tolist()):
        if event in (TAU, TICK):
            ranks[column] = 0
        else:
            ranks[column] = next((i for i, level in enumerate(levels) if event in level), -1)
    rank = ranks[columns]
    starts = sources(lts)
    highest = np.full(lts.states, lowest, dtype=np.int64)
    ranked = rank >= 0
    np.minimum.at(highest, starts[ranked], rank[ranked])
    return _kept(lts, ~ranked | (rank == highest[starts]))


def prioritised_by_order(lts: Lts, events: EventSet, order: Collection[tuple[int, int]], maximal: EventSet) -> Lts:
    """``prioritisepo(P, events, order, maximal)``: an event gives way to a greater one."""
    greater: dict[int, set[int]] = {}
    for high, low in order:
        greater.setdefault(low, set()).add(high)
    kept = np.ones(lts.transitions, dtype=np.bool_)
    for state in range(lts.states):
        first, last = int(lts.offsets[state]), int(lts.offsets[state + 1])
        row = lts.labels[first:last].tolist()
        possible = set(row)
        urgent = TAU in possible or TICK in possible
        for i, event in enumerate(row, first):
            if event in (TAU, TICK) or event not in events:
                continue
            kept[i] = not greater.get(event, set()) & possible and (not urgent or event in maximal)
    return _kept(lts, kept)


def _kept(lts: Lts, kept: BoolArray) -> Lts:
    counts = np.bincount(sources(lts)[kept], minlength=lts.states)
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    return reachable(Lts(offsets, lts.labels[kept], lts.targets[kept], lts.root))
