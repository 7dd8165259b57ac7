"""What comes of an obligation: a plain value, in the words of the specification."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from cspcheck.cspm.source import Span

Severity = Literal["error", "warning", "info"]
"""How much a refuted obligation matters: an error makes ``C :[obligations]`` fail."""

Status = Literal["proved", "refuted", "bounded", "unknown"]
"""``bounded``: not proved, but nothing speaks against it in the scopes that were searched."""


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """What a proof needed.

    Attributes:
        what: it is: ``invariant``, ``guard``, ``effect``, ``axiom``, ``carrier``, a lemma.
        text: what it says.
        span: the line that says it; None for what no line says, as that a variable is not in the Delta-list.
    """

    what: str
    text: str
    span: Span | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """The answer to one obligation.

    Attributes:
        obligation: its name, as in ``assert C :[invariant preserved]``.
        subject: the class, or the two classes of a refinement.
        operation: that it is about, None where it is about the class.
        detail: what of the operation: an invariant, a variable, an input value, an application.
        severity: how much it matters where it is refuted.
        status: proved, refuted, bounded or unknown.
        message: where it is refuted, what is wrong, in a sentence without a full stop; else what is to be known.
        values: of the counterexample, or of the witness where the obligation is that there is one: texts by name,
            in the order before, inputs, outputs, after.
        failing: text of the predicate that does not hold.
        lines: that cannot hold together.
        span: what the message points at.
        vacuous: what is assumed cannot be, so that the proof says nothing.
        vouched: texts of predicates that the solver alone says hold of the values.
        hypotheses: names of the lemmas and laws that the proof needed.
        used: the lines that the proof needed; None where that was not asked for, or where values are the proof.
        missing: names of lemmas that it was to use and that are not proved.
        scope: up to which size of sets and collections was searched (status ``bounded``).
        seconds: it took.
    """

    obligation: str
    subject: str
    operation: str | None = None
    detail: str = ""
    severity: Severity = "error"
    status: Status
    message: str = ""
    values: Mapping[str, str] = field(default_factory=dict)
    failing: str | None = None
    lines: tuple[Span, ...] = ()
    span: Span | None = None
    vacuous: bool = False
    vouched: tuple[str, ...] = ()
    hypotheses: tuple[str, ...] = ()
    used: tuple[Hypothesis, ...] | None = None
    missing: tuple[str, ...] = ()
    scope: int | None = None
    seconds: float = 0.0

    @property
    def place(self) -> str:
        """The operation and the detail, as a listing shows them."""
        return " ".join(part for part in (self.operation or "", self.detail) if part)


_ORDER: Mapping[Status, int] = {"refuted": 0, "unknown": 1, "bounded": 2, "proved": 3}


def worst_first(finding: Finding) -> int:
    """A key that puts what is wrong in front."""
    return _ORDER[finding.status]
