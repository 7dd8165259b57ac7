"""Answering the assertions about the data of classes: obligations, data refinement, subclasses."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from cspcheck.checker.proof import messages
from cspcheck.checker.proof.finding import Finding, worst_first
from cspcheck.checker.proof.obligations import BY_NAME, OBLIGATIONS, discharge
from cspcheck.checker.proof.prover import Prover
from cspcheck.checker.proof.question import Help, SolverSettings
from cspcheck.checker.proof.simulation import RULES, Relation, Simulation, projection, retrieve
from cspcheck.checker.verdict import BrokenObligation, Counterexample, Outcome, Verdict
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.oz import core, laws, syntax
from cspcheck.cspm.oz.processes import classes
from cspcheck.cspm.oz.typing.lemma_messages import unknown_lemma
from cspcheck.cspm.oz.typing.messages import unknown_class
from cspcheck.cspm.source import Source, Span
from cspcheck.cspm.spelling import suggestions
from cspcheck.cspm.syntax.tree import Assertion, NotAssertion

if TYPE_CHECKING:
    from cspcheck.cspm.script import Script

_MOST_OTHERS = 8
_BETWEEN_STATES = ("applicability", "definedness", "correctness")
"""Rules whose counterexamples begin in related states, so that the relation is there."""


def answer(
    node: syntax.Obligations | syntax.DataRefinement | syntax.Subtype,
    specification: core.Specification,
    seconds: float | None = None,
    clock: Callable[[], float] = time.monotonic,
) -> Outcome:
    """The answer to an assertion.

    Args:
        node: the assertion.
        specification: that it speaks of.
        seconds: for the whole assertion; by default ten for each obligation.
        clock: tells the seconds.

    Raises:
        ScriptError: it speaks of what there is not.
    """
    start = clock()
    settings = SolverSettings(deadline=None if seconds is None else start + seconds)
    if isinstance(node, syntax.Obligations):
        # An obligation that is asked for by name counts as it is; among all only errors do.
        named = node.obligation not in (None, "obligations")
        return outcome(obligations(node, specification, settings), named=named, seconds=clock() - start)
    # What is false is mostly false of few and small values, and proving the rest of it is of no use then.
    glance = whole_refinement(node, specification, replace(settings, glance="only"))
    found = [f for f in glance if f.status == "refuted" and f.severity == "error" and f.obligation in _BETWEEN_STATES]
    if not found:
        found = list(whole_refinement(node, specification, replace(settings, glance="after")))
    return outcome(found, named=False, seconds=clock() - start)


def whole_refinement(node: Assertion, specification: core.Specification, settings: SolverSettings) -> Iterator[Finding]:
    """The findings for an assertion about two classes; none for other assertions.

    Raises:
        ScriptError: it speaks of what there is not.
    """
    while isinstance(node, NotAssertion):
        node = node.inner
    match node:
        case syntax.DataRefinement():
            relation = _retrieve(node, specification)
            yield from _refinement(specification, relation, node, settings, upward=node.upward)
        case syntax.Subtype():
            yield from _refinement(specification, _projection(node, specification), node, settings)


def _refinement(
    specification: core.Specification,
    relation: Relation,
    node: syntax.DataRefinement | syntax.Subtype,
    settings: SolverSettings,
    *,
    upward: bool = False,
) -> Iterator[Finding]:
    simulation = Simulation(specification, relation, settings)
    simulation.help = help_of(node.hints, simulation.prover)
    yield from simulation.prover.solver.one_after_another(simulation.upward() if upward else simulation.downward())


def specification_of(script: Script) -> core.Specification:
    """The Object-Z part of a loaded script; an empty one where it has none."""
    return classes.specification_of(script) or core.Specification()


def obligations(node: syntax.Obligations, specification: core.Specification, settings: SolverSettings) -> list[Finding]:
    """The findings for an assertion about obligations."""
    model = class_of(specification, node.subject.name, node.subject.span)
    names = obligation_names(node.obligation, node.span)
    operation = None
    prover = Prover(specification, model, settings)
    if node.operation is not None and names == ["lemma"]:
        operation = _lemma_of(prover, node.operation.name, node.operation.span)
    elif node.operation is not None:
        operation = operation_of(model, node.operation.name, node.operation.span).name
    return list(discharge(prover, names, operation, help_of(node.hints, prover)))


def help_of(hints: syntax.Hints | None, prover: Prover) -> Help:
    """What an assertion says that its proof needs.

    Raises:
        ScriptError: it names a lemma that there is not.
    """
    if hints is None:
        return Help()
    for name in hints.using:
        _lemma_of(prover, name.name, name.span)
    on = hints.induction
    return Help(tuple(core.LemmaUse(name=name.name) for name in hints.using), None if on is None else on.name)


def _lemma_of(prover: Prover, name: str, span: Span | None) -> str:
    if prover.claim(name) is None:
        assert span is not None
        known = [known.rpartition(".")[2] for known in prover.claims]
        raise ScriptError(unknown_lemma(name, span, suggestions(name, [*known, *laws.names()])))
    return name


def class_of(specification: core.Specification, name: str, span: Span | None) -> core.ClassModel:
    """A class by its name.

    Raises:
        ScriptError: there is none.
    """
    model = specification.classes.get(name)
    if model is None:
        raise ScriptError(unknown_class(name, span, suggestions(name, specification.classes)))  # type: ignore[arg-type]
    return model


def lemmas_alone() -> core.ClassModel:
    """A class without anything, for the lemmas of a script that has no class."""
    return core.ClassModel(name="lemmas", span=Source("", "").span(0, 0))


def operation_of(model: core.ClassModel, name: str, span: Span | None) -> core.Operation:
    """An operation of a class by the name of its channel, or of one of its schemas.

    Raises:
        ScriptError: there is none.
    """
    plain = name
    for prefix in ("com_", "effect_", "enable_"):
        plain = plain.removeprefix(prefix)
    found = model.operations.get(name) or model.operations.get(plain)
    if found is None:
        raise ScriptError(messages.no_such_operation(model.name, name, span, suggestions(name, model.operations)))
    return found


def obligation_names(name: str | None, span: Span | None) -> list[str] | None:
    """The kinds of obligations that a name stands for; None for all.

    Raises:
        ScriptError: for none.
    """
    if name is None or name == "obligations":
        return None
    if name not in BY_NAME:
        known = [o.name for o in OBLIGATIONS]
        raise ScriptError(messages.unknown_obligation(name, span, suggestions(name, known), known))
    return [name]


def rule_of(name: str | None) -> str | None:
    """The rule of refinement that a name is; None where it is none."""
    return name if name in RULES else None


def _retrieve(node: syntax.DataRefinement, specification: core.Specification) -> Relation:
    for name in (node.abstract, node.concrete):
        class_of(specification, name.name, name.span)
    relation = specification.retrieves.get(node.retrieve.name)
    if relation is None:
        similar = suggestions(node.retrieve.name, specification.retrieves)
        raise ScriptError(messages.unknown_retrieve_relation(node.retrieve.name, node.retrieve.span, similar))
    wanted, found = (node.abstract.name, node.concrete.name), (relation.abstract, relation.concrete)
    if wanted != found:
        raise ScriptError(messages.other_classes(relation.name, wanted, found, node.retrieve.span, relation.span))
    return retrieve(relation)


def _projection(node: syntax.Subtype, specification: core.Specification) -> Relation:
    for name in (node.parent, node.child):
        class_of(specification, name.name, name.span)
    try:
        return projection(specification, node.parent.name, node.child.name)
    except LookupError as missing:
        raise ScriptError(
            messages.no_projection(node.parent.name, node.child.name, str(missing.args[0]), node.child.span)
        ) from None


# --- outcomes ---------------------------------------------------------------------------------------------------------


def outcome(findings: Sequence[Finding], *, named: bool, seconds: float) -> Outcome:
    """What findings add up to: a failure, if one that counts is refuted; a pass, if all that count are proved."""
    counting = [f for f in findings if named or f.severity == "error"]
    refuted = [f for f in counting if f.status == "refuted"]
    remarks = tuple(
        said(f) for f in findings if (f not in counting and f.status == "refuted" and f.severity != "info") or f.vacuous
    )
    remarks += _of_lemmas(findings)
    if refuted:
        verdict, reason, counterexample = Verdict.FAIL, None, broken(refuted)
    else:
        open_ = sorted((f for f in counting if f.status != "proved"), key=worst_first)
        counterexample = None
        verdict = Verdict.UNKNOWN if open_ else Verdict.PASS
        reason = _open(open_) if open_ else None
    return Outcome(verdict, reason, 0, 0, seconds, 0, counterexample, remarks)


def _of_lemmas(findings: Sequence[Finding]) -> tuple[str, ...]:
    """What lemmas the proofs needed, and which they were to use and could not."""
    used = dict.fromkeys(name for finding in findings for name in finding.hypotheses)
    missing = dict.fromkeys(name for finding in findings for name in finding.missing)
    told = [f"proved with {', '.join(f'`{name}`' for name in used)}"] if used else []
    told += [f"`{name}` is not proved, and was not used" for name in missing]
    return tuple(told)


def _open(findings: Sequence[Finding]) -> str:
    more = f"; and {len(findings) - 1} more" if len(findings) > 1 else ""
    return said(findings[0]) + more


def said(finding: Finding) -> str:
    """A finding in a line."""
    place = f" of `{finding.operation}`" if finding.operation is not None else ""
    return f"`{finding.obligation}`{place}: {finding.message}"


def broken(refuted: Sequence[Finding]) -> Counterexample:
    """The first of the refuted obligations as a counterexample, with the others named."""
    first = refuted[0]
    others = [said(finding) for finding in refuted[1:]]
    if len(others) > _MOST_OTHERS:
        others[_MOST_OTHERS - 1 :] = [f"{len(others) - _MOST_OTHERS + 1} more"]
    return Counterexample(
        kind="obligation",
        trace=(),
        values=dict(first.values) or None,
        obligation=BrokenObligation(
            name=first.obligation,
            subject=first.subject,
            operation=first.operation,
            message=first.message,
            line=None if first.span is None else first.span.line,
            failing=first.failing,
            lines=tuple((span.line, " ".join(span.text.split())) for span in first.lines),
            others=tuple(others),
        ),
    )


def without_times(findings: Iterable[Finding]) -> list[Finding]:
    """The findings without what differs from run to run."""
    return [replace(finding, seconds=0.0) for finding in findings]
