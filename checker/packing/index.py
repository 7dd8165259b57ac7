"""Which rules a state has to look at.

A home is a run of a few neighbouring fields; it lists for each of its values the rules that the value allows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int32Array, Int64Array, distinct
from cspcheck.checker.kernels.arrays import Index
from cspcheck.checker.packing.instances import Instances, LocalTransitions, RuleGroup
from cspcheck.checker.packing.layout import BitField, Layout

HOME_BITS = 8
"""Neighbouring fields share a home up to this many bits: 256 lists, which the cache holds."""
LISTED = 4_000_000
"""Entries of lists past which fields get homes of their own."""

FORMAT = -1
"""Stands for the format where slots are numbered."""


@dataclass(frozen=True, slots=True)
class Home:
    """A run of bits: the fields of ``members`` (slots, or ``FORMAT``), which are neighbours in a word."""

    word: int
    shift: int
    width: int
    members: tuple[int, ...]


def make_homes(layout: Layout, bits: int = HOME_BITS) -> list[Home]:
    """The homes that cover all fields, neighbours together up to the given number of bits; at least one home."""
    fields = sorted(
        ((field.word, field.shift, field.width, member) for member, field in _fields(layout) if field.width),
    )
    homes: list[Home] = []
    for word, shift, width, member in fields:
        last = homes[-1] if homes else None
        if last is not None and last.word == word and last.width + width <= bits:
            homes[-1] = Home(word, last.shift, last.width + width, (*last.members, member))
        else:
            homes.append(Home(word, shift, width, (member,)))
    return homes or [Home(0, 0, 0, ())]


def _fields(layout: Layout) -> list[tuple[int, BitField]]:
    return [(FORMAT, layout.format), *enumerate(layout.slots)]


@dataclass(frozen=True, eq=False, slots=True)
class Listing:
    """Entries of lists: with value ``keys[i]``, home ``home`` lists item ``items[i]``."""

    home: int
    keys: Int64Array
    items: Int64Array


class Listings:
    """The lists of all homes, in the making.

    Attributes:
        homes: the homes.
        listings: what they list.
        overflow: whether there were more entries than allowed; the lists are not usable then.
    """

    __slots__ = ("_choices", "_entries", "_layout", "_local", "_most", "homes", "listings", "overflow")

    def __init__(
        self, layout: Layout, local: Sequence[LocalTransitions], formats: int, homes: list[Home], most: int | None
    ) -> None:
        self.homes = homes
        self.listings: list[Listing] = []
        self.overflow = False
        self._entries = 0
        self._most = most
        self._layout = layout
        self._local = local
        self._choices = {FORMAT: formats, **{slot: local[slot].states for slot in range(len(local))}}

    def add_instances(self, block: Instances, first: int) -> None:
        """List the instances of a block, numbered from *first*."""
        at_home = self._best_homes(block.group)[block.rows]
        numbers = first + np.arange(len(block.rows))
        for home in distinct(at_home).tolist():
            chosen = at_home == home
            keys = np.zeros(int(chosen.sum()), dtype=np.int64)
            for member in self.homes[home].members:
                if member == FORMAT:
                    keys += block.group.format << self._place(home, member)
                elif member in block.group.slots:
                    i = block.group.slots.index(member)
                    keys += block.sources[chosen, i] << self._place(home, member)
            self._list(home, block.group, keys, numbers[chosen])

    def add_products(self, group: RuleGroup, first: int) -> None:
        """List the rules of a group that stay products, numbered from *first*."""
        at_home = self._best_homes(group)
        for row, home in enumerate(at_home.tolist()):
            keys = np.zeros(1, dtype=np.int64)
            for member in self.homes[home].members:
                if member == FORMAT:
                    keys = keys + (group.format << self._place(home, member))
                elif member in group.slots:
                    i = group.slots.index(member)
                    sources = distinct(self._local[member].sources[group.starts[row, i] : group.ends[row, i]])
                    keys = np.add.outer(keys, sources << self._place(home, member)).reshape(-1)
            items = np.full(len(keys), -1 - (first + row), dtype=np.int64)
            self._list(home, group, keys, items)

    def _best_homes(self, group: RuleGroup) -> Int64Array:
        """For each rule of a group the home whose lists name it for the smallest share of values."""
        best = np.full(len(group.numbers), 2.0)
        chosen = np.zeros(len(group.numbers), dtype=np.int64)
        for number, home in enumerate(self.homes):
            if home.members and not any(m == FORMAT or m in group.slots for m in home.members):
                continue
            share = np.ones(len(group.numbers))
            for member in home.members:
                if member == FORMAT:
                    share /= self._choices[FORMAT]
                elif member in group.slots:
                    share *= group.enabled[:, group.slots.index(member)] / self._choices[member]
            better = share < best
            best[better], chosen[better] = share[better], number
        return chosen

    def _list(self, home: int, group: RuleGroup, keys: Int64Array, items: Int64Array) -> None:
        """List items for the given values of the group's fields and all values of the home's other fields."""
        others = np.zeros(1, dtype=np.int64)
        for member in self.homes[home].members:
            if member != FORMAT and member not in group.slots:
                choices = np.arange(self._choices[member], dtype=np.int64) << self._place(home, member)
                others = np.add.outer(others, choices).reshape(-1)
        self._entries += len(keys) * len(others)
        if self._most is not None and self._entries > self._most:
            self.overflow = True
            return
        listed = np.add.outer(keys, others).reshape(-1)
        self.listings.append(Listing(home, listed, np.repeat(items, len(others))))

    def _place(self, home: int, member: int) -> int:
        """The lowest bit of a member's field within the home."""
        field = self._layout.format if member == FORMAT else self._layout.slots[member]
        return field.shift - self.homes[home].shift

    def index(self, wanted: Callable[[Int64Array], BoolArray], order: Callable[[Int64Array], Int64Array]) -> Index:
        """The lists of the wanted items, each in the given order; homes that list none of them are left out.

        Args:
            wanted: for items, which of them are to be listed (booleans).
            order: for items, numbers by which a list is to be sorted.
        """
        words, shifts, masks, bases = [], [], [], []
        lengths: list[Int64Array] = []
        items: list[Int64Array] = []
        rows = 0
        for number, home in enumerate(self.homes):
            mine = [listing for listing in self.listings if listing.home == number]
            if not mine:
                continue
            keys = np.concatenate([listing.keys for listing in mine])
            listed = np.concatenate([listing.items for listing in mine])
            chosen = wanted(listed)
            keys, listed = keys[chosen], listed[chosen]
            if not len(keys):
                continue
            words.append(home.word)
            shifts.append(home.shift)
            masks.append((1 << home.width) - 1)
            bases.append(rows)
            lengths.append(np.bincount(keys, minlength=1 << home.width))
            items.append(listed[np.lexsort([order(listed), keys])])
            rows += 1 << home.width
        offsets = np.concatenate([np.zeros(1, dtype=np.int64), *lengths]).cumsum()
        joined: Int32Array = np.concatenate([np.zeros(0, dtype=np.int64), *items]).astype(np.int32)
        return Index(
            np.array(words, dtype=np.int64),
            np.array(shifts, dtype=np.int64),
            np.array(masks, dtype=np.int64),
            np.array(bases, dtype=np.int64),
            offsets.astype(np.int64),
            joined,
        )
