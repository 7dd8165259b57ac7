"""Typed data: the sets that variables and the fields of channels take their values from.

Values are plain Python: ``int``, ``float``, ``bool``, ``str``, members of an ``Enum``, :class:`Tagged` for
constructors with fields, ``tuple`` for tuples and sequences, ``frozenset`` for sets, and ``tuple`` of pairs sorted by
key for functions. Only a type says which of these a tuple is, so it is the type that prints a value the way a
specification writes it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from itertools import chain, combinations, product
from math import inf, isfinite
from typing import Any, ClassVar, NamedTuple

LARGEST = 10_000
"""So many values of a type are listed when somebody has to choose one."""


class OutOfRange(Exception):
    """A value that its variable or field cannot hold."""

    def __init__(self, owner: str, variable: str, value: object, expected: DataType) -> None:
        self.owner = owner
        self.variable = variable
        self.value = value
        self.expected = expected
        kind = "" if expected.admits(value) else f" ({type(value).__name__})"
        super().__init__(f"{owner}: {variable} = {value!r}{kind} is outside {expected.describe()}")


class Tagged(NamedTuple):
    """A constructor of a datatype applied to its fields."""

    name: str
    fields: tuple[Any, ...] = ()

    def __repr__(self) -> str:
        return ".".join([self.name, *map(repr, self.fields)])


class DataType:
    """A set of values. ``name`` is what messages call it; without one they show the set itself."""

    name: str | None = None

    def contains(self, value: object) -> bool:
        """Whether *value* belongs to the set."""
        raise NotImplementedError

    def admits(self, value: object) -> bool:
        """Whether *value* is of the right kind, whatever its size; tells a wrong number from no number."""
        return self.contains(value)

    def values(self) -> Iterator[Any] | None:
        """All values in their order, or None where they cannot be listed."""
        raise NotImplementedError

    def all(self) -> frozenset[Any]:
        """The set itself.

        Raises:
            TypeError: its values cannot be listed.
        """
        values = self.values()
        if values is None:
            raise TypeError(f"the values of {self.describe()} cannot be listed")
        return frozenset(values)

    def extent(self) -> str:
        """The set as a specification writes it."""
        raise NotImplementedError

    def text(self, value: Any) -> str:
        """*value* as a specification writes it."""
        return _text(value)

    @property
    def default(self) -> Any:
        """The value that a variable has before anything is known of it."""
        values = self.values()
        return None if values is None else next(values, None)

    def describe(self) -> str:
        """Name and extent, for messages."""
        return self.extent() if self.name is None else f"{self.name} = {self.extent()}"

    def check(self, value: object, owner: str, variable: str) -> None:
        """Make sure that *value* belongs to the set.

        Raises:
            OutOfRange: it does not; the message names owner, variable, value and set.
        """
        if not self.contains(value):
            raise OutOfRange(owner, variable, value, self)

    def __repr__(self) -> str:
        return f"<{self.describe()}>"


@dataclass(frozen=True, repr=False)
class Integers(DataType):
    """``{low..high}``; None stands for no bound."""

    low: int | None = None
    high: int | None = None
    name: str | None = None

    def contains(self, value: object) -> bool:
        """Whether *value* is an integer (not a truth value) within the bounds."""
        return (
            type(value) is int and (self.low is None or self.low <= value) and (self.high is None or value <= self.high)
        )

    def admits(self, value: object) -> bool:
        """Any integer."""
        return type(value) is int

    def values(self) -> Iterator[int] | None:
        """From the least to the greatest."""
        if self.low is None or self.high is None:
            return None
        return iter(range(self.low, self.high + 1))

    @property
    def default(self) -> int:
        """Zero, or the bound that is next to it."""
        least = 0 if self.low is None else max(0, self.low)
        return least if self.high is None else min(least, self.high)

    def extent(self) -> str:
        """``0..10``."""
        if self.low is None and self.high is None:
            return "the integers"
        return f"{'' if self.low is None else self.low}..{'' if self.high is None else self.high}"


@dataclass(frozen=True, repr=False)
class Reals(DataType):
    """Finite floating-point numbers within bounds; integers count as reals."""

    low: float = -inf
    high: float = inf
    name: str | None = None

    def contains(self, value: object) -> bool:
        """Whether *value* is a finite number within the bounds."""
        return self.admits(value) and self.low <= value <= self.high  # type: ignore[operator]

    def admits(self, value: object) -> bool:
        """Any finite number."""
        return isinstance(value, (int, float)) and not isinstance(value, bool) and isfinite(value)

    def values(self) -> None:
        """None: they cannot be listed."""
        return

    @property
    def default(self) -> float:
        """Zero, or the bound that is next to it."""
        return float(min(max(0.0, self.low), self.high))

    def extent(self) -> str:
        """``0.0..360.0``."""
        if self.low == -inf and self.high == inf:
            return "the reals"
        return f"{'' if self.low == -inf else self.low}..{'' if self.high == inf else self.high}"


@dataclass(frozen=True, repr=False)
class Members(DataType):
    """Listed values: truth values, constants, characters, or any others."""

    members: tuple[Any, ...]
    name: str | None = None
    texts: tuple[str, ...] = ()
    """How a specification writes the members, where their Python values do not tell (sequences from tuples)."""
    _known: dict[tuple[type, Any], str | None] = field(init=False, compare=False, default_factory=dict)

    def __post_init__(self) -> None:
        texts = self.texts or (None,) * len(self.members)
        known = {(type(member), member): text for member, text in zip(self.members, texts, strict=True)}
        object.__setattr__(self, "_known", known)

    def text(self, value: Any) -> str:
        """*value* as a specification writes it."""
        return self._known.get((type(value), value)) or _text(value)

    def contains(self, value: object) -> bool:
        """Whether *value* is one of them; 1 and ``True`` are two."""
        try:
            return (type(value), value) in self._known
        except TypeError:  # unhashable
            return False

    def admits(self, value: object) -> bool:
        """Anything of the type of a member."""
        return any(type(value) is type(member) for member in self.members)

    def values(self) -> Iterator[Any]:
        """As they were listed."""
        return iter(self.members)

    def extent(self) -> str:
        """``{red, green}``."""
        return f"{{{', '.join(map(self.text, self.members))}}}"


BOOLEANS = Members((False, True), "Bool")
"""The truth values."""


@dataclass(frozen=True, repr=False)
class Tuples(DataType):
    """Tuples of one value from each of several sets."""

    items: tuple[DataType, ...]
    name: str | None = None

    def contains(self, value: object) -> bool:
        """Whether *value* is a tuple of the right length with the right items."""
        return (
            type(value) is tuple
            and len(value) == len(self.items)
            and all(item.contains(part) for item, part in zip(self.items, value, strict=True))
        )

    def values(self) -> Iterator[Any] | None:
        """The first item varies slowest."""
        return _products(self.items)

    @property
    def default(self) -> Any:
        """The defaults of the items."""
        return tuple(item.default for item in self.items)

    def extent(self) -> str:
        """``({0..3}, Bool)``."""
        return f"({', '.join(item.name or item.extent() for item in self.items)})"

    def text(self, value: Any) -> str:
        """``(1, true)``."""
        return f"({', '.join(item.text(part) for item, part in zip(self.items, value, strict=True))})"


@dataclass(frozen=True, repr=False)
class Sequences(DataType):
    """Finite sequences over a set, as tuples; ``longest`` None: of any length."""

    element: DataType
    longest: int | None = None
    name: str | None = None

    def contains(self, value: object) -> bool:
        """Whether *value* is a tuple of elements that is not too long."""
        return (
            type(value) is tuple
            and (self.longest is None or len(value) <= self.longest)
            and all(map(self.element.contains, value))
        )

    def admits(self, value: object) -> bool:
        """Any sequence of elements."""
        return type(value) is tuple and all(map(self.element.contains, value))

    def values(self) -> Iterator[Any] | None:
        """Short ones first."""
        longest = self.longest
        elements = self.element.values()
        if longest is None or elements is None:
            return None
        items = tuple(elements)
        return chain.from_iterable(product(items, repeat=length) for length in range(longest + 1))

    @property
    def default(self) -> Any:
        """The empty sequence."""
        return ()

    def extent(self) -> str:
        """``Seq({0..3}), at most 4``."""
        bound = "" if self.longest is None else f", at most {self.longest}"
        return f"Seq({self.element.name or self.element.extent()}){bound}"

    def text(self, value: Any) -> str:
        """``<1, 2>``."""
        return f"<{', '.join(map(self.element.text, value))}>"


@dataclass(frozen=True, repr=False)
class Sets(DataType):
    """Finite subsets of a set, as frozensets."""

    element: DataType
    name: str | None = None

    def contains(self, value: object) -> bool:
        """Whether *value* is a frozenset of elements."""
        return type(value) is frozenset and all(map(self.element.contains, value))

    def values(self) -> Iterator[Any] | None:
        """Small ones first."""
        elements = self.element.values()
        if elements is None:
            return None
        items = tuple(elements)
        return (frozenset(some) for size in range(len(items) + 1) for some in combinations(items, size))

    @property
    def default(self) -> Any:
        """The empty set."""
        return frozenset()

    def extent(self) -> str:
        """``Set({0..3})``."""
        return f"Set({self.element.name or self.element.extent()})"

    def text(self, value: Any) -> str:
        """``{1, 2}``, sorted where the elements have an order."""
        return f"{{{', '.join(sorted(map(self.element.text, value)))}}}"


@dataclass(frozen=True, repr=False)
class Constructed(DataType):
    """A datatype: each constructor's name with the sets of its fields; constants are constructors without fields."""

    constructors: tuple[tuple[str, tuple[DataType, ...]], ...]
    name: str | None = None

    def contains(self, value: object) -> bool:
        """Whether *value* is one of the constructors with fields from their sets."""
        if not isinstance(value, Tagged):
            return False
        fields = dict(self.constructors).get(value.name)
        return (
            fields is not None
            and len(fields) == len(value.fields)
            and all(field.contains(part) for field, part in zip(fields, value.fields, strict=True))
        )

    def admits(self, value: object) -> bool:
        """Any constructor of this name."""
        return isinstance(value, Tagged) and value.name in dict(self.constructors)

    def values(self) -> Iterator[Any] | None:
        """Constructor by constructor."""
        rows = [_products(fields) for _, fields in self.constructors]
        if any(row is None for row in rows):
            return None
        named = zip((name for name, _ in self.constructors), rows, strict=True)
        return (Tagged(name, fields) for name, row in named for fields in row or ())

    def extent(self) -> str:
        """``A | B.{0..3}``."""
        rows = [(name, *[field.name or field.extent() for field in fields]) for name, fields in self.constructors]
        return " | ".join(".".join(row) for row in rows)

    def text(self, value: Any) -> str:
        """``B.3``."""
        fields = dict(self.constructors)[value.name]
        parts = [field.text(part) for field, part in zip(fields, value.fields, strict=True)]
        return ".".join([value.name, *parts])


@dataclass(frozen=True, repr=False)
class Anything(DataType):
    """A type about which nothing is known: every value belongs to it."""

    name: str | None = None

    def contains(self, value: object) -> bool:
        """True."""
        return True

    def values(self) -> None:
        """None: they cannot be listed."""
        return

    def extent(self) -> str:
        """The word for it."""
        return "anything"


class Variables:
    """Variables with declared types: every assignment is checked.

    Subclasses list the types in ``TYPES``. An attribute that is not listed cannot be assigned.
    """

    OWNER: ClassVar[str] = ""
    TYPES: ClassVar[dict[str, DataType]] = {}

    def __init__(self, **values: Any) -> None:
        for name, declared in self.TYPES.items():
            setattr(self, name, values.pop(name) if name in values else declared.default)
        if values:
            raise AttributeError(f"{self.OWNER} has no variable {next(iter(values))!r}")

    def __setattr__(self, name: str, value: Any) -> None:
        declared = self.TYPES.get(name)
        if declared is None:
            raise AttributeError(f"{self.OWNER} has no variable {name!r}")
        if not declared.contains(value):
            raise OutOfRange(self.OWNER, name, value, declared)
        object.__setattr__(self, name, value)

    def snapshot(self) -> dict[str, Any]:
        """The values, by name."""
        return {name: getattr(self, name) for name in self.TYPES}

    def restore(self, values: dict[str, Any]) -> None:
        """Take all values back to those of a snapshot."""
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        return f"{self.OWNER}({', '.join(f'{name}={value!r}' for name, value in self.snapshot().items())})"


def _products(types: Sequence[DataType]) -> Iterator[tuple[Any, ...]] | None:
    rows = [field.values() for field in types]
    if any(row is None for row in rows):
        return None
    return product(*[row for row in rows if row is not None])


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, Tagged):
        return ".".join([value.name, *map(_text, value.fields)])
    if isinstance(value, frozenset):
        return f"{{{', '.join(sorted(map(_text, value)))}}}"
    if isinstance(value, tuple):
        return f"({', '.join(map(_text, value))})"
    if isinstance(value, str):
        return f"'{value}'"
    return str(value)
