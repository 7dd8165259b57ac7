"""Between the values of the Object-Z part and those of CSPm.

=============== ===================================================================================================
Object-Z        CSPm
=============== ===================================================================================================
``int, bool``   the same
``real``        :class:`cspcheck.cspm.values.values.Real`, which only classes can make
given set       a datatype with the constants ``NAME_1``, ``NAME_2``, ...
free type       a datatype with the same constructors
tuple, record   a tuple (of one field: that field)
set, relation   a set
sequence        a sequence
function, bag   a map
=============== ===================================================================================================
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.values.carriers import listed
from cspcheck.cspm.oz.values.values import Construction, Element, Graph
from cspcheck.cspm.values.dots import Dotted, Head
from cspcheck.cspm.values.sets import Set, set_of
from cspcheck.cspm.values.values import FALSE, TRUE, Boolean, Map, Real, Sequence, deep

REALS = 1 << 12
"""So many real numbers are kept to be given again."""


class Conversion:
    """Converts values of the types of one script.

    Args:
        specification: what free types are made of.
        heads: the constructors of each datatype, by its name, in the order of declaration; asked for when needed.
    """

    def __init__(self, specification: core.Specification, heads: Callable[[str], list[Head]]) -> None:
        self._heads = heads
        self._arguments = _argument_types(specification)
        self._known: dict[str, list[Head]] = {}
        self._reals: dict[int, Real] = {}

    def _of(self, datatype: str) -> list[Head]:
        found = self._known.get(datatype)
        if found is None:
            found = self._known[datatype] = self._heads(datatype)
        return found

    def to_cspm(self, value: Any, type_: core.Type) -> Any:
        """A value as CSPm has it."""
        match type_:
            case core.IntType():
                return value
            case core.BoolType():
                return TRUE if value else FALSE
            case core.RealType():
                return self._real(value)
            case core.GivenType():
                return self._of(type_.name)[value.number - 1].value
            case core.FreeType():
                head = self._of(type_.name)[value.rank]
                if value.argument is None:
                    return head.value
                return head.complete((self.to_cspm(value.argument, self._argument(type_.name, value.rank)),))
            case core.TupleType():
                return tuple([self.to_cspm(v, t) for v, t in zip(value, type_.items, strict=True)])
            case core.RecordType():
                items = tuple([self.to_cspm(v, t) for v, (_, t) in zip(value, type_.fields, strict=True)])
                return items[0] if len(items) == 1 else items
            case core.SetType():
                return set_of([self.to_cspm(item, type_.element) for item in listed(value)])
            case core.SequenceType():
                return deep(Sequence.of([self.to_cspm(item, type_.element) for item in value]))
            case core.FunctionType():
                pairs = {self.to_cspm(a, type_.domain): self.to_cspm(b, type_.range) for a, b in value.items()}
                return deep(Map(pairs))
            case core.BagType():
                return deep(Map({self.to_cspm(a, type_.element): n for a, n in value.items()}))
        raise TypeError(type_)

    def _real(self, value: Fraction) -> Real:
        """The same for the same fraction: those of a large carrier share a few, which are costly to compare."""
        known = self._reals.get(id(value))
        if known is None or known.value is not value:
            if len(self._reals) >= REALS:
                self._reals.clear()
            known = self._reals[id(value)] = Real(value)
        return known

    def _argument(self, datatype: str, rank: int) -> core.Type:
        """The type of what a constructor of a free type is applied to."""
        found = self._arguments[datatype][rank]
        assert found is not None
        return found

    def from_cspm(self, value: Any, type_: core.Type) -> Any:
        """A value of CSPm as the Object-Z part has it."""
        match type_:
            case core.IntType():
                return value
            case core.BoolType():
                assert isinstance(value, Boolean)
                return value.truth
            case core.RealType():
                return value.value if isinstance(value, Real) else Fraction(value)
            case core.GivenType():
                return Element(type_.name, self._rank(value, type_.name) + 1)
            case core.FreeType():
                rank = self._rank(value, type_.name)
                name = self._of(type_.name)[rank].name.split("::")[-1]
                if not value.fields:
                    return Construction(rank, name)
                return Construction(rank, name, self.from_cspm(value.fields[0], self._argument(type_.name, rank)))
            case core.TupleType():
                return tuple([self.from_cspm(v, t) for v, t in zip(value, type_.items, strict=True)])
            case core.RecordType():
                items = (value,) if len(type_.fields) == 1 else value
                return tuple([self.from_cspm(v, t) for v, (_, t) in zip(items, type_.fields, strict=True)])
            case core.SetType():
                assert isinstance(value, Set)
                return frozenset([self.from_cspm(item, type_.element) for item in value.elements()])
            case core.SequenceType():
                return tuple([self.from_cspm(item, type_.element) for item in value.values()])
            case core.FunctionType():
                return Graph(
                    (self.from_cspm(a, type_.domain), self.from_cspm(b, type_.range)) for a, b in value.entries.items()
                )
            case core.BagType():
                return Graph((self.from_cspm(a, type_.element), n) for a, n in value.entries.items())
        raise TypeError(type_)

    def _rank(self, value: Any, datatype: str) -> int:
        assert isinstance(value, Dotted)
        return self._of(datatype).index(value.head)


def _argument_types(specification: core.Specification) -> dict[str, list[core.Type | None]]:
    """The types of the arguments of each free type's constructors, in order."""
    found: dict[str, list[core.Type | None]] = {}
    for name, definition in specification.frees.items():
        found[name] = [
            carrier.type.element if carrier is not None and isinstance(carrier.type, core.SetType) else None
            for _, carrier in definition.branches
        ]
    return found
