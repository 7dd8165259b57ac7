"""Where a component, or a composition of some, can tick: what else it offers there, as far as that matters.

Under a parallel operator a part that can tick ends by itself, unless it offers a clock: then it waits
(``semantics.parallel``). A component's machine knows which of the two it does in each of its states. The parts
of a composition that is itself an operand tick together, by one rule, and a rule cannot ask what is *not* offered: so
that composition must be seen never to end by itself. Else it is not taken apart.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from cspcheck.checker.arrays import distinct
from cspcheck.checker.lts import Lts
from cspcheck.cspm.process.events import TICK, EventSet
from cspcheck.cspm.process.terms import (
    NO_EVENTS,
    AlphabetisedParallel,
    Hide,
    LinkedParallel,
    Parallel,
    Process,
    Project,
    Rename,
)

Ending = EventSet | None
"""A state that can tick: the clocks that it offers, or None if it can do nothing but tick."""
Endings = frozenset[Ending]
"""How the states can be in which a part can tick."""


def of_machine(lts: Lts, clocks: EventSet, private: Sequence[int] = (), first_private: int = 0) -> Endings:
    """The endings of a component.

    Args:
        lts: its machine.
        clocks: the events that count.
        private, first_private: the events of labels from *first_private* on.
    """
    found: set[Ending] = set()
    labels, offsets = lts.labels, lts.offsets
    ticking = np.searchsorted(offsets, np.flatnonzero(labels == TICK), side="right") - 1
    for state in distinct(ticking).tolist():
        offered = labels[offsets[state] : offsets[state + 1]].tolist()
        if len(offered) == 1:
            found.add(None)
            continue
        events = [private[label - first_private] if private and label >= first_private else label for label in offered]
        found.add(EventSet.of(event for event in events if event in clocks))
    return frozenset(found)


def ends_alone(endings: Endings) -> bool:
    """Whether a part with these endings may terminate before the others, though it could do something else."""
    return NO_EVENTS in endings


def touches(operator: Process, clocks: EventSet) -> bool:
    """Whether a unary operator makes a difference to which clocks its operand offers."""
    match operator:
        case Hide():
            return not operator.events.isdisjoint(clocks)
        case Project():
            return bool(clocks - operator.events)
        case Rename():
            return any(old in clocks or new in clocks for old, new in operator.pairs)
    return False


def together(operator: Process, operands: Sequence[Endings]) -> Endings:
    """The endings of a parallel composition, given those of its operands under it."""
    if not all(operands):
        return frozenset()
    clocks = _clocks(operator)
    # What the operands so far offer, what one of them keeps from happening, and whether all have terminated.
    so_far: set[tuple[EventSet, EventSet, bool]] = {(NO_EVENTS, NO_EVENTS, True)}
    for i, endings in enumerate(operands):
        performs, shares = _part(operator, i, clocks)
        so_far = {
            (
                offered if ending is None else offered | (ending & performs),
                blocked | (shares if ending is None else shares - ending),
                terminated and ending is None,
            )
            for offered, blocked, terminated in so_far
            for ending in endings
        }
    return frozenset([None if terminated else offered - blocked for offered, blocked, terminated in so_far])


def _clocks(operator: Process) -> EventSet:
    assert isinstance(operator, Parallel | AlphabetisedParallel | LinkedParallel)
    return operator.clocks


def _part(operator: Process, i: int, clocks: EventSet) -> tuple[EventSet, EventSet]:
    """The clocks that operand *i* can perform under an operator, and those that need it."""
    match operator:
        case Parallel():
            return clocks, clocks & operator.events
        case AlphabetisedParallel():
            own = clocks & operator.alphabets[i]
            return own, own
        case LinkedParallel():
            return clocks - EventSet.of(link[i] for link in operator.links), NO_EVENTS
    raise AssertionError(f"{type(operator).__name__} is no parallel operator")


def union(endings: Iterable[Endings]) -> Endings:
    """What one of several parts may do."""
    return frozenset().union(*endings)
