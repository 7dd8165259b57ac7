"""The values that core terms have, as Python objects.

============== ===================================================================================================
type           value
============== ===================================================================================================
``bool``       ``bool``
``int``        ``int``
``real``       ``fractions.Fraction``, also where it is whole
given set      :class:`Element`
free type      :class:`Construction`
tuple, record  ``tuple`` of the items, or of the fields in the order of the type
set, relation  ``frozenset``; :class:`cspcheck.cspm.oz.values.carriers.Carrier` where the set may be infinite
sequence       ``tuple``
function       :class:`Graph`
bag            :class:`Graph` from elements to counts above zero
============== ===================================================================================================

Python holds ``True == 1 == Fraction(1)``, but the type of a term tells these apart and no set mixes them.
All values are hashable and compare by content.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import Any, Final, NamedTuple

from cspcheck.cspm.oz import core
from cspcheck.cspm.values.text import show_real

LARGEST: Final = 1 << 20
"""A set is written out only if it has at most so many elements."""


class Element(NamedTuple):
    """An element of a given set: nothing but its number, from 1."""

    given: str
    number: int

    def __str__(self) -> str:
        return f"{self.given}_{self.number}"


class Construction(NamedTuple):
    """A value of a free type; ``rank`` is the number of its constructor, so that values sort as declared."""

    rank: int
    constructor: str
    argument: Any = None


class Graph(dict[Any, Any]):
    """A finite function, or a bag. Never changed once it has been hashed."""

    __slots__ = ("_hash",)

    def __hash__(self) -> int:  # type: ignore[override]
        try:
            return self._hash
        except AttributeError:
            self._hash: int = hash(frozenset(self.items()))
            return self._hash


def order_key(value: Any) -> Any:
    """A key by which values of one type sort: numbers by size, constructors as declared, the smaller sets first."""
    match value:
        case frozenset():
            return (len(value), sorted(map(order_key, value)))
        case Graph():
            return (len(value), sorted((order_key(a), order_key(b)) for a, b in value.items()))
        case Construction():
            return (value.rank, () if value.argument is None else (order_key(value.argument),))
        case Element():
            return value.number
        case tuple():
            return (len(value), [order_key(item) for item in value])
    return value


def in_order(values: Iterable[Any]) -> list[Any]:
    """Values of one type in their order."""
    found = list(values)
    if len(found) > 1:
        found.sort(key=None if type(found[0]) in (int, Fraction, bool) else order_key)
    return found


def show(value: Any, type_: core.Type | None = None) -> str:
    """A value as the text notation writes it. Without its type, tuples and sequences look alike."""
    match value:
        case bool():
            return "true" if value else "false"
        case Fraction():
            return show_real(value)
        case Element():
            return str(value)
        case Construction():
            if value.argument is None:
                return value.constructor
            return f"{value.constructor}({show(value.argument)})"
        case frozenset():
            element = type_.element if isinstance(type_, core.SetType) else None
            inside = ", ".join(show(item, element) for item in in_order(value))
            return f"{{ {inside}}}" if inside.startswith("-") else f"{{{inside}}}"
        case Graph():
            return _show_graph(value, type_)
        case tuple():
            return _show_tuple(value, type_)
    return str(value)


def _show_graph(value: Graph, type_: core.Type | None) -> str:
    if isinstance(type_, core.BagType):
        repeated = [item for item in in_order(value) for _ in range(value[item])]
        return "[[" + ", ".join(show(item, type_.element) for item in repeated) + "]]"
    domain, range_ = (type_.domain, type_.range) if isinstance(type_, core.FunctionType) else (None, None)
    pairs = ", ".join(f"{show(key, domain)} |-> {show(value[key], range_)}" for key in in_order(value))
    return f"{{{pairs}}}"


def _show_tuple(value: tuple[Any, ...], type_: core.Type | None) -> str:
    match type_:
        case core.SequenceType():
            return "<" + ", ".join(show(item, type_.element) for item in value) + ">"
        case core.RecordType():
            pairs = zip(type_.fields, value, strict=True)
            return "(| " + ", ".join(f"{name} == {show(item, kind)}" for (name, kind), item in pairs) + " |)"
        case core.TupleType():
            return "(" + ", ".join(show(item, kind) for item, kind in zip(value, type_.items, strict=True)) + ")"
    return "(" + ", ".join(map(show, value)) + ")"


def show_assignment(names: Mapping[str, core.Type], values: Iterable[Any]) -> str:
    """``items = <1, 2>, size = 2``."""
    return ", ".join(f"{name} = {show(value, names[name])}" for name, value in zip(names, values, strict=True))
