"""The specification beside a counterexample: a run of its own with the same visible events, as terms."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.checker.semantics.derivation import derive
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.checker.verdict import SpecificationRun
from cspcheck.cspm.process.events import TAU, EventTable
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.process.text import describe
from cspcheck.cspm.recursion import deep_recursion

LOOKED_AT = 2_000
"""States of the specification that are looked at; what needs more has no run told."""

_Back = dict[Process, tuple[Process, int] | None]


def specification_run(process: Process, trace: Sequence[int], events: EventTable) -> SpecificationRun | None:
    """The first run of a specification with the given visible events, of those with fewest taus before each event.

    It ends in a stable state if one can be reached without another event. None where there is no such run, or where
    finding it would take too long.

    Args:
        process: the specification.
        trace: visible events.
        events: names them.
    """
    semantics = Semantics()
    levels: list[_Back] = []
    starts: _Back = {semantics.state(process): None}
    looked_at = 0
    for position in range(len(trace) + 1):
        # All states after the events so far, each with the state that it was first reached from by a tau.
        level: _Back = dict(starts)
        levels.append(level)
        following: _Back = {}
        order = list(level)
        for state in order:
            looked_at += 1
            if looked_at > LOOKED_AT:
                return None
            for event, after in semantics.transitions(state):
                if event == TAU and after not in level:
                    level[after] = (state, TAU)
                    order.append(after)
                elif position < len(trace) and event == trace[position]:
                    following.setdefault(after, (state, event))
        starts = following
        if position < len(trace) and not starts:
            return None
    end = next((s for s in levels[-1] if all(event != TAU for event, _ in semantics.transitions(s))), None)
    steps = _backwards(levels, end if end is not None else next(iter(levels[-1])))
    state = semantics.state(process)
    names, causes, states = [], [], [describe(process, events)]
    with deep_recursion():
        for event, after in steps:
            cause = derive(semantics, state, event, after).cause
            names.append(events.name(event))
            causes.append(None if cause is None else events.name(cause))
            states.append(describe(semantics.heads.name(after) or after, events))
            state = after
    return SpecificationRun(tuple(names), tuple(causes), tuple(states))


def _backwards(levels: list[_Back], end: Process) -> list[tuple[int, Process]]:
    found: list[tuple[int, Process]] = []
    position = len(levels) - 1
    while (step := levels[position][end]) is not None:
        before, event = step
        found.append((event, end))
        position -= event != TAU
        end = before
    return found[::-1]
