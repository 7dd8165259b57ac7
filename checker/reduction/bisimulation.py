"""Equivalences on the states of an explicit machine, and the quotients by them.

All three are the coarsest partition that is stable under a set of moves: those of the machine itself (strong
bisimulation), tau* a (delay bisimulation) or tau* a tau* (weak bisimulation). The latter two respect
divergence: a state with an infinite path of taus is never put together with one that has none, and its class
keeps a tau to itself; so the quotient has the same failures and divergences. None of them puts the state after a tick
together with a deadlock.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int32Array, Int64Array, distinct
from cspcheck.checker.guard import afford
from cspcheck.checker.kernels import taus
from cspcheck.checker.kernels.jit import kernels_for, tau_kernels_for
from cspcheck.checker.kernels.taus import RefinedPartition, Signatures
from cspcheck.checker.lts import Lts, machine, sources
from cspcheck.checker.reduction.partition import coarsest_partition, numbered, quotient
from cspcheck.checker.specification.acceptances import divergent_states
from cspcheck.cspm.process.events import TAU, TICK

Numbers = TypeVar("Numbers", Int32Array, Int64Array)

SATURATED = 2_000_000
"""So many tau* a (tau*) moves are written down; where there are more, classes of targets are looked at instead."""

SLICE = 20_000_000
"""So much is looked at before machine code comes back: some tenths of a second."""

SLICES = 50
"""As often it may come back before what can be done without is given up."""

IDLE = 3
"""After so many rounds in which nothing falls apart by weights signatures are looked at."""

FEW = 300
"""Machines of no more states are small enough for delay and weak bisimulation as they are."""

_NOTHING = Signatures(np.zeros(1, dtype=np.int64), np.zeros(0, dtype=np.int64))


def strong_bisimulation(lts: Lts) -> Lts:
    """The quotient by strong bisimulation: as small as a strongly bisimilar machine can be."""
    return quotient(lts, coarsest_partition(lts, terminated(lts)), keep_inner_taus=True)


def terminated(lts: Lts) -> Int64Array:
    """1 for the states that tick leads to, else 0: to have terminated is not to be deadlocked. Shape (states,)."""
    ended = np.zeros(lts.states, dtype=np.int64)
    ended[lts.targets[lts.labels == TICK]] = 1
    return ended


def weak_bisimulation(lts: Lts) -> Lts:
    """The quotient by divergence-respecting weak bisimulation (Milner 1989, chapter 5; taus may follow the event)."""
    return _tau_abstracting_quotient(lts, taus_after=True)


def delay_bisimulation(lts: Lts) -> Lts:
    """The quotient by divergence-respecting delay bisimulation (van Glabbeek 1993: taus only before the event)."""
    return _tau_abstracting_quotient(lts, taus_after=False)


def factor_tau_loops(lts: Lts) -> Lts:
    """``tau_loop_factor``: the states of a cycle of taus become one state, with a tau to itself."""
    return quotient(lts, tau_components(lts)[0], keep_inner_taus=True)


def tau_components(lts: Lts) -> tuple[Int64Array, BoolArray]:
    """Strongly connected components of the taus, and which states have an infinite path of taus.

    Components are numbered so that every tau leads to the same or a smaller number.
    """
    size = lts.states
    tau = lts.labels == TAU
    offsets = np.concatenate([[0], np.cumsum(np.bincount(sources(lts)[tau], minlength=size))]).astype(np.int64)
    component, low, stack = (np.zeros(size, dtype=np.int64) for _ in range(3))
    targets = np.ascontiguousarray(lts.targets[tau])
    kernels_for(size).strong_components(
        offsets, targets, size, component, low, stack, np.zeros(2 * size, dtype=np.int64)
    )
    return component, divergent_states(lts)


def branching_bisimulation(lts: Lts) -> Lts:
    """The quotient by divergence-respecting branching bisimulation; the machine itself if that takes too long.

    It is finer than delay bisimulation and needs to look at taus within classes only (van Glabbeek and Weijland, 1996).
    """
    acyclic, diverging = _without_tau_loops(lts)
    partition = _by_signatures(acyclic, diverging, taus.BRANCHING, SLICES)
    return lts if partition is None else quotient(acyclic, partition, keep_inner_taus=False, diverging=diverging)


def _without_tau_loops(lts: Lts) -> tuple[Lts, BoolArray]:
    """The machine with each cycle of taus as one state, taus leading to smaller numbers; and which states diverged."""
    components, diverging_states = tau_components(lts)
    diverging = np.zeros(int(components.max()) + 1, dtype=np.bool_)
    diverging[components[diverging_states]] = True
    starts, targets = components[sources(lts)], components[lts.targets]
    kept = (lts.labels != TAU) | (starts != targets)
    root = int(components[lts.root])
    return machine(len(diverging), starts[kept], lts.labels[kept], targets[kept], root), diverging


def _tau_abstracting_quotient(lts: Lts, *, taus_after: bool) -> Lts:
    # Strongly bisimilar states and those of a cycle of taus are equivalent in any case, and taking them together
    # first costs next to nothing; those that are branching bisimilar cost little.
    lts = strong_bisimulation(lts)
    if lts.states > FEW:
        lts = branching_bisimulation(lts)
    acyclic, diverging = _without_tau_loops(lts)
    partition = tau_abstracting_partition(acyclic, diverging, taus_after=taus_after)
    return quotient(acyclic, partition, keep_inner_taus=False, diverging=diverging)


def tau_abstracting_partition(lts: Lts, diverging: BoolArray, *, taus_after: bool, most: int = SATURATED) -> Int64Array:
    """The classes of divergence-respecting delay or weak bisimulation.

    Args:
        lts: a machine whose taus lead to states of smaller numbers only.
        diverging: shape (states,): the states that an infinite path of taus started from before cycles were removed.
        taus_after: whether taus may follow an event (weak bisimulation).
        most: see ``SATURATED``.
    """
    saturated = _saturated(lts, taus_after=taus_after, most=most)
    if saturated is not None:
        return coarsest_partition(saturated, _apart(lts, diverging))
    partition = _by_signatures(lts, diverging, taus.WEAK if taus_after else taus.DELAY)
    assert partition is not None
    return partition


def _apart(lts: Lts, diverging: BoolArray) -> Int64Array:
    """The partition to start with: states that diverge or have terminated are like no others."""
    return 2 * diverging.astype(np.int64) + terminated(lts)


def _saturated(lts: Lts, *, taus_after: bool, most: int) -> Lts | None:
    """The machine of the moves tau* and tau* a (tau*), numbered anew and in any order.

    None for more than *most*, or if it takes long to find them, most of them again and again.
    """
    size = lts.states
    kernels = tau_kernels_for(size)
    starts, middles, ends, small_labels = _spans(lts)
    reach_offsets, offsets = np.zeros(size + 1, dtype=np.int64), np.zeros(size + 1, dtype=np.int64)
    reached = np.zeros(min(most, 2 * (size + lts.transitions)), dtype=np.int32)
    stamps = np.zeros(size, dtype=np.int64)
    done = slices = 0
    while done < size:
        found = kernels.reach(
            size, done, starts, middles, lts.targets, stamps, slices * size, reach_offsets, reached, SLICE
        )
        slices += 1
        if found < 0:
            if len(reached) == most:
                return None
            reached = _longer(reached, most)
        if slices > SLICES or found == done:
            return None
        done = _done(found)
    room = min(most, int(reach_offsets[-1]) + 2 * lts.transitions)
    afford(8 * 2 * room)
    labels, targets = np.zeros(room, dtype=np.int64), np.zeros(room, dtype=np.int64)
    keys, key_stamps = _table(room), _table(room)
    done = slices = 0
    while done < size:
        found = kernels.saturate(
            size,
            done,
            middles,
            ends,
            small_labels,
            lts.targets,
            reach_offsets,
            reached,
            int(taus_after),
            keys,
            key_stamps,
            slices * size,
            offsets,
            labels,
            targets,
            SLICE,
        )
        slices += 1
        if found < 0:
            if len(labels) == most:
                return None
            labels, targets = _longer(labels, most), _longer(targets, most)
            keys, key_stamps = _table(len(labels)), _table(len(labels))
        if slices > SLICES or found == done:
            return None
        done = _done(found)
    return Lts(offsets, labels[: offsets[-1]], targets[: offsets[-1]], lts.root)


def _done(found: int) -> int:
    """How many states are done: kernels tell -1 minus that where there is no room for the next."""
    return found if found >= 0 else -1 - found


def _longer(numbers: Numbers, most: int) -> Numbers:
    """The array with four times the room, but room for no more than *most*."""
    room = min(most, 4 * len(numbers) + 64)
    afford(numbers.itemsize * room)
    longer = np.zeros(room, dtype=numbers.dtype)
    longer[: len(numbers)] = numbers
    return longer


def _table(entries: int) -> Int64Array:
    """A hash table for more than so many entries, a power of two, all 0."""
    size = 2 << (entries + 1).bit_length()
    afford(8 * size)
    return np.zeros(size, dtype=np.int64)


def _spans(lts: Lts) -> tuple[Int64Array, Int64Array, Int64Array, Int64Array]:
    """Where the taus of each state begin, where they end and the rest begins and ends; and labels as small numbers."""
    starts, ends = np.ascontiguousarray(lts.offsets[:-1]), np.ascontiguousarray(lts.offsets[1:])
    before = np.concatenate([[0], np.cumsum(lts.labels == TAU)])
    _, labels = np.unique(np.append(TAU, lts.labels), return_inverse=True)
    return starts, starts + before[ends] - before[starts], ends, labels[1:].astype(np.int64)


class _Rounds:
    """Refinement by signatures, which are all computed anew in each round.

    A signature has classes where a saturated machine has states; long sequences of taus through few classes, which
    make that one large, are no trouble here.

    Attributes:
        slices: how often machine code has come back.
    """

    def __init__(self, lts: Lts) -> None:
        self.slices = 0
        self._size = lts.states
        self._kernels = tau_kernels_for(lts.states)
        self._starts, self._middles, self._ends, self._labels = _spans(lts)
        self._targets = lts.targets
        self._table, self._table_stamps = _table(0), _table(0)

    def reached(self, block: Int64Array) -> Signatures:
        """The classes that taus lead to from each state."""
        return self._round(taus.DELAY, block, _NOTHING, self._middles)[2]

    def refined(self, kind: int, block: Int64Array, behind: Signatures = _NOTHING) -> tuple[Int64Array, int]:
        """What a partition falls into, numbered in the order of first occurrence, and how many classes that are.

        Args:
            kind: see :mod:`cspcheck.checker.kernels.taus`.
            block: the partition.
            behind: for weak bisimulation what :meth:`reached` gives.
        """
        return self._round(kind, block, behind, self._ends)[:2]

    def sifted(self, kind: int, block: Int64Array) -> Int64Array:
        """A partition between *block* and what refining it to the end gives, found without writing signatures down.

        States of different least weights (``kernels.taus.least_keys``) have different signatures; that equal weights
        say nothing costs time only. Weights are drawn anew in each round, always the same ones.
        """
        drawn = np.random.default_rng(1)
        labels = int(self._labels.max(initial=0)) + 1
        none = np.zeros(0, dtype=np.int64)
        least, behind = np.zeros(self._size, dtype=np.int64), np.zeros(self._size, dtype=np.int64)
        classes, idle = int(block.max()) + 1, 0
        while idle < IDLE:
            weights, shifts = (drawn.integers(0, 1 << 61, size=count) for count in (classes, labels))
            spans = (self._starts, self._middles)
            if kind == taus.WEAK:
                self._kernels.least_keys(
                    *spans, self._middles, self._labels, self._targets, block, weights, shifts, none, behind
                )
            self._kernels.least_keys(
                *spans,
                self._ends,
                self._labels,
                self._targets,
                block,
                weights,
                shifts,
                behind if kind == taus.WEAK else none,
                least,
            )
            self.slices += 1
            pairs = distinct(least)
            block = numbered(block * len(pairs) + np.searchsorted(pairs, least))
            found = int(block.max()) + 1
            idle, classes = (idle + 1 if found == classes else 0), found
        return block

    def _round(
        self, kind: int, block: Int64Array, behind: Signatures, ends: Int64Array
    ) -> tuple[Int64Array, int, Signatures]:
        size = self._size
        group, representatives, hashes = (np.zeros(size, dtype=np.int64) for _ in range(3))
        slots = np.full(2 << (size + 1).bit_length(), -1, dtype=np.int64)
        afford(8 * (4 * size + len(slots) + 2 * (size + len(self._targets))))
        offsets = np.zeros(size + 1, dtype=np.int64)
        signatures = Signatures(offsets, np.zeros(2 * (size + len(self._targets)), dtype=np.int64))
        done = groups = 0
        while done < size:
            if len(self._table) <= len(signatures.keys):
                self._table, self._table_stamps = _table(len(signatures.keys)), _table(len(signatures.keys))
            classes = RefinedPartition(block, group, representatives, hashes, slots, self._table, self._table_stamps)
            found, groups = self._kernels.refine_by_signatures(
                done,
                self._starts,
                self._middles,
                ends,
                self._labels,
                self._targets,
                kind,
                classes,
                self.slices * size,
                signatures,
                behind,
                groups,
                SLICE,
            )
            self.slices += 1
            done = _done(found)
            if found < 0:
                signatures = Signatures(offsets, _longer(signatures.keys, 4 * len(signatures.keys)))
        return group, groups, signatures


def _by_signatures(lts: Lts, diverging: BoolArray, kind: int, slices: int | None = None) -> Int64Array | None:
    """The classes of branching, delay or weak bisimulation; None if machine code comes back more than *slices* times.

    Args:
        lts: a machine whose taus lead to states of smaller numbers only.
        diverging: shape (states,): the states that an infinite path of taus started from before cycles were removed.
        kind: see :mod:`cspcheck.checker.kernels.taus`.
        slices: as often machine code may come back.
    """
    rounds = _Rounds(lts)
    block = numbered(_apart(lts, diverging))
    classes = int(block.max()) + 1
    while slices is None or rounds.slices <= slices:
        if kind != taus.BRANCHING and lts.states > FEW:
            block = rounds.sifted(kind, block)
            classes = int(block.max()) + 1
        behind = rounds.reached(block) if kind == taus.WEAK else _NOTHING
        block, found = rounds.refined(kind, block, behind)
        if found == classes:
            return block
        classes = found
    return None
