"""Quantifiers, comprehensions, lambda and mu: all find values of their bound variables with a solver."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Binder, Comprehension, Quantifier, Term, Variable
from cspcheck.cspm.oz.values.carriers import Carrier, Frame, Undefined, capped
from cspcheck.cspm.oz.values.enumeration import Enumeration, Member, membership
from cspcheck.cspm.oz.values.solving import SolutionPlan, SoughtVariable, solver
from cspcheck.cspm.oz.values.terms import conjuncts, negated, show_term
from cspcheck.cspm.oz.values.values import Graph, in_order

if TYPE_CHECKING:
    from cspcheck.cspm.oz.values.evaluation import FrameScope, TermEvaluator

Code: TypeAlias = Callable[[Frame], Any]


def unknown(binder: Binder, term: Term) -> SoughtVariable:
    """A bound variable as something to be found."""
    return SoughtVariable(binder.name, "bound", binder.carrier, binder.carrier.span or term.span)


def _some(frame: Frame) -> bool:
    return True


def quantifier(evaluator: TermEvaluator, term: Quantifier, scope: FrameScope) -> Code:
    """Code for a quantified predicate."""
    unknowns = [unknown(binder, term) for binder in term.binders]
    body = negated(term.body) if term.kind == "forall" else term.body
    found = solver(evaluator, scope, unknowns, (term.condition, body))
    found.use_readings(evaluator)
    run = found.run
    if term.kind == "exists":
        return lambda frame: run(frame, _some)
    if term.kind == "forall":
        return lambda frame: not run(frame, _some)
    slots = [scope.slot(*u.key) for u in unknowns]

    def exactly_one(frame: Frame) -> bool:
        seen: set[tuple[Any, ...]] = set()

        def take(frame: Frame) -> bool:
            seen.add(tuple([frame[slot] for slot in slots]))
            return len(seen) > 1

        run(frame, take)
        return len(seen) == 1

    return exactly_one


def comprehension(evaluator: TermEvaluator, term: Comprehension, scope: FrameScope) -> Code:
    """Code for a set, a function or the only value."""
    if term.kind == "set":
        return _set(evaluator, term, scope)
    found = solver(evaluator, scope, [unknown(binder, term) for binder in term.binders], [term.condition])
    found.use_readings(evaluator)
    body = evaluator.code(term.body, scope)
    run = found.run
    if term.kind == "lambda":
        arguments = [scope.slot(binder.name, "bound") for binder in term.binders]

        def graph(frame: Frame) -> Graph:
            result = Graph()

            def take(frame: Frame) -> bool:
                values = [frame[slot] for slot in arguments]
                result[values[0] if len(values) == 1 else tuple(values)] = body(frame)
                return False

            run(frame, take)
            return result

        return graph

    def only(frame: Frame) -> Any:
        seen: set[Any] = set()

        def take(frame: Frame) -> bool:
            seen.add(body(frame))
            return len(seen) > 1

        run(frame, take)
        if len(seen) != 1:
            why = "no value satisfies it" if not seen else "several values satisfy it"
            raise Undefined(f"`{show_term(term)}` has no value: {why}", term.span)
        return next(iter(seen))

    return only


def applied(evaluator: TermEvaluator, function: Comprehension, argument: Term, scope: FrameScope) -> Code:
    """Code for a comprehension applied at once: a lambda's domain need not be gone through for that."""
    value = evaluator.code(argument, scope)
    if function.kind != "lambda":
        graph = evaluator.code(function, scope)

        def lookup(frame: Frame) -> Any:
            try:
                return graph(frame)[value(frame)]
            except KeyError:
                raise _outside(function, argument) from None

        return lookup
    slots = [scope.slot(binder.name, "bound") for binder in function.binders]
    inside = [membership(evaluator, binder.carrier, scope) for binder in function.binders]
    condition = evaluator.predicate(function.condition, scope)
    body = evaluator.code(function.body, scope)

    def apply(frame: Frame) -> Any:
        found = value(frame)
        for slot, test, item in zip(slots, inside, found if len(slots) > 1 else (found,), strict=True):
            frame[slot] = item
            if not test(frame, item):
                raise _outside(function, argument)
        if not condition(frame):
            raise _outside(function, argument)
        return body(frame)

    return apply


def _outside(function: Comprehension, argument: Term) -> Undefined:
    return Undefined(f"`{show_term(argument)}` is outside the domain of `{show_term(function)}`", argument.span)


# --- sets ------------------------------------------------------------------------------------------------------------


def _solutions(evaluator: TermEvaluator, term: Comprehension, scope: FrameScope) -> tuple[SolutionPlan, Code]:
    """A solver for the bound variables, and code for all values of the body in order."""
    found = solver(evaluator, scope, [unknown(binder, term) for binder in term.binders], [term.condition])
    body = evaluator.code(term.body, scope)
    run = found.run

    def collect(frame: Frame) -> set[Any]:
        values: set[Any] = set()

        def take(frame: Frame) -> bool:
            values.add(body(frame))
            return False

        run(frame, take)
        return values

    return found, collect


def _set(evaluator: TermEvaluator, term: Comprehension, scope: FrameScope) -> Code:
    found, collect = _solutions(evaluator, term, scope)
    if found.exact:
        return lambda frame: frozenset(collect(frame))
    member = comprehension_member(evaluator, term, scope, False)

    def build(frame: Frame) -> Carrier:
        kept = list(frame)
        return Carrier(term, lambda v: member(kept, v), lambda: capped(in_order(collect(kept)), term), False)

    return build


def comprehension_enumeration(evaluator: TermEvaluator, term: Comprehension, scope: FrameScope) -> Enumeration:
    """A way through a set comprehension."""
    found, collect = _solutions(evaluator, term, scope)
    readings = {id(reading): reading for _, readings in found.sampled for reading in readings}
    return Enumeration(lambda frame: in_order(collect(frame)), tuple(readings.values()), found.bounded)


def comprehension_member(evaluator: TermEvaluator, term: Comprehension, scope: FrameScope, reading: bool) -> Member:
    """Whether a value is in a set comprehension."""
    first = term.binders[0]
    body = term.body
    if len(term.binders) == 1 and isinstance(body, Variable) and body.name == first.name:
        slot = scope.slot(first.name, "bound")
        inside = membership(evaluator, first.carrier, scope, reading=reading)
        condition = evaluator.predicate(term.condition, scope)

        def simple(frame: Frame, value: Any) -> bool:
            frame[slot] = value
            return inside(frame, value) and condition(frame)

        return simple
    name = f"%{len(scope.slots)}"
    slot = scope.slot(name, "bound")
    value_itself = Variable(type=body.type, name=name, role="bound")
    unknowns = [unknown(binder, term) for binder in term.binders]
    equation = Apply(type=core.BOOL, operator="equal", operands=(body, value_itself), span=body.span)
    found = solver(evaluator, scope, unknowns, [*conjuncts([term.condition]), equation])
    found.use_readings(evaluator)
    run = found.run

    def general(frame: Frame, value: Any) -> bool:
        frame[slot] = value
        return run(frame, _some)

    return general
