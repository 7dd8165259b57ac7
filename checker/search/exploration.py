"""Breadth-first exploration of a packed network, level by level.

Level ``k`` holds the states whose shortest trace has ``k`` visible events; taus are free. What is asked of a
search is told per level, and levels do not depend on the order in which states are met, so neither do the answers
on the number of workers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from cspcheck.checker.arrays import Int64Array, distinct
from cspcheck.checker.guard import afford
from cspcheck.checker.lts import Lts
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.beyond import Beyond, prepared
from cspcheck.checker.search.checkpoint import Checkpoints
from cspcheck.checker.search.findings import StopReason
from cspcheck.checker.search.levels import NO_LIMITS, Progress
from cspcheck.checker.search.tau_cycles import divergent_states_of_level, tau_cyclic_states
from cspcheck.checker.search.walk import CHUNK, Transitions, Walk, transitions_of
from cspcheck.checker.verdict import Limits

__all__ = ["Exploration", "Progress", "StopReason", "Successors", "enabled", "explore", "successors"]


@dataclass(frozen=True, eq=False, slots=True)
class Successors:
    """The transitions of some states: those of the ``i``-th are the slice ``offsets[i]:offsets[i + 1]``.

    Within a state they are ordered by (event, target words) and distinct in them.

    Attributes:
        offsets: shape (states + 1,).
        events: shape (transitions,): event identifiers; 0 is tau, 1 is tick.
        targets: shape (transitions, words): packed states.
        rules: shape (transitions,): the rule of the network that fired; where several give the same transition, the
            one with the least (cause, rule number).
        nodes: shape (transitions,): in a pair search the node of the specification afterwards, -1 where the
            specification does not allow the event; otherwise all 0.
    """

    offsets: Int64Array
    events: Int64Array
    targets: Int64Array
    rules: Int64Array
    nodes: Int64Array


@dataclass(eq=False, slots=True)
class Exploration:
    """What a search has found. See :func:`explore`.

    Attributes:
        packed: the network that was explored.
        levels: the states of level ``k`` are the rows ``levels[k]:levels[k + 1]`` of ``states``. Only levels that
            were completed are counted: after a limit the states of the unfinished level are left out, so that what
            is reported can be reproduced.
        transitions: of all states in ``levels``, one per distinct (source, event, target).
        transitions_at: the same of the states up to each level.
        complete: whether every reachable state is in ``levels``.
        stop: why not, or None.
        found: states met when the search ended, those of an unfinished level included. After a limit it depends on
            chance.
        deadlock_level: the first level with a deadlock, or None.
        divergence_level: the first level with a cycle of taus (None also if they were not looked for).
        has_tau: whether a tau was met.
        branching: whether some state has two different targets for one visible event (tick included); in a pair
            search always False.
        peak_memory_bytes: the search's arrays at their largest.
        seconds: wall time.
    """

    packed: PackedNetwork
    levels: tuple[int, ...]
    transitions: int
    transitions_at: tuple[int, ...]
    complete: bool
    stop: StopReason | None
    found: int
    deadlock_level: int | None
    divergence_level: int | None
    has_tau: bool
    branching: bool
    peak_memory_bytes: int
    seconds: float
    _walk: Walk | Callable[[], Walk] = field(repr=False)

    @property
    def walk(self) -> Walk:
        """The states, to be walked about in; taken out of a larger search when they are first asked for.

        Raises:
            OSError: they are on a disk, and there was no room for what it takes.
        """
        if not isinstance(self._walk, Walk):
            self._walk = self._walk()
        return self._walk

    @property
    def depth(self) -> int:
        """The number of the last completed level; -1 if there is none."""
        return len(self.levels) - 2

    @property
    def states(self) -> Int64Array:
        """The packed states in the order of discovery, shape (states, words).

        A view; in a pair search a copy without the nodes, for which :meth:`states_at` is better.
        """
        return self.states_at(slice(0, self.walk.levels[-1]))

    @property
    def is_partial(self) -> bool:
        """Whether only the states are at hand that lead to what was found: the search was larger than memory."""
        return self.walk.levels[-1] < self.levels[-1]

    def states_at(self, indices: Int64Array | slice) -> Int64Array:
        """The packed states with the given indices, shape (indices, words)."""
        rows = self.walk.visited.states[indices]
        if self.walk.pairs is None:
            return rows
        return self.walk.pairs.states(rows.reshape(-1))

    def index(self, state: Int64Array, node: int = 0) -> int:
        """Where a packed state (with its node, in a pair search) is in ``states``; -1 if it is not."""
        return int(self.indices(np.asarray(state, dtype=np.int64).reshape(1, -1), np.array([node]))[0])

    def indices(self, states: Int64Array, nodes: Int64Array | None = None) -> Int64Array:
        """For each row of packed states (with its node, in a pair search) its place in ``states``, or -1."""
        if self.walk.pairs is None:
            return self.walk.find(states.reshape(-1))
        nodes = np.zeros(len(states), dtype=np.int64) if nodes is None else nodes
        return self.walk.find(self.walk.pairs.join(states, nodes))

    def deadlocked(self, level: int) -> Int64Array:
        """The states of a level that have no transition and are not the terminated state: ascending indices."""
        first, last = self.walk.levels[level], self.walk.levels[level + 1]
        parts: list[Int64Array] = []
        for start in range(first, last, CHUNK):
            until = min(last, start + CHUNK)
            moving = transitions_of(self.packed, self.walk.pairs, self.walk.span(start, until)).sources
            idle = start + np.flatnonzero(np.bincount(moving, minlength=until - start) == 0)
            parts.append(idle[~self.packed.are_terminated(self.states_at(idle))])
        return np.concatenate(parts)

    def divergent(self, level: int) -> Int64Array:
        """The states of a level from which an infinite path of taus starts: ascending indices."""
        if self.divergence_level is None:
            return np.zeros(0, dtype=np.int64)
        return divergent_states_of_level(self.walk, self.divergence_level, level)

    def tau_cyclic(self, level: int) -> Int64Array:
        """The states of a level that lie on a cycle of taus: ascending indices."""
        return tau_cyclic_states(self.walk, level)

    def successors(self, indices: Int64Array) -> Successors:
        """The transitions of some states."""
        rows = self.walk.rows(indices)
        return _distinct(self.packed, transitions_of(self.packed, self.walk.pairs, rows), len(indices), self._states_of)

    def _states_of(self, rows: Int64Array) -> Int64Array:
        """The packed states in flat rows of the search."""
        if self.walk.pairs is None:
            return rows.reshape(-1, self.packed.words)
        return self.walk.pairs.states(rows)

    def to_lts(self, limit: int | None = None) -> Lts:
        """The explored machine, its states in the order of discovery.

        Raises:
            ValueError: the exploration is not complete, or has more than *limit* states.
        """
        size = self.levels[-1]
        if not self.complete or self.is_partial:
            raise ValueError("the exploration is not complete")
        if limit is not None and size > limit:
            raise ValueError(f"{size:,} states are more than {limit:,}")
        # In pieces, and whole.
        afford(2 * (8 * size + 16 * self.transitions))
        lengths: list[Int64Array] = [np.zeros(1, dtype=np.int64)]
        labels: list[Int64Array] = [np.zeros(0, dtype=np.int64)]
        targets: list[Int64Array] = [np.zeros(0, dtype=np.int64)]
        for start, edges in zip(range(0, size, CHUNK), self.walk.edges(0, size), strict=True):
            order = np.lexsort([edges.targets, edges.events, edges.sources])
            keys = (edges.sources[order], edges.events[order], edges.targets[order])
            fresh = _first_of_runs(keys)
            lengths.append(np.bincount(keys[0][fresh] - start, minlength=min(CHUNK, size - start)))
            labels.append(self.packed.events[keys[1][fresh]])
            targets.append(keys[2][fresh])
        offsets = np.concatenate(lengths).cumsum()
        return Lts(offsets.astype(np.int64), np.concatenate(labels), np.concatenate(targets))


def explore(
    packed: PackedNetwork,
    *,
    limits: Limits = NO_LIMITS,
    workers: int = 1,
    stop_at_deadlock: bool = False,
    stop_at_divergence: bool = False,
    look_for_divergence: bool = True,
    progress: Callable[[Progress], None] | None = None,
    notify: Callable[[str], None] | None = None,
    compiled: bool | None = None,
    checkpoints: Checkpoints | None = None,
    beyond: Beyond | None = None,
) -> Exploration:
    """All reachable states of a network, breadth first.

    Args:
        packed: the network.
        limits: where to give up; the exploration is then not ``complete``.
        workers: threads to use once the machine turns out to be big. Results do not depend on it.
        stop_at_deadlock: end after the first level that has a deadlock.
        stop_at_divergence: end after the first level that has a cycle of taus.
        look_for_divergence: whether to look for cycles of taus at all.
        progress: called a few times a second.
        notify: called with one line when the kernels have to be compiled first, which takes some seconds.
        compiled: True or False to use compiled or interpreted kernels throughout; None: change to the compiled ones
            when the machine turns out to be big. Results do not depend on it.
        checkpoints: where to write the search down now and then, and to go on from, if it is there.
        beyond: where the search goes on, or is done, that may be too large for this process.
    """
    search = prepared(
        beyond,
        packed,
        None,
        limits=limits,
        workers=workers,
        stop_at_deadlock=stop_at_deadlock,
        stop_at_divergence=stop_at_divergence,
        look_for_divergence=look_for_divergence,
        progress=progress,
        notify=notify,
        compiled=compiled,
        checkpoints=checkpoints,
    )
    search.run()
    return Exploration(
        packed,
        tuple(search.levels),
        search.transitions,
        tuple(search.transitions_at),
        search.complete,
        search.stop,
        search.known,
        search.deadlock_level,
        search.divergence_level,
        search.has_tau,
        search.branching,
        search.peak_memory_bytes,
        search.seconds,
        search.walk if search.has_found else search.walk(),
    )


def successors(packed: PackedNetwork, states: Int64Array) -> Successors:
    """The transitions of any packed states, shape (states, words), reachable or not."""
    found = transitions_of(packed, None, states.reshape(-1))
    return _distinct(packed, found, len(states), lambda rows: rows.reshape(-1, packed.words))


def enabled(packed: PackedNetwork, state: Int64Array) -> tuple[int, ...]:
    """The event identifiers that a packed state can perform, ascending; 0 for tau."""
    found = transitions_of(packed, None, np.asarray(state, dtype=np.int64))
    return tuple(packed.events[distinct(found.events)].tolist())


def _distinct(
    packed: PackedNetwork, found: Transitions, size: int, states_of: Callable[[Int64Array], Int64Array]
) -> Successors:
    """The transitions in order, each once, with the rule of the least (cause, number)."""
    targets = states_of(found.targets)
    words = list(targets.T)
    order = np.lexsort(
        [found.rules, packed.causes[found.rules], found.nodes, *reversed(words), found.events, found.sources]
    )
    fresh = _first_of_runs([column[order] for column in (found.sources, found.events, *words)])
    kept = order[fresh]
    offsets = np.concatenate([[0], np.cumsum(np.bincount(found.sources[kept], minlength=size))]).astype(np.int64)
    return Successors(offsets, packed.events[found.events[kept]], targets[kept], found.rules[kept], found.nodes[kept])


def _first_of_runs(keys: tuple[Int64Array, ...] | list[Int64Array]) -> Int64Array:
    """Where in sorted columns a row differs from the one before."""
    fresh = np.zeros(len(keys[0]), dtype=np.bool_)
    fresh[:1] = True
    for key in keys:
        fresh[1:] |= key[1:] != key[:-1]
    return np.flatnonzero(fresh)
