"""Definite descriptions (``mu``) taken out of predicates."""

from __future__ import annotations

from collections.abc import Iterator

from cspcheck.checker.proof.definedness import extreme
from cspcheck.checker.proof.terms import TRUE, implication, member, quantified, universe, variables
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import BOOL, Apply, Comprehension, Term
from cspcheck.cspm.oz.values.substitution import rebuilt

_LOGICAL = ("not", "and", "or", "implies", "iff")


def without_descriptions(term: Term) -> Term:
    """``P(mu x | p @ e)`` as ``exists x | p @ P(e)``, which says the same where there is exactly one such x."""
    if isinstance(term, core.Quantifier) or (isinstance(term, Apply) and term.operator in _LOGICAL):
        return rebuilt(term, without_descriptions)
    if isinstance(term, core.If) and term.type == BOOL:
        return rebuilt(term, without_descriptions)
    if term.type != BOOL:
        return rebuilt(term, lambda part: without_descriptions(part) if part.type == BOOL else part)
    found = _innermost(term)
    if found is None:
        return rebuilt(term, without_descriptions)
    inner = without_descriptions(_replaced(term, found, found.body))
    return quantified("exists", found.binders, without_descriptions(found.condition), inner)


def _innermost(term: Term) -> Comprehension | None:
    """A description in a term, outside all binders, that contains no other."""
    if isinstance(term, core.Quantifier):
        return None
    if isinstance(term, Comprehension):
        return term if term.kind == "mu" else None
    for part in core.parts(term):
        found = _innermost(part)
        if found is not None:
            return found
    return None


def _replaced(term: Term, old: Term, new: Term) -> Term:
    return new if term is old else rebuilt(term, lambda part: _replaced(part, old, new))


def with_extremes_described(term: Term) -> Term:
    """``min s`` and ``max s`` as descriptions, where the set is not written out."""
    term = rebuilt(term, with_extremes_described)
    if isinstance(term, Apply) and term.operator in ("min", "max"):
        collection = term.operands[0]
        if not (isinstance(collection, Apply) and collection.operator in ("set", "range")):
            binder, condition = extreme(term, collection)
            best = core.Variable(type=term.type, name=binder.name, role="bound")
            return Comprehension(type=term.type, kind="mu", binders=(binder,), condition=condition, body=best)
    return term


def plain(term: Term) -> Term:
    """A predicate that the encoder has formulas for."""
    return without_descriptions(with_extremes_described(term))


def extremes_exist(term: Term) -> Iterator[Term]:
    """That finite sets have least and greatest elements, for the sets of which a predicate says that they have."""
    if isinstance(term, core.Quantifier) and term.kind == "exists" and len(term.binders) == 1:
        (best,), condition = term.binders, term.condition
        inner = condition if isinstance(condition, core.Quantifier) else term.body
        if (
            isinstance(inner, core.Quantifier)
            and inner.kind == "forall"
            and len(inner.binders) == 1
            and inner.binders[0].carrier == best.carrier
            and not any(role == "bound" for _, role in variables(best.carrier))
            and _orders(inner, best)
        ):
            set_type = best.carrier.type
            finite = Apply(type=core.SetType(set_type), operator="finset1", operands=(universe(best.type),))
            alone = quantified("exists", term.binders, inner, TRUE)
            yield implication(member(best.carrier, finite), alone)
    for part in core.parts(term):
        yield from extremes_exist(part)


def _orders(inner: core.Quantifier, best: core.Binder) -> bool:
    """Whether ``forall y : S @ x <= y`` (or ``y <= x``) is all that is said of the extreme x of S."""
    if inner.condition != TRUE or not (isinstance(inner.body, Apply) and inner.body.operator == "at_most"):
        return False
    names = [operand.name for operand in inner.body.operands if isinstance(operand, core.Variable)]
    return sorted(names) == sorted([best.name, inner.binders[0].name])
