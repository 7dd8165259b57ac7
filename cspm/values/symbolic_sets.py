"""Sets that are not written out: ``Int``, ``Seq(S)``, products, datatypes, ... Many of them are infinite."""

# ruff: noqa: D102 -- what overrides a method of Set means what is said there

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import compress, product
from math import prod
from typing import Any, Final, Literal

from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.dots import Constructor, DotList, Dotted, Event, Head
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.sets import Set, set_of
from cspcheck.cspm.values.values import Map, Sequence, deep

COLLECTIONS: Final = 1 << 20
"""A set of sets or maps is listed only if it has at most so many."""
MOST_BITS: Final = 1 << 17
"""The size of a set is told if it has at most so many bits."""


def _product_exceeds(sets: tuple[Set, ...], limit: int) -> bool:
    """Whether finite sets have more than *limit* combinations."""
    if any(s.is_empty() for s in sets):
        return limit < 0
    total = 1
    for s in sets:
        if s.exceeds(limit):
            return True
        total *= s.size()
        if total > limit:
            return True
    return total > limit


def _product_size(sets: tuple[Set, ...]) -> int:
    """How many combinations of their elements finite sets have; one of them may be infinite if another is empty."""
    return 0 if any(s.is_empty() for s in sets) else prod(s.size() for s in sets)


def _as_listed(values: Set) -> list[Any]:
    """The elements of a set that lists them in FDR's order, each once.

    Raises:
        Failure: it is infinite, or too large to be listed.
    """
    if not values.is_finite():
        raise Failure(messages.infinite_set(values))
    values._check_size()
    return list(values.listed())


class _Infinite(Set):
    """A set of infinitely many values of one kind."""

    __slots__ = ()

    def is_finite(self) -> bool:
        return False


class Integers(_Infinite):
    """``Int``, or ``{low..}``."""

    __slots__ = ("low",)

    def __init__(self, low: int | None = None) -> None:
        self.low = low

    def contains(self, value: Any) -> bool:
        return type(value) is int and (self.low is None or value >= self.low)

    def describe(self) -> str:
        return "Int" if self.low is None else f"{{{' ' * (self.low < 0)}{self.low}..}}"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Integers) and self.low == other.low

    def __hash__(self) -> int:
        return hash((Integers, self.low))


class Characters(_Infinite):
    """``Char``."""

    __slots__ = ()

    def contains(self, value: Any) -> bool:
        return type(value) is str

    def describe(self) -> str:
        return "Char"


class Processes(_Infinite):
    """``Proc``."""

    __slots__ = ()

    def contains(self, value: Any) -> bool:
        return isinstance(value, Process)

    def describe(self) -> str:
        return "Proc"


INTEGERS: Final = Integers()
CHARACTERS: Final = Characters()
PROCESSES: Final = Processes()


class Sequences(Set):
    """``Seq(S)``: all finite sequences over a set."""

    __slots__ = ("base",)

    def __init__(self, base: Set) -> None:
        self.base = base

    def contains(self, value: Any) -> bool:
        return type(value) is Sequence and all(self.base.contains(deep(item)) for item in value.items())

    def is_finite(self) -> bool:
        return self.base.is_empty()

    def size(self) -> int:
        return 1

    def listed(self) -> Iterable[Any]:
        return (Sequence.of(()),)

    def describe(self) -> str:
        return f"Seq({self.base.describe()})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequences) and self.base.canonical() == other.base.canonical()

    def __hash__(self) -> int:
        return hash((Sequences, self.base.canonical()))


class Subsets(Set):
    """``Set(S)``: all subsets of a set."""

    __slots__ = ("base",)

    most = COLLECTIONS

    def __init__(self, base: Set) -> None:
        self.base = base

    def contains(self, value: Any) -> bool:
        return isinstance(value, Set) and value.is_subset(self.base)

    def is_finite(self) -> bool:
        return self.base.is_finite()

    def is_empty(self) -> bool:
        return False

    def exceeds(self, limit: int) -> bool:
        return self.base.exceeds(limit.bit_length() - 1)

    def size(self) -> int:
        if self.base.exceeds(MOST_BITS):
            raise Failure(messages.too_large(self, self.most), is_limit=True)
        return int(2 ** self.base.size())

    def listed(self) -> Iterator[Any]:
        """The subsets with the first element before those without it, as FDR lists them."""
        elements = self.base.elements()
        for chosen in product((True, False), repeat=len(elements)):
            yield set_of(compress(elements, chosen))

    def elements(self) -> list[Any]:
        return _as_listed(self)

    def describe(self) -> str:
        return f"Set({self.base.describe()})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Subsets) and self.base.canonical() == other.base.canonical()

    def __hash__(self) -> int:
        return hash((Subsets, self.base.canonical()))


class Maps(Set):
    """``Map(K, V)``: all maps from some elements of K to elements of V."""

    __slots__ = ("keys", "values")

    most = COLLECTIONS

    def __init__(self, keys: Set, values: Set) -> None:
        self.keys = keys
        self.values = values

    def contains(self, value: Any) -> bool:
        return type(value) is Map and all(
            self.keys.contains(key) and self.values.contains(deep(kept)) for key, kept in value.entries.items()
        )

    def is_finite(self) -> bool:
        if self.keys.is_empty() or self.values.is_empty():
            return True
        return self.keys.is_finite() and self.values.is_finite()

    def is_empty(self) -> bool:
        return False

    def exceeds(self, limit: int) -> bool:
        if self.keys.is_empty() or self.values.is_empty():
            return limit < 1
        if self.keys.exceeds(limit.bit_length() - 1) or self.values.exceeds(limit):
            return True
        return self.size() > limit

    def size(self) -> int:
        if self.keys.is_empty() or self.values.is_empty():
            return 1
        if self.keys.exceeds(MOST_BITS) or self.keys.size() * self.values.size().bit_length() > MOST_BITS:
            raise Failure(messages.too_large(self, self.most), is_limit=True)
        return int((self.values.size() + 1) ** self.keys.size())

    def listed(self) -> Iterator[Any]:
        if self.keys.is_empty() or self.values.is_empty():
            yield Map({})
            return
        values = self.values.elements()
        for domain in Subsets(self.keys).listed():
            keys = domain.elements()
            for chosen in product(values, repeat=len(keys)):
                yield Map(dict(zip(reversed(keys), chosen, strict=True)))

    def elements(self) -> list[Any]:
        return _as_listed(self)

    def describe(self) -> str:
        return f"Map({self.keys.describe()}, {self.values.describe()})"

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Maps)
            and self.keys.canonical() == other.keys.canonical()
            and self.values.canonical() == other.values.canonical()
        )

    def __hash__(self) -> int:
        return hash((Maps, self.keys.canonical(), self.values.canonical()))


class Product(Set):
    """The tuples, or the values side by side (``dot``), with one part from each of two or more sets."""

    __slots__ = ("kind", "sets")

    def __init__(self, kind: Literal["tuple", "dot"], sets: tuple[Set, ...]) -> None:
        self.kind = kind
        self.sets = sets

    def _parts(self, value: Any) -> tuple[Any, ...] | None:
        if self.kind == "tuple":
            return value if type(value) is tuple else None
        return value.parts if type(value) is DotList else None

    def contains(self, value: Any) -> bool:
        found = self._parts(value)
        return (
            found is not None
            and len(found) == len(self.sets)
            and all(s.contains(deep(part)) for s, part in zip(self.sets, found, strict=True))
        )

    def is_finite(self) -> bool:
        return any(s.is_empty() for s in self.sets) or all(s.is_finite() for s in self.sets)

    def is_empty(self) -> bool:
        return any(s.is_empty() for s in self.sets)

    def exceeds(self, limit: int) -> bool:
        return _product_exceeds(self.sets, limit)

    def size(self) -> int:
        return _product_size(self.sets)

    def listed(self) -> Iterable[Any]:
        if any(s.is_empty() for s in self.sets):
            return ()
        found = product(*[s.elements() for s in self.sets])
        return found if self.kind == "tuple" else map(DotList, found)

    def elements(self) -> list[Any]:
        return _as_listed(self)

    def describe(self) -> str:
        inner = [s.describe() for s in self.sets]
        return f"({', '.join(inner)})" if self.kind == "tuple" else ".".join(inner)

    def _key(self) -> tuple[Any, ...]:
        return (self.kind, *[s.canonical() for s in self.sets])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Product) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())


class Union(Set):
    """A union of sets of which at least one is infinite."""

    __slots__ = ("sets",)

    def __init__(self, sets: tuple[Set, ...]) -> None:
        self.sets = sets

    def contains(self, value: Any) -> bool:
        return any(s.contains(value) for s in self.sets)

    def is_finite(self) -> bool:
        return all(s.is_finite() for s in self.sets)

    def is_empty(self) -> bool:
        return all(s.is_empty() for s in self.sets)

    def exceeds(self, limit: int) -> bool:
        return any(s.exceeds(limit) for s in self.sets) or self.size() > limit

    def size(self) -> int:
        return len(set(self.listed()))

    def listed(self) -> Iterator[Any]:
        for s in self.sets:
            yield from s.listed()

    def may_contain_head(self, head: Head) -> bool:
        return any(s.may_contain_head(head) for s in self.sets)

    def describe(self) -> str:
        text = self.sets[0].describe()
        for s in self.sets[1:]:
            text = f"union({text}, {s.describe()})"
        return text

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Union) and set(self.sets) == set(other.sets)

    def __hash__(self) -> int:
        return hash(frozenset(self.sets))


class DatatypeSet(Set):
    """The values of a datatype, or of a subtype of one.

    ``evaluate`` gives the constructors, each with the sets of its fields; it is asked when first needed, so a
    datatype's fields may mention the datatype.
    """

    __slots__ = ("_branches", "_evaluate", "_finite", "_heads", "heads", "is_subtype", "name")

    def __init__(
        self,
        name: str,
        heads: Callable[[], tuple[Constructor, ...]],
        evaluate: Callable[[], tuple[tuple[Constructor, tuple[Set, ...]], ...]],
        *,
        is_subtype: bool,
    ) -> None:
        self.name = name
        self.is_subtype = is_subtype
        self._heads = heads
        self.heads: frozenset[Head] | None = None
        self._evaluate = evaluate
        self._branches: tuple[tuple[Constructor, tuple[Set, ...]], ...] | None = None
        self._finite: bool | None = None

    @property
    def branches(self) -> tuple[tuple[Constructor, tuple[Set, ...]], ...]:
        """The constructors with the sets of their fields."""
        if self._branches is None:
            self._branches = self._evaluate()
        return self._branches

    def may_contain_head(self, head: Head) -> bool:
        if self.heads is None:
            self.heads = frozenset(self._heads())
        return head in self.heads

    def contains(self, value: Any) -> bool:
        if type(value) is not Dotted or not value.complete or not self.may_contain_head(value.head):
            return False
        if not self.is_subtype:
            return True
        sets = next(sets for head, sets in self.branches if head is value.head)
        return all(s.contains(field) for s, field in zip(sets, value.fields, strict=True))

    def is_finite(self) -> bool:
        if self._finite is None:
            self._finite = False  # what contains itself, if anything at all, has no end
            empty = [any(s.is_empty() for s in sets) for _, sets in self.branches]
            self._finite = all(
                nothing or all(s.is_finite() for s in sets)
                for nothing, (_, sets) in zip(empty, self.branches, strict=True)
            )
        return self._finite

    def is_empty(self) -> bool:
        return self.is_finite() and all(any(s.is_empty() for s in sets) for _, sets in self.branches)

    def exceeds(self, limit: int) -> bool:
        return any(_product_exceeds(sets, limit) for _, sets in self.branches) or self.size() > limit

    def size(self) -> int:
        return sum(_product_size(sets) for _, sets in self.branches)

    def listed(self) -> Iterator[Any]:
        for head, sets in self.branches:
            if any(s.is_empty() for s in sets):
                continue
            for fields in product(*[s.elements() for s in sets]):
                yield head.complete(fields)

    def elements(self) -> list[Any]:
        return _as_listed(self)

    def describe(self) -> str:
        return self.name


class AllEvents(Set):
    """``Events`` where some channel has an infinite field: membership only."""

    __slots__ = ()

    def contains(self, value: Any) -> bool:
        return type(value) is Event

    def is_finite(self) -> bool:
        return False

    def describe(self) -> str:
        return "Events"
