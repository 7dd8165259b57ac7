"""Canonical paths through an exploration: the ones that counterexamples show.

A level is expanded again when it is needed; nothing of the search but its states is kept for this. Backwards, each
level's states are marked that lie on a shortest path to a goal; forwards, the least trace is followed through the
marked states; and along that trace the path with the fewest taus is picked.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int64Array, among, distinct
from cspcheck.checker.search.exploration import Exploration
from cspcheck.checker.search.walk import CHUNK, Transitions, Walk, backwards
from cspcheck.checker.sparse_rows import gather_rows
from cspcheck.cspm.interruption import during
from cspcheck.cspm.process.events import TAU

_FAR = np.iinfo(np.int64).max


@dataclass(frozen=True, slots=True)
class PathStep:
    """One transition.

    Attributes:
        event: what the whole performs, as an identifier (0 tau, 1 tick).
        rule: the number of the rule of the network that fired; its ``cause`` says what was hidden.
        state: the packed state afterwards.
        node: the specification's node afterwards in a pair search, else 0.
    """

    event: int
    rule: int
    state: tuple[int, ...]
    node: int = 0


def shortest_path(exploration: Exploration, goals: Int64Array, ranks: Int64Array | None = None) -> tuple[PathStep, ...]:
    """The canonical path from the initial state to one of the states with the indices *goals*.

    It has the fewest visible events; among those paths the lexicographically least sequence of visible events (by
    identifier); then a goal of the least rank; then the fewest taus; then at each step the least (event, cause,
    target words, rule). Nothing of that depends on the order of discovery.

    Args:
        exploration: where to look; limits it ran into do not matter as long as the goals are in it.
        goals: at least one index into ``exploration.states``.
        ranks: aligned with *goals*; all equal if None.
    """
    with during("looking for the shortest way to what was found"):
        return _shortest_path(exploration.walk, goals, ranks)


def _shortest_path(walk: Walk, goals: Int64Array, ranks: Int64Array | None) -> tuple[PathStep, ...]:
    goals = np.asarray(goals, dtype=np.int64)
    ranks = np.zeros(len(goals), dtype=np.int64) if ranks is None else ranks
    levels = walk.level_of(goals)
    last = int(levels.min())
    walk.keep(walk.levels[last + 1])
    goals, ranks = goals[levels == last], ranks[levels == last]
    trail = _least_trail(walk, _marked(walk, goals, last), last)
    reached = among(goals, trail.members[last])
    best = goals[reached & (ranks == ranks[reached].min())]
    return _fewest_taus(walk, trail, best)


def _marked(walk: Walk, goals: Int64Array, last: int) -> BoolArray:
    """Which states of the levels up to *last* lie on a path to a goal that makes a level with each visible event."""
    levels = np.array(walk.levels[: last + 2], dtype=np.int64)
    marks = np.zeros(levels[last + 1], dtype=np.bool_)
    above = last
    while above >= 0:
        # Several small levels at once, or a large one by itself.
        below = min(above, int(np.searchsorted(levels, levels[above + 1] - CHUNK)))
        first, end = int(levels[below]), int(levels[above + 1])
        seeds = [goals[(goals >= first) & (goals < end)]]
        inside: list[tuple[Int64Array, Int64Array]] = []
        for edges in walk.edges(first, end):
            made = np.searchsorted(levels, edges.targets, side="right")
            made -= np.searchsorted(levels, edges.sources, side="right")
            forward = (made == (edges.events != TAU)) & (edges.targets < len(marks))
            sources, targets = edges.sources[forward], edges.targets[forward]
            outside = targets >= end
            seeds.append(distinct(sources[outside][marks[targets[outside]]]))
            inside.append((sources[~outside], targets[~outside]))
        sources, targets = (np.concatenate(parts) for parts in zip(*inside, strict=True))
        marks[first:end] = backwards(sources, targets, first, end, np.concatenate(seeds)) >= 0
        above = below - 1
    return marks


@dataclass(frozen=True, eq=False, slots=True)
class _Trail:
    """The marked states that a trace leads to.

    Attributes:
        events: the dense events of the trace.
        members: for each level the states that the trace up to there leads to, closed under tau; ascending.
    """

    events: list[int]
    members: list[Int64Array]


def _least_trail(walk: Walk, marks: BoolArray, last: int) -> _Trail:
    """Follow the least visible event from the marked states of each level to those of the next."""
    trail = _Trail([], [])
    start = np.zeros(1, dtype=np.int64)
    for level in range(last + 1):
        members = _closed_under_tau(walk, marks, start, level)
        trail.members.append(members)
        if level < last:
            steps = walk.steps(members, taus=False)
            events, targets = steps.found.events, steps.targets
            forward = targets >= walk.levels[level + 1]
            forward &= (targets < walk.levels[level + 2]) & marks[np.minimum(targets, len(marks) - 1)]
            event = int(events[forward].min())
            trail.events.append(event)
            start = distinct(targets[forward & (events == event)])
    return trail


def _closed_under_tau(walk: Walk, marks: BoolArray, start: Int64Array, level: int) -> Int64Array:
    """The marked states of a level that taus lead to from *start*, these included; ascending."""
    members = frontier = start
    while len(frontier) and len(walk.packed.tau.items):
        targets = walk.steps(frontier, taus=True).targets
        targets = targets[(targets >= walk.levels[level]) & (targets < walk.levels[level + 1])]
        frontier = distinct(targets[marks[targets]])
        frontier = frontier[~among(frontier, members)]
        members = np.sort(np.concatenate([members, frontier]))
    return members


def _fewest_taus(walk: Walk, trail: _Trail, goals: Int64Array) -> tuple[PathStep, ...]:
    """The path along a trail to one of the goals with the fewest taus, least at each step."""
    rest = _taus_ahead(walk, trail, goals)
    steps: list[PathStep] = []
    level, here = 0, 0
    while True:
        ahead = int(rest[level][np.searchsorted(trail.members[level], here)])
        if level == len(trail.events) and ahead == 0:
            return tuple(steps)
        onwards = walk.transitions(np.array([here]))
        found, targets = onwards.found, onwards.targets
        fitting = (found.events == TAU) & (_look_up(trail.members[level], rest[level], targets) == ahead - 1)
        if level < len(trail.events):
            onward = _look_up(trail.members[level + 1], rest[level + 1], targets) == ahead
            fitting |= (found.events == trail.events[level]) & onward
        chosen = np.flatnonzero(fitting & (found.nodes >= 0))
        pick = chosen[_least(walk, found, chosen)]
        level += int(found.events[pick] != TAU)
        here = int(targets[pick])
        steps.append(_step(walk, found, int(pick)))


def _taus_ahead(walk: Walk, trail: _Trail, goals: Int64Array) -> list[Int64Array]:
    """For each level and each of the trail's members there, the fewest taus on a way along the trail to a goal."""
    rest: list[Int64Array] = []
    for level in range(len(trail.events), -1, -1):
        members = trail.members[level]
        taus = np.full(len(members), _FAR, dtype=np.int64)
        if level == len(trail.events):
            taus[among(members, distinct(goals))] = 0
        else:
            steps = walk.steps(members, taus=False)
            chosen = steps.found.events == trail.events[level]
            onward = _look_up(trail.members[level + 1], rest[-1], steps.targets[chosen])
            np.minimum.at(taus, steps.found.sources[chosen], onward)
        if len(walk.packed.tau.items):
            steps = walk.steps(members, taus=True)
            places = np.searchsorted(members, steps.targets)
            inside = _look_up(members, members, steps.targets) != _FAR
            taus = _relaxed(taus, steps.found.sources[inside], places[inside])
        rest.append(taus)
    return rest[::-1]


def _relaxed(taus: Int64Array, sources: Int64Array, targets: Int64Array) -> Int64Array:
    """The least over all ways of the number at the end plus the number of edges, by number in ascending order."""
    order = np.argsort(targets, kind="stable")
    sources = sources[order]
    starts = np.searchsorted(targets[order], np.arange(len(taus) + 1))
    later = taus[taus != _FAR]
    while len(later):
        number = later.min()
        reached = sources[gather_rows(starts, np.flatnonzero(taus == number))]
        taus[reached[taus[reached] > number + 1]] = number + 1
        later = taus[(taus > number) & (taus != _FAR)]
    return taus


def _look_up(keys: Int64Array, values: Int64Array, wanted: Int64Array) -> Int64Array:
    """The values of the wanted keys; _FAR for those that are not among the ascending *keys*."""
    places = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    return np.where(keys[places] == wanted, values[places], _FAR)


def _least(walk: Walk, found: Transitions, chosen: Int64Array) -> int:
    """Which of the chosen transitions is the least by (event, cause, target words, node, rule)."""
    stride = walk.visited.stride
    targets = found.targets.reshape(-1, stride)[chosen]
    words = targets if walk.pairs is None else walk.pairs.states(targets.reshape(-1))
    rules = found.rules[chosen]
    keys = [rules, found.nodes[chosen], *reversed(list(words.T)), walk.packed.causes[rules], found.events[chosen]]
    return int(np.lexsort(keys)[0])


def _step(walk: Walk, found: Transitions, pick: int) -> PathStep:
    row = found.targets.reshape(-1, walk.visited.stride)[pick]
    words = row if walk.pairs is None else walk.pairs.states(row)[0]
    return PathStep(
        int(walk.packed.events[found.events[pick]]),
        int(found.rules[pick]),
        tuple(words.tolist()),
        int(found.nodes[pick]),
    )


def tau_loop(exploration: Exploration, start: int) -> tuple[PathStep, ...]:
    """The shortest cycle of taus through the state with index *start*, least in the order of :func:`shortest_path`.

    Raises:
        ValueError: the state is on no such cycle.
    """
    walk = exploration.walk
    level = int(walk.level_of(np.array([start]))[0])
    first, end = walk.levels[level], walk.levels[level + 1]
    walk.keep(end)
    distance = backwards(*walk.tau_edges(level), first, end, np.array([start]))
    steps: list[PathStep] = []
    here, ahead = start, None
    while True:
        onwards = walk.steps(np.array([here]), taus=True)
        found, targets = onwards.found, onwards.targets
        inside = (targets >= first) & (targets < end)
        behind = np.where(inside, distance[np.where(inside, targets - first, 0)], -1)
        if ahead is None:
            if not (behind >= 0).any():
                raise ValueError("no cycle of taus leads through the state")
            ahead = int(behind[behind >= 0].min()) + 1
        chosen = np.flatnonzero(behind == ahead - 1)
        pick = int(chosen[_least(walk, found, chosen)])
        steps.append(_step(walk, found, pick))
        here, ahead = int(targets[pick]), ahead - 1
        if ahead == 0:
            return tuple(steps)
