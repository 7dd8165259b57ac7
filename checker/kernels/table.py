"""The search's inner loops, first part: the set of visited states.

Every kernel is plain Python on flat arrays (or memory views of them) and integers, and at the same time in that part
of Python which ``translation`` understands; ``cspcheck.checker.kernels.jit`` gives both. Numbers are natural and below
2**63 throughout, so that Python's integers, numpy's and the machine's agree; nothing may overflow. The one place where
a product may is :func:`wrapping_product`.

A table of visited states is an open-addressing hash table with linear probing of ``2**bits`` entries. An entry is
-1, or the state's row number in its low ``bits`` bits below a *tag* of further bits of its hash, ``entry_bits`` in
all: a wrong state is nearly always recognised without looking at its row. Kernels say ``Int32Array`` of a table and
take one of 64 bits as well, for more states than 32 bits can number. A table is cut into
``2**partition_bits`` equal partitions, each of which one thread may change while others change theirs; probing stays
within a partition, which therefore can be full before the table is.

A search of millions of states would mostly wait for memory. The loops over many rows therefore ask for the entry that
a row will need ``AHEAD`` rows before, and ``CLOSE`` rows before for the state that this entry names.
"""

from __future__ import annotations

from typing import Any

from cspcheck.checker.arrays import Int32Array, Int64Array

NATURAL = 0x7FFFFFFFFFFFFFFF
GOLDEN = 0x1E3779B97F4A7C15
MIXER = 0x3F58476D1CE4E5B9

AHEAD = 64
"""How many rows ahead an entry is asked for."""
CLOSE = 32
"""How many rows ahead the state is asked for that the entry, which has come meanwhile, names."""


def wrapping_product(a: int, b: int) -> int:
    """The low 63 bits of a product. (``translation`` has this for the machine.)"""
    return a * b & NATURAL


def prefetch(array: Any, index: int) -> None:
    """Tell the processor that an element will be needed soon; it may lie outside. (``translation`` has
    this for the machine.)
    """


def hash_of(rows: Int64Array, row: int, stride: int) -> int:
    """A 63-bit hash of a row; the high bits depend on all of it.

    Multiplying by the golden section keeps regular sets of states apart and keeps the distances between states and
    their successors, which the cache rewards (Knuth, The Art of Computer Programming 3, section 6.4).
    """
    base = row * stride
    h = wrapping_product(rows[base], GOLDEN)
    for w in range(1, stride):
        h = wrapping_product((h ^ (h >> 32)) ^ rows[base + w], GOLDEN)
    return h


def mixed(h: int) -> int:
    """Another 63-bit hash from a hash, without regularities."""
    return wrapping_product(h ^ (h >> 32), MIXER)


def same_row(rows: Int64Array, row: int, others: Int64Array, other: int, stride: int) -> bool:
    """Whether two rows are equal."""
    if rows[row * stride] != others[other * stride]:
        return False
    for w in range(1, stride):  # noqa: SIM110 (kernels have no all)
        if rows[row * stride + w] != others[other * stride + w]:
            return False
    return True


def copy_row(rows: Int64Array, row: int, others: Int64Array, other: int, stride: int) -> None:
    """Copy a row to the place of another."""
    others[other * stride] = rows[row * stride]
    for w in range(1, stride):
        others[other * stride + w] = rows[row * stride + w]


def place_of(
    targets: Int64Array,
    row: int,
    stride: int,
    states: Int64Array,
    table: Int32Array,
    bits: int,
    entry_bits: int,
    partition_bits: int,
) -> tuple[int, int]:
    """Where a row of *targets* is entered in the table, or is to be, and its number.

    Returns:
        The place, -1 if the row has none in its full partition, and the number, -1 if the row is not there.
    """
    wrap = (1 << (bits - partition_bits)) - 1
    index_mask = (1 << bits) - 1
    h = hash_of(targets, row, stride)
    tag = (h >> (63 - entry_bits)) & ((1 << (entry_bits - bits)) - 1)
    place = h >> (63 - bits)
    last = (place & ~wrap) | ((place - 1) & wrap)
    while True:
        entry = table[place]
        if entry < 0:
            return place, -1
        if entry >> bits == tag:
            number = entry & index_mask
            if same_row(states, number, targets, row, stride):
                return place, number
        if place == last:
            return -1, -1
        place = (place & ~wrap) | ((place + 1) & wrap)


def entry_of(targets: Int64Array, row: int, stride: int, number: int, bits: int, entry_bits: int) -> int:
    """The entry of a state with a number, which is in a row of *targets*."""
    tag = (hash_of(targets, row, stride) >> (63 - entry_bits)) & ((1 << (entry_bits - bits)) - 1)
    return (tag << bits) | number


def ask_ahead(
    targets: Int64Array, row: int, end: int, stride: int, states: Int64Array, table: Int32Array, bits: int
) -> None:
    """Have what the rows ahead will need brought from memory."""
    if row + AHEAD < end:
        prefetch(table, hash_of(targets, row + AHEAD, stride) >> (63 - bits))
        named = table[hash_of(targets, row + CLOSE, stride) >> (63 - bits)] & ((1 << bits) - 1)
        prefetch(states, named * stride)


def insert(
    targets: Int64Array,
    begin: int,
    end: int,
    stride: int,
    states: Int64Array,
    known: int,
    room: int,
    table: Int32Array,
    bits: int,
    entry_bits: int,
    partition_bits: int,
    numbers: Int64Array,
) -> tuple[int, int]:
    """Add the rows *begin* to *end* of *targets* to the visited states, as long as there is room.

    Args:
        known: how many states there are; new ones are numbered on from there.
        room: how many there may be.
        numbers: if not empty, ``numbers[i]`` becomes the number of the state in row ``i`` of *targets*.

    Returns:
        The first row not added for want of room in its partition or altogether (*end* if all were added), and how
        many states there are now.
    """
    numbered = len(numbers) > 0
    for j in range(begin, end):
        ask_ahead(targets, j, end, stride, states, table, bits)
        place, number = place_of(targets, j, stride, states, table, bits, entry_bits, partition_bits)
        if number < 0:
            if place < 0 or known == room:
                return j, known
            table[place] = entry_of(targets, j, stride, known, bits, entry_bits)
            copy_row(targets, j, states, known, stride)
            number = known
            known += 1
        if numbered:
            numbers[j] = number
    return end, known


def find(
    targets: Int64Array,
    count: int,
    stride: int,
    states: Int64Array,
    table: Int32Array,
    bits: int,
    entry_bits: int,
    partition_bits: int,
    numbers: Int64Array,
) -> None:
    """The numbers of the first *count* rows of *targets* among the visited states; -1 for those that are not there."""
    for j in range(count):
        ask_ahead(targets, j, count, stride, states, table, bits)
        _, number = place_of(targets, j, stride, states, table, bits, entry_bits, partition_bits)
        numbers[j] = number


def enter_all(
    states: Int64Array,
    known: int,
    stride: int,
    table: Int32Array,
    bits: int,
    entry_bits: int,
    partition_bits: int,
    first_partition: int,
    last_partition: int,
) -> bool:
    """Enter those of the distinct states that belong to the given partitions into their empty part of the table.

    Returns:
        Whether the partitions were large enough.
    """
    wrap = (1 << (bits - partition_bits)) - 1
    tag_mask = (1 << (entry_bits - bits)) - 1
    for row in range(known):
        if row + AHEAD < known:
            ahead = hash_of(states, row + AHEAD, stride) >> (63 - bits)
            partition = ahead >> (bits - partition_bits)
            if first_partition <= partition < last_partition:
                prefetch(table, ahead)
        h = hash_of(states, row, stride)
        place = h >> (63 - bits)
        partition = place >> (bits - partition_bits)
        if partition < first_partition or partition >= last_partition:
            continue
        last = (place & ~wrap) | ((place - 1) & wrap)
        while table[place] >= 0:
            if place == last:
                return False
            place = (place & ~wrap) | ((place + 1) & wrap)
        table[place] = (((h >> (63 - entry_bits)) & tag_mask) << bits) | row
    return True


def sort_by_owner(
    targets: Int64Array,
    count: int,
    stride: int,
    partition_bits: int,
    owners: int,
    capacity: int,
    ends: Int64Array,
    outbox: Int64Array,
) -> None:
    """Copy rows to *outbox* grouped by the worker that owns their partition.

    Owner ``o`` has ``capacity`` rows of *outbox* from ``o * capacity`` on; its last one is before ``ends[o]``.
    """
    if owners == 2:
        # Written to both places, of which one is written to again: a wrong guess would cost more.
        low, high = 0, capacity
        for j in range(count):
            owner = hash_of(targets, j, stride) >> 62
            copy_row(targets, j, outbox, low, stride)
            copy_row(targets, j, outbox, high, stride)
            low += 1 - owner
            high += owner
        ends[0] = low
        ends[1] = high
        return
    for o in range(owners):
        ends[o] = o * capacity
    for j in range(count):
        owner = (hash_of(targets, j, stride) >> (63 - partition_bits)) * owners >> partition_bits
        at = ends[owner]
        ends[owner] = at + 1
        copy_row(targets, j, outbox, at, stride)


def sort_by_rank(
    targets: Int64Array, count: int, stride: int, ranks: int, capacity: int, ends: Int64Array, outbox: Int64Array
) -> None:
    """Copy rows to *outbox* grouped by the process that they belong to; otherwise as :func:`sort_by_owner`.

    That is told by another hash than the place in the table, whose entries would lie in a part of it only otherwise.
    """
    for o in range(ranks):
        ends[o] = o * capacity
    for j in range(count):
        rank = ((mixed(hash_of(targets, j, stride)) >> 31) * ranks) >> 32
        at = ends[rank]
        ends[rank] = at + 1
        copy_row(targets, j, outbox, at, stride)


def move(
    states: Int64Array,
    source: int,
    target: int,
    count: int,
    stride: int,
    table: Int32Array,
    bits: int,
    partition_bits: int,
) -> None:
    """Give *count* states, from number *source* on, numbers from *target* on, and the rows of these."""
    wrap = (1 << (bits - partition_bits)) - 1
    index_mask = (1 << bits) - 1
    for i in range(count):
        if i + CLOSE < count:
            prefetch(table, hash_of(states, source + i + CLOSE, stride) >> (63 - bits))
        place = hash_of(states, source + i, stride) >> (63 - bits)
        while table[place] & index_mask != source + i:
            place = (place & ~wrap) | ((place + 1) & wrap)
        table[place] = (table[place] >> bits << bits) | (target + i)
        copy_row(states, source + i, states, target + i, stride)


KERNELS = (
    hash_of,
    mixed,
    same_row,
    copy_row,
    place_of,
    entry_of,
    ask_ahead,
    insert,
    find,
    enter_all,
    sort_by_owner,
    sort_by_rank,
    move,
)
