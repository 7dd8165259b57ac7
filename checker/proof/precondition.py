"""The precondition of an operation, computed and written in the terms of the specification.

After-values and outputs are eliminated by the one-point rule; what is left over numbers goes through the solver's
tactic ``qe`` (``cspcheck.checker.proof.elimination``). What the state
and the inputs imply anyway is left out of the answer.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from fractions import Fraction

from cspcheck.checker.proof.encode_functions import first_of
from cspcheck.checker.proof.one_point import eliminated, simplified
from cspcheck.checker.proof.prover import Prover
from cspcheck.checker.proof.question import Constraint, Impossible
from cspcheck.checker.proof.terms import (
    TRUE,
    Unknown,
    all_of,
    bound_by,
    conjuncts,
    equal,
    implication,
    integer,
    is_false,
    negation,
    quantified,
    substitute,
    variables_of,
)
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import BOOL, Apply, Constant, Operation, Term
from cspcheck.cspm.oz.values.substitution import rebuilt
from cspcheck.cspm.oz.writing.core_text import text

_QE_SECONDS = 5.0
_MOST_CASES = 16


@dataclass(frozen=True, slots=True)
class Precondition:
    """When an operation is possible.

    Attributes:
        conjuncts: over the state before, inputs and simple parameters; none: always.
        guard: conjuncts of the guard, where the operation has one; ``conjuncts`` is then when the effect is possible.
        exact: whether no quantifier over after-values or outputs is left.
    """

    conjuncts: tuple[Term, ...]
    guard: tuple[Term, ...] | None
    exact: bool


def precondition(prover: Prover, operation: Operation) -> Precondition:
    """The precondition of an operation (of the effect, where there is a guard beside it)."""
    prover.solver.begin()
    situation = prover.situation
    unknowns, parts = situation.existential(operation)
    left, terms = eliminated(unknowns, prover.solver.definedness.holding(part.term for part in parts))
    terms = tuple(tidied(term) for term in terms)
    known = [*situation.state(), *situation.inputs(operation)]
    if operation.form in ("guarded", "effect"):
        known += situation.guard(operation)
    found = _without_quantifiers(prover, known, left, terms)
    guard = None if operation.form == "com" else operation.guard
    exact = not any(isinstance(term, core.Quantifier) and term.kind == "exists" for term in found) or not left
    return Precondition(tuple(_necessary(prover, known, found)), guard, exact)


def _without_quantifiers(
    prover: Prover, known: list[Constraint], unknowns: tuple[Unknown, ...], terms: tuple[Term, ...]
) -> list[Term]:
    """``exists unknowns @ terms`` as conjuncts, without the quantifier where that can be done."""
    if not unknowns:
        return list(terms)
    keys = {unknown.key for unknown in unknowns}
    outside = [term for term in terms if variables_of([term]).keys().isdisjoint(keys)]
    inside = [term for term in terms if term not in outside]
    by_cases = _by_cases(prover, known, unknowns, inside)
    if by_cases is not None:
        return [*outside, *by_cases]
    binders, table = bound_by(unknowns)
    whole = quantified("exists", binders, TRUE, all_of(substitute(term, table) for term in inside))
    solved = prover.solver.eliminate(whole, _QE_SECONDS)
    return [*outside, *(conjuncts(solved) if solved is not None else [whole])]


def _by_cases(
    prover: Prover, known: list[Constraint], unknowns: tuple[Unknown, ...], terms: list[Term]
) -> list[Term] | None:
    """``exists unknowns @ terms`` as implications, one for each case of the conditions that terms have.

    None where there are no cases, too many, or one that still needs a quantifier.
    """
    keys = {unknown.key for unknown in unknowns}
    found: list[Term] = []
    todo: list[tuple[list[Term], tuple[Unknown, ...], list[Term]]] = [([], unknowns, terms)]
    leaves = 0
    while todo:
        case, left, parts = todo.pop()
        split = next((c for part in parts if (c := _condition(part, keys)) is not None), None)
        if split is None:
            leaves += 1
            if leaves > _MOST_CASES or not case:
                return None
            if left:
                binders, table = bound_by(left)
                body = all_of(substitute(part, table) for part in parts)
                solved = prover.solver.eliminate(quantified("exists", binders, TRUE, body), _QE_SECONDS)
                if solved is None:
                    return None
                parts = [solved]
            premises = [*known, *[Constraint(term, "case") for term in case]]
            rest = _necessary(prover, premises, list(conjuncts(tidied(all_of(parts)))))
            found.append(implication(all_of(_brief(prover, known, case)), all_of(rest)))
            continue
        for condition in (negation(split), split):
            premises = [*known, *[Constraint(term, "case") for term in (*case, condition)]]
            if isinstance(prover.find(premises), Impossible):
                continue
            chosen = [_chosen(part, split, condition is split) for part in parts]
            todo.append(([*case, condition], *_listed(eliminated(left, chosen))))
    return found


def _listed(result: tuple[tuple[Unknown, ...], tuple[Term, ...]]) -> tuple[tuple[Unknown, ...], list[Term]]:
    return result[0], list(result[1])


def _condition(part: Term, keys: set[tuple[str, str]]) -> Term | None:
    """What decides whether a conjunct speaks of an unknown."""
    match part:
        case Apply(operator="implies", operands=(condition, _)) | core.If(test=condition):
            pass
        case Apply(operator="equal", operands=(_, core.If(test=condition))):
            pass
        case Apply(operator="equal", operands=(core.If(test=condition), _)):
            pass
        case _:
            return None
    return condition if variables_of([condition]).keys().isdisjoint(keys) else None


def _chosen(part: Term, split: Term, truth: bool) -> Term:
    """A conjunct in the case that a condition has a truth value."""

    def decided(term: Term) -> Term:
        if term == split:
            return Constant(type=BOOL, value=truth)
        return rebuilt(term, decided)

    return simplified(decided(part))


def _brief(prover: Prover, known: list[Constraint], case: list[Term]) -> list[Term]:
    """The conditions of a case that do not follow from the others; negated ones go first."""
    kept = list(case)
    for term in sorted(case, key=lambda t: not (isinstance(t, Apply) and t.operator == "not")):
        others = [Constraint(other, "case") for other in kept if other is not term]
        if isinstance(prover.refutes([*known, *others], term), Impossible):
            kept = [other for other in kept if other is not term]
    return kept


def tidied(term: Term) -> Term:
    """A conjunct that is known to be defined, with lengths and domains worked out."""
    return simplified(_tidied(term))


def _tidied(term: Term) -> Term:
    term = rebuilt(term, _tidied)
    match term:
        case Apply(operator="length", operands=(Apply(operator="concat", operands=(left, right)),)):
            return _sum(_tidied(replace(term, operands=(left,))), _tidied(replace(term, operands=(right,))))
        case Apply(operator="length", operands=(Apply(operator="sequence", operands=items),)):
            return integer(len(items))
        case Apply(operator="length", operands=(Apply(operator="tail" | "front", operands=(inner,)),)):
            return _sum(_tidied(replace(term, operands=(inner,))), integer(-1))
        case Apply(operator="length", operands=(Apply(operator="rev", operands=(inner,)),)):
            return replace(term, operands=(inner,))
        case Apply(operator="at_most" | "less" | "equal" as operator, operands=(left, right)):
            return compared(operator, left, right)
        case Apply(operator="in", operands=(Apply() as number, Apply(operator="range", operands=(low, high)))):
            return all_of([compared("at_most", low, number), compared("at_most", number, high)])
        case Apply(operator="in", operands=(number, Apply(operator="Nat"))) if isinstance(number, Apply):
            return compared("at_most", integer(0), number)
        case Apply(operator="dom", operands=(Apply(operator="override", operands=(old, new)),)):
            both = tuple(_tidied(replace(term, operands=(part,))) for part in (old, new))
            return Apply(type=term.type, operator="union", operands=both)
        case Apply(operator="dom", operands=(Apply(operator="dom_subtract", operands=(removed, old)),)):
            return Apply(type=term.type, operator="diff", operands=(_tidied(replace(term, operands=(old,))), removed))
        case Apply(operator="dom", operands=(Apply(operator="function", operands=pairs),)):
            return Apply(type=term.type, operator="set", operands=tuple(first_of(pair) for pair in pairs))
        case Apply(operator="equal", operands=(Apply(operator="concat", operands=(left, right)), nothing)) if (
            isinstance(nothing, Apply) and nothing.operator == "sequence" and not nothing.operands
        ):
            return all_of([_tidied(equal(left, nothing)), _tidied(equal(right, nothing))])
    return term


def _sum(left: Term, right: Term) -> Term:
    return Apply(type=core.INT, operator="plus", operands=(left, right))


def opposite(term: Term) -> Term:
    """The negation, with comparisons turned round."""
    if isinstance(term, Apply) and term.operator in ("at_most", "less"):
        left, right = term.operands
        return compared("less" if term.operator == "at_most" else "at_most", right, left)
    return negation(term)


def compared(operator: str, left: Term, right: Term) -> Term:
    """A comparison with what is subtracted moved to the other side: ``x - y >= 0`` is ``y <= x``."""
    positive: list[Term] = []
    negative: list[Term] = []
    if left.type not in (core.INT, core.REAL):
        return Apply(type=BOOL, operator=operator, operands=(left, right))
    if operator == "equal" and isinstance(left, Constant):
        left, right = right, left
    if operator == "equal" and not _is_sum(left) and not _is_sum(right):
        return Apply(type=BOOL, operator=operator, operands=(left, right))
    total = _collect(left, 1, positive, negative) + _collect(right, -1, positive, negative)
    for term in list(positive):
        if term in negative:
            positive.remove(term)
            negative.remove(term)
    if not positive and not negative:
        truth = {"equal": total == 0, "at_most": total <= 0, "less": total < 0}[operator]
        return Constant(type=BOOL, value=truth)
    sides = [_added(positive, left.type), _added(negative, left.type)]
    literal: Term | None = None
    if total:
        side = 0 if total > 0 else 1
        literal = _number(abs(total), left.type)
        sides[side] = literal if sides[side] is None else _plus(sides[side], literal)
    if operator == "at_most" and left.type == core.INT and total == 1 and sides[0] is not literal:
        # a + 1 <= b is a < b
        operator, sides[0] = "less", _added(positive, left.type)
    zero = _number(Fraction(0), left.type)
    if operator == "equal" and sides[0] is None:
        sides.reverse()
    return Apply(type=BOOL, operator=operator, operands=(sides[0] or zero, sides[1] or zero))


def _is_sum(term: Term) -> bool:
    return isinstance(term, Apply) and term.operator in ("plus", "minus", "negate")


def _number(value: Fraction, type_: core.Type) -> Constant:
    return Constant(type=type_, value=value if type_ == core.REAL else int(value))


def _collect(term: Term, sign: int, positive: list[Term], negative: list[Term]) -> Fraction:
    """Distribute the summands of *sign* times a term to two sides; the literal part is returned."""
    match term:
        case Constant(value=value):
            return sign * Fraction(str(value))
        case Apply(operator="plus", operands=(left, right)):
            return _collect(left, sign, positive, negative) + _collect(right, sign, positive, negative)
        case Apply(operator="minus", operands=(left, right)):
            return _collect(left, sign, positive, negative) + _collect(right, -sign, positive, negative)
        case Apply(operator="negate", operands=(inner,)):
            return _collect(inner, -sign, positive, negative)
        case Apply(operator="times", operands=(Constant(value=factor), inner)) if factor == -1:
            return _collect(inner, -sign, positive, negative)
        case Apply(operator="times", operands=(Constant(value=factor), inner)) if factor < 0:
            literal = _number(-Fraction(str(factor)), term.type)
            turned = Apply(type=term.type, operator="times", operands=(literal, inner))
            (negative if sign > 0 else positive).append(turned)
            return Fraction(0)
    (positive if sign > 0 else negative).append(term)
    return Fraction(0)


def _added(terms: list[Term], type_: core.Type) -> Term | None:
    result: Term | None = None
    for term in terms:
        result = term if result is None else _plus(result, term)
    return result


def _plus(left: Term | None, right: Term) -> Term:
    assert left is not None
    return Apply(type=right.type, operator="plus", operands=(left, right))


def _necessary(prover: Prover, known: Iterable[Constraint], terms: list[Term]) -> list[Term]:
    """The conjuncts that do not follow from what is known and from each other; definedness conditions go first."""
    kept = list(dict.fromkeys(part for term in terms for part in conjuncts(term)))
    if any(map(is_false, kept)):
        return [Constant(type=BOOL, value=False)]
    known = list(known)
    # The longest go first: short ones say the same more plainly.
    for term in sorted(kept, key=lambda kept_term: -len(text(kept_term))):
        others = [Constraint(other, "precondition") for other in kept if other is not term]
        if isinstance(prover.refutes([*known, *others], term), Impossible):
            kept = [other for other in kept if other is not term]
    return kept
