"""Obligations about constants and states: that there are some."""

from __future__ import annotations

from collections.abc import Iterator

from checker.proof.finding import Finding
from checker.proof.prover import Prover, Report
from checker.proof.question import Impossible, Part, Question
from checker.proof.situation import speaks_of
from checker.proof.terms import TRUE, Unknown, all_of, bound_by, quantified, substitute
from cspm.oz.core import Term, Variable
from cspm.oz.core_text import text


def axioms_consistent(prover: Prover, report: Report) -> Iterator[Finding]:
    """``exists C @ Ax``."""
    situation = prover.situation
    if not situation.constants and not situation.axioms:
        return
    parts = situation.all_constants()
    shown = tuple(Variable(type=c.type, name=c.name, role="constant") for c in situation.constants)
    answer = prover.solver.ask(Question(parts, shown))
    lines = prover.lines(parts) if isinstance(answer, Impossible) else ()
    span = situation.constants[0].span if situation.constants else None
    yield report.existential(answer, message="no values of the constants satisfy all axioms", lines=lines, span=span)


def state_inhabited(prover: Prover, report: Report) -> Iterator[Finding]:
    """``exists S @ Inv``."""
    situation = prover.situation
    if not situation.variables:
        return
    answer = prover.inhabited()
    lines = prover.lines(situation.state()) if isinstance(answer, Impossible) else ()
    yield report.existential(
        answer, message="no values of the variables satisfy the invariant", lines=lines, span=prover.model.span
    )


def initialisation(prover: Prover, report: Report) -> Iterator[Finding]:
    """``exists S @ Inv and Init``."""
    situation = prover.situation
    if not situation.variables:
        return
    parts = (*situation.state(), *situation.initial())
    answer = prover.find(parts, situation.shown())
    lines = prover.lines(parts) if isinstance(answer, Impossible) else ()
    yield report.existential(
        answer, message="no state of the class satisfies INIT", lines=lines, span=prover.model.span
    )


def initial_invariant(prover: Prover, report: Report) -> Iterator[Finding]:
    """``Init => Inv``, carriers assumed; for secondary variables it is enough that they can have values."""
    situation = prover.situation
    if situation.model.initial is None:
        return
    premises = [
        *situation.carriers("before", situation.model.primary),
        *[part for part in situation.initial() if not _about_secondary(prover, part)],
    ]
    shown = tuple(Variable(type=d.type, name=d.name, role="before") for d in situation.model.primary)
    constraints = [part for part in situation.initial() if _about_secondary(prover, part)]
    for goal in invariant_goals(prover, constraints):
        answer = prover.refutes(premises, goal.term, shown)
        yield report.universal(
            answer,
            message="INIT allows values outside the invariant; they are silently left out",
            goal=goal.term,
            detail=goal.what,
            span=goal.span,
        )


def invariant_goals(prover: Prover, constraints: list[Part]) -> Iterator[Part]:
    """The invariant as goals over the state before: each conjunct without secondary variables, and one for the rest.

    Secondary variables follow the others: it is enough that they can have values, those that *constraints* allow.
    """
    situation = prover.situation
    with_secondary: list[Part] = list(constraints)
    for part in situation.invariant():
        if _about_secondary(prover, part):
            with_secondary.append(part)
        else:
            yield Part(part.term, f"`{text(part.term)}`", part.span)
    if not with_secondary:
        return
    unknowns = [
        Unknown(Variable(type=d.type, name=d.name, role="before"), d.carrier) for d in situation.model.secondary
    ]
    binders, table = bound_by(unknowns)
    body: Term = all_of(substitute(part.term, table) for part in with_secondary)
    names = ", ".join(f"`{d.name}`" for d in situation.model.secondary)
    yield Part(quantified("exists", binders, TRUE, body), f"values for {names}", with_secondary[-1].span)


def _about_secondary(prover: Prover, part: Part) -> bool:
    return speaks_of(part, [(name, "before") for name in prover.situation.secondary_keys])
