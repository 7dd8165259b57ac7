"""From a network's rules to masks on packed states.

A rule with its participants' local transitions multiplies out to instances; rules over the same participants are
multiplied out together, in arrays. Rules that would give too many instances stay products of tables.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cspcheck.checker.arrays import BoolArray, Int32Array, Int64Array, UInt8Array, distinct
from cspcheck.checker.kernels.arrays import WORD, Index, Rules, no_stubborn_tables
from cspcheck.checker.lts import Lts
from cspcheck.checker.network.network import Network, Switch
from cspcheck.checker.packing.layout import Layout


class LocalTransitions:
    """The transitions of one slot's machine in the order of their labels."""

    __slots__ = ("_source_counts", "labels", "sources", "states", "targets")

    def __init__(self, lts: Lts) -> None:
        sources = np.repeat(np.arange(lts.states), np.diff(lts.offsets))
        order = np.argsort(lts.labels, kind="stable")
        self.states = lts.states
        self.labels: Int64Array = lts.labels[order]
        self.sources: Int64Array = sources[order]
        self.targets: Int64Array = lts.targets[order]
        # Within a label the sources ascend, so each new one shows.
        fresh = np.ones(len(order), dtype=np.int64)
        fresh[1:] = (self.labels[1:] != self.labels[:-1]) | (self.sources[1:] != self.sources[:-1])
        self._source_counts = np.concatenate([[0], np.cumsum(fresh)])

    def ranges(self, labels: Int64Array) -> tuple[Int64Array, Int64Array]:
        """For each label the slice of transitions that carry it."""
        return np.searchsorted(self.labels, labels), np.searchsorted(self.labels, labels, side="right")

    def enabled_states(self, starts: Int64Array, ends: Int64Array) -> Int64Array:
        """How many local states have a transition in each slice of one label's transitions."""
        counts: Int64Array = self._source_counts[ends] - self._source_counts[starts]
        return counts


@dataclass(frozen=True, eq=False, slots=True)
class RuleGroup:
    """Rules of one format with the same participants, the same switch and the same priority.

    Attributes:
        format, switch, slots: what they have in common.
        numbers: shape (rules,): their numbers in the network.
        events: shape (rules,): dense events.
        starts, ends: shape (rules, participants): slices of the participants' :class:`LocalTransitions`.
        enabled: shape (rules, participants): local states in which the participant can take part.
    """

    format: int
    switch: Switch | None
    slots: tuple[int, ...]
    numbers: Int64Array
    events: Int64Array
    starts: Int64Array
    ends: Int64Array
    enabled: Int64Array

    def sizes(self) -> npt.NDArray[np.float64]:
        """How many instances each rule has; as floats, for they can be huge."""
        sizes: npt.NDArray[np.float64] = np.prod((self.ends - self.starts).astype(np.float64), axis=1)
        return sizes

    def select(self, chosen: BoolArray) -> RuleGroup:
        """The same for some of the rules."""
        return RuleGroup(
            self.format,
            self.switch,
            self.slots,
            self.numbers[chosen],
            self.events[chosen],
            self.starts[chosen],
            self.ends[chosen],
            self.enabled[chosen],
        )


def group_rules(network: Network, local: Sequence[LocalTransitions], events: Int64Array) -> list[RuleGroup]:
    """The rules that can ever fire, by participants. *events* are the identifiers by dense number."""
    # Of equal instances of a group one is kept, so what gives way to others is no group with what does not.
    members: dict[tuple[int, Switch | None, tuple[int, ...], int, int], list[int]] = {}
    for number, rule in enumerate(network.rules):
        key = (rule.format, rule.switch, tuple(slot for slot, _ in rule.moves), rule.raises, rule.yields)
        members.setdefault(key, []).append(number)
    groups: list[RuleGroup] = []
    for (format, switch, slots, _, _), numbers in members.items():
        labels = np.array([[label for _, label in network.rules[n].moves] for n in numbers], dtype=np.int64)
        labels = labels.reshape(len(numbers), len(slots))
        starts, ends, enabled = np.empty_like(labels), np.empty_like(labels), np.empty_like(labels)
        for i, slot in enumerate(slots):
            starts[:, i], ends[:, i] = local[slot].ranges(labels[:, i])
            enabled[:, i] = local[slot].enabled_states(starts[:, i], ends[:, i])
        results = np.array([network.rules[n].result for n in numbers], dtype=np.int64)
        group = RuleGroup(
            format,
            switch,
            slots,
            np.array(numbers, dtype=np.int64),
            np.searchsorted(events, results),
            starts,
            ends,
            enabled,
        )
        possible = np.logical_and.reduce(ends > starts, axis=1)
        if possible.any():
            groups.append(group.select(possible))
    return groups


@dataclass(frozen=True, eq=False, slots=True)
class Effect:
    """What all rules of a group do to a state, by word: the bits they look at, keep, and set whatever the targets.

    Attributes:
        format_mask, format_value: the bits of the format, and what they must be.
        keep: bits that stay as they are.
        set: bits that are set.
        moving: the participants (positions in the group's slots) whose targets count; the switch says what becomes of
            the others.
    """

    format_mask: list[int]
    format_value: list[int]
    keep: list[int]
    set: list[int]
    moving: list[int]


def effect_of(group: RuleGroup, layout: Layout) -> Effect:
    """The effect that a group's rules have in common."""
    zeros = [0] * layout.words
    effect = Effect(list(zeros), list(zeros), [WORD] * layout.words, list(zeros), [])
    field = layout.format
    effect.format_mask[field.word] |= field.mask
    effect.format_value[field.word] |= group.format << field.shift
    replaced: set[int] = set()
    if group.switch is not None:
        replaced = {*group.switch.cleared, *(slot for slot, _ in group.switch.started)}
        effect.keep[field.word] &= ~field.mask
        effect.set[field.word] |= group.switch.format << field.shift
        for slot in group.switch.cleared:
            effect.keep[layout.slots[slot].word] &= ~layout.slots[slot].mask
        for slot, state in group.switch.started:
            effect.keep[layout.slots[slot].word] &= ~layout.slots[slot].mask
            effect.set[layout.slots[slot].word] |= state << layout.slots[slot].shift
    for i, slot in enumerate(group.slots):
        effect.keep[layout.slots[slot].word] &= ~layout.slots[slot].mask
        if slot not in replaced:
            effect.moving.append(i)
    return effect


@dataclass(frozen=True, eq=False, slots=True)
class Instances:
    """The instances of a group.

    Attributes:
        group: the group.
        rows: shape (instances,): which rule of the group.
        sources: shape (instances, participants): local states.
        words: the words that they look at or change.
        value, set: shape (instances, len(words)).
        mask, keep: shape (len(words),).
    """

    group: RuleGroup
    rows: Int64Array
    sources: Int64Array
    words: list[int]
    mask: Int64Array
    value: Int64Array
    keep: Int64Array
    set: Int64Array


def multiply_out(group: RuleGroup, layout: Layout, local: Sequence[LocalTransitions], causes: Int64Array) -> Instances:
    """The instances of all rules of a group; of equal ones that of the least (cause, rule) alone."""
    lengths = group.ends - group.starts
    sizes = np.prod(lengths, axis=1)
    rows = np.repeat(np.arange(len(group.numbers)), sizes)
    rest = np.arange(len(rows)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    sources = np.empty((len(rows), len(group.slots)), dtype=np.int64)
    targets = np.empty_like(sources)
    for i in reversed(range(len(group.slots))):
        rest, digit = np.divmod(rest, lengths[rows, i])
        transition = group.starts[rows, i] + digit
        sources[:, i] = local[group.slots[i]].sources[transition]
        targets[:, i] = local[group.slots[i]].targets[transition]

    effect = effect_of(group, layout)
    mask = list(effect.format_mask)
    value = np.tile(np.array(effect.format_value, dtype=np.int64), (len(rows), 1))
    set = np.tile(np.array(effect.set, dtype=np.int64), (len(rows), 1))
    for i, slot in enumerate(group.slots):
        field = layout.slots[slot]
        mask[field.word] |= field.mask
        value[:, field.word] |= sources[:, i] << field.shift
        if i in effect.moving:
            set[:, field.word] |= targets[:, i] << field.shift

    if group.switch is not None or len(distinct(group.events)) < len(group.events):
        kept = _first_of_equal(group, rows, value, set, causes)
        rows, sources, value, set = rows[kept], sources[kept], value[kept], set[kept]
    touched = [w for w in range(layout.words) if mask[w] or effect.keep[w] != WORD] or [0]
    return Instances(
        group,
        rows,
        sources,
        touched,
        np.array([mask[w] for w in touched], dtype=np.int64),
        value[:, touched],
        np.array([effect.keep[w] for w in touched], dtype=np.int64),
        set[:, touched],
    )


def _first_of_equal(
    group: RuleGroup, rows: Int64Array, value: Int64Array, set: Int64Array, causes: Int64Array
) -> Int64Array:
    """Of the instances with the same event, value and set the one of the least (cause, rule)."""
    numbers = group.numbers[rows]
    keys = [group.events[rows], *value.T, *set.T]
    order = np.lexsort([numbers, causes[numbers], *keys])
    fresh = np.zeros(len(order), dtype=np.bool_)
    fresh[:1] = True
    for key in keys:
        fresh[1:] |= key[order][1:] != key[order][:-1]
    return np.sort(order[fresh])


@dataclass(eq=False, slots=True)
class Products:
    """The rules that stay products, in the making. The lists become the arrays of :class:`Rules`."""

    layout: Layout
    local: Sequence[LocalTransitions]
    event: list[int]
    rule: list[int]
    guard_mask: list[int]
    guard_value: list[int]
    keep: list[int]
    set: list[int]
    participants: list[int]
    word: list[int]
    shift: list[int]
    mask: list[int]
    rows: list[int]
    row_lengths: list[Int64Array]
    row_targets: list[Int64Array]
    known: dict[tuple[int, int, bool], int]
    next_row: int = 0

    @classmethod
    def none(cls, layout: Layout, local: Sequence[LocalTransitions]) -> Products:
        """No products yet."""
        return cls(layout, local, [], [], [], [], [], [], [0], [], [], [], [], [], [], {})

    def add(self, group: RuleGroup) -> None:
        """Add the rules of a group."""
        effect = effect_of(group, self.layout)
        for row, number in enumerate(group.numbers.tolist()):
            self.event.append(int(group.events[row]))
            self.rule.append(number)
            self.guard_mask += effect.format_mask
            self.guard_value += effect.format_value
            self.keep += effect.keep
            self.set += effect.set
            for i, slot in enumerate(group.slots):
                field = self.layout.slots[slot]
                self.word.append(field.word)
                self.shift.append(field.shift)
                self.mask.append((1 << field.width) - 1)
                start, end = int(group.starts[row, i]), int(group.ends[row, i])
                self.rows.append(self._table(slot, start, end, i in effect.moving))
            self.participants.append(len(self.word))

    def _table(self, slot: int, start: int, end: int, moving: bool) -> int:
        """The first row of the table with the targets of a slice of a slot's transitions, by local state."""
        base = self.known.get((slot, start, moving))
        if base is None:
            base = self.known[slot, start, moving] = self.next_row
            local, field = self.local[slot], self.layout.slots[slot]
            lengths = np.bincount(local.sources[start:end], minlength=local.states)
            # Within a label transitions ascend by source, so the targets are in the order of the rows already.
            targets = local.targets[start:end] << field.shift
            if not moving:
                lengths = np.minimum(lengths, 1)
                targets = np.zeros(int(lengths.sum()), dtype=np.int64)
            self.row_lengths.append(lengths)
            self.row_targets.append(targets)
            self.next_row += len(lengths)
        return base


def rules_in_arrays(layout: Layout, blocks: Sequence[Instances], products: Products, care: UInt8Array) -> Rules:
    """Everything in the flat arrays that the kernels read, priority apart; instances numbered block after block."""
    counts = [np.full(len(block.rows), len(block.words), dtype=np.int64) for block in blocks]
    lengths = _joined(counts)

    def per_part(columns: Sequence[Int64Array]) -> Int64Array:
        return _joined([column.reshape(-1) for column in columns])

    return Rules(
        parts=np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64),
        word=per_part([np.tile(np.array(b.words, dtype=np.int64), len(b.rows)) for b in blocks]),
        mask=per_part([np.tile(b.mask, len(b.rows)) for b in blocks]),
        value=per_part([b.value for b in blocks]),
        keep=per_part([np.tile(b.keep, len(b.rows)) for b in blocks]),
        set=per_part([b.set for b in blocks]),
        event=_joined([b.group.events[b.rows] for b in blocks]).astype(np.int32),
        rule=_joined([b.group.numbers[b.rows] for b in blocks]).astype(np.int32),
        care=care,
        product_event=_int32(products.event),
        product_rule=_int32(products.rule),
        guard_mask=_int64(products.guard_mask),
        guard_value=_int64(products.guard_value),
        product_keep=_int64(products.keep),
        product_set=_int64(products.set),
        participants=_int64(products.participants),
        participant_word=_int64(products.word),
        participant_shift=_int64(products.shift),
        participant_mask=_int64(products.mask),
        participant_rows=_int64(products.rows),
        row_offsets=np.concatenate([[0], np.cumsum(_joined(products.row_lengths))]).astype(np.int64),
        row_targets=_joined(products.row_targets),
        raises=_int64([]),
        yields=_int64([]),
        urgent=Index(_int64([]), _int64([]), _int64([]), _int64([]), _int64([0]), _int32([])),
        stubborn=no_stubborn_tables(),
    )


def _joined(arrays: Sequence[Int64Array]) -> Int64Array:
    return np.concatenate([np.zeros(0, dtype=np.int64), *arrays]).astype(np.int64, copy=False)


def _int64(numbers: Sequence[int]) -> Int64Array:
    return np.array(numbers, dtype=np.int64)


def _int32(numbers: Sequence[int]) -> Int32Array:
    return np.array(numbers, dtype=np.int32)
