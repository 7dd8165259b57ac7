"""Machines in which events may be preceded or followed by taus, as kernels.

See ``cspcheck.checker.kernels.table`` for what is common to all kernels.
"""

from __future__ import annotations

from typing import NamedTuple

from cspcheck.checker.arrays import Int32Array, Int64Array
from cspcheck.checker.kernels.arrays import Handed
from cspcheck.checker.kernels.table import GOLDEN, NATURAL, mixed, wrapping_product


def reach(
    size: int,
    first: int,
    starts: Int64Array,
    middles: Int64Array,
    targets: Int64Array,
    stamps: Int64Array,
    first_stamp: int,
    reach_offsets: Int64Array,
    reached: Int32Array,
    most: int,
) -> int:
    """Write down for each state what taus lead to from it, itself included, in an order in which it comes first.

    Args:
        size: how many states there are.
        first: those before it are done.
        starts, middles, targets: the taus of state ``s`` are ``targets[starts[s]:middles[s]]``, all less than ``s``.
        stamps, first_stamp: scratch, an entry per state, none above *first_stamp*; none becomes larger than that by
            more than the number of states.
        reach_offsets: becomes where the states that state ``s`` reaches are in *reached*: from ``reach_offsets[s]``
            to ``reach_offsets[s + 1]``.
        reached: room.
        most: it comes back when it has looked at more.

    Returns:
        How many states are done; -1 minus that where there is no room for the next.
    """
    end = reach_offsets[first]
    work = 0
    for state in range(first, size):
        if end >= len(reached):
            return -1 - state
        stamp = first_stamp + state + 1
        stamps[state] = stamp
        reached[end] = state
        end += 1
        for i in range(starts[state], middles[state]):
            target = targets[i]
            if stamps[target] != stamp:
                work += reach_offsets[target + 1] - reach_offsets[target]
                if work > most:
                    return state
                for j in range(reach_offsets[target], reach_offsets[target + 1]):
                    other = reached[j]
                    if stamps[other] != stamp:
                        if end >= len(reached):
                            return -1 - state
                        stamps[other] = stamp
                        reached[end] = other
                        end += 1
        reach_offsets[state + 1] = end
    return size


def hash_of_key(key: int) -> int:
    """A 63-bit hash of a natural number, without regularities."""
    return mixed(wrapping_product(key, GOLDEN))


def is_new_move(label: int, target: int, size: int, keys: Int64Array, key_stamps: Int64Array, stamp: int) -> bool:
    """Whether a transition is not yet in the hash table of those with this stamp; it is entered."""
    key = label * size + target
    mask = len(keys) - 1
    hashed = wrapping_product(key, GOLDEN)
    place = (hashed ^ (hashed >> 32)) & mask
    while key_stamps[place] == stamp:
        if keys[place] == key:
            return False
        place = (place + 1) & mask
    keys[place] = key
    key_stamps[place] = stamp
    return True


def saturate(
    size: int,
    first: int,
    middles: Int64Array,
    ends: Int64Array,
    labels: Int64Array,
    targets: Int64Array,
    reach_offsets: Int64Array,
    reached: Int32Array,
    taus_after: int,
    keys: Int64Array,
    key_stamps: Int64Array,
    first_stamp: int,
    offsets: Int64Array,
    moved_labels: Int64Array,
    moved_targets: Int64Array,
    most: int,
) -> int:
    """Write down the moves tau* and tau* a, or tau* a tau*, of each state.

    Args:
        size: how many states there are.
        first: those before it are done.
        middles, ends, labels, targets: the transitions that are no taus of state ``s`` lie from ``middles[s]`` to
            ``ends[s]``.
        reach_offsets, reached: see :func:`reach`.
        taus_after: 1 if taus may follow an event.
        keys, key_stamps, first_stamp: scratch, a power of two of entries, more than there is room for moves; stamps
            as those of :func:`reach`.
        offsets: becomes where the moves of each state begin, and the last end.
        moved_labels, moved_targets: room for the moves; taus are 0.
        most: it comes back when it has looked at more.

    Returns:
        How many states are done; -1 minus that where there is no room for the next.
    """
    end = offsets[first]
    work = 0
    for state in range(first, size):
        stamp = first_stamp + state + 1
        begin = reach_offsets[state]
        last = reach_offsets[state + 1]
        if end + last - begin > len(moved_labels):
            return -1 - state
        for i in range(begin, last):
            moved_labels[end] = 0
            moved_targets[end] = reached[i]
            end += 1
        for i in range(begin, last):
            source = reached[i]
            work += 1
            for j in range(middles[source], ends[source]):
                target = targets[j]
                # The first of what a state reaches is the state itself.
                stop = reach_offsets[target] + 1
                if taus_after == 1:
                    stop = reach_offsets[target + 1]
                work += stop - reach_offsets[target]
                if work > most:
                    return state
                for k in range(reach_offsets[target], stop):
                    after = reached[k]
                    if is_new_move(labels[j], after, size, keys, key_stamps, stamp):
                        if end >= len(moved_labels):
                            return -1 - state
                        moved_labels[end] = labels[j]
                        moved_targets[end] = after
                        end += 1
        offsets[state + 1] = end
    return size


BRANCHING = 0
"""Signatures of branching bisimulation: what follows taus within a class."""
DELAY = 1
"""Signatures of delay bisimulation: what follows any taus."""
WEAK = 2
"""Signatures of weak bisimulation: what follows any taus, and what taus lead to after that."""


class _Signatures(NamedTuple):
    """The signatures of states, which become known one by one.

    Attributes:
        offsets: the signature of state ``s`` is ``keys[offsets[s]:offsets[s + 1]]``, in no order.
        keys: and room.
    """

    offsets: Int64Array
    keys: Int64Array


class Signatures(Handed, _Signatures):
    """The signatures of states."""


class _Classes(NamedTuple):
    """What is needed to write signatures and to tell them apart.

    Attributes:
        of: the class of each state.
        group: becomes the new class of each state.
        representatives, hashes: an entry per state.
        slots: a power of two of entries, more than twice the states, all -1.
        keys, stamps: a power of two of entries, more than a signature can have.
    """

    of: Int64Array
    group: Int64Array
    representatives: Int64Array
    hashes: Int64Array
    slots: Int64Array
    keys: Int64Array
    stamps: Int64Array


class RefinedPartition(Handed, _Classes):
    """A partition that is being refined."""


def is_same_signature(signatures: Signatures, begin: int, end: int, classes: RefinedPartition, stamp: int) -> bool:
    """Whether all of a signature is in the hash table of the keys with this stamp."""
    mask = len(classes.keys) - 1
    for i in range(begin, end):
        key = signatures.keys[i]
        hashed = wrapping_product(key, GOLDEN)
        place = (hashed ^ (hashed >> 32)) & mask
        found = False
        while classes.stamps[place] == stamp:
            if classes.keys[place] == key:
                found = True
                break
            place = (place + 1) & mask
        if not found:
            return False
    return True


def with_keys(
    source: Signatures,
    begin: int,
    end: int,
    factor: int,
    signatures: Signatures,
    at: int,
    classes: RefinedPartition,
    stamp: int,
) -> int:
    """Add keys of a signature, each plus *factor* times the states, to another that ends at *at*; the new end.

    -1 if there is no room.
    """
    for i in range(begin, end):
        key = source.keys[i]
        if is_new_move(factor, key, len(classes.of), classes.keys, classes.stamps, stamp):
            if at >= len(signatures.keys):
                return -1
            signatures.keys[at] = factor * len(classes.of) + key
            at += 1
    return at


def with_key(key: int, signatures: Signatures, at: int, classes: RefinedPartition, stamp: int) -> int:
    """Add a key to a signature that ends at *at*; the new end, -1 if there is no room."""
    if is_new_move(0, key, len(classes.of), classes.keys, classes.stamps, stamp):
        if at >= len(signatures.keys):
            return -1
        signatures.keys[at] = key
        at += 1
    return at


def refine_by_signatures(
    first: int,
    starts: Int64Array,
    middles: Int64Array,
    ends: Int64Array,
    labels: Int64Array,
    targets: Int64Array,
    kind: int,
    classes: RefinedPartition,
    first_stamp: int,
    signatures: Signatures,
    behind: Signatures,
    groups: int,
    most: int,
) -> tuple[int, int]:
    """One round: states stay together that are together and have the same signature, classes being what they are.

    The signature of a state is made of those of the states that its taus lead to, which come before it (Blom and
    Orzan, "Distributed branching bisimulation reduction of state spaces", 2003). Its keys are classes that taus lead
    to, and for each label, times the number of states, classes that the label leads to.

    Args:
        first: the states before it are done.
        starts, middles, ends, labels, targets: the taus of state ``s`` are ``targets[starts[s]:middles[s]]``, all less
            than ``s``; its other transitions, of labels above 0, lie from ``middles[s]`` to ``ends[s]``.
        kind: ``BRANCHING``, ``DELAY`` or ``WEAK``.
        classes: working space and result.
        first_stamp: no stamp is above this; none becomes larger by more than the number of states.
        signatures: room.
        behind: for ``WEAK`` the classes that taus lead to from each state.
        groups: how many classes there are so far.
        most: it comes back when it has looked at more; a state is done as a whole.

    Returns:
        How many states are done, -1 minus that where there is no room for the next; and how many classes there are
        so far.
    """
    size = len(classes.of)
    mask = len(classes.slots) - 1
    work = 0
    for state in range(first, size):
        if work > most:
            return state, groups
        stamp = first_stamp + state + 1
        own = classes.of[state]
        begin = signatures.offsets[state]
        end = begin
        if kind != BRANCHING:
            end = with_key(own, signatures, end, classes, stamp)
        for i in range(starts[state], middles[state]):
            target = targets[i]
            if end >= 0:
                if kind != BRANCHING or classes.of[target] == own:
                    last = signatures.offsets[target + 1]
                    work += last - signatures.offsets[target]
                    end = with_keys(signatures, signatures.offsets[target], last, 0, signatures, end, classes, stamp)
                else:
                    end = with_key(classes.of[target], signatures, end, classes, stamp)
        for i in range(middles[state], ends[state]):
            target = targets[i]
            if end >= 0:
                if kind == WEAK:
                    last = behind.offsets[target + 1]
                    work += last - behind.offsets[target]
                    end = with_keys(behind, behind.offsets[target], last, labels[i], signatures, end, classes, stamp)
                else:
                    end = with_key(labels[i] * size + classes.of[target], signatures, end, classes, stamp)
        if end < 0:
            return -1 - state, groups
        work += 1 + ends[state] - starts[state]
        signatures.offsets[state + 1] = end
        hashed = hash_of_key(NATURAL - 1 - own)
        for i in range(begin, end):
            hashed ^= hash_of_key(signatures.keys[i])
        place = (hashed ^ (hashed >> 32)) & mask
        found = -1
        while classes.slots[place] >= 0:
            number = classes.slots[place]
            other = classes.representatives[number]
            start = signatures.offsets[other]
            stop = signatures.offsets[other + 1]
            same = classes.hashes[number] == hashed and classes.of[other] == own and stop - start == end - begin
            if same and is_same_signature(signatures, start, stop, classes, stamp):
                found = number
                break
            place = (place + 1) & mask
        if found < 0:
            found = groups
            classes.slots[place] = groups
            classes.representatives[groups] = state
            classes.hashes[groups] = hashed
            groups += 1
        classes.group[state] = found
    return size, groups


def least_keys(
    starts: Int64Array,
    middles: Int64Array,
    ends: Int64Array,
    labels: Int64Array,
    targets: Int64Array,
    block: Int64Array,
    weights: Int64Array,
    shifts: Int64Array,
    behind: Int64Array,
    least: Int64Array,
) -> None:
    """The least weight among the keys of the signature of each state; see :func:`refine_by_signatures`.

    States of one signature have one least weight, and to find it no signature has to be written down. (Broder, "On the
    resemblance and containment of documents", 1997, tells sets apart by such weights.)

    Args:
        weights: per class, less than 2**61. The weight of the key of a label and a class is that of the class and the
            shift of the label.
        shifts: per label, less than 2**61.
        behind: for weak bisimulation the least weight of the classes that taus lead to from each state, else empty.
        least: per state; the result.
    """
    for state in range(len(block)):
        best = weights[block[state]]
        for i in range(starts[state], middles[state]):
            if least[targets[i]] < best:
                best = least[targets[i]]
        for i in range(middles[state], ends[state]):
            weight = shifts[labels[i]]
            if len(behind) > 0:
                weight += behind[targets[i]]
            else:
                weight += weights[block[targets[i]]]
            if weight < best:
                best = weight
        least[state] = best


KERNELS = (
    reach,
    hash_of_key,
    is_new_move,
    saturate,
    is_same_signature,
    with_keys,
    with_key,
    refine_by_signatures,
    least_keys,
)
