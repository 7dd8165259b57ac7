"""Families of processes for bulk comparison: related enough to refine each other about half the time."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator

from cspcheck.cspm.process.terms import Process
from tests.reference.denotations import Semantics, TooLarge, Unguarded
from tests.reference.processes import EVENTS, random_process
from tests.reference.surgery import relative, smaller
from tests.reference.verdicts import reachable

MEMBERS = 4
EXPRESSIONS = 400
"""A family whose denotations need more than these is left out."""


def families(seed: int) -> Iterator[tuple[Semantics, list[Process]]]:
    """Endlessly many families, the same for the same seed; their denotations are small."""
    rng = random.Random(seed)
    while True:
        letters = rng.choice((2, 3, 3))
        members = [random_process(rng, rng.randrange(2, 10), letters)]
        while len(members) < MEMBERS:
            members.append(relative(rng.choice(members), rng, letters))
        semantics = Semantics(EVENTS, EXPRESSIONS)
        try:
            for member in members:
                for _ in reachable(semantics.of(member)):
                    pass
        except (TooLarge, Unguarded):  # a changed guard need not guard any more
            continue
        yield semantics, members


def smallest(processes: tuple[Process, ...], wrong: Callable[..., object], tries: int = 3_000) -> tuple[Process, ...]:
    """Simpler processes of which *wrong* is still true: those to put into a message.

    What cannot be computed for a simpler process (no guard, too large) is not wrong.
    """

    def still_wrong(candidate: tuple[Process, ...]) -> bool:
        try:
            return bool(wrong(*candidate))
        except Exception:
            return False

    while True:
        for i, process in enumerate(processes):
            for simpler in smaller(process):
                tries -= 1
                candidate = (*processes[:i], simpler, *processes[i + 1 :])
                if tries > 0 and still_wrong(candidate):
                    break
            else:
                continue
            processes = candidate
            break
        else:
            return processes
