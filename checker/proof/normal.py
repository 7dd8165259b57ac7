"""Sequences in one form, so that terms that are the same by associativity are the same to the eye."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from cspcheck.checker.proof.one_point import is_universe
from cspcheck.checker.proof.terms import TRUE, all_of, member
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Term
from cspcheck.cspm.oz.values.substitution import rebuilt


def normal(term: Term) -> Term:
    """A term with its concatenations bracketed to the left, of single items and of what is no concatenation."""
    term = rebuilt(term, normal)
    if isinstance(term, Apply) and term.operator == "in":
        return _membership(term, *term.operands)
    if isinstance(term, Apply) and isinstance(term.type, core.SequenceType) and term.operator in ("concat", "sequence"):
        return joined(tuple(items_of(term)), term)
    return term


def _membership(term: Term, element: Term, carrier: Term) -> Term:
    """What is put together is in a set of sequences or sets where its parts are."""
    if not isinstance(carrier, Apply) or not isinstance(element, Apply):
        return term
    inner = carrier.operands[0] if carrier.operands else carrier
    match carrier.operator, element:
        case "seq", Apply(operator="concat", operands=operands):
            return all_of(_membership(member(o, carrier), o, carrier) for o in operands)
        case "seq" | "power" | "finset", Apply(operator="sequence" | "set", operands=items):
            return all_of(TRUE if is_universe(inner) else member(item, inner) for item in items)
        case "power" | "finset", Apply(operator="union", operands=operands):
            return all_of(_membership(member(o, carrier), o, carrier) for o in operands)
    return term


def items_of(term: Term) -> Iterator[Term]:
    """What a sequence is a concatenation of: sequences of one item, and others."""
    match term:
        case Apply(operator="concat", operands=operands):
            for operand in operands:
                yield from items_of(operand)
        case Apply(operator="sequence", operands=items):
            for item in items:
                yield Apply(type=term.type, operator="sequence", operands=(item,))
        case _:
            yield term


def joined(items: Sequence[Term], like: Term) -> Term:
    """The concatenation of sequences; *like* is one of the same type."""
    if not items:
        return Apply(type=like.type, operator="sequence")
    result = items[0]
    for item in items[1:]:
        result = Apply(type=like.type, operator="concat", operands=(result, item), span=like.span)
    return result
