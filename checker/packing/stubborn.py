"""Partial order reduction: which rules may wait, and what of a network's states is kept when they do.

In a state only the rules of a stubborn set are taken (``cspcheck.checker.kernels.stubborn``): no matter what the others
do, they neither disable nor enable those, and can be taken afterwards to the same effect. What is kept:

* *Deadlocks*: every state without transitions that can be reached, by as many visible events as before. Any rule may be
  in a set. (Valmari, "Stubborn sets for reduced state space generation", 1990.)
* *Behaviour*: traces, stable failures and divergences with the traces before them. A set that leaves something out has
  taus only, and none that is *sticky*; what is sticky is chosen such that every cycle of taus has one, so that on every
  cycle there is a state that leaves nothing out. (Kurshan, Levin, Minea, Peled and Yenigün, "Static partial order
  reduction", TACAS 1998.) A stable state leaves nothing out, so what is refused is judged as before.
  (Valmari, "Stubborn set methods for process algebras", 1997.)
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int64Array, UInt8Array, distinct
from cspcheck.checker.kernels.arrays import StubbornTables
from cspcheck.checker.network.network import Network
from cspcheck.checker.packing.instances import LocalTransitions, RuleGroup, group_rules
from cspcheck.checker.packing.overlaps import cycling_rules
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.cspm.process.events import TAU

Kept = Literal["deadlocks", "behaviour"]
"""What a reduced search has of a network; see above."""

ENTRIES = 4_000_000
"""A network with more rules than this, each counted once a local state, is not reduced."""


def narrowed(packed: PackedNetwork, kept: Kept) -> PackedNetwork | None:
    """The network, searched by partial order; None for one that cannot be reduced.

    That is one of fewer than two components, one with priorities, where what a component may do depends on all the
    others, and one of very many rules.

    Args:
        packed: the network.
        kept: what is asked of it.
    """
    network = packed.network
    if len(network.slots) < 2 or network.is_prioritised:
        return None
    local = [LocalTransitions(slot.lts) for slot in network.slots]
    groups = group_rules(network, local, packed.events)
    if sum(int(group.enabled.sum()) for group in groups) > ENTRIES:
        return None
    free = np.ones(len(network.rules), dtype=np.uint8)
    if kept == "behaviour":
        free[:] = [rule.result == TAU for rule in network.rules]
        free[sticky_rules(network, groups, local)] = 0
    if not free.any():
        return None
    tables = _tables(packed, groups, local, free)
    return replace(packed, rules=packed.rules._replace(stubborn=tables))


def sticky_rules(network: Network, groups: list[RuleGroup], local: list[LocalTransitions]) -> BoolArray:
    """For each rule whether it is sticky: every cycle of taus has one that is.

    On a cycle every participant walks round in its own machine. Rules that close a way round in a machine are taken
    away, then those that cannot go round any more without them, until none is left.
    """
    sticky = np.zeros(len(network.rules), dtype=np.bool_)
    while True:
        alive = cycling_rules(network, _without(groups, sticky), local)
        cycling = _without(groups, ~alive)
        slot = next((group.slots[0] for group in cycling if group.slots), None)
        closing = [] if slot is None else _closing(slot, local[slot], cycling)
        if not closing:  # what is left, if anything is, goes round in ways that are not seen here
            return sticky | alive
        sticky[closing] = True


def _without(groups: list[RuleGroup], dropped: BoolArray) -> list[RuleGroup]:
    left = (group.select(~dropped[group.numbers]) for group in groups)
    return [group for group in left if len(group.numbers)]


def _closing(slot: int, local: LocalTransitions, groups: list[RuleGroup]) -> list[int]:
    """The rules by which a search of the slot's machine comes back to a state that it is in the midst of."""
    steps: list[list[tuple[int, int]]] = [[] for _ in range(local.states)]
    for group in groups:
        if slot not in group.slots:
            continue
        i = group.slots.index(slot)
        for row, number in enumerate(group.numbers.tolist()):
            part = slice(int(group.starts[row, i]), int(group.ends[row, i]))
            for source, target in zip(local.sources[part].tolist(), local.targets[part].tolist(), strict=True):
                steps[source].append((target, number))
    closing: list[int] = []
    entered, left = [False] * local.states, [False] * local.states
    for root in range(local.states):
        path = [] if entered[root] else [(root, iter(steps[root]))]
        entered[root] = True
        while path:
            state, rest = path[-1]
            for target, number in rest:
                if not entered[target]:
                    entered[target] = True
                    path.append((target, iter(steps[target])))
                    break
                if not left[target]:
                    closing.append(number)
            else:
                left[state] = True
                path.pop()
    return closing


def _tables(
    packed: PackedNetwork, groups: list[RuleGroup], local: list[LocalTransitions], free: UInt8Array
) -> StubbornTables:
    network, layout = packed.network, packed.layout
    sizes = [machine.states for machine in local]
    base = np.cumsum([0, *sizes]).astype(np.int64)
    rows: list[Int64Array] = []
    listed: list[Int64Array] = []
    ready: list[UInt8Array] = []
    known: dict[tuple[int, int, int], tuple[int, Int64Array]] = {}
    able_length = 0
    members: list[list[tuple[int, int]]] = [[] for _ in network.rules]
    wide: list[list[int]] = [[] for _ in range(network.formats)]
    for group in groups:
        for row, number in enumerate(group.numbers.tolist()):
            for i, slot in enumerate(group.slots):
                key = slot, int(group.starts[row, i]), int(group.ends[row, i])
                found = known.get(key)
                if found is None:
                    states = distinct(local[slot].sources[key[1] : key[2]])
                    flags = np.zeros(sizes[slot], dtype=np.uint8)
                    flags[states] = 1
                    ready.append(flags)
                    found = known[key] = able_length, states
                    able_length += len(flags)
                members[number].append((slot, found[0]))
                rows.append(base[slot] + found[1])
                listed.append(np.full(len(found[1]), number, dtype=np.int64))
            # What changes the shape moves slots that take no part in it.
            if group.switch is not None or not group.slots:
                wide[group.format].append(number)
    at = np.concatenate([np.zeros(0, dtype=np.int64), *rows])
    order = np.argsort(at, kind="stable")
    fields = layout.slots
    return StubbornTables(
        word=np.array([field.word for field in fields], dtype=np.int64),
        shift=np.array([field.shift for field in fields], dtype=np.int64),
        mask=np.array([(1 << field.width) - 1 for field in fields], dtype=np.int64),
        base=base[:-1].copy(),
        offsets=np.concatenate([[0], np.cumsum(np.bincount(at, minlength=int(base[-1])))]).astype(np.int64),
        entries=np.concatenate([np.zeros(0, dtype=np.int64), *listed])[order].astype(np.int32),
        format_word=layout.format.word,
        format_shift=layout.format.shift,
        format_mask=(1 << layout.format.width) - 1,
        format=np.array([rule.format for rule in network.rules], dtype=np.int32),
        parts=np.cumsum([0, *map(len, members)]).astype(np.int64),
        slot=np.array([slot for parts in members for slot, _ in parts], dtype=np.int32),
        able=np.array([place for parts in members for _, place in parts], dtype=np.int64),
        ready=np.concatenate([np.zeros(0, dtype=np.uint8), *ready]),
        wide_offsets=np.cumsum([0, *map(len, wide)]).astype(np.int64),
        wide=np.array([number for numbers in wide for number in numbers], dtype=np.int32),
        free=free,
    )
