"""A question in the plainest words: quantifiers opened, results in the place of the variables that have them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from cspcheck.checker.proof.normal import normal
from cspcheck.checker.proof.question import Constraint
from cspcheck.checker.proof.terms import Key, conjuncts, key, member, negation, substitute, variables
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import BOOL, Apply, Term, Variable
from cspcheck.cspm.oz.values.substitution import rebuilt


def prepared(parts: Iterable[Constraint]) -> tuple[Constraint, ...]:
    """Parts that can be satisfied exactly where *parts* can; the values of other variables stay the same.

    What some value satisfies gets a name, and what equations say of after-values and outputs is put in their place.

    Args:
        parts: defined everywhere.
    """
    opened = [replace(part, term=term) for part in parts for term in _opened(lifted(part.term))]
    for _ in range(len(opened)):
        table = dict(_equations(opened))
        if not table:
            break
        opened = [replace(part, term=substitute(part.term, table)) for part in opened]
    return tuple(replace(part, term=normal(part.term)) for part in opened)


def _opened(term: Term) -> Iterator[Term]:
    """The conjuncts of a predicate with a name for each value that it says there is."""
    for part in conjuncts(term):
        positive = isinstance(part, core.Quantifier) and part.kind == "exists"
        match part:
            case Apply(operator="not", operands=(core.Quantifier(kind="forall") as inner,)):
                found: core.Quantifier = inner
            case core.Quantifier(kind="exists"):
                found = part
            case Apply(operator="not", operands=(Apply(operator="or", operands=operands),)):
                for operand in operands:
                    yield from _opened(negation(operand))
                continue
            case Apply(operator="not", operands=(Apply(operator="implies", operands=(left, right)),)):
                yield from _opened(left)
                yield from _opened(negation(right))
                continue
            case Apply(operator="not", operands=(Apply(operator="not", operands=(inner_,)),)):
                yield from _opened(inner_)
                continue
            case _:
                yield part
                continue
        table: dict[Key, Term] = {}
        for binder in found.binders:
            # The names of binders are unique, and so are these.
            variable = Variable(type=binder.type, name=f"{binder.name}%some", role="simple")
            yield member(variable, substitute(binder.carrier, table))
            table[binder.name, "bound"] = variable
        yield from _opened(substitute(found.condition, table))
        body = substitute(found.body, table)
        yield from _opened(body if positive else negation(body))


def _equations(parts: Iterable[Constraint]) -> Iterator[tuple[Key, Term]]:
    """One equation that says what an after-value or an output is."""
    for part in parts:
        if isinstance(part.term, Apply) and part.term.operator == "equal":
            for one, other in (part.term.operands, part.term.operands[::-1]):
                result = isinstance(one, Variable) and (one.role in ("after", "output") or one.name.endswith("%some"))
                if isinstance(one, Variable) and result and key(one) not in variables(other):
                    yield key(one), other
                    return


def lifted(term: Term) -> Term:
    """``exists x @ A or B`` as a disjunction, and with a conditional on what is not x as a conditional."""
    term = rebuilt(term, lambda part: lifted(part) if part.type == BOOL else part)
    if not (isinstance(term, core.Quantifier) and term.kind == "exists"):
        return term
    bound = {(binder.name, "bound") for binder in term.binders}
    match term.body:
        case core.If(test=test, then=then, otherwise=otherwise) if bound.isdisjoint(variables(test)):
            branches = [lifted(replace(term, body=branch)) for branch in (then, otherwise)]
            return core.If(type=BOOL, test=test, then=branches[0], otherwise=branches[1])
        case Apply(operator="or", operands=operands):
            return Apply(type=BOOL, operator="or", operands=tuple(lifted(replace(term, body=o)) for o in operands))
        case Apply(operator="and", operands=operands):
            free = [o for o in operands if bound.isdisjoint(variables(o))]
            inside = [o for o in operands if not bound.isdisjoint(variables(o))]
            split = next((o for o in inside if _splits(o, bound)), None)
            if split is not None:
                return _with_choice(term, operands, split)
            if free and inside:
                rest = lifted(replace(term, body=core.conjunction(tuple(inside))))
                return Apply(type=BOOL, operator="and", operands=(*free, rest))
    return term


def _splits(term: Term, bound: set[tuple[str, str]]) -> bool:
    match term:
        case core.If(test=test):
            return bound.isdisjoint(variables(test))
        case Apply(operator="or"):
            return True
    return False


def _with_choice(term: core.Quantifier, operands: tuple[Term, ...], split: Term) -> Term:
    """``exists x @ P and (A or B)`` with the choice outside."""

    def chosen(choice: Term) -> Term:
        body = core.conjunction(tuple(choice if o is split else o for o in operands))
        return lifted(replace(term, body=_flat(body)))

    if isinstance(split, core.If):
        return core.If(type=BOOL, test=split.test, then=chosen(split.then), otherwise=chosen(split.otherwise))
    assert isinstance(split, Apply)
    return Apply(type=BOOL, operator="or", operands=tuple(map(chosen, split.operands)))


def _flat(term: Term) -> Term:
    return core.conjunction(tuple(conjuncts(term)))
