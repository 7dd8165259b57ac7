"""The subset construction, one node at a time.

A node is the set of states that a trace can lead to (Roscoe, Understanding Concurrent Systems, section 16.1). Only
states that matter are kept in it: those with a visible transition, an acceptance or a divergence that the model
looks at. Small sets are worked on one state at a time, large ones in arrays.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int64Array
from cspcheck.checker.lts import Lts
from cspcheck.checker.sparse_rows import gather_spans
from cspcheck.checker.specification.acceptances import (
    Acceptance,
    AcceptanceSet,
    AcceptanceSets,
    StateAcceptances,
    divergent_states,
    minimal,
)
from cspcheck.checker.specification.normal_form import NormalForm, NormalModel
from cspcheck.cspm.process.events import TAU

LARGE = 100
"""Sets of more states are worked on in arrays, where each step costs more and each state next to nothing."""

Key = bytes | None
"""The states of a node, ascending, as 32-bit integers; None for the node that allows everything."""


class Normaliser:
    """The normal form of a machine, extended node by node.

    Nodes are numbered in the order in which :meth:`extend` meets them; node 0 is the root. Nothing of a node but
    its members is computed before it is asked for, so that a search can extend just the nodes that it reaches.

    Attributes:
        model: the model.
        events: shape (columns,): the visible labels of the machine, ascending.
    """

    def __init__(self, lts: Lts, model: NormalModel) -> None:
        self.model = model
        self.events: Int64Array = np.unique(lts.labels[lts.labels != TAU])
        self._columns = np.searchsorted(self.events, lts.labels)
        self._taus = _Taus(lts)
        self._ends = lts.offsets[1:]
        self._targets = lts.targets
        self._matters: BoolArray = self._ends > self._taus.ends
        self._sets = AcceptanceSets()
        self._set_of: dict[bytes, int] = {}
        self._acceptances: list[Acceptance] = [()]
        self._acceptance = np.zeros(lts.states, dtype=np.int64)
        if model != "T":
            accepting = StateAcceptances(lts, self._columns)
            self._acceptances, self._acceptance = accepting.acceptances, accepting.number
            self._matters |= self._acceptance >= 0
        self._divergent = divergent_states(lts) if model == "FD" else np.zeros(lts.states, dtype=np.bool_)
        self._few = (self._taus.ends.data, self._ends.data, self._columns.data, self._targets.data)
        self._number: dict[Key, int] = {}
        self._members: list[Key] = []
        self._node([lts.root])

    @property
    def nodes(self) -> int:
        """Number of nodes met so far."""
        return len(self._members)

    @property
    def nbytes(self) -> int:
        """About how many bytes the machine and the nodes take."""
        arrays = (self._columns, self._targets, self._ends, self._taus.ends, self._acceptance)
        return sum(a.nbytes for a in arrays) + sum(len(key) for key in self._members if key is not None)

    @property
    def acceptance_sets(self) -> list[AcceptanceSet]:
        """The sets that :meth:`acceptance_set` has numbered so far; see :class:`NormalForm`."""
        return self._sets.sets

    def is_divergent(self, node: int) -> bool:
        """Whether the node allows everything (FD only)."""
        return self._members[node] is None

    def members(self, node: int) -> Int64Array:
        """The states of the machine that the node stands for and that matter to the model, ascending."""
        return np.frombuffer(self._members[node] or b"", dtype=np.int32).astype(np.int64)

    def acceptance_set(self, node: int) -> int:
        """The number of the node's set of minimal acceptances."""
        if self.is_divergent(node):
            return self._sets.number(())
        if self.model == "T":
            return self._sets.number(((),))
        numbers = np.unique(self._acceptance[self.members(node)])
        numbers = numbers[numbers >= 0]
        key = numbers.tobytes()
        number = self._set_of.get(key)
        if number is None:
            acceptances = minimal(self._acceptances[acceptance] for acceptance in numbers.tolist())
            number = self._set_of[key] = self._sets.number(acceptances)
        return number

    def allowed(self, node: int) -> tuple[int, ...]:
        """The events that the specification can perform at *node*, as identifiers, ascending."""
        return tuple(int(self.events[column]) for column, _ in self.extend(node))

    def acceptances(self, node: int) -> tuple[tuple[int, ...], ...]:
        """The minimal acceptances of *node* as event identifiers; for a divergent node none."""
        acceptances = self.acceptance_sets[self.acceptance_set(node)]
        return tuple(tuple(int(self.events[column]) for column in acceptance) for acceptance in acceptances)

    def extend(self, node: int) -> list[tuple[int, int]]:
        """The transitions of a node as (column, node), columns ascending; targets that are new become nodes."""
        key = self._members[node] or b""
        states = np.frombuffer(key, dtype=np.int32)
        after = self._after_few(states.tolist()) if len(states) <= LARGE else self._after_many(states.astype(np.int64))
        return [(column, self._node(targets)) for column, targets in after]

    def _after_few(self, states: list[int]) -> list[tuple[int, list[int]]]:
        after: dict[int, list[int]] = {}
        starts, ends, columns, targets = self._few
        for state in states:
            start, end = starts[state], ends[state]
            for column, target in zip(columns[start:end].tolist(), targets[start:end].tolist(), strict=True):
                if column in after:
                    after[column].append(target)
                else:
                    after[column] = [target]
        return sorted(after.items())

    def _after_many(self, states: Int64Array) -> list[tuple[int, list[int]]]:
        rows = gather_spans(self._taus.ends[states], self._ends[states])
        columns, targets = self._columns[rows], self._targets[rows]
        order = np.argsort(columns, kind="stable")
        columns, targets = columns[order], targets[order].tolist()
        starts = np.flatnonzero(np.diff(columns, prepend=-1))
        spans = pairwise([*starts.tolist(), len(targets)])
        return [
            (column, targets[start:end]) for column, (start, end) in zip(columns[starts].tolist(), spans, strict=True)
        ]

    def all_nodes(self, poll: Callable[[int], None] | None = None) -> NormalForm:
        """Extend every node and give the normal form.

        Args:
            poll: called now and then with the number of nodes so far. What it raises ends the work.
        """
        offsets, columns, targets = array("q", [0]), array("i"), array("i")
        divergent, acceptance_set = array("b"), array("i")
        node = 0
        while node < self.nodes:
            if poll is not None and node % 64 == 0:
                poll(self.nodes)
            for column, target in self.extend(node):
                columns.append(column)
                targets.append(target)
            offsets.append(len(columns))
            divergent.append(self.is_divergent(node))
            acceptance_set.append(self.acceptance_set(node))
            node += 1
        return NormalForm(
            self.model,
            self.events,
            np.array(offsets, dtype=np.int64),
            np.array(columns, dtype=np.int32),
            np.array(targets, dtype=np.int32),
            np.array(divergent, dtype=np.bool_),
            np.array(acceptance_set, dtype=np.int32),
            tuple(self.acceptance_sets),
        )

    def _node(self, states: list[int]) -> int:
        """The number of the node for some states and all that taus lead to."""
        closed = self._taus.closure(states)
        key = self._key_of_few(closed) if isinstance(closed, set) else self._key_of_many(closed)
        number = self._number.setdefault(key, len(self._members))
        if number == len(self._members):
            self._members.append(key)
        return number

    def _key_of_few(self, states: set[int]) -> Key:
        divergent, matters = self._divergent.data, self._matters.data
        if any(divergent[state] for state in states):
            return None
        return array("i", sorted(state for state in states if matters[state])).tobytes()

    def _key_of_many(self, states: Int64Array) -> Key:
        if self._divergent[states].any():
            return None
        return np.sort(states[self._matters[states]]).astype(np.int32).tobytes()


class _Taus:
    """The taus of a machine, to be followed.

    Attributes:
        ends: shape (states,): where the taus of each state end in the machine's transitions, and the rest starts.
    """

    __slots__ = ("_few", "_none", "_place", "_seen", "_starts", "_targets", "ends")

    def __init__(self, lts: Lts) -> None:
        before = np.concatenate([[0], np.cumsum(lts.labels == TAU)])
        self._starts = lts.offsets[:-1]
        self.ends: Int64Array = self._starts + before[lts.offsets[1:]] - before[self._starts]
        self._targets = lts.targets
        self._none = not before[-1]
        # Reading single numbers of an array is several times faster through a view of its memory.
        self._few = (self._starts.data, self.ends.data, self._targets.data)
        self._seen = np.zeros(lts.states, dtype=np.bool_)
        self._place = np.zeros(lts.states, dtype=np.int64)

    def closure(self, states: list[int]) -> set[int] | Int64Array:
        """All states that taus lead to from *states*, these included; an array, in no order, where they are many."""
        seen = set(states)
        if self._none:
            return seen
        stack = list(seen)
        starts, ends, targets = self._few
        while stack:
            if len(seen) > LARGE:
                return self._large_closure(np.fromiter(seen, dtype=np.int64))
            state = stack.pop()
            for target in targets[starts[state] : ends[state]]:
                if target not in seen:
                    seen.add(target)
                    stack.append(target)
        return seen

    def _large_closure(self, states: Int64Array) -> Int64Array:
        """The closure, step by step of taus; steps of few states, of which there may be many, without arrays."""
        seen = self._seen
        seen[states] = True
        found = [states]
        frontier: list[int] | Int64Array = states
        while len(frontier):
            frontier = self._few_more(frontier) if len(frontier) < LARGE else self._many_more(np.asarray(frontier))
            found.append(np.asarray(frontier, dtype=np.int64))
        closed = np.concatenate(found)
        seen[closed] = False
        return closed

    def _few_more(self, frontier: list[int] | Int64Array) -> list[int]:
        starts, ends, targets = self._few
        seen = self._seen.data
        more: list[int] = []
        for state in frontier if isinstance(frontier, list) else frontier.tolist():
            for target in targets[starts[state] : ends[state]]:
                if not seen[target]:
                    seen[target] = True
                    more.append(target)
        return more

    def _many_more(self, frontier: Int64Array) -> Int64Array:
        reached = self._targets[gather_spans(self._starts[frontier], self.ends[frontier])]
        reached = reached[~self._seen[reached]]
        # Of the entries for one state the last is the one that its place names.
        entries = np.arange(len(reached))
        self._place[reached] = entries
        more: Int64Array = reached[self._place[reached] == entries]
        self._seen[more] = True
        return more
