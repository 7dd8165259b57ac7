"""The expansion of states: what every search does, whatever it searches for.

See ``cspcheck.checker.kernels.table`` for what is common to all kernels.
"""

from __future__ import annotations

from cspcheck.checker.arrays import Int32Array, Int64Array
from cspcheck.checker.kernels.arrays import Index, Rules, Scratch
from cspcheck.checker.kernels.stubborn import stubborn_set
from cspcheck.checker.kernels.table import hash_of, mixed, same_row

MAY_REPEAT = 1
MAY_BRANCH = 2


def is_repeated(targets: Int64Array, events: Int32Array, start: int, count: int, stride: int, seen: Int32Array) -> bool:
    """Whether transition *count* of the buffer equals one of those since *start*; if not it is noted in *seen*.

    *seen* is a hash table of places in the buffer. Entries before *start* belong to earlier states and count as
    empty.
    """
    mask = len(seen) - 1
    place = (mixed(hash_of(targets, count, stride)) >> 33) & mask
    while seen[place] >= start:
        other = seen[place]
        if events[other] == events[count] and same_row(targets, other, targets, count, stride):
            return True
        place = (place + 1) & mask
    seen[place] = count
    return False


def admitted(
    care: int,
    rules: Rules,
    targets: Int64Array,
    events: Int32Array,
    row: int,
    start: int,
    count: int,
    stride: int,
    scratch: Scratch,
) -> int:
    """1 if transition *count* of the buffer is to stay, 0 if the state has it already."""
    event = events[count]
    needed = care & rules.care[event]
    if needed & MAY_REPEAT and is_repeated(targets, events, start, count, stride, scratch.seen):
        return 0
    if needed & MAY_BRANCH:
        if scratch.last_row[event] == row:
            scratch.branching[0] = 1
        scratch.last_row[event] = row
    return 1


def is_ready(rules: Rules, product: int, words: int, states: Int64Array, base: int) -> bool:
    """Whether a product fires in the row that begins at *base*."""
    for w in range(words):
        if states[base + w] & rules.guard_mask[product * words + w] != rules.guard_value[product * words + w]:
            return False
    for p in range(rules.participants[product], rules.participants[product + 1]):
        local = (states[base + rules.participant_word[p]] >> rules.participant_shift[p]) & rules.participant_mask[p]
        table_row = rules.participant_rows[p] + local
        if rules.row_offsets[table_row] == rules.row_offsets[table_row + 1]:
            return False
    return True


def fires(rules: Rules, item: int, states: Int64Array, base: int) -> bool:
    """Whether an instance fires in the row that begins at *base*."""
    for part in range(rules.parts[item], rules.parts[item + 1]):
        if states[base + rules.word[part]] & rules.mask[part] != rules.value[part]:
            return False
    return True


def raised(rules: Rules, words: int, states: Int64Array, base: int) -> int:
    """The bits that the rules raise which can fire in the row that begins at *base*."""
    urgent = rules.urgent
    bits = 0
    for home in range(len(urgent.word)):
        k = urgent.base[home] + ((states[base + urgent.word[home]] >> urgent.shift[home]) & urgent.mask[home])
        for entry in range(urgent.offsets[k], urgent.offsets[k + 1]):
            item = urgent.items[entry]
            if item < 0:
                raising = rules.raises[rules.product_rule[-1 - item]]
                if bits | raising != bits and is_ready(rules, -1 - item, words, states, base):
                    bits |= raising
                continue
            raising = rules.raises[rules.rule[item]]
            if bits | raising != bits and fires(rules, item, states, base):
                bits |= raising
    return bits


def fire_product(
    product: int,
    rules: Rules,
    words: int,
    stride: int,
    states: Int64Array,
    row: int,
    capacity: int,
    care: int,
    start: int,
    count: int,
    targets: Int64Array,
    events: Int32Array,
    fired: Int32Array,
    scratch: Scratch,
) -> int:
    """Append the successors of a row by one product; the new number of transitions, or -1 if they do not fit."""
    base = row * stride
    for w in range(words):
        if states[base + w] & rules.guard_mask[product * words + w] != rules.guard_value[product * words + w]:
            return count
    first = rules.participants[product]
    last = rules.participants[product + 1]
    for p in range(first, last):
        local = (states[base + rules.participant_word[p]] >> rules.participant_shift[p]) & rules.participant_mask[p]
        table_row = rules.participant_rows[p] + local
        if rules.row_offsets[table_row] == rules.row_offsets[table_row + 1]:
            return count
        scratch.table_row[p - first] = table_row
        scratch.odometer[p - first] = rules.row_offsets[table_row]
    while True:
        if count == capacity:
            return -1
        at = count * stride
        for w in range(words):
            kept = states[base + w] & rules.product_keep[product * words + w]
            targets[at + w] = kept | rules.product_set[product * words + w]
        for w in range(words, stride):
            targets[at + w] = states[base + w]
        for p in range(first, last):
            targets[at + rules.participant_word[p]] |= rules.row_targets[scratch.odometer[p - first]]
        if len(events) > 0:
            events[count] = rules.product_event[product]
            fired[count] = rules.product_rule[product]
        if care == 0:
            count += 1
        else:
            count += admitted(care, rules, targets, events, row, start, count, stride, scratch)
        # The next combination: the last participant's targets turn fastest.
        p = last - 1
        while p >= first:
            scratch.odometer[p - first] += 1
            if scratch.odometer[p - first] < rules.row_offsets[scratch.table_row[p - first] + 1]:
                break
            scratch.odometer[p - first] = rules.row_offsets[scratch.table_row[p - first]]
            p -= 1
        if p < first:
            return count


def expand(
    rules: Rules,
    index: Index,
    words: int,
    stride: int,
    states: Int64Array,
    first: int,
    last: int,
    capacity: int,
    care: int,
    offsets: Int64Array,
    targets: Int64Array,
    events: Int32Array,
    fired: Int32Array,
    scratch: Scratch,
) -> int:
    """The successors of the rows *first* to *last* of *states* by the rules of *index*, as many rows as fit.

    Where there are tables for it, only the rules of a stubborn set of each state are looked at.

    The transitions of row ``first + i`` become entries ``offsets[i]:offsets[i + 1]`` of *targets* (with the row's
    words past *words* unchanged), *events* and *fired* (rules). The latter two are filled only if they are not
    empty; *care* needs them.

    Args:
        rules, index: see ``kernel_tables``.
        words: words of a state of the network.
        stride: words of a row, at least *words*.
        states: flat rows.
        capacity: transitions that the buffers hold.
        care: which of ``MAY_REPEAT`` and ``MAY_BRANCH`` to look after.
        scratch: see ``kernel_tables``.

    Returns:
        The first row that was not expanded: *last*, or the one whose successors did not fit.
    """
    homes = len(index.word)
    prioritised = len(rules.yields) > 0
    narrowing = len(rules.stubborn.word) > 0
    count = 0
    offsets[0] = 0
    for row in range(first, last):
        base = row * stride
        start = count
        bits = -1  # what the rules raise that can fire here is found out when a rule asks
        narrowed = 0
        if narrowing:
            narrowed = stubborn_set(rules.stubborn, states, base, scratch)
        for home in range(homes):
            k = index.base[home] + ((states[base + index.word[home]] >> index.shift[home]) & index.mask[home])
            for entry in range(index.offsets[k], index.offsets[k + 1]):
                item = index.items[entry]
                if item >= 0:
                    if words == 1:
                        if states[base] & rules.mask[item] != rules.value[item]:
                            continue
                    elif not fires(rules, item, states, base):
                        continue
                if narrowed > 0:
                    rule = rules.rule[item] if item >= 0 else rules.product_rule[-1 - item]
                    if scratch.within[rules.stubborn.slot[rules.stubborn.parts[rule]]] != narrowed:
                        continue
                if prioritised:
                    rule = rules.rule[item] if item >= 0 else rules.product_rule[-1 - item]
                    given_way = rules.yields[rule]
                    if given_way != 0:
                        if bits < 0:
                            bits = raised(rules, words, states, base)
                        if given_way & bits != 0:
                            continue
                if item < 0:
                    count = fire_product(
                        -1 - item,
                        rules,
                        words,
                        stride,
                        states,
                        row,
                        capacity,
                        care,
                        start,
                        count,
                        targets,
                        events,
                        fired,
                        scratch,
                    )
                    if count < 0:
                        return row
                    continue
                if count == capacity:
                    return row
                if words == 1:
                    targets[count * stride] = (states[base] & rules.keep[item]) | rules.set[item]
                else:
                    for w in range(words):
                        targets[count * stride + w] = states[base + w]
                    for part in range(rules.parts[item], rules.parts[item + 1]):
                        at = count * stride + rules.word[part]
                        targets[at] = (targets[at] & rules.keep[part]) | rules.set[part]
                for w in range(words, stride):
                    targets[count * stride + w] = states[base + w]
                if len(events) > 0:
                    events[count] = rules.event[item]
                    fired[count] = rules.rule[item]
                if care == 0:
                    count += 1
                else:
                    count += admitted(care, rules, targets, events, row, start, count, stride, scratch)
        offsets[row - first + 1] = count
    return last


KERNELS = (is_repeated, admitted, is_ready, fires, raised, fire_product, expand)
