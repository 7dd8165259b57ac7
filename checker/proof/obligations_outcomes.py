"""Obligations about what an operation does: its inputs, branches, outputs and changes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from cspcheck.checker.proof.finding import Finding
from cspcheck.checker.proof.one_point import simplified
from cspcheck.checker.proof.prover import ObligationReport, Prover
from cspcheck.checker.proof.question import CLAIM, Constraint, Found, Impossible
from cspcheck.checker.proof.situation import parameter_variable, second, state_variable
from cspcheck.checker.proof.terms import (
    FALSE,
    TRUE,
    all_of,
    any_of,
    conjuncts,
    equal,
    is_false,
    mentions,
    negation,
    substitute,
)
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Constant, Construct, Operation, Term, Variable
from cspcheck.cspm.oz.writing.core_text import text, written

_MOST_VALUES = 32

# --- inputs ----------------------------------------------------------------------------------------------------------


def inputs_usable(prover: Prover, report: ObligationReport, operation: Operation) -> Iterator[Finding]:
    """For each value v of a finite input: the operation can be performed with it."""
    situation = prover.situation
    if isinstance(prover.performed(operation), Impossible):
        return  # which is said by `feasible`
    for parameter in operation.parameters:
        if parameter.kind == "output":
            continue
        values = values_of_carrier(parameter.carrier, prover.specification)
        if values is None:
            continue
        variable = parameter_variable(parameter)
        for value in values:
            if _declared_away(operation, variable, value):
                continue
            parts = [*situation.step(operation), Constraint(equal(variable, value), "input")]
            answer = prover.find(parts, situation.shown(operation))
            lines = prover.lines(parts) if isinstance(answer, Impossible) else ()
            shown = f"{written(variable)} = {text(value)}"
            yield report.existential(
                answer,
                operation,
                message=f"with `{shown}` the operation can never be performed",
                detail=f"`{shown}`",
                lines=lines,
                span=parameter.span,
            )


def _declared_away(operation: Operation, variable: Variable, value: Term) -> bool:
    """Whether the operation's own declaration of a parameter leaves a value of its channel out."""
    for term in (*operation.guard, *operation.effect):
        match term:
            case Apply(operator="in", operands=(Variable() as subject, _)) if (subject.name, subject.role) == (
                variable.name,
                variable.role,
            ):
                if is_false(simplified(substitute(term, {(variable.name, variable.role): value}))):
                    return True
    return False


def values_of_carrier(carrier: Term, specification: core.Specification) -> list[Term] | None:
    """The values of a small carrier that is written out; None for any other."""
    carrier = simplified(carrier)
    if not isinstance(carrier, Apply) or not isinstance(carrier.type, core.SetType):
        return None
    element = carrier.type.element
    match carrier.operator, carrier.operands:
        case "Bool", _:
            return [FALSE, TRUE]
        case "range", (Constant(value=low), Constant(value=high)) if high - low < _MOST_VALUES:
            return [Constant(type=element, value=value) for value in range(int(low), int(high) + 1)]
        case "set", items if items and all(isinstance(item, Constant | Construct) for item in items):
            return list(items)
        case "All", _ if isinstance(element, core.FreeType):
            free = specification.frees.get(element.name)
            if free is None or len(free.branches) > _MOST_VALUES or any(a is not None for _, a in free.branches):
                return None
            return [Construct(type=element, constructor=name) for name, _ in free.branches]
    return None


# --- branches --------------------------------------------------------------------------------------------------------


def branch_reachable(prover: Prover, report: ObligationReport, operation: Operation) -> Iterator[Finding]:
    """Each antecedent, disjunct and alternative can hold together with the rest."""
    situation = prover.situation
    if isinstance(prover.performed(operation), Impossible):
        return  # which is said by `feasible`
    for term in (*operation.guard, *operation.effect):
        for part in conjuncts(term):
            for condition in branches(part):
                parts = [*situation.step(operation), Constraint(condition, "branch", condition.span or part.span)]
                answer = prover.find(parts, situation.shown(operation))
                lines = prover.lines(parts) if isinstance(answer, Impossible) else ()
                yield report.existential(
                    answer,
                    operation,
                    message=f"the branch `{text(condition)}` can never be taken",
                    detail=f"`{text(condition)}`",
                    lines=lines,
                    span=condition.span or part.span,
                )


def branches(term: Term) -> Iterator[Term]:
    """The conditions of the branches that a conjunct has."""
    match term:
        case Apply(operator="implies", operands=(premise, conclusion)):
            yield premise
            for inner in conjuncts(conclusion):
                for condition in branches(inner):
                    yield all_of([premise, condition])
        case Apply(operator="or", operands=operands):
            yield from operands
        case core.If(test=test):
            yield test
            yield negation(test)
            for condition in branches(term.then):
                yield all_of([test, condition])
            for condition in branches(term.otherwise):
                yield all_of([negation(test), condition])
        case (
            Apply(operator="equal", operands=(_, core.If(test=test)))
            | Apply(operator="equal", operands=(core.If(test=test), _))
        ):
            yield test
            yield negation(test)


# --- outcomes --------------------------------------------------------------------------------------------------------


def deterministic(prover: Prover, report: ObligationReport, operation: Operation) -> Iterator[Finding]:
    """``Op(S, in, S1, o1) and Op(S, in, S2, o2) => S1 = S2 and o1 = o2``, a finding for each variable."""
    situation = prover.situation
    step = situation.step(operation)
    again = [
        Constraint(term, part.what, part.span) for part, term in zip(step, second(p.term for p in step), strict=True)
    ]
    both = [*step, *[part for part in again if part not in step]]
    results: list[Variable] = [parameter_variable(p) for p in operation.parameters if p.kind == "output"]
    results += [state_variable(d, "after") for d in situation.variables if _may_change(prover, operation, d.name)]
    for result in results:
        other = replace(result, name=f"{result.name}%second")
        answer = prover.find([*both, Constraint(negation(equal(result, other)), CLAIM)], situation.shown(operation))
        name = written(result)
        finding = report.universal(
            answer,
            operation,
            message=f"state and inputs do not determine `{name}`",
            detail=f"`{name}`",
            span=operation.spans[0] if operation.spans else None,
        )
        if isinstance(answer, Found):
            finding = replace(finding, values=_two_outcomes(answer))
        yield finding


def _may_change(prover: Prover, operation: Operation, name: str) -> bool:
    return name in operation.delta or name in prover.situation.secondary_keys


def _two_outcomes(found: Found) -> dict[str, str]:
    """The values, with those of the second outcome behind the first."""
    first = {written(v): text(value) for v, value in found.values.items() if "%" not in v.name}
    other = {written(v): text(value) for v, value in found.values.items() if v.name.endswith("%second")}
    return {
        name: value if other.get(name, value) == value else f"{value}, or {other[name]}"
        for name, value in first.items()
    }


def output_defined(prover: Prover, report: ObligationReport, operation: Operation) -> Iterator[Finding]:
    """No output is left free: two values of it with everything else equal, and no predicate that speaks of it there."""
    situation = prover.situation
    step = situation.step(operation)
    for parameter in operation.parameters:
        if parameter.kind != "output":
            continue
        output = parameter_variable(parameter)
        own = (output.name, output.role)
        free = all_of(free_of(part, own) for term in operation.effect for part in conjuncts(term))
        if is_false(free):
            yield report.finding("proved", operation, detail=f"`{written(output)}`", span=parameter.span)
            continue
        other = replace(output, name=f"{output.name}%second")
        again = [Constraint(substitute(p.term, {own: other}), p.what, p.span) for p in step if mentions(p.term, [own])]
        parts = [*step, *again, Constraint(negation(equal(output, other)), CLAIM), Constraint(free, CLAIM)]
        answer = prover.find(parts, situation.shown(operation))
        finding = report.universal(
            answer,
            operation,
            message=f"nothing is said of `{written(output)}` here: it can be anything",
            detail=f"`{written(output)}`",
            span=parameter.span,
        )
        if isinstance(answer, Found):
            finding = replace(finding, values=_two_outcomes(answer))
        yield finding


def free_of(term: Term, own: tuple[str, str]) -> Term:
    """A condition under which a conjunct says nothing of a variable, by the way it is written."""
    if not mentions(term, [own]):
        return TRUE
    match term:
        case Apply(operator="and", operands=operands):
            return all_of(free_of(operand, own) for operand in operands)
        case Apply(operator="or", operands=operands):
            # A disjunct without the variable that holds makes the whole hold.
            return any_of(operand if not mentions(operand, [own]) else FALSE for operand in operands)
        case Apply(operator="implies", operands=(premise, conclusion)):
            if mentions(premise, [own]):
                return FALSE
            return any_of([negation(premise), free_of(conclusion, own)])
        case core.If() if not mentions(term.test, [own]):
            then = all_of([term.test, free_of(term.then, own)])
            return any_of([then, all_of([negation(term.test), free_of(term.otherwise, own)])])
    return FALSE


def delta_changes(prover: Prover, report: ObligationReport, operation: Operation) -> Iterator[Finding]:
    """``Op => x' = x`` does not hold for any x of the Delta-list."""
    situation = prover.situation
    if isinstance(prover.performed(operation), Impossible):
        return  # which is said by `feasible`
    step = situation.step(operation)
    for declared in situation.model.primary:
        if declared.name not in operation.delta:
            continue
        before, after = state_variable(declared, "before"), state_variable(declared, "after")
        changed = Constraint(negation(equal(after, before)), CLAIM)
        answer = prover.find([*step, changed], situation.shown(operation))
        yield report.existential(
            answer,
            operation,
            message=f"`{declared.name}` is in the Delta-list but never changes",
            detail=f"`{declared.name}`",
            span=operation.spans[0] if operation.spans else None,
        )
