"""Sets of states that taus and events lead to, as kernels: the subset construction.

See ``cspcheck.checker.kernels.table`` for what is common to all kernels.
"""

from __future__ import annotations

from typing import NamedTuple

from cspcheck.checker.arrays import Int32Array, Int64Array, UInt8Array
from cspcheck.checker.kernels.arrays import Handed
from cspcheck.checker.kernels.partition import sort_span
from cspcheck.checker.kernels.table import GOLDEN, mixed, wrapping_product

MATTERS = 1
"""Flag of a state: it is kept in the sets that it is in."""
COLLAPSES = 2
"""Flag of a state: all sets that it is in are the one that allows everything."""

ROWS = 0
"""Where the progress of an extension has the number of transitions that were written down."""
STAMP = 1
"""Where it has the last stamp that was used."""
DIVERGENT = 2
"""Where it has the number of the node that allows everything, -1 if there is none."""
WORK = 3
"""Where it counts the states and transitions that were looked at."""
COLUMNS = 4
"""Where it has how many columns of the first node are done."""


class _Sets(NamedTuple):
    """Distinct sets of small numbers, numbered as they are met.

    Attributes:
        members: the elements of set ``s`` are ``members[offsets[s]:offsets[s + 1]]``, in no order; and room.
        offsets: the first is 0; and room.
        hashes: of each set; as much room as offsets.
        slots: an open-addressing table of the sets' numbers, a power of two of entries, -1 where none is.
        size: one entry, how many sets there are.
    """

    members: Int32Array
    offsets: Int64Array
    hashes: Int64Array
    slots: Int32Array
    size: Int64Array


class SetNumbering(Handed, _Sets):
    """A numbering of sets."""


class _Branching(NamedTuple):
    """A machine whose transitions are followed.

    Attributes:
        starts, middles, ends: the taus of state ``s`` are ``targets[starts[s]:middles[s]]``; its other transitions
            lie from ``middles[s]`` to ``ends[s]``.
        columns: the label of each transition as a small number.
        targets: the target of each transition.
        flags: for each state ``MATTERS | COLLAPSES``.
        acceptance: for each state the number of its acceptance, -1 if it has none.
    """

    starts: Int64Array
    middles: Int64Array
    ends: Int64Array
    columns: Int64Array
    targets: Int64Array
    flags: UInt8Array
    acceptance: Int64Array


class Branching(Handed, _Branching):
    """A machine that need not be deterministic."""


class _Following(NamedTuple):
    """Working space.

    Attributes:
        stamps, queue: an entry per state; stamps 0 at first.
        kept: an entry per state.
        offer_stamps: an entry per acceptance, 0 at first.
        offered: an entry per acceptance.
        counts: an entry per column, 0 at first.
        used, places: an entry per column.
        moved: an entry per transition.
    """

    stamps: Int64Array
    queue: Int64Array
    kept: Int64Array
    offer_stamps: Int64Array
    offered: Int64Array
    counts: Int64Array
    used: Int64Array
    places: Int64Array
    moved: Int64Array


class Following(Handed, _Following):
    """The working space of following transitions."""


def hash_of_element(element: int) -> int:
    """A 63-bit hash of a natural number; that of a set is the exclusive or of those of its elements."""
    return mixed(wrapping_product(element + 1, GOLDEN))


def slot_of(hashed: int, slots: int) -> int:
    """Where the search for a hash begins in a table of so many slots."""
    return (hashed ^ (hashed >> 32)) & (slots - 1)


def find_set(sets: SetNumbering, size: int, hashed: int, stamps: Int64Array, stamp: int) -> int:
    """The number of the set of *size* elements, those that bear the stamp; -1 if it has none.

    (Other numbers may bear the stamp that are no elements of any set.)
    """
    mask = len(sets.slots) - 1
    place = slot_of(hashed, len(sets.slots))
    while sets.slots[place] >= 0:
        number = int(sets.slots[place])
        if sets.hashes[number] == hashed:
            start = sets.offsets[number]
            end = sets.offsets[number + 1]
            if end - start == size:
                same = True
                for i in range(start, end):
                    if stamps[sets.members[i]] != stamp:
                        same = False
                        break
                if same:
                    return number
        place = (place + 1) & mask
    return -1


def has_room(sets: SetNumbering, size: int) -> bool:
    """Whether a set of so many elements can be added."""
    number = int(sets.size[0])
    room = int(sets.offsets[number]) + size <= len(sets.members)
    return room and number + 1 < len(sets.offsets) and 2 * (number + 1) <= len(sets.slots)


def add_set(sets: SetNumbering, elements: Int64Array, size: int, hashed: int) -> int:
    """Number a set that has none; there must be room for it."""
    number = int(sets.size[0])
    start = sets.offsets[number]
    for i in range(size):
        sets.members[start + i] = elements[i]
    sets.offsets[number + 1] = start + size
    sets.hashes[number] = hashed
    sets.size[0] = number + 1
    mask = len(sets.slots) - 1
    place = slot_of(hashed, len(sets.slots))
    while sets.slots[place] >= 0:
        place = (place + 1) & mask
    sets.slots[place] = number
    return number


def enter_slots(sets: SetNumbering, apart: int) -> None:
    """Enter all sets but the one of number *apart* into a table that is empty."""
    mask = len(sets.slots) - 1
    for number in range(sets.size[0]):
        if number != apart:
            place = slot_of(sets.hashes[number], len(sets.slots))
            while sets.slots[place] >= 0:
                place = (place + 1) & mask
            sets.slots[place] = number


def offer_of(machine: Branching, offers: SetNumbering, space: Following, size: int, stamp: int) -> int:
    """The number of the set of acceptances of the first states of ``space.kept``; -1 if there is no room for it."""
    found = 0
    hashed = 0
    for i in range(size):
        acceptance = machine.acceptance[space.kept[i]]
        if acceptance >= 0 and space.offer_stamps[acceptance] != stamp:
            space.offer_stamps[acceptance] = stamp
            space.offered[found] = acceptance
            found += 1
            hashed ^= hash_of_element(acceptance)
    number = find_set(offers, found, hashed, space.offer_stamps, stamp)
    if number < 0 and has_room(offers, found):
        number = add_set(offers, space.offered, found, hashed)
    return number


def node_of_states(
    machine: Branching,
    nodes: SetNumbering,
    offers: SetNumbering,
    node_offers: Int64Array,
    space: Following,
    begin: int,
    end: int,
    progress: Int64Array,
) -> int:
    """The node for the states ``space.moved[begin:end]`` and all that taus lead to; -1 if there is no room for it."""
    stamp = progress[STAMP] + 1
    progress[STAMP] = stamp
    tail = 0
    for i in range(begin, end):
        state = space.moved[i]
        if space.stamps[state] != stamp:
            space.stamps[state] = stamp
            space.queue[tail] = state
            tail += 1
    head = 0
    size = 0
    hashed = 0
    while head < tail:
        state = space.queue[head]
        head += 1
        flags = machine.flags[state]
        if flags & COLLAPSES != 0:
            if progress[DIVERGENT] < 0:
                number = nodes.size[0]
                if not has_room(nodes, 0):
                    return -1
                nodes.offsets[number + 1] = nodes.offsets[number]
                nodes.hashes[number] = 0
                nodes.size[0] = number + 1
                node_offers[number] = -1
                progress[DIVERGENT] = number
            return int(progress[DIVERGENT])
        if flags & MATTERS != 0:
            space.kept[size] = state
            size += 1
            hashed ^= hash_of_element(state)
        for i in range(machine.starts[state], machine.middles[state]):
            target = machine.targets[i]
            if space.stamps[target] != stamp:
                space.stamps[target] = stamp
                space.queue[tail] = target
                tail += 1
    progress[WORK] += tail
    number = find_set(nodes, size, hashed, space.stamps, stamp)
    if number < 0 and has_room(nodes, size):
        offer = offer_of(machine, offers, space, size, stamp)
        if offer >= 0:
            node_offers[nodes.size[0]] = offer
            number = add_set(nodes, space.kept, size, hashed)
    return number


def extend_nodes(
    machine: Branching,
    nodes: SetNumbering,
    offers: SetNumbering,
    node_offers: Int64Array,
    space: Following,
    first: int,
    last: int,
    row_ends: Int64Array,
    row_columns: Int32Array,
    row_targets: Int32Array,
    progress: Int64Array,
    most: int,
) -> int:
    """The transitions of the nodes from *first* to *last*, as far as there are such; what they lead to becomes nodes.

    A node is a set of states that is closed under taus, less those that do not matter (Roscoe, Understanding
    Concurrent Systems, section 16.1). One state that collapses makes it the node that allows everything, which has no
    transitions.

    Args:
        machine: the machine.
        nodes: the nodes met so far.
        offers: the sets of acceptances met so far.
        node_offers: for each node the number of its set of acceptances, -1 for the one that allows everything.
        space: working space.
        first, last: the nodes.
        row_ends: ``row_ends[i]`` becomes the end of the transitions of node ``first + i``.
        row_columns, row_targets: what is written down: the columns, ascending within a node, and the targets.
        progress: see ``ROWS``, ``STAMP``, ``DIVERGENT``, ``WORK`` and ``COLUMNS``.
        most: it comes back when the work has grown to this; a column of a node is done as a whole.

    Returns:
        The first node that is not done: there is no room for it (what it has brought into being stays, and does not
        harm), or enough has been done. Where all are done, *last* or the number of nodes.
    """
    node = first
    while node < last and node < nodes.size[0] and progress[WORK] < most:
        rows = progress[ROWS]
        if node - first >= len(row_ends):
            return node
        touched = 0
        for i in range(nodes.offsets[node], nodes.offsets[node + 1]):
            state = nodes.members[i]
            for j in range(machine.middles[state], machine.ends[state]):
                column = machine.columns[j]
                if space.counts[column] == 0:
                    space.used[touched] = column
                    touched += 1
                space.counts[column] += 1
        sort_span(space.used, 0, touched)
        at = 0
        for t in range(touched):
            column = space.used[t]
            space.places[column] = at
            at += space.counts[column]
            space.counts[column] = 0
        progress[WORK] += at
        for i in range(nodes.offsets[node], nodes.offsets[node + 1]):
            state = nodes.members[i]
            for j in range(machine.middles[state], machine.ends[state]):
                column = machine.columns[j]
                space.moved[space.places[column]] = machine.targets[j]
                space.places[column] += 1
        if rows + touched > len(row_columns):
            return node
        begin = 0
        done = int(progress[COLUMNS])
        if done > 0:
            begin = space.places[space.used[done - 1]]
        for t in range(done, touched):
            if t > done and progress[WORK] >= most:
                return node
            column = space.used[t]
            end = space.places[column]
            target = node_of_states(machine, nodes, offers, node_offers, space, begin, end, progress)
            if target < 0:
                return node
            row_columns[rows + t] = column
            row_targets[rows + t] = target
            progress[COLUMNS] = t + 1
            begin = end
        progress[COLUMNS] = 0
        progress[ROWS] = rows + touched
        row_ends[node - first] = rows + touched
        node += 1
    return node


KERNELS = (
    hash_of_element,
    slot_of,
    find_set,
    has_room,
    add_set,
    enter_slots,
    offer_of,
    node_of_states,
    extend_nodes,
)
