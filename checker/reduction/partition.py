"""Partitions of the states of explicit machines: the coarsest stable one, and the machine of its classes."""

from __future__ import annotations

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int64Array, distinct
from cspcheck.checker.guard import afford
from cspcheck.checker.kernels.jit import kernels_for
from cspcheck.checker.lts import Lts, machine, reachable, sources
from cspcheck.cspm.process.events import TAU

MOST = 1 << 18
"""So many states are examined before machine code comes back: some tenths of a second."""


def coarsest_partition(lts: Lts, initial: Int64Array) -> Int64Array:
    """The coarsest refinement of a partition whose classes cannot be told apart by their transitions.

    Args:
        lts: the machine.
        initial: shape (states,): a class number for each state; any integers.

    Returns:
        The class of each state, numbered in the order of first occurrence.
    """
    size = lts.states
    slots = 2 << (2 * size).bit_length()
    afford(8 * (16 * size + 5 * lts.transitions + 2 * slots))
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

    def scratch(entries: int) -> Int64Array:
        return np.zeros(entries, dtype=np.int64)

    by_label, earlier = labels.astype(np.int64), sources(lts)[by_target]
    block_first = block_last - counts
    marked, group, fresh, dirty = (scratch(size + 1) for _ in range(4))
    group_size, group_block, changed, touched = (scratch(size + 1) for _ in range(4))
    group_ends, queued = scratch(2 * size + 2), scratch(size)
    buffer = scratch(size + lts.transitions + widest)
    hashed, stamps, progress = scratch(slots), scratch(slots), scratch(6)
    kernels, blocks = kernels_for(size), -1 - len(first)
    while blocks < 0:
        # Between two calls whoever limits this work may end it.
        blocks = kernels.coarsest(
            size,
            lts.offsets,
            by_label,
            lts.targets,
            earlier_offsets,
            earlier,
            block,
            -1 - blocks,
            order,
            place,
            block_first,
            block_last,
            marked,
            group,
            group_ends,
            group_size,
            group_block,
            fresh,
            dirty,
            changed,
            touched,
            queued,
            buffer,
            hashed,
            stamps,
            progress,
            MOST,
        )
    return numbered(block)


def numbered(classes: Int64Array) -> Int64Array:
    """The same classes, numbered from 0 in the order of first occurrence."""
    _, first, numbers = np.unique(classes, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first, kind="stable")] = np.arange(len(first))
    return rank[numbers]


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
        loops = distinct(partition[diverging])
        starts, targets = np.concatenate([starts, loops]), np.concatenate([targets, loops])
        labels = np.concatenate([labels, np.full(len(loops), TAU, dtype=np.int64)])
    classes = int(partition.max()) + 1
    return reachable(machine(classes, starts, labels, targets, int(partition[lts.root])))
