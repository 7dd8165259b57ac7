"""Dining philosophers twice: as CSP, and as a plain table of positions and forks."""

from __future__ import annotations

from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.definitions import Definition
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import AlphabetisedParallel, Prefix, Process, Reference

STEPS = 6
"""Take left, take right, eat, put right, put left, think."""


def _event(kind: int, n: int, philosopher: int, fork: int = 0) -> int:
    return 2 + (kind * n + philosopher) * n + fork


def philosophers(n: int) -> Process:
    """*n* philosophers who all take the left fork first, and *n* forks, each in its alphabet."""
    take, put, eat, think = range(4)

    def philosopher(i: int) -> tuple[EventSet, Process]:
        left, right = i, (i + 1) % n
        order = [
            _event(take, n, i, left),
            _event(take, n, i, right),
            _event(eat, n, i),
            _event(put, n, i, right),
            _event(put, n, i, left),
            _event(think, n, i),
        ]

        def body() -> Process:
            process: Process = itself
            for event in reversed(order):
                process = prefix(event, process)
            return process

        itself = Reference(("dining", n, "Phil", i), Definition(f"Phil({i})", None, body))
        return EventSet.of(order), itself

    def fork(i: int) -> tuple[EventSet, Process]:
        users = sorted((i, (i - 1) % n))
        events = [_event(kind, n, user, i) for kind in (take, put) for user in users]

        def body() -> Process:
            return Prefix(tuple((_event(take, n, user, i), prefix(_event(put, n, user, i), itself)) for user in users))

        itself = Reference(("dining", n, "Fork", i), Definition(f"Fork({i})", None, body))
        return EventSet.of(events), itself

    alphabets, operands = zip(*[philosopher(i) for i in range(n)], *[fork(i) for i in range(n)], strict=True)
    return AlphabetisedParallel(alphabets, operands)


def machine_of_philosophers(n: int) -> tuple[int, int, int]:
    """States, transitions and deadlocks of the table: a state is how many of ``STEPS`` each philosopher has done."""

    def holds(steps: int, i: int) -> set[int]:
        left, right = i, (i + 1) % n
        return [set(), {left}, {left, right}, {left, right}, {left}, set()][steps]

    def successors(state: tuple[int, ...]) -> list[tuple[int, ...]]:
        held = set().union(*(holds(steps, i) for i, steps in enumerate(state)))
        found = []
        for i, steps in enumerate(state):
            after = (steps + 1) % STEPS
            if not (holds(after, i) - holds(steps, i)) & held:
                found.append((*state[:i], after, *state[i + 1 :]))
        return found

    order = [(0,) * n]
    seen = set(order)
    moves = stuck = 0
    for state in order:
        after = successors(state)
        moves += len(after)
        stuck += not after
        for other in after:
            if other not in seen:
                seen.add(other)
                order.append(other)
    return len(order), moves, stuck
