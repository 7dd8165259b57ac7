"""Normal forms: what a specification allows after each of its traces.

A normal form is a deterministic machine without taus. Its node for a trace says which events the specification
can perform next, the minimal acceptances (what it must offer at least, one of the alternatives), and whether it
may diverge. An implementation refines the specification exactly when no pair (node, state of the implementation)
that a common trace reaches breaks what the node says (Roscoe, Understanding Concurrent Systems, section 8.4 and
chapter 16).

The models differ in what a node keeps, not in how it is read:

* T keeps the events; its only acceptance is the empty one, which everything satisfies.
* F keeps the events and the minimal acceptances of the stable states. A node without any acceptance (the
  specification only diverges there) allows no stable state.
* FD also marks the nodes after which the specification can diverge. Such a node allows everything for ever; all
  of them are one node, and nothing behind it is looked at.

Termination is signalled: a state that can tick accepts {tick} whether or not it can do something else as well,
taus included, and nothing more than that can be relied on. (A trace ``s`` that can be followed by a tick has every
set of visible events among its refusals, Roscoe's axiom F4; taking it from stable states alone would make hiding and
sliding choice disagree with their laws.)
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int32Array, Int64Array

NormalModel = Literal["T", "F", "FD"]
"""The models that a normal form is made for."""
FailuresModel = Literal["F", "FD"]
"""Those of them that know of refusals."""


@dataclass(frozen=True, eq=False, slots=True)
class NormalForm:
    """A complete normal form in arrays.

    Attributes:
        model: the model it was made for.
        events: shape (columns,): the event identifiers of the specification, ascending; tick (1) may be the first.
        offsets: shape (nodes + 1,): the transitions of node ``n`` are the slice ``offsets[n]:offsets[n + 1]``.
        columns: shape (transitions,): positions in ``events``, ascending within a node, each at most once.
        targets: shape (transitions,): nodes.
        divergent: shape (nodes,): the nodes that allow everything; they have no transitions. In FD those after which
            the specification can diverge; in every model those of which nothing is known.
        acceptance_set: shape (nodes,): which set of minimal acceptances the node has.
        acceptance_sets: for each set its acceptances, each the ascending positions in ``events``; in the order
            of size and then of events. Empty for a divergent node.
        root: the node of the empty trace.
    """

    model: NormalModel
    events: Int64Array
    offsets: Int64Array
    columns: Int32Array
    targets: Int32Array
    divergent: BoolArray
    acceptance_set: Int32Array
    acceptance_sets: tuple[tuple[tuple[int, ...], ...], ...]
    root: int = 0

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return len(self.offsets) - 1

    @property
    def transitions(self) -> int:
        """Number of transitions."""
        return len(self.columns)

    def allowed(self, node: int) -> tuple[int, ...]:
        """The events that the specification can perform at *node*, as identifiers, ascending."""
        row = self.columns[self.offsets[node] : self.offsets[node + 1]]
        return tuple(self.events[row].tolist())

    def acceptances(self, node: int) -> tuple[tuple[int, ...], ...]:
        """The minimal acceptances of *node* as event identifiers; for a divergent node none."""
        events = self.events
        return tuple(
            tuple(int(events[column]) for column in acceptance)
            for acceptance in self.acceptance_sets[self.acceptance_set[node]]
        )

    def after(self, node: int, event: int) -> int | None:
        """The node behind *event*, or None where the specification cannot perform it."""
        start, end = int(self.offsets[node]), int(self.offsets[node + 1])
        row = self.events[self.columns[start:end]]
        position = int(np.searchsorted(row, event))
        if position == len(row) or row[position] != event:
            return None
        return int(self.targets[start + position])

    def along(self, trace: Iterable[int]) -> int | None:
        """The node behind a trace of visible events; None when the trace is not one of the specification.

        A divergent node is behind all traces that extend one of its own.
        """
        node: int | None = self.root
        for event in trace:
            assert node is not None
            if self.divergent[node]:
                break
            node = self.after(node, event)
            if node is None:
                return None
        return node
