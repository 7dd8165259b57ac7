"""Compressed sparse rows: the few operations on them that normalisation and its like are made of.

Row ``r`` of ``(offsets, values)`` is ``values[offsets[r]:offsets[r + 1]]``.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cspcheck.checker.arrays import Int64Array

Uint64Array = npt.NDArray[np.uint64]

_WORD = (1 << 64) - 1


def gather_rows(offsets: Int64Array, rows: Int64Array) -> Int64Array:
    """The indices of all entries of the given rows of compressed sparse rows, row after row."""
    return gather_spans(offsets[rows], offsets[rows + 1])


def gather_spans(starts: Int64Array, ends: Int64Array) -> Int64Array:
    """The indices in all the half-open spans from *starts* to *ends*, span after span."""
    lengths = ends - starts
    before = np.cumsum(lengths) - lengths
    total = int(lengths.sum())
    indices: Int64Array = np.arange(total) + np.repeat(starts - before, lengths)
    return indices


def intern_rows(offsets: Int64Array, values: Int64Array) -> tuple[Int64Array, Int64Array]:
    """Number the distinct rows of compressed sparse rows whose rows are strictly ascending.

    Rows are grouped by a hash of the set of their entries; every row is then compared with the first of its group,
    so that the answer does not rest on the hash.

    Returns:
        ``(numbers, first)``: the number of each row, numbers given in the order of first occurrence; and for each
        number the first row that has it.
    """
    if len(offsets) == 1:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    lengths = np.diff(offsets)
    for seed in range(8):
        _, first, numbers = np.unique(_row_hashes(offsets, values, seed), return_index=True, return_inverse=True)
        order = np.argsort(first, kind="stable")
        rank = np.empty_like(order)
        rank[order] = np.arange(len(order))
        numbers, first = rank[numbers], first[order]
        leader = first[numbers]
        if not np.array_equal(lengths[leader], lengths):
            continue
        counterpart = np.arange(len(values)) + np.repeat(offsets[leader] - offsets[:-1], lengths)
        if np.array_equal(values[counterpart], values):
            return numbers.astype(np.int64), first.astype(np.int64)
    raise AssertionError("eight independent hashes all collided")


def _row_hashes(offsets: Int64Array, values: Int64Array, seed: int) -> Uint64Array:
    """A 64-bit hash of each row: the sum of its entries' own hashes."""
    with np.errstate(over="ignore"):
        mixed = _mix(
            values.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(seed * 0xD1342543DE82EF95 & _WORD)
        )
        running = np.zeros(len(values) + 1, dtype=np.uint64)
        np.cumsum(mixed, out=running[1:])
        hashes: Uint64Array = running[offsets[1:]] - running[offsets[:-1]]
    return hashes


def _mix(words: Uint64Array) -> Uint64Array:
    """Steele, Lea and Flood's finaliser of SplitMix64, in place: each input bit reaches each output bit."""
    words ^= words >> np.uint64(30)
    words *= np.uint64(0xBF58476D1CE4E5B9)
    words ^= words >> np.uint64(27)
    words *= np.uint64(0x94D049BB133111EB)
    words ^= words >> np.uint64(31)
    return words
