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
    if isinstance(term, Apply) and term.operator in ("union", "inter", "diff"):
        return _of_sets(term)
    match term:
        case Apply(
            operator="ran_restrict" | "ran_subtract" as operator,
            operands=(
                Apply(operator="override", operands=(old, Apply(operator="function", operands=(pair,)) as new)),
                chosen,
            ),
        ) if isinstance(pair, Apply) and pair.operator == "tuple":
            return _restricted(term, operator, old, new, pair, chosen)
    return term


def _restricted(term: Apply, operator: str, old: Term, new: Apply, pair: Apply, chosen: Term) -> Term:
    """``(f (+) {x |-> y}) |> b`` by whether y is in b."""
    argument, image = pair.operands
    alone = Apply(type=core.SetType(argument.type), operator="set", operands=(argument,))
    others = Apply(type=old.type, operator="dom_subtract", operands=(alone, old))
    rest = Apply(type=term.type, operator=operator, operands=(others, chosen))
    with_it = Apply(type=term.type, operator="override", operands=(rest, new))
    inside = member(image, chosen)
    both = (with_it, rest) if operator == "ran_restrict" else (rest, with_it)
    return core.If(type=term.type, test=inside, then=both[0], otherwise=both[1], span=term.span)


def _of_sets(term: Apply) -> Term:
    """A set with what is written out of it at the end of a union, where its elements are counted one by one."""
    left, right = term.operands

    def made(operator: str, one: Term, other: Term) -> Term:
        return Apply(type=term.type, operator=operator, operands=(one, other), span=term.span)

    if term.operator == "union":
        for one, other in ((left, right), (right, left)):
            if isinstance(one, Apply) and one.operator == "union" and _is_written_out(one.operands[1]):
                return made("union", _of_sets_again(made("union", one.operands[0], other)), one.operands[1])
        if _is_written_out(left) and not _is_written_out(right):
            return made("union", right, left)
        return term
    for one, other in ((left, right), (right, left)):
        distributes = term.operator == "inter" or one is left
        if distributes and isinstance(one, Apply) and one.operator == "union" and _is_written_out(one.operands[1]):
            rest, few = one.operands
            return made("union", _of_sets_again(made(term.operator, rest, other)), made(term.operator, few, other))
    return term


def _of_sets_again(term: Term) -> Term:
    assert isinstance(term, Apply)
    return _of_sets(term)


def _is_written_out(term: Term) -> bool:
    """Whether the candidates of a set are written out."""
    if not isinstance(term, Apply):
        return False
    if term.operator in ("inter", "diff"):
        return _is_written_out(term.operands[0])
    return term.operator == "set"


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
