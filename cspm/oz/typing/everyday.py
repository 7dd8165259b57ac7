"""Everyday Z, in which functions and sequences are sets of pairs: what that means for terms that tell them apart.

Whether a relation is in a set of functions, or a function in a set of sequences, is said by its pairs (Spivey, *The Z
Notation*, 1992, chapter 4); iterates of a relation are composed; a constructor of a free type has an inverse.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import BOOL, INT, Apply, Constant, FunctionType, SetType, Term, TupleType, Type, Variable
from cspcheck.cspm.oz.typing import type_messages as messages
from cspcheck.cspm.oz.typing.typing_operators import RULES, Wrong, as_set
from cspcheck.cspm.source import Span

Bound = Callable[[str, Type, Term], core.Binder]
"""Makes a bound variable with a name of its own, of a type, from a set."""

TOTAL: Final = frozenset(["fun", "inj", "surj", "bij"])
INJECTIVE: Final = frozenset(["pinj", "inj", "bij", "finj"])
SURJECTIVE: Final = frozenset(["psurj", "surj", "bij"])
FINITE: Final = frozenset(["ffun", "finj"])
SPACES: Final = TOTAL | INJECTIVE | SURJECTIVE | FINITE | {"pfun"}
SEQUENCES: Final = frozenset(["seq", "seq1", "iseq"])


def is_by_pairs(element: Type, set_: Term) -> bool:
    """Whether membership has to be said by pairs: of a relation in a set of functions or sequences, and the like."""
    if not isinstance(set_, Apply) or not isinstance(set_.type, SetType):
        return False
    if set_.operator in SPACES:
        return isinstance(element, SetType) and element == _relation(set_.type.element)
    wanted = set_.type.element
    if set_.operator in SEQUENCES and isinstance(wanted, core.SequenceType):
        pairs = TupleType((INT, wanted.element))
        return element in (SetType(pairs), FunctionType(INT, wanted.element))
    return False


def _relation(type_: Type) -> Type:
    assert isinstance(type_, FunctionType)
    return SetType(TupleType((type_.domain, type_.range)))


def pair(first: Term, second: Term, span: Span) -> Term:
    """A tuple of two terms."""
    made = TupleType((first.type, second.type))
    return Apply(type=made, operator="tuple", operands=(first, second), span=span)


def by_pairs(term: Term, set_: Term, bound: Bound, span: Span) -> Term:
    """That a set of pairs is a function or a sequence that *set_* has, where :func:`is_by_pairs`."""
    assert isinstance(set_, Apply)
    assert isinstance(set_.type, SetType)
    pairs = as_set(term, span)
    assert isinstance(pairs.type, SetType)
    assert isinstance(pairs.type.element, TupleType)
    first, second = pairs.type.element.items
    domain = Apply(type=SetType(first), operator="dom", operands=(pairs,), span=span)
    range_ = Apply(type=SetType(second), operator="ran", operands=(pairs,), span=span)

    def said(operator: str, *operands: Term) -> Term:
        return Apply(type=BOOL, operator=operator, operands=operands, span=span)

    parts = [] if isinstance(term.type, FunctionType) else [_single(pairs, 0, bound, span)]
    if set_.operator in SEQUENCES:
        one = Constant(type=INT, value=1, span=span)
        size = Apply(type=INT, operator="card", operands=(domain,), span=span)
        parts.append(said("equal", domain, Apply(type=SetType(INT), operator="range", operands=(one, size), span=span)))
        parts.append(said("subset", range_, set_.operands[0]))
        if set_.operator == "seq1":
            parts.append(said("at_most", one, size))
        if set_.operator == "iseq":
            parts.append(_single(pairs, 1, bound, span))
        return core.conjunction(tuple(parts), span)
    source, target = set_.operands
    parts.append(said("equal" if set_.operator in TOTAL else "subset", domain, source))
    parts.append(said("equal" if set_.operator in SURJECTIVE else "subset", range_, target))
    if set_.operator in INJECTIVE:
        parts.append(_single(pairs, 1, bound, span))
    if set_.operator in FINITE:
        all_ = Apply(type=SetType(pairs.type), operator="finset", operands=(pairs,), span=span)
        parts.append(said("in", pairs, all_))
    return core.conjunction(tuple(parts), span)


def _single(pairs: Term, end: int, bound: Bound, span: Span) -> Term:
    """No two pairs have the same first component (*end* 0) or second one (1)."""
    assert isinstance(pairs.type, SetType)
    assert isinstance(pairs.type.element, TupleType)
    binders = [bound(name, pairs.type.element, pairs) for name in ("p", "q")]
    items = [
        [_item(Variable(type=b.type, name=b.name, role="bound", span=span), i, span) for b in binders] for i in (0, 1)
    ]
    same, other = [Apply(type=BOOL, operator="equal", operands=tuple(items[i]), span=span) for i in (end, 1 - end)]
    return core.Quantifier(type=BOOL, kind="forall", binders=tuple(binders), condition=same, body=other, span=span)


def _item(pair: Term, index: int, span: Span) -> Term:
    assert isinstance(pair.type, TupleType)
    place = Constant(type=INT, value=index)
    return Apply(type=pair.type.items[index], operator="item", operands=(pair, place), span=span)


def component(tuple_: Term, number: int, span: Span) -> Term | None:
    """``t.1``: a component of a tuple, counted from 1; None if it has no such one."""
    assert isinstance(tuple_.type, TupleType)
    return _item(tuple_, number - 1, span) if 0 < number <= len(tuple_.type.items) else None


MOST_ITERATIONS: Final = 32
"""How often a relation is composed with itself at most."""


def is_iteration(operands: list[Term]) -> bool:
    """Whether ``r ^ n`` is an iterate of a relation and not a concatenation."""
    left, right = operands
    return isinstance(left.type, FunctionType | SetType) and right.type == INT


def iterated(operands: list[Term], span: Span) -> Term:
    """``r ^ n`` for a number that is written out: composed with itself, for a negative one its inverse.

    Raises:
        Wrong: the number is not known, or the relation does not lead back to where it begins.
    """
    relation, number = operands
    if not isinstance(number, Constant) or not isinstance(number.value, int) or abs(number.value) > MOST_ITERATIONS:
        raise Wrong(messages.iteration_not_known(span))
    if number.value < 0:
        relation = RULES["inverse"]("inverse", [relation], span)
    if number.value == 0:
        field = [RULES[end](end, [relation], span) for end in ("dom", "ran")]
        # The identity on the whole type, as Z has it.
        element = field[0].type
        if field[0].type != field[1].type or not isinstance(element, SetType):
            raise Wrong(messages.types_differ(str(field[0].type), str(field[1].type), span))
        from cspcheck.cspm.oz.typing.schemas import maximal

        return RULES["id"]("id", [maximal(element.element)], span)
    result = relation
    for _ in range(abs(number.value) - 1):
        result = RULES["compose"]("compose", [result, relation], span)
    return result


def constructor_function(name: str, type_: core.FreeType, carrier: Term, bound: Bound, span: Span) -> Term:
    """A constructor of a free type as the function that it is."""
    assert isinstance(carrier.type, SetType)
    binder = bound("x", carrier.type.element, carrier)
    argument = Variable(type=binder.type, name=binder.name, role="bound", span=span)
    return core.Comprehension(
        type=FunctionType(binder.type, type_),
        kind="lambda",
        binders=(binder,),
        condition=Constant(type=BOOL, value=True),
        body=core.Construct(type=type_, constructor=name, argument=argument, span=span),
        span=span,
    )


def constructed_from(name: str, type_: core.FreeType, carrier: Term, value: Term, bound: Bound, span: Span) -> Term:
    """``leaf~(t)``: what a value is made from by a constructor."""
    assert isinstance(carrier.type, SetType)
    binder = bound("x", carrier.type.element, carrier)
    argument = Variable(type=binder.type, name=binder.name, role="bound", span=span)
    made = core.Construct(type=type_, constructor=name, argument=argument, span=span)
    return core.Comprehension(
        type=binder.type,
        kind="mu",
        binders=(binder,),
        condition=Apply(type=BOOL, operator="equal", operands=(made, value), span=span),
        body=argument,
        span=span,
    )
