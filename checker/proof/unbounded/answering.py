"""Assertions about processes of classes, answered for all values of their data.

Each answer is certain: ``pass`` rests on an invariant that the prover has checked, ``fail`` on a run whose values the
evaluator has put into the classes. Where neither is found the answer is ``unknown``, with what was tried.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

from cspcheck.checker.proof.prover import Prover
from cspcheck.checker.proof.question import Found, Impossible, SolverSettings
from cspcheck.checker.proof.terms import is_false
from cspcheck.checker.proof.unbounded.claims import (
    Problem,
    deadlock_freedom,
    determined_by_traces,
    failures_refinement,
    guards_that_cover,
    trace_refinement,
)
from cspcheck.checker.proof.unbounded.control import UnreadableProcess
from cspcheck.checker.proof.unbounded.invariants import Invariant, Invariants
from cspcheck.checker.proof.unbounded.runs import FailingRun, Runs
from cspcheck.checker.proof.unbounded.system import (
    ClassComponent,
    ClassSystem,
    Composition,
    Hidden,
    SystemLeaf,
    Together,
    component,
)
from cspcheck.checker.verdict import DEFAULT_MODELS, ComponentBehaviour, Counterexample, Outcome, Verdict
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.processes.context import ClassContext
from cspcheck.cspm.oz.writing.core_text import text
from cspcheck.cspm.syntax import tree as syntax

if TYPE_CHECKING:
    from cspcheck.cspm.script import Script


class _OtherKind(Exception):
    """An assertion of a kind that is not answered here."""


SHORT, LONG = 3, 8
"""So many steps a run may have that is looked for before and after the search for an invariant."""
EFFORT, GLANCE = 2.0, 1.0
"""Seconds' worth of the solver's steps for one question of a proof, and for one about a run."""


def for_all_values(
    assertion: syntax.Assertion,
    script: Script,
    seconds: float | None = None,
    clock: Callable[[], float] = time.monotonic,
    *,
    termination_counts: bool = False,
) -> Outcome | None:
    """The answer to an assertion about classes, for all values of their data; None where it is of another kind.

    Args:
        assertion: deadlock freedom, or a refinement in T, F or FD.
        script: that it is one of.
        seconds: for the whole; None: no limit but that of work.
        clock: tells the seconds.
        termination_counts: whether a process that has terminated counts as deadlocked.
    """
    from cspcheck.cspm.oz.processes.classes import context_of

    context = context_of(script)
    if context is None or context.control or script.events.clocks:
        return None
    start = clock()
    try:
        problem, observer, specification = _Reading(script, context).problem(assertion)
        if termination_counts and any(component.machine.ends for component in problem.components):
            raise UnreadableProcess("a class may terminate, which counts as deadlock")
    except _OtherKind:
        return None
    except UnreadableProcess as unreadable:
        return Outcome(Verdict.UNKNOWN, str(unreadable), 0, 0, clock() - start, 0)
    settings = SolverSettings(seconds=EFFORT, deadline=None if seconds is None else start + seconds)
    prover = Prover(specification, _model(problem.components), settings, clock)
    outcome = _answered(problem, observer, prover)
    return replace(outcome, seconds=clock() - start)


def _model(components: Sequence[ClassComponent]) -> core.ClassModel:
    """A class with the constants of all components."""
    constants = dict.fromkeys(c for component in components for c in component.model.constants)
    axioms = dict.fromkeys(a for component in components for a in component.model.axioms)
    return replace(components[0].model, constants=tuple(constants), axioms=tuple(axioms))


def _answered(problem: Problem, observer: ClassComponent | None, prover: Prover) -> Outcome:
    begins = prover.find(problem.initial, problem.variables())
    if not isinstance(begins, Found):
        return _unknown("it is not known whether there is an initial state")
    if observer is not None:
        for premises, goal in determined_by_traces(observer):
            if not isinstance(prover.refutes(premises, goal), Impossible):
                return _unknown(f"what `{observer.name}` has done does not determine its data, as far as is known")
    invariants = Invariants(problem, prover)
    if invariants.at_once():
        return _proved(problem, invariants.nothing)
    invariant = invariants.of_equations()
    if invariant is not None:
        return _proved(problem, invariant)
    if not _covered(problem, prover):
        problem = replace(problem, claims=tuple(tuple(replace(c, exact=False) for c in cs) for cs in problem.claims))
    glance = replace(prover.solver.settings, seconds=GLANCE, scopes=(2,))
    runs = Runs(problem, Prover(prover.specification, prover.model, glance, prover.clock))
    run = runs.search(SHORT)
    if run is None:
        invariant = invariants.found()
        if invariant is not None:
            return _proved(problem, invariant)
        run = runs.search(LONG)
    if run is not None:
        return _refuted(run, runs, observer)
    if runs.excluded < 0:
        return _unknown("no invariant was found that proves it, and no run that refutes it")
    return _unknown(
        f"no invariant was found that proves it; no run of at most {runs.excluded} steps refutes it, for any values"
    )


def _covered(problem: Problem, prover: Prover) -> bool:
    """Whether no guard holds where its effect is impossible, in whatever state a class is."""
    obligations = [each for component in problem.components for each in guards_that_cover(component)]
    return all(isinstance(prover.refutes(premises, goal), Impossible) for premises, goal in obligations)


def _unknown(reason: str) -> Outcome:
    return Outcome(Verdict.UNKNOWN, reason, 0, 0, 0.0, 0)


def _proved(problem: Problem, invariant: Invariant) -> Outcome:
    remarks = ["proved for all values of the data, whatever its size"]
    for place, known in zip(problem.places, invariant.places, strict=True):
        if known:
            said = "never, because of the data" if is_false(known[0]) else " and ".join(f"`{text(t)}`" for t in known)
            remarks.append(f"invariant where {place} is possible: {said}")
    return Outcome(Verdict.PASS, None, 0, 0, 0.0, 0, remarks=tuple(remarks))


def _refuted(run: FailingRun, runs: Runs, observer: ClassComponent | None) -> Outcome:
    implementation = [component for component in runs.problem.components if component is not observer]
    trace: list[str] = []
    causes: list[str | None] = []
    taking: dict[int, list[str | None]] = {number: [] for number in range(len(implementation))}
    states = [run.states[0]]
    for position, (step, values) in enumerate(run.steps):
        if not step.move.parts:
            continue  # an internal step of control
        channel = step.move.label or step.move.parts[0][1]
        event = ".".join([channel, *values])
        trace.append(event if step.move.label is not None else "tau")
        causes.append(None if step.move.label is not None else event)
        states.append(run.states[position + 1])
        there = {number for number, _ in step.move.parts}
        for number, events in taking.items():
            events.append(event if number in there else None)
    components = [
        _behaviour(component, states, taking[number], runs.offers(run, number))
        for number, component in enumerate(implementation)
    ]
    visible = [event for event, cause in zip(trace, causes, strict=True) if cause is None]
    end = None if run.claim.label is None else ".".join([run.claim.label, *run.values])
    kind = run.claim.kind
    found = Counterexample(
        kind="deadlock" if kind == "deadlock" else "trace" if kind == "trace" else "refusal",
        trace=tuple(trace),
        causes=tuple(causes),
        event=end if kind == "trace" else None,
        refusal=(end,) if kind == "refusal" and end is not None else None,
        components=tuple(components),
        specification_trace=None if observer is None else tuple(visible),
    )
    remarks = ["found by the solver for all values of the data, and replayed by the evaluator of classes"]
    if run.vouched:
        remarks = ["found by the solver; of predicates over infinite sets the solver alone says that they hold"]
    if run.constants:
        remarks.append("where " + ", ".join(f"{name} = {value}" for name, value in run.constants.items()))
    return Outcome(Verdict.FAIL, None, 0, 0, 0.0, 0, found, tuple(remarks))


def _behaviour(
    component: ClassComponent, states: Sequence[Mapping[str, str]], trace: Sequence[str | None], offers: tuple[str, ...]
) -> ComponentBehaviour:
    names = [v.name for v in component.situation.state_variables()]
    plain = {name: name.rpartition(".")[2] for name in names}
    shown = [{plain[name]: state[name] for name in names} for state in states]
    changes = [
        {name: value for name, value in after.items() if before[name] != value} for before, after in pairwise(shown)
    ]
    inside = ", ".join(f"{name} = {value}" for name, value in shown[-1].items())
    return ComponentBehaviour(
        name=component.name,
        trace=tuple(trace),
        state=f"{component.name}({inside})" if inside else component.name,
        line=component.model.span.line,
        offers=offers,
        waiting_for=(),
        variables=shown[0],
        changes=tuple(changes),
    )


class _Reading:
    """Reads assertions whose processes are classes, and compositions of classes."""

    def __init__(self, script: Script, context: ClassContext) -> None:
        self._script = script
        self._context = context
        self._specification = context.specification
        self._classes: list[tuple[core.ClassModel, bool]] = []

    def problem(self, assertion: syntax.Assertion) -> tuple[Problem, ClassComponent | None, core.Specification]:
        """The claims, the specification of a refinement, and what the terms belong to.

        Raises:
            Unreadable: it is not about classes alone, or about more than is read here.
        """
        match assertion:
            case syntax.Property(kind="deadlock free", options=()):
                composition = self._composition(assertion.process)
                system = self._system(composition, self._components(qualified=len(self._classes) > 1))
                model = assertion.model or DEFAULT_MODELS["deadlock free"]
                if model not in ("T", "F", "FD"):
                    raise UnreadableProcess(f"the model {model} is only searched")
                return deadlock_freedom(system, divergences=model == "FD"), None, self._specification
            case syntax.Refinement(model="T" | "F" | "FD" as wanted, options=()):
                implementation = self._composition(assertion.implementation)
                number = len(self._classes)
                specification = self._composition(assertion.specification)
                if not isinstance(specification, SystemLeaf):
                    raise UnreadableProcess("the specification is no class")
                components = self._components(qualified=True)
                system = self._system(implementation, components[:number])
                observer = components[-1]
                if wanted == "T":
                    problem = trace_refinement(system, observer)
                else:
                    problem = failures_refinement(system, observer, divergences=wanted == "FD")
                return problem, observer, self._specification
        raise _OtherKind

    def _components(self, *, qualified: bool) -> list[ClassComponent]:
        names = [model.name for model, _ in self._classes]
        if len(set(names)) < len(names):
            raise UnreadableProcess("a class occurs twice")
        return [
            component(self._context, model, qualified=qualified, visible=visible) for model, visible in self._classes
        ]

    def _system(self, composition: Composition, components: Sequence[ClassComponent]) -> ClassSystem:
        return ClassSystem(tuple(components), _resolved(composition, components))

    def _composition(self, node: syntax.Expr, depth: int = 0) -> Composition:
        if depth > 50:
            raise UnreadableProcess("processes are nested too deeply")
        match node:
            case syntax.Paren():
                return self._composition(node.inner, depth + 1)
            case syntax.Name(parts=parts):
                name = "::".join(parts)
                model = self._context.class_of(name)
                if model is not None:
                    self._classes.append((model, len(parts) > 1))
                    return SystemLeaf(len(self._classes) - 1)
                symbol = self._script.names.find(node)
                declaration = None if symbol is None else symbol.declaration
                if isinstance(declaration, syntax.PatternDefinition) and isinstance(
                    declaration.pattern, syntax.NamePattern
                ):
                    return self._composition(declaration.body, depth + 1)
            case syntax.ClassParallel():
                left, right = self._composition(node.left, depth + 1), self._composition(node.right, depth + 1)
                return Together(_EVERYTHING, left, right)
            case syntax.ProcessBinary(operator="|||"):
                left, right = self._composition(node.left, depth + 1), self._composition(node.right, depth + 1)
                return Together(frozenset(), left, right)
            case syntax.Synchronised(operator="[|"):
                left, right = self._composition(node.left, depth + 1), self._composition(node.right, depth + 1)
                return Together(_channels(node.events), left, right)
            case syntax.Hide(keep=False):
                return Hidden(_channels(node.events), self._composition(node.process, depth + 1))
        raise UnreadableProcess(f"`{' '.join(node.span.text.split())[:60]}` is no composition of classes")


_EVERYTHING = frozenset({"*"})
"""In place of the channels that both sides have."""


def _resolved(composition: Composition, components: Sequence[ClassComponent]) -> Composition:
    """The composition with the channels that both sides have where ``||`` joins classes."""
    match composition:
        case Together(channels=channels, left=left, right=right):
            one, other = _resolved(left, components), _resolved(right, components)
            if channels is _EVERYTHING:
                channels = _alphabet(one, components) & _alphabet(other, components)
            return Together(channels, one, other)
        case Hidden(channels=channels, inner=inner):
            return Hidden(channels, _resolved(inner, components))
    return composition


def _alphabet(composition: Composition, components: Sequence[ClassComponent]) -> frozenset[str]:
    match composition:
        case SystemLeaf(number=number):
            return frozenset(label for label in components[number].labels.values() if label is not None)
        case Hidden(channels=channels, inner=inner):
            return _alphabet(inner, components) - channels
        case Together(left=left, right=right):
            return _alphabet(left, components) | _alphabet(right, components)


def _channels(node: syntax.Expr) -> frozenset[str]:
    node = syntax.bare(node)
    if isinstance(node, syntax.Productions) and node.statements is None:
        names = [item for item in node.items if isinstance(item, syntax.Name)]
        if len(names) == len(node.items):
            return frozenset("::".join(name.parts) for name in names)
    raise UnreadableProcess("a set of events is not one of whole channels")
