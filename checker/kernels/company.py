"""Components whose transitions are worked out while the whole gets to them, as kernels.

See ``cspcheck.checker.kernels.table`` for what is common to all kernels.
"""

from __future__ import annotations

from typing import NamedTuple

from cspcheck.checker.arrays import Int32Array, Int64Array, UInt8Array
from cspcheck.checker.kernels.arrays import Handed
from cspcheck.checker.kernels.table import copy_row

FLAGS = 64
"""So many tau rules are counted together, to find the first that can fire."""


class _Company(NamedTuple):
    """Components, what is known of their transitions, and the rules by which they step together.

    Attributes:
        word, shift, mask: the field of each component in a packed state.
        grows: per component, 1 if not all of its transitions are known.
        first_row: where the rows of each component begin in *known*.
        known: the moves that are known of a component in local state ``s`` lie from ``known[first_row + s]`` to the
            next entry. Of one that does not grow, a label that is not there cannot be performed.
        labels: the label of each move, which are numbered from 0 in each component; ascending in a row.
        offsets: the targets of move ``m`` are ``targets[offsets[m]:offsets[m + 1]]``.
        targets: local states.
        asked: the labels by which component ``c`` is asked for rules are ``asked_labels[asked[c]:asked[c + 1]]``; this
            is looked at only if it grows.
        asked_labels: see there.
        first_label: where the labels of each component begin in *driven*.
        driven: the rules that label ``l`` of component ``c`` is asked for are those from ``driven[first_label[c] + l]``
            up to the next entry.
        others: what the other participants of rule ``r`` do is at the places from ``others[r]`` to ``others[r + 1]``.
        other, other_label: the component and its label.
    """

    word: Int64Array
    shift: Int64Array
    mask: Int64Array
    grows: UInt8Array
    first_row: Int64Array
    known: Int64Array
    labels: Int64Array
    offsets: Int64Array
    targets: Int32Array
    asked: Int64Array
    asked_labels: Int64Array
    first_label: Int64Array
    driven: Int64Array
    others: Int64Array
    other: Int64Array
    other_label: Int64Array


class Company(Handed, _Company):
    """The components of a composition, as far as they are known."""


class _Outcome(NamedTuple):
    """Where an expansion writes to.

    Attributes:
        rows: room for successors, each packed.
        questions: room for the moves that are not known yet but would fire a rule: component, local state, label.
        pending: room for the rows that have such moves.
        place, begin, target, until: scratch, an entry per participant of a rule.
    """

    rows: Int64Array
    questions: Int64Array
    pending: Int64Array
    place: Int64Array
    begin: Int64Array
    target: Int64Array
    until: Int64Array


class Outcome(Handed, _Outcome):
    """The room of an expansion."""


def place_of_move(company: Company, row: int, label: int) -> int:
    """Where a label is in a row of a component, -1 if it is not."""
    low = company.known[row]
    end = company.known[row + 1]
    high = end
    while low < high:
        middle = (low + high) >> 1
        if company.labels[middle] < label:
            low = middle + 1
        else:
            high = middle
    return low if low < end and company.labels[low] == label else -1


def asked(outcome: Outcome, questions: int, slot: int, local: int, label: int) -> int:
    """How many questions there are with this one; -1 if there is no room for it."""
    if 3 * questions + 3 > len(outcome.questions):
        return -1
    outcome.questions[3 * questions] = slot
    outcome.questions[3 * questions + 1] = local
    outcome.questions[3 * questions + 2] = label
    return questions + 1


def step_together(
    company: Company,
    rows: Int64Array,
    row: int,
    stride: int,
    rule: int,
    outcome: Outcome,
    count: int,
    questions: int,
) -> tuple[int, int]:
    """The successors that a rule gives; the targets of the participant that was asked for it are in *outcome*.

    Returns:
        How many successors and questions there are now; -1 for either if there is no room for more.
    """
    place = outcome.place
    begin = outcome.begin
    target = outcome.target
    until = outcome.until
    width = 1
    for i in range(company.others[rule], company.others[rule + 1]):
        slot = company.other[i]
        local = (rows[row * stride + company.word[slot]] >> company.shift[slot]) & company.mask[slot]
        known = place_of_move(company, company.first_row[slot] + local, company.other_label[i])
        if known < 0:
            if company.grows[slot] == 0:
                return count, questions
            # Those that grow come last: all others can step.
            return count, asked(outcome, questions, slot, local, company.other_label[i])
        if company.offsets[known] == company.offsets[known + 1]:
            return count, questions
        place[width] = slot
        begin[width] = company.offsets[known]
        until[width] = company.offsets[known + 1]
        width += 1
    for i in range(width):
        target[i] = begin[i]
    last = 0
    while last >= 0:
        if (count + 1) * stride > len(outcome.rows):
            return -1, questions
        copy_row(rows, row, outcome.rows, count, stride)
        for i in range(width):
            slot = place[i]
            at = count * stride + company.word[slot]
            kept = outcome.rows[at]
            kept -= kept & (company.mask[slot] << company.shift[slot])
            outcome.rows[at] = kept | (company.targets[target[i]] << company.shift[slot])
        count += 1
        # The next combination: the last participant counts fastest.
        last = width - 1
        while last >= 0 and target[last] + 1 == until[last]:
            target[last] = begin[last]
            last -= 1
        if last >= 0:
            target[last] += 1
    return count, questions


def step_by(
    company: Company,
    rows: Int64Array,
    row: int,
    stride: int,
    slot: int,
    label: int,
    known: int,
    outcome: Outcome,
    count: int,
    questions: int,
) -> tuple[int, int]:
    """The successors by the rules that a component is asked for whose move is the one at *known*; see above."""
    driven = company.first_label[slot] + label
    for rule in range(company.driven[driven], company.driven[driven + 1]):
        outcome.place[0] = slot
        outcome.begin[0] = company.offsets[known]
        outcome.until[0] = company.offsets[known + 1]
        count, questions = step_together(company, rows, row, stride, rule, outcome, count, questions)
        if count < 0 or questions < 0:
            return count, questions
    return count, questions


def expand_together(
    company: Company, rows: Int64Array, first: int, end: int, stride: int, outcome: Outcome
) -> tuple[int, int, int, int]:
    """The successors of some states, as far as the components' transitions are known.

    Args:
        company: the components.
        rows: packed states.
        first, end: which of them.
        stride: words of a state.
        outcome: for what is found. A state with a question comes again when there are answers.

    Returns:
        The first row that was not looked at, for want of room; successors, questions and pending rows.
    """
    count, questions, pending = 0, 0, 0
    for row in range(first, end):
        count_before, questions_before = count, questions
        if pending == len(outcome.pending):
            return row, count, questions, pending
        for slot in range(len(company.word)):
            local = (rows[row * stride + company.word[slot]] >> company.shift[slot]) & company.mask[slot]
            line = company.first_row[slot] + local
            if company.grows[slot] == 0:
                for known in range(company.known[line], company.known[line + 1]):
                    count, questions = step_by(
                        company, rows, row, stride, slot, company.labels[known], known, outcome, count, questions
                    )
                    if count < 0 or questions < 0:
                        return row, count_before, questions_before, pending
            else:
                for i in range(company.asked[slot], company.asked[slot + 1]):
                    label = company.asked_labels[i]
                    known = place_of_move(company, line, label)
                    if known < 0:
                        questions = asked(outcome, questions, slot, local, label)
                    elif company.offsets[known] < company.offsets[known + 1]:
                        count, questions = step_by(
                            company, rows, row, stride, slot, label, known, outcome, count, questions
                        )
                    if count < 0 or questions < 0:
                        return row, count_before, questions_before, pending
        if questions > questions_before:
            outcome.pending[pending] = row
            pending += 1
    return end, count, questions, pending


class _TauRules(NamedTuple):
    """The tau rules of a composition of small components, in the order in which they come.

    Attributes:
        touched: the parts that component ``c`` takes in tau rules are numbered from ``touched[c]`` to
            ``touched[c + 1]``.
        place: the rule of each part.
        table: where the table of each component begins in *after*; its rows are those of its local states.
        after: per local state and part of a component the state that it goes to first; -1 if it cannot.
        needs: per rule how many take part.
        parts: the parts of rule ``r`` are ``part[parts[r]:parts[r + 1]]``.
        part, part_slot: see there; and the component that takes it.
        mix: where the numbers of each component begin in *mixes*.
        mixes: a random number per local state.
    """

    touched: Int64Array
    place: Int64Array
    table: Int64Array
    after: Int32Array
    needs: Int64Array
    parts: Int64Array
    part: Int64Array
    part_slot: Int64Array
    mix: Int64Array
    mixes: Int64Array


class TauRules(Handed, _TauRules):
    """The tau rules of what is chased."""


class _TauScratch(NamedTuple):
    """Working space of a chase.

    Attributes:
        able: an entry per rule: how many participants can take their part.
        fires: an entry per rule, 1 if all of them can.
        groups: an entry per ``FLAGS`` rules: how many of these can fire.
        before: an entry per component.
    """

    able: Int64Array
    fires: UInt8Array
    groups: Int64Array
    before: Int64Array


class TauScratch(Handed, _TauScratch):
    """The working space of a chase."""


def count_able(rules: TauRules, scratch: TauScratch, slot: int, local: int, change: int) -> None:
    """Count a component in or out (*change* is 1 or -1) of the rules that it can take part in."""
    begin, end = rules.touched[slot], rules.touched[slot + 1]
    row = rules.table[slot] + local * (end - begin) - begin
    for touch in range(begin, end):
        if rules.after[row + touch] >= 0:
            place = rules.place[touch]
            scratch.able[place] += change
            fires = 1 if scratch.able[place] == rules.needs[place] else 0
            if fires != scratch.fires[place]:
                scratch.fires[place] = fires
                scratch.groups[place // FLAGS] += 2 * fires - 1


def chase_taus(rules: TauRules, state: Int64Array, scratch: TauScratch) -> bool:
    """Follow the first tau from a state, in which it is left, as long as there is one.

    Returns:
        Whether that comes to an end. A cycle is found by looking back at one state after 1, 2, 4, ... steps (Brent,
        BIT 20, 1980).
    """
    slots = len(rules.touched) - 1
    for i in range(len(scratch.able)):
        scratch.able[i] = 0
        scratch.fires[i] = 0
    for i in range(len(scratch.groups)):
        scratch.groups[i] = 0
    here = 0
    for slot in range(slots):
        scratch.before[slot] = state[slot]
        here ^= rules.mixes[rules.mix[slot] + state[slot]]
        count_able(rules, scratch, slot, state[slot], 1)
    there = here
    steps, limit = 0, 1
    while True:
        group = 0
        while group < len(scratch.groups) and scratch.groups[group] == 0:
            group += 1
        if group == len(scratch.groups):
            return True
        rule = group * FLAGS
        while scratch.fires[rule] == 0:
            rule += 1
        for i in range(rules.parts[rule], rules.parts[rule + 1]):
            slot, touch = rules.part_slot[i], rules.part[i]
            begin, old = rules.touched[slot], state[slot]
            new = rules.after[rules.table[slot] + old * (rules.touched[slot + 1] - begin) + touch - begin]
            if new != old:
                count_able(rules, scratch, slot, old, -1)
                count_able(rules, scratch, slot, new, 1)
                state[slot] = new
                here ^= rules.mixes[rules.mix[slot] + old] ^ rules.mixes[rules.mix[slot] + new]
        if here == there:
            same = 1
            for slot in range(slots):
                if state[slot] != scratch.before[slot]:
                    same = 0
                    break
            if same == 1:
                return False
        steps += 1
        if steps == limit:
            limit *= 2
            there = here
            for slot in range(slots):
                scratch.before[slot] = state[slot]


KERNELS = (place_of_move, asked, step_together, step_by, expand_together, count_able, chase_taus)
