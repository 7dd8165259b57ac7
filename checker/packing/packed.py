"""Networks packed for the search: states as a few machine words, rules as masks on them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product as cartesian

import numpy as np
import numpy.typing as npt

from cspcheck.checker.arrays import Int64Array, distinct
from cspcheck.checker.kernels.arrays import Index, Rules
from cspcheck.checker.network.network import Network
from cspcheck.checker.packing.index import HOME_BITS, LISTED, Listings, make_homes
from cspcheck.checker.packing.instances import (
    Instances,
    LocalTransitions,
    Products,
    RuleGroup,
    group_rules,
    multiply_out,
    rules_in_arrays,
)
from cspcheck.checker.packing.layout import BitField, Layout, lay_out, packed_state
from cspcheck.checker.packing.overlaps import careful_events, cycling_rules
from cspcheck.cspm.process.events import TAU, TICK

INSTANCES_PER_RULE = 4_096
"""A rule of several participants that would have more instances stays a product."""
INSTANCES = 4_000_000
"""When all rules of several participants together would have more instances, the largest stay products."""


@dataclass(frozen=True, eq=False, slots=True)
class PackedNetwork:
    """A network whose states are rows of ``words`` integers.

    Attributes:
        network: where it comes from.
        layout: how a state is laid out in words of 63 bits.
        events: the event identifiers by dense number: tau, tick, then the other results of rules, ascending.
        initial: the initial state, shape (words,).
        rules: the rules as masks and tables.
        tau: the index of the rules with the result tau.
        visible: the index of the others.
        cycling: the index of those rules with the result tau that could take part in a cycle of taus.
        terminated: shape (patterns, 2, words): a state is one after tick when it agrees with the second row of a
            pattern in the bits of the first.
        participants: the participants of the widest product.
        causes: the ``cause`` of each rule of the network.
    """

    network: Network
    layout: Layout
    events: Int64Array
    initial: Int64Array
    rules: Rules
    tau: Index
    visible: Index
    cycling: Index
    terminated: Int64Array
    participants: int
    causes: Int64Array

    @property
    def words(self) -> int:
        """How many words a state has."""
        return self.layout.words

    @property
    def is_narrowed(self) -> bool:
        """Whether it is searched by partial order, which leaves states out."""
        return len(self.rules.stubborn.word) > 0

    def pack(self, format: int, local_states: Sequence[int]) -> Int64Array:
        """The packed state, shape (words,). ``local_states`` has one entry per slot, 0 for slots not in use."""
        return packed_state(self.layout, format, local_states)

    def format(self, state: Sequence[int] | Int64Array) -> int:
        """The format of a packed state."""
        field = self.layout.format
        return int(state[field.word]) >> field.shift & (1 << field.width) - 1

    def local_states(self, state: Sequence[int] | Int64Array) -> tuple[int, ...]:
        """The local state of each slot in a packed state; 0 for slots not in use."""
        words = [int(word) for word in state]
        return tuple(words[f.word] >> f.shift & (1 << f.width) - 1 for f in self.layout.slots)

    def is_terminated(self, state: Sequence[int] | Int64Array) -> bool:
        """Whether a state is the one after tick."""
        return bool(self.are_terminated(np.asarray(state, dtype=np.int64).reshape(1, -1))[0])

    def are_terminated(self, states: Int64Array) -> npt.NDArray[np.bool_]:
        """For packed states, shape (states, words), which of them are those after tick."""
        terminated = np.zeros(len(states), dtype=np.bool_)
        for mask, value in self.terminated:
            terminated |= ((states & mask) == value).all(axis=1)
        return terminated


def pack(
    network: Network, *, instances_per_rule: int = INSTANCES_PER_RULE, instances: int = INSTANCES
) -> PackedNetwork:
    """Lay out the states of a network and turn its rules into masks and tables.

    Args:
        network: what to pack.
        instances_per_rule: a rule of several participants that would have more instances stays a product.
        instances: when all rules would have more together, the largest stay products.
    """
    layout = lay_out(network)
    results = {rule.result for rule in network.rules} - {TAU, TICK}
    events = np.array([TAU, TICK, *sorted(results)], dtype=np.int64)
    causes = np.array([rule.cause for rule in network.rules], dtype=np.int64)
    local = [LocalTransitions(slot.lts) for slot in network.slots]
    groups = group_rules(network, local, events)
    largest = _largest_instance(groups, instances_per_rule, instances)

    multiplied: list[tuple[RuleGroup, Instances]] = []
    kept: list[RuleGroup] = []
    products = Products.none(layout, local)
    for group in groups:
        small = group.sizes() <= largest if len(group.slots) > 1 else np.ones(len(group.numbers), dtype=np.bool_)
        if small.any():
            chosen = group.select(small)
            multiplied.append((chosen, multiply_out(chosen, layout, local, causes)))
        if not small.all():
            kept.append(group.select(~small))
            products.add(kept[-1])

    exact = [(group, True) for group, _ in multiplied] + [(group, False) for group in kept]
    blocks = [block for _, block in multiplied]
    rules = rules_in_arrays(layout, blocks, products, careful_events(exact, local, events))
    cycling = cycling_rules(network, groups, local)
    listings = _listings(layout, local, network.formats, blocks, kept)
    # Lists name product p as -1 - p, which is where these arrays have it.
    event = np.concatenate([rules.event, rules.product_event[::-1]]).astype(np.int64)
    rule = np.concatenate([rules.rule, rules.product_rule[::-1]]).astype(np.int64)

    def order(items: Int64Array) -> Int64Array:
        numbers: Int64Array = event[items] * (len(network.rules) + 1) + rule[items]
        return numbers

    if network.is_prioritised:
        rules = _with_priority(rules, network, listings, rule, order)
    return PackedNetwork(
        network,
        layout,
        events,
        _initial(network, layout),
        rules,
        listings.index(lambda items: event[items] == TAU, order),
        listings.index(lambda items: event[items] != TAU, order),
        listings.index(lambda items: cycling[rule[items]], order),
        _terminated(layout, network),
        int(np.diff(rules.participants).max(initial=0)),
        causes,
    )


def _with_priority(
    rules: Rules, network: Network, listings: Listings, rule: Int64Array, order: Callable[[Int64Array], Int64Array]
) -> Rules:
    """The arrays with what rules raise and yield to; *rule* tells the rule of an item."""
    yields = np.array([each.yields for each in network.rules], dtype=np.int64)
    asked = int(np.bitwise_or.reduce(yields))
    raises = np.array([each.raises & asked for each in network.rules], dtype=np.int64)
    return rules._replace(
        raises=raises, yields=yields, urgent=listings.index(lambda items: raises[rule[items]] != 0, order)
    )


def _largest_instance(groups: Sequence[RuleGroup], instances_per_rule: int, instances: int) -> float:
    """Rules of several participants with more instances than this stay products."""
    sizes = np.sort(np.concatenate([np.zeros(1), *(group.sizes() for group in groups if len(group.slots) > 1)]))
    fitting = sizes[(sizes <= instances_per_rule) & (np.cumsum(sizes) <= instances)]
    return float(fitting[-1])


def _listings(
    layout: Layout,
    local: Sequence[LocalTransitions],
    formats: int,
    blocks: Sequence[Instances],
    products: Sequence[RuleGroup],
) -> Listings:
    """The lists of all homes: of shared ones, or of one home a field where those would be too long."""
    for homes, most in ((make_homes(layout, HOME_BITS), LISTED), (make_homes(layout, 0), None)):
        listings = Listings(layout, local, formats, homes, most)
        first = 0
        for block in blocks:
            listings.add_instances(block, first)
            first += len(block.rows)
        first = 0
        for group in products:
            listings.add_products(group, first)
            first += len(group.numbers)
        if not listings.overflow:
            break
    return listings


def _initial(network: Network, layout: Layout) -> Int64Array:
    local_states = [0] * len(network.slots)
    for slot, state in network.initial:
        local_states[slot] = state
    return packed_state(layout, network.initial_format, local_states)


def _terminated(layout: Layout, network: Network) -> Int64Array:
    """The patterns of ``PackedNetwork.terminated``."""
    ticks = [rule for rule in network.rules if rule.result == TICK]
    patterns: set[tuple[tuple[int, ...], tuple[int, ...]]] = set()
    if network.formats > 1:
        if ticks:
            fields = [layout.format, *layout.slots]
            patterns.add(_pattern(layout, fields, [network.formats - 1] + [0] * len(network.slots)))
    else:
        for rule in ticks:
            fields = [layout.slots[slot] for slot, _ in rule.moves]
            machines = [network.slots[slot].lts for slot, _ in rule.moves]
            after = [
                distinct(machine.targets[machine.labels == label]).tolist()
                for machine, (_, label) in zip(machines, rule.moves, strict=True)
            ]
            patterns.update(_pattern(layout, fields, states) for states in cartesian(*after))
    return np.array(sorted(patterns), dtype=np.int64).reshape(-1, 2, layout.words)


def _pattern(
    layout: Layout, fields: Sequence[BitField], values: Sequence[int]
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """The bits of some fields, and their values in place."""
    mask, value = [0] * layout.words, [0] * layout.words
    for field, number in zip(fields, values, strict=True):
        mask[field.word] |= field.mask
        value[field.word] |= number << field.shift
    return tuple(mask), tuple(value)
