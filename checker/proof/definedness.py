"""Where a term is defined: functions are applied inside their domain, nothing is divided by zero, and so on.

Logic is that of Kleene, as in :mod:`cspcheck.cspm.oz.values.evaluation`: a predicate that has a truth value whatever
an undefined part of it might be has that value, whichever way round it is written. :meth:`Definedness.holding` turns
a predicate into one that is defined everywhere and true exactly where the given one is defined and true; formulas are
made from that.

That every application is defined is an obligation of its own, for each :class:`ConditionalTerm` under what is known
where it stands. A condition is a core term, so that it can be proved, evaluated and shown like any other.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from cspcheck.checker.proof.one_point import simplified
from cspcheck.checker.proof.terms import (
    TRUE,
    Unknown,
    all_of,
    any_of,
    bound_by,
    conjuncts,
    equal,
    implication,
    integer,
    is_true,
    member,
    negation,
    quantified,
    universe,
)
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import BOOL, INT, Apply, Binder, Constant, Term, Variable


@dataclass(frozen=True, slots=True)
class ConditionalTerm:
    """A place where a term is defined under a condition only.

    Attributes:
        term: the application.
        condition: under which it is defined.
        path: what holds whenever the term is evaluated: conditions of binders and of conditionals, conjuncts before.
        binders: around it, from outside to inside.
        demand: the condition in a few words.
    """

    term: Term
    condition: Term
    path: tuple[Term, ...]
    binders: tuple[Binder, ...]
    demand: str


class Definedness:
    """Conditions under which terms are defined, in one specification."""

    def __init__(self, frees: Mapping[str, core.FreeDefinition]) -> None:
        self._frees = frees

    def condition(self, term: Term) -> Term:
        """The condition under which *term* is defined, conjunctions and the like read from left to right."""
        return simplified(self._condition(term))

    def total(self, term: Term) -> bool:
        """Whether a term is defined everywhere, by the way it is written."""
        return is_true(self.condition(term))

    def holding(self, terms: Iterable[Term]) -> tuple[Term, ...]:
        """Conjuncts, defined everywhere, that all hold exactly where all of *terms* are defined and true."""
        found: list[Term] = []
        for term in terms:
            for part in conjuncts(term):
                found += [c for c in conjuncts(self._decided(part, True)) if not is_true(c)]
        return tuple(found)

    def _decided(self, term: Term, wanted: bool) -> Term:
        """That a predicate is defined and has the truth value *wanted*."""
        if self.total(term):
            return term if wanted else negation(term)
        match term:
            case Apply(operator="not", operands=(inner,)):
                return self._decided(inner, not wanted)
            case Apply(operator="and" | "or" as operator, operands=operands):
                parts = [self._decided(operand, wanted) for operand in operands]
                return all_of(parts) if (operator == "and") == wanted else any_of(parts)
            case Apply(operator="implies", operands=(left, right)):
                parts = [self._decided(left, not wanted), self._decided(right, wanted)]
                return any_of(parts) if wanted else all_of(parts)
            case core.If():
                then = all_of([self._decided(term.test, True), self._decided(term.then, wanted)])
                otherwise = all_of([self._decided(term.test, False), self._decided(term.otherwise, wanted)])
                return any_of([then, otherwise])
            case core.Quantifier(kind="forall" | "exists" as kind) if all(self.total(b.carrier) for b in term.binders):
                binders = term.binders
                if (kind == "forall") == wanted:
                    if kind == "forall":
                        inner = any_of([self._decided(term.condition, False), self._decided(term.body, True)])
                    else:
                        inner = any_of([self._decided(term.condition, False), self._decided(term.body, False)])
                    return quantified("forall", binders, TRUE, inner)
                condition = self._decided(term.condition, True)
                return quantified("exists", binders, condition, self._decided(term.body, kind == "exists"))
        return all_of([self.condition(term), term if wanted else negation(term)])

    def applications(self, term: Term) -> Iterator[ConditionalTerm]:
        """All places of a term where something is defined under a condition only, in the order of evaluation."""
        yield from self._applications(term, (), ())

    # --- conditions --------------------------------------------------------------------------------------------------

    def _condition(self, term: Term) -> Term:
        match term:
            case Apply(operator="and", operands=operands):
                return _in_turn(map(self._condition, operands), operands, conjunctive=True)
            case Apply(operator="or", operands=operands):
                return _in_turn(map(self._condition, operands), operands, conjunctive=False)
            case Apply(operator="implies", operands=(left, right)):
                return all_of([self._condition(left), implication(left, self._condition(right))])
            case core.If():
                then, otherwise = self._condition(term.then), self._condition(term.otherwise)
                branches = [implication(term.test, then), implication(negation(term.test), otherwise)]
                return all_of([self._condition(term.test), *branches])
            case core.Quantifier() | core.Comprehension():
                carriers = [self._condition(binder.carrier) for binder in term.binders]
                inner = all_of(
                    [self._condition(term.condition), implication(term.condition, self._condition(term.body))]
                )
                inside = quantified("forall", term.binders, TRUE, inner)
                return all_of([*carriers, inside, self._own(term)[0]])
        return all_of([*map(self._condition, core.parts(term)), self._own(term)[0]])

    def _own(self, term: Term) -> tuple[Term, str]:
        """The condition of the outermost operator alone, and that in words."""
        match term:
            case Apply(operator="apply", operands=(function, argument)):
                match function.type:
                    case core.FunctionType():
                        domain = Apply(type=core.SetType(argument.type), operator="dom", operands=(function,))
                        return _inside(function, argument, domain), "the argument is in the domain"
                    case core.SequenceType():
                        length = Apply(type=INT, operator="length", operands=(function,))
                        bounds = [_at_most(integer(1), argument), _at_most(argument, length)]
                        return all_of(bounds), "the index is within the sequence"
            case Apply(operator="head" | "tail" | "last" | "front", operands=(sequence,)):
                if isinstance(sequence, Apply) and sequence.operator == "sequence" and sequence.operands:
                    return TRUE, ""
                empty = Apply(type=sequence.type, operator="sequence")
                return negation(equal(sequence, empty)), "the sequence is not empty"
            case Apply(operator="divide" | "div" | "mod", operands=(_, divisor)):
                if isinstance(divisor, Apply) and divisor.operator == "int_to_real":
                    divisor = divisor.operands[0]
                if isinstance(divisor, Constant) and divisor.value:
                    return TRUE, ""
                zero = Constant(type=divisor.type, value=0)
                return negation(equal(divisor, zero)), "the divisor is not zero"
            case Apply(operator="min" | "max", operands=(collection,)):
                return _has_extreme(term, collection), "the set has such an element"
            case Apply(operator="card", operands=(collection,)):
                if _plainly_finite(collection):
                    return TRUE, ""
                finite = Apply(type=core.SetType(collection.type), operator="finset", operands=(_all(collection),))
                return member(collection, finite), "the set is finite"
            case Apply(operator="function", operands=pairs):
                return _distinct(pairs), "no argument has two values"
            case core.Construct(argument=argument) if argument is not None:
                carrier = self._argument(term)
                if carrier is None:
                    return TRUE, ""
                return simplified(member(argument, carrier)), "the argument is what the constructor takes"
            case core.Comprehension(kind="mu"):
                return quantified("exists1", term.binders, term.condition, TRUE), "there is exactly one such value"
        return TRUE, ""

    def _argument(self, term: core.Construct) -> Term | None:
        free = self._frees.get(term.type.name) if isinstance(term.type, core.FreeType) else None
        return dict(free.branches).get(term.constructor) if free is not None else None

    # --- places ------------------------------------------------------------------------------------------------------

    def known(self, operands: Sequence[Term], *, conjunctive: bool = True) -> Iterator[tuple[Term, tuple[Term, ...]]]:
        """Each operand with what is known where it matters: those before it, and later ones that are total.

        A total conjunct that is false makes the conjunction false, wherever it stands.
        """
        for position, operand in enumerate(operands):
            others = [*operands[:position], *filter(self.total, operands[position + 1 :])]
            yield operand, tuple(others if conjunctive else map(negation, others))

    def _applications(
        self, term: Term, path: tuple[Term, ...], binders: tuple[Binder, ...]
    ) -> Iterator[ConditionalTerm]:
        match term:
            case Apply(operator="and" | "or" as operator, operands=operands):
                for operand, known in self.known(operands, conjunctive=operator == "and"):
                    yield from self._applications(operand, (*path, *known), binders)
                return
            case Apply(operator="implies", operands=(left, right)):
                yield from self._applications(left, path, binders)
                yield from self._applications(right, (*path, left), binders)
                return
            case core.If():
                yield from self._applications(term.test, path, binders)
                yield from self._applications(term.then, (*path, term.test), binders)
                yield from self._applications(term.otherwise, (*path, negation(term.test)), binders)
                return
            case core.Quantifier() | core.Comprehension():
                inner = binders
                for binder in term.binders:
                    yield from self._applications(binder.carrier, path, inner)
                    inner = (*inner, binder)
                yield from self._applications(term.condition, path, inner)
                yield from self._applications(term.body, (*path, term.condition), inner)
            case _:
                for part in core.parts(term):
                    yield from self._applications(part, path, binders)
        condition, demand = self._own(term)
        condition = simplified(condition)
        if not is_true(condition):
            yield ConditionalTerm(term, condition, path, binders, demand)


def _in_turn(conditions: Iterable[Term], operands: tuple[Term, ...], *, conjunctive: bool) -> Term:
    """The condition of operands of which each is evaluated only where those before do not decide."""
    found: list[Term] = []
    before: list[Term] = []
    for condition, operand in zip(conditions, operands, strict=True):
        if not is_true(condition):
            found.append(implication(all_of(before), condition) if conjunctive else any_of([*before, condition]))
        before.append(operand)
    return all_of(found)


def _at_most(left: Term, right: Term) -> Term:
    return Apply(type=BOOL, operator="at_most", operands=(left, right))


def _inside(function: Term, argument: Term, domain: Term) -> Term:
    """That an argument is in the domain; where the function is a lambda, in the words of the lambda."""
    if isinstance(function, core.Comprehension) and len(function.binders) == 1 and is_true(function.condition):
        return simplified(member(argument, function.binders[0].carrier))
    return member(argument, domain)


def _has_extreme(term: Apply, collection: Term) -> Term:
    """That a set of numbers has a least or greatest element."""
    if isinstance(collection, Apply) and collection.operator == "set" and collection.operands:
        return TRUE
    if isinstance(collection, Apply) and collection.operator == "range":
        return _at_most(*collection.operands)
    if _plainly_finite(collection):
        return negation(equal(collection, Apply(type=collection.type, operator="set")))
    return quantified("exists", *_extreme(term, collection))


def _extreme(term: Apply, collection: Term) -> tuple[tuple[Binder, ...], Term, Term]:
    binder, condition = extreme(term, collection)
    return (binder,), condition, TRUE


def extreme(term: Apply, collection: Term) -> tuple[Binder, Term]:
    """A binder over *collection*, and the condition that it binds the least (for ``max`` the greatest) element."""

    def unknown(name: str) -> Unknown:
        return Unknown(Variable(type=term.type, name=name, role="bound"), collection)

    binders, table = bound_by([unknown("m"), unknown("n")])
    best, other = (table[name, "bound"] for name in ("m", "n"))
    order = (best, other) if term.operator == "min" else (other, best)
    return binders[0], quantified("forall", (binders[1],), TRUE, _at_most(*order))


def _plainly_finite(term: Term) -> bool:
    """Whether a set is finite by the way it is written."""
    if not isinstance(term, Apply):
        return False
    match term.operator:
        case "set" | "range":
            return True
        case "union":
            return all(map(_plainly_finite, term.operands))
        case "inter":
            return any(map(_plainly_finite, term.operands))
        case "diff":
            return _plainly_finite(term.operands[0])
        case "ran" | "dom" | "function_to_relation":
            inner = term.operands[0]
            return isinstance(inner, Apply) and inner.operator in (
                "sequence_to_function",
                "function",
                "bag_to_function",
            )
    return False


def _all(collection: Term) -> Term:
    assert isinstance(collection.type, core.SetType)
    return universe(collection.type.element)


def _distinct(pairs: tuple[Term, ...]) -> Term:
    """That maplets with equal first components have equal second ones."""
    found: list[Term] = []
    for i, one in enumerate(pairs):
        for other in pairs[i + 1 :]:
            found.append(implication(equal(_part(one, 0), _part(other, 0)), equal(_part(one, 1), _part(other, 1))))
    return all_of(found)


def _part(pair: Term, index: int) -> Term:
    if isinstance(pair, Apply) and pair.operator == "tuple":
        return pair.operands[index]
    assert isinstance(pair.type, core.TupleType)
    return Apply(type=pair.type.items[index], operator="item", operands=(pair, integer(index)))
