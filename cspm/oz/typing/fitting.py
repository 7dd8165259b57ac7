"""Types that fit: where one kind of value may stand for another, and the coercion that says so.

Integers stand for reals, sequences for functions from 1..n, functions for relations, and empty displays for a
collection of any type. :func:`fit` makes a term have a wanted type; :func:`join` finds the type that two terms can
both have.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Final

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import (
    BOOL,
    INT,
    REAL,
    Apply,
    BagType,
    Comprehension,
    Constant,
    FunctionType,
    GivenType,
    If,
    SequenceType,
    SetType,
    Term,
    TupleType,
    Type,
)

UNKNOWN: Final[Type] = GivenType("?")
"""The element type of ``{}`` and ``<>`` until something says more."""


class Misfit(Exception):
    """A term cannot have a wanted type."""

    def __init__(self, term: Term, wanted: Type) -> None:
        super().__init__(f"{term.type} is not {wanted}")
        self.term = term
        self.wanted = wanted


def unknown_in(type_: Type) -> bool:
    """Whether something of a type is not known yet."""
    match type_:
        case SetType(element) | SequenceType(element) | BagType(element):
            return unknown_in(element)
        case FunctionType(domain, range_):
            return unknown_in(domain) or unknown_in(range_)
        case TupleType(items):
            return any(map(unknown_in, items))
    return type_ == UNKNOWN


def join(a: Type, b: Type) -> Type | None:
    """The type that terms of types *a* and *b* can both have; None if there is none."""
    if a == b or b == UNKNOWN:
        return a
    if a == UNKNOWN:
        return b
    match a, b:
        case (core.IntType(), core.RealType()) | (core.RealType(), core.IntType()):
            return REAL
        case SequenceType(x), SequenceType(y):
            return _of(SequenceType, join(x, y))
        case SetType(x), SetType(y):
            return _of(SetType, join(x, y))
        case BagType(x), BagType(y):
            return _of(BagType, join(x, y))
        case FunctionType(d, r), FunctionType(e, q):
            domain, range_ = join(d, e), join(r, q)
            return None if domain is None or range_ is None else FunctionType(domain, range_)
        case (SequenceType(x), FunctionType(d, r)) | (FunctionType(d, r), SequenceType(x)):
            range_ = join(x, r)
            return None if range_ is None or join(INT, d) != INT else FunctionType(INT, range_)
        case (FunctionType(d, r), SetType(x)) | (SetType(x), FunctionType(d, r)):
            return _of(SetType, join(TupleType((d, r)), x))
        case (SequenceType(y), SetType(x)) | (SetType(x), SequenceType(y)):
            return _of(SetType, join(TupleType((INT, y)), x))
        case (BagType(y), FunctionType(d, r)) | (FunctionType(d, r), BagType(y)):
            domain = join(y, d)
            return None if domain is None or r != INT else FunctionType(domain, INT)
        case core.RecordType(_, xs), core.RecordType(_, ys) if sorted(xs, key=_named) == sorted(ys, key=_named):
            return a  # schemas with the same components have the same type
        case TupleType(xs), TupleType(ys) if len(xs) == len(ys):
            items = [join(x, y) for x, y in zip(xs, ys, strict=True)]
            return TupleType(tuple([item for item in items if item is not None])) if None not in items else None
    return None


def _named(field: tuple[str, Type]) -> str:
    return field[0]


def _of(form: type[SequenceType] | type[SetType] | type[BagType], element: Type | None) -> Type | None:
    return None if element is None else form(element)


_DEEP: Final = ("union", "inter", "diff", "symdiff", "concat", "override", "bag_union")
"""Operators whose operands have the type of the whole."""
_SHALLOW: Final = ("tail", "front", "rev")


def fit(term: Term, wanted: Type) -> Term:
    """*term* with the type *wanted*: itself, a display with the type filled in, or a coercion of it.

    Raises:
        Misfit: it cannot have that type.
    """
    if term.type == wanted:
        return term
    if wanted == UNKNOWN:
        return term
    rebuilt = _rebuilt(term, wanted)
    if rebuilt is not None:
        return rebuilt
    match term.type, wanted:
        case core.IntType(), core.RealType():
            return Apply(type=REAL, operator="int_to_real", operands=(term,), span=term.span)
        case SequenceType(), SequenceType(element):
            return _mapped_sequence(term, element)
        case SequenceType(), FunctionType(domain, range_) if domain == INT:
            inner = fit(term, SequenceType(range_))
            return Apply(type=wanted, operator="sequence_to_function", operands=(inner,), span=term.span)
        case SequenceType(), SetType(TupleType((first, second))) if first == INT:
            inner = fit(term, FunctionType(INT, second))
            return Apply(type=wanted, operator="function_to_relation", operands=(inner,), span=term.span)
        case BagType(element), FunctionType(domain, range_) if element == domain and range_ == INT:
            return Apply(type=wanted, operator="bag_to_function", operands=(term,), span=term.span)
        case FunctionType(domain, range_), SetType(TupleType((first, second))) if (domain, range_) == (first, second):
            return Apply(type=wanted, operator="function_to_relation", operands=(term,), span=term.span)
        case FunctionType(), SetType(TupleType((first, second))):
            relation = fit(term, SetType(TupleType((term.type.domain, term.type.range))))
            return fit(relation, wanted)
        case core.RecordType(_, has), core.RecordType(_, fields) if sorted(has, key=_named) == sorted(
            fields, key=_named
        ):
            values = [core.Field(type=type_, record=term, name=name, span=term.span) for name, type_ in fields]
            return core.Record(type=wanted, values=tuple(values), span=term.span)
        case SetType(), SetType(element):
            return _mapped_set(term, element)
        case TupleType(items), TupleType(others) if len(items) == len(others):
            operands = []
            for i, (item, other) in enumerate(zip(items, others, strict=True)):
                place = Constant(type=INT, value=i)
                operands.append(fit(Apply(type=item, operator="item", operands=(term, place), span=term.span), other))
            return Apply(type=wanted, operator="tuple", operands=tuple(operands), span=term.span)
    raise Misfit(term, wanted)


def _rebuilt(term: Term, wanted: Type) -> Term | None:
    """A literal, a display or a choice with its parts fitted; None where only a coercion can help."""
    match term:
        case Constant(value=int() as value) if wanted == REAL and term.type == INT:
            return Constant(type=REAL, value=Fraction(value), span=term.span)
        case If():
            return replace(term, type=wanted, then=fit(term.then, wanted), otherwise=fit(term.otherwise, wanted))
        case Apply(operator="set", operands=operands):
            if isinstance(wanted, SetType):
                return replace(term, type=wanted, operands=tuple([fit(item, wanted.element) for item in operands]))
            if isinstance(wanted, FunctionType):
                pair = TupleType((wanted.domain, wanted.range))
                items = tuple([fit(item, pair) for item in operands])
                return replace(term, type=wanted, operator="function", operands=items)
            if isinstance(wanted, SequenceType) and not operands:
                return replace(term, type=wanted, operator="sequence")
        case Apply(operator="sequence", operands=operands) if isinstance(wanted, SequenceType):
            return replace(term, type=wanted, operands=tuple([fit(item, wanted.element) for item in operands]))
        case Apply(operator="bag_display", operands=operands) if isinstance(wanted, BagType):
            return replace(term, type=wanted, operands=tuple([fit(item, wanted.element) for item in operands]))
        case Apply(operator="tuple", operands=operands) if isinstance(wanted, TupleType):
            if len(operands) == len(wanted.items):
                fitted = [fit(item, type_) for item, type_ in zip(operands, wanted.items, strict=True)]
                return replace(term, type=wanted, operands=tuple(fitted))
        case Apply(operator=operator, operands=operands) if operator in _DEEP and _same_kind(term.type, wanted):
            return replace(term, type=wanted, operands=tuple([fit(item, wanted) for item in operands]))
        case Apply(operator="negate" | "plus" | "minus" | "times" | "abs", operands=operands) if wanted == REAL:
            if all(_literal(item) for item in operands):
                return replace(term, type=REAL, operands=tuple([fit(item, REAL) for item in operands]))
        case Apply(operator=operator, operands=operands) if operator in _SHALLOW and _same_kind(term.type, wanted):
            return replace(term, type=wanted, operands=tuple([fit(item, wanted) for item in operands]))
        case Apply(operator="Union" | "Inter" | "flatten", operands=(inner,)) if _same_kind(term.type, wanted):
            around = SequenceType(wanted) if term.operator == "flatten" else SetType(wanted)
            return replace(term, type=wanted, operands=(fit(inner, around),))
    return None


def _literal(term: Term) -> bool:
    """Whether a number is written out, so that its type can still be chosen."""
    match term:
        case Constant():
            return True
        case Apply(operator="negate", operands=(inner,)):
            return _literal(inner)
    return False


def _same_kind(a: Type, b: Type) -> bool:
    return type(a) is type(b)


def _mapped_set(term: Term, element: Type) -> Term:
    """A set with each of its elements coerced: ``{x : term @ coerced x}``."""
    assert isinstance(term.type, SetType)
    bound = core.Variable(type=term.type.element, name="x%" + str(element), role="bound", span=term.span)
    binder = core.Binder(bound.name, bound.type, term, "x")
    return Comprehension(
        type=SetType(element),
        kind="set",
        binders=(binder,),
        condition=Constant(type=BOOL, value=True),
        body=fit(bound, element),
        span=term.span,
    )


def _mapped_sequence(term: Term, element: Type) -> Term:
    raise Misfit(term, SequenceType(element))


def fit_both(left: Term, right: Term) -> tuple[Term, Term]:
    """Two terms with one type.

    A display of maplets beside a function becomes a function, so that both stay functions.

    Raises:
        Misfit: they have no common type.
    """
    for display, other in ((left, right), (right, left)):
        if isinstance(other.type, FunctionType | SequenceType) and _maplets(display):
            function = other.type if isinstance(other.type, FunctionType) else FunctionType(INT, other.type.element)
            try:
                return fit(left, function), fit(right, function)
            except Misfit:
                break
    common = join(left.type, right.type)
    if common is None:
        raise Misfit(right, left.type)
    return fit(left, common), fit(right, common)


def _maplets(term: Term) -> bool:
    return isinstance(term, Apply) and term.operator == "set" and isinstance(term.type, SetType)
