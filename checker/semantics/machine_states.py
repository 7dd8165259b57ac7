"""Explicit machines as terms: a state of a machine is a leaf whose transitions are a row of the machine's arrays.

Wherever a compressed or prioritised process runs, under any operator, it may run as a machine that was worked out
once. Every other operator treats it as it treats a sequential process, and nobody explores it again.
"""

from __future__ import annotations

from collections.abc import Callable

from cspcheck.checker.lts import Lts
from cspcheck.checker.semantics.steps import Row
from cspcheck.cspm.process.events import TICK
from cspcheck.cspm.process.terms import SKIP, STOP, TERMINATED, MachineState, Process

Compile = Callable[[Process], Process | None]
"""Gives the state that a term is as a machine; None where it is better to follow the operands of the term."""


class ExplicitMachine:
    """A machine whose states are terms. A state that only ticks is SKIP, and one without transitions is STOP.

    The root is always a state of the machine, so that what runs as one can be told by its beginning.

    Attributes:
        lts: the machine.
        source: the term that it was made of, whose failures and divergences it has.
    """

    __slots__ = ("_rows", "_terms", "lts", "source")

    def __init__(self, lts: Lts, source: Process) -> None:
        self.lts = lts
        self.source = source
        self._terms: dict[int, Process] = {lts.root: MachineState(self, lts.root)}
        self._rows: dict[int, Row] = {}

    def term(self, state: int) -> Process:
        """A state that has not just come about by a tick, as a term."""
        term = self._terms.get(state)
        if term is None:
            labels = {label for label, _ in self.lts.successors(state)}
            if labels == {TICK}:
                term = SKIP
            else:
                term = MachineState(self, state) if labels else STOP
            self._terms[state] = term
        return term

    def row(self, state: int) -> Row:
        """The transitions of a state, distinct and ascending by event; a tick leads to the terminated process."""
        row = self._rows.get(state)
        if row is None:
            moves = [
                (label, TERMINATED if label == TICK else self.term(target))
                for label, target in self.lts.successors(state)
            ]
            row = self._rows[state] = tuple(dict.fromkeys(moves))
        return row


class MachineParts:
    """Tells which terms have a state of a machine among their running parts."""

    def __init__(self) -> None:
        self._known: dict[Process, bool] = {}

    def __call__(self, term: Process) -> bool:
        """Whether the term has one."""
        known = self._known
        pending = [term]
        while pending:
            part = pending[-1]
            if part in known:
                pending.pop()
            elif isinstance(part, MachineState):
                known[part] = True
            else:
                operands = part.active()
                missing = [q for q in operands if q not in known]
                if missing and not any(known.get(q) for q in operands):
                    pending.extend(missing)
                else:
                    known[part] = any(known.get(q) for q in operands)
        return known[term]
