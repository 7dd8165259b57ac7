"""The beginning of a process that has no end: all that it can do within so many visible events.

A component without end cannot be explored by itself, though something may be wrong after a few events. What the terms
do up to some level, which is the number of visible events, is a machine like any other; what is found there within
the levels that are there as a whole is so of the process.
"""

from __future__ import annotations

from typing import NamedTuple

from cspcheck.checker.lts import Lts
from cspcheck.checker.semantics.transitions import Explored, Poll, Semantics
from cspcheck.cspm.process.events import TAU
from cspcheck.cspm.process.terms import Process


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
