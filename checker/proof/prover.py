"""Claims about one class, answered: the ground that all obligations stand on."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from cspcheck.checker.proof.client import Solver
from cspcheck.checker.proof.finding import Finding, Severity, Status
from cspcheck.checker.proof.question import Answer, Found, Impossible, NotUpTo, Part, Question, Settings, Unanswered
from cspcheck.checker.proof.situation import Situation
from cspcheck.checker.proof.terms import all_of, negation
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Term, Variable
from cspcheck.cspm.oz.writing.core_text import text, written
from cspcheck.cspm.source import Span


class Prover:
    """Answers claims about one class of a specification.

    Args:
        specification, model: what the claims are about.
        settings: how hard to try.
        clock: tells the seconds.
    """

    def __init__(
        self,
        specification: core.Specification,
        model: core.ClassModel,
        settings: Settings | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.situation = Situation(specification, model)
        self.solver = Solver(specification, model, settings, clock)
        self.clock = clock
        self._possible: dict[tuple[str, str], Answer] = {}

    @property
    def model(self) -> core.ClassModel:
        """The class."""
        return self.situation.model

    @property
    def specification(self) -> core.Specification:
        """The specification."""
        return self.situation.specification

    # --- asking ------------------------------------------------------------------------------------------------------

    def find(self, parts: Iterable[Part], shown: Iterable[Variable] = ()) -> Answer:
        """Values that satisfy *parts*, and the constants' axioms with them."""
        whole = self.situation.with_constants(parts)
        variables = (*self.situation.constant_variables(whole), *shown)
        return self.solver.ask(Question(whole, variables))

    def refutes(self, premises: Iterable[Part], goal: Term, shown: Iterable[Variable] = ()) -> Answer:
        """Values that satisfy *premises*, but not *goal*."""
        return self.find([*premises, self.fails(goal)], shown)

    def fails(self, goal: Term) -> Part:
        """That a predicate is false or undefined."""
        return Part(negation(all_of(self.solver.definedness.holding([goal]))), "claim", goal.span, total=True)

    def performed(self, operation: core.Operation) -> Answer:
        """Whether the operation can ever be performed; asked once."""
        known = self._possible.get(("step", operation.name))
        if known is None:
            step = self.situation.step(operation)
            known = self.find(step, self.situation.shown(operation))
            self._possible["step", operation.name] = known
        return known

    def inhabited(self) -> Answer:
        """Whether there is a state; asked once."""
        known = self._possible.get(("state", ""))
        if known is None:
            known = self.find(self.situation.state(), self.situation.shown())
            self._possible["state", ""] = known
        return known

    # --- telling -----------------------------------------------------------------------------------------------------

    def lines(self, parts: Iterable[Part]) -> tuple[Span, ...]:
        """The lines that cannot hold together, of parts that cannot."""
        conflict = self.solver.conflict(self.situation.with_constants(parts))
        spans = {(s.start, s.end): s for s in (part.span for part in conflict) if s is not None}
        return tuple(spans[k] for k in sorted(spans))


class Report:
    """Makes the findings of one obligation.

    Args:
        prover: for the class and its clock.
        obligation: the name.
        severity: of a refutation.
    """

    def __init__(self, prover: Prover, obligation: str, severity: Severity) -> None:
        self._prover = prover
        self._obligation = obligation
        self._severity = severity
        self._start = prover.clock()

    def finding(self, status: Status, operation: core.Operation | None = None, **more: object) -> Finding:
        """A finding; the time since the last one is its time."""
        now = self._prover.clock()
        seconds, self._start = now - self._start, now
        name = operation.name if operation is not None else None
        return Finding(
            obligation=self._obligation,
            subject=self._prover.model.name,
            operation=name,
            severity=self._severity,
            status=status,
            seconds=seconds,
            **more,  # type: ignore[arg-type]
        )

    def universal(
        self,
        answer: Answer,
        operation: core.Operation | None = None,
        *,
        message: str,
        goal: Term | None = None,
        **more: object,
    ) -> Finding:
        """The finding for an answer that would be a counterexample."""
        match answer:
            case Impossible():
                return self.finding("proved", operation, **more)
            case Found():
                failing = text(goal) if goal is not None else None
                return self.finding("refuted", operation, message=message, failing=failing, **_told(answer), **more)
            case NotUpTo(scope=scope, reason=reason):
                said = f"not proved ({reason}); no counterexample with at most {scope} elements"
                return self.finding("bounded", operation, message=said, scope=scope, **more)
            case Unanswered(reason=reason):
                return self.finding("unknown", operation, message=reason, **more)

    def existential(
        self, answer: Answer, operation: core.Operation | None = None, *, message: str, **more: object
    ) -> Finding:
        """The finding for an answer that would be a witness."""
        match answer:
            case Found():
                more.pop("lines", None)
                return self.finding("proved", operation, **_told(answer), **more)
            case Impossible():
                return self.finding("refuted", operation, message=message, **more)
            case NotUpTo(scope=scope, reason=reason):
                said = f"{reason}; no values found with at most {scope} elements"
                return self.finding("unknown", operation, message=said, **more)
            case Unanswered(reason=reason):
                return self.finding("unknown", operation, message=reason, **more)


def _told(found: Found) -> dict[str, object]:
    return {
        "values": values_of(found),
        "vouched": tuple(text(part.term) for part in found.vouched),
    }


def values_of(found: Found) -> dict[str, str]:
    """The values as texts by the names that the specification uses; internal variables left out."""
    return {written(variable): text(value) for variable, value in found.values.items() if variable.role != "bound"}
