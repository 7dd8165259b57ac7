"""Hash consing: of all terms with the same operator and the same operands there is one object.

Terms then compare by identity, and a term that nobody holds any more is forgotten (Filliatre and Conchon, "Type-safe
modular hash-consing", 2006).
"""

from __future__ import annotations

from dataclasses import MISSING, fields
from functools import cache
from typing import Any, ClassVar
from weakref import ref


class Entry(ref[Any]):
    """A weak reference that knows where it is kept; a third of the price of ``weakref.KeyedRef``."""

    __slots__ = ("key",)

    key: Any


class HashConsed(type):
    """Calling a class with the operands of an existing term gives that term; those left out have their defaults."""

    _terms: ClassVar[dict[tuple[Any, ...], Entry]] = {}

    def __call__(cls, *operands: Any) -> Any:
        """The one term with these operands."""
        # A WeakValueDictionary does the same at twice the price; terms are made by the million.
        key = (cls, *operands)
        known = HashConsed._terms.get(key)
        if known is not None:
            term = known()
            if term is not None:
                return term
        defaults = _defaults(cls).get(len(operands))
        if defaults is not None:
            return cls(*operands, *defaults)  # only the term with all its operands is kept
        term = super().__call__(*operands)
        HashConsed._terms[key] = entry = Entry(term, _forget)
        entry.key = key
        return term


@cache
def _defaults(cls: type[Any]) -> dict[int, tuple[Any, ...]]:
    """What the last operands of a class of terms are where they are left out, by the number of those given."""
    found: dict[int, tuple[Any, ...]] = {}
    defaults: tuple[Any, ...] = ()
    operands = fields(cls)
    for given in reversed(range(len(operands))):
        if operands[given].default is MISSING:
            break
        defaults = (operands[given].default, *defaults)
        found[given] = defaults
    return found


def _forget(reference: Entry, _terms: dict[Any, Any] = HashConsed._terms) -> None:
    """Drop the entry of a term that nobody has any more, unless an equal one has taken its place."""
    if _terms.get(reference.key) is reference:
        del _terms[reference.key]
