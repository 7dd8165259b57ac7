"""The coarsest stable partition of the states of an explicit machine, as a kernel.

See ``cspcheck.checker.kernels.table`` for what is common to all kernels.
"""

from __future__ import annotations

from cspcheck.checker.arrays import Int64Array


def sort_span(keys: Int64Array, first: int, last: int) -> None:
    """Sort a span of an array in place, ascending (Shell 1959; spans are short and nearly sorted as a rule)."""
    gap = (last - first) * 5 // 11
    if gap == 0:
        gap = 1
    while gap > 0:
        for i in range(first + gap, last):
            key = keys[i]
            j = i
            while j >= first + gap and keys[j - gap] > key:
                keys[j] = keys[j - gap]
                j -= gap
            keys[j] = key
        if gap == 1:
            gap = 0
        else:
            gap = max(1, gap * 5 // 11)


def sign(
    state: int,
    offsets: Int64Array,
    labels: Int64Array,
    targets: Int64Array,
    block: Int64Array,
    size: int,
    buffer: Int64Array,
    at: int,
) -> int:
    """Write the signature of a state to a buffer: its (label, block of the target), distinct and ascending; the end."""
    end = at
    for i in range(offsets[state], offsets[state + 1]):
        buffer[end] = labels[i] * size + block[targets[i]]
        end += 1
    sort_span(buffer, at, end)
    kept = at
    for i in range(at, end):
        if i == at or buffer[i] != buffer[i - 1]:
            buffer[kept] = buffer[i]
            kept += 1
    return kept


def group_of(
    buffer: Int64Array,
    at: int,
    end: int,
    group_ends: Int64Array,
    groups: int,
    slots: Int64Array,
    stamps: Int64Array,
    stamp: int,
) -> int:
    """The group of a signature: of those found in this block so far an equal one, else the number *groups*.

    Group ``g`` has the signature ``buffer[group_ends[2 * g]:group_ends[2 * g + 1]]``. The hash table's entries are
    those that bear the stamp.
    """
    mask = len(slots) - 1
    hashed = 0
    for i in range(at, end):
        hashed = (hashed * 31 + (buffer[i] ^ (buffer[i] >> 15)) * 40503) & 0xFFFFFFFFFF
    place = (hashed ^ (hashed >> 20)) & mask
    while stamps[place] == stamp:
        group = slots[place]
        start = group_ends[2 * group]
        if group_ends[2 * group + 1] - start == end - at:
            same = True
            for i in range(end - at):
                if buffer[start + i] != buffer[at + i]:
                    same = False
                    break
            if same:
                return int(group)
        place = (place + 1) & mask
    slots[place] = groups
    stamps[place] = stamp
    return groups


def coarsest(
    size: int,
    offsets: Int64Array,
    labels: Int64Array,
    targets: Int64Array,
    earlier_offsets: Int64Array,
    earlier: Int64Array,
    block: Int64Array,
    blocks: int,
    order: Int64Array,
    place: Int64Array,
    block_first: Int64Array,
    block_last: Int64Array,
    marked: Int64Array,
    group: Int64Array,
    group_ends: Int64Array,
    group_size: Int64Array,
    group_block: Int64Array,
    fresh: Int64Array,
    dirty: Int64Array,
    changed: Int64Array,
    touched: Int64Array,
    queued: Int64Array,
    buffer: Int64Array,
    slots: Int64Array,
    stamps: Int64Array,
    progress: Int64Array,
    most: int,
) -> int:
    """Refine a partition until no two states of a block can be told apart by (label, block of the target).

    Rounds recompute the signatures only of states one of whose targets has changed its block; when a block falls
    apart its largest part keeps the number. A state changes its number only into a part at most half as large, hence
    at most log2(states) times (Hopcroft 1971; signatures as in Blom and Orzan 2003).

    What holds between rounds: states of a block that are not dirty have the same signature.

    Args:
        size: how many states there are.
        offsets, labels, targets: the machine; labels are small numbers.
        earlier_offsets, earlier: the states before each state, in compressed sparse rows.
        block: per state; the partition, which becomes the result. Blocks are numbered from 0.
        blocks: how many blocks there are.
        order, place, block_first, block_last: ``order[block_first[b]:block_last[b]]`` are the states of block b, and
            ``order[place[s]] == s``.
        marked: scratch, an entry per state, all 0.
        group, group_size, group_block, fresh, dirty, changed, touched: scratch, an entry more than states.
        group_ends: scratch, two entries more than twice the states.
        queued: scratch, an entry per state, all 0.
        buffer: scratch, as many entries as states, transitions and the most transitions of one state together.
        slots, stamps: scratch, a power of two of entries, more than twice the states; stamps all 0.
        progress: six entries, all 0 at first: whether it was begun, how many states are dirty, how many stamps were
            used, and of a round that is not finished how many blocks are touched, how many of them are done, and how
            many states have changed their block.
        most: it comes back, to be called again, when about so many states were examined; a block is done as a whole.

    Returns:
        The number of blocks when all is done; until then -1 minus how many there are.
    """
    if progress[0] == 0:
        for state in range(size):
            dirty[state] = state
            queued[state] = 1
        progress[0] = 1
        progress[1] = size
        progress[3] = -1
    dirties = progress[1]
    stamp = progress[2]
    work = 0
    while dirties > 0:
        touches = progress[3]
        begun = progress[4]
        changes = progress[5]
        if touches < 0:
            touches = 0
            for i in range(dirties):
                state = dirty[i]
                queued[state] = 0
                number = block[state]
                if marked[number] == 0:
                    touched[touches] = number
                    touches += 1
                # The dirty states of a block are moved to the front of its span.
                front = block_first[number] + marked[number]
                other = order[front]
                order[place[state]] = other
                place[other] = place[state]
                order[front] = state
                place[state] = front
                marked[number] += 1
        for t in range(begun, touches):
            if work > most:
                progress[1] = dirties
                progress[2] = stamp
                progress[3] = touches
                progress[4] = t
                progress[5] = changes
                return -1 - blocks
            number = touched[t]
            first = block_first[number]
            last = block_last[number]
            count = marked[number]
            marked[number] = 0
            if last - first == 1:
                continue
            stamp += 1
            groups = 0
            end = 0
            # One clean state stands for all of them; it is looked at first, so that they are group 0.
            clean = last - first - count
            examined = count + (1 if clean > 0 else 0)
            work += examined
            for i in range(examined):
                place_of = first + count - i if clean > 0 else first + i
                state = order[place_of]
                finish = sign(state, offsets, labels, targets, block, size, buffer, end)
                found = group_of(buffer, end, finish, group_ends, groups, slots, stamps, stamp)
                if found == groups:
                    group_ends[2 * groups] = end
                    group_ends[2 * groups + 1] = finish
                    group_size[groups] = 0
                    groups += 1
                    end = finish
                group[state] = found
                if clean > 0 and i == 0:
                    group_size[0] += clean
                else:
                    group_size[found] += 1
            if groups == 1:
                continue
            kept = 0
            for g in range(1, groups):
                if group_size[g] > group_size[kept]:
                    kept = g
            # Lay out the spans: group 0, with the clean states, at the end of the block's span, the others before.
            at = first
            for g in range(1, groups):
                share = group_size[g]
                group_ends[2 * g] = at
                if g == kept:
                    group_block[g] = number
                    block_first[number] = at
                    block_last[number] = at + share
                else:
                    group_block[g] = blocks
                    block_first[blocks] = at
                    block_last[blocks] = at + share
                    blocks += 1
                at += share
            group_ends[0] = at
            if kept == 0:
                group_block[0] = number
                block_first[number] = at
                block_last[number] = last
            else:
                group_block[0] = blocks
                block_first[blocks] = at
                block_last[blocks] = last
                blocks += 1
                for i in range(first + count, last):
                    state = order[i]
                    fresh[changes] = group_block[0]
                    changed[changes] = state
                    changes += 1
            # The dirty states are put in the spans of their groups by way of the scratch that `buffer` now is.
            for i in range(count):
                dirty_state = order[first + i]
                buffer[i] = dirty_state
            for i in range(count):
                state = buffer[i]
                g = group[state]
                order[group_ends[2 * g]] = state
                place[state] = group_ends[2 * g]
                group_ends[2 * g] += 1
                if g != kept:
                    fresh[changes] = group_block[g]
                    changed[changes] = state
                    changes += 1
        dirties = 0
        progress[3] = -1
        progress[4] = 0
        progress[5] = 0
        for i in range(changes):
            block[changed[i]] = fresh[i]
        for i in range(changes):
            state = changed[i]
            for j in range(earlier_offsets[state], earlier_offsets[state + 1]):
                source = earlier[j]
                if queued[source] == 0:
                    queued[source] = 1
                    dirty[dirties] = source
                    dirties += 1
    return blocks


KERNELS = (sort_span, sign, group_of, coarsest)
