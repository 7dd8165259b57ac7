"""What is wrong, in a sentence: the words of a counterexample, without its tables."""

from __future__ import annotations

from collections.abc import Sequence

from checker.verdict import Counterexample, Verdict
from cspcheck.quantities import count
from cspcheck.result import Result

_LONGEST_NAME = 32


def sentence(result: Result) -> str:
    """Why the verdict is what it is, and what the script expects of it, without a full stop; empty for a plain pass."""
    why = _why(result)
    if result.expected is Verdict.PASS:
        return why
    if result.as_expected:
        return f"{_VERBS[result.verdict]}, as the script expects" + (f": {why}" if why else "")
    return f"{_VERBS[result.verdict]}, but the script expects `{result.expected}`" + (f": {why}" if why else "")


_VERBS = {Verdict.PASS: "it passes", Verdict.FAIL: "it fails", Verdict.UNKNOWN: "it is unknown", Verdict.ERROR: "error"}


def _why(result: Result) -> str:
    counterexample = result.counterexample
    if result.verdict is Verdict.ERROR:
        return result.reason or (result.diagnostics[0].message if result.diagnostics else "it could not be checked")
    if result.verdict is Verdict.UNKNOWN:
        return result.reason or "the search was not completed"
    if counterexample is not None:
        return _misbehaviour(result, counterexample)
    if result.verdict is Verdict.FAIL:
        return "what stands behind `not` holds" if result.negated else result.reason or "it is false"
    return ""


def _misbehaviour(result: Result, counterexample: Counterexample) -> str:
    process = _called(result.process, "the implementation" if result.specification is not None else "the process")
    specification = _called(result.specification, "the specification")
    event = f"`{counterexample.event}`"
    after = _after(counterexample)
    match counterexample.kind:
        case "deadlock":
            return f"{process} deadlocks {after}: nothing can happen, and it has not terminated"
        case "divergence":
            known = "" if result.specification is None else f", and {specification} does not"
            return f"{process} diverges {after}: it can go on for ever without a visible event{known}"
        case "nondeterminism":
            return f"{process} is not deterministic: {after} it can perform {event}, and it can refuse it"
        case "refusal" | "trace" if result.kind == "has trace":
            if possible(counterexample):
                return f"{process} need not perform the trace: {after} it can refuse {event}"
            return f"{process} does not have the trace: {after} it cannot perform {event}"
        case "trace":
            return f"{process} performs {event} {after}, and {specification} does not allow it"
        case "refusal":
            return f"{process} refuses {after} what {specification} must accept"
        case "obligation":
            return f"{process} does not meet its obligation" if result.process else "the obligation does not hold"


def _called(text: str | None, otherwise: str) -> str:
    return f"`{text}`" if text and len(text) <= _LONGEST_NAME else otherwise


def _after(counterexample: Counterexample) -> str:
    steps = len(counterexample.trace)
    if not steps:
        return "at once"
    hidden = counterexample.trace.count("tau")
    visible = count(steps - hidden, "event")
    internal = count(hidden, "internal step")
    if not hidden:
        return f"after {visible}"
    return f"after {internal}" if hidden == steps else f"after {visible} and {internal}"


def possible(counterexample: Counterexample) -> bool:
    """Whether the event of a counterexample can happen there at all."""
    return any(counterexample.event in events for events in counterexample.allowed or ())


def circle_sentence(circle: Sequence[str]) -> str:
    """``A waits for B, B waits for C, and C waits for A``."""
    if len(circle) == 1:
        return f"{circle[0]} waits for itself"
    steps = [f"{name} waits for {other}" for name, other in zip(circle, [*circle[1:], circle[0]], strict=True)]
    return ", ".join(steps[:-1]) + f", and {steps[-1]}"
