"""What a network's rules say about its states before any state is looked at.

Three questions whose honest answer is mostly no, and then costs nothing during the search: can two rules give the
same transition, can a state have two targets for one event, can taus go round in a cycle. Each answer errs on the
side of yes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int64Array, UInt8Array
from cspcheck.checker.kernels.arrays import MAY_BRANCH, MAY_REPEAT
from cspcheck.checker.network.network import Network
from cspcheck.checker.packing.instances import LocalTransitions, RuleGroup
from cspcheck.cspm.process.events import TAU

COMPARED = 200
"""More rules than this with one result in one format are not compared with each other."""
ANALYSED = 100_000
"""Local transitions past which no one looks whether taus can go round."""


class _Participation:
    """One rule of a group, as far as it overlaps with others."""

    __slots__ = ("cleared", "exact", "format_after", "group", "row", "slots")

    def __init__(self, group: RuleGroup, row: int, exact: bool) -> None:
        self.group = group
        self.row = row
        self.exact = exact
        self.slots = dict(zip(group.slots, range(len(group.slots)), strict=True))
        switch = group.switch
        self.format_after = group.format if switch is None else switch.format
        self.cleared = set() if switch is None else {*switch.cleared, *(slot for slot, _ in switch.started)}

    def steps(self, slot: int, local: Sequence[LocalTransitions]) -> tuple[Int64Array, Int64Array]:
        """The sources and targets of what *slot* contributes."""
        i = self.slots[slot]
        part = slice(int(self.group.starts[self.row, i]), int(self.group.ends[self.row, i]))
        return local[slot].sources[part], local[slot].targets[part]


def careful_events(
    groups: Iterable[tuple[RuleGroup, bool]], local: Sequence[LocalTransitions], events: Int64Array
) -> UInt8Array:
    """For each dense event which of ``MAY_REPEAT`` and ``MAY_BRANCH`` it needs.

    Args:
        groups: the rules; True with those whose equal instances have been dropped already.
        local: the transitions of each slot.
        events: the identifiers by dense number.
    """
    care = np.zeros(len(events), dtype=np.uint8)
    together: dict[tuple[int, int], list[_Participation]] = {}
    for group, exact in groups:
        branching = (group.ends - group.starts != group.enabled).any(axis=1)
        care[group.events[branching]] |= MAY_BRANCH
        for row, event in enumerate(group.events.tolist()):
            together.setdefault((event, group.format), []).append(_Participation(group, row, exact))
    for (event, _), rules in together.items():
        if len(rules) > COMPARED:
            care[event] |= MAY_BRANCH
            if any(not r.exact or r.cleared or _idle_slots(r, local) for r in rules):
                care[event] |= MAY_REPEAT
            continue
        for one, other in combinations(rules, 2):
            if _both_enabled(one, other, local):
                care[event] |= MAY_BRANCH
                if _same_result(one, other, local):
                    care[event] |= MAY_REPEAT
                    break
    care[TAU] &= MAY_REPEAT
    return care


def _idle_slots(rule: _Participation, local: Sequence[LocalTransitions]) -> set[int]:
    """The participants that can take part without changing their local state."""
    idle: set[int] = set()
    for slot in rule.slots:
        sources, targets = rule.steps(slot, local)
        if (sources == targets).any():
            idle.add(slot)
    return idle


def _both_enabled(one: _Participation, other: _Participation, local: Sequence[LocalTransitions]) -> bool:
    """Whether no shared participant keeps the two rules from firing in the same state."""
    shared = one.slots.keys() & other.slots.keys()
    return all(len(np.intersect1d(one.steps(slot, local)[0], other.steps(slot, local)[0])) for slot in shared)


def _same_result(one: _Participation, other: _Participation, local: Sequence[LocalTransitions]) -> bool:
    """Whether two rules that can fire in the same state could lead to the same state."""
    if one.format_after != other.format_after:
        return False
    if one.exact and other.exact and one.group is other.group:
        return False
    cleared = one.cleared | other.cleared
    for slot in (one.slots.keys() & other.slots.keys()) - cleared:
        states = local[slot].states
        (sources, targets), (other_sources, other_targets) = one.steps(slot, local), other.steps(slot, local)
        if not len(np.intersect1d(sources * states + targets, other_sources * states + other_targets)):
            return False
    return all(
        slot in _idle_slots(rule, local)
        for rule, partner in ((one, other), (other, one))
        for slot in rule.slots.keys() - partner.slots.keys() - cleared
    )


def cycling_rules(network: Network, groups: Sequence[RuleGroup], local: Sequence[LocalTransitions]) -> BoolArray:
    """For each rule of the network whether it has the result tau and could be part of a cycle of taus.

    On such a cycle every participant walks round in its own machine, by local transitions that rules of the cycle
    use, and so does the format. Rules one of whose participants cannot are dropped, until none is left to drop.
    """
    alive = np.zeros(len(network.rules), dtype=np.bool_)
    silent: list[RuleGroup] = []
    for group in groups:
        chosen = group.events == TAU
        if chosen.any():
            silent.append(group.select(chosen))
            alive[silent[-1].numbers] = True
    used = {slot for group in silent for slot in group.slots}
    if sum(len(local[slot].labels) for slot in used) > ANALYSED:
        return alive
    while True:
        before = int(alive.sum())
        living = [group.select(alive[group.numbers]) for group in silent]
        living = [group for group in living if len(group.numbers)]
        _drop_without_format_cycle(network, living, alive)
        # What a switch clears or starts moves in ways that no local transition shows.
        moved = {slot for group in living if group.switch for slot in group.switch.cleared}
        moved |= {slot for group in living if group.switch for slot, _ in group.switch.started}
        for slot in used - moved:
            _drop_without_local_cycle(slot, local[slot], living, alive)
        if int(alive.sum()) == before:
            return alive


def _drop_without_format_cycle(network: Network, groups: Sequence[RuleGroup], alive: BoolArray) -> None:
    formats = [(g.format, g.format if g.switch is None else g.switch.format) for g in groups]
    sources = np.array([before for before, _ in formats], dtype=np.int64)
    targets = np.array([after for _, after in formats], dtype=np.int64)
    for group, cyclic in zip(groups, _between_cycles(network.formats, sources, targets).tolist(), strict=True):
        if not cyclic:
            alive[group.numbers] = False


def _drop_without_local_cycle(
    slot: int, local: LocalTransitions, groups: Sequence[RuleGroup], alive: BoolArray
) -> None:
    parts = [(group, group.slots.index(slot)) for group in groups if slot in group.slots]
    inside = np.zeros(len(local.labels) + 1, dtype=np.int64)
    for group, i in parts:
        np.add.at(inside, group.starts[:, i], 1)
        np.add.at(inside, group.ends[:, i], -1)
    taken = np.flatnonzero(np.cumsum(inside[:-1]) > 0)
    cyclic = np.zeros(len(local.labels), dtype=np.int64)
    cyclic[taken] = _between_cycles(local.states, local.sources[taken], local.targets[taken])
    until = np.concatenate([[0], np.cumsum(cyclic)])
    for group, i in parts:
        alive[group.numbers[until[group.ends[:, i]] == until[group.starts[:, i]]]] = False


def _between_cycles(nodes: int, sources: Int64Array, targets: Int64Array) -> BoolArray:
    """Which edges stay when nodes without a way in or without a way out are taken away again and again."""
    stays = np.ones(len(sources), dtype=np.bool_)
    for tails, heads in ((sources, targets), (targets, sources)):
        edges: list[list[int]] = [[] for _ in range(nodes)]
        degree = [0] * nodes
        for edge in np.flatnonzero(stays).tolist():
            edges[int(tails[edge])].append(edge)
            degree[int(heads[edge])] += 1
        ended = [node for node in range(nodes) if not degree[node]]
        while ended:
            for edge in edges[ended.pop()]:
                stays[edge] = False
                head = int(heads[edge])
                degree[head] -= 1
                if not degree[head]:
                    ended.append(head)
    return stays
