"""Formulas for logic, numbers, tuples and records."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import z3

from cspcheck.checker.proof.encode_functions import FINITE_CARRIERS, finite
from cspcheck.checker.proof.encoding_rules import value
from cspcheck.checker.proof.sorts import Expr, Unsupported
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Constant

if TYPE_CHECKING:
    from cspcheck.checker.proof.encode import Encoder


@value("not")
def _not(e: Encoder, term: Apply) -> Expr:
    return z3.Not(e.term(term.operands[0]))


@value("and")
def _and(e: Encoder, term: Apply) -> Expr:
    return e.all(e.term(operand) for operand in term.operands)


@value("or")
def _or(e: Encoder, term: Apply) -> Expr:
    return e.any(e.term(operand) for operand in term.operands)


@value("implies")
def _implies(e: Encoder, term: Apply) -> Expr:
    return z3.Implies(e.term(term.operands[0]), e.term(term.operands[1]))


@value("iff", "equal")
def _equal(e: Encoder, term: Apply) -> Expr:
    left, right = term.operands
    for sequence, other in ((left, right), (right, left)):
        if isinstance(other, Apply) and other.operator == "sequence" and not other.operands:
            assert isinstance(sequence.type, core.SequenceType)
            return e.sorts.length(sequence.type, e.term(sequence)) == 0
    return e.term(left) == e.term(right)


@value("in")
def _in(e: Encoder, term: Apply) -> Expr:
    element, carrier = term.operands
    if isinstance(carrier, Apply) and carrier.operator in FINITE_CARRIERS:
        # By the way it is written an element is known to be finite more often than by its formula alone.
        free = replace(carrier, operator=FINITE_CARRIERS[carrier.operator])
        return e.all([e.member(e.term(element), free), finite(e, element)])
    return e.member(e.term(element), carrier)


@value("less")
def _less(e: Encoder, term: Apply) -> Expr:
    return e.term(term.operands[0]) < e.term(term.operands[1])


@value("at_most")
def _at_most(e: Encoder, term: Apply) -> Expr:
    return e.term(term.operands[0]) <= e.term(term.operands[1])


@value("plus")
def _plus(e: Encoder, term: Apply) -> Expr:
    return e.term(term.operands[0]) + e.term(term.operands[1])


@value("minus")
def _minus(e: Encoder, term: Apply) -> Expr:
    return e.term(term.operands[0]) - e.term(term.operands[1])


@value("times")
def _times(e: Encoder, term: Apply) -> Expr:
    return e.term(term.operands[0]) * e.term(term.operands[1])


@value("negate")
def _negate(e: Encoder, term: Apply) -> Expr:
    return -e.term(term.operands[0])


@value("abs")
def _abs(e: Encoder, term: Apply) -> Expr:
    number = e.term(term.operands[0])
    return z3.If(number >= 0, number, -number)


@value("divide")
def _divide(e: Encoder, term: Apply) -> Expr:
    return e.term(term.operands[0]) / e.term(term.operands[1])


@value("div")
def _div(e: Encoder, term: Apply) -> Expr:
    left, right = (e.term(operand) for operand in term.operands)
    return floored(left, right, term.operands[1])


@value("mod")
def _mod(e: Encoder, term: Apply) -> Expr:
    left, right = (e.term(operand) for operand in term.operands)
    return left - right * floored(left, right, term.operands[1])


def floored(left: Expr, right: Expr, divisor: core.Term) -> Expr:
    """The quotient rounded down; the solver's own division rounds so that the remainder is not negative."""
    if isinstance(divisor, Constant):
        return left / right if divisor.value > 0 else (-left) / (-right)
    return z3.If(right > 0, left / right, (-left) / (-right))


@value("int_to_real")
def _int_to_real(e: Encoder, term: Apply) -> Expr:
    return z3.ToReal(e.term(term.operands[0]))


@value("floor")
def _floor(e: Encoder, term: Apply) -> Expr:
    return z3.ToInt(e.term(term.operands[0]))


@value("tuple")
def _tuple(e: Encoder, term: Apply) -> Expr:
    return e.sorts.make(term.type, [e.term(operand) for operand in term.operands])


@value("item")
def _item(e: Encoder, term: Apply) -> Expr:
    whole, index = term.operands
    assert isinstance(index, Constant)
    return e.sorts.part(whole.type, e.term(whole), int(index.value))


@value("init")
def _init(e: Encoder, term: Apply) -> Expr:
    record = term.operands[0]
    assert isinstance(record.type, core.RecordType)
    definition = e.sorts.record(record.type)
    if definition is None or definition.initial is None:
        raise Unsupported(f"`{record.type}`, which has no INIT")
    formula = e.term(record)
    table = {(name, "bound"): e.sorts.part(record.type, formula, i) for i, (name, _) in enumerate(record.type.fields)}
    with e.bound(table, opened=False):
        return e.all(e.term(part) for part in definition.initial)


@value("min", "max")
def _extreme(e: Encoder, term: Apply) -> Expr:
    collection = term.operands[0]
    least = term.operator == "min"
    if isinstance(collection, Apply) and collection.operator == "range":
        return e.term(collection.operands[0 if least else 1])
    if isinstance(collection, Apply) and collection.operator == "set" and collection.operands:
        best, *others = [e.term(operand) for operand in collection.operands]
        for other in others:
            best = z3.If(other < best if least else other > best, other, best)
        return best
    # An uninterpreted function of the set; where the set has a least element, the function gives it.
    set_formula = e.term(collection)
    number_type = term.type
    sort = e.sorts.sort(number_type)
    function = e.function(term.operator, collection.type, e.sorts.sort(collection.type), sort)
    result = function(set_formula)
    e.approximated.add(term.operator)
    inside = e.member(result, collection)

    def bounds(element: Expr) -> Expr:
        there = e.member(element, collection)
        return z3.Implies(there, z3.And(inside, result <= element if least else result >= element))

    # True of every set with a least element; the query's definedness conditions leave no other.
    has = e.exists(
        number_type,
        lambda m: z3.And(
            e.member(m, collection),
            e.forall(
                number_type,
                lambda n: z3.Implies(e.member(n, collection), m <= n if least else m >= n),
                e.candidates(collection),
            ),
        ),
        e.candidates(collection),
    )
    e.fact(z3.Implies(has, z3.And(inside, e.forall(number_type, bounds, e.candidates(collection)))))
    return result
