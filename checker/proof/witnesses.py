"""Sequences and functions that are said item by item: there are such, whatever the items are.

To ``exists q : seq X @ #q = n and (forall i : 1..n @ q(i) = t(i)) and p`` a solver finds no witness, since that is a
sequence of any length. But one with these items exists for every n that is no negative number, where all t(i) are
defined; so it may be given a name, and the claim be asked of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from cspcheck.checker.proof.definedness import Definedness
from cspcheck.checker.proof.question import Constraint
from cspcheck.checker.proof.terms import (
    TRUE,
    all_of,
    conjuncts,
    equal,
    implication,
    integer,
    member,
    mentions,
    negation,
    quantified,
    substitute,
)
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import BOOL, Apply, Binder, Quantifier, Term, Variable


def with_witnesses(parts: tuple[Constraint, ...], definedness: Definedness) -> tuple[Constraint, ...] | None:
    """Parts with a name for each value that one of them denies and that is said item by item; None: there is none.

    Args:
        parts: defined everywhere.
        definedness: tells when a term is defined.
    """
    found = [part for part in parts for term in _made(part.term, definedness) for part in (replace(part, term=term),)]
    return (*parts, *found) if found else None


def _made(term: Term, definedness: Definedness) -> Iterator[Term]:
    """What is so of a value that a denied existence could have, and that it is not what was denied."""
    match term:
        case Apply(operator="not", operands=(Quantifier(kind="exists", binders=(binder,)) as denied,)):
            said = tuple(conjuncts(all_of([denied.condition, denied.body])))
            whole = _whole(binder, said)
            if whole is None:
                return
            bounds, inside, size = whole
            made = Variable(type=binder.type, name=f"{binder.name}%made", role="simple")
            items = list(_items(binder, said, made, inside, definedness))
            if not items:
                return
            defined = [quantified("forall", over, TRUE, condition) for over, condition, _ in items]
            values = [quantified("forall", over, TRUE, equation) for over, _, equation in items]
            yield implication(all_of([*bounds, *defined[:1]]), all_of([equal(_size(made), size), *values[:1]]))
            table = {(binder.name, "bound"): made}
            carrier = member(made, binder.carrier)
            yield implication(carrier, negation(all_of(substitute(part, table) for part in said)))


def _size(value: Term) -> Term:
    """The length of a sequence, the domain of a function."""
    if isinstance(value.type, core.SequenceType):
        return Apply(type=core.INT, operator="length", operands=(value,))
    assert isinstance(value.type, core.FunctionType)
    return Apply(type=core.SetType(value.type.domain), operator="dom", operands=(value,))


def _whole(binder: Binder, said: tuple[Term, ...]) -> tuple[list[Term], core.Type, Term] | None:
    """How long a sequence is said to be, or what the domain of a function: what that needs, the type of places, it."""
    if not isinstance(binder.type, core.SequenceType | core.FunctionType):
        return None
    own = (binder.name, "bound")
    size = _size(Variable(type=binder.type, name=binder.name, role="bound"))
    for part in said:
        if isinstance(part, Apply) and part.operator == "equal":
            for one, other in (part.operands, part.operands[::-1]):
                if one == size and not mentions(other, [own]):
                    if isinstance(binder.type, core.SequenceType):
                        least = Apply(type=BOOL, operator="at_most", operands=(integer(0), other))
                        return [least], core.INT, other
                    return [], binder.type.domain, other
    return None


def _items(
    binder: Binder, said: tuple[Term, ...], made: Variable, places: core.Type, definedness: Definedness
) -> Iterator[tuple[tuple[Binder, ...], Term, Term]]:
    """What is said of the items: for which places, when that is defined, and the equation where that is a place."""
    own = (binder.name, "bound")
    for part in said:
        if not (isinstance(part, Quantifier) and part.kind == "forall" and len(part.binders) == 1):
            continue
        (place,) = part.binders
        if place.type != places or part.condition != TRUE or mentions(place.carrier, [own]):
            continue
        at = Variable(type=place.type, name=place.name, role="bound")
        for equation in conjuncts(part.body):
            if not (isinstance(equation, Apply) and equation.operator == "equal"):
                continue
            for one, value in (equation.operands, equation.operands[::-1]):
                if _is_item(one, binder, at) and not mentions(value, [own]):
                    item = Apply(type=value.type, operator="apply", operands=(made, at))
                    there = _is_place(at, made)
                    yield part.binders, definedness.condition(value), implication(there, equal(item, value))


def _is_item(term: Term, binder: Binder, at: Variable) -> bool:
    match term:
        case Apply(operator="apply", operands=(Variable(name=name), argument)):
            return name == binder.name and argument == at
    return False


def _is_place(at: Variable, made: Variable) -> Term:
    if isinstance(made.type, core.FunctionType):
        return member(at, _size(made))
    low = Apply(type=BOOL, operator="at_most", operands=(integer(1), at))
    return all_of([low, Apply(type=BOOL, operator="at_most", operands=(at, _size(made)))])
