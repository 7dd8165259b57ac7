"""``union``, ``inter``, ``diff``, ``==`` and ``<=`` on sets, the infinite ones by cases.

What is true of the elements decides; where two infinite sets are of forms that say nothing of each other the
question is refused, never guessed.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import inf
from typing import Any

from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.dots import Event
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.sets import CANONICAL, EMPTY_SET, LARGEST, EventsSet, FiniteSet, Range, Set, set_of
from cspcheck.cspm.values.symbolic_sets import DatatypeSet, Integers, Maps, Product, Sequences, Subsets, Union

_LISTED = (FiniteSet, EventsSet, Range)


def same(left: Set, right: Set) -> bool:
    """``left == right``.

    Raises:
        Failure: both are infinite and of forms that cannot be compared.
    """
    if left is right:
        return True
    if type(left) is FiniteSet and type(right) is FiniteSet:
        return left.items == right.items
    if left.is_finite() != right.is_finite():
        return False
    if left.is_finite():
        if type(left) is Range and type(right) is Range:
            return left == right
        if left.exceeds(LARGEST) != right.exceeds(LARGEST):
            return False
        if type(left) is type(right) and left.exceeds(CANONICAL) and left == right:
            return True  # as they are written
        return left.size() == right.size() and left.finite() == right.finite()
    return left == right or (subset(left, right) and subset(right, left))


def subset(left: Set, right: Set) -> bool:
    """``left <= right``.

    Raises:
        Failure: *left* is infinite and the two are of forms that cannot be compared.
    """
    if left is right:
        return True
    if type(left) is EventsSet and type(right) is EventsSet:
        return left.events <= right.events
    if type(left) is FiniteSet and type(right) is FiniteSet:
        return left.items <= right.items
    if left.is_finite():
        if left.exceeds(CANONICAL):
            found = _large_subset(left, right)
            if found is not None:
                return found
        return all(right.contains(item) for item in left.finite().listed())
    if right.is_finite():
        return False
    found = _subset_by_form(left, right)
    if found is None:
        raise Failure(messages.undecidable("inclusion", left, right))
    return found


def _large_subset(left: Set, right: Set) -> bool | None:
    """Inclusion of a finite set that is better not listed; None if there is no other way."""
    if right.is_finite() and left.exceeds(LARGEST) and not right.exceeds(LARGEST):
        return False
    match left, right:
        case Range(), Range():
            return left.numbers.start >= right.numbers.start and left.numbers.stop <= right.numbers.stop
        case Range(), Integers():
            return right.low is None or right.low <= left.numbers.start
        case (Subsets(), Subsets()) | (Maps(), Maps()) | (Product(), Product()):
            return _subset_by_form(left, right)
    return None


def _subset_by_form(left: Set, right: Set) -> bool | None:
    """Inclusion of infinite sets; None if their forms do not tell."""
    if left == right:
        return True
    if isinstance(left, Union):
        return all(subset(part, right) for part in left.sets)
    if isinstance(right, Union):
        if any(part.is_finite() is False and _subset_by_form(left, part) for part in right.sets):
            return True
        return False if isinstance(left, Integers) else None  # what is listed leaves a gap below the rest
    match left, right:
        case Integers(), Integers():
            return right.low is None or (left.low is not None and left.low >= right.low)
        case Sequences(), Sequences():
            return subset(left.base, right.base)
        case Subsets(), Subsets():
            return subset(left.base, right.base)
        case Maps(), Maps():
            return subset(left.keys, right.keys) and subset(left.values, right.values)
        case Product(), Product() if left.kind == right.kind and len(left.sets) == len(right.sets):
            return all(subset(a, b) for a, b in zip(left.sets, right.sets, strict=True))
        case DatatypeSet(), DatatypeSet():
            if not left.is_subtype:
                return None if right.is_subtype or left.name == right.name else False
            if not right.is_subtype:
                return all(right.may_contain_head(head) for head, _ in left.branches)
            return None
    return False if type(left) is not type(right) else None


def union(left: Set, right: Set) -> Set:
    """``union(left, right)``."""
    if type(left) is EventsSet and type(right) is EventsSet:
        return EventsSet(left.events | right.events, left.channels)
    if type(left) is FiniteSet and type(right) is FiniteSet:
        return FiniteSet(left.items | right.items)
    if left.is_finite() and right.is_finite():
        a, b = left.finite(), right.finite()
        if type(a) is type(b):
            return union(a, b)
        return b if not a.size() else a if not b.size() else set_of(frozenset(a.listed()) | frozenset(b.listed()))
    if left.is_finite() and subset(left, right):
        return right
    if right.is_finite() and subset(right, left):
        return left
    parts = list(dict.fromkeys([*_union_parts(left), *_union_parts(right)]))
    upwards = min((part for part in parts if isinstance(part, Integers)), key=_low, default=None)
    if upwards is not None:
        return _integers(parts, upwards)
    return Union(tuple(parts)) if len(parts) > 1 else left


def _low(numbers: Integers) -> float:
    return -inf if numbers.low is None else numbers.low


def _integers(parts: list[Set], upwards: Integers) -> Set:
    """A set of integers without an upper bound in its one form: what is listed leaves a gap below the rest."""
    if upwards.low is None:
        return upwards
    low = upwards.low
    apart: list[Set] = []  # ranges that are better not listed
    listed: set[int] = set()
    for part in parts:
        if isinstance(part, Range) and part.exceeds(LARGEST):
            if part.numbers.stop < low:
                apart.append(part)
            else:
                low = min(low, part.numbers.start)
        elif part.is_finite():
            listed.update(part.finite().listed())
    while low - 1 in listed:
        low -= 1
    below = {n for n in listed if n < low}
    found = [*apart, *([set_of(below)] if below else []), Integers(low)]
    return Union(tuple(found)) if len(found) > 1 else found[0]


def _union_parts(s: Set) -> tuple[Set, ...]:
    return s.sets if isinstance(s, Union) else (s.canonical(),)


def intersection(left: Set, right: Set) -> Set:
    """``inter(left, right)``.

    Raises:
        Failure: both are infinite and of forms that cannot be compared.
    """
    if type(left) is EventsSet and type(right) is EventsSet:
        return EventsSet.of(left.events & right.events, left.channels)
    if type(left) is FiniteSet and type(right) is FiniteSet:
        return _plain(left.items & right.items)
    if left.is_finite():
        if right.is_finite() and left.exceeds(LARGEST) and not right.exceeds(LARGEST):
            return intersection(right, left)
        if type(left) is Range and type(right) is Range:
            both = range(max(left.numbers.start, right.numbers.start), min(left.numbers.stop, right.numbers.stop))
            return Range(both.start, both.stop - 1) if both else EMPTY_SET
        return set_of([item for item in left.finite().listed() if right.contains(item)])
    if right.is_finite():
        return intersection(right, left)
    if isinstance(left, Union):
        return _unite(intersection(part, right) for part in left.sets)
    if isinstance(right, Union):
        return _unite(intersection(left, part) for part in right.sets)
    match left, right:
        case Integers(), Integers():
            lows = [low for low in (left.low, right.low) if low is not None]
            return Integers(max(lows)) if lows else left
        case Sequences(), Sequences():
            return Sequences(intersection(left.base, right.base))
        case Subsets(), Subsets():
            return Subsets(intersection(left.base, right.base))
        case Maps(), Maps():
            return Maps(intersection(left.keys, right.keys), intersection(left.values, right.values))
        case Product(), Product() if left.kind == right.kind and len(left.sets) == len(right.sets):
            pairs = zip(left.sets, right.sets, strict=True)
            return Product(left.kind, tuple([intersection(a, b) for a, b in pairs]))
    if _subset_by_form(left, right):
        return left
    if _subset_by_form(right, left):
        return right
    if type(left) is not type(right):
        return EMPTY_SET
    raise Failure(messages.undecidable("the intersection", left, right))


def difference(left: Set, right: Set) -> Set:
    """``diff(left, right)``.

    Raises:
        Failure: what is left over is infinite and cannot be written.
    """
    if type(left) is EventsSet and type(right) is EventsSet:
        return EventsSet.of(left.events - right.events, left.channels)
    if type(left) is FiniteSet and type(right) is FiniteSet:
        return _plain(left.items - right.items)
    if type(left) is Range and type(right) is FiniteSet and not left.exceeds(CANONICAL):
        return _plain(left.finite().items - right.items)
    if left.is_finite():
        return set_of([item for item in left.finite().listed() if not right.contains(item)])
    if right.is_finite() and not any(left.contains(item) for item in right.finite().listed()):
        return left
    if isinstance(left, Union):
        return _unite(difference(part, right) for part in left.sets)
    if not right.is_finite():
        if _subset_by_form(left, right):
            return EMPTY_SET
        if isinstance(right, Union):
            for part in right.sets:
                left = difference(left, part)
            return left
        if type(left) is not type(right):
            return left
    if isinstance(left, Integers) and left.low is not None and isinstance(right, Integers):
        assert right.low is not None  # else all was taken away above, and so was it if nothing is left below
        return Range(left.low, right.low - 1)
    if isinstance(left, Integers) and left.low is not None and isinstance(right, Range | FiniteSet):
        taken = right.elements()
        numbers = [n for n in taken if type(n) is int]
        top = max(numbers)
        between = [n for n in range(left.low, top) if n not in set(numbers)]
        rest = Integers(top + 1)
        return union(set_of(between), rest) if between else rest
    raise Failure(messages.undecidable("the difference", left, right))


def _plain(kept: frozenset[Any]) -> Set:
    """The set of what is left of a listed one: only events may be left of a mixed one."""
    for item in kept:
        return set_of(kept) if type(item) is Event else FiniteSet(kept)
    return EMPTY_SET


def _unite(parts: Iterable[Set]) -> Set:
    result: Set = EMPTY_SET
    for part in parts:
        result = union(result, part)
    return result
