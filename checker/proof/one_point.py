"""The one-point rule: ``exists x @ x = e and P(x)`` is ``P(e)``.

Most preconditions and most steps of a simulation say of their after-values what they are, so that this rule, applied
before the solver sees a formula, leaves nothing for the solver's quantifiers (Woodcock and Davies, *Using Z*, 1996,
chapters 4 and 14).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from cspcheck.checker.proof.terms import (
    FALSE,
    TRUE,
    Key,
    Unknown,
    all_of,
    conjuncts,
    equal,
    is_false,
    is_true,
    key,
    member,
    negation,
    simplified_outside,
    substitute,
    universe,
    variables,
)
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Constant, Field, Record, Term, Variable
from cspcheck.cspm.oz.values.substitution import rebuilt

_NUMERIC = (core.INT, core.REAL)


def eliminated(
    unknowns: Iterable[Unknown], terms: Iterable[Term], values: list[tuple[Variable, Term]] | None = None
) -> tuple[tuple[Unknown, ...], tuple[Term, ...]]:
    """What is left of ``exists unknowns @ terms``: the unknowns that are not given by an equation, and the conjuncts.

    That the values found lie in the carriers of their unknowns is among the conjuncts. *values*, if given, takes each
    eliminated unknown with its value, which may speak of unknowns that are eliminated later.
    """
    left = list(unknowns)
    parts = _simple(terms)
    while True:
        left, parts = _split(left, parts, values)
        point = _point(left, parts)
        if point is None:
            apart = _all_taken_apart(left, parts)
            if apart is None:
                return tuple(left), tuple(parts)
            parts = apart
            continue
        unknown, value, source = point
        left.remove(unknown)
        if values is not None:
            values.append((unknown.variable, value))
        table: dict[Key, Term] = {unknown.key: value}
        remaining = [part for part in parts if part is not source]
        remaining.append(member(unknown.variable, unknown.carrier))
        left = [Unknown(other.variable, substitute(other.carrier, table)) for other in left]
        parts = _simple(substitute(part, table) for part in remaining)


def _point(unknowns: list[Unknown], parts: list[Term]) -> tuple[Unknown, Term, Term] | None:
    """An unknown with the value that one of the parts gives it; values that need no other unknown come first."""
    keys = {unknown.key: unknown for unknown in unknowns}
    later: tuple[Unknown, Term, Term] | None = None
    for part in parts:
        for variable, value in _equations(part, keys):
            inside = variables(value)
            if key(variable) in inside:
                continue
            unknown = keys[key(variable)]
            if not any(other in inside for other in keys):
                return unknown, value, part
            if later is None and not any(unknown.key in variables(o.carrier) for o in unknowns if o.key in inside):
                later = unknown, value, part
    return later


def _equations(part: Term, keys: dict[Key, Unknown]) -> Iterable[tuple[Variable, Term]]:
    """The equations ``variable = value`` that a conjunct amounts to."""
    match part:
        case Variable() if key(part) in keys:
            yield part, TRUE
        case Apply(operator="not", operands=(Variable() as variable,)) if key(variable) in keys:
            yield variable, FALSE
        case Apply(operator="equal" | "iff", operands=(left, right)):
            for one, other in ((left, right), (right, left)):
                if isinstance(one, Variable):
                    if key(one) in keys:
                        yield one, other
                elif one.type in _NUMERIC:
                    yield from _isolated(one, other, keys)


def _isolated(term: Term, value: Term, keys: dict[Key, Unknown]) -> Iterable[tuple[Variable, Term]]:
    """Solutions of ``term = value`` for an unknown that occurs in sums and differences."""
    match term:
        case Variable() if key(term) in keys:
            yield term, value
        case Apply(operator="plus", operands=(left, right)):
            yield from _isolated(left, _arithmetic("minus", value, right), keys)
            yield from _isolated(right, _arithmetic("minus", value, left), keys)
        case Apply(operator="minus", operands=(left, right)):
            yield from _isolated(left, _arithmetic("plus", value, right), keys)
            yield from _isolated(right, _arithmetic("minus", left, value), keys)
        case Apply(operator="negate", operands=(inner,)):
            yield from _isolated(inner, Apply(type=value.type, operator="negate", operands=(value,)), keys)


def _arithmetic(operator: str, left: Term, right: Term) -> Term:
    if isinstance(left, Constant) and isinstance(right, Constant):
        value = left.value + right.value if operator == "plus" else left.value - right.value
        return Constant(type=left.type, value=value)
    return Apply(type=left.type, operator=operator, operands=(left, right))


def _split(
    unknowns: list[Unknown], parts: list[Term], values: list[tuple[Variable, Term]] | None
) -> tuple[list[Unknown], list[Term]]:
    """Records and tuples whose components are spoken of, replaced by their components."""
    spoken: set[Key] = set()
    for part in parts:
        _accesses(part, spoken)
    left: list[Unknown] = []
    table: dict[Key, Term] = {}
    for unknown in unknowns:
        components = _components(unknown) if unknown.key in spoken else None
        if components is None:
            left.append(unknown)
            continue
        whole, new = components
        table[unknown.key] = whole
        if values is not None:
            values.append((unknown.variable, whole))
        left += new
        parts = [*parts, member(unknown.variable, unknown.carrier)]
    if not table:
        return unknowns, parts
    left = [Unknown(unknown.variable, substitute(unknown.carrier, table)) for unknown in left]
    return left, _simple(substitute(part, table) for part in parts)


def _components(unknown: Unknown) -> tuple[Term, list[Unknown]] | None:
    variable = unknown.variable
    match variable.type:
        case core.RecordType(fields=fields):
            named = [(f".{name}", type_) for name, type_ in fields]
        case core.TupleType(items=items):
            named = [(f".{number}", type_) for number, type_ in enumerate(items, 1)]
        case _:
            return None
    parts = [Variable(type=type_, name=variable.name + suffix, role=variable.role) for suffix, type_ in named]
    if isinstance(variable.type, core.RecordType):
        whole: Term = Record(type=variable.type, values=tuple(parts))
    else:
        whole = Apply(type=variable.type, operator="tuple", operands=tuple(parts))
    return whole, [Unknown(part, universe(part.type)) for part in parts]


def _accesses(term: Term, found: set[Key]) -> None:
    """The variables whose components are spoken of."""
    match term:
        case Field(record=Variable() as variable) | Apply(operator="item", operands=(Variable() as variable, _)):
            found.add(key(variable))
        case Apply(operator="equal", operands=(left, right)):
            for one, other in ((left, right), (right, left)):
                if isinstance(one, Variable) and _is_whole(other):
                    found.add(key(one))
    for part in core.parts(term):
        _accesses(part, found)


def _is_whole(term: Term) -> bool:
    return isinstance(term, Record) or (isinstance(term, Apply) and term.operator == "tuple")


def _simple(terms: Iterable[Term]) -> list[Term]:
    """The conjuncts, simplified; ``[false]`` where one is false."""
    found: list[Term] = []
    for term in terms:
        for part in conjuncts(simplified(term)):
            if is_false(part):
                return [FALSE]
            if not is_true(part):
                found.append(part)
    return found


def simplified(term: Term) -> Term:
    """A term that means the same: literals worked out, memberships and equations taken apart."""
    return _simplified_here(simplified_outside(rebuilt(term, simplified)))


def _simplified_here(term: Term) -> Term:
    match term:
        case Apply(operator="not", operands=(Apply(operator="or", operands=operands),)):
            return all_of(_simplified_here(negation(operand)) for operand in operands)
        case Apply(operator="not", operands=(Apply(operator="implies", operands=(left, right)),)):
            return all_of([left, _simplified_here(negation(right))])
        case Apply(operator="not", operands=(inner,)):
            return negation(inner)
        case Apply(operator="and", operands=operands):
            return all_of(operands)
        case Apply(operator="or", operands=operands):
            if any(map(is_true, operands)):
                return TRUE
            kept = tuple(operand for operand in operands if not is_false(operand))
            return _joined(term, kept)
        case Apply(operator="implies", operands=(left, right)):
            if is_false(left) or is_true(right):
                return TRUE
            if is_true(left):
                return right
            return negation(left) if is_false(right) else term
        case Apply(operator="iff", operands=(left, right)):
            for one, other in ((left, right), (right, left)):
                if isinstance(one, Constant):
                    return other if one.value else negation(other)
            return TRUE if left == right else term
        case Apply(operator="equal", operands=(left, right)):
            return _equation(term, left, right)
        case Apply(operator="in", operands=(element, carrier)):
            return _membership(term, element, carrier)
        case Apply(operator="less" | "at_most" as operator, operands=(Constant(value=left), Constant(value=right))):
            return TRUE if (left < right if operator == "less" else left <= right) else FALSE
        case core.Quantifier(kind="exists") if is_false(term.condition) or is_false(term.body):
            return FALSE
        case core.Quantifier(kind="forall") if is_false(term.condition) or is_true(term.body):
            return TRUE
    return term


def _joined(term: Apply, operands: tuple[Term, ...]) -> Term:
    if not operands:
        return FALSE
    if len(operands) == 1:
        return operands[0]
    return term if operands == term.operands else Apply(type=term.type, operator=term.operator, operands=operands)


def _equation(term: Term, left: Term, right: Term) -> Term:
    if left == right:
        return TRUE
    match left, right:
        case Constant(), Constant():
            return FALSE
        case Record(values=ours), Record(values=theirs):
            return all_of(simplified(equal(a, b)) for a, b in zip(ours, theirs, strict=True))
        case Apply(operator="tuple", operands=ours), Apply(operator="tuple", operands=theirs):
            return all_of(simplified(equal(a, b)) for a, b in zip(ours, theirs, strict=True))
        case core.Construct(), core.Construct():
            if left.constructor != right.constructor:
                return FALSE
            if left.argument is not None and right.argument is not None:
                return simplified(equal(left.argument, right.argument))
            return TRUE
        case Constant(type=core.BoolType(), value=value), _:
            return right if value else negation(right)
        case _, Constant(type=core.BoolType(), value=value):
            return left if value else negation(left)
    return term


def taken_apart(term: Term, solved: Callable[[Variable], bool]) -> Term:
    """``s = <a> ^ t`` as ``s /= <> and a = head s and t = tail s``, where *solved* variables occur in t and not in s.

    The second form says what t is. Likewise where the known items stand behind. Other terms are returned as they are.
    """
    if not isinstance(term, Apply) or term.operator != "equal":
        return term
    left, right = term.operands
    for whole, parts in ((left, right), (right, left)):
        if not isinstance(parts, Apply) or parts.operator != "concat":
            continue
        if any(map(solved, variables(whole).values())):
            continue
        for rest, display in (parts.operands, parts.operands[::-1]):
            written_out = isinstance(display, Apply) and display.operator == "sequence"
            if written_out and any(map(solved, variables(rest).values())):
                assert isinstance(display, Apply)
                return _taken_apart(whole, display, rest, front=display is parts.operands[0])
    return term


def _all_taken_apart(unknowns: list[Unknown], parts: list[Term]) -> list[Term] | None:
    """The parts with equations of sequences taken apart for the unknowns; None where there are none."""
    keys = {unknown.key for unknown in unknowns}
    apart = [taken_apart(part, lambda variable: key(variable) in keys) for part in parts]
    return None if all(a is b for a, b in zip(apart, parts, strict=True)) else _simple(apart)


def _taken_apart(whole: Term, display: Apply, rest: Term, *, front: bool) -> Term:
    found: list[Term] = []
    empty = Apply(type=whole.type, operator="sequence")
    take, drop = ("head", "tail") if front else ("last", "front")
    for item in display.operands if front else reversed(display.operands):
        found.append(negation(equal(whole, empty)))
        found.append(equal(item, Apply(type=item.type, operator=take, operands=(whole,))))
        whole = Apply(type=whole.type, operator=drop, operands=(whole,))
    return all_of([*found, equal(rest, whole)])


def _membership(term: Term, element: Term, carrier: Term) -> Term:
    if is_universe(carrier):
        return TRUE
    match carrier, element:
        case Apply(operator="set", operands=(only,)), _:
            return simplified(equal(element, only))
        case Apply(operator="set", operands=()), _:
            return FALSE
        case Apply(operator="cross", operands=carriers), Apply(operator="tuple", operands=items):
            return all_of(simplified(member(i, c)) for i, c in zip(items, carriers, strict=True))
        case Apply(operator="Nat"), Constant(value=value):
            return TRUE if value >= 0 else FALSE
        case Apply(operator="Nat1"), Constant(value=value):
            return TRUE if value >= 1 else FALSE
        case (
            Apply(operator="range", operands=(Constant(value=low), Constant(value=high))),
            Constant(value=value),
        ):
            return TRUE if low <= value <= high else FALSE
        case Apply(operator="set", operands=items), _ if element in items:
            return TRUE
    return term


def is_universe(carrier: Term) -> bool:
    """Whether a carrier has all values of its type, so that membership says nothing.

    Not so for free types: the arguments of their constructors have carriers.
    """
    if not isinstance(carrier, Apply):
        return False
    match carrier.operator:
        case "Int" | "Real" | "Bool" | "AllRecords":
            return True
        case "All":
            return isinstance(carrier.type, core.SetType) and isinstance(carrier.type.element, core.GivenType)
        case "power" | "seq" | "bag" | "cross" | "rel" | "pfun":
            return all(map(is_universe, carrier.operands))
    return False
