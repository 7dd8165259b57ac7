"""What a composition can do, worked out from what its components can do, operator by operator.

An action is a rule in the making: which components move on which local labels, and what the whole performs. The
functions here turn the actions of operands into those of the operator applied to them, for the operators that keep
their shape: parallel composition, hiding and renaming. (The "supercombinators" of Goldsmith, "Operational semantics
for fun and profit", CSP25, 2005.)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import product
from math import prod
from typing import NamedTuple

from cspcheck.cspm.process.events import TAU, TICK, EventSet, new_names
from cspcheck.cspm.process.terms import Process

Path = tuple[int, ...]
"""A position in a term: which operand to take, from the root down."""
Moves = tuple[tuple[int, int], ...]


class Action(NamedTuple):
    """One way in which components step together.

    Attributes:
        result: the event that the whole performs.
        cause: what it was before it was hidden, or ``result``; TAU for a component's own tau.
        moves: (slot, local label) of each component that takes part.
        changes: for each position at which the action puts another term in the place of what was there, that term.
    """

    result: int
    cause: int
    moves: Moves
    changes: tuple[tuple[Path, Process], ...] = ()


MOST_ACTIONS = 2_000_000


class TooManyActions(Exception):
    """The operands of a composition can act together in more than ``MOST_ACTIONS`` ways."""


def hidden(actions: Iterable[Action], events: EventSet) -> list[Action]:
    r"""The actions of ``P \ events``."""
    return [a._replace(result=TAU) if a.result in events else a for a in actions]


def projected(actions: Iterable[Action], events: EventSet) -> list[Action]:
    r"""The actions of ``P |\ events``."""
    return [a if a.result in (TAU, TICK) or a.result in events else a._replace(result=TAU) for a in actions]


def renamed(actions: Iterable[Action], pairs: Iterable[tuple[int, int]]) -> list[Action]:
    """The actions of ``P [[pairs]]``: an event with several new names gives an action for each."""
    new = new_names(pairs)
    result = []
    for a in actions:
        if a.result in new:
            result.extend([a._replace(result=name, cause=name) for name in new[a.result]])
            if len(result) > MOST_ACTIONS:
                raise TooManyActions
        else:
            result.append(a)
    return result


def parallel(events: EventSet, operands: Sequence[Sequence[Action]]) -> list[Action]:
    """The actions of ``P [|events|] Q [|events|] ...``."""
    everyone = range(len(operands))
    done, offers = _separated(operands, lambda i, event: event in events)
    for event, by_operand in offers.items():
        _combine(done, event, [by_operand.get(i, ()) for i in everyone])
    return done


def alphabetised(alphabets: Sequence[EventSet], operands: Sequence[Sequence[Action]]) -> list[Action]:
    """The actions of ``P [A || B] Q`` and its n-ary form: an operand performs nothing outside its alphabet."""
    done, offers = _separated(operands, lambda i, event: True)
    sharing: dict[int, list[int]] = {event: [] for event in offers}
    for i, events in enumerate(alphabets):
        # Of many alphabets each is small as a rule, and there are many events.
        for event in events if len(events) < len(offers) else [event for event in offers if event in events]:
            if event in sharing:
                sharing[event].append(i)
    for event, by_operand in offers.items():
        _combine(done, event, [by_operand.get(i, ()) for i in sharing[event]])
    return done


def linked(links: Iterable[tuple[int, int]], left: Sequence[Action], right: Sequence[Action]) -> list[Action]:
    """The actions of ``P [a <-> b] Q``; the cause of a linked pair is the left event."""
    links = tuple(links)
    ends = ({a for a, _ in links}, {b for _, b in links})
    done, offers = _separated((left, right), lambda i, event: event in ends[i])
    for a, b in links:
        _combine(done, TAU, [offers.get(a, {}).get(0, ()), offers.get(b, {}).get(1, ())])
    return done


def together(result: int, participants: Sequence[Action]) -> Action:
    """The action that consists of actions of different components at once."""
    return Action(
        result,
        participants[0].cause,
        tuple([move for a in participants for move in a.moves]),
        tuple([change for a in participants for change in a.changes]),
    )


Offers = dict[int, dict[int, list[Action]]]
"""By event, by position of the operand: its actions with that event."""


def _separated(operands: Sequence[Sequence[Action]], shared: Callable[[int, int], bool]) -> tuple[list[Action], Offers]:
    """The actions that a parallel operator leaves to its operands, its own tick, and what the operands share.

    An operand ticks only when that is all it can do, so the ticks of all together are that of the whole.
    """
    done: list[Action] = []
    offers: Offers = {}
    ticks: list[list[Action]] = [[] for _ in operands]
    for i, actions in enumerate(operands):
        for a in actions:
            if a.result == TAU:
                done.append(a)
            elif a.result == TICK:
                ticks[i].append(a)
            elif shared(i, a.result):
                offers.setdefault(a.result, {}).setdefault(i, []).append(a)
            else:
                done.append(a)
    _combine(done, TICK, ticks)
    return done, offers


def _combine(done: list[Action], result: int, choices: Sequence[Sequence[Action]]) -> None:
    """Add the actions that consist of one of each of *choices*; if there are no choices there is no action."""
    number = prod(map(len, choices)) if choices else 0
    if not number:
        return
    if number + len(done) > MOST_ACTIONS:
        raise TooManyActions
    done.extend([together(result, participants) for participants in product(*choices)])
