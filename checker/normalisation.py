"""Making normal forms of explicit machines.

A machine without taus in which no event leads to two states is its own normal form, whatever its size; this is
decided and done in arrays. Everything else goes through the subset construction (Roscoe, Understanding Concurrent
Systems, section 16.1): a node is the set of states that a trace can lead to. Only states that matter are kept in
such a set: those with a visible transition, an acceptance or a divergence that the model looks at.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable

import numpy as np
import numpy.typing as npt

from checker.lts import Int64Array, Lts
from checker.normal_form import NormalForm, Semantics
from checker.rows import gather_rows, intern_rows
from cspm.events import TAU, TICK

BoolArray = npt.NDArray[np.bool_]

Acceptance = tuple[int, ...]
"""The events of an acceptance as ascending columns."""
AcceptanceSet = tuple[Acceptance, ...]

MINIMISATION_WORK = 20_000_000
"""Transitions that the minimisation of a normal form may look at, all rounds together, before it is given up."""


def normalise(
    lts: Lts, model: Semantics, *, minimise: bool = True, poll: Callable[[int], None] | None = None
) -> NormalForm:
    """The normal form of a machine whose states are all reachable.

    Args:
        lts: the machine of the specification.
        model: what the normal form is to be compared in.
        minimise: whether equivalent nodes are to be merged where that is cheap. The verdicts are the same; the
            numbers of nodes and of pairs are smaller.
        poll: called every now and then with the number of nodes so far. What it raises ends the work.
    """
    normal_form = _own_normal_form(lts, model) if is_deterministic(lts) else Normaliser(lts, model).all_nodes(poll)
    return minimised(normal_form) if minimise else normal_form


def is_deterministic(lts: Lts) -> bool:
    """Whether there is no tau and no event leads from one state to two."""
    if (lts.labels == TAU).any():
        return False
    repeated = lts.labels[1:] == lts.labels[:-1]
    starts = lts.offsets[1:-1]
    repeated[starts[(starts > 0) & (starts < lts.transitions)] - 1] = False
    return not repeated.any()


def divergent_states(lts: Lts) -> BoolArray:
    """Which states have an infinite path of taus. Shape (states,).

    States from which every path of taus ends are peeled off from the ends; what stays cannot stop. Linear in
    the taus.
    """
    sources = np.repeat(np.arange(lts.states), np.diff(lts.offsets))
    tau = lts.labels == TAU
    sources, targets = sources[tau], lts.targets[tau]
    remaining = np.bincount(sources, minlength=lts.states)
    order = np.argsort(targets, kind="stable")
    predecessors = sources[order]
    starts = np.searchsorted(targets[order], np.arange(lts.states + 1))
    ended = np.flatnonzero(remaining == 0)
    while len(ended):
        losing, losses = np.unique(predecessors[gather_rows(starts, ended)], return_counts=True)
        remaining[losing] -= losses
        ended = losing[remaining[losing] == 0]
    diverging: BoolArray = remaining > 0
    return diverging


class StateAcceptances:
    """The acceptance of each state that has one.

    Attributes:
        number: shape (states,): which acceptance the state has; -1 for an unstable state that cannot tick.
        acceptances: the distinct acceptances as ascending columns (positions in the ascending visible labels).
    """

    __slots__ = ("acceptances", "number")

    def __init__(self, lts: Lts, columns: Int64Array) -> None:
        sources = np.repeat(np.arange(lts.states), np.diff(lts.offsets))
        ticking = np.zeros(lts.states, dtype=np.bool_)
        ticking[sources[lts.labels == TICK]] = True
        unstable = np.zeros(lts.states, dtype=np.bool_)
        unstable[sources[lts.labels == TAU]] = True
        kept = np.where(ticking[sources], lts.labels == TICK, ~unstable[sources])
        # A nondeterministic state offers an event once however many targets it has.
        again = np.zeros(lts.transitions, dtype=np.bool_)
        again[1:] = (lts.labels[1:] == lts.labels[:-1]) & (sources[1:] == sources[:-1])
        kept &= ~again
        offsets = np.concatenate([[0], np.cumsum(np.bincount(sources[kept], minlength=lts.states))])
        values = columns[kept]
        self.number, first = intern_rows(offsets, values)
        self.acceptances = [tuple(values[offsets[row] : offsets[row + 1]].tolist()) for row in first.tolist()]
        self.number[unstable & ~ticking] = -1


def minimal(acceptances: Iterable[Acceptance]) -> AcceptanceSet:
    """Those of some acceptances that contain no other, in the order of size and then of events."""
    kept: list[Acceptance] = []
    masks: list[int] = []
    for acceptance in sorted(set(acceptances), key=lambda acceptance: (len(acceptance), acceptance)):
        mask = sum(1 << column for column in acceptance)
        if not any(smaller & mask == smaller for smaller in masks):
            kept.append(acceptance)
            masks.append(mask)
    return tuple(kept)


class AcceptanceSets:
    """Sets of minimal acceptances, numbered as they are met.

    Attributes:
        sets: the sets.
    """

    __slots__ = ("_numbers", "sets")

    def __init__(self) -> None:
        self._numbers: dict[AcceptanceSet, int] = {}
        self.sets: list[AcceptanceSet] = []

    def number(self, acceptances: AcceptanceSet) -> int:
        """The number of a set that is minimal and in order."""
        number = self._numbers.setdefault(acceptances, len(self.sets))
        if number == len(self.sets):
            self.sets.append(acceptances)
        return number


class Normaliser:
    """The subset construction, one node at a time.

    Nodes are numbered in the order in which :meth:`extend` meets them; node 0 is the root. Nothing of a node but
    its members is computed before it is asked for, so that a search can extend just the nodes that it reaches.

    Attributes:
        events: shape (columns,): the visible labels of the machine, ascending.
    """

    def __init__(self, lts: Lts, model: Semantics) -> None:
        self.model = model
        self.events: Int64Array = np.unique(lts.labels[lts.labels != TAU])
        columns = np.searchsorted(self.events, lts.labels)
        taus = np.concatenate([[0], np.cumsum(lts.labels == TAU)])
        visible = lts.offsets[:-1] + taus[lts.offsets[1:]] - taus[lts.offsets[:-1]]
        matters = lts.offsets[1:] > visible
        self._first = lts.offsets.data
        self._visible = np.ascontiguousarray(visible).data
        self._columns = np.ascontiguousarray(columns).data
        self._targets = np.ascontiguousarray(lts.targets).data
        self._sets = AcceptanceSets()
        self._set_of: dict[frozenset[int], int] = {}
        self._acceptances: list[Acceptance] = [()]
        self._acceptance: memoryview | None = None
        self._divergent: memoryview | None = None
        if model != "T":
            accepting = StateAcceptances(lts, columns)
            self._acceptances = accepting.acceptances
            self._acceptance = accepting.number.data
            matters |= accepting.number >= 0
        if model == "FD":
            diverging = divergent_states(lts)
            if diverging.any():
                self._divergent = diverging.data
        self._matters = matters.data
        self._has_taus = bool(taus[-1])
        self._number: dict[bytes | None, int] = {}
        self._members: list[bytes | None] = []
        self._node(self._closure([lts.root]))

    @property
    def nodes(self) -> int:
        """Number of nodes met so far."""
        return len(self._members)

    @property
    def nbytes(self) -> int:
        """About how many bytes the machine and the nodes take."""
        arrays = (self._first, self._visible, self._columns, self._targets, self._matters)
        return sum(a.nbytes for a in arrays) + sum(len(key) for key in self._members if key is not None)

    @property
    def acceptance_sets(self) -> list[AcceptanceSet]:
        """The sets that :meth:`acceptance_set` has numbered so far; see :class:`NormalForm`."""
        return self._sets.sets

    def is_divergent(self, node: int) -> bool:
        """Whether the node allows everything (FD only)."""
        return self._members[node] is None

    def members(self, node: int) -> list[int]:
        """The states of the machine that the node stands for and that matter to the model, ascending."""
        key = self._members[node]
        if key is None:
            return []
        states = array("q")
        states.frombytes(key)
        return states.tolist()

    def acceptance_set(self, node: int) -> int:
        """The number of the node's set of minimal acceptances."""
        if self.is_divergent(node):
            return self._sets.number(())
        if self._acceptance is None:
            return self._sets.number(((),))
        numbers = frozenset({self._acceptance[state] for state in self.members(node)} - {-1})
        number = self._set_of.get(numbers)
        if number is None:
            acceptances = minimal(self._acceptances[acceptance] for acceptance in numbers)
            number = self._set_of[numbers] = self._sets.number(acceptances)
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
        after: dict[int, list[int]] = {}
        for state in self.members(node):
            start, end = self._visible[state], self._first[state + 1]
            for column, target in zip(
                self._columns[start:end].tolist(), self._targets[start:end].tolist(), strict=True
            ):
                targets = after.get(column)
                if targets is None:
                    after[column] = [target]
                else:
                    targets.append(target)
        return [(column, self._node(self._closure(after[column]))) for column in sorted(after)]

    def all_nodes(self, poll: Callable[[int], None] | None = None) -> NormalForm:
        """Extend every node and give the normal form."""
        offsets, columns, targets = array("q", [0]), array("i"), array("i")
        divergent, acceptance_set = array("b"), array("i")
        node = 0
        while node < self.nodes:
            if poll is not None and node % 256 == 0:
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

    def _closure(self, states: list[int]) -> set[int] | None:
        """All states that taus lead to from *states*, these included; None if one of them is divergent."""
        seen = set(states)
        if not self._has_taus:
            return seen
        stack = list(seen)
        divergent, first, visible, targets = self._divergent, self._first, self._visible, self._targets
        while stack:
            state = stack.pop()
            if divergent is not None and divergent[state]:
                return None
            for target in targets[first[state] : visible[state]]:
                if target not in seen:
                    seen.add(target)
                    stack.append(target)
        return seen

    def _node(self, states: set[int] | None) -> int:
        """The number of the node for a set of states that is closed under tau."""
        key: bytes | None = None
        if states is not None:
            matters = self._matters
            key = array("q", sorted(state for state in states if matters[state])).tobytes()
        number = self._number.setdefault(key, len(self._members))
        if number == len(self._members):
            self._members.append(key)
        return number


def _own_normal_form(lts: Lts, model: Semantics) -> NormalForm:
    """The normal form of a machine that :func:`is_deterministic`: the machine itself, in arrays throughout."""
    events: Int64Array = np.unique(lts.labels)
    columns = np.searchsorted(events, lts.labels)
    if model == "T":
        acceptance_set = np.zeros(lts.states, dtype=np.int32)
        sets: list[AcceptanceSet] = [((),)]
    else:
        accepting = StateAcceptances(lts, columns)
        acceptance_set = accepting.number.astype(np.int32)
        sets = [(acceptance,) for acceptance in accepting.acceptances]
    return NormalForm(
        model,
        events,
        lts.offsets,
        columns.astype(np.int32),
        lts.targets.astype(np.int32),
        np.zeros(lts.states, dtype=np.bool_),
        acceptance_set,
        tuple(sets),
        lts.root,
    )


def minimised(normal_form: NormalForm, *, work: int = MINIMISATION_WORK) -> NormalForm:
    """The normal form with the fewest nodes, or the one given if finding it takes more than *work* transitions.

    Moore's refinement of partitions: nodes stay together while they agree in what they say and in where their
    events lead. Nodes keep the order of their first representatives.
    """
    offsets, targets = normal_form.offsets, normal_form.targets.astype(np.int64)
    nodes = normal_form.nodes
    lengths = np.diff(offsets)
    keys = normal_form.acceptance_set.astype(np.int64) * 2 + normal_form.divergent
    block, first = intern_rows(np.arange(nodes + 1), keys)
    # A row of the signature, ascending: the block so far, below zero, then (column, block of the target) in one number.
    heads = offsets[:-1] + np.arange(nodes)
    body = np.arange(len(targets)) + np.repeat(np.arange(1, nodes + 1), lengths)
    signature = np.empty(len(targets) + nodes, dtype=np.int64)
    signature_offsets = np.concatenate([heads, [len(signature)]])
    done = 0
    while True:
        done += len(signature)
        if done > work:
            return normal_form
        signature[heads] = -1 - block
        signature[body] = normal_form.columns.astype(np.int64) * nodes + block[targets]
        block, refined = intern_rows(signature_offsets, signature)
        if len(refined) == len(first):
            break
        first = refined
    if len(first) == nodes:
        return normal_form
    rows = gather_rows(offsets, first)
    return NormalForm(
        normal_form.model,
        normal_form.events,
        np.concatenate([[0], np.cumsum(lengths[first])]).astype(np.int64),
        normal_form.columns[rows],
        block[targets[rows]].astype(np.int32),
        normal_form.divergent[first],
        normal_form.acceptance_set[first],
        normal_form.acceptance_sets,
        int(block[normal_form.root]),
    )
