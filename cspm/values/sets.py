"""Sets as values: those that are listed, those of events, and the symbolic ones that may be infinite.

All are immutable. A finite set has one canonical form (:meth:`Set.canonical`), in which equal sets are equal Python
objects: sets of events are ranges of identifiers, everything else a ``frozenset``. Elements are evaluated through
and through. What ranges over a set does so in the order of ``cspcheck.cspm.values.order``.
"""

# ruff: noqa: D102 -- what overrides a method of Set means what is said there

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import islice, product
from typing import Any, ClassVar, Final

from cspcheck.cspm.process.events import UNBOUNDED, EventSet, FieldDomain, RangeDomain
from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.dots import Channels, DotList, Event, Head, parts
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.order import in_order
from cspcheck.cspm.values.thunks import force
from cspcheck.cspm.values.values import deep

LARGEST: Final = 1 << 22
"""A set is written out only if it has at most so many elements."""
_SHOWN: Final = 3
CANONICAL: Final = 1 << 16
"""A symbolic set up to this size takes its listed form when it is compared or hashed as part of other values."""


class Set:
    """Any set. Subclasses say what is in them; the rest follows.

    Attributes:
        most: it is listed only if it has at most so many elements.
    """

    __slots__ = ()

    most: ClassVar[int] = LARGEST

    def contains(self, value: Any) -> bool:
        """Whether *value* is an element.

        Raises:
            Failure: that cannot be decided.
        """
        raise NotImplementedError

    def is_finite(self) -> bool:
        """Whether the set has finitely many elements."""
        raise NotImplementedError

    def size(self) -> int:
        """The number of elements of a finite set, counted without listing them where possible."""
        raise NotImplementedError

    def listed(self) -> Iterable[Any]:
        """The elements of a finite set in some order."""
        raise NotImplementedError

    def describe(self) -> str:
        """The set as the language writes it."""
        raise NotImplementedError

    def exceeds(self, limit: int) -> bool:
        """Whether a finite set has more than *limit* elements; quick also where the number is astronomical."""
        return self.size() > limit

    def is_empty(self) -> bool:
        """Whether there are no elements."""
        return self.is_finite() and self.size() == 0

    def finite(self) -> FiniteSet | EventsSet:
        """The same set, listed.

        Raises:
            Failure: it is infinite, or too large to be listed.
        """
        if not self.is_finite():
            raise Failure(messages.infinite_set(self))
        self._check_size()
        return set_of(self.listed())

    def _check_size(self) -> None:
        """Refuse to list what is too large."""
        if self.exceeds(self.most):
            raise Failure(messages.too_large(self, self.most), is_limit=True)

    def elements(self) -> list[Any]:
        """The elements in order, in a list that must not be changed.

        Raises:
            Failure: there are infinitely many.
        """
        return self.finite().elements()

    def canonical(self) -> Set:
        """The form in which equal finite sets are equal objects (larger symbolic sets stay as they are)."""
        return self.finite() if self.is_finite() and not self.exceeds(CANONICAL) else self

    def may_contain_head(self, head: Head) -> bool:
        """Whether some element starts with the channel or constructor *head*; when in doubt, True."""
        return True

    def field_domain(self) -> FieldDomain | None:
        """The set as the domain of a channel's field; None if it is infinite, or as good as that."""
        return FieldDomain(self.elements()) if self.is_finite() and not self.exceeds(self.most) else None

    def is_same(self, other: Any) -> bool:
        """``==`` of the language.

        Raises:
            Failure: two infinite sets that cannot be compared.
        """
        from cspcheck.cspm.values.set_algebra import same

        return isinstance(other, Set) and same(self, other)

    def is_subset(self, other: Set) -> bool:
        """``<=`` of the language.

        Raises:
            Failure: two infinite sets that cannot be compared.
        """
        from cspcheck.cspm.values.set_algebra import subset

        return subset(self, other)

    def __repr__(self) -> str:
        return self.describe()


class FiniteSet(Set):
    """A listed set, of events only if there are other values beside them."""

    __slots__ = ("_ordered", "items")

    def __init__(self, items: frozenset[Any]) -> None:
        self.items = items
        self._ordered: list[Any] | None = None

    def contains(self, value: Any) -> bool:
        return deep(value) in self.items

    def is_finite(self) -> bool:
        return True

    def size(self) -> int:
        return len(self.items)

    def is_empty(self) -> bool:
        return not self.items

    def listed(self) -> Iterable[Any]:
        return self.items

    def finite(self) -> FiniteSet:
        return self

    def canonical(self) -> FiniteSet:
        return self

    def elements(self) -> list[Any]:
        if self._ordered is None:
            self._ordered = in_order(self.items)
        return self._ordered

    def may_contain_head(self, head: Head) -> bool:
        return any(getattr(item, "head", head) is head for item in self.items)

    def describe(self) -> str:
        from cspcheck.cspm.values.text import show

        return show(self)

    def __eq__(self, other: object) -> bool:
        return self is other or (isinstance(other, FiniteSet) and self.items == other.items)

    def __hash__(self) -> int:
        return hash(self.items)


class EventsSet(Set):
    """A non-empty set of events as ranges of their numbers: its size does not matter."""

    __slots__ = ("channels", "events")

    def __init__(self, events: EventSet, channels: Channels) -> None:
        self.events = events
        self.channels = channels

    @classmethod
    def of(cls, events: EventSet, channels: Channels) -> Set:
        """The set of *events*, which may be empty."""
        return cls(events, channels) if events else EMPTY_SET

    @classmethod
    def of_ranges(cls, ranges: Iterable[tuple[int, int]], channels: Channels) -> Set:
        """The set of the events in half-open *ranges* of numbers."""
        return cls.of(EventSet(ranges), channels)

    @classmethod
    def of_numbers(cls, numbers: Iterable[int], channels: Channels) -> Set:
        """The set of the events of these *numbers*."""
        return cls.of(EventSet.of(numbers), channels)

    def contains(self, value: Any) -> bool:
        return type(value) is Event and value.number in self.events

    def is_finite(self) -> bool:
        return True

    def size(self) -> int:
        return len(self.events)

    def is_empty(self) -> bool:
        return False

    def listed(self) -> Iterable[Any]:
        return map(self.channels.event, self.events)

    def finite(self) -> EventsSet:
        return self

    def canonical(self) -> EventsSet:
        return self

    def elements(self) -> list[Any]:
        self._check_size()
        return list(self.listed())

    def describe(self) -> str:
        from cspcheck.cspm.values.text import show

        return show(self)

    def __eq__(self, other: object) -> bool:
        return self is other or (isinstance(other, EventsSet) and self.events == other.events)

    def __hash__(self) -> int:
        return hash(self.events)


EMPTY_SET: Final = FiniteSet(frozenset())


def set_of(items: Iterable[Any]) -> FiniteSet | EventsSet:
    """The set of *items*, which must be evaluated through and through, in canonical form."""
    kept = items if isinstance(items, frozenset) else frozenset(items)
    if not kept:
        return EMPTY_SET
    for item in kept:
        if type(item) is not Event:
            return FiniteSet(kept)
    return EventsSet(EventSet.of(event.number for event in kept), item.channels)


class Range(Set):
    """``{low..high}``, not written out."""

    __slots__ = ("_listed", "numbers")

    def __init__(self, low: int, high: int) -> None:
        self.numbers = range(low, high + 1)
        self._listed: FiniteSet | None = None

    def contains(self, value: Any) -> bool:
        return type(value) is int and value in self.numbers

    def is_finite(self) -> bool:
        return True

    def size(self) -> int:
        return max(0, self.numbers.stop - self.numbers.start)

    def listed(self) -> Iterable[Any]:
        return self.numbers

    def finite(self) -> FiniteSet:
        if self._listed is None:
            self._check_size()
            self._listed = FiniteSet(frozenset(self.numbers)) if self.numbers else EMPTY_SET
        return self._listed

    def canonical(self) -> Set:
        # No listed set is equal to one that cannot be listed.
        return self if self.exceeds(LARGEST) else self.finite()

    def elements(self) -> list[Any]:
        self._check_size()
        return list(self.numbers)

    def field_domain(self) -> FieldDomain | None:
        return None if self.exceeds(UNBOUNDED) else RangeDomain(self.numbers)

    def describe(self) -> str:
        low, high = self.numbers.start, self.numbers.stop - 1
        return f"{{{' ' * (low < 0)}{low}..{high}}}" if self.numbers else "{}"

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Range):
            return self.numbers == other.numbers
        if not isinstance(other, FiniteSet) or self.exceeds(LARGEST):
            return False
        return self.size() == other.size() and self.finite() == other

    def __hash__(self) -> int:
        return hash(self.numbers) if self.exceeds(LARGEST) else hash(self.finite())


def event_set(value: Any) -> EventSet:
    """The events of a set value.

    Raises:
        Failure: it is not a set of complete events, or is infinite.
    """
    if type(value) is EventsSet:
        return value.events
    if not isinstance(value, Set):
        raise Failure(messages.not_a_set_of_events(value))
    finite = value.finite()
    if type(finite) is EventsSet:
        return finite.events
    for item in finite.elements():
        if type(item) is not Event:
            raise Failure(messages.not_an_event_in_set(item))
    return EventSet.of(item.number for item in finite.elements())


def field_sets(value: Any, name: str) -> tuple[Set, ...]:
    """The sets of the single fields that a type stands for: ``S``, ``S.T``, ``(S, T)``, a set of dotted values.

    Raises:
        Failure: *value* is no type, or a set of dotted values that is not a product of its fields.
    """
    from cspcheck.cspm.values.symbolic_sets import Product

    found: list[Set] = []
    for part in parts(value):
        if type(part) is tuple:
            found.append(Product("tuple", tuple([type_set(force(item), name) for item in part])))
        elif isinstance(part, Product) and part.kind == "dot":
            for field in part.sets:
                found.extend(field_sets(field, name))
        elif isinstance(part, Set):
            found.extend(_split(part, name))
        else:
            raise Failure(messages.not_a_type(part, name))
    return tuple(found)


def type_set(value: Any, name: str) -> Set:
    """The one set that a type stands for.

    Raises:
        Failure: *value* is no type.
    """
    from cspcheck.cspm.values.symbolic_sets import Product

    sets = field_sets(value, name)
    return sets[0] if len(sets) == 1 else Product("dot", sets)


def _split(part: Set, name: str) -> Sequence[Set]:
    """A set of dotted values is several fields, and must then hold every combination of their values."""
    if not isinstance(part, FiniteSet) or not part.items:
        return (part,)
    sample = next(iter(part.items))
    if type(sample) is not DotList:
        return (part,)
    width = len(sample.parts)
    columns: list[set[Any]] = [set() for _ in range(width)]
    for item in part.items:
        if type(item) is not DotList or len(item.parts) != width:
            raise Failure(messages.not_rectangular(name, part, []))
        for column, value in zip(columns, item.parts, strict=True):
            column.add(value)
    sets = [set_of(column) for column in columns]
    combinations = 1
    for column_set in sets:
        combinations *= column_set.size()
    if combinations != len(part.items):
        combined = map(DotList, product(*[column_set.elements() for column_set in sets]))
        absent = islice((combination for combination in combined if combination not in part.items), _SHOWN + 1)
        raise Failure(messages.not_rectangular(name, part, list(absent)))
    return sets
