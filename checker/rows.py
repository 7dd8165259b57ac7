"""Compressed sparse rows: the few operations on them that normalisation and its like are made of.

Row ``r`` of ``(offsets, values)`` is ``values[offsets[r]:offsets[r + 1]]``.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from checker.lts import Int64Array

Uint64Array = npt.NDArray[np.uint64]


def gather_rows(offsets: Int64Array, rows: Int64Array) -> Int64Array:
    """The indices of all entries of the given rows of compressed sparse rows, row after row."""
    lengths = offsets[rows + 1] - offsets[rows]
    ends = np.cumsum(lengths)
    total = int(ends[-1]) if len(ends) else 0
    indices: Int64Array = np.arange(total) - np.repeat(ends - lengths - offsets[rows], lengths)
    return indices


def intern_rows(offsets: Int64Array, values: Int64Array) -> tuple[Int64Array, Int64Array]:
    """Number the distinct rows of compressed sparse rows.

    Rows are grouped by a random linear hash of their entries and positions; every row is then compared with the
    first of its group, so that the answer does not rest on the hash.

    Returns:
        ``(numbers, first)``: the number of each row, numbers given in the order of first occurrence; and for each
        number the first row that has it.
    """
    rows = len(offsets) - 1
    if rows == 0:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    lengths = np.diff(offsets)
    within = np.arange(len(values)) - np.repeat(offsets[:-1], lengths)
    for seed in range(8):
        hashes = _row_hashes(lengths, within, values, seed)
        _, first, numbers = np.unique(hashes, return_index=True, return_inverse=True)
        order = np.argsort(first, kind="stable")
        rank = np.empty_like(order)
        rank[order] = np.arange(len(order))
        numbers, first = rank[numbers], first[order]
        leader = first[numbers]
        if not np.array_equal(lengths[leader], lengths):
            continue
        counterpart = np.repeat(offsets[leader], lengths) + within
        if np.array_equal(values[counterpart], values):
            return numbers.astype(np.int64), first.astype(np.int64)
    raise AssertionError("eight independent hashes all collided")


def _row_hashes(lengths: Int64Array, within: Int64Array, values: Int64Array, seed: int) -> Uint64Array:
    """A 64-bit hash of each row."""
    salt = np.uint64((seed * 2 + 1) * 0x9E3779B97F4A7C15 & 0xFFFFFFFFFFFFFFFF)
    with np.errstate(over="ignore"):
        mixed = _mix(values.astype(np.uint64) + _mix(within.astype(np.uint64) * salt + salt))
        ends = np.cumsum(lengths)
        running = np.concatenate([np.zeros(1, dtype=np.uint64), np.cumsum(mixed, dtype=np.uint64)])
        return _mix(running[ends] - running[ends - lengths] + lengths.astype(np.uint64) * salt)


def _mix(words: Uint64Array) -> Uint64Array:
    """Steele, Lea and Flood's finaliser of SplitMix64: each input bit reaches each output bit."""
    words = (words ^ (words >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    words = (words ^ (words >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return words ^ (words >> np.uint64(31))
