"""The arrays that the kernels read a network's rules from, as named tuples that are the same for machine code.

States are rows of 63-bit words in flat int64 arrays; every number here is a natural number, so that plain Python
integers, numpy's and machine arithmetic agree on all of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cspcheck.checker.arrays import Int32Array, Int64Array, UInt8Array

WORD_BITS = 63
"""Bits of a word that are used. The sign bit stays clear."""
WORD = (1 << WORD_BITS) - 1
"""All used bits of a word."""

MAY_REPEAT = 1
"""Flag of an event: two rules can give the same transition, so transitions have to be compared."""
MAY_BRANCH = 2
"""Flag of a visible event: a state may have two targets for it."""


class Handed:
    """A named tuple that can be told what machine code is handed of it; its arrays stay where they are.

    Attributes:
        words: that, for ``machine_code``; none before the first time. It is no part of the value: a copy has none.
    """

    words: Sequence[int] | None = None

    def __getstate__(self) -> None:
        """Nothing beside the members is copied or written anywhere."""
        return


class _Rules(NamedTuple):
    """Rules as masks, and those that are too many for that as products of tables.

    An *instance* is a rule together with a local transition of each participant. It fires in a state when
    ``state & mask == value`` in each of its *parts* (one part a word that it looks at or changes); its successor is
    ``state & keep | set`` there. The parts of instance ``i`` are ``parts[i]:parts[i + 1]``; with one-word states
    part ``i`` is that of instance ``i``.

    A *product* is a rule that is evaluated from one table per participant: row ``rows + local state`` of a
    participant holds its possible targets, shifted into place. It fires when its guard holds and no row is empty,
    once for each combination of targets: ``state & keep | set | targets``.
    """

    parts: Int64Array
    word: Int64Array
    mask: Int64Array
    value: Int64Array
    keep: Int64Array
    set: Int64Array
    event: Int32Array
    rule: Int32Array
    care: UInt8Array
    """For each dense event ``MAY_REPEAT | MAY_BRANCH``."""
    product_event: Int32Array
    product_rule: Int32Array
    guard_mask: Int64Array
    """Shape (products * words): the format in which the product applies."""
    guard_value: Int64Array
    product_keep: Int64Array
    """Shape (products * words)."""
    product_set: Int64Array
    participants: Int64Array
    """Shape (products + 1): the participants of product ``p`` are the slice ``participants[p]:participants[p + 1]``."""
    participant_word: Int64Array
    participant_shift: Int64Array
    participant_mask: Int64Array
    participant_rows: Int64Array
    row_offsets: Int64Array
    row_targets: Int64Array
    raises: Int64Array
    """For each rule of the network the bits that it raises where it can fire; empty if no rule yields to another."""
    yields: Int64Array
    """For each rule the bits that it yields to: it fires only where no rule that can fire raises one of them."""
    urgent: Index
    """The rules that raise a bit."""
    stubborn: StubbornTables
    """What narrows the rules of a state to a stubborn set; of no slots where nothing is narrowed."""


class Rules(Handed, _Rules):
    """The rules of a network."""


class _Index(NamedTuple):
    """Which rules are worth looking at in a state.

    A *home* is a run of bits in one word of a state, a few neighbouring fields. Row ``base + bits`` of a home lists
    the rules that those bits allow: an instance by its number, product ``p`` as ``-1 - p``. Each rule is at home in
    one place, so the lists of a state's homes name each candidate once.
    """

    word: Int64Array
    shift: Int64Array
    mask: Int64Array
    base: Int64Array
    offsets: Int64Array
    items: Int32Array


class Index(Handed, _Index):
    """An index of rules."""


class _StubbornTables(NamedTuple):
    """What a stubborn set of a state is found from: the rules by the local states that they start from.

    Attributes:
        word, shift, mask: per slot the field of its local state, the mask not in place.
        base: per slot its first row; the row of a local state is ``base + local state``.
        offsets: the rules that a slot in the local state of row ``r`` can take part in are
            ``entries[offsets[r]:offsets[r + 1]]``.
        entries: rules.
        format_word, format_shift, format_mask: the field of the format, the mask not in place.
        format: per rule the format in which it applies.
        parts: the participants of rule ``r`` are ``parts[r]:parts[r + 1]``.
        slot: per participant the slot.
        able: per participant where in ``ready`` its local states begin.
        ready: 1 for the local states in which a participant can take part.
        wide_offsets, wide: for each format the rules that all slots depend on.
        free: per rule 1 if a set that leaves something out may have it.
    """

    word: Int64Array
    shift: Int64Array
    mask: Int64Array
    base: Int64Array
    offsets: Int64Array
    entries: Int32Array
    format_word: int
    format_shift: int
    format_mask: int
    format: Int32Array
    parts: Int64Array
    slot: Int32Array
    able: Int64Array
    ready: UInt8Array
    wide_offsets: Int64Array
    wide: Int32Array
    free: UInt8Array


class StubbornTables(Handed, _StubbornTables):
    """The tables that stubborn sets are found from."""


def no_stubborn_tables() -> StubbornTables:
    """The tables of a search that narrows nothing."""
    none8, none32, none64 = np.zeros(0, dtype=np.uint8), np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.int64)
    return StubbornTables(
        none64,
        none64,
        none64,
        none64,
        none64,
        none32,
        0,
        0,
        0,
        none32,
        none64,
        none32,
        none64,
        none8,
        none64,
        none32,
        none8,
    )


class _Scratch(NamedTuple):
    """Working space of the expansion.

    Attributes:
        seen: for ``MAY_REPEAT``: a power of two of entries, more than the buffers hold, all -1 at the start of a call.
        last_row: for ``MAY_BRANCH``: an entry per dense event, none of them the number of a row to be expanded.
        branching: one entry, set to 1 when a state has two targets for a visible event.
        table_row, odometer: an entry per participant of the widest product.
        within: for stubborn sets: per slot the number of the last set that it was in, and behind them the last number.
        waiting: an entry per slot.
    """

    seen: Int32Array
    last_row: Int64Array
    branching: Int64Array
    table_row: Int64Array
    odometer: Int64Array
    within: Int64Array
    waiting: Int64Array


class Scratch(Handed, _Scratch):
    """The working space of an expansion."""


class _Guide(NamedTuple):
    """A specification's normal form and where pairs keep their node; see ``cspcheck.checker.search.pair_search``.

    Attributes:
        word, shift, mask: the field of the node; the mask is 0 where there is no specification.
        columns: per dense event of the implementation its column in the normal form, -1 where it has none.
        starts, ends: per node its slice of ``row_columns`` (ascending within it) and ``row_targets`` (nodes).
        divergent: per node, 1 if it allows everything.
        acceptance_set: per node the number of its set of acceptances.
        set_offsets: set ``k`` is the acceptances ``set_offsets[k]:set_offsets[k + 1]``.
        acceptance_offsets: acceptance ``a`` is the slice ``acceptance_offsets[a]:acceptance_offsets[a + 1]`` of
            ``members``, which are columns.
        offered: scratch, an entry per column, none of them the number of a pair to be looked at plus one.
    """

    word: int
    shift: int
    mask: int
    columns: Int32Array
    starts: Int64Array
    ends: Int64Array
    row_columns: Int32Array
    row_targets: Int32Array
    divergent: UInt8Array
    acceptance_set: Int32Array
    set_offsets: Int64Array
    acceptance_offsets: Int64Array
    members: Int32Array
    offered: Int64Array


class Guide(Handed, _Guide):
    """The guide of a search for pairs."""


def no_guide() -> Guide:
    """The guide of a search without a specification."""
    none32, none64 = np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.int64)
    return Guide(
        0,
        0,
        0,
        none32,
        none64,
        none64,
        none32,
        none32,
        np.zeros(0, dtype=np.uint8),
        none32,
        none64,
        none64,
        none32,
        none64,
    )
