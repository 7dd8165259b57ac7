"""Terms rebuilt with other parts: renaming and substitution."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Term


def rebuilt(term: Term, change: Callable[[Term], Term]) -> Term:
    """*term* with each of its immediate subterms changed; itself where nothing changes.

    Carriers of binders are subterms too; bound names are unique, so nothing is captured.
    """
    match term:
        case core.Construct(argument=argument) if argument is not None:
            new = change(argument)
            return term if new is argument else replace(term, argument=new)
        case core.Record(values=values):
            changed = tuple([change(value) for value in values])
            return term if _same(values, changed) else replace(term, values=changed)
        case core.Field(record=record):
            new = change(record)
            return term if new is record else replace(term, record=new)
        case core.Apply(operands=operands) if operands:
            changed = tuple([change(operand) for operand in operands])
            return term if _same(operands, changed) else replace(term, operands=changed)
        case core.Quantifier() | core.Comprehension():
            binders = tuple([_binder(binder, change) for binder in term.binders])
            condition, body = change(term.condition), change(term.body)
            if binders == term.binders and condition is term.condition and body is term.body:
                return term
            return replace(term, binders=binders, condition=condition, body=body)
        case core.If():
            parts = (change(term.test), change(term.then), change(term.otherwise))
            if _same((term.test, term.then, term.otherwise), parts):
                return term
            return replace(term, test=parts[0], then=parts[1], otherwise=parts[2])
    return term


def _binder(binder: core.Binder, change: Callable[[Term], Term]) -> core.Binder:
    carrier = change(binder.carrier)
    return binder if carrier is binder.carrier else replace(binder, carrier=carrier)


def _same(old: tuple[Term, ...], new: tuple[Term, ...]) -> bool:
    return all(a is b for a, b in zip(old, new, strict=True))


def substituted(term: Term, values: Callable[[core.Variable], Term | None]) -> Term:
    """*term* with variables replaced by what *values* gives for them (None: the variable stays)."""
    if isinstance(term, core.Variable):
        new = values(term)
        return term if new is None else new
    return rebuilt(term, lambda part: substituted(part, values))


def renamed_variables(term: Term, role: core.Role, names: Mapping[str, core.Variable]) -> Term:
    """*term* with the variables of a role replaced by name."""
    return substituted(term, lambda variable: names.get(variable.name) if variable.role == role else None)
