"""What a search asks of a level once its states are expanded: deadlocks and cycles of taus.

See ``cspcheck.checker.kernels.table`` for what is common to all kernels.
"""

from __future__ import annotations

from cspcheck.checker.arrays import Int32Array, Int64Array, UInt8Array
from cspcheck.checker.kernels.arrays import Guide, Index, Rules, Scratch
from cspcheck.checker.kernels.expand import expand
from cspcheck.checker.kernels.pairs import at_divergent_node
from cspcheck.checker.kernels.table import find


def note_movers(offsets: Int64Array, rows: int, moved: UInt8Array, first: int) -> None:
    """Set ``moved[first + i]`` for each of the rows that has a transition."""
    for i in range(rows):
        if offsets[i + 1] > offsets[i]:
            moved[first + i] = 1


def matches(states: Int64Array, row: int, words: int, stride: int, patterns: Int64Array) -> bool:
    """Whether a row agrees with one of the patterns: a mask for each word, then the values."""
    for pattern in range(0, len(patterns), 2 * words):
        agrees = True
        for w in range(words):
            if states[row * stride + w] & patterns[pattern + w] != patterns[pattern + words + w]:
                agrees = False
                break
        if agrees:
            return True
    return False


def count_deadlocks(
    offsets: Int64Array,
    first: int,
    rows: int,
    moved: UInt8Array,
    first_moved: int,
    states: Int64Array,
    words: int,
    stride: int,
    patterns: Int64Array,
) -> int:
    """How many of the rows from *first* on have no transition and match no pattern (of the terminated state).

    ``moved[first_moved + i]`` tells whether row ``first + i`` has a transition that *offsets* does not count; an
    empty *moved* that none has.
    """
    count = 0
    for i in range(rows):
        if offsets[i + 1] > offsets[i] or (len(moved) > 0 and moved[first_moved + i] != 0):
            continue
        if not matches(states, first + i, words, stride, patterns):
            count += 1
    return count


def count_arrivals(numbers: Int64Array, count: int, start: int, end: int, arrivals: Int32Array) -> int:
    """Count in ``arrivals[number - start]`` how often each state of a level occurs in *numbers*; the total."""
    total = 0
    for i in range(count):
        number = numbers[i]
        if start <= number < end:
            arrivals[number - start] += 1
            total += 1
    return total


def peel(
    rules: Rules,
    index: Index,
    guide: Guide,
    words: int,
    stride: int,
    states: Int64Array,
    start: int,
    end: int,
    arrivals: Int32Array,
    queue: Int32Array,
    head: int,
    tail: int,
    most: int,
    capacity: int,
    offsets: Int64Array,
    targets: Int64Array,
    events: Int32Array,
    fired: Int32Array,
    scratch: Scratch,
    table: Int32Array,
    bits: int,
    entry_bits: int,
    partition_bits: int,
    numbers: Int64Array,
) -> tuple[int, int]:
    """Take away the states of a level at which no tau arrives, and again; what stays is on or behind a cycle.

    Kahn's topological sorting (Communications of the ACM 5, 1962).

    Args:
        start, end: the rows of the level.
        arrivals: per state of the level, how many taus of states not taken away lead to it; a transition that
            several rules give counts for each.
        queue: the states taken away, as numbers within the level; those before *head* are dealt with, those before
            *tail* are known.
        most: how many states to deal with before coming back.
        capacity: transitions that the buffers hold; if a state has more, the return is early.

    Returns:
        The new *head* and *tail*. It is done when they are equal.
    """
    for _ in range(most):
        if head == tail:
            break
        row = start + queue[head]
        if not at_divergent_node(guide, states, row, stride):
            if (
                expand(
                    rules,
                    index,
                    words,
                    stride,
                    states,
                    row,
                    row + 1,
                    capacity,
                    0,
                    offsets,
                    targets,
                    events,
                    fired,
                    scratch,
                )
                == row
            ):
                break
            find(targets, offsets[1], stride, states, table, bits, entry_bits, partition_bits, numbers)
            for i in range(offsets[1]):
                target = numbers[i] - start
                if 0 <= target < end - start:
                    arrivals[target] -= 1
                    if arrivals[target] == 0:
                        queue[tail] = target
                        tail += 1
        head += 1
    return head, tail


def strong_components(
    offsets: Int64Array,
    targets: Int64Array,
    nodes: int,
    component: Int64Array,
    low: Int64Array,
    stack: Int64Array,
    path: Int64Array,
) -> int:
    """Number the strongly connected components of a graph in compressed sparse rows.

    Tarjan's algorithm (SIAM Journal on Computing 1, 1972), with its recursion on an explicit path.

    Args:
        component: per node; becomes its component's number.
        low, stack: scratch, an entry per node.
        path: scratch, two entries per node: the nodes being visited, and the next edge of each.

    Returns:
        The number of components.
    """
    components = 0
    visited = 0
    on_stack = 0
    for node in range(nodes):
        component[node] = -1
        low[node] = -1
    for root in range(nodes):
        if low[root] >= 0:
            continue
        depth = 0
        path[0] = root
        path[1] = -1
        while depth >= 0:
            node = path[2 * depth]
            if path[2 * depth + 1] < 0:
                # Until a component is complete, component[node] is -2 minus the node's number in order of visit.
                low[node] = visited
                component[node] = -2 - visited
                visited += 1
                stack[on_stack] = node
                on_stack += 1
                path[2 * depth + 1] = offsets[node]
            descended = False
            while path[2 * depth + 1] < offsets[node + 1]:
                target = targets[path[2 * depth + 1]]
                if low[target] < 0:
                    depth += 1
                    path[2 * depth] = target
                    path[2 * depth + 1] = -1
                    descended = True
                    break
                if component[target] < 0 and low[target] < low[node]:
                    low[node] = low[target]
                path[2 * depth + 1] += 1
            if descended:
                continue
            if low[node] == -2 - component[node]:
                while True:
                    on_stack -= 1
                    member = stack[on_stack]
                    component[member] = components
                    if member == node:
                        break
                components += 1
            depth -= 1
            if depth >= 0:
                caller = path[2 * depth]
                if component[node] < 0 and low[node] < low[caller]:
                    low[caller] = low[node]
                path[2 * depth + 1] += 1
    return components


KERNELS = (note_movers, matches, count_deadlocks, count_arrivals, peel, strong_components)
