"""What a composition offers, put together from the offers of its operands, and which operands are missing for the rest.

An offer is whatever stands for somebody's readiness to perform an event: the move of a slot of a network, or a
component of a running composition. Both ways of finding out who waits for whom go through the operators with this.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

from cspcheck.cspm.process.events import TICK, EventSet, new_names

Offer = TypeVar("Offer")
Offers = dict[int, set[Offer]]
"""By event, taus apart, the offers that it can be made of."""
Missing = list[tuple[int, int]]
"""Positions of operands that would have to take part, each with the event that it would have to offer."""
Note = Callable[[set[Offer], Missing], None]
"""Notes offers that cannot be taken up, with who is missing."""


def joined(parts: Sequence[Offers[Offer]], alphabets: Iterable[EventSet], note: Note[Offer]) -> Offers[Offer]:
    """Operands that perform the events of their alphabets, and termination, only with all others that share them.

    Args:
        parts: the offers of each operand; an event outside its alphabet it performs alone.
        alphabets: as many.
        note: called for offers that lack a partner.
    """
    alphabets = tuple(alphabets)
    merged: Offers[Offer] = {}
    for event in sorted({event for part in parts for event in part}):
        having = [i for i, part in enumerate(parts) if event in part]
        offers = {offer for i in having for offer in parts[i][event]}
        missing = [
            (i, event)
            for i, alphabet in enumerate(alphabets)
            if (event == TICK or event in alphabet) and event not in parts[i]
        ]
        if missing:
            note(offers, missing)
        else:
            merged[event] = offers
    return merged


def within(part: Offers[Offer], alphabet: EventSet) -> Offers[Offer]:
    """The offers of an operand that performs nothing outside its alphabet but termination."""
    return {event: offers for event, offers in part.items() if event == TICK or event in alphabet}


def linked(
    left: Offers[Offer],
    right: Offers[Offer],
    links: Iterable[tuple[int, int]],
    note: Note[Offer],
    taken: Callable[[set[Offer]], None],
) -> Offers[Offer]:
    """Two operands whose linked events happen together, and inside; *taken* is called for those that can."""
    links = tuple(links)
    for a, b in links:
        if a in left and b in right:
            taken(left[a] | right[b])
        elif a in left:
            note(left[a], [(1, b)])
        elif b in right:
            note(right[b], [(0, a)])
    ends = ({a for a, _ in links}, {b for _, b in links})
    own = [
        {event: offers for event, offers in part.items() if event not in inside}
        for part, inside in zip((left, right), ends, strict=True)
    ]
    return joined(own, [EventSet(), EventSet()], note)


def renamed(part: Offers[Offer], pairs: Iterable[tuple[int, int]]) -> Offers[Offer]:
    """The offers under other names."""
    new = new_names(pairs)
    found: Offers[Offer] = {}
    for event, offers in part.items():
        for name in new.get(event, (event,)):
            found.setdefault(name, set()).update(offers)
    return found
