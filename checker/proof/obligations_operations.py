"""Obligations about operations: that they can be performed, and keep what the class promises."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from cspcheck.checker.proof.finding import Finding
from cspcheck.checker.proof.obligations_states import invariant_goals
from cspcheck.checker.proof.one_point import eliminated, is_universe
from cspcheck.checker.proof.prover import ObligationReport, Prover
from cspcheck.checker.proof.question import Constraint, Found, Impossible
from cspcheck.checker.proof.situation import parameter_variable, speaks_of, state_variable
from cspcheck.checker.proof.terms import (
    TRUE,
    Unknown,
    all_of,
    bound_by,
    is_true,
    member,
    negation,
    primed,
    quantified,
    substitute,
    variables,
)
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Declared, Operation, Term, Variable
from cspcheck.cspm.oz.writing.core_text import text, written
from cspcheck.cspm.source import Span

_MOST_ALTERNATIVES = 32
_TOTAL = ("fun", "inj", "surj", "bij")


def feasible(prover: Prover, report: ObligationReport, operation: Operation) -> Iterator[Finding]:
    """``exists S, in, S', out @ Inv and Op and F and Inv'``."""
    answer = prover.performed(operation)
    lines = prover.lines(prover.situation.step(operation)) if isinstance(answer, Impossible) else ()
    yield report.existential(
        answer, operation, message="the operation can never be performed", lines=lines, span=_span(operation)
    )


def invariant_preserved(prover: Prover, report: ObligationReport, operation: Operation) -> Iterator[Finding]:
    """``Inv and Op and F => exists S', out @ Op and F and Inv'``, carriers assumed: nothing is lost to the invariant.

    ``Inv'`` belongs to every operation, so what leads outside the invariant may be no mistake: a variable that follows
    from others is left to it, an alternative is excluded by it. A mistake is an after-state of the operation's
    predicate where none of those that it allows satisfies the invariant. Each conjunct is asked for by itself first.
    """
    situation = prover.situation
    after_secondary = [(name, "after") for name in situation.secondary_keys]
    effect = situation.effect(operation)
    premises = [
        *situation.state(),
        *situation.inputs(operation),
        *situation.guard(operation),
        *[part for part in effect if not speaks_of(part, after_secondary)],
        *situation.frame(operation),
        *situation.outputs(operation),
        *situation.carriers("after", situation.model.primary),
    ]
    shown = tuple(v for v in situation.shown(operation) if (v.name, v.role) not in after_secondary)
    changed = {
        (d.name, "after") for d in situation.variables if (d.name, "after") not in situation.unchanged(operation)
    }
    for goal in _after_goals(prover, [part for part in effect if speaks_of(part, after_secondary)]):
        # What speaks of unchanged variables alone holds as it did before.
        if not speaks_of(goal, changed) and not is_quantified(goal.term):
            continue
        answer = prover.refutes(premises, goal.term, shown)
        if not isinstance(answer, Impossible) and not _determined(prover, operation):
            broken = [*premises, prover.fails(goal.term)] if isinstance(answer, Found) else premises
            lost = prover.refutes(broken, situation.possible(operation), shown)
            if isinstance(lost, Impossible):
                said = "what it allows outside the invariant is left out" if isinstance(answer, Found) else ""
                yield report.finding("proved", operation, detail=goal.what, message=said, span=goal.span)
                continue
            answer = lost if isinstance(answer, Found) else answer
        yield report.universal(
            answer,
            operation,
            message=f"the operation breaks the invariant {goal.what}",
            goal=goal.term,
            detail=goal.what,
            span=goal.span,
        )


def _determined(prover: Prover, operation: Operation) -> bool:
    """Whether its equations give the after-values and outputs, so that there is one outcome at most."""
    unknowns, parts = prover.situation.existential(operation)
    left, _ = eliminated(unknowns, [part.term for part in parts if part.what == "effect"])
    return not left


def is_quantified(term: Term) -> bool:
    """Whether a goal quantifies over secondary variables."""
    return isinstance(term, core.Quantifier) and term.kind == "exists"


def _after_goals(prover: Prover, constraints: list[Constraint]) -> Iterator[Constraint]:
    """The goals of the invariant, said of the state afterwards; *constraints* speak of it already."""
    before = [Constraint(_unprimed(part.term, prover), part.what, part.span) for part in constraints]
    for goal in invariant_goals(prover, before):
        (term,) = _primed_goal(goal.term, prover)
        yield Constraint(term, goal.what, goal.span)


_MARK = "%was"


def _unprimed(term: Term, prover: Prover) -> Term:
    """A predicate over both states as one over the state before, with marks on what was before."""
    table: dict[tuple[str, str], Term] = {}
    for d in prover.situation.variables:
        table[d.name, "before"] = Variable(type=d.type, name=d.name + _MARK, role="before")
        table[d.name, "after"] = Variable(type=d.type, name=d.name, role="before")
    return substitute(term, table)


def _primed_goal(term: Term, prover: Prover) -> tuple[Term]:
    table: dict[tuple[str, str], Term] = {}
    for d in prover.situation.variables:
        table[d.name, "before"] = Variable(type=d.type, name=d.name, role="after")
        table[d.name + _MARK, "before"] = Variable(type=d.type, name=d.name, role="before")
    return (substitute(term, table),)


# --- carriers --------------------------------------------------------------------------------------------------------


def carrier_kept(prover: Prover, report: ObligationReport, operation: Operation) -> Iterator[Finding]:
    """What the operation says of a variable or output leaves it a value in its carrier."""
    for variable, carrier, declared in _targets(prover, operation):
        if not is_universe(carrier) and not _is_total(carrier):
            yield _kept(prover, report, operation, variable, carrier, declared, "leaves the carrier")


def total_function(prover: Prover, report: ObligationReport, operation: Operation) -> Iterator[Finding]:
    """A function that is declared total stays total."""
    for variable, carrier, declared in _targets(prover, operation):
        if _is_total(carrier):
            yield _kept(prover, report, operation, variable, carrier, declared, "is no longer what is declared,")


def _is_total(carrier: Term) -> bool:
    return isinstance(carrier, Apply) and carrier.operator in _TOTAL


def _targets(prover: Prover, operation: Operation) -> Iterator[tuple[Variable, Term, Declared]]:
    """What the operation gives values to, as far as its predicates speak of it, with the carriers."""
    situation = prover.situation
    targets: list[tuple[Variable, Term, Declared]] = [
        (state_variable(d, "after"), primed([d.carrier])[0], d)
        for d in situation.model.primary
        if d.name in operation.delta
    ]
    targets += [(parameter_variable(p), p.carrier, p) for p in operation.parameters if p.kind == "output"]
    effect = situation.effect(operation)
    for variable, carrier, declared in targets:
        if any(speaks_of(part, [(variable.name, variable.role)]) for part in effect):
            yield variable, carrier, declared


def _kept(
    prover: Prover,
    report: ObligationReport,
    operation: Operation,
    variable: Variable,
    carrier: Term,
    declared: Declared,
    what: str,
) -> Finding:
    situation = prover.situation
    effect = situation.effect(operation)
    own = (variable.name, variable.role)
    binders, table = bound_by([Unknown(variable, carrier)])
    speaking = [part for part in effect if speaks_of(part, [own])]
    goal = quantified("exists", binders, TRUE, all_of(substitute(part.term, table) for part in speaking))
    premises = [*situation.state(), *situation.inputs(operation), *situation.guard(operation), *effect]
    premises += situation.frame(operation)
    answer = prover.refutes(premises, goal, situation.shown(operation))
    name = written(variable)
    return report.universal(
        answer,
        operation,
        message=f"`{name}` {what} `{text(carrier)}`: there the operation is blocked",
        goal=member(variable, carrier),
        detail=f"`{name}`",
        span=declared.span,
    )


# --- alternatives ----------------------------------------------------------------------------------------------------


def alternative_kept(prover: Prover, report: ObligationReport, operation: Operation) -> Iterator[Finding]:
    """``Inv and alternative and F => exists S', out @ alternative and F and Inv'``, the carriers on the right alone.

    Where another alternative can be taken the operation is not blocked, and no other obligation sees that this one is.
    """
    situation = prover.situation
    for term, effect in _alternatives(operation.effect):
        taken = replace(operation, effect=effect)
        premises = [
            *situation.state(),
            *situation.inputs(operation),
            *situation.guard(operation),
            *situation.effect(taken),
            *situation.frame(operation),
        ]
        answer = prover.refutes(premises, situation.possible(taken), situation.shown(operation))
        yield report.universal(
            answer,
            operation,
            message=f"carriers or invariant cut off the alternative `{text(term)}` here",
            detail=f"`{text(term)}`",
            span=term.span,
        )


def _alternatives(effect: tuple[Term, ...]) -> Iterator[tuple[Term, tuple[Term, ...]]]:
    """The operands of disjunctions that speak of the outcome, each with the effect in which it is taken."""
    taken = 0
    for position, conjunct in enumerate(effect):
        for term, instead in _taken(conjunct):
            if any(role in ("after", "output") for _, role in variables(term)):
                taken += 1
                if taken > _MOST_ALTERNATIVES:
                    return
                yield term, (*effect[:position], instead, *effect[position + 1 :])


def _taken(term: Term) -> Iterator[tuple[Term, Term]]:
    """Each operand of the disjunctions in a predicate with the predicate in which it is the one that holds."""
    match term:
        case Apply(operator="or", operands=operands):
            for operand in operands:
                inner = list(_taken(operand))
                yield from inner or [(operand, operand)]
        case Apply(operator="and", operands=operands):
            for position, operand in enumerate(operands):
                for chosen, instead in _taken(operand):
                    yield chosen, all_of([*operands[:position], instead, *operands[position + 1 :]])
        case Apply(operator="implies", operands=(premise, conclusion)):
            for chosen, instead in _taken(conclusion):
                yield chosen, all_of([premise, instead])
        case core.If(type=core.BoolType(), test=test):
            for chosen, instead in _taken(term.then):
                yield chosen, all_of([test, instead])
            for chosen, instead in _taken(term.otherwise):
                yield chosen, all_of([negation(test), instead])


# --- guards ----------------------------------------------------------------------------------------------------------


def guard_covers_effect(prover: Prover, report: ObligationReport, operation: Operation) -> Iterator[Finding]:
    """``Inv and enable => pre effect``."""
    if operation.form not in ("guarded", "effect"):
        return
    situation = prover.situation
    premises = [*situation.state(), *situation.inputs(operation), *situation.guard(operation)]
    unknowns, parts = situation.existential(operation)
    # An effect without after-values, outputs and predicates is always possible.
    if not unknowns and all(is_true(part.term) for part in parts):
        yield report.finding("proved", operation)
        return
    goal = situation.possible(operation)
    answer = prover.refutes(premises, goal, situation.shown(operation, after=False))
    guard = "there is no guard, and" if operation.form == "effect" else "the guard holds, but"
    yield report.universal(
        answer,
        operation,
        message=f"{guard} no outcome satisfies the effect: the class diverges",
        span=_span(operation),
    )


def guard_satisfiable(prover: Prover, report: ObligationReport, operation: Operation) -> Iterator[Finding]:
    """``Inv and enable`` can hold."""
    if not operation.guard:
        return
    situation = prover.situation
    parts = [*situation.state(), *situation.inputs(operation), *situation.guard(operation)]
    answer = prover.find(parts, situation.shown(operation, after=False))
    lines = prover.lines(parts) if isinstance(answer, Impossible) else ()
    yield report.existential(
        answer, operation, message="the guard holds in no state", lines=lines, span=_first(operation.guard)
    )


def guard_not_redundant(prover: Prover, report: ObligationReport, operation: Operation) -> Iterator[Finding]:
    """``Inv => enable`` does not hold."""
    if not operation.guard or all(map(is_true, operation.guard)):
        return
    situation = prover.situation
    parts = [*situation.state(), *situation.inputs(operation), prover.fails(all_of(operation.guard))]
    answer = prover.find(parts, situation.shown(operation, after=False))
    yield report.existential(
        answer,
        operation,
        message="the guard holds in every state and for every input",
        span=_first(operation.guard),
    )


def guard_is_precondition(prover: Prover, report: ObligationReport, operation: Operation) -> Iterator[Finding]:
    """``pre effect => enable``."""
    if operation.form != "guarded" or not operation.guard:
        return
    situation = prover.situation
    step = [part for part in situation.step(operation) if part.what != "guard"]
    answer = prover.refutes(step, all_of(operation.guard), situation.shown(operation))
    yield report.universal(
        answer,
        operation,
        message="the guard refuses what the effect could do",
        goal=all_of(operation.guard),
        span=_first(operation.guard),
    )


def _span(operation: Operation) -> Span | None:
    return operation.spans[0] if operation.spans else None


def _first(terms: Iterable[Term]) -> Span | None:
    return next((term.span for term in terms if term.span is not None), None)
