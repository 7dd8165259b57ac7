"""Answering the assertions of a script."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, TypeGuard

from cspcheck.checker.budget import NO_ROOM, Budget, Incomplete
from cspcheck.checker.checks.context import Context, PartialOrder, Sure
from cspcheck.checker.checks.determinism import deterministic
from cspcheck.checker.checks.observed_refinement import ObservedModel, refines_observed
from cspcheck.checker.checks.properties import deadlock_free, divergence_free, has_trace
from cspcheck.checker.checks.readings import Trace, held_against_readings
from cspcheck.checker.checks.refinement import refines
from cspcheck.checker.checks.store import KEPT_BYTES, Machines
from cspcheck.checker.explain.replay import ReplayFailure
from cspcheck.checker.lts import Lts
from cspcheck.checker.search.beyond import Beyond
from cspcheck.checker.search.checkpoint import Checkpoints
from cspcheck.checker.search.exploration import Progress
from cspcheck.checker.search.spill import Spill, is_full
from cspcheck.checker.specification.normal_form import FailuresModel, NormalModel
from cspcheck.checker.verdict import (
    BY_PARTIAL_ORDER,
    DEFAULT_MODELS,
    DIVERGENCE_COUNTS,
    TERMINATION_COUNTS,
    UNORDERED_FULL,
    UNORDERED_KIND,
    UNORDERED_PROCESS,
    Limits,
    Outcome,
    Termination,
    Verdict,
)
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.interruption import during
from cspcheck.cspm.process.events import EventSet, EventTable
from cspcheck.cspm.process.terms import STOP, Prioritised, Process, Sequential
from cspcheck.cspm.syntax.tree import (
    Assertion,
    AssertOption,
    BooleanAssertion,
    Expr,
    Model,
    NotAssertion,
    Property,
    PropertyKind,
    Refinement,
)

if TYPE_CHECKING:
    from cspcheck.checker.checks.coverage import Happened
    from cspcheck.cspm.oz.syntax import DataRefinement, Obligations, Subtype
    from cspcheck.cspm.script import Script

_FAILURES: dict[Model, FailuresModel] = {"F": "F", "FD": "FD", "V": "F", "VD": "FD", "R": "F", "RD": "FD"}
"""What deadlock freedom and determinism look at in each model: richer models tell no more of them than failures do."""


EARLY = (1_000, 8_000)
"""Where a component has more states than this by itself, as many of the whole are looked at first."""


_NOT_FOR_ALL_VALUES = "not decided for all values"
_TOO_WIDE = ("CSP411", "CSP681", "CSP682")
"""What a search cannot go through: infinite sets of events or values, and those that are too large."""


class _Proved(Exception):
    """What a search was to answer has been proved, or refuted, for all values."""

    def __init__(self, outcome: Outcome) -> None:
        super().__init__()
        self.outcome = outcome


class Checker:
    """Answers assertions about the processes of one script, and shares what they have in common.

    Which assertions have been answered before makes no difference to an outcome, its time apart; neither does the
    number of workers.

    Args:
        script: the loaded script.
        limits: for each assertion; the states are those of each machine that has to be explored for it.
        workers: threads for large searches; by default as many as there are processors.
        full: explore the whole space of every check: nothing is merged, no search ends early.
        as_written: reduce nothing that the script does not ask to be reduced.
        termination: what a process that has terminated is to ``deadlock free``: a success, or a deadlock as in FDR4.
        progress: called a few times a second during a search.
        notify: called with a line to be shown when kernels have to be compiled first.
        checkpoints: where to write long searches down, and to go on from.
        beyond: where searches go on that are too large for this process.
    """

    def __init__(
        self,
        script: Script,
        *,
        limits: Limits = Limits(),  # noqa: B008  (immutable)
        workers: int | None = None,
        full: bool = False,
        as_written: bool = False,
        termination: Termination = "success",
        progress: Callable[[Progress], None] | None = None,
        notify: Callable[[str], None] | None = None,
        checkpoints: Checkpoints | None = None,
        beyond: Beyond | None = None,
    ) -> None:
        self._script = script
        self._limits = limits
        self._termination = termination
        self._unproved: Assertion | None = None
        self._open: str | None = None
        """Why the assertion at hand is not decided for all values, once that has been tried."""
        self._happened: dict[Process, Happened | None] = {}
        self._sure = Sure()
        self._order = PartialOrder()
        kept = KEPT_BYTES if limits.memory_bytes is None else min(KEPT_BYTES, limits.memory_bytes // 2)
        self._machines = Machines(
            workers=workers or os.cpu_count() or 1,
            full=full,
            reduces=not as_written,
            kept_bytes=kept,
            progress=progress,
            notify=notify,
            checkpoints=checkpoints,
            beyond=beyond,
        )

    def check(self, assertion: Assertion) -> Outcome:
        """The answer to an assertion of the script.

        The option ``partial order reduce`` asks for a search that leaves states out where components do not depend on
        each other, with the same verdict. ``tau priority`` gives both sides priority to tau and tick over the option's
        events.

        Raises:
            ScriptError: what the assertion speaks of cannot be evaluated.
        """
        if isinstance(assertion, NotAssertion):
            return _inverted(self.check(assertion.inner))
        classes = self._script.classes
        if classes is None:
            return self._for_every_size(assertion, self._check(assertion))
        if _is_proved(assertion):
            return self._check(assertion)  # proofs are about all values, whatever a search takes instead
        with self._proving(assertion):
            try:
                outcome = self._check(assertion)
            except _Proved as proved:
                return proved.outcome
            except ScriptError as error:
                if any(diagnostic.code not in _TOO_WIDE for diagnostic in error.diagnostics):
                    raise
                proved_instead = self._for_all_values()
                if proved_instead is None:
                    if self._open is None:
                        raise
                    note = f"{_NOT_FOR_ALL_VALUES}: {self._open}"
                    raise ScriptError(*[d.with_notes(note) for d in error.diagnostics]) from None
                return proved_instead
            readings = self._script.readings(assertion)
            if outcome.verdict is Verdict.UNKNOWN or classes.chosen(readings):
                proved_instead = self._for_all_values()
                if proved_instead is not None:
                    return proved_instead
            if outcome.verdict is Verdict.UNKNOWN and self._open is not None:
                remark = f"{_NOT_FOR_ALL_VALUES}: {self._open}"
                outcome = replace(outcome, remarks=(*outcome.remarks, remark))
        outcome = replace(outcome, readings=readings, control=classes.control)
        return outcome if classes.has_left else self._for_every_size(assertion, outcome)

    def _for_every_size(self, assertion: Assertion, outcome: Outcome) -> Outcome:
        """The outcome of a search with what it says of types of other sizes."""
        if outcome.verdict is Verdict.UNKNOWN or not isinstance(assertion, Refinement | Property):
            return outcome
        from cspcheck.checker.independence.answering import for_every_size

        return replace(outcome, every_size=for_every_size(assertion, self._script, outcome))

    @contextmanager
    def _proving(self, assertion: Assertion) -> Iterator[None]:
        """What is asked of the prover, at most once, where a search cannot go through all values."""
        before = self._unproved, self._open
        self._unproved, self._open = assertion, None
        try:
            yield
        finally:
            self._unproved, self._open = before

    def _for_all_values(self) -> Outcome | None:
        """The answer to the assertion at hand for all values of the data of its classes; None where it is not known."""
        assertion, self._unproved = self._unproved, None
        if assertion is None or self._machines.full or self._limits.states is not None:
            return None  # whoever limits the states wants to know what a search says
        from cspcheck.checker.proof.unbounded.answering import for_all_values

        with during("proving it for all values", vague=True):
            outcome = for_all_values(
                assertion, self._script, self._limits.seconds, termination_counts=self._termination == "deadlock"
            )
        if outcome is None or outcome.verdict is not Verdict.UNKNOWN:
            return outcome
        self._open = outcome.reason
        return None

    def _is_endless(self, process: Process, budget: Budget) -> bool:
        """Whether a process has a component with more states than a first look goes through."""
        try:
            self._machines.network(process, budget, terms=EARLY[0])
        except Incomplete as incomplete:
            return incomplete.endless
        return False

    def ended(self, assertion: Assertion, reason: str) -> Outcome | None:
        """What is sure of an assertion whose check was stopped for a reason; None if nothing is.

        That is a failure that was being explained. Nothing else may be asked of this checker any more.
        """
        if isinstance(assertion, NotAssertion):
            outcome = self.ended(assertion.inner, reason)
            return None if outcome is None else _inverted(outcome)
        sure, classes = self._sure.outcome, self._script.classes
        if sure is None or self._sure.about is not assertion or (classes is not None and classes.has_left):
            return None
        outcome = _untold(sure, reason)
        return self._differences_told(outcome, assertion.kind) if isinstance(assertion, Property) else outcome

    def _check(self, assertion: Assertion) -> Outcome:
        budget = Budget(self._limits)
        self._sure.about, self._sure.outcome = assertion, None
        options = assertion.options if isinstance(assertion, Refinement | Property) else ()
        self._order = PartialOrder(any(option.kind == "partial order reduce" for option in options))
        if isinstance(assertion, BooleanAssertion):
            holds = self._script.boolean(assertion.condition)
            return budget.outcome(Verdict.PASS if holds else Verdict.FAIL, None, 0, 0)
        if isinstance(assertion, Refinement):
            specification = self._process(assertion.specification, assertion.options)
            implementation = self._process(assertion.implementation, assertion.options)
            if self._unproved is not None and self._is_endless(specification, budget):
                proved = self._for_all_values()
                if proved is not None:
                    raise _Proved(proved)
            outcome = self.check_refinement(specification, assertion.model, implementation, budget)
            outcome = self._order_told(outcome, suited=assertion.model in ("T", "F", "FD"))
            return self._within_readings(outcome, implementation, specification, budget, traces=assertion.model == "T")
        if isinstance(assertion, Property):
            model = assertion.model or DEFAULT_MODELS[assertion.kind]
            trace = () if assertion.trace is None else self._script.trace(assertion.trace)
            process = self._process(assertion.process, assertion.options)
            if assertion.kind == "deadlock free" and self._termination == "deadlock":
                # Where it would terminate it does nothing any more, and has not terminated.
                process = Sequential(process, STOP)
            outcome = self.check_property(process, assertion.kind, model, trace, budget)
            outcome = self._differences_told(outcome, assertion.kind)
            outcome = self._order_told(outcome, suited=assertion.kind in ("deadlock free", "divergence free"))
            claim: Trace = "no"
            if assertion.kind == "has trace":
                claim = "possible" if model == "T" else "reliable"
            return self._within_readings(outcome, process, None, budget, trace=claim)
        if _is_proved(assertion):
            from cspcheck.checker.proof.answer import answer, specification_of

            return answer(assertion, specification_of(self._script), self._limits.seconds)
        raise TypeError(f"not an assertion: {assertion!r}")

    def _differences_told(self, outcome: Outcome, kind: PropertyKind) -> Outcome:
        """The outcome of a property, with a remark where FDR4 would come to another one."""
        remark = None
        if kind == "deadlock free" and self._termination == "deadlock":
            remark = TERMINATION_COUNTS
        elif kind == "deterministic" and outcome.counterexample is not None:
            remark = DIVERGENCE_COUNTS if outcome.counterexample.kind == "divergence" else None
        return outcome if remark is None else replace(outcome, remarks=(*outcome.remarks, remark))

    def _order_told(self, outcome: Outcome, *, suited: bool) -> Outcome:
        """The outcome, with what has become of the wish for partial order.

        Args:
            outcome: the outcome.
            suited: whether the assertion is of a kind that can be answered so.
        """
        if not self._order.wanted:
            return outcome
        if self._order.used:
            return replace(outcome, remarks=(*outcome.remarks, BY_PARTIAL_ORDER), reduction="partial order")
        why = UNORDERED_KIND if not suited else UNORDERED_FULL if self._machines.full else UNORDERED_PROCESS
        if suited and not self._machines.full and not self._order.unsuited:
            return outcome  # there was no search that would have been worth it
        return replace(outcome, remarks=(*outcome.remarks, f"partial order changes nothing here: {why}"))

    def _within_readings(
        self,
        outcome: Outcome,
        implementation: Process,
        specification: Process | None,
        budget: Budget,
        *,
        traces: bool = False,
        trace: Trace = "no",
    ) -> Outcome:
        """The outcome, held against what classes do outside their finite readings."""
        classes = self._script.classes
        if classes is None or not classes.has_left:
            return outcome
        return held_against_readings(outcome, implementation, specification, budget, traces=traces, trace=trace)

    def check_refinement(
        self, specification: Process, model: Model, implementation: Process, budget: Budget | None = None
    ) -> Outcome:
        """Whether ``specification [model= implementation``, for process terms.

        Args:
            specification, model, implementation: what is claimed.
            budget: the limits, running; by default the checker's, from now.
        """
        budget = budget or Budget(self._limits)
        if model == "T" or model == "F" or model == "FD":
            checked: NormalModel = model
            return self._answered(
                budget, implementation, lambda context: refines(context, specification, checked, implementation)
            )
        observed: ObservedModel = model
        return self._answered(
            budget, None, lambda context: refines_observed(context, specification, observed, implementation)
        )

    def check_property(
        self,
        process: Process,
        kind: PropertyKind,
        model: Model | None = None,
        trace: Sequence[int] = (),
        budget: Budget | None = None,
    ) -> Outcome:
        """Whether a process term has a property.

        Args:
            process: the process.
            kind: the property.
            model: by default FD, for ``has trace`` T.
            trace: the events for ``has trace``.
            budget: the limits, running; by default the checker's, from now.
        """
        budget = budget or Budget(self._limits)
        model = model or DEFAULT_MODELS[kind]
        if kind == "divergence free":
            return self._answered(budget, process, lambda context: divergence_free(context, process))
        if kind == "has trace":
            semantics: NormalModel = "T" if model == "T" else _FAILURES[model]
            return self._answered(
                budget, process, lambda context: has_trace(context, process, trace, semantics), len(trace)
            )
        failures: FailuresModel = "F" if model == "T" else _FAILURES[model]
        check = deadlock_free if kind == "deadlock free" else deterministic
        outcome = self._answered(budget, process, lambda context: check(context, process, failures))
        if model != "T":
            return outcome
        remark = f"`{kind}` is no property of traces, which say nothing of what is refused: checked in F"
        return replace(outcome, remarks=(*outcome.remarks, remark))

    def lts(self, process: Process) -> Lts:
        """The explicit machine of a process, all its states in the order of discovery.

        Raises:
            Incomplete: a limit was reached.
            ScriptError: a definition cannot be evaluated.
        """
        return self._machines.lts(process, Budget(self._limits))

    def happened(self, process: Process) -> Happened | None:
        """What happens in the reachable states of a process, none of them left out; None where a limit was reached.

        Raises:
            ScriptError: a definition cannot be evaluated.
        """
        if process not in self._happened:
            self._happened[process] = self._looked_at(process)
        return self._happened[process]

    def _looked_at(self, process: Process) -> Happened | None:
        from cspcheck.checker.checks.coverage import TooManySteps, happened

        try:
            exploration = self._machines.exploration(process, "everything", Budget(self._limits), original=True)
            return happened(exploration) if exploration.complete and not exploration.is_partial else None
        except (Incomplete, TooManySteps):
            return None

    @property
    def events(self) -> EventTable:
        """The events of the script."""
        return self._script.events

    def _context(self, budget: Budget) -> Context:
        return Context(self._machines, self._script.events, budget, self._sure, self._order)

    def _answered(
        self, budget: Budget, subject: Process | None, check: Callable[[Context], Outcome], length: int | None = None
    ) -> Outcome:
        """The outcome of a check; unknown where it could not be done.

        Args:
            budget: what may be used.
            subject: the process that is searched, of which the beginning is looked at if it has no end; None: never.
            check: does it.
            length: for ``has trace`` the number of events, which the beginning may tell all about.
        """
        self._sure.outcome = None  # what was sure of another question says nothing of this one
        if subject is not None and not self._machines.full and budget.limits.states is None:
            for states in EARLY:
                try:
                    self._machines.network(subject, budget, terms=states)
                    break
                except Incomplete as incomplete:
                    if not incomplete.endless:
                        break
                    early = self._at_the_beginning(budget, subject, check, length, states)
                    if early is not None:
                        return early
                    proved = self._for_all_values()
                    if proved is not None:
                        raise _Proved(proved) from None
        try:
            return self._in_words(check(self._context(budget)))
        except OSError as error:
            if not isinstance(self._machines.beyond, Spill) or not is_full(error):
                raise
            if self._sure.outcome is None:
                return budget.outcome(Verdict.UNKNOWN, NO_ROOM, 0, 0)
            return _untold(self._in_words(self._sure.outcome), NO_ROOM)
        except Incomplete as incomplete:
            if self._sure.outcome is not None:
                return _untold(self._in_words(self._sure.outcome), incomplete.reason)
            unknown = budget.outcome(Verdict.UNKNOWN, incomplete.reason, incomplete.states, incomplete.transitions)
            if subject is None or not incomplete.endless:
                return unknown
        return self._at_the_beginning(budget, subject, check, length) or unknown

    def _at_the_beginning(
        self,
        budget: Budget,
        subject: Process,
        check: Callable[[Context], Outcome],
        length: int | None,
        states: int | None = None,
    ) -> Outcome | None:
        """The outcome that the first *states* of a process tell already; None if they do not. See :meth:`_answered`."""
        try:
            machines, levels = self._machines.at_the_beginning(subject, budget, states)
            with during("looking at the beginning of the process", vague=True):
                found = self._in_words(check(Context(machines, self._script.events, budget, self._sure, whole=levels)))
        except (Incomplete, ReplayFailure) as error:
            # Beyond the levels that are there as a whole the machine has deadlocks that the process does not have.
            sure, self._sure.outcome = self._sure.outcome, None
            if sure is None or not isinstance(error, Incomplete):
                return None
            return _untold(self._in_words(sure), error.reason)
        told = found.verdict is Verdict.PASS and length is not None and length < levels
        if found.counterexample is not None:
            told = sum(event != found.counterexample.tau for event in found.counterexample.trace) < levels
        if not told:
            self._sure.outcome = None
        return found if told else None

    def _in_words(self, outcome: Outcome) -> Outcome:
        """The outcome with the word that the script leaves free for the internal action."""
        tau = self._script.events.tau
        if outcome.counterexample is None or outcome.counterexample.tau == tau:
            return outcome
        return replace(outcome, counterexample=replace(outcome.counterexample, tau=tau))

    def _process(self, expression: Expr, options: tuple[AssertOption, ...]) -> Process:
        process = self._script.process(expression)
        for option in options:
            if option.kind == "tau priority" and option.events is not None:
                process = Prioritised(process, (EventSet(), self._script.event_set(option.events)))
        return process


def _is_proved(assertion: Assertion) -> TypeGuard[DataRefinement | Obligations | Subtype]:
    """Whether an assertion speaks of classes and is proved, not searched."""
    from cspcheck.cspm.oz.syntax import (  # only scripts with classes pay for their syntax
        DataRefinement,
        Obligations,
        Subtype,
    )

    return isinstance(assertion, Obligations | DataRefinement | Subtype)


def _untold(outcome: Outcome, reason: str) -> Outcome:
    """A failure that could not be explained to its end."""
    if outcome.counterexample is None:
        return replace(outcome, reason=f"it does not hold, and that is all that is known: {reason}")
    return replace(outcome, remarks=(*outcome.remarks, f"the failure was not explained to its end: {reason}"))


def _inverted(outcome: Outcome) -> Outcome:
    opposite = {Verdict.PASS: Verdict.FAIL, Verdict.FAIL: Verdict.PASS}
    return replace(outcome, verdict=opposite.get(outcome.verdict, outcome.verdict))
