r"""The rules of the operators whose operands step together: ``[|A|]``, ``[A||B]``, ``[a <-> b]``, ``[+A+]``, ``/+A+\``.

Termination of the parallel operators is distributed (Roscoe 2010, section 6.2): an operand that can tick moves to
``SKIP`` by a tau, and the whole ticks when all its operands have. An operand whose only transition is tick counts
as terminated already, since the tau would change no behaviour and double the states. And an operand that can tick and
lets time pass (it offers a clock of the operator) *waits*: it keeps all that it can do, so that time does not stop for
the others, and the whole can tick when all its operands have terminated or wait.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import product
from typing import Any

from cspcheck.checker.semantics.steps import Normalise, Row, Step
from cspcheck.cspm.process.events import TAU, TICK, EventSet
from cspcheck.cspm.process.terms import (
    SKIP,
    TERMINATED,
    AlphabetisedParallel,
    LinkedParallel,
    Parallel,
    Process,
    SynchronisingChoice,
    SynchronisingInterrupt,
)

Operands = tuple[Process, ...]
Offers = dict[int, dict[int, list[Process]]]
"""By event, by position of the operand that can perform it: the states it can be in afterwards."""


def has_terminated(row: Row) -> bool:
    """Whether an operand with these transitions counts as terminated: it can tick and do nothing else."""
    return len(row) == 1 and row[0][0] == TICK


def waits(row: Iterable[tuple[int, object]], clocks: EventSet) -> bool:
    """Whether an operand with these transitions can tick and lets time pass until the others can, too."""
    if not clocks:
        return False
    events = {event for event, _ in row}
    return TICK in events and any(event in clocks for event in events)


def is_ready(row: Row, clocks: EventSet) -> bool:
    """Whether an operand does not keep the whole from ticking."""
    return has_terminated(row) or waits(row, clocks)


def _replaced(operands: Operands, i: int, operand: Process) -> Operands:
    return (*operands[:i], operand, *operands[i + 1 :])


def _together(operands: Operands, participants: Sequence[int], offers: dict[int, list[Process]]) -> Iterator[Operands]:
    """The operands after all *participants* have performed an event of which *offers* tells the outcomes.

    None if one of them cannot perform it.
    """
    if any(i not in offers for i in participants):
        return
    for outcome in product(*[offers[i] for i in participants]):
        after = list(operands)
        for i, operand in zip(participants, outcome, strict=True):
            after[i] = operand
        yield tuple(after)


def _alone(
    operands: Operands,
    rows: list[Row],
    clocks: EventSet,
    shared: Callable[[int, int], bool],
    rebuild: Callable[[Operands], Process],
) -> tuple[list[Step], Offers]:
    """What the operands of a parallel operator do on their own, and what they offer to do together.

    The tick of the whole is among the first. *shared(i, event)* tells whether operand *i* leaves the event to the
    operator.
    """
    steps: list[Step] = []
    offers: Offers = {}
    everyone_is_ready = True
    for i, row in enumerate(rows):
        if has_terminated(row):
            continue
        waiting = waits(row, clocks)
        everyone_is_ready = everyone_is_ready and waiting
        for event, after in row:
            if event == TICK:
                if not waiting:
                    steps.append((TAU, rebuild(_replaced(operands, i, SKIP))))
            elif event != TAU and shared(i, event):
                offers.setdefault(event, {}).setdefault(i, []).append(after)
            else:
                steps.append((event, rebuild(_replaced(operands, i, after))))
    if everyone_is_ready:
        steps.append((TICK, TERMINATED))
    return steps, offers


def _parallel(state: Normalise, p: Parallel, rows: list[Row]) -> list[Step]:
    events, clocks = p.events, p.clocks

    def rebuild(operands: Operands) -> Process:
        return Parallel(events, operands, clocks)

    steps, offers = _alone(p.operands, rows, clocks, lambda i, event: event in events, rebuild)
    everyone = range(len(rows))
    for event, by_operand in offers.items():
        steps.extend((event, rebuild(after)) for after in _together(p.operands, everyone, by_operand))
    return steps


_SHARING: dict[int, tuple[tuple[EventSet, ...], dict[int, list[int]]]] = {}
MOST_KEPT = 64
"""Compositions whose alphabets have been looked through for events."""


def sharing(alphabets: tuple[EventSet, ...], event: int) -> list[int]:
    """The operands that have an event in their alphabets; all states of a composition ask the same."""
    found = _SHARING.get(id(alphabets))
    if found is None:
        if len(_SHARING) == MOST_KEPT:
            _SHARING.clear()
        # The alphabets are kept with what is known of them, so that their identity stays theirs.
        found = _SHARING[id(alphabets)] = alphabets, {}
    known = found[1]
    if event not in known:
        known[event] = [i for i, alphabet in enumerate(alphabets) if event in alphabet]
    return known[event]


def _alphabetised(state: Normalise, p: AlphabetisedParallel, rows: list[Row]) -> list[Step]:
    """An operand performs nothing outside its alphabet."""
    alphabets, clocks = p.alphabets, p.clocks

    def rebuild(operands: Operands) -> Process:
        return AlphabetisedParallel(alphabets, operands, clocks)

    steps, offers = _alone(p.operands, rows, clocks, lambda i, event: True, rebuild)
    for event, by_operand in offers.items():
        participants = sharing(alphabets, event)
        if participants:
            steps.extend((event, rebuild(after)) for after in _together(p.operands, participants, by_operand))
    return steps


def _linked(state: Normalise, p: LinkedParallel, rows: list[Row]) -> list[Step]:
    operands = (p.left, p.right)
    linked = ({a for a, _ in p.links}, {b for _, b in p.links})

    def rebuild(after: Operands) -> Process:
        return LinkedParallel(after[0], p.links, after[1], p.clocks)

    steps, offers = _alone(operands, rows, p.clocks, lambda i, event: event in linked[i], rebuild)
    for a, b in p.links:
        lefts, rights = offers.get(a, {}).get(0, ()), offers.get(b, {}).get(1, ())
        steps.extend((TAU, rebuild(after)) for after in product(lefts, rights))
    return steps


def _synchronising_choice(state: Normalise, p: SynchronisingChoice, rows: list[Row]) -> list[Step]:
    """Events of A all operands perform together, and neither they nor taus resolve the choice."""
    steps: list[Step] = []
    offers: Offers = {}
    for i, row in enumerate(rows):
        for event, after in row:
            if event == TAU:
                steps.append((TAU, SynchronisingChoice(p.events, _replaced(p.operands, i, after))))
            elif event in p.events:
                offers.setdefault(event, {}).setdefault(i, []).append(after)
            else:
                steps.append((event, after))
    for event, by_operand in offers.items():
        together = _together(p.operands, range(len(rows)), by_operand)
        steps.extend((event, SynchronisingChoice(p.events, after)) for after in together)
    return steps


def _synchronising_interrupt(state: Normalise, p: SynchronisingInterrupt, rows: list[Row]) -> list[Step]:
    """Events of A both sides perform together; any other event of the right, and a tick of either, ends the left."""
    steps: list[Step] = []
    offers: Offers = {}
    for i, row in enumerate(rows):
        for event, after in row:
            if event == TICK:
                steps.append((TICK, after))
            elif event != TAU and event in p.events:
                offers.setdefault(event, {}).setdefault(i, []).append(after)
            elif i == 0:
                steps.append((event, SynchronisingInterrupt(after, p.events, p.right)))
            elif event == TAU:
                steps.append((TAU, SynchronisingInterrupt(p.left, p.events, after)))
            else:
                steps.append((event, after))
    for event, by_operand in offers.items():
        for left, right in _together((p.left, p.right), (0, 1), by_operand):
            steps.append((event, SynchronisingInterrupt(left, p.events, right)))
    return steps


CONCURRENT_RULES: dict[type[Process], Callable[[Normalise, Any, list[Row]], list[Step]]] = {
    Parallel: _parallel,
    AlphabetisedParallel: _alphabetised,
    LinkedParallel: _linked,
    SynchronisingChoice: _synchronising_choice,
    SynchronisingInterrupt: _synchronising_interrupt,
}
