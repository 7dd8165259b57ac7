"""Which operands a transition of a term comes from, found with the rules of the operational semantics themselves.

A rule says what an operator does given the transitions of its operands. Taking transitions away from the operands for
as long as the rule still gives the step in question leaves those that the step needs; nothing about any operator has to
be known for that.
"""

from __future__ import annotations

from dataclasses import dataclass

from cspcheck.checker.semantics.steps import Row
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.cspm.process.events import TAU, TICK
from cspcheck.cspm.process.terms import Process


class NotDerivable(Exception):
    """A term does not have the transition that was to be derived, which is a mistake of the tool."""


@dataclass(frozen=True, slots=True)
class Derivation:
    """A transition, and the transitions of the operands that it is made of.

    Attributes:
        event: what the term performs.
        after: the state after it.
        moves: (position of an active operand, its derivation), ascending; operands that take no part are missing.
    """

    event: int
    after: Process
    moves: tuple[tuple[int, Derivation], ...] = ()

    @property
    def cause(self) -> int | None:
        """For a tau, the event that was hidden or linked in it at the outermost place; None where there was none."""
        step = self
        while step.event == TAU and step.moves:
            step = step.moves[0][1]
        return step.event if self.event == TAU and step.event not in (TAU, TICK) else None


def derive(semantics: Semantics, state: Process, event: int, after: Process) -> Derivation:
    """How *state* comes to perform *event* and to be *after*; of several ways the one of the earliest operands.

    Args:
        semantics: the transitions of terms.
        state: a term in head normal form.
        event, after: one of its transitions.

    Raises:
        NotDerivable: it is none of them.
        ScriptError: a definition cannot be evaluated.
    """
    operands = state.active()
    if not operands:
        if (event, after) not in semantics.transitions(state):
            raise NotDerivable(f"no transition {event} of {type(state).__name__}")
        return Derivation(event, after)
    moves = []
    for i, premise in _premises(semantics, state, event, after):
        moves.append((i, derive(semantics, operands[i], *premise)))
    return Derivation(event, after, tuple(moves))


def _premises(
    semantics: Semantics, state: Process, event: int, after: Process
) -> list[tuple[int, tuple[int, Process]]]:
    """The transitions of operands that a step needs, at most one for each operand."""
    rows: list[Row] = [semantics.transitions(operand) for operand in state.active()]

    def enough(i: int, row: Row) -> bool:
        return (event, after) in semantics.applied(state, [*rows[:i], row, *rows[i + 1 :]])

    if (event, after) not in semantics.applied(state, rows):
        raise NotDerivable(f"no transition {event} of {type(state).__name__}")
    for i in reversed(range(len(rows))):
        if rows[i] and enough(i, ()):
            rows[i] = ()
    premises = []
    for i, row in enumerate(rows):
        if not row:
            continue
        # What performs the same event is tried first. A tick that is not enough by itself stands for the tau of an
        # operand that can still do something else; that something else takes no part.
        likely = sorted(row, key=lambda step: step[0] != event)
        premise = next((step for step in likely if enough(i, (step,))), None)
        if premise is None:
            premise = next(step for step in row if step[0] == TICK)
        else:
            rows[i] = (premise,)
        premises.append((i, premise))
    return premises
