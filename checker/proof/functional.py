"""Unions of functions that are a function, as overrides: ``f' = f union {x |-> y}`` says what f' is."""

from __future__ import annotations

from collections.abc import Iterator

from cspcheck.checker.proof.terms import (
    TRUE,
    Unknown,
    all_of,
    bound_by,
    equal,
    implication,
    member,
    quantified,
    substitute,
)
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, FunctionType, SetType, Term, Variable
from cspcheck.cspm.oz.values.substitution import rebuilt


def functional(term: Term) -> Term:
    """A predicate that says the same, with overrides and removals for unions and differences that functions equal.

    A function is the union of two exactly where these agree on what both are defined for, and it is then one
    overridden by the other. Where a term in the predicate has no value, neither has what is made of it.
    """
    term = rebuilt(term, functional)
    match term:
        case Apply(operator="equal", operands=(left, right)):
            for one, other in ((left, right), (right, left)):
                whole, built = _function(one), _built(other)
                if whole is not None and built is not None:
                    function, agreements = built
                    return all_of([equal(whole, function), *agreements])
    return term


def _function(term: Term) -> Term | None:
    """The function that a relation is as it stands."""
    match term:
        case Apply(operator="function_to_relation", operands=(function,)) if isinstance(function.type, FunctionType):
            return function
    return None


def _built(term: Term) -> tuple[Term, list[Term]] | None:
    """The function that a union or difference is, and where it is one."""
    match term:
        case Apply(operator="union", operands=(left, right)):
            before, new = _part(left), _part(right)
            if before is None or new is None:
                return None
            (one, first), (other, second) = before, new
            if _pairs(one) and not _pairs(other):
                one, other = other, one
            joined = Apply(type=one.type, operator="override", operands=(one, other), span=term.span)
            return joined, [*first, *second, *_agreement(one, other)]
        case Apply(operator="diff", operands=(left, right)):
            part, pairs = _part(left), _pairs(_function(right))
            if part is None or len(pairs) != 1:
                return None
            function, agreements = part
            argument, image = pairs[0].operands
            alone = Apply(type=SetType(argument.type), operator="set", operands=(argument,))
            less = Apply(type=function.type, operator="dom_subtract", operands=(alone, function))
            there = all_of([_inside(argument, function), equal(_applied(function, argument), image)])
            rest = core.If(type=function.type, test=there, then=less, otherwise=function, span=term.span)
            return rest, agreements
    return None


def _part(term: Term) -> tuple[Term, list[Term]] | None:
    function = _function(term)
    if function is None:
        return _built(term)
    # Two pairs with one first item are no function; of one pair that cannot be.
    if isinstance(function, Apply) and function.operator == "function":
        return (function, []) if len(function.operands) == len(_pairs(function)) == 1 else None
    return function, []


def _pairs(function: Term | None) -> tuple[Apply, ...]:
    """The pairs of a function that is written out."""
    if not isinstance(function, Apply) or function.operator != "function":
        return ()
    return tuple(
        p for p in function.operands if isinstance(p, Apply) and p.operator == "tuple" and len(p.operands) == 2
    )


def _agreement(one: Term, other: Term) -> Iterator[Term]:
    """That two functions agree on what both are defined for."""
    pairs = _pairs(other)
    if pairs:
        for pair in pairs:
            argument, image = pair.operands
            yield implication(_inside(argument, one), equal(_applied(one, argument), image))
        return
    assert isinstance(one.type, FunctionType)
    x = Variable(type=one.type.domain, name="both%", role="simple")
    binders, table = bound_by([Unknown(x, _domain(other))])
    same = implication(_inside(x, one), equal(_applied(one, x), _applied(other, x)))
    yield quantified("forall", binders, TRUE, substitute(same, table))


def _domain(function: Term) -> Term:
    assert isinstance(function.type, FunctionType)
    return Apply(type=SetType(function.type.domain), operator="dom", operands=(function,))


def _inside(argument: Term, function: Term) -> Term:
    return member(argument, _domain(function))


def _applied(function: Term, argument: Term) -> Term:
    assert isinstance(function.type, FunctionType)
    return Apply(type=function.type.range, operator="apply", operands=(function, argument))
