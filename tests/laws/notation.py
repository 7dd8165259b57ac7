"""Short names for the operators, and how a law is stated.

A law is a function from processes, event sets, events, menus and renamings to a claim. What an argument is, is told by
its name: ``p q r`` are processes, ``x y z`` event sets, ``a b`` events, ``menu`` and ``other`` the branches of a
prefix choice, ``relation`` and ``second`` renamings of any kind, ``bijection`` one that permutes all events, and
``p2 q2`` processes that never perform the event c.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass

from hypothesis import strategies as st

from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import (
    AlphabetisedParallel,
    ExternalChoice,
    Hide,
    InternalChoice,
    Interrupt,
    Parallel,
    Prefix,
    Process,
    Rename,
    Sequential,
    SlidingChoice,
    SynchronisingChoice,
    SynchronisingInterrupt,
    Throw,
)
from tests.reference.processes import EVENTS, event_sets, processes, renamings
from tests.reference.verdicts import MODELS, Model

Pairs = tuple[tuple[int, int], ...]
Menu = tuple[tuple[int, Process], ...]

NONE = EventSet()


def external(*operands: Process) -> Process:
    return ExternalChoice(operands)


def internal(*operands: Process) -> Process:
    return InternalChoice(operands)


def sliding(p: Process, q: Process) -> Process:
    return SlidingChoice(p, q)


def synchronising_choice(p: Process, x: EventSet, q: Process) -> Process:
    return SynchronisingChoice(x, (p, q))


def interrupt(p: Process, q: Process) -> Process:
    return Interrupt(p, q)


def synchronising_interrupt(p: Process, x: EventSet, q: Process) -> Process:
    return SynchronisingInterrupt(p, x, q)


def throw(p: Process, x: EventSet, q: Process) -> Process:
    return Throw(p, x, q)


def sequence(p: Process, q: Process) -> Process:
    return Sequential(p, q)


def parallel(p: Process, x: EventSet, q: Process) -> Process:
    return Parallel(x, (p, q))


def interleave(p: Process, q: Process) -> Process:
    return Parallel(NONE, (p, q))


def alphabetised(p: Process, x: EventSet, y: EventSet, q: Process) -> Process:
    return AlphabetisedParallel((x, y), (p, q))


def hide(p: Process, x: EventSet) -> Process:
    return Hide(p, x)


def rename(p: Process, pairs: Pairs) -> Process:
    return Rename(p, tuple(sorted(set(pairs))))


def menu_of(branches: dict[int, Process]) -> Process:
    return Prefix(tuple(sorted(branches.items(), key=lambda branch: branch[0])))


@dataclass(frozen=True)
class Claim:
    """``left = right``, or ``left`` refined by ``right`` only."""

    left: Process
    right: Process
    both_ways: bool = True


def equal(left: Process, right: Process) -> Claim:
    return Claim(left, right)


def refined_by(left: Process, right: Process) -> Claim:
    return Claim(left, right, both_ways=False)


@dataclass(frozen=True)
class Law:
    name: str
    models: tuple[Model, ...]
    claim: Callable[..., Claim]

    def claims(self) -> st.SearchStrategy[Claim]:
        return st.builds(self.claim, **{name: ARGUMENTS[name] for name in inspect.signature(self.claim).parameters})


LAWS: list[Law] = []


def law(*models: Model) -> Callable[[Callable[..., Claim]], Callable[..., Claim]]:
    """Registers a law that holds in the given models; by default in all."""

    def registered(claim: Callable[..., Claim]) -> Callable[..., Claim]:
        LAWS.append(Law(claim.__name__, models or MODELS, claim))
        return claim

    return registered


_PROCESSES = processes(max_size=4)
_EVENT_SETS = event_sets()
_RENAMINGS = renamings()
_MENUS = st.dictionaries(st.sampled_from(EVENTS), processes(max_size=3), max_size=3).map(
    lambda branches: tuple(sorted(branches.items(), key=lambda branch: branch[0]))
)
ARGUMENTS: dict[str, st.SearchStrategy[object]] = {
    **dict.fromkeys(("p", "q", "r"), _PROCESSES),
    **dict.fromkeys(("p2", "q2"), processes(max_size=4, letters=2)),
    **dict.fromkeys(("x", "y", "z"), _EVENT_SETS),
    **dict.fromkeys(("a", "b"), st.sampled_from(EVENTS)),
    **dict.fromkeys(("menu", "other"), _MENUS),
    **dict.fromkeys(("relation", "second"), _RENAMINGS),
    "bijection": st.permutations(EVENTS).map(lambda images: tuple(zip(EVENTS, images, strict=True))),
}
