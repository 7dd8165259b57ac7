"""Sets that may be infinite, as values, and the failures of evaluation that concern values and sets."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from cspcheck.cspm.oz.core import Term
from cspcheck.cspm.oz.processes import messages as messages
from cspcheck.cspm.oz.values.terms import show_term
from cspcheck.cspm.oz.values.values import LARGEST
from cspcheck.cspm.source import Span
from cspcheck.cspm.values.failure import Failure

Frame = list[Any]
"""The values of the variables in scope, by slot."""


class Undefined(Failure):
    """A term has no value; where the truth of a predicate does not depend on it, that is no mistake."""

    def __init__(self, what: str, span: Span | None = None) -> None:
        super().__init__(messages.undefined(what, span))


class Unbounded(Failure):
    """An infinite set would have to be gone through."""

    def __init__(self, carrier: Term, variable: str | None = None, span: Span | None = None) -> None:
        text = show_term(carrier)
        super().__init__(messages.no_finite_reading(variable, text, suggestion(carrier), span or carrier.span))
        self.carrier = carrier
        self.variable = variable

    def of(self, variable: str, span: Span | None) -> Unbounded:
        """The same with the variable that is to be chosen, if it has none yet."""
        return self if self.variable is not None else Unbounded(self.carrier, variable, span)


class TooLarge(Failure):
    """A finite set has too many elements to be written out."""

    def __init__(self, what: str, span: Span | None = None) -> None:
        super().__init__(messages.set_too_large(what, LARGEST, span), is_limit=True)


def suggestion(carrier: Term) -> str:
    """A reading that would do for a carrier."""
    text = show_term(carrier)
    match getattr(carrier, "operator", None):
        case "Int":
            return "reading int = -3..3"
        case "Nat" | "Nat1":
            return f"reading {text} = {int(text == 'nat1')}..3"
        case "Real":
            return "reading real = {0.0, 0.5, 1.0}"
        case "All":
            return f"reading {text} = 2"
    return f"reading {text} = 2"


@dataclass(frozen=True, eq=False, slots=True)
class Carrier:
    """A set that is not written out.

    Attributes:
        term: what it is, for messages.
        contains: whether a value is in it.
        listing: its elements in order, as far as the finite readings go; raises Unbounded or TooLarge.
        exact: whether the listing is all of it.
    """

    term: Term
    contains: Callable[[Any], bool]
    listing: Callable[[], Iterable[Any]]
    exact: bool

    def listed(self) -> frozenset[Any]:
        """All elements.

        Raises:
            Unbounded: there are infinitely many, whatever a finite reading says.
        """
        if not self.exact:
            raise Unbounded(self.term)
        return frozenset(self.listing())

    def __contains__(self, value: Any) -> bool:
        return self.contains(value)


def listed(value: Any) -> frozenset[Any]:
    """A set value, written out.

    Raises:
        Unbounded: it is infinite.
    """
    return value if type(value) is frozenset else value.listed()


def capped(values: Iterable[Any], what: Term) -> list[Any]:
    """All *values* in a list.

    Raises:
        TooLarge: there are too many.
    """
    found: list[Any] = []
    for value in values:
        found.append(value)
        if len(found) > LARGEST:
            raise TooLarge(show_term(what), what.span)
    return found
