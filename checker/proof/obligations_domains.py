"""The obligation that every term is defined where it is evaluated."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from cspcheck.checker.proof.finding import Finding
from cspcheck.checker.proof.prover import ObligationReport, Prover
from cspcheck.checker.proof.question import CARRIER, Answer, Constraint, Found
from cspcheck.checker.proof.terms import member, variables_of
from cspcheck.cspm.oz.core import Operation, Term, Variable
from cspcheck.cspm.oz.writing.core_text import text, written


def applied_in_domain(prover: Prover, report: ObligationReport) -> Iterator[Finding]:
    """At each application, under what is known there: its condition."""
    situation = prover.situation
    constants = situation.all_constants()
    axioms = [part for part in constants if part.what == "axiom"]
    carriers = [part for part in constants if part.what != "axiom"]
    yield from _places(prover, report, None, carriers, axioms, ())
    invariant = situation.invariant()
    yield from _places(prover, report, None, list(situation.carriers()), list(invariant), situation.shown())
    yield from _places(prover, report, None, list(situation.state()), list(situation.initial()), situation.shown())
    for operation in prover.model.operations.values():
        yield from _operation(prover, report, operation)


def _operation(prover: Prover, report: ObligationReport, operation: Operation) -> Iterator[Finding]:
    situation = prover.situation
    known = [*situation.state(), *situation.inputs(operation)]
    guard = list(situation.guard(operation))
    shown = situation.shown(operation, after=False)
    yield from _places(prover, report, operation, known, guard, shown)
    after = [
        *guard,
        *situation.frame(operation),
        *situation.outputs(operation),
        *situation.carriers("after"),
        *[p for p in situation.invariant("after") if prover.solver.definedness.total(p.term)],
    ]
    yield from _places(prover, report, operation, [*known, *after], list(situation.effect(operation)), shown)


def _places(
    prover: Prover,
    report: ObligationReport,
    operation: Operation | None,
    known: Sequence[Constraint],
    parts: Sequence[Constraint],
    shown: Sequence[Variable],
) -> Iterator[Finding]:
    """The applications in some conjuncts; each conjunct may rely on those before it."""
    definedness = prover.solver.definedness
    for part, (term, others) in zip(parts, definedness.known([p.term for p in parts]), strict=True):
        for application in definedness.applications(term):
            premises = [*known, *[Constraint(other, "context", other.span) for other in others]]
            premises += [Constraint(condition, "context", condition.span) for condition in application.path]
            inside: list[Variable] = []
            for binder in application.binders:
                variable = Variable(type=binder.type, name=binder.name, role="bound")
                inside.append(variable)
                premises.append(Constraint(member(variable, binder.carrier), f"{CARRIER}`{binder.written}`"))
            answer = prover.refutes(premises, application.condition, (*shown, *inside))
            finding = report.universal(
                answer,
                operation,
                message=f"`{text(application.term)}` is undefined: it needs that {application.demand}",
                goal=application.condition,
                detail=f"`{text(application.term)}`",
                span=application.term.span or part.span,
            )
            yield _to_the_point(finding, answer, shown, inside, (application.term, application.condition))


def _to_the_point(
    finding: Finding, answer: Answer, shown: Sequence[Variable], inside: Sequence[Variable], terms: Sequence[Term]
) -> Finding:
    """The finding with the values of what is shown, of what the application speaks of, and of what is bound around."""
    if not isinstance(answer, Found):
        return finding
    spoken = variables_of(terms)
    kept = {written(v) for v in (*shown, *spoken.values())}
    kept |= {written(v) for v in answer.values if v.role == "constant"}
    values = {name: value for name, value in finding.values.items() if name in kept}
    for variable in inside:
        if variable in answer.values:
            values[written(variable)] = text(answer.values[variable])
    return replace(finding, values=values)
