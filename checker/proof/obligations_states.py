"""Obligations about constants and states: that there are some."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from fractions import Fraction

from cspcheck.checker.proof.control import control_states
from cspcheck.checker.proof.defined import without_definitions
from cspcheck.checker.proof.finding import Finding
from cspcheck.checker.proof.prover import ObligationReport, Prover
from cspcheck.checker.proof.question import Constraint, Impossible, Question
from cspcheck.checker.proof.situation import Situation, parameter_variable, speaks_of
from cspcheck.checker.proof.terms import (
    FALSE,
    TRUE,
    Key,
    Unknown,
    all_of,
    any_of,
    bound_by,
    integer,
    quantified,
    substitute,
    variables_of,
)
from cspcheck.cspm.oz.core import (
    REAL,
    Apply,
    Constant,
    Construct,
    Declared,
    FreeType,
    Operation,
    SetType,
    Specification,
    Term,
    Variable,
)
from cspcheck.cspm.oz.writing.core_text import text


def axioms_consistent(prover: Prover, report: ObligationReport) -> Iterator[Finding]:
    """``exists C @ Ax``."""
    situation = prover.situation
    if not situation.constants and not situation.axioms:
        return
    parts: tuple[Constraint, ...] = situation.all_constants()
    without = tuple(without_definitions(parts, prover.defined))
    alone = not any(
        role == "constant" and name in prover.defined for part in without for name, role in variables_of([part.term])
    )
    # Functions that are defined by recursion are there whatever the others are.
    left = [c for c in situation.constants if not alone or c.name not in prover.defined]
    parts = without if alone else parts
    shown = tuple(Variable(type=c.type, name=c.name, role="constant") for c in left)
    answer = prover.solver.ask(Question(parts, shown))
    lines = prover.lines(parts) if isinstance(answer, Impossible) else ()
    span = situation.constants[0].span if situation.constants else None
    yield report.existential(answer, message="no values of the constants satisfy all axioms", lines=lines, span=span)


def lemmas(prover: Prover, report: ObligationReport) -> Iterator[Finding]:
    """Each lemma of the class, and of the script where there is only that."""
    names = prover.model.lemmas or prover.specification.lemmas
    for name in names:
        claim = prover.claims[name]
        answer = prover.lemma(claim)
        yield report.universal(
            answer, message="the lemma does not hold", detail=f"`{name}`", span=claim.lemma.span, goal=claim.lemma.term
        )


def state_inhabited(prover: Prover, report: ObligationReport) -> Iterator[Finding]:
    """``exists S @ Inv``."""
    situation = prover.situation
    if not situation.variables:
        return
    answer = prover.inhabited()
    lines = prover.lines(situation.state()) if isinstance(answer, Impossible) else ()
    yield report.existential(
        answer, message="no values of the variables satisfy the invariant", lines=lines, span=prover.model.span
    )


def initialisation(prover: Prover, report: ObligationReport) -> Iterator[Finding]:
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


def initial_invariant(prover: Prover, report: ObligationReport) -> Iterator[Finding]:
    """``Init => Inv``, carriers assumed.

    For secondary variables, and others of which INIT says nothing, it is enough that they can have values.
    """
    situation = prover.situation
    if situation.model.initial is None:
        return
    spoken = {name for name, _ in variables_of(part.term for part in situation.initial())}
    following = [d for d in situation.variables if d in situation.model.secondary or d.name not in spoken]
    leading = [d for d in situation.variables if d not in following]
    premises = [
        *situation.carriers("before", leading),
        *[part for part in situation.initial() if not _about(part, following)],
    ]
    shown = tuple(Variable(type=d.type, name=d.name, role="before") for d in leading)
    constraints = [part for part in situation.initial() if _about(part, following)]
    for goal in invariant_goals(prover, constraints, following):
        answer = prover.refutes(premises, goal.term, shown)
        yield report.universal(
            answer,
            message="INIT allows values outside the invariant; they are silently left out",
            goal=goal.term,
            detail=goal.what,
            span=goal.span,
        )


def invariant_goals(
    prover: Prover, constraints: list[Constraint], following: Iterable[Declared] | None = None
) -> Iterator[Constraint]:
    """The invariant as goals over the state before: each conjunct without *following* variables, and one for the rest.

    Those (by default the secondary ones) follow the others: it is enough that they can have values, those that
    *constraints* allow.
    """
    situation = prover.situation
    following = tuple(situation.model.secondary if following is None else following)
    about_them: list[Constraint] = list(constraints)
    for part in situation.invariant():
        if _about(part, following):
            about_them.append(part)
        else:
            yield Constraint(part.term, f"`{text(part.term)}`", part.span)
    if not about_them:
        return
    unknowns = [Unknown(Variable(type=d.type, name=d.name, role="before"), d.carrier) for d in following]
    binders, table = bound_by(unknowns)
    body: Term = all_of(substitute(part.term, table) for part in about_them)
    names = ", ".join(f"`{d.name}`" for d in following)
    yield Constraint(quantified("exists", binders, TRUE, body), f"values for {names}", about_them[-1].span)


def _about(part: Constraint, variables: Iterable[Declared]) -> bool:
    return speaks_of(part, [(d.name, "before") for d in variables])


def no_blocked_control_state(prover: Prover, report: ObligationReport) -> Iterator[Finding]:
    """``Inv => enable of one of the events that the process waits for``, at each place in its equations.

    A state for which that fails may be one that the process is never in at that place: the search can tell.
    """
    situation = prover.situation
    model = prover.model
    for place in control_states(model):
        for way in place.ways:
            waited = [model.operations.get(name) for name in sorted(way.channels)]
            operations = [operation for operation in waited if operation is not None]
            if len(operations) < len(waited):
                continue  # the data do not restrict one of the events
            goal = any_of(_some_input(situation, operation) for operation in operations)
            plain = any_of(_plain_input(situation, operation) for operation in operations)
            answer = prover.refutes(situation.state(), plain)
            if not isinstance(answer, Impossible):
                answer = prover.refutes(situation.state(), goal, situation.shown())
            names = ", ".join(f"`{operation.name}`" for operation in operations)
            finding = report.universal(
                answer,
                message=f"the process waits here for {names}, and the data refuse {_each(len(operations))}",
                detail=names,
                span=place.span,
            )
            if finding.status == "proved" and not way.exact:
                finding = replace(
                    finding, status="unknown", message="the process takes certain values only, which were not looked at"
                )
            yield finding


def _plain_input(situation: Situation, operation: Operation) -> Term:
    """That an operation is available for the plainest inputs: mostly enough, and easier than any inputs."""
    table: dict[Key, Term] = {}
    for parameter in operation.parameters:
        if parameter.kind != "output":
            value = plainest(parameter.carrier, situation.specification)
            if value is None:
                return FALSE
            table[parameter.name, parameter.kind] = value
    return substitute(situation.enabled(operation), table)


def plainest(carrier: Term, specification: Specification) -> Term | None:
    """A value of a carrier that has an obvious one."""
    if not isinstance(carrier, Apply):
        return None
    match carrier.operator, carrier.operands:
        case "Int" | "Nat", _:
            return integer(0)
        case "Nat1", _:
            return integer(1)
        case "Real", _:
            return Constant(type=REAL, value=Fraction(0))
        case "Bool", _:
            return FALSE
        case "range" | "set", (first, *_):
            return first
        case "All", _ if isinstance(carrier.type, SetType) and isinstance(carrier.type.element, FreeType):
            free = specification.frees.get(carrier.type.element.name)
            plain = next((name for name, argument in free.branches if argument is None), None) if free else None
            return None if plain is None else Construct(type=carrier.type.element, constructor=plain)
    return None


def _each(number: int) -> str:
    return "it" if number == 1 else "each of them"


def _some_input(situation: Situation, operation: Operation) -> Term:
    """That an operation is available for some inputs."""
    unknowns = [Unknown(parameter_variable(p), p.carrier) for p in operation.parameters if p.kind != "output"]
    binders, table = bound_by(unknowns)
    return quantified("exists", binders, TRUE, substitute(situation.enabled(operation), table))
