"""One assertion with its answer, and what the answers of a whole run add up to."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Literal

from cspcheck.checker.verdict import DEFAULT_MODELS, Counterexample, EverySize, Outcome, Verdict
from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.syntax import tree as syntax

if TYPE_CHECKING:
    from cspcheck.coverage import Coverage
    from cspcheck.cspm.script import Assertion


INTERRUPTED = "interrupted"
"""The reason of an unknown verdict where the run was stopped before there was one."""


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Result:
    """The answer to one assertion of a script. True exactly when the verdict is ``pass``.

    Attributes:
        file, line: where the assertion stands; line 0 for one that stands in no file.
        assertion: its text.
        kind: ``refinement``, ``boolean`` or the property (``deadlock free``); of the inner one under ``not``.
        model: ``T``, ``F``, ``FD`` and so on; None where there is none.
        negated: whether it is a ``not`` assertion.
        process: the process that it is about, as text (the implementation of a refinement).
        specification: the left side of a refinement, as text.
        expected: the verdict that the script asks for in a comment; ``pass`` without one.
        outcome: what the checker found.
        diagnostics: the errors met while checking (verdict ``error``).
        coverage: what never happened in a check that passed, where that was asked for.
        machine: a picture of the machine of ``process`` as SVG, where a report asks for one and it is small.
    """

    file: str
    line: int
    assertion: str
    kind: str
    model: str | None
    outcome: Outcome
    negated: bool = False
    process: str = ""
    specification: str | None = None
    expected: Verdict = Verdict.PASS
    diagnostics: tuple[Diagnostic, ...] = ()
    coverage: Coverage | None = None
    machine: str | None = None

    def __bool__(self) -> bool:
        return self.verdict is Verdict.PASS

    @property
    def verdict(self) -> Verdict:
        """``pass``, ``fail``, ``unknown`` or ``error``."""
        return self.outcome.verdict

    @property
    def reason(self) -> str | None:
        """Why the verdict is ``unknown`` or ``error``."""
        return self.outcome.reason

    @property
    def states(self) -> int:
        """States explored."""
        return self.outcome.states

    @property
    def transitions(self) -> int:
        """Transitions explored."""
        return self.outcome.transitions

    @property
    def seconds(self) -> float:
        """Wall time of this assertion."""
        return self.outcome.seconds

    @property
    def peak_memory_bytes(self) -> int:
        """The engine's arrays at their largest."""
        return self.outcome.peak_memory_bytes

    @property
    def counterexample(self) -> Counterexample | None:
        """The behaviour that decides the verdict, if there is one."""
        return self.outcome.counterexample

    @property
    def readings(self) -> tuple[str, ...]:
        """The finite readings of wide types under which the answer holds."""
        return self.outcome.readings

    @property
    def control(self) -> bool:
        """Whether the answer is about the control view: classes without their data."""
        return self.outcome.control

    @property
    def every_size(self) -> tuple[EverySize, ...]:
        """Of which types the size makes no difference, or which size would be enough to know."""
        return self.outcome.every_size

    @property
    def as_expected(self) -> bool:
        """Whether the verdict is the one that the script expects."""
        return self.verdict is self.expected

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is worth knowing and does not decide the verdict."""
        return self.outcome.remarks

    def __repr__(self) -> str:
        place = f"{self.file}:{self.line}: " if self.line else ""
        return f"<cspcheck.Result {place}{self.assertion}: {self.verdict}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: the explanation, and a counterexample as a sequence chart."""
        from html import escape

        chart = self.chart()
        return f"<pre>{escape(self.explain())}</pre>" + (chart or "")

    def chart(self) -> str | None:
        """The counterexample as a sequence chart, an SVG document; None where there is no run to be drawn."""
        if self.counterexample is None or self.counterexample.kind == "obligation":
            return None
        from cspcheck.drawing import sequence

        return sequence.render(self.assertion, self.counterexample)

    def explain(self) -> str:
        """What the command line shows for this assertion: verdict, counterexample, components. No colour."""
        from cspcheck.report.full import explain

        return explain(self)


def answer(assertion: Assertion, outcome: Outcome, diagnostics: Iterable[Diagnostic] = ()) -> Result:
    """The result for an assertion of a loaded script."""
    kind, model, negated, process, specification = _shape(assertion.node)
    return Result(
        file=assertion.span.source.name,
        line=assertion.span.line,
        assertion=assertion.text,
        kind=kind,
        model=model,
        outcome=outcome,
        negated=negated,
        process=process,
        specification=specification,
        expected=Verdict(assertion.expected or "pass"),
        diagnostics=tuple(diagnostics),
    )


def _shape(node: syntax.Assertion) -> tuple[str, str | None, bool, str, str | None]:
    """Kind, model, whether negated, the process and the specification of an assertion."""
    negated = False
    while isinstance(node, syntax.NotAssertion):
        node, negated = node.inner, not negated
    match node:
        case syntax.Refinement():
            return "refinement", node.model, negated, _one_line(node.implementation), _one_line(node.specification)
        case syntax.Property():
            return node.kind, node.model or DEFAULT_MODELS[node.kind], negated, _one_line(node.process), None
        case syntax.BooleanAssertion():
            return "boolean", None, negated, "", None
    return _proved_shape(node, negated)


def _proved_shape(node: syntax.Assertion, negated: bool) -> tuple[str, str | None, bool, str, str | None]:
    """The same for an assertion about classes."""
    from cspcheck.cspm.oz.syntax import (  # only scripts with classes pay for their syntax
        DataRefinement,
        Obligations,
        Subtype,
    )

    match node:
        case Obligations():
            return node.obligation or "obligations", None, negated, node.subject.name, None
        case DataRefinement():
            return "data refinement", None, negated, node.concrete.name, node.abstract.name
        case Subtype():
            return "subclass", None, negated, node.child.name, node.parent.name
    raise TypeError(f"not an assertion: {node!r}")


def _one_line(expression: syntax.Expr) -> str:
    from cspcheck.cspm.printing.printer import print_expression

    return " ".join(print_expression(expression).split())


class Exit(IntEnum):
    """What the exit code of the command says."""

    OK = 0
    FAILED = 1
    NOT_RUN = 2
    UNKNOWN = 3
    INTERNAL = 4
    NOTHING = 5
    INTERRUPTED = 130


_WORST_FIRST = (Exit.INTERRUPTED, Exit.INTERNAL, Exit.NOT_RUN, Exit.FAILED, Exit.UNKNOWN, Exit.NOTHING, Exit.OK)


def worst(codes: Iterable[Exit]) -> Exit:
    """The exit code that wins; OK of none."""
    return min(codes, key=_WORST_FIRST.index, default=Exit.OK)


def exit_of(result: Result) -> Exit:
    """What one result means for the exit code.

    A verdict that the script expects is in order. Any other decided verdict fails, also a ``pass`` where the script
    expects a failure: the script claims something that is not so.
    """
    if result.verdict is Verdict.ERROR:
        return Exit.NOT_RUN
    if result.as_expected:
        return Exit.OK
    return Exit.UNKNOWN if result.verdict is Verdict.UNKNOWN else Exit.FAILED


@dataclass(slots=True)
class Summary:
    """Counts over a run, as results come in.

    Attributes:
        verdicts: results by verdict; ``error`` also counts the scripts that could not be loaded.
        unexpected: results whose verdict is not the one that the script expects.
        seconds: wall time of the run.
        errors: errors that were told, of which a script can have several.
        unreached: of the unknown ones, those that the run was interrupted before.
    """

    verdicts: dict[Literal["pass", "fail", "unknown", "error"], int]
    unexpected: int = 0
    seconds: float = 0.0
    unreached: int = 0
    errors: int = 0

    @classmethod
    def empty(cls) -> Summary:
        """The summary of nothing."""
        return cls({"pass": 0, "fail": 0, "unknown": 0, "error": 0})

    def add(self, result: Result) -> None:
        """Count a result."""
        self.verdicts[result.verdict.value] += 1
        self.unexpected += not result.as_expected
        self.unreached += result.reason == INTERRUPTED

    def add_broken_script(self) -> None:
        """Count a script that could not be loaded."""
        self.verdicts["error"] += 1
        self.unexpected += 1
