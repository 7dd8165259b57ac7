"""Equivalences on the states of an explicit machine, and the quotients by them.

All three are the coarsest partition that is stable under a set of moves: those of the machine itself (strong
bisimulation), tau* a (delay bisimulation) or tau* a tau* (weak bisimulation). The latter two respect
divergence: a state with an infinite path of taus is never put together with one that has none, and its class
keeps a tau to itself; so the quotient has the same failures and divergences. None of them puts the state after a tick
together with a deadlock.
"""

from __future__ import annotations

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int64Array
from cspcheck.checker.kernels.jit import kernels_for
from cspcheck.checker.lts import Lts, machine, sources
from cspcheck.checker.reduction.partition import coarsest_partition, numbered, quotient
from cspcheck.checker.specification.acceptances import divergent_states
from cspcheck.cspm.process.events import TAU, TICK

SATURATED = 2_000_000
"""So many tau* a (tau*) moves are written down; where there are more, classes of targets are looked at instead."""


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


def _tau_abstracting_quotient(lts: Lts, *, taus_after: bool) -> Lts:
    # Strongly bisimilar states and those of a cycle of taus are equivalent in any case, and taking them together
    # first costs next to nothing.
    lts = strong_bisimulation(lts)
    components, diverging_states = tau_components(lts)
    diverging = np.zeros(int(components.max()) + 1, dtype=np.bool_)
    diverging[components[diverging_states]] = True
    starts, targets = components[sources(lts)], components[lts.targets]
    kept = (lts.labels != TAU) | (starts != targets)
    acyclic = machine(len(diverging), starts[kept], lts.labels[kept], targets[kept], int(components[lts.root]))
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
    return _by_rounds(lts, diverging, taus_after=taus_after)


def _apart(lts: Lts, diverging: BoolArray) -> Int64Array:
    """The partition to start with: states that diverge or have terminated are like no others."""
    return 2 * diverging.astype(np.int64) + terminated(lts)


def _saturated(lts: Lts, *, taus_after: bool, most: int) -> Lts | None:
    """The machine of the moves tau* and tau* a (tau*); None if there are more than *most*."""
    reach: list[list[int]] = []
    visible: list[set[tuple[int, int]]] = []
    moves = 0
    for state in range(lts.states):
        reached = {state}
        moved: set[tuple[int, int]] = set()
        for label, target in lts.successors(state):
            if label == TAU:
                reached.update(reach[target])
                moved |= visible[target]
            else:
                moved.add((label, target))
        reach.append(list(reached))
        visible.append(moved)
        moves += len(reached) + len(moved)
        if moves > most:
            return None
    if taus_after:
        moves = sum(map(len, reach)) + sum(len(reach[target]) for moved in visible for _, target in moved)
        if moves > most:
            return None
        visible = [{(label, after) for label, target in moved for after in reach[target]} for moved in visible]
    return Lts.from_successors(
        [[*((TAU, target) for target in reached), *moved] for reached, moved in zip(reach, visible, strict=True)]
    )


def _by_rounds(lts: Lts, diverging: BoolArray, *, taus_after: bool) -> Int64Array:
    """The classes, all signatures being computed anew in each round, from those that taus lead to.

    A signature has classes where a saturated machine has states; long sequences of taus through few classes, which
    make that one large, are no trouble here.
    """
    rows = [tuple(lts.successors(state)) for state in range(lts.states)]
    taus = [[target for label, target in row if label == TAU] for row in rows]
    moves = [[move for move in row if move[0] != TAU] for row in rows]
    block: list[int] = numbered(_apart(lts, diverging)).tolist()
    classes = max(block) + 1
    while True:
        reach: list[frozenset[int]] = []
        for number, targets in zip(block, taus, strict=True):
            reach.append(frozenset({number}).union(*(reach[target] for target in targets)))
        visible: list[frozenset[tuple[int, int]]] = []
        for own, targets in zip(moves, taus, strict=True):
            after = {
                (label, number)
                for label, target in own
                for number in (reach[target] if taus_after else (block[target],))
            }
            visible.append(frozenset(after).union(*(visible[target] for target in targets)))
        signatures: dict[tuple[int, frozenset[int], frozenset[tuple[int, int]]], int] = {}
        block = [
            signatures.setdefault(signature, len(signatures)) for signature in zip(block, reach, visible, strict=True)
        ]
        if len(signatures) == classes:
            return numbered(np.array(block, dtype=np.int64))
        classes = len(signatures)
