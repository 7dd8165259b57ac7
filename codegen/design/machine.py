"""Machines: a task as the states of its process and the events that lead from one to the next.

What a process does is what the operational semantics says, so this is right for every operator; the semantics comes
from whoever asks for the design, since the workshop does not know the checker. A process that reads well as a program
is translated as it is written (``codegen.design.tasks``); a machine is made of one that does not, and of every process
for targets that run tables.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from cspcheck.codegen import messages
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.process.events import TAU, TICK, EventTable
from cspcheck.cspm.process.terms import Beyond, Process, Reference
from cspcheck.cspm.process.text import describe

LARGEST = 4_000
"""A machine with more states than this is no table that anybody wants in a program."""
MOST_MOVES = 40_000
"""Likewise for what its states offer."""


class OperationalSemantics(Protocol):
    """What a process does: the operational semantics of the checker has these two."""

    def state(self, process: Process) -> Process:
        """The state that a process begins in."""

    def transitions(self, state: Process) -> Sequence[tuple[int, Process]]:
        """The events of a state, each with the state behind it; tau and tick among them."""


@dataclass(frozen=True)
class MachineState:
    """A state of a machine.

    Attributes:
        text: the process that the task is there.
        moves: the events that it offers, with the numbers of the states behind them.
        ways: the states that it goes to by itself; if there are any, the task chooses one of them.
        ends: whether it may terminate.
    """

    text: str
    moves: tuple[tuple[int, int], ...]
    ways: tuple[int, ...]
    ends: bool


@dataclass(frozen=True)
class Machine:
    """States by number, and for each of the processes that were asked for the one that it begins in."""

    states: tuple[MachineState, ...]
    starts: tuple[int, ...]

    def events(self) -> tuple[int, ...]:
        """All events that some state offers, ascending."""
        return tuple(sorted({event for state in self.states for event, _ in state.moves}))

    def chooses(self) -> bool:
        """Whether some state leaves a choice to nobody."""
        return any(len(state.ways) > 1 for state in self.states)


def machine(references: Sequence[Reference], semantics: OperationalSemantics, table: EventTable) -> Machine:
    """The machine of some processes, which share their states.

    A state that can do something by itself is left at once: what it offered beside that, it offers to nobody. Every
    run of the machine is one of the process, and it stops only where the process may.

    Raises:
        ScriptError: it has too many states, or a state that no reading of a wide type has.
    """
    name = references[0].text
    numbers: dict[Process, int] = {}
    order: list[Process] = []
    found: list[MachineState] = []

    def number(process: Process) -> int:
        state = _settled(process, semantics)
        if isinstance(state, Beyond):
            help = "give its types wider readings, or say in the class what happens at their ends"
            raise ScriptError(messages.not_generated(f"`{name}`: {state.report}", references[0].span, help))
        known = numbers.get(state)
        if known is None:
            known = numbers[state] = len(order)
            order.append(state)
            if known >= LARGEST:
                raise ScriptError(messages.too_large(name, "states", LARGEST, references[0].span))
        return known

    starts = tuple(number(reference) for reference in references)
    moves = 0
    while len(found) < len(order):
        state = order[len(found)]
        row = semantics.transitions(state)
        ways = tuple(dict.fromkeys(number(target) for event, target in row if event == TAU))
        offered = () if ways else tuple((event, number(target)) for event, target in row if event > TICK)
        moves += len(offered)
        if moves > MOST_MOVES:
            raise ScriptError(messages.too_large(name, "events in its states", MOST_MOVES, references[0].span))
        ends = not ways and any(event == TICK for event, _ in row)
        found.append(MachineState(describe(state, table, width=90), offered, ways, ends))
    return Machine(tuple(found), starts)


def _settled(process: Process, semantics: OperationalSemantics) -> Process:
    """The state that a process comes to by itself as long as there is only one way: no choice, and nothing to see."""
    state = semantics.state(process)
    seen = {state}
    while True:
        row = semantics.transitions(state)
        targets = {semantics.state(target) for event, target in row if event == TAU}
        if len(targets) != 1:
            return state
        (state,) = targets
        if state in seen:
            return state  # it goes round by itself for ever: a state with one way, to itself
        seen.add(state)
