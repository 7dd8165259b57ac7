"""Explicit machines: labelled transition systems in compressed sparse rows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cspcheck.checker.arrays import Int64Array, distinct
from cspcheck.checker.guard import afford
from cspcheck.checker.sparse_rows import gather_rows

ONE_NUMBER = 1 << 62
"""Where there are fewer possible transitions than this, each is a number."""


@dataclass(frozen=True, eq=False, slots=True)
class Lts:
    """An explicit machine.

    The transitions of state ``s`` are ``labels[offsets[s]:offsets[s+1]]`` with the same slice of ``targets``,
    ordered by (label, target) and without duplicates. States are numbered from 0 to ``len(offsets) - 2``.

    Attributes:
        offsets: shape (states + 1,), ascending.
        labels: shape (transitions,): event identifiers of the script's event table; 0 is tau, 1 is tick.
        targets: shape (transitions,): state numbers.
        root: the initial state.
    """

    offsets: Int64Array
    labels: Int64Array
    targets: Int64Array
    root: int = 0

    @property
    def states(self) -> int:
        """Number of states."""
        return len(self.offsets) - 1

    @property
    def transitions(self) -> int:
        """Number of transitions."""
        return len(self.labels)

    def successors(self, state: int) -> Iterator[tuple[int, int]]:
        """The (label, target) pairs of a state, in order."""
        start, end = int(self.offsets[state]), int(self.offsets[state + 1])
        return zip(self.labels[start:end].tolist(), self.targets[start:end].tolist(), strict=True)

    def alphabet(self) -> tuple[int, ...]:
        """The labels that occur, ascending."""
        return tuple(int(label) for label in distinct(self.labels))

    @classmethod
    def from_successors(cls, rows: Sequence[Iterable[tuple[int, int]]], root: int = 0) -> Lts:
        """The machine whose state ``s`` has the (label, target) pairs ``rows[s]``."""
        offsets = [0]
        labels: list[int] = []
        targets: list[int] = []
        for row in rows:
            for label, target in sorted(set(row)):
                labels.append(label)
                targets.append(target)
            offsets.append(len(labels))
        return cls(
            np.asarray(offsets, dtype=np.int64),
            np.asarray(labels, dtype=np.int64),
            np.asarray(targets, dtype=np.int64),
            root,
        )


def sources(lts: Lts) -> Int64Array:
    """The state that each transition starts from, shape (transitions,)."""
    return np.repeat(np.arange(lts.states), np.diff(lts.offsets))


def machine(states: int, starts: Int64Array, labels: Int64Array, targets: Int64Array, root: int = 0) -> Lts:
    """The machine with the given transitions, in any order and perhaps repeated."""
    afford(8 * 5 * len(starts))
    width = int(labels.max(initial=0)) + 1
    if states * width * states < ONE_NUMBER and labels.min(initial=0) >= 0:
        # A transition as one number: these are sorted in a fraction of the time that three columns take.
        keys = distinct((starts.astype(np.int64) * width + labels) * states + targets)
        keys, targets = np.divmod(keys, max(1, states))
        starts, labels = np.divmod(keys, width)
    else:
        order = np.lexsort([targets, labels, starts])
        starts, labels, targets = starts[order], labels[order], targets[order]
        fresh = np.ones(len(order), dtype=np.bool_)
        fresh[1:] = (starts[1:] != starts[:-1]) | (labels[1:] != labels[:-1]) | (targets[1:] != targets[:-1])
        starts, labels, targets = starts[fresh], labels[fresh], targets[fresh]
    counts = np.bincount(starts, minlength=states)
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    return Lts(offsets, labels.astype(np.int64), targets.astype(np.int64), root)


def reachable(lts: Lts) -> Lts:
    """What the root reaches, numbered breadth first by ascending labels and targets; the root is 0."""
    number = np.full(lts.states, -1, dtype=np.int64)
    number[lts.root] = 0
    order = [np.array([lts.root], dtype=np.int64)]
    known = 1
    while len(order[-1]):
        rows = gather_rows(lts.offsets, order[-1])
        found = lts.targets[rows]
        found = found[number[found] < 0]
        _, first = np.unique(found, return_index=True)
        found = found[np.sort(first)]
        number[found] = np.arange(known, known + len(found))
        known += len(found)
        order.append(found)
    states = np.concatenate(order)
    afford(8 * 4 * lts.transitions)
    rows = gather_rows(lts.offsets, states)
    starts = np.repeat(np.arange(known), np.diff(lts.offsets)[states])
    return machine(known, starts, lts.labels[rows], number[lts.targets[rows]])
