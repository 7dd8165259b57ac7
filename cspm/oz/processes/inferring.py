"""The types of what classes bring into the expressions of a script."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from cspcheck.cspm.naming.symbols import Symbol
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.processes.nodes import CarrierSet, ClassExpression, ClassProcess, ConstantValue, given_name
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.typing.types import BOOL, INT, PROC, REAL, MapOf, SequenceOf, SetOf, TupleOf, Type

if TYPE_CHECKING:
    from cspcheck.cspm.typing.inference.context import InferenceContext


def foreign_type(context: InferenceContext, node: syntax.Foreign) -> Type:
    """The type of an expression that the Object-Z part brings."""
    assert isinstance(node, ClassExpression)
    datatypes = {given_name(context.names.symbol(name).name): context.names.symbol(name) for name in node.datatypes}
    match node:
        case CarrierSet():
            return SetOf(_type(context, node.element, datatypes))
        case ConstantValue():
            return _type(context, node.type, datatypes)
        case ClassProcess():
            for main in node.mains:
                context.check(main, PROC, "the `main` of a class")
            return PROC
    raise TypeError(node)


def _type(context: InferenceContext, type_: core.Type, datatypes: Mapping[str, Symbol]) -> Type:
    def of(inner: core.Type) -> Type:
        return _type(context, inner, datatypes)

    match type_:
        case core.IntType():
            return INT
        case core.BoolType():
            return BOOL
        case core.RealType():
            return REAL
        case core.GivenType(name) | core.FreeType(name):
            return context.views.datatype(datatypes[name])
        case core.TupleType(items):
            return TupleOf([of(item) for item in items])
        case core.RecordType(_, fields):
            items_ = [of(item) for _, item in fields]
            return items_[0] if len(items_) == 1 else TupleOf(items_)
        case core.SetType(element):
            return SetOf(of(element))
        case core.SequenceType(element):
            return SequenceOf(of(element))
        case core.FunctionType(domain, range_):
            return MapOf(of(domain), of(range_))
        case core.BagType(element):
            return MapOf(of(element), INT)
    raise TypeError(type_)
