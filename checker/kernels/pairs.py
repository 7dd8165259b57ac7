"""Pairs of a specification's node and an implementation's state.

See ``cspcheck.checker.kernels.table`` for what is common to all kernels.
"""

from __future__ import annotations

from cspcheck.checker.arrays import Int32Array, Int64Array, UInt8Array
from cspcheck.checker.kernels.arrays import Guide

TRACE = 1
REFUSAL = 2


def node_of(guide: Guide, rows: Int64Array, row: int, stride: int) -> int:
    """The node in a row."""
    node: int = (rows[row * stride + guide.word] >> guide.shift) & guide.mask
    return node


def at_divergent_node(guide: Guide, rows: Int64Array, row: int, stride: int) -> bool:
    """Whether the row's node allows everything; False where there is no specification."""
    if guide.mask == 0:
        return False
    divergent: int = guide.divergent[node_of(guide, rows, row, stride)]
    return divergent != 0


def node_after(guide: Guide, node: int, event: int) -> int:
    """The node behind a visible event (dense number), or -1 where it is not allowed."""
    column = guide.columns[event]
    if column < 0:
        return -1
    low = guide.starts[node]
    end = guide.ends[node]
    high = end
    while low < high:
        middle = (low + high) >> 1
        if guide.row_columns[middle] < column:
            low = middle + 1
        else:
            high = middle
    after = -1
    if low < end and guide.row_columns[low] == column:
        after = guide.row_targets[low]
    return after


def accepts_enough(guide: Guide, node: int, mark: int) -> bool:
    """Whether one of the node's minimal acceptances consists of columns whose ``offered`` is *mark*."""
    sets = guide.acceptance_set[node]
    for acceptance in range(guide.set_offsets[sets], guide.set_offsets[sets + 1]):
        enough = True
        for i in range(guide.acceptance_offsets[acceptance], guide.acceptance_offsets[acceptance + 1]):
            if guide.offered[guide.members[i]] != mark:
                enough = False
                break
        if enough:
            return True
    return False


def refuses_too_much(
    guide: Guide, node: int, start: int, end: int, events: Int32Array, stable: bool, mark: int
) -> bool:
    """Whether a state that offers ``events[start:end]`` may refuse what the node does not let it refuse.

    A state that can tick can refuse everything but the tick, be it stable or not; otherwise an unstable state
    refuses nothing.
    """
    ticks = False
    for i in range(start, end):
        if events[i] == 1:
            ticks = True
    if not (ticks or stable):
        return False
    for i in range(start, end):
        column = guide.columns[events[i]]
        if column >= 0 and (events[i] == 1 or not ticks):
            guide.offered[column] = mark
    return not accepts_enough(guide, node, mark)


def follow(
    guide: Guide,
    states: Int64Array,
    first: int,
    rows: int,
    stride: int,
    judging: int,
    moved: UInt8Array,
    first_moved: int,
    offsets: Int64Array,
    targets: Int64Array,
    events: Int32Array,
    fired: Int32Array,
    verdicts: UInt8Array,
) -> int:
    """Take the specification along: enter the node afterwards into each transition, and drop the forbidden ones.

    The transitions are those that ``expand`` gave for the rows from *first* on; *offsets* and the buffers are closed
    up in place. Transitions of pairs at a divergent node are dropped.

    Args:
        guide: see ``kernel_tables``.
        judging: 1 if the transitions are the visible ones, which show what is violated; 0 if they are the taus.
        moved: ``moved[first_moved + i]`` tells whether row ``first + i`` is unstable; empty if none is.
        verdicts: if not empty, ``verdicts[i]`` becomes what row ``first + i`` violates: ``TRACE | REFUSAL``.

    Returns:
        What all rows together violate.
    """
    kept = 0
    start = 0
    violated = 0
    for i in range(rows):
        row = first + i
        end = offsets[i + 1]
        node = node_of(guide, states, row, stride)
        verdict = 0
        if guide.divergent[node] == 0:
            if judging == 1:
                stable = len(moved) == 0 or moved[first_moved + i] == 0
                if refuses_too_much(guide, node, start, end, events, stable, row + 1):
                    verdict = REFUSAL
            for j in range(start, end):
                after = node
                if events[j] != 0:
                    after = node_after(guide, node, events[j])
                    if after < 0:
                        verdict |= TRACE
                        continue
                for w in range(stride):
                    targets[kept * stride + w] = targets[j * stride + w]
                targets[kept * stride + guide.word] ^= (node ^ after) << guide.shift
                events[kept] = events[j]
                fired[kept] = fired[j]
                kept += 1
        if len(verdicts) > 0:
            verdicts[i] = verdict
        violated |= verdict
        start = end
        offsets[i + 1] = kept
    return violated


def nodes_after(
    guide: Guide, before: Int64Array, sources: Int64Array, events: Int32Array, count: int, after: Int64Array
) -> None:
    """For transitions of pairs the nodes afterwards, -1 where the specification does not allow the event.

    Transition ``i`` is by ``events[i]`` from a pair with the node ``before[sources[i]]``. A tau keeps the node, and so
    does everything at a node that allows everything.
    """
    for i in range(count):
        node = before[sources[i]]
        if events[i] == 0 or guide.divergent[node] != 0:
            after[i] = node
        else:
            after[i] = node_after(guide, node, events[i])


KERNELS = (node_of, at_divergent_node, node_after, accepts_enough, refuses_too_much, follow, nodes_after)
