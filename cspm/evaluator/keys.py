"""What tells two applications of the same process definition apart: their arguments, as far as they have values."""

from __future__ import annotations

from typing import Any

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.sets import FiniteSet
from cspcheck.cspm.values.values import ATOMS, Map, Sequence, deep


class FailedArgument:
    """An argument that cannot be evaluated. Nothing wrong with that as long as nobody asks for it."""

    __slots__ = ("diagnostic",)

    def __init__(self, diagnostic: Diagnostic) -> None:
        self.diagnostic = diagnostic

    def _identity(self) -> tuple[Any, ...]:
        span = self.diagnostic.span
        place = None if span is None else (id(span.source), span.start, span.end)
        return (self.diagnostic.code, self.diagnostic.message, place)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, FailedArgument) and self._identity() == other._identity()

    def __hash__(self) -> int:
        return hash(self._identity())


class Itself:
    """An argument that is only equal to itself, such as an infinite sequence: no comparison would end."""

    __slots__ = ("value",)

    def __init__(self, value: Any) -> None:
        self.value = value

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Itself) and self.value is other.value

    def __hash__(self) -> int:
        return id(self.value)


def key_of(value: Any, level: int = 0) -> Any:
    """*value* (or what a thunk evaluates to) as a part of a key; never fails for a mistake in the script."""
    try:
        return deep(value, level)
    except Failure as failure:
        return Itself(value) if failure.is_limit else FailedArgument(failure.diagnostic)


def native(value: Any) -> Any:
    """What stands for an evaluated *value* in a key: equal for equal values alone, and compared by Python itself.

    A key is looked up for every mention of a process, and methods of values would be called for each. No value is a
    ``frozenset``, and no tuple of values begins with a class, so no two values are mixed up.
    """
    kind = type(value)
    if kind in ATOMS:
        return value
    if kind is FiniteSet:
        return value.items
    if kind is Sequence or kind is Map:
        return value.native
    return value
