"""Sets of rows as sorted runs: what a search does with states that are too many for memory.

Rows are ordered by their words, the first counting most. See ``cspcheck.checker.kernels.table`` for what is common to
all kernels.
"""

from __future__ import annotations

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.kernels.table import copy_row


def comes_before(rows: Int64Array, row: int, others: Int64Array, other: int, stride: int) -> bool:
    """Whether a row is less than another."""
    for w in range(stride):
        here = rows[row * stride + w]
        there = others[other * stride + w]
        if here != there:
            less: bool = here < there
            return less
    return False


def first_not_before(rows: Int64Array, begin: int, end: int, others: Int64Array, other: int, stride: int) -> int:
    """The first of the ascending rows *begin* to *end* that is not less than a row; *end* if all are.

    Found by steps that double, and halving the last of them (Bentley and Yao, Information Processing Letters 5, 1976),
    so that it costs little if it is near and not much if it is far.
    """
    step = 1
    low = begin
    while low + step - 1 < end and comes_before(rows, low + step - 1, others, other, stride):
        low += step
        step *= 2
    high = low + step - 1
    if high > end:
        high = end
    while low < high:
        middle = (low + high) >> 1
        if comes_before(rows, middle, others, other, stride):
            low = middle + 1
        else:
            high = middle
    return low


def rows_before(rows: Int64Array, begin: int, end: int, others: Int64Array, other: int, stride: int) -> int:
    """How many of the ascending rows *begin* to *end* are less than a row."""
    return first_not_before(rows, begin, end, others, other, stride) - begin


def unite(
    rows: Int64Array,
    begin: int,
    end: int,
    others: Int64Array,
    place: int,
    stop: int,
    stride: int,
    union: Int64Array,
) -> int:
    """Write the union of two ascending sets of rows to *union*, ascending; how many rows that are."""
    count = 0
    while begin < end and place < stop:
        if comes_before(rows, begin, others, place, stride):
            copy_row(rows, begin, union, count, stride)
            begin += 1
        elif comes_before(others, place, rows, begin, stride):
            copy_row(others, place, union, count, stride)
            place += 1
        else:
            copy_row(rows, begin, union, count, stride)
            begin += 1
            place += 1
        count += 1
    while begin < end:
        copy_row(rows, begin, union, count, stride)
        begin += 1
        count += 1
    while place < stop:
        copy_row(others, place, union, count, stride)
        place += 1
        count += 1
    return count


def sift(
    rows: Int64Array,
    begin: int,
    end: int,
    kept: int,
    others: Int64Array,
    place: int,
    stop: int,
    stride: int,
    wanted: int,
) -> tuple[int, int, int]:
    """Keep those of the ascending rows *begin* to *end* that are among others, or those that are not.

    Args:
        kept: where in *rows* those that are kept are closed up; at most *begin*.
        others: ascending rows, of which those from *place* to *stop* are looked at.
        wanted: 1 to keep what is among the others, 0 to keep what is not.

    Returns:
        The first row that was not decided on, for it is greater than all others; where the next one that is kept goes;
        and the first of the others that is not less than that row (*stop* if rows are left).
    """
    while begin < end and place < stop:
        place = first_not_before(others, place, stop, rows, begin, stride)
        if place == stop:
            break
        found = 0 if comes_before(rows, begin, others, place, stride) else 1
        if found == wanted:
            copy_row(rows, begin, rows, kept, stride)
            kept += 1
        begin += 1
    return begin, kept, place


KERNELS = (comes_before, first_not_before, rows_before, unite, sift)
