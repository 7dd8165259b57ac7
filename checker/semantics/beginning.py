"""The beginning of a process that has no end: all that it can do within so many visible events.

A component without end cannot be explored by itself, though something may be wrong after a few events. What the terms
do up to some level, which is the number of visible events, is a machine like any other; what is found there within
the levels that are there as a whole is so of the process.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from cspcheck.checker.lts import Lts
from cspcheck.checker.semantics.steps import Row
from cspcheck.checker.semantics.transitions import Explored, Poll, Semantics
from cspcheck.cspm.process.events import TAU
from cspcheck.cspm.process.terms import Process

MANY = 100
"""So many steps of all their operands together the states may have on average that are looked at along a trace."""


class Beginning(NamedTuple):
    """A machine in which only the states of the first levels have their transitions.

    Attributes:
        machine: the machine; states further on have no transitions.
        levels: how many levels are there as a whole.
    """

    machine: Explored
    levels: int


def beginning(process: Process, most: int, poll: Poll | None = None) -> Beginning:
    """What *process* can do, level by level, as far as its first *most* states tell.

    Args:
        process: any term.
        most: how many states are looked at.
        poll: called now and then with the number of states found so far; what it raises ends the work.

    Raises:
        ScriptError: a definition cannot be evaluated.
    """
    semantics = Semantics()
    start = semantics.state(process)
    number = {start: 0}
    terms = [start]
    known: dict[Process, list[tuple[int, int]]] = {}
    levels = 0
    level = [start]
    while level:
        following: dict[Process, None] = {}
        moves: dict[Process, list[tuple[int, int]]] = {}
        for state in level:
            if len(moves) % 256 == 0 and poll is not None:
                poll(len(terms))
            if len(terms) > most:
                break
            row = []
            for event, after in semantics.transitions(state):
                if after not in number:
                    number[after] = len(terms)
                    terms.append(after)
                    if event == TAU:
                        level.append(after)
                    else:
                        following[after] = None
                elif event == TAU and after in following:
                    # It is one of this level after all, and was met by an event first.
                    del following[after]
                    level.append(after)
                row.append((event, number[after]))
            moves[state] = row
        if len(moves) < len(level):
            break
        known.update(moves)
        levels += 1
        level = list(following)
    return Beginning(Explored(Lts.from_successors([known.get(term, ()) for term in terms]), tuple(terms)), levels)


def along(process: Process, trace: Sequence[int], most: int, poll: Poll | None = None) -> Explored | None:
    """The machine of the states that *process* can be in while it performs a trace.

    Only these states, those that taus lead to after the last event among them, have their transitions; what other
    events lead to has none.

    Args:
        process: any term.
        trace: visible events.
        most: how many states are looked at; of large ones with many transitions fewer.
        poll: called now and then with the number of states found so far; what it raises ends the work.

    Returns:
        None where there are more states, or the process does not have the trace.

    Raises:
        ScriptError: a definition cannot be evaluated.
    """
    semantics = Semantics()
    known: dict[Process, Row] = {}
    level = [semantics.state(process)]
    number = {level[0]: 0}
    for position in range(len(trace) + 1):
        seen = set(level)
        following: dict[Process, None] = {}
        for state in level:
            row = known.get(state)
            if row is None:
                if len(known) == most or semantics.steps > most * MANY:
                    return None
                row = known[state] = semantics.transitions(state)
                if poll is not None and len(known) % 256 == 0:
                    poll(len(known))
            for event, after in row:
                number.setdefault(after, len(number))
                if event == TAU and after not in seen:
                    seen.add(after)
                    level.append(after)
                elif position < len(trace) and event == trace[position]:
                    following[after] = None
        level = list(following)
        if position < len(trace) and not level:
            return None
    rows = [[(event, number[after]) for event, after in known.get(term, ())] for term in number]
    return Explored(Lts.from_successors(rows), tuple(number))


def one_run(
    process: Process, trace: Sequence[int], goal: Callable[[Row], bool], most: int, poll: Poll | None = None
) -> Explored | None:
    """The machine of the states of one run that performs a trace and ends in a state with the transitions sought.

    Depth first, so where the order of internal steps does not matter few states are looked at; the run is not the
    shortest. Its last state has its transitions, the others have those between states of the run.

    Args:
        process: any term.
        trace: visible events.
        goal: tells from its transitions whether the run may end in a state.
        most: how many states are looked at; of large ones with many transitions fewer.
        poll: called now and then with the number of states found so far; what it raises ends the work.

    Returns:
        None where the run is not found among so many states.

    Raises:
        ScriptError: a definition cannot be evaluated.
    """
    semantics = Semantics()
    start = (0, semantics.state(process))
    came_from: dict[tuple[int, Process], tuple[int, Process] | None] = {start: None}
    pending = [start]
    looked_at = 0
    while pending and looked_at < most and semantics.steps <= most * MANY:
        here = pending.pop()
        position, state = here
        row = semantics.transitions(state)
        looked_at += 1
        if poll is not None and looked_at % 256 == 0:
            poll(looked_at)
        if position == len(trace) and goal(row):
            run: dict[Process, None] = {}
            step: tuple[int, Process] | None = here
            while step is not None:
                run[step[1]] = None
                step = came_from[step]
            return _of_run(tuple(reversed(run)), state, semantics)
        # What was pushed last is looked at first: the next event of the trace, if it can be performed here.
        for event, after in reversed(row):
            follows = position < len(trace) and event == trace[position]
            if event == TAU or follows:
                there = (position + follows, after)
                if there not in came_from:
                    came_from[there] = here
                    pending.append(there)
    return None


def _of_run(states: Sequence[Process], last: Process, semantics: Semantics) -> Explored:
    """The machine of the states of a run and of what the last one leads to.

    No other state has a transition out of the run, lest what is not looked at be taken for a state that can do nothing.
    """
    number = {state: i for i, state in enumerate(states)}
    for _, after in semantics.transitions(last):
        number.setdefault(after, len(number))
    rows = [
        [(event, number[after]) for event, after in semantics.transitions(state) if state is last or after in number]
        for state in states
    ]
    rows.extend([] for _ in range(len(number) - len(states)))
    return Explored(Lts.from_successors(rows), tuple(number))
