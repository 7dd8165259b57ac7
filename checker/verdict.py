"""Verdicts and the behaviours that justify them: plain values, event names as text, ready to be rendered."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from html import escape
from typing import TYPE_CHECKING, Final, Literal

from cspcheck.cspm.syntax.tree import Model, PropertyKind

if TYPE_CHECKING:
    from cspcheck.cspm.process.terms import Process


class Verdict(StrEnum):
    """``pass`` and ``fail`` are said of completed searches and proofs only; all else is ``unknown``."""

    PASS = "pass"
    FAIL = "fail"
    UNKNOWN = "unknown"
    ERROR = "error"


CounterexampleKind = Literal["trace", "refusal", "deadlock", "divergence", "nondeterminism", "obligation"]

DEFAULT_MODELS: Final[dict[PropertyKind, Model]] = {
    "deadlock free": "FD",
    "divergence free": "FD",
    "deterministic": "FD",
    "has trace": "T",
}
"""The model in which a property is looked at that names none."""


@dataclass(frozen=True, slots=True)
class ComponentBehaviour:
    """What one component did and can do.

    Attributes:
        name: its name in the script.
        trace: aligned with the counterexample's trace; None where it took no part.
        state: its state at the end, as a process expression.
        line: line of its definition, from 1, or None.
        offers: events it can perform on its own account at the end.
        waiting_for: names of the components that an offered event needs and that do not offer it.
        variables: of a class, at the beginning: values by name; empty for other processes.
        changes: aligned with the trace: of a class the variables that another value has after the step.
    """

    name: str
    trace: tuple[str | None, ...]
    state: str
    line: int | None
    offers: tuple[str, ...]
    waiting_for: tuple[str, ...]
    variables: Mapping[str, str] = field(default_factory=dict)
    changes: tuple[Mapping[str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class SpecificationRun:
    """What the specification of a refinement does while the implementation runs into its violation.

    Attributes:
        trace: its events in order, taus included; without these, the visible events of the counterexample.
        causes: aligned with ``trace``: for a hidden event the event it was, else None.
        states: its states as process expressions: before the first step and after each.
    """

    trace: tuple[str, ...]
    causes: tuple[str | None, ...]
    states: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ReplayedRun:
    """The run of a counterexample as terms: the process, and the events with the term after each."""

    process: Process
    steps: tuple[tuple[int, Process], ...]


@dataclass(frozen=True, slots=True)
class BrokenObligation:
    """A proof obligation that does not hold. Its values, if it has any, are those of the counterexample.

    Attributes:
        name: of the obligation, or of the rule of a refinement.
        subject: the class, or the refinement.
        operation: that it is about, or None.
        message: what is wrong, in a sentence without a full stop.
        line: where, from 1, or None.
        failing: text of the predicate that does not hold for the values, or None.
        lines: number and text of lines that cannot hold together.
        others: further obligations that do not hold, a line each.
    """

    name: str
    subject: str
    operation: str | None
    message: str
    line: int | None
    failing: str | None
    lines: tuple[tuple[int, str], ...]
    others: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Counterexample:
    """A behaviour that refutes an assertion.

    Attributes:
        kind: what is wrong at the end of ``trace``.
        trace: event names from the initial state, taus included as :attr:`tau`.
        causes: aligned with ``trace``: for a hidden event the event it was (``mid.0``), else None.
        event: the event that is not allowed (kind ``trace``) or both possible and refusable (``nondeterminism``).
        refusal: what is refused at the end (kinds ``refusal``, ``deadlock``, ``nondeterminism``), or None. For a
            refinement: the events of the specification's acceptances that the state does not offer.
        offered: for a refinement's refusal, what the state at the end can be relied on to offer.
        allowed: the acceptances that the specification allows there, or the events, or None.
        loop: the cycle of taus (kind ``divergence``) by their causes (:attr:`tau` where there is none).
        loop_parts: aligned with ``loop``: what the components that take part in each step perform, by name.
        refusals: in the models of refusal testing, aligned with ``trace``: what was seen to be refused before the step,
            None where nothing was looked at; None where no refusal on the way matters.
        components: the parts of the composition.
        specification_trace: for refinements the visible events of ``trace`` as the specification performs them.
        specification: for refinements a run of the specification with these events; None where finding one takes too
            long.
        event_parts: for kind ``trace`` what the components that take part in ``event`` perform, by name.
        values: named values (kind ``obligation``): before, inputs, outputs, after.
        obligation: what does not hold (kind ``obligation``).
        waiting_cycle: for a deadlock, names of components each of which waits for the next, the last for the first;
            None where there is no such cycle.
        alternative: for nondeterminism, another run with the visible events of ``trace`` and then ``event``, which
            the run of ``trace`` ends by refusing.
        tau: how the internal action is written here; not ``tau`` where a channel of the script has this name.
        run: the replayed run, for who wants to step through it; no part of what is told.
    """

    kind: CounterexampleKind
    trace: tuple[str, ...]
    causes: tuple[str | None, ...] = ()
    event: str | None = None
    refusal: tuple[str, ...] | None = None
    allowed: tuple[tuple[str, ...], ...] | None = None
    loop: tuple[str, ...] | None = None
    components: tuple[ComponentBehaviour, ...] = ()
    specification_trace: tuple[str, ...] | None = None
    specification: SpecificationRun | None = None
    event_parts: tuple[tuple[str, str], ...] = ()
    offered: tuple[str, ...] | None = None
    loop_parts: tuple[tuple[tuple[str, str], ...], ...] = ()
    values: dict[str, str] | None = None
    obligation: BrokenObligation | None = None
    waiting_cycle: tuple[str, ...] | None = None
    alternative: tuple[str, ...] | None = None
    run: ReplayedRun | None = field(default=None, compare=False, repr=False)
    refusals: tuple[tuple[str, ...] | None, ...] | None = None
    tau: str = "tau"

    def __repr__(self) -> str:
        end = "" if self.event is None else f", then {self.event}"
        return f"<cspcheck.Counterexample: {self.kind} after <{', '.join(self._steps())}>{end}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: the steps, and which components take part in each."""
        rows = []
        for index, step in enumerate(self._steps()):
            parts = [part.name for part in self.components if part.trace[index] is not None]
            rows.append((str(index + 1), step, ", ".join(parts)))
        if self.event is not None:
            rows.append(("", self.event, "not allowed" if self.kind == "trace" else "can be refused"))
        cells = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
        return f"<table><tr><th></th><th>event</th><th>{escape(self.kind)}</th></tr>{cells}</table>"

    def _steps(self) -> list[str]:
        """The trace, with what a tau hides in brackets."""
        causes = self.causes or (None,) * len(self.trace)
        return [name if cause is None else f"{name} ({cause})" for name, cause in zip(self.trace, causes, strict=True)]


Reduction = Literal["partial order"]


@dataclass(frozen=True, slots=True)
class EverySize:
    """What a verdict says of types that have another number of values (data independence).

    Attributes:
        type: the type, in which the processes are data independent: its values are passed on, perhaps compared.
        size: how many values it has here.
        sufficient: how many values are enough to tell for all larger sizes.
        least: from this size on the verdict is the same, if it tells.
        tests: whether values are compared.
        tells: whether *size* is enough.
        held, new: where values are compared, the most that are held at one time, and that come new in one step.
    """

    type: str
    size: int
    sufficient: int
    least: int
    tests: bool
    tells: bool
    held: int | None = None
    new: int | None = None


@dataclass(frozen=True, slots=True)
class Outcome:
    """The answer to one assertion.

    Attributes:
        verdict: of the assertion as written (``not`` applied).
        reason: why ``unknown`` or ``error``: one sentence, with what was covered.
        states, transitions: explored (for a refinement, pairs and their transitions).
        seconds: wall time that this assertion took.
        peak_memory_bytes: the engine's arrays at their largest, as far as this assertion needed them.
        counterexample: the behaviour that was found; for ``not`` the one that makes it pass.
        remarks: what is worth knowing and does not decide the verdict, a sentence each.
        readings: the finite readings of wide types under which the answer holds, as the script writes them.
        control: whether the answer is about the control view: classes without their data.
        every_size: of which types the size makes no difference, or which size would be enough to know.
        reduction: by what the search that gave the answer did without states, where the script asks for it.
    """

    verdict: Verdict
    reason: str | None
    states: int
    transitions: int
    seconds: float
    peak_memory_bytes: int
    counterexample: Counterexample | None = None
    remarks: tuple[str, ...] = ()
    readings: tuple[str, ...] = ()
    control: bool = False
    every_size: tuple[EverySize, ...] = ()
    reduction: Reduction | None = None


Termination = Literal["success", "deadlock"]
"""What a process that has terminated is to ``deadlock free``."""
TERMINATES = "the process may terminate, which is no deadlock here; FDR4 says that it is one (`--termination deadlock`)"
"""Remarks on answers that FDR4 gives otherwise."""
TERMINATION_COUNTS = "a process that has terminated counts as deadlocked, as in FDR4"
DIVERGENCE_COUNTS = "a process that diverges is not deterministic here; FDR4 does not look at divergence"


BY_STEPS = "told by a run of the fewest steps, internal ones counted: another may have fewer events"
BY_PARTIAL_ORDER = "searched by partial order: the states are those that were looked at, not all that there are"
UNORDERED_KIND = "such an assertion needs every state"
UNORDERED_FULL = "the whole space is asked for"
UNORDERED_PROCESS = "the process has priorities, one component only, or no taus that could wait"


@dataclass(frozen=True, slots=True)
class Limits:
    """Where a search gives up. None: no limit."""

    states: int | None = None
    seconds: float | None = None
    memory_bytes: int | None = None
