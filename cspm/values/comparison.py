"""``==`` and ``<`` of the language on values."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.thunks import Thunk
from cspcheck.cspm.values.values import ATOMS, Map, Sequence

PATIENCE = 1 << 18
"""After so many equal elements two sequences are evaluated to their ends, which infinite ones refuse."""


def equal(left: Any, right: Any) -> bool:
    """``==``: structural, sets by their elements. Both sides must be evaluated (not thunks).

    Raises:
        Failure: an item cannot be evaluated, or the two cannot be compared (functions, processes, infinite sets).
    """
    kind = type(left)
    if kind in ATOMS:
        return kind is type(right) and bool(left == right)
    if kind is tuple:
        if type(right) is not tuple or len(left) != len(right):
            return False
        for i, item in enumerate(left):
            a = item.force() if type(item) is Thunk else item
            b = right[i]
            if not equal(a, b.force() if type(b) is Thunk else b):
                return False
        return True
    if kind is Sequence:
        return type(right) is Sequence and equal_sequences(left, right)
    if kind is Map:
        return type(right) is Map and _equal_maps(left, right)
    comparison: Callable[[Any], bool] | None = getattr(left, "is_same", None)
    if comparison is None:
        raise Failure(messages.not_comparable(left))
    return comparison(right)


def equal_sequences(left: Sequence, right: Sequence) -> bool:
    """``==`` on sequences: stops at the first difference, so one of the two may be infinite."""
    a: Any = left
    b: Any = right
    compared = 0
    while True:
        if a is b and a._endless:
            return True
        if a._rest is None and b._rest is None:
            if a._end != b._end:
                return False
            return all(equal(_get(a, i), _get(b, i)) for i in range(a._end - 1, -1, -1))
        compared += 1
        if compared == PATIENCE:
            a, b = a.forced(), b.forced()
            continue
        first, second = a.uncons(), b.uncons()
        if first is None or second is None:
            return first is second
        x, a = first
        y, b = second
        if not equal(x.force() if type(x) is Thunk else x, y.force() if type(y) is Thunk else y):
            return False
        a = a.force() if type(a) is Thunk else a
        b = b.force() if type(b) is Thunk else b


def _get(sequence: Sequence, i: int) -> Any:
    item = sequence._items[i]
    if type(item) is Thunk:
        item = sequence._items[i] = item.force()
    return item


def _equal_maps(left: Map, right: Map) -> bool:
    if left.entries.keys() != right.entries.keys():
        return False
    return all(equal(_value(left, key), _value(right, key)) for key in left.entries)


def _value(mapping: Map, key: Any) -> Any:
    value = mapping.entries[key]
    if type(value) is Thunk:
        value = mapping.entries[key] = value.force()
    return value


def less(left: Any, right: Any, *, strict: bool) -> bool:
    """``<`` (*strict*) or ``<=``.

    Numbers and characters by size, tuples lexicographically, sequences by prefix, sets by inclusion, maps by
    inclusion of their entries' keys with smaller values. Values that are not related give False both ways.

    Raises:
        Failure: values of this kind have no order, or the comparison has no end.
    """
    kind = type(left)
    if kind is not type(right) and not (hasattr(left, "is_subset") and hasattr(right, "is_subset")):
        raise Failure(messages.not_ordered(left, right))
    if kind is int or kind is str:
        return bool(left < right if strict else left <= right)
    if kind is tuple:
        for i, item in enumerate(left):
            a = item.force() if type(item) is Thunk else item
            b = right[i].force() if type(right[i]) is Thunk else right[i]
            if not equal(a, b):
                return less(a, b, strict=True)
        return not strict
    if kind is Sequence:
        return _is_prefix(left, right) and not (strict and equal_sequences(left, right))
    if kind is Map:
        inside = all(
            key in right.entries and less(_value(left, key), _value(right, key), strict=False) for key in left.entries
        )
        return inside and not (strict and _equal_maps(left, right))
    if hasattr(left, "is_subset"):
        return bool(left.is_subset(right)) and not (strict and left.is_same(right))
    raise Failure(messages.not_ordered(left, right))


def _is_prefix(left: Sequence, right: Sequence) -> bool:
    a: Any = left
    b: Any = right
    compared = 0
    while True:
        compared += 1
        if compared == PATIENCE:
            a.forced()
        first = a.uncons()
        if first is None:
            return True
        second = b.uncons()
        if second is None:
            return False
        x, a = first
        y, b = second
        if not equal(x.force() if type(x) is Thunk else x, y.force() if type(y) is Thunk else y):
            return False
        a = a.force() if type(a) is Thunk else a
        b = b.force() if type(b) is Thunk else b
