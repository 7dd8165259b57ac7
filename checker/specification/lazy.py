"""Specifications that cannot be explored to their end: normalised term by term, as far as the search gets.

An unbounded buffer is a fine specification of a bounded one. Its machine has no end, but the search of pairs only
ever looks at what the implementation does, and that part may be finite.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.budget import Incomplete
from cspcheck.checker.semantics.steps import Row
from cspcheck.checker.semantics.transitions import Semantics, offer
from cspcheck.checker.specification.acceptances import AcceptanceSet, AcceptanceSets, minimal
from cspcheck.checker.specification.normal_form import NormalModel
from cspcheck.cspm.process.events import TAU
from cspcheck.cspm.process.terms import Process

FOREIGN = int(np.iinfo(np.int64).max)
"""Stands for every event that the implementation cannot perform."""

Members = frozenset[Process]


class LazySpecification:
    """The normal form of a process term over the events of an implementation, one node at a time.

    Nodes are numbered in the order in which :meth:`extend` meets them, those behind events that the implementation
    cannot perform left out; node 0 is the root.

    Attributes:
        events: shape (columns,): the visible events of the implementation, ascending, and :data:`FOREIGN`.

    Args:
        process: the specification.
        model: what it is to be compared in.
        alphabet: the visible events of the implementation, ascending.
        most: how many states may be looked at.
        why: what to raise when there are more.
        poll: called now and then; what it raises ends the work.
        effort: how many transitions may be looked at in finding where taus lead to, each as often as it is looked at;
            None for any number. Where nodes have many states in common, that is what takes the time.
    """

    def __init__(
        self,
        process: Process,
        model: NormalModel,
        alphabet: Int64Array,
        most: int,
        why: Incomplete,
        poll: Callable[[], None] = lambda: None,
        effort: int | None = None,
    ) -> None:
        self.events: Int64Array = np.append(alphabet, FOREIGN)
        self._column = {event: column for column, event in enumerate(alphabet.tolist())}
        self._model = model
        self._most = most
        self._why = why
        self._poll = poll
        self._effort = effort
        self._semantics = Semantics()
        self._rows: dict[Process, Row] = {}
        self._sets = AcceptanceSets()
        self._numbers: dict[Members | None, int] = {}
        self._members: list[Members | None] = []
        self._node([self._semantics.state(process)])

    @property
    def acceptance_sets(self) -> list[AcceptanceSet]:
        """The sets that :meth:`acceptance_set` has numbered so far; see ``NormalForm``."""
        return self._sets.sets

    def is_divergent(self, node: int) -> bool:
        """Whether the node allows everything (FD only)."""
        return self._members[node] is None

    def extend(self, node: int) -> list[tuple[int, int]]:
        """The transitions of a node as (column, node), columns ascending; targets that are new become nodes.

        Raises:
            Incomplete: more states would have to be looked at than may be.
        """
        after: dict[int, list[Process]] = {}
        for row in self._rows_of(node):
            for event, target in row:
                column = self._column.get(event)
                if column is not None:
                    after.setdefault(column, []).append(target)
        return [(column, self._node(after[column])) for column in sorted(after)]

    def acceptance_set(self, node: int) -> int:
        """The number of the node's set of minimal acceptances."""
        if self.is_divergent(node):
            return self._sets.number(())
        if self._model == "T":
            return self._sets.number(((),))
        foreign = len(self._column)
        accepted = (
            tuple(sorted({self._column.get(event, foreign) for event in acceptance}))
            for acceptance in self._offers(node)
        )
        return self._sets.number(minimal(accepted))

    def allowed(self, node: int) -> tuple[int, ...]:
        """All events that the specification can perform at *node*, as identifiers, ascending."""
        return tuple(sorted({event for row in self._rows_of(node) for event, _ in row if event != TAU}))

    def acceptances(self, node: int) -> tuple[tuple[int, ...], ...]:
        """The minimal acceptances of *node* as event identifiers; for a divergent node none."""
        if self._model == "T":
            return ((),)
        offers = self._offers(node)
        # Identifiers can be any numbers up to 2 ** 63; their places in their order will do.
        events = sorted({event for acceptance in offers for event in acceptance})
        column = {event: place for place, event in enumerate(events)}
        found = minimal(tuple(sorted(column[event] for event in acceptance)) for acceptance in offers)
        return tuple(tuple(events[place] for place in acceptance) for acceptance in found)

    def _rows_of(self, node: int) -> list[Row]:
        members = self._members[node]
        return [] if members is None else [self._row(state) for state in members]

    def _offers(self, node: int) -> set[frozenset[int]]:
        offers = (offer(row) for row in self._rows_of(node))
        return {acceptance for acceptance in offers if acceptance is not None}

    def _row(self, state: Process) -> Row:
        row = self._rows.get(state)
        if row is None:
            if len(self._rows) >= self._most:
                raise self._why
            if len(self._rows) % 256 == 0:
                self._poll()
            row = self._rows[state] = self._semantics.transitions(state)
        return row

    def _node(self, states: Iterable[Process]) -> int:
        """The number of the node for some states and all that taus lead to."""
        seen = set(states)
        pending = list(seen)
        taus: dict[Process, int] = {}
        before: dict[Process, list[Process]] = {}
        while pending:
            state = pending.pop()
            row = self._row(state)
            if self._effort is not None:
                self._effort -= len(row)
                if self._effort < 0:
                    raise self._why
            targets = [target for event, target in row if event == TAU]
            taus[state] = len(targets)
            for target in targets:
                before.setdefault(target, []).append(state)
                if target not in seen:
                    seen.add(target)
                    pending.append(target)
        members: Members | None = frozenset(state for state in seen if self._matters(self._row(state)))
        if self._model == "FD" and _has_cycle(taus, before):
            members = None
        number = self._numbers.setdefault(members, len(self._members))
        if number == len(self._members):
            self._members.append(members)
        return number

    def _matters(self, row: Row) -> bool:
        """Whether a state adds anything to a node in this model: a visible event, or an acceptance."""
        if any(event != TAU for event, _ in row):
            return True
        return self._model != "T" and not row


def _has_cycle(out_degrees: dict[Process, int], before: dict[Process, list[Process]]) -> bool:
    """Whether a graph has a cycle: something remains when what leads nowhere is taken away again and again."""
    remaining = dict(out_degrees)
    ended = [state for state, degree in remaining.items() if degree == 0]
    gone = len(ended)
    while ended:
        for state in before.get(ended.pop(), ()):
            remaining[state] -= 1
            if remaining[state] == 0:
                ended.append(state)
                gone += 1
    return gone < len(remaining)
