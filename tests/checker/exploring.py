"""Networks explored by interpretation, and machines compared by the obvious fixpoint."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count

from cspcheck.checker.lts import Lts
from cspcheck.checker.network.interpretation import Interpretation
from cspcheck.checker.network.network import Network

Rows = list[set[tuple[int, int]]]


class TooLarge(Exception):
    """More states than a test wants to look at."""


def rows_of(lts: Lts) -> Rows:
    """The (label, target) pairs of each state of an explicit machine, whose root is 0."""
    assert lts.root == 0
    return [set(lts.successors(state)) for state in range(lts.states)]


def interpreted(network: Network, most: int = 100_000) -> Rows:
    """The reachable states of a network, the initial one first, each with its (event, target) pairs."""
    reading = Interpretation(network)
    number = {reading.initial: 0}
    rows: Rows = []
    for state in (order := [reading.initial]):
        rows.append(set())
        for event, after, _ in reading.successors(state):
            if after not in number:
                number[after] = len(order)
                order.append(after)
                if len(order) > most:
                    raise TooLarge
            rows[-1].add((event, number[after]))
    return rows


def transitions_in(rows: Rows) -> int:
    """How many transitions a machine has."""
    return sum(map(len, rows))


def strongly_bisimilar(left: Rows, right: Rows) -> bool:
    """Whether the roots of two machines are strongly bisimilar: split by successors' classes until nothing splits."""
    shift = len(left)
    rows: Sequence[set[tuple[int, int]]] = [*left, *({(e, t + shift) for e, t in row} for row in right)]
    classes = [0] * len(rows)
    while True:
        signatures: dict[tuple[int, frozenset[tuple[int, int]]], int] = {}
        numbers = count()
        refined = []
        for state, row in enumerate(rows):
            signature = (classes[state], frozenset((event, classes[target]) for event, target in row))
            if signature not in signatures:
                signatures[signature] = next(numbers)
            refined.append(signatures[signature])
        if len(signatures) == len(set(classes)):
            return refined[0] == refined[shift]
        classes = refined
