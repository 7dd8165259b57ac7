"""The compression functions of scripts, as functions from explicit machines to smaller ones that mean the same.

Each keeps traces, failures and divergences. Bisimulations live in :mod:`cspcheck.checker.reduction.bisimulation`;
here are those that work on taus and acceptances (Roscoe, Understanding Concurrent Systems, section 16.3).
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from cspcheck.checker.arrays import Int64Array, distinct
from cspcheck.checker.guard import afford
from cspcheck.checker.kernels.diamonds import DONE, FULL, Detour, Shortcuts
from cspcheck.checker.kernels.jit import tau_kernels_for
from cspcheck.checker.lts import Lts, machine, reachable
from cspcheck.checker.reduction.bisimulation import (
    delay_bisimulation,
    factor_tau_loops,
    strong_bisimulation,
    weak_bisimulation,
)
from cspcheck.checker.specification.acceptances import StateAcceptances, divergent_states
from cspcheck.checker.specification.normaliser import Normaliser
from cspcheck.cspm.process.events import TAU

MOST = 1 << 20
"""So many states are looked at before machine code comes back."""


def eliminate_diamonds(lts: Lts) -> Lts:
    """``diamond``: states that only taus lead to disappear.

    A state takes over the visible transitions of all the states that its taus lead to. What remains of its taus is
    what failures and divergences can see: a tau to each stable state of least acceptance (none where its own offer is
    the only one), and a tau to itself where it diverges. A transition to a state that another of the same event
    leads to by taus is left out.
    """
    factored = factor_tau_loops(strong_bisimulation(lts))
    machine_of_taus, events = _shortcuts(factored)
    space = _detour(factored, len(events), len(machine_of_taus.accepted_offsets) - 1)
    space.seen[factored.root], space.pending[0] = 1, factored.root
    progress = np.array([0, 1, 0, 0], dtype=np.int64)
    room = 2 * factored.transitions + factored.states
    afford(3 * 8 * room)
    starts, labels, targets = (np.zeros(room, dtype=np.int64) for _ in range(3))
    kernels = tau_kernels_for(factored.states)
    while (found := kernels.diamonds(machine_of_taus, space, starts, labels, targets, progress, MOST)) != DONE:
        if found == FULL:
            afford(3 * 2 * starts.nbytes)
            rows = (np.append(numbers, np.zeros_like(numbers)) for numbers in (starts, labels, targets))
            starts, labels, targets = rows
    starts, labels, targets = (numbers[: progress[2]] for numbers in (starts, labels, targets))
    return reachable(machine(factored.states, starts, np.append(TAU, events)[labels], targets, factored.root))


def _shortcuts(lts: Lts) -> tuple[Shortcuts, Int64Array]:
    """The machine as the kernel has it, and the events that its labels stand for."""
    events: Int64Array = distinct(lts.labels[lts.labels != TAU])
    columns = np.searchsorted(events, lts.labels).astype(np.int64)
    before = np.concatenate([[0], np.cumsum(lts.labels == TAU)])
    starts, ends = np.ascontiguousarray(lts.offsets[:-1]), np.ascontiguousarray(lts.offsets[1:])
    accepting = StateAcceptances(lts, columns)
    by_size = sorted(range(len(accepting.acceptances)), key=lambda number: len(accepting.acceptances[number]))
    acceptances = [accepting.acceptances[number] for number in by_size]
    rank = np.zeros(len(by_size) + 1, dtype=np.int64)
    rank[by_size], rank[-1] = np.arange(len(by_size)), -1
    found = Shortcuts(
        starts,
        starts + before[ends] - before[starts],
        ends,
        columns,
        lts.targets,
        divergent_states(lts).astype(np.uint8),
        rank[accepting.number],
        np.concatenate([[0], np.cumsum([len(acceptance) for acceptance in acceptances])]).astype(np.int64),
        np.array([column for acceptance in acceptances for column in acceptance], dtype=np.int64),
    )
    return found, events


def _detour(lts: Lts, events: int, acceptances: int) -> Detour:
    def entries(number: int) -> Int64Array:
        return np.zeros(number, dtype=np.int64)

    states, slots = lts.states, 2 << (lts.transitions + 1).bit_length()
    afford(8 * (3 * states + lts.transitions + 2 * slots))
    return Detour(
        stamps=entries(states),
        queue=entries(states),
        seen=np.zeros(states, dtype=np.uint8),
        pending=entries(states),
        witness=np.full(acceptances, -1, dtype=np.int64),
        found=entries(acceptances),
        marks=entries(events),
        counts=entries(events),
        used=entries(events),
        places=entries(events),
        moved=entries(lts.transitions),
        keys=entries(slots),
        key_stamps=entries(slots),
    )


class TooManyNodes(Exception):
    """A normal form is larger than it may be."""


def normalise(lts: Lts, most: int | None = None) -> Lts:
    """``normal``: one state for each behaviour after a trace, with its acceptances behind taus.

    The subset construction: a state of the result is a set of states. Where a set has one acceptance and it is all
    that the set can do, the state is stable; otherwise a tau leads to one stable state for each minimal acceptance.
    A diverging set has a tau to itself.

    Raises:
        TooManyNodes: there are more than *most*.
    """

    def poll(nodes: int) -> None:
        if most is not None and nodes > most:
            raise TooManyNodes

    small = strong_bisimulation(lts)
    normaliser = Normaliser(small, "FD", collapse=False)
    nodes = normaliser.all_nodes(poll)
    diverging = normaliser.diverging().tolist()
    events, columns, targets = nodes.events.tolist(), nodes.columns.tolist(), nodes.targets.tolist()
    rows: list[list[tuple[int, int]]] = []
    chosen: list[list[tuple[int, int]]] = []
    for node, (start, end) in enumerate(pairwise(nodes.offsets.tolist())):
        row = list(zip(columns[start:end], targets[start:end], strict=True))
        moves = [(events[column], target) for column, target in row]
        acceptances = nodes.acceptance_sets[nodes.acceptance_set[node]]
        if diverging[node]:
            moves.append((TAU, node))
        if diverging[node] or acceptances != (tuple(column for column, _ in row),):
            for acceptance in map(set, acceptances):
                moves.append((TAU, nodes.nodes + len(chosen)))
                chosen.append([(events[column], target) for column, target in row if column in acceptance])
        rows.append(moves)
    if most is not None and len(rows) + len(chosen) > most:
        raise TooManyNodes
    return strong_bisimulation(Lts.from_successors(rows + chosen, nodes.root))


def normalise_if_small(lts: Lts) -> Lts:
    """``lazynorm``: ``normal``, unless that would be much larger than the machine; then bisimilar states together.

    To normalise lazily is to pay only for what is reached; here it is paid for only where it is cheap.
    """
    reduced = strong_bisimulation(lts)
    try:
        return normalise(reduced, 2 * reduced.states + 1_000)
    except TooManyNodes:
        return reduced


def compress_for_failures_divergences(lts: Lts) -> Lts:
    """``model_compress``: the smallest that these compressions reach together."""
    return strong_bisimulation(eliminate_diamonds(weak_bisimulation(lts)))


COMPRESSIONS: MappingProxyType[str, Callable[[Lts], Lts]] = MappingProxyType(
    {
        "sbisim": strong_bisimulation,
        "wbisim": weak_bisimulation,
        "dbisim": delay_bisimulation,
        "diamond": eliminate_diamonds,
        "tau_loop_factor": factor_tau_loops,
        "normal": normalise,
        "model_compress": compress_for_failures_divergences,
        "lazynorm": normalise_if_small,
        # To list the states of a component is what is asked for; that equal ones are listed once can only help.
        "explicate": strong_bisimulation,
        "lazyenumerate": strong_bisimulation,
    }
)
"""What each compression function of a script does to the machine of its operand."""
