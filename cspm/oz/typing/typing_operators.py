"""The operators and functions of the toolkit on typed terms: what each needs, and the type of what it makes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz.core import (
    BOOL,
    INT,
    REAL,
    Apply,
    BagType,
    Constant,
    FunctionType,
    SequenceType,
    SetType,
    Term,
    TupleType,
    Type,
)
from cspcheck.cspm.oz.typing import type_messages as messages
from cspcheck.cspm.oz.typing.fitting import UNKNOWN, Misfit, fit, fit_both, join
from cspcheck.cspm.source import Span


class Wrong(Exception):
    """A mistake in a term."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic


def alike(left: Term, right: Term, span: Span) -> tuple[Term, Term]:
    """Two terms with one type.

    Raises:
        Wrong: they have none in common.
    """
    try:
        return fit_both(left, right)
    except Misfit:
        raise Wrong(messages.types_differ(str(left.type), str(right.type), span)) from None


def coerced(term: Term, wanted: Type, span: Span) -> Term:
    """*term* with the type *wanted*.

    Raises:
        Wrong: it cannot have it.
    """
    try:
        return fit(term, wanted)
    except Misfit:
        raise Wrong(messages.types_differ(str(term.type), str(wanted), term.span or span)) from None


def numbers(left: Term, right: Term, span: Span) -> tuple[Term, Term]:
    """Two numbers of one type.

    Raises:
        Wrong: one is no number.
    """
    return alike(number(left, span), number(right, span), span)


def number(term: Term, span: Span) -> Term:
    """*term*, which must be a number.

    Raises:
        Wrong: it is none.
    """
    if term.type not in (INT, REAL):
        raise Wrong(messages.wrong_operand("a number", str(term.type), term.span or span))
    return term


def as_set(term: Term, span: Span) -> Term:
    """*term* as a set; functions and sequences are sets of pairs.

    Raises:
        Wrong: it is none.
    """
    match term.type:
        case SetType():
            return term
        case FunctionType(domain, range_):
            return fit(term, SetType(TupleType((domain, range_))))
        case SequenceType(element):
            return fit(term, SetType(TupleType((INT, element))))
    raise Wrong(messages.no_set(str(term.type), term.span or span))


def must_be(term: Term, kind: type[SequenceType] | type[BagType], words: str, span: Span) -> Term:
    """*term*, which must be a sequence or a bag; *words* say so.

    Raises:
        Wrong: it is something else.
    """
    if isinstance(term.type, kind):
        return term
    if isinstance(term, Apply) and term.operator == "set" and not term.operands:
        return fit(term, kind(UNKNOWN))
    raise Wrong(messages.wrong_operand(words, str(term.type), term.span or span))


def element_of(set_: Term) -> Type:
    """The type of the elements of a set."""
    assert isinstance(set_.type, SetType)
    return set_.type.element


def _ends(type_: Type) -> tuple[Type, Type]:
    match type_:
        case FunctionType(domain, range_) | SetType(TupleType((domain, range_))):
            return domain, range_
    raise AssertionError(type_)


def _items(term: Term) -> tuple[Term, ...]:
    """The components of a tuple."""
    if isinstance(term, Apply) and term.operator == "tuple":
        return term.operands
    assert isinstance(term.type, TupleType)
    return tuple(
        [
            Apply(type=t, operator="item", operands=(term, Constant(type=INT, value=i)), span=term.span)
            for i, t in enumerate(term.type.items)
        ]
    )


def partition(left: Term, right: Term, span: Span) -> Term:
    """``<A, B> partition C``: the parts, written out as a sequence, are disjoint and make up the whole."""
    if not isinstance(left, Apply) or left.operator != "sequence":
        raise Wrong(messages.partition_of_no_display(span))
    whole = as_set(right, span)
    sets = tuple([coerced(item, whole.type, span) for item in left.operands])
    return Apply(type=BOOL, operator="partition", operands=(whole, *sets), span=span)


def _arithmetic(name: str, operands: list[Term], span: Span) -> Term:
    left, right = numbers(operands[0], operands[1], span)
    return Apply(type=left.type, operator=name, operands=(left, right), span=span)


def _quotient(name: str, operands: list[Term], span: Span) -> Term:
    wanted = REAL if name == "divide" else INT
    fitted = tuple([coerced(operand, wanted, span) for operand in operands])
    return Apply(type=wanted, operator=name, operands=fitted, span=span)


def _negation(name: str, operands: list[Term], span: Span) -> Term:
    operand = number(operands[0], span)
    match operand:
        case Constant(value=int() as value):
            return Constant(type=operand.type, value=-value, span=span)
        case Constant(value=value):
            return Constant(type=operand.type, value=-value, span=span)
    return Apply(type=operand.type, operator="negate", operands=(operand,), span=span)


def _size(name: str, operands: list[Term], span: Span) -> Term:
    operand = operands[0]
    if isinstance(operand.type, SequenceType):
        return Apply(type=INT, operator="length", operands=(operand,), span=span)
    return Apply(type=INT, operator="card", operands=(as_set(operand, span),), span=span)


def _integers(name: str, operands: list[Term], span: Span) -> Term:
    fitted = tuple([coerced(operand, INT, span) for operand in operands])
    return Apply(type=SetType(INT), operator="range", operands=fitted, span=span)


def _maplet(name: str, operands: list[Term], span: Span) -> Term:
    items = TupleType(tuple([operand.type for operand in operands]))
    return Apply(type=items, operator="tuple", operands=tuple(operands), span=span)


def _sets(name: str, operands: list[Term], span: Span) -> Term:
    left, right = alike(operands[0], operands[1], span)
    if isinstance(left.type, FunctionType) and name in ("inter", "diff"):
        pass  # a part of a function is one
    else:
        left, right = as_set(left, span), as_set(right, span)
    if isinstance(left.type, FunctionType):
        relation = SetType(TupleType((left.type.domain, left.type.range)))
        left, right = coerced(left, relation, span), coerced(right, relation, span)
    return Apply(type=left.type, operator=name, operands=(left, right), span=span)


def _concatenation(name: str, operands: list[Term], span: Span) -> Term:
    left, right = alike(operands[0], operands[1], span)
    wanted: type[SequenceType] | type[BagType] = SequenceType if name == "concat" else BagType
    must_be(left, wanted, "a sequence" if name == "concat" else "a bag", span)
    return Apply(type=left.type, operator=name, operands=(left, right), span=span)


def _collection_of(name: str, operands: list[Term], span: Span) -> Term:
    operand = as_set(operands[0], span)
    element = element_of(operand)
    made: Type
    if name in ("seq", "seq1", "iseq"):
        made = SequenceType(element)
    elif name == "bag":
        made = BagType(element)
    else:
        made = SetType(element)
    return Apply(type=SetType(made), operator=name, operands=(operand,), span=span)


def _space(name: str, operands: list[Term], span: Span) -> Term:
    left, right = (as_set(operand, span) for operand in operands)
    a, b = element_of(left), element_of(right)
    made: Type = SetType(TupleType((a, b))) if name == "rel" else FunctionType(a, b)
    return Apply(type=SetType(made), operator=name, operands=(left, right), span=span)


def _distributed(name: str, operands: list[Term], span: Span) -> Term:
    operand = operands[0]
    if name == "flatten":
        outer = must_be(operand, SequenceType, "a sequence of sequences", span)
        assert isinstance(outer.type, SequenceType)
        if not isinstance(outer.type.element, SequenceType):
            raise Wrong(messages.wrong_operand("a sequence of sequences", str(operand.type), span))
        return Apply(type=outer.type.element, operator=name, operands=(outer,), span=span)
    operand = as_set(operand, span)
    inner = element_of(operand)
    if not isinstance(inner, SetType):
        raise Wrong(messages.wrong_operand("a set of sets", str(operand.type), span))
    return Apply(type=inner, operator=name, operands=(operand,), span=span)


def _disjoint(name: str, operands: list[Term], span: Span) -> Term:
    display = operands[0]
    if not isinstance(display, Apply) or display.operator != "sequence":
        raise Wrong(messages.partition_of_no_display(span))
    sets = [as_set(item, span) for item in display.operands]
    return Apply(type=BOOL, operator="disjoint", operands=tuple(sets), span=span)


def _mapping(term: Term, span: Span) -> Term:
    """A relation, or a function where it is one; sequences and bags become functions."""
    match term.type:
        case SequenceType(element):
            return fit(term, FunctionType(INT, element))
        case BagType(element):
            return fit(term, FunctionType(element, INT))
        case FunctionType() | SetType(TupleType((_, _))):
            return term
        case SetType(element) if element == UNKNOWN:
            return fit(term, SetType(TupleType((UNKNOWN, UNKNOWN))))
    raise Wrong(messages.wrong_operand("a relation or function", str(term.type), span))


def _relation(term: Term, span: Span) -> Term:
    term = _mapping(term, span)
    if isinstance(term.type, FunctionType):
        return fit(term, SetType(TupleType((term.type.domain, term.type.range))))
    return term


def _end(name: str, operands: list[Term], span: Span) -> Term:
    relation = _mapping(operands[0], span)
    domain, range_ = _ends(relation.type)
    end = domain if name == "dom" else range_
    return Apply(type=SetType(end), operator=name, operands=(relation,), span=span)


def _identity(name: str, operands: list[Term], span: Span) -> Term:
    operand = as_set(operands[0], span)
    element = element_of(operand)
    return Apply(type=SetType(TupleType((element, element))), operator="id", operands=(operand,), span=span)


def _restriction(name: str, operands: list[Term], span: Span) -> Term:
    side = 0 if name.startswith("dom") else 1
    relation = _mapping(operands[1 - side], span)
    set_ = coerced(as_set(operands[side], span), SetType(_ends(relation.type)[side]), span)
    both = (set_, relation) if side == 0 else (relation, set_)
    return Apply(type=relation.type, operator=name, operands=both, span=span)


def _composition(name: str, operands: list[Term], span: Span) -> Term:
    first, second = (_mapping(operand, span) for operand in operands)
    if name == "circ":
        first, second = second, first
    if type(first.type) is not type(second.type):
        first, second = _relation(first, span), _relation(second, span)
    (a, b), (c, d) = _ends(first.type), _ends(second.type)
    if join(b, c) is None:
        raise Wrong(messages.types_differ(str(b), str(c), span))
    made: Type = FunctionType(a, d) if isinstance(first.type, FunctionType) else SetType(TupleType((a, d)))
    return Apply(type=made, operator="compose", operands=(first, second), span=span)


def _overriding(name: str, operands: list[Term], span: Span) -> Term:
    left, right = alike(operands[0], operands[1], span)
    left, right = _mapping(left, span), _mapping(right, span)
    return Apply(type=left.type, operator="override", operands=(left, right), span=span)


def _of_relation(name: str, operands: list[Term], span: Span) -> Term:
    relation = _relation(operands[0], span)
    a, b = _ends(relation.type)
    if name != "inverse" and join(a, b) is None:
        raise Wrong(messages.types_differ(str(a), str(b), span))
    made = SetType(TupleType((b, a))) if name == "inverse" else relation.type
    return Apply(type=made, operator=name, operands=(relation,), span=span)


def _image(name: str, operands: list[Term], span: Span) -> Term:
    relation = _mapping(operands[0], span)
    a, b = _ends(relation.type)
    set_ = coerced(as_set(operands[1], span), SetType(a), span)
    return Apply(type=SetType(b), operator="image", operands=(relation, set_), span=span)


def _filtering(name: str, operands: list[Term], span: Span) -> Term:
    sequence = must_be(operands[0 if name == "filter" else 1], SequenceType, "a sequence", span)
    assert isinstance(sequence.type, SequenceType)
    set_ = as_set(operands[1 if name == "filter" else 0], span)
    set_ = coerced(set_, SetType(sequence.type.element if name == "filter" else INT), span)
    both = (sequence, set_) if name == "filter" else (set_, sequence)
    return Apply(type=sequence.type, operator=name, operands=both, span=span)


def as_function(relation: Term, span: Span) -> Term:
    """A relation that is applied: refused, as nothing says that it relates its argument to one value only.

    Raises:
        Wrong: always.
    """
    raise Wrong(messages.relation_applied(str(relation.type), span))


def toolkit_function(name: str, argument: Term, span: Span) -> Term:
    """A function of the toolkit applied to its argument.

    Raises:
        Wrong: the argument is of another kind.
    """
    if name in ("head", "last", "tail", "front", "rev", "items"):
        sequence = must_be(argument, SequenceType, "a sequence", span)
        assert isinstance(sequence.type, SequenceType)
        made: Type = sequence.type
        if name in ("head", "last"):
            made = sequence.type.element
        elif name == "items":
            made = BagType(sequence.type.element)
        return Apply(type=made, operator=name, operands=(sequence,), span=span)
    if name == "squash":
        function = _mapping(argument, span)
        if not isinstance(function.type, FunctionType) or function.type.domain != INT:
            raise Wrong(messages.wrong_operand("a function on integers", str(argument.type), span))
        return Apply(type=SequenceType(function.type.range), operator=name, operands=(function,), span=span)
    if name in ("min", "max"):
        set_ = as_set(argument, span)
        if element_of(set_) not in (INT, REAL):
            raise Wrong(messages.wrong_operand("a set of numbers", str(argument.type), span))
        return Apply(type=element_of(set_), operator=name, operands=(set_,), span=span)
    if name == "abs":
        value = number(argument, span)
        return Apply(type=value.type, operator=name, operands=(value,), span=span)
    if name == "succ":
        value = coerced(argument, INT, span)
        return Apply(type=INT, operator="plus", operands=(value, Constant(type=INT, value=1)), span=span)
    if name == "floor":
        return Apply(type=INT, operator="floor", operands=(coerced(argument, REAL, span),), span=span)
    if name == "count":
        if not isinstance(argument.type, TupleType) or not isinstance(argument.type.items[0], BagType):
            raise Wrong(messages.wrong_operand("a bag and an element", str(argument.type), span))
        bag, element = _items(argument)
        assert isinstance(bag.type, BagType)
        return Apply(type=INT, operator="count", operands=(bag, coerced(element, bag.type.element, span)))
    if not isinstance(argument.type, TupleType) or len(argument.type.items) != 2:
        raise Wrong(messages.wrong_operand("a pair", str(argument.type), span))
    return _items(argument)[0 if name == "first" else 1]


Rule = Callable[[str, list[Term], Span], Term]

RULES: Final[Mapping[str, Rule]] = {
    **dict.fromkeys(("plus", "minus", "times"), _arithmetic),
    **dict.fromkeys(("divide", "div", "mod"), _quotient),
    "negate": _negation,
    "size": _size,
    "range": _integers,
    "maplet": _maplet,
    **dict.fromkeys(("union", "inter", "diff", "symdiff"), _sets),
    **dict.fromkeys(("concat", "bag_union"), _concatenation),
    **dict.fromkeys(("power", "power1", "finset", "finset1", "seq", "seq1", "iseq", "bag"), _collection_of),
    **dict.fromkeys(("rel", "pfun", "fun", "pinj", "inj", "psurj", "surj", "bij", "ffun", "finj"), _space),
    **dict.fromkeys(("Union", "Inter", "flatten"), _distributed),
    "disjoint": _disjoint,
    "dom": _end,
    "ran": _end,
    "id": _identity,
    **dict.fromkeys(("dom_restrict", "dom_subtract", "ran_restrict", "ran_subtract"), _restriction),
    "compose": _composition,
    "circ": _composition,
    "override": _overriding,
    **dict.fromkeys(("inverse", "closure", "reflexive_closure"), _of_relation),
    "image": _image,
    **dict.fromkeys(("filter", "extract"), _filtering),
}
