"""Working with core terms: building them, walking them, putting terms for variables."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import count
from typing import TypeAlias

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import BOOL, Apply, Binder, Constant, Quantifier, Term, Variable
from cspcheck.cspm.oz.values.substitution import rebuilt
from cspcheck.cspm.oz.writing.core_text import written

Key: TypeAlias = tuple[str, str]
"""A variable as it is looked up: name and role."""

TRUE = Constant(type=BOOL, value=True)
FALSE = Constant(type=BOOL, value=False)


def key(variable: Variable) -> Key:
    """The key of a variable."""
    return variable.name, variable.role


# --- building --------------------------------------------------------------------------------------------------------


def is_true(term: Term) -> bool:
    """Whether a term is the literal ``true``."""
    return isinstance(term, Constant) and term.value is True


def is_false(term: Term) -> bool:
    """Whether a term is the literal ``false``."""
    return isinstance(term, Constant) and term.value is False


def all_of(terms: Iterable[Term]) -> Term:
    """The conjunction, without literals."""
    kept = [part for term in terms for part in conjuncts(term) if not is_true(part)]
    if any(map(is_false, kept)):
        return FALSE
    return core.conjunction(tuple(kept))


def any_of(terms: Iterable[Term]) -> Term:
    """The disjunction, without literals."""
    kept = [term for term in terms if not is_false(term)]
    if not kept:
        return FALSE
    if any(map(is_true, kept)):
        return TRUE
    return kept[0] if len(kept) == 1 else Apply(type=BOOL, operator="or", operands=tuple(kept))


def negation(term: Term) -> Term:
    """``not term``, simplified on the outside."""
    if isinstance(term, Constant):
        return FALSE if term.value else TRUE
    if isinstance(term, Apply) and term.operator == "not":
        return term.operands[0]
    return Apply(type=BOOL, operator="not", operands=(term,), span=term.span)


def implication(premise: Term, conclusion: Term) -> Term:
    """``premise implies conclusion``, simplified on the outside."""
    if is_true(premise) or is_true(conclusion):
        return conclusion
    if is_false(premise):
        return TRUE
    if is_false(conclusion):
        return negation(premise)
    return Apply(type=BOOL, operator="implies", operands=(premise, conclusion))


def equal(left: Term, right: Term) -> Term:
    """``left = right``."""
    return Apply(type=BOOL, operator="equal", operands=(left, right))


def member(element: Term, carrier: Term) -> Term:
    """``element in carrier``."""
    return Apply(type=BOOL, operator="in", operands=(element, carrier))


def integer(value: int) -> Term:
    """An integer literal."""
    return Constant(type=core.INT, value=value)


def quantified(kind: str, binders: tuple[Binder, ...], condition: Term, body: Term) -> Term:
    """A quantifier, or its body where nothing is bound."""
    if not binders:
        return implication(condition, body) if kind == "forall" else all_of([condition, body])
    if is_true(body) and kind == "forall":
        return TRUE
    return Quantifier(type=BOOL, kind=kind, binders=binders, condition=condition, body=body)  # type: ignore[arg-type]


def universe(type_: core.Type) -> Term:
    """The set of all values of a type."""
    match type_:
        case core.BoolType():
            operator, operands = "Bool", ()
        case core.IntType():
            operator, operands = "Int", ()
        case core.RealType():
            operator, operands = "Real", ()
        case core.GivenType() | core.FreeType():
            operator, operands = "All", ()
        case core.TupleType():
            return Apply(type=core.SetType(type_), operator="cross", operands=tuple(map(universe, type_.items)))
        case core.SetType():
            return Apply(type=core.SetType(type_), operator="power", operands=(universe(type_.element),))
        case core.SequenceType():
            return Apply(type=core.SetType(type_), operator="seq", operands=(universe(type_.element),))
        case core.BagType():
            return Apply(type=core.SetType(type_), operator="bag", operands=(universe(type_.element),))
        case core.FunctionType():
            both = (universe(type_.domain), universe(type_.range))
            return Apply(type=core.SetType(type_), operator="pfun", operands=both)
        case core.RecordType():
            operator, operands = "AllRecords", ()
    return Apply(type=core.SetType(type_), operator=operator, operands=operands)


# --- walking ---------------------------------------------------------------------------------------------------------


def conjuncts(term: Term) -> Iterator[Term]:
    """The parts of a conjunction, nested ones flattened."""
    if isinstance(term, Apply) and term.operator == "and":
        for operand in term.operands:
            yield from conjuncts(operand)
    else:
        yield term


def variables(term: Term) -> dict[Key, Variable]:
    """The variables that occur, those bound inside left out, in the order of occurrence."""
    found: dict[Key, Variable] = {}
    _collect(term, frozenset(), found)
    return found


def _collect(term: Term, bound: frozenset[str], found: dict[Key, Variable]) -> None:
    if isinstance(term, Variable):
        if term.role != "bound" or term.name not in bound:
            found.setdefault(key(term), term)
        return
    if isinstance(term, core.Quantifier | core.Comprehension):
        bound = bound | {binder.name for binder in term.binders}
    for part in core.parts(term):
        _collect(part, bound, found)


def variables_of(terms: Iterable[Term]) -> dict[Key, Variable]:
    """The variables of several terms."""
    found: dict[Key, Variable] = {}
    for term in terms:
        _collect(term, frozenset(), found)
    return found


def mentions(term: Term, keys: Iterable[Key]) -> bool:
    """Whether one of the variables occurs."""
    return not variables(term).keys().isdisjoint(keys)


# --- putting terms for variables -------------------------------------------------------------------------------------


def substitute(term: Term, values: Mapping[Key, Term]) -> Term:
    """The term with *values* in the place of variables.

    Binders have names that are unique in a specification, so that nothing is captured.
    """
    if not values:
        return term
    return simplified_outside(_substitute(term, values))


def _substitute(term: Term, values: Mapping[Key, Term]) -> Term:
    if isinstance(term, Variable):
        return values.get((term.name, term.role), term)
    return simplified_outside(rebuilt(term, lambda part: _substitute(part, values)))


def simplified_outside(term: Term) -> Term:
    """The term with the access to a known record or tuple, and conditionals on a literal, worked out."""
    match term:
        case core.Field(record=core.Record() as record, name=name):
            fields = record.type.fields if isinstance(record.type, core.RecordType) else ()
            names = [field for field, _ in fields]
            return record.values[names.index(name)] if name in names else term
        case Apply(operator="item", operands=(Apply(operator="tuple", operands=items), Constant(value=index))):
            return items[int(index)]
        case core.If(test=test) if isinstance(test, Constant):
            return term.then if test.value else term.otherwise
    return term


def renamed(terms: Iterable[Term], change: Callable[[Variable], Variable | None]) -> tuple[Term, ...]:
    """The terms with other variables where *change* gives one."""
    terms = tuple(terms)
    table: dict[Key, Term] = {}
    for variable in variables_of(terms).values():
        new = change(variable)
        if new is not None:
            table[key(variable)] = new
    return tuple(substitute(term, table) for term in terms)


def primed(terms: Iterable[Term]) -> tuple[Term, ...]:
    """Predicates over a state, said of the state afterwards."""
    return renamed(terms, lambda v: replace(v, role="after") if v.role == "before" else None)


_fresh = count(1)


@dataclass(frozen=True, slots=True)
class Unknown:
    """A variable that a formula is to find a value for, with the set that the value is in."""

    variable: Variable
    carrier: Term

    @property
    def key(self) -> Key:
        """The key of the variable."""
        return key(self.variable)


def bound_by(unknowns: Iterable[Unknown]) -> tuple[tuple[Binder, ...], dict[Key, Term]]:
    """Binders with new names for *unknowns*, and what to put for these in the scope of the binders.

    The numbers behind the names are local to a process; texts never show them.
    """
    binders: list[Binder] = []
    table: dict[Key, Term] = {}
    for unknown in unknowns:
        variable = unknown.variable
        name = f"{written(variable)}%{next(_fresh)}p"
        carrier = substitute(unknown.carrier, table)
        binders.append(Binder(name, variable.type, carrier, written(variable)))
        table[unknown.key] = Variable(type=variable.type, name=name, role="bound")
    return tuple(binders), table


def element_name(type_: core.GivenType, number: int) -> Term:
    """The element of a given set with a number from 1."""
    return Variable(type=type_, name=f"{type_.name}_{number}", role="constant")
