"""Sorts of the solver for the types of a specification.

==============  =============================================================================================
given set       an uninterpreted sort; for a bounded search an enumeration of k elements
free type       a datatype
tuple, record   a datatype with one constructor
set, relation   an array from elements to truth values
function        an array from arguments to options, ``none`` outside the domain: equality is extensional, and a
                restriction or an override is a change of the array
sequence        a length and an array from positions; beyond the length the array has one fixed value (*junk*), so
                that equality is extensional here too
bag             an array from elements to counts
==============  =============================================================================================

The solver's own theory of finite sets is not used: it answers wrongly about cardinalities.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeAlias

import z3

from cspcheck.cspm.oz import core

Expr: TypeAlias = Any
Sort: TypeAlias = Any


class Unsupported(Exception):
    """A term or type that cannot be put as a formula; the text says what."""


class QuerySorts:
    """The sorts of one query.

    Args:
        specification: whose free types and records these are.
        size: the number of elements of each given set; None: any.
    """

    def __init__(self, specification: core.Specification, size: int | None) -> None:
        self.context = z3.Context()
        self.size = size
        self._specification = specification
        self._sorts: dict[core.Type, Sort] = {}
        self._junk: dict[core.Type, Expr] = {}
        self._names = 0

    # --- sorts -------------------------------------------------------------------------------------------------------

    def sort(self, type_: core.Type) -> Sort:
        """The sort of a type."""
        found = self._sorts.get(type_)
        if found is None:
            found = self._make(type_)
            self._sorts[type_] = found
        return found

    def _make(self, type_: core.Type) -> Sort:
        match type_:
            case core.BoolType():
                return z3.BoolSort(self.context)
            case core.IntType():
                return z3.IntSort(self.context)
            case core.RealType():
                return z3.RealSort(self.context)
            case core.GivenType(name=name):
                if self.size is None:
                    return z3.DeclareSort(name, self.context)
                return z3.EnumSort(name, [f"{name}.{i}" for i in range(1, self.size + 1)], self.context)[0]
            case core.FreeType():
                self._make_free(type_)
                return self._sorts[type_]
            case core.TupleType(items=items):
                return self._product(type_, [(str(i), item) for i, item in enumerate(items, 1)])
            case core.RecordType(fields=fields):
                return self._product(type_, list(fields))
            case core.SetType(element=element):
                return z3.ArraySort(self.sort(element), z3.BoolSort(self.context))
            case core.FunctionType(domain=domain, range=range_):
                return z3.ArraySort(self.sort(domain), self._option(range_))
            case core.SequenceType(element=element):
                kind = z3.Datatype(self._name("seq"), self.context)
                items_sort = z3.ArraySort(z3.IntSort(self.context), self.sort(element))
                kind.declare("sequence", ("length", z3.IntSort(self.context)), ("items", items_sort))
                return kind.create()
            case core.BagType(element=element):
                return z3.ArraySort(self.sort(element), z3.IntSort(self.context))
        raise TypeError(f"not a type: {type_!r}")

    def _name(self, stem: str) -> str:
        self._names += 1
        return f"{stem}%{self._names}"

    def _product(self, type_: core.Type, fields: list[tuple[str, core.Type]]) -> Sort:
        kind = z3.Datatype(self._name("record" if isinstance(type_, core.RecordType) else "tuple"), self.context)
        kind.declare("make", *[(f".{name}", self.sort(field)) for name, field in fields])
        return kind.create()

    def _option(self, type_: core.Type) -> Sort:
        # Options are kept under a type that no term has: a one-element function.
        wrapped = core.FunctionType(core.RecordType("%option", ()), type_)
        found = self._sorts.get(wrapped)
        if found is None:
            kind = z3.Datatype(self._name("option"), self.context)
            kind.declare("none")
            kind.declare("some", ("value", self.sort(type_)))
            found = self._sorts[wrapped] = kind.create()
        return found

    def _make_free(self, type_: core.FreeType) -> None:
        """Make a free type, and with it the free types and tuples that it is recursive with."""
        group: list[core.Type] = []
        self._gather(type_, group)
        kinds = {member: z3.Datatype(self._kind_name(member), self.context) for member in group}

        def reference(part: core.Type) -> Any:
            if part in kinds:
                return kinds[part]
            if self._reaches(part, set(group)):
                raise Unsupported(f"the free type `{type_}`, which contains itself inside `{part}`")
            return self.sort(part)

        for member, kind in kinds.items():
            if isinstance(member, core.FreeType):
                for constructor, argument in self.free(member).branches:
                    fields = [] if argument is None else [("argument", reference(element_of(argument)))]
                    # The prefix keeps the names of the text apart from the attributes of the solver's objects.
                    kind.declare(f"{member}.{constructor}", *fields)
            else:
                kind.declare("make", *[(f".{name}", reference(part)) for name, part in _fields(member)])
        for member, sort in zip(group, z3.CreateDatatypes(*kinds.values()), strict=True):
            self._sorts[member] = sort

    def _kind_name(self, type_: core.Type) -> str:
        return type_.name if isinstance(type_, core.FreeType) else self._name("tuple")

    def _gather(self, type_: core.Type, group: list[core.Type]) -> None:
        """The free types below a free type, with the products that lie between them."""
        if type_ in group or type_ in self._sorts:
            return
        if isinstance(type_, core.FreeType):
            group.append(type_)
            for _, argument in self.free(type_).branches:
                if argument is not None:
                    self._gather(element_of(argument), group)
        elif isinstance(type_, core.TupleType | core.RecordType) and self._reaches(type_, set(group)):
            group.append(type_)
            for _, part in _fields(type_):
                self._gather(part, group)

    def _reaches(self, type_: core.Type, goals: set[core.Type], seen: frozenset[core.Type] = frozenset()) -> bool:
        """Whether a value of a type can contain one of the types *goals*."""
        if type_ in goals:
            return True
        if type_ in seen:
            return False
        seen = seen | {type_}
        if isinstance(type_, core.FreeType):
            arguments = [element_of(a) for _, a in self.free(type_).branches if a is not None]
            return any(self._reaches(part, goals, seen) for part in arguments)
        return any(self._reaches(part, goals, seen) for part in _components(type_))

    def free(self, type_: core.FreeType) -> core.FreeDefinition:
        """The definition of a free type."""
        definition = self._specification.frees.get(type_.name)
        if definition is None:
            raise Unsupported(f"the type `{type_.name}`, whose values are not known")
        return definition

    def record(self, type_: core.RecordType) -> core.RecordDefinition | None:
        """The definition of a record type, None where it has none."""
        return self._specification.records.get(type_.name)

    def recursive(self, type_: core.FreeType) -> bool:
        """Whether values of a free type can contain others of it."""
        arguments = [element_of(a) for _, a in self.free(type_).branches if a is not None]
        return any(self._reaches(part, {type_}) for part in arguments)

    def contains(self, type_: core.Type, part: core.FreeType) -> bool:
        """Whether a value of a type can contain one of a free type."""
        return self._reaches(type_, {part})

    # --- values ------------------------------------------------------------------------------------------------------

    def truth(self, value: bool) -> Expr:
        """A truth value."""
        return z3.BoolVal(value, self.context)

    def whole(self, value: int) -> Expr:
        """An integer."""
        return z3.IntVal(value, self.context)

    def option(self, function: Expr, argument: Expr) -> Expr:
        """What a function gives for an argument: ``none`` or ``some``."""
        return selected(function, argument)

    def none(self, type_: core.FunctionType) -> Expr:
        """``none``, for arguments outside the domain."""
        return self._option(type_.range).none

    def some(self, type_: core.FunctionType, value: Expr) -> Expr:
        """``some value``."""
        return self._option(type_.range).some(value)

    def is_some(self, type_: core.FunctionType, option: Expr) -> Expr:
        """Whether an option is a value."""
        return self._option(type_.range).is_some(option)

    def value(self, type_: core.FunctionType, option: Expr) -> Expr:
        """The value of ``some value``."""
        return self._option(type_.range).value(option)

    def junk(self, type_: core.Type) -> Expr:
        """The value that arrays of sequences have beyond the length: the same for the whole query."""
        found = self._junk.get(type_)
        if found is None:
            found = self._junk[type_] = z3.Const(self._name("junk"), self.sort(type_))
        return found

    def make(self, type_: core.Type, parts: list[Expr]) -> Expr:
        """A tuple or record from its components."""
        constructor = self.sort(type_).constructor(0)
        return constructor(*parts)

    def part(self, type_: core.Type, whole: Expr, index: int) -> Expr:
        """A component of a tuple or record, from 0."""
        if z3.is_app(whole) and whole.decl().eq(self.sort(type_).constructor(0)):
            return whole.arg(index)
        return self.sort(type_).accessor(0, index)(whole)

    def length(self, type_: core.SequenceType, sequence: Expr) -> Expr:
        """The length of a sequence."""
        return self._side(type_, sequence, 0)

    def items(self, type_: core.SequenceType, sequence: Expr) -> Expr:
        """The array of a sequence."""
        return self._side(type_, sequence, 1)

    def _side(self, type_: core.SequenceType, sequence: Expr, index: int) -> Expr:
        sort = self.sort(type_)
        if z3.is_app(sequence) and sequence.decl().eq(sort.constructor(0)):
            return sequence.arg(index)
        return sort.accessor(0, index)(sequence)

    def sequence(self, type_: core.SequenceType, length: Expr, items: Expr) -> Expr:
        """A sequence from its length and its array."""
        return self.sort(type_).sequence(length, items)

    def constructor_index(self, type_: core.FreeType, constructor: str) -> int:
        """The position of a constructor of a free type."""
        names = [name for name, _ in self.free(type_).branches]
        return names.index(constructor)


def element_of(carrier: core.Term) -> core.Type:
    """The type of the elements of a carrier."""
    assert isinstance(carrier.type, core.SetType)
    return carrier.type.element


def _fields(type_: core.Type) -> list[tuple[str, core.Type]]:
    match type_:
        case core.TupleType(items=items):
            return [(str(i), item) for i, item in enumerate(items, 1)]
        case core.RecordType(fields=fields):
            return list(fields)
    return []


def _components(type_: core.Type) -> Iterator[core.Type]:
    match type_:
        case core.TupleType(items=items):
            yield from items
        case core.RecordType(fields=fields):
            yield from (part for _, part in fields)
        case core.SetType(element=element) | core.SequenceType(element=element) | core.BagType(element=element):
            yield element
        case core.FunctionType(domain=domain, range=range_):
            yield domain
            yield range_


def selected(array: Expr, index: Expr) -> Expr:
    """The value of an array at an index, read off where the array is written out."""
    if z3.is_quantifier(array) and array.is_lambda():
        return z3.substitute_vars(array.body(), index)
    if z3.is_const_array(array):
        return array.arg(0)
    while z3.is_store(array):
        if array.arg(1).eq(index):
            return array.arg(2)
        if not (z3.is_int_value(index) and z3.is_int_value(array.arg(1))):
            break
        array = array.arg(0)
        if z3.is_const_array(array):
            return array.arg(0)
    return z3.Select(array, index)


def all_true(context: z3.Context, parts: list[Expr]) -> Expr:
    """The conjunction of formulas."""
    kept = [part for part in parts if not z3.is_true(part)]
    if any(z3.is_false(part) for part in kept):
        return z3.BoolVal(False, context)
    if not kept:
        return z3.BoolVal(True, context)
    return kept[0] if len(kept) == 1 else z3.And(*kept)


def any_true(context: z3.Context, parts: list[Expr]) -> Expr:
    """The disjunction of formulas."""
    kept = [part for part in parts if not z3.is_false(part)]
    if any(z3.is_true(part) for part in kept):
        return z3.BoolVal(True, context)
    if not kept:
        return z3.BoolVal(False, context)
    return kept[0] if len(kept) == 1 else z3.Or(*kept)
