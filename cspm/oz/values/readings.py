"""The finite readings of a specification: which of them says what a search takes instead of a wide carrier."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import TYPE_CHECKING, Any, Final

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, FiniteReading, Term
from cspcheck.cspm.oz.values.carriers import listed
from cspcheck.cspm.oz.values.terms import shape
from cspcheck.cspm.oz.values.values import in_order

if TYPE_CHECKING:
    from cspcheck.cspm.oz.values.evaluation import TermEvaluator

COLLECTIONS: Final = frozenset(
    {
        *("seq", "seq1", "iseq", "bag", "power", "power1", "finset", "finset1"),
        *("rel", "pfun", "fun", "pinj", "inj", "psurj", "surj", "bij", "ffun", "finj"),
    }
)
"""Carriers whose reading may be a greatest length or size."""


class Readings:
    """The readings of one specification, by the form of the carrier that each is about."""

    def __init__(self, specification: core.Specification, evaluator: TermEvaluator) -> None:
        self._evaluator = evaluator
        self._by_shape: dict[Hashable, FiniteReading] = {}
        for reading in specification.readings:
            self._by_shape.setdefault(shape(reading.subject), reading)
        self._values: dict[int, list[Any]] = {}

    def of(self, carrier: Term) -> FiniteReading | None:
        """The reading of exactly this carrier.

        A reading of ``int`` serves ``nat`` and ``nat1`` too, one of ``nat`` serves ``nat1``, and one of ``seq T``
        serves ``seq1 T`` and ``iseq T``.
        """
        if not self._by_shape:
            return None
        found = self._by_shape.get(shape(carrier))
        if found is not None or not isinstance(carrier, Apply):
            return found
        for wider in _WIDER.get(carrier.operator, ()):
            found = self._by_shape.get(shape(Apply(type=carrier.type, operator=wider, operands=carrier.operands)))
            if found is not None:
                return found
        return None

    def values(self, reading: FiniteReading) -> list[Any]:
        """The values of a reading that lists them, in order."""
        found = self._values.get(id(reading))
        if found is None:
            assert reading.values is not None
            found = self._values[id(reading)] = in_order(listed(self._evaluator.value(reading.values)))
        return found

    def use(self, readings: Iterable[FiniteReading]) -> None:
        """Remember that some readings are followed."""
        for reading in readings:
            self._evaluator.used.setdefault(written(reading))


def written(reading: FiniteReading) -> str:
    """A reading as the script writes it, without the word: ``nat = 0..3``."""
    text = reading.span.text
    if text.startswith("\\"):
        from cspcheck.cspm.oz.reading.latex_reader import text_of

        text = text_of(reading.span)
    return " ".join(text.split()).removeprefix("reading ")


_WIDER: Final = {
    "Nat": ("Int",),
    "Nat1": ("Nat", "Int"),
    "seq1": ("seq",),
    "iseq": ("seq",),
    "power1": ("power",),
    "finset": ("power",),
    "finset1": ("finset", "power"),
}
"""Carriers whose reading serves another, nearest first."""
