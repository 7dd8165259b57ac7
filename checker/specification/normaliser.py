"""The subset construction, one node at a time or as a whole.

A node is the set of states that a trace can lead to (Roscoe, Understanding Concurrent Systems, section 16.1). Only
states that matter are kept in it: those with a visible transition, an acceptance or a divergence that the model
looks at. The work is done by the kernels of :mod:`cspcheck.checker.kernels.subsets`: interpreted ones as long as
there is little of it, then compiled ones.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int32Array, Int64Array, distinct
from cspcheck.checker.guard import afford
from cspcheck.checker.kernels import subsets
from cspcheck.checker.kernels.jit import Kernels, tau_kernels, tau_kernels_are_loaded
from cspcheck.checker.kernels.subsets import Branching, Following, SetNumbering
from cspcheck.checker.lts import Lts
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

INTERPRETED = 10_000
"""So many states and transitions are looked at before compiled kernels are worth loading."""

SLICE = 2_000_000
"""So many are looked at by machine code before it comes back."""


class _Numbering:
    """Sets that are numbered as they are met, with room that grows.

    Attributes:
        sets: them, as the kernels have them.
    """

    def __init__(self) -> None:
        self.sets = SetNumbering(
            np.zeros(64, dtype=np.int32),
            np.zeros(64, dtype=np.int64),
            np.zeros(64, dtype=np.int64),
            np.full(128, -1, dtype=np.int32),
            np.zeros(1, dtype=np.int64),
        )

    def __len__(self) -> int:
        return int(self.sets.size[0])

    @property
    def nbytes(self) -> int:
        """The memory that they take, in bytes."""
        return sum(array.nbytes for array in self.sets)

    def members(self, number: int) -> Int32Array:
        """The elements of a set, in no order."""
        start, end = self.sets.offsets[number : number + 2].tolist()
        return self.sets.members[start:end]

    def reserve(self, size: int, apart: int, kernels: Kernels) -> None:
        """Have room for one more set of at most *size* elements; *apart* is the one set that is not looked up."""
        sets, count = self.sets, len(self)
        used = int(sets.offsets[count])
        members = _at_least(sets.members, used + size)
        offsets, hashes, slots = _at_least(sets.offsets, count + 2), _at_least(sets.hashes, count + 2), sets.slots
        if 2 * (count + 1) > len(slots):
            afford(4 * slots.nbytes)
            slots = np.full(4 * len(slots), -1, dtype=np.int32)
        if members is not sets.members or offsets is not sets.offsets or slots is not sets.slots:
            grown = SetNumbering(members, offsets, hashes, slots, sets.size)
            if slots is not sets.slots:
                kernels.enter_slots(grown, apart)
            self.sets = grown


Numbers = TypeVar("Numbers", Int32Array, Int64Array)


def _at_least(numbers: Numbers, length: int) -> Numbers:
    """The array, with room for *length* numbers; where it has to grow, for twice as many as it had."""
    if length <= len(numbers):
        return numbers
    afford(numbers.nbytes)
    grown = np.zeros(max(length, 2 * len(numbers)), dtype=numbers.dtype)
    grown[: len(numbers)] = numbers
    return grown


@dataclass(eq=False, slots=True)
class _Rows:
    """Room for the transitions of some nodes."""

    ends: Int64Array
    columns: Int32Array
    targets: Int32Array


class Normaliser:
    """The normal form of a machine, extended node by node.

    Nodes are numbered in the order in which :meth:`extend` meets them; node 0 is the root. Nothing of a node but
    its members is computed before it is asked for, so that a search can extend just the nodes that it reaches.

    Attributes:
        model: the model.
        events: shape (columns,): the visible labels of the machine, ascending.

    Args:
        lts: the machine.
        model: the model.
        collapse: whether in FD all sets with a divergent state are one node that allows everything. Otherwise they
            are nodes as others, which keep their divergent states.
    """

    def __init__(self, lts: Lts, model: NormalModel, *, collapse: bool = True) -> None:
        self.model = model
        self.events: Int64Array = distinct(lts.labels[lts.labels != TAU])
        columns = np.searchsorted(self.events, lts.labels).astype(np.int64)
        before = np.concatenate([[0], np.cumsum(lts.labels == TAU)])
        starts, ends = np.ascontiguousarray(lts.offsets[:-1]), np.ascontiguousarray(lts.offsets[1:])
        middles = starts + before[ends] - before[starts]
        matters: BoolArray = ends > middles
        self._sets = AcceptanceSets()
        self._set_of: dict[int, int] = {}
        self._acceptances: list[Acceptance] = [()]
        acceptance = np.zeros(lts.states, dtype=np.int64)
        if model != "T":
            accepting = StateAcceptances(lts, columns)
            self._acceptances, acceptance = accepting.acceptances, accepting.number
            matters |= acceptance >= 0
        flags = matters.astype(np.uint8) * np.uint8(subsets.MATTERS)
        if model == "FD":
            self.divergent = divergent_states(lts)
            flags[self.divergent] |= subsets.COLLAPSES if collapse else subsets.MATTERS
        targets = np.ascontiguousarray(lts.targets)
        self._machine = Branching(starts, middles, ends, columns, targets, flags, acceptance)
        self._space = _space(lts, len(self.events), len(self._acceptances))
        self._nodes, self._offers = _Numbering(), _Numbering()
        self._node_offers = np.zeros(64, dtype=np.int64)
        self._progress = np.array([0, 0, -1, 0, 0], dtype=np.int64)
        self._looked_at = 0
        self._row = _Rows(
            np.zeros(1, dtype=np.int64),
            np.zeros(len(self.events), dtype=np.int32),
            np.zeros(len(self.events), dtype=np.int32),
        )
        self._space.moved[0] = lts.root
        while True:
            self._reserve()
            found = self._kernels().node_of_states(
                self._machine,
                self._nodes.sets,
                self._offers.sets,
                self._node_offers,
                self._space,
                0,
                1,
                self._progress,
            )
            if found >= 0:
                break

    @property
    def nodes(self) -> int:
        """Number of nodes met so far."""
        return len(self._nodes)

    @property
    def nbytes(self) -> int:
        """About how many bytes the machine and the nodes take."""
        return sum(array.nbytes for array in (*self._machine, *self._space)) + self._nodes.nbytes

    @property
    def acceptance_sets(self) -> list[AcceptanceSet]:
        """The sets that :meth:`acceptance_set` has numbered so far; see :class:`NormalForm`."""
        return self._sets.sets

    def is_divergent(self, node: int) -> bool:
        """Whether the node allows everything (FD only)."""
        return bool(node == self._progress[subsets.DIVERGENT])

    def members(self, node: int) -> Int64Array:
        """The states of the machine that the node stands for and that matter to the model, ascending."""
        return np.sort(self._nodes.members(node)).astype(np.int64)

    def diverging(self) -> BoolArray:
        """Which of the nodes met so far keep a divergent state; only in FD, and where they do not collapse."""
        sets = self._nodes.sets
        members = sets.members[: sets.offsets[self.nodes]]
        nodes = np.repeat(np.arange(self.nodes), np.diff(sets.offsets[: self.nodes + 1]))
        found: BoolArray = np.bincount(nodes[self.divergent[members]], minlength=self.nodes) > 0
        return found

    def acceptance_set(self, node: int) -> int:
        """The number of the node's set of minimal acceptances."""
        offer = int(self._node_offers[node])
        number = self._set_of.get(offer)
        if number is None:
            number = self._set_of[offer] = self._sets.number(self._minimal(offer))
        return number

    def _minimal(self, offer: int) -> AcceptanceSet:
        if offer < 0:
            return ()
        if self.model == "T":
            return ((),)
        return minimal(self._acceptances[number] for number in self._offers.members(offer).tolist())

    def allowed(self, node: int) -> tuple[int, ...]:
        """The events that the specification can perform at *node*, as identifiers, ascending."""
        return tuple(int(self.events[column]) for column, _ in self.extend(node))

    def acceptances(self, node: int) -> tuple[tuple[int, ...], ...]:
        """The minimal acceptances of *node* as event identifiers; for a divergent node none."""
        acceptances = self.acceptance_sets[self.acceptance_set(node)]
        return tuple(tuple(int(self.events[column]) for column in acceptance) for acceptance in acceptances)

    def extend(self, node: int) -> list[tuple[int, int]]:
        """The transitions of a node as (column, node), columns ascending; targets that are new become nodes."""
        self._progress[subsets.ROWS] = self._progress[subsets.COLUMNS] = 0
        while self._extended(node, node + 1, self._row) == node:
            self._reserve()
        end = int(self._row.ends[0])
        return list(zip(self._row.columns[:end].tolist(), self._row.targets[:end].tolist(), strict=True))

    def all_nodes(self, poll: Callable[[int], None] | None = None) -> NormalForm:
        """Extend every node and give the normal form.

        Args:
            poll: called now and then with the number of nodes so far. What it raises ends the work.
        """
        rows = _Rows(np.zeros(64, dtype=np.int64), np.zeros(64, dtype=np.int32), np.zeros(64, dtype=np.int32))
        ends: list[Int64Array] = [np.zeros(1, dtype=np.int64)]
        self._progress[subsets.ROWS] = self._progress[subsets.COLUMNS] = node = 0
        while True:
            after = self._extended(node, 1 << 62, rows)
            ends.append(rows.ends[: after - node].copy())
            node = after
            if poll is not None:
                poll(self.nodes)
            if node == self.nodes:
                break
            self._reserve()
            rows.ends = _at_least(rows.ends, min(self.nodes, 1 << 16))
            needed = int(self._progress[subsets.ROWS]) + len(self.events)
            rows.columns, rows.targets = _at_least(rows.columns, needed), _at_least(rows.targets, needed)
        transitions = int(self._progress[subsets.ROWS])
        afford(8 * transitions + 32 * node)
        divergent = np.zeros(node, dtype=np.bool_)
        if self._progress[subsets.DIVERGENT] >= 0:
            divergent[self._progress[subsets.DIVERGENT]] = True
        _, first, offer_of = np.unique(self._node_offers[:node], return_index=True, return_inverse=True)
        numbers = np.zeros(len(first), dtype=np.int32)
        for offer in np.argsort(first).tolist():
            numbers[offer] = self.acceptance_set(int(first[offer]))
        return NormalForm(
            self.model,
            self.events,
            np.concatenate(ends),
            rows.columns[:transitions].copy(),
            rows.targets[:transitions].copy(),
            divergent,
            numbers[offer_of],
            tuple(self.acceptance_sets),
        )

    def _extended(self, first: int, last: int, rows: _Rows) -> int:
        """Extend the nodes from *first* to *last* as far as there is room; the first that is not done."""
        self._progress[subsets.WORK] = 0
        found = self._kernels().extend_nodes(
            self._machine,
            self._nodes.sets,
            self._offers.sets,
            self._node_offers,
            self._space,
            first,
            last,
            rows.ends,
            rows.columns,
            rows.targets,
            self._progress,
            max(1, INTERPRETED if self._looked_at <= INTERPRETED and not tau_kernels_are_loaded() else SLICE),
        )
        self._looked_at += int(self._progress[subsets.WORK])
        return found

    def _kernels(self) -> Kernels:
        return tau_kernels(tau_kernels_are_loaded() or self._looked_at > INTERPRETED)

    def _reserve(self) -> None:
        """Have room for at least one more node."""
        self._nodes.reserve(len(self._machine.flags), int(self._progress[subsets.DIVERGENT]), self._kernels())
        self._offers.reserve(len(self._acceptances), -1, self._kernels())
        self._node_offers = _at_least(self._node_offers, len(self._nodes.sets.offsets))


def _space(lts: Lts, columns: int, acceptances: int) -> Following:
    def entries(number: int) -> Int64Array:
        return np.zeros(number, dtype=np.int64)

    return Following(
        stamps=entries(lts.states),
        queue=entries(lts.states),
        kept=entries(lts.states),
        offer_stamps=entries(acceptances),
        offered=entries(acceptances),
        counts=entries(columns),
        used=entries(columns),
        places=entries(columns),
        moved=entries(lts.transitions + 1),
    )
