"""Case distinctions: what a solver does not see at once of a conditional it mostly sees of each of its branches."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from cspcheck.checker.proof.question import Constraint
from cspcheck.checker.proof.terms import conjuncts, negation
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import BOOL, Apply, If, Term
from cspcheck.cspm.oz.values.substitution import rebuilt

_MOST_CASES = 16
_LOGICAL = ("not", "and", "or", "implies", "iff")


Total = Callable[[Term], bool]


def cases(parts: tuple[Constraint, ...], total: Total) -> list[tuple[Constraint, ...]]:
    """The parts, split over their disjunctions, implications and conditionals; one of the cases holds where they do.

    Conditionals inside of terms are split as well. Parts that are too many cases together are split as far as
    sixteen reach; none where nothing is to be split.

    Args:
        parts: the predicates.
        total: whether a predicate is defined everywhere. In the logic of Kleene one case may hold while another has
            no truth value, so a case only assumes of the others what has one.
    """
    found: list[tuple[Constraint, ...]] = [()]
    for part in parts:
        ways = list(_ways(part.term, total))
        if len(ways) == 1 or len(found) * len(ways) > _MOST_CASES:
            found = [(*case, part) for case in found]
        else:
            found = [(*case, replace(part, term=way, total=False)) for case in found for way in ways]
    return found if len(found) > 1 else []


def _ways(term: Term, total: Total) -> Iterator[Term]:
    match term:
        case Apply(operator="or", operands=operands):
            for operand in operands:
                yield from _ways(operand, total)
        case Apply(operator="implies", operands=(premise, conclusion)):
            yield negation(premise)
            for way in _ways(conclusion, total):
                yield _both(premise, way) if total(premise) else way
        case Apply(operator="not", operands=(Apply(operator="and", operands=operands),)):
            for operand in operands:
                yield negation(operand)
        case If(type=core.BoolType()):
            for way in _ways(term.then, total):
                yield _both(term.test, way)
            for way in _ways(term.otherwise, total):
                yield _both(negation(term.test), way)
        case Apply(operator="and", operands=operands):
            for position, operand in enumerate(operands):
                ways = list(_ways(operand, total))
                if len(ways) > 1:
                    for way in ways:
                        yield Apply(
                            type=BOOL, operator="and", operands=(*operands[:position], way, *operands[position + 1 :])
                        )
                    return
            yield term
        case _:
            inner = _conditional(term)
            if inner is None:
                yield term
                return
            yield _both(inner.test, _instead(term, inner, inner.then))
            yield _both(negation(inner.test), _instead(term, inner, inner.otherwise))


def _both(one: Term, other: Term) -> Term:
    return Apply(type=BOOL, operator="and", operands=(*conjuncts(one), *conjuncts(other)), span=other.span)


def _conditional(term: Term) -> If | None:
    """A conditional in an atomic predicate or its negation, which has no truth value where the test has none."""
    if isinstance(term, Apply) and term.operator == "not":
        (term,) = term.operands
    if term.type != BOOL or (isinstance(term, Apply) and term.operator in _LOGICAL):
        return None
    return _inside(term)


def _inside(term: Term) -> If | None:
    if isinstance(term, core.Quantifier | core.Comprehension):
        return None
    if isinstance(term, Apply) and term.operator in _LOGICAL:
        return None
    if isinstance(term, If):
        return term
    return next((found for part in core.parts(term) if (found := _inside(part)) is not None), None)


def _instead(term: Term, old: If, new: Term) -> Term:
    return new if term is old else rebuilt(term, lambda part: _instead(part, old, new))
