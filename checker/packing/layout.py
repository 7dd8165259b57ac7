"""Where the parts of a network's state are in its words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.kernels.arrays import WORD_BITS
from cspcheck.checker.network.network import Network


@dataclass(frozen=True, slots=True)
class BitField:
    """A run of bits of a state: ``width`` bits from ``shift`` of word ``word``. Width 0: always 0."""

    word: int
    shift: int
    width: int

    @property
    def mask(self) -> int:
        """The field's bits in place."""
        return ((1 << self.width) - 1) << self.shift


@dataclass(frozen=True, slots=True)
class Layout:
    """The fields of a state.

    Attributes:
        words: words of a state, at least one.
        format: the field of the format number.
        slots: the field of each slot's local state.
    """

    words: int
    format: BitField
    slots: tuple[BitField, ...]

    def free_bits(self) -> tuple[int, int]:
        """How many bits of the last word no field uses, and from which bit on."""
        used = [f.shift + f.width for f in (self.format, *self.slots) if f.width and f.word == self.words - 1]
        top = max(used, default=0)
        return WORD_BITS - top, top


def lay_out(network: Network) -> Layout:
    """The fields of the states of a network."""
    widths = [(network.formats - 1).bit_length()]
    return layout_of([*widths, *[(slot.lts.states - 1).bit_length() for slot in network.slots]])


def layout_of(widths: Sequence[int]) -> Layout:
    """Fields of these widths, that of the format first, in as few words as possible.

    Those of neighbouring slots are next to each other where that costs no word.
    """
    in_order = _first_fit(widths, range(len(widths)))
    by_width = _first_fit(widths, sorted(range(len(widths)), key=lambda i: -widths[i]))
    fields, words = min(in_order, by_width, key=lambda placed: placed[1])
    return Layout(words, fields[0], tuple(fields[1:]))


def _first_fit(widths: Sequence[int], order: Sequence[int]) -> tuple[list[BitField], int]:
    """Each field in the first word that has room for it, in the given order; and the number of words."""
    used: list[int] = [0]
    placed: dict[int, BitField] = {}
    for i in order:
        word = next((w for w, bits in enumerate(used) if bits + widths[i] <= WORD_BITS), len(used))
        if word == len(used):
            used.append(0)
        placed[i] = BitField(word, used[word] if widths[i] else 0, widths[i])
        used[word] += widths[i]
    return [placed[i] for i in range(len(widths))], len(used)


def packed_state(layout: Layout, format: int, local_states: Sequence[int]) -> Int64Array:
    """A state in the given layout, shape (words,)."""
    words = [0] * layout.words
    words[layout.format.word] |= format << layout.format.shift
    for field, local in zip(layout.slots, local_states, strict=True):
        words[field.word] |= local << field.shift
    return np.array(words, dtype=np.int64)
