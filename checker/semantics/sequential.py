"""The rules of the operators in which operands run by themselves: prefix, the choices, ``;``, hiding, ...

Rules: Roscoe, *Understanding Concurrent Systems* (2010), chapter 9.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cspcheck.checker.budget import Incomplete
from cspcheck.checker.semantics.external import prioritise_by_order
from cspcheck.checker.semantics.machine_states import ExplicitMachine
from cspcheck.checker.semantics.steps import Normalise, Row, Step
from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.events import TAU, TICK, EventSet, new_names
from cspcheck.cspm.process.terms import (
    DIV,
    SKIP,
    STOP,
    TERMINATED,
    Beyond,
    Buffer,
    Chaos,
    Diverge,
    External,
    ExternalChoice,
    Hide,
    InternalChoice,
    Interrupt,
    MachineState,
    Prefix,
    Prioritised,
    Process,
    Project,
    Rename,
    Run,
    Sequential,
    Skip,
    SlidingChoice,
    Stop,
    Terminated,
    Throw,
)

MOST_TRANSITIONS = 1 << 22
"""No state is listed that has more transitions than this."""


def _none(state: Normalise, p: Process, rows: list[Row]) -> list[Step]:
    return []


def _skip(state: Normalise, p: Skip, rows: list[Row]) -> list[Step]:
    return [(TICK, TERMINATED)]


def _diverge(state: Normalise, p: Diverge, rows: list[Row]) -> list[Step]:
    return [(TAU, DIV)]


def _run(state: Normalise, p: Run, rows: list[Row]) -> list[Step]:
    return [(event, p) for event in _listed(p.events)]


def _chaos(state: Normalise, p: Chaos, rows: list[Row]) -> list[Step]:
    if not p.events:
        return [(TAU, STOP)]
    return [(TAU, STOP), (TAU, Prefix(tuple([(event, p) for event in _listed(p.events)])))]


def _listed(events: EventSet) -> EventSet:
    """The same events, each of which is to be a transition.

    Raises:
        Incomplete: they are too many for that.
    """
    if len(events) > MOST_TRANSITIONS:
        raise Incomplete(f"one state has {len(events):,} transitions, more than {MOST_TRANSITIONS:,}")
    return events


def _prefix(state: Normalise, p: Prefix, rows: list[Row]) -> list[Step]:
    return [(event, state(after)) for event, after in p.branches]


def _internal_choice(state: Normalise, p: InternalChoice, rows: list[Row]) -> list[Step]:
    return [(TAU, state(operand)) for operand in p.operands]


def _external_choice(state: Normalise, p: ExternalChoice, rows: list[Row]) -> list[Step]:
    """A tau of an operand does not resolve the choice; everything else does."""
    steps: list[Step] = []
    operands = p.operands
    for i, row in enumerate(rows):
        for event, after in row:
            if event == TAU:
                steps.append((TAU, ExternalChoice((*operands[:i], after, *operands[i + 1 :]))))
            else:
                steps.append((event, after))
    return steps


def _sliding_choice(state: Normalise, p: SlidingChoice, rows: list[Row]) -> list[Step]:
    steps = [(event, SlidingChoice(after, p.right) if event == TAU else after) for event, after in rows[0]]
    steps.append((TAU, state(p.right)))
    return steps


def _interrupt(state: Normalise, p: Interrupt, rows: list[Row]) -> list[Step]:
    """The right takes over with its first visible event; a tick of either side ends the whole."""
    steps: list[Step] = []
    for event, after in rows[0]:
        steps.append((event, after if event == TICK else Interrupt(after, p.right)))
    for event, after in rows[1]:
        steps.append((event, Interrupt(p.left, after) if event == TAU else after))
    return steps


def _throw(state: Normalise, p: Throw, rows: list[Row]) -> list[Step]:
    steps: list[Step] = []
    for event, after in rows[0]:
        if event == TICK:
            steps.append((TICK, after))
        elif event != TAU and event in p.events:
            steps.append((event, state(p.right)))
        else:
            steps.append((event, Throw(after, p.events, p.right)))
    return steps


def _sequential(state: Normalise, p: Sequential, rows: list[Row]) -> list[Step]:
    return [(TAU, state(p.right)) if event == TICK else (event, Sequential(after, p.right)) for event, after in rows[0]]


def _unless_ended(after: Process) -> bool:
    """Whether a unary operator still matters: it cannot change a tick, nor what has ended."""
    return after is not SKIP and after is not TERMINATED


def _hide(state: Normalise, p: Hide, rows: list[Row]) -> list[Step]:
    return [
        (TAU if event in p.events else event, Hide(after, p.events) if _unless_ended(after) else after)
        for event, after in rows[0]
    ]


def _project(state: Normalise, p: Project, rows: list[Row]) -> list[Step]:
    return [
        (
            event if event == TICK or event in p.events else TAU,
            Project(after, p.events) if _unless_ended(after) else after,
        )
        for event, after in rows[0]
    ]


def _rename(state: Normalise, p: Rename, rows: list[Row]) -> list[Step]:
    """Relational: an event with several new names gives one transition for each of them."""
    new = new_names(p.pairs)
    steps: list[Step] = []
    for event, after in rows[0]:
        renamed = Rename(after, p.pairs) if _unless_ended(after) else after
        steps.extend((name, renamed) for name in new.get(event, (event,)))
    return steps


def _prioritised(state: Normalise, p: Prioritised, rows: list[Row]) -> list[Step]:
    """Only the highest level that has something to offer; events of no level are neither blocked nor blocking."""
    (row,) = rows
    levels: dict[int, int] = {}
    for event, _ in row:
        if event in (TAU, TICK):
            levels[event] = 0
        elif event not in levels:
            level = next((i for i, events in enumerate(p.levels) if event in events), None)
            if level is not None:
                levels[event] = level
    highest = min(levels.values(), default=0)
    return [
        (event, Prioritised(after, p.levels) if _unless_ended(after) else after)
        for event, after in row
        if levels.get(event, highest) == highest
    ]


def _buffer(state: Normalise, p: Buffer, rows: list[Row]) -> list[Step]:
    """First in, first out; what a full or empty buffer does beside that depends on its kind.

    BUFFER: a full buffer accepts no input. WEAK_BUFFER: it does, and then can only perform ``explode`` and stop.
    SIGNAL_BUFFER: as BUFFER, and it offers ``full`` as long as it is full and ``empty`` as long as it is empty,
    either of which leaves it as it is.
    """
    steps: list[Step] = []
    held = len(p.contents)
    if held < p.capacity:
        for i, (received, _) in enumerate(p.pairs):
            steps.append((received, Buffer(p.kind, p.capacity, p.signals, p.pairs, (*p.contents, i))))
    elif p.kind == "WEAK_BUFFER":
        exploding = prefix(p.signals[0], STOP)
        steps.extend((received, exploding) for received, _ in p.pairs)
    if held:
        sent = p.pairs[p.contents[0]][1]
        steps.append((sent, Buffer(p.kind, p.capacity, p.signals, p.pairs, p.contents[1:])))
    if p.kind == "SIGNAL_BUFFER":
        full, empty = p.signals
        if held == p.capacity:
            steps.append((full, p))
        if not held:
            steps.append((empty, p))
    return steps


def _machine_state(state: Normalise, p: MachineState, rows: list[Row]) -> list[Step]:
    assert isinstance(p.machine, ExplicitMachine)
    return list(p.machine.row(p.state))


def _external(state: Normalise, p: External, rows: list[Row]) -> list[Step]:
    """The other functions look further than at the transitions of an operand
    (``cspcheck.checker.semantics.external``).
    """
    assert p.function == "prioritisepo"
    return prioritise_by_order(p, rows[0])


SEQUENTIAL_RULES: dict[type[Process], Callable[[Normalise, Any, list[Row]], list[Step]]] = {
    Stop: _none,
    Terminated: _none,
    Skip: _skip,
    Diverge: _diverge,
    Beyond: _none,
    Run: _run,
    Chaos: _chaos,
    Prefix: _prefix,
    InternalChoice: _internal_choice,
    ExternalChoice: _external_choice,
    SlidingChoice: _sliding_choice,
    Interrupt: _interrupt,
    Throw: _throw,
    Sequential: _sequential,
    Hide: _hide,
    Project: _project,
    Rename: _rename,
    Prioritised: _prioritised,
    MachineState: _machine_state,
    Buffer: _buffer,
    External: _external,
}
