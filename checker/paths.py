"""Canonical paths through an exploration: the ones that counterexamples show."""

from __future__ import annotations

from dataclasses import dataclass

from checker.lts import Int64Array
from checker.search import Exploration


@dataclass(frozen=True, slots=True)
class Step:
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


def shortest_path(exploration: Exploration, goals: Int64Array, ranks: Int64Array | None = None) -> tuple[Step, ...]:
    """The canonical path from the initial state to one of the states with the indices *goals*.

    It has the fewest visible events; among those paths the lexicographically least sequence of visible events (by
    identifier); then a goal of the least rank; then the fewest taus; then at each step the least (event, cause,
    target words, rule). Nothing of that depends on the order of discovery.

    Args:
        exploration: where to look; limits it ran into do not matter as long as the goals are in it.
        goals: at least one index into ``exploration.states``.
        ranks: aligned with *goals*; all equal if None.
    """
    raise NotImplementedError


def tau_loop(exploration: Exploration, start: int) -> tuple[Step, ...]:
    """The shortest cycle of taus through the state with index *start*, least in the order of :func:`shortest_path`.

    Raises:
        ValueError: the state is on no such cycle.
    """
    raise NotImplementedError
