"""A few events, small processes written as terms, and a checker for them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from cspcheck.checker.check import Checker
from cspcheck.checker.semantics.transitions import explore
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.process.events import EventSet, EventTable
from cspcheck.cspm.process.terms import (
    AlphabetisedParallel,
    ExternalChoice,
    Hide,
    InternalChoice,
    Parallel,
    Prefix,
    Process,
    Reference,
    Sequential,
    SlidingChoice,
)
from tests.checker import explicit
from tests.checker.terms import alphabet, reference

EVENTS = alphabet(8)
a, b, c, d, e, f, g, h = range(2, 10)


@dataclass
class Terms:
    """What stands in for a script where processes are given as terms."""

    events: EventTable


def checker(events: EventTable = EVENTS, **options: Any) -> Checker:
    limits = Limits(**{name: options.pop(name) for name in ("states", "seconds", "memory_bytes") if name in options})
    return Checker(Terms(events), limits=limits, workers=options.pop("workers", 1), **options)


def events(*identifiers: int) -> EventSet:
    return EventSet.of(identifiers)


def then(*sequence: Any) -> Process:
    """``then(a, b, P)`` is ``a -> b -> P``."""
    process: Process = sequence[-1]
    for event in reversed(sequence[:-1]):
        process = Prefix(((event, process),))
    return process


def choose(*operands: Process) -> Process:
    return ExternalChoice(operands)


def perhaps(*operands: Process) -> Process:
    return InternalChoice(operands)


def interleave(*operands: Process) -> Process:
    return Parallel(EventSet(), operands)


def share(shared: EventSet, *operands: Process) -> Process:
    return Parallel(shared, operands)


def meet(*parts: tuple[EventSet, Process]) -> Process:
    return AlphabetisedParallel(tuple(part[0] for part in parts), tuple(part[1] for part in parts))


def hidden(process: Process, *identifiers: int) -> Process:
    return Hide(process, events(*identifiers))


def sequence(left: Process, right: Process) -> Process:
    return Sequential(left, right)


def timeout(left: Process, right: Process) -> Process:
    return SlidingChoice(left, right)


def forever(*sequence: int, name: str = "P") -> Reference:
    """``P = a -> b -> P``."""
    process: Reference = reference(name, lambda: then(*sequence, process))
    return process


def rows_of(process: Process) -> explicit.Rows:
    """The machine of the terms themselves."""
    machine = explore(process).lts
    rows = [set(machine.successors(state)) for state in range(machine.states)]
    # Brute force starts in state 0.
    assert machine.root == 0
    return rows


def identifiers(names: Iterable[str]) -> tuple[int, ...]:
    """The visible events among the names of a trace."""
    number = {EVENTS.name(event): event for event in [1, *range(2, 10)]}
    return tuple(number[name] for name in names if name != "tau")
