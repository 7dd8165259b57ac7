"""A network read as it is written, one state at a time: for tests and for explaining counterexamples."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product

from cspcheck.checker.network.network import Network, Rule

NetworkState = tuple[int, tuple[int, ...]]
"""The format, and the local state of each slot (0 where it is not in use)."""


class Interpretation:
    """The states and transitions of a network, straight from the definitions in ``cspcheck.checker.network.network``.

    Attributes:
        network: what is interpreted.
        initial: the initial state.
    """

    def __init__(self, network: Network) -> None:
        self.network = network
        local = [0] * len(network.slots)
        for slot, state in network.initial:
            local[slot] = state
        self.initial: NetworkState = (network.initial_format, tuple(local))
        self._rules: dict[int, list[int]] = {}
        for number, rule in enumerate(network.rules):
            self._rules.setdefault(rule.format, []).append(number)
        self._rows: dict[tuple[int, int], dict[int, list[int]]] = {}

    def successors(self, state: NetworkState) -> list[tuple[int, NetworkState, int]]:
        """(event, state after it, number of the rule) for each way in which a rule fires, in the order of the rules."""
        format, local = state
        rules = self.network.rules
        possible: list[tuple[int, list[Sequence[int]]]] = []
        raised = 0
        for number in self._rules.get(format, ()):
            choices: list[Sequence[int]] = [
                self._row(slot, local[slot]).get(label, ()) for slot, label in rules[number].moves
            ]
            if all(choices):
                possible.append((number, choices))
                raised |= rules[number].raises
        return [
            (rules[number].result, _after(rules[number], format, local, targets), number)
            for number, choices in possible
            if not rules[number].yields & raised
            for targets in product(*choices)
        ]

    def _row(self, slot: int, state: int) -> dict[int, list[int]]:
        row = self._rows.get((slot, state))
        if row is None:
            row = self._rows[slot, state] = {}
            for label, target in self.network.slots[slot].lts.successors(state):
                row.setdefault(label, []).append(target)
        return row


def _after(rule: Rule, format: int, local: tuple[int, ...], targets: Sequence[int]) -> NetworkState:
    states = list(local)
    for (slot, _), target in zip(rule.moves, targets, strict=True):
        states[slot] = target
    if rule.switch is not None:
        format = rule.switch.format
        for slot in rule.switch.cleared:
            states[slot] = 0
        for slot, state in rule.switch.started:
            states[slot] = state
    return format, tuple(states)


def interpret(network: Network) -> Callable[[NetworkState], list[tuple[int, NetworkState, int]]]:
    """The successor function of a network on states (format, local states)."""
    return Interpretation(network).successors


def participants(rule: Rule) -> tuple[int, ...]:
    """The slots that move when a rule fires."""
    return tuple(slot for slot, _ in rule.moves)
