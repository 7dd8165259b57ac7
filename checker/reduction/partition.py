"""Partitions of the states of explicit machines: the coarsest stable one, and the machine of its classes."""

from __future__ import annotations

import numpy as np

from cspcheck.checker.lts import Int64Array, Lts
from cspcheck.checker.search.walk import kernels_for
from cspcheck.checker.sparse_rows import gather_rows
from cspcheck.checker.specification.normal_form import BoolArray
from cspcheck.cspm.process.events import TAU


def coarsest_partition(lts: Lts, initial: Int64Array) -> Int64Array:
    """The coarsest refinement of a partition whose classes cannot be told apart by their transitions.

    Args:
        lts: the machine.
        initial: shape (states,): a class number for each state; any integers.

    Returns:
        The class of each state, numbered in the order of first occurrence.
    """
    size = lts.states
    _, first = np.unique(initial, return_index=True)
    block = numbered(np.asarray(initial, dtype=np.int64))
    order = np.argsort(block, kind="stable").astype(np.int64)
    place = np.empty(size, dtype=np.int64)
    place[order] = np.arange(size)
    counts = np.bincount(block, minlength=size)
    block_last = np.cumsum(counts)
    _, labels = np.unique(lts.labels, return_inverse=True)
    by_target = np.argsort(lts.targets, kind="stable")
    earlier_offsets = np.concatenate([[0], np.cumsum(np.bincount(lts.targets, minlength=size))]).astype(np.int64)
    widest = int(np.diff(lts.offsets).max(initial=0))
    slots = 2 << (2 * size).bit_length()

    def scratch(entries: int) -> Int64Array:
        return np.zeros(entries, dtype=np.int64)

    kernels_for(size).coarsest(
        size,
        lts.offsets,
        labels.astype(np.int64),
        lts.targets,
        earlier_offsets,
        sources(lts)[by_target],
        block,
        len(first),
        order,
        place,
        block_last - counts,
        block_last,
        scratch(size),
        scratch(size + 1),
        scratch(2 * size + 2),
        scratch(size + 1),
        scratch(size + 1),
        scratch(size + 1),
        scratch(size + 1),
        scratch(size + 1),
        scratch(size + 1),
        scratch(size),
        scratch(size + lts.transitions + widest),
        scratch(slots),
        scratch(slots),
    )
    return numbered(block)


def numbered(classes: Int64Array) -> Int64Array:
    """The same classes, numbered from 0 in the order of first occurrence."""
    _, first, numbers = np.unique(classes, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first, kind="stable")] = np.arange(len(first))
    return rank[numbers]


def sources(lts: Lts) -> Int64Array:
    """The state that each transition starts from, shape (transitions,)."""
    return np.repeat(np.arange(lts.states), np.diff(lts.offsets))


def quotient(lts: Lts, partition: Int64Array, *, keep_inner_taus: bool, diverging: BoolArray | None = None) -> Lts:
    """The machine whose states are the classes, numbered breadth first from the root's; unreachable ones are left out.

    Args:
        lts: the machine.
        partition: shape (states,): the class of each state, numbered from 0 without gaps.
        keep_inner_taus: whether a tau inside a class stays a tau of the class to itself.
        diverging: shape (states,); a class with a diverging state gets a tau to itself.
    """
    starts, targets, labels = partition[sources(lts)], partition[lts.targets], lts.labels
    if not keep_inner_taus:
        kept = (labels != TAU) | (starts != targets)
        starts, targets, labels = starts[kept], targets[kept], labels[kept]
    if diverging is not None:
        loops = np.unique(partition[diverging])
        starts, targets = np.concatenate([starts, loops]), np.concatenate([targets, loops])
        labels = np.concatenate([labels, np.full(len(loops), TAU, dtype=np.int64)])
    classes = int(partition.max()) + 1
    return reachable(machine(classes, starts, labels, targets, int(partition[lts.root])))


def machine(states: int, starts: Int64Array, labels: Int64Array, targets: Int64Array, root: int = 0) -> Lts:
    """The machine with the given transitions, in any order and perhaps repeated."""
    order = np.lexsort([targets, labels, starts])
    starts, labels, targets = starts[order], labels[order], targets[order]
    fresh = np.ones(len(order), dtype=np.bool_)
    fresh[1:] = (starts[1:] != starts[:-1]) | (labels[1:] != labels[:-1]) | (targets[1:] != targets[:-1])
    counts = np.bincount(starts[fresh], minlength=states)
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    return Lts(offsets, labels[fresh].astype(np.int64), targets[fresh].astype(np.int64), root)


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
    rows = gather_rows(lts.offsets, states)
    starts = np.repeat(np.arange(known), np.diff(lts.offsets)[states])
    return machine(known, starts, lts.labels[rows], number[lts.targets[rows]])
