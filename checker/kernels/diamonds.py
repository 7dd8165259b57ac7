"""Leaving taus out of machines, as a kernel.

See ``cspcheck.checker.kernels.table`` for what is common to all kernels.
"""

from __future__ import annotations

from typing import NamedTuple

from cspcheck.checker.arrays import Int64Array, UInt8Array
from cspcheck.checker.kernels.arrays import Handed
from cspcheck.checker.kernels.partition import sort_span
from cspcheck.checker.kernels.taus import is_new_move


class _Shortcuts(NamedTuple):
    """A machine without cycles of taus but those of one state, and what is needed to leave taus out of it.

    Attributes:
        starts, middles, ends: the taus of state ``s`` are ``targets[starts[s]:middles[s]]``; its other transitions
            lie from ``middles[s]`` to ``ends[s]``, ascending by their labels.
        labels: small numbers.
        targets: states.
        diverging: 1 for states that an infinite path of taus starts from.
        acceptance: for each state the number of its acceptance, -1 if it has none.
        accepted_offsets, accepted: what each acceptance consists of: ``accepted[accepted_offsets[a]:]`` as far as
            where that of ``a + 1`` begins. No acceptance is larger than the next.
    """

    starts: Int64Array
    middles: Int64Array
    ends: Int64Array
    labels: Int64Array
    targets: Int64Array
    diverging: UInt8Array
    acceptance: Int64Array
    accepted_offsets: Int64Array
    accepted: Int64Array


class Shortcuts(Handed, _Shortcuts):
    """A machine whose taus are to be left out."""


class _Detour(NamedTuple):
    """Working space.

    Attributes:
        stamps, queue: an entry per state, all 0.
        seen, pending: an entry per state: which states the result has, and they in the order in which they are met.
        witness, found: an entry per acceptance; witness all -1.
        marks: an entry per label, all 0.
        counts: an entry per label, all 0.
        used, places: an entry per label.
        moved: an entry per transition.
        keys, key_stamps: a power of two of entries, more than twice the transitions; stamps all 0.
    """

    stamps: Int64Array
    queue: Int64Array
    seen: UInt8Array
    pending: Int64Array
    witness: Int64Array
    found: Int64Array
    marks: Int64Array
    counts: Int64Array
    used: Int64Array
    places: Int64Array
    moved: Int64Array
    keys: Int64Array
    key_stamps: Int64Array


class Detour(Handed, _Detour):
    """The working space of leaving out taus."""


def reached_from(machine: Shortcuts, space: Detour, tail: int, stamp: int) -> int:
    """Add to the first *tail* states of ``space.queue``, which bear the stamp, what taus lead to; how many that makes.

    A state that taus lead to from itself only is not added for that.
    """
    head = 0
    while head < tail:
        source = space.queue[head]
        head += 1
        for i in range(machine.starts[source], machine.middles[source]):
            target = machine.targets[i]
            if space.stamps[target] != stamp:
                space.stamps[target] = stamp
                space.queue[tail] = target
                tail += 1
    return tail


def keep_least(machine: Shortcuts, space: Detour, count: int, stamp: int) -> tuple[int, int]:
    """Keep of the first *count* acceptances of ``space.found`` those that contain no other; how many, and the stamp.

    They are numbered by their sizes.
    """
    sort_span(space.found, 0, count)
    kept = 0
    for i in range(count):
        acceptance = space.found[i]
        stamp += 1
        for j in range(machine.accepted_offsets[acceptance], machine.accepted_offsets[acceptance + 1]):
            space.marks[machine.accepted[j]] = stamp
        least = True
        for k in range(kept):
            smaller = space.found[k]
            within = True
            for j in range(machine.accepted_offsets[smaller], machine.accepted_offsets[smaller + 1]):
                if space.marks[machine.accepted[j]] != stamp:
                    within = False
                    break
            if within:
                least = False
                break
        if least:
            space.found[kept] = acceptance
            kept += 1
        else:
            space.witness[acceptance] = -1
    return kept, stamp


DONE = 0
"""The result of ``diamonds`` where all is done."""
WORKED = 1
"""Where it has looked at enough states."""
FULL = 2
"""Where there is no room for the transitions of the next state."""


def diamonds(
    machine: Shortcuts,
    space: Detour,
    sources: Int64Array,
    labels: Int64Array,
    targets: Int64Array,
    progress: Int64Array,
    most: int,
) -> int:
    """Leave out taus; see ``cspcheck.checker.reduction.compression.eliminate_diamonds``.

    Args:
        machine: the machine.
        space: working space, with the root as the only state that is seen and pending.
        sources, labels, targets: room for the transitions; taus are 0, other labels are what they were plus 1.
        progress: how many states are done, how many are pending in all, how many transitions were written down, and
            the last stamp.
        most: it comes back when it has looked at more states; a state is done as a whole.

    Returns:
        ``DONE``, ``WORKED`` or ``FULL``.
    """
    work = 0
    while progress[0] < progress[1]:
        if work > most:
            return WORKED
        state = space.pending[progress[0]]
        pending = progress[1]
        end = progress[2]
        stamp = progress[3] + 1
        progress[3] = stamp
        unstable = machine.starts[state] < machine.middles[state]
        space.stamps[state] = stamp
        space.queue[0] = state
        reached = reached_from(machine, space, 1, stamp)
        work += reached
        # The visible transitions, without repetitions, by label.
        touched = 0
        moves = 0
        for i in range(reached):
            source = space.queue[i]
            for j in range(machine.middles[source], machine.ends[source]):
                label = machine.labels[j]
                target = machine.targets[j]
                if is_new_move(label, target, len(space.stamps), space.keys, space.key_stamps, stamp):
                    if space.counts[label] == 0:
                        space.used[touched] = label
                        touched += 1
                    space.counts[label] += 1
                    moves += 1
        acceptances = 0
        if unstable:
            for i in range(reached):
                source = space.queue[i]
                acceptance = machine.acceptance[source]
                if acceptance >= 0:
                    if space.witness[acceptance] < 0:
                        space.found[acceptances] = acceptance
                        acceptances += 1
                        space.witness[acceptance] = source
                    elif source < space.witness[acceptance]:
                        space.witness[acceptance] = source
        if end + moves + acceptances + 1 > len(labels):
            for t in range(touched):
                space.counts[space.used[t]] = 0
            for i in range(acceptances):
                space.witness[space.found[i]] = -1
            return FULL
        at = 0
        for t in range(touched):
            label = space.used[t]
            space.places[label] = at
            at += space.counts[label]
            space.counts[label] = 0
        stamp += 1
        for i in range(reached):
            source = space.queue[i]
            for j in range(machine.middles[source], machine.ends[source]):
                label = machine.labels[j]
                target = machine.targets[j]
                if is_new_move(label, target, len(space.stamps), space.keys, space.key_stamps, stamp):
                    space.moved[space.places[label]] = target
                    space.places[label] += 1
        work += moves
        # Of several targets of a label those are left out that taus lead to from another.
        begin = 0
        for t in range(touched):
            label = space.used[t]
            last = space.places[label]
            stamp += 1
            if last - begin > 1:
                below = 0
                for i in range(begin, last):
                    source = space.moved[i]
                    for j in range(machine.starts[source], machine.middles[source]):
                        target = machine.targets[j]
                        if target != source and space.stamps[target] != stamp:
                            space.stamps[target] = stamp
                            space.queue[below] = target
                            below += 1
                work += reached_from(machine, space, below, stamp)
            for i in range(begin, last):
                target = space.moved[i]
                if space.stamps[target] != stamp:
                    sources[end] = state
                    labels[end] = label + 1
                    targets[end] = target
                    end += 1
            begin = last
        if unstable:
            kept, stamp = keep_least(machine, space, acceptances, stamp)
            size = 0
            if kept == 1:
                size = machine.accepted_offsets[space.found[0] + 1] - machine.accepted_offsets[space.found[0]]
            # One acceptance that is all that the state can do needs no taus to show it.
            shown = machine.diverging[state] == 0 and kept == 1 and size == touched
            for i in range(kept):
                witness = space.witness[space.found[i]]
                space.witness[space.found[i]] = -1
                if not shown and witness != state:
                    sources[end] = state
                    labels[end] = 0
                    targets[end] = witness
                    end += 1
            if machine.diverging[state] == 1:
                sources[end] = state
                labels[end] = 0
                targets[end] = state
                end += 1
        for i in range(progress[2], end):
            target = targets[i]
            if space.seen[target] == 0:
                space.seen[target] = 1
                space.pending[pending] = target
                pending += 1
        progress[0] += 1
        progress[1] = pending
        progress[2] = end
        progress[3] = stamp
    return DONE


KERNELS = (reached_from, keep_least, diamonds)
