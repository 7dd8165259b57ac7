"""What is wrong, in a sentence: the words of a counterexample, without its tables."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.checker.verdict import TERMINATION_COUNTS, Counterexample, Verdict
from cspcheck.quantities import count
from cspcheck.result import Result

_LONGEST_NAME = 32


def sentence(result: Result) -> str:
    """Why the verdict is what it is, and what the script expects of it, without a full stop; empty for a plain pass."""
    reason = why(result)
    if result.expected is Verdict.PASS:
        return reason
    behind = f": {reason}" if reason else ""
    if result.as_expected:
        return f"{_VERBS[result.verdict]}, as the script expects{behind}"
    return f"{_VERBS[result.verdict]}, but the script expects `{result.expected}`{behind}"


_VERBS = {Verdict.PASS: "it passes", Verdict.FAIL: "it fails", Verdict.UNKNOWN: "it is unknown", Verdict.ERROR: "error"}


def why(result: Result) -> str:
    """Why the verdict is what it is, whatever the script expects; empty for a plain pass."""
    counterexample = result.counterexample
    if result.verdict is Verdict.ERROR:
        return result.reason or (result.diagnostics[0].message if result.diagnostics else "it could not be checked")
    if result.verdict is Verdict.UNKNOWN:
        return result.reason or "the search was not completed"
    if counterexample is not None:
        return _misbehaviour(result, counterexample)
    if result.verdict is Verdict.FAIL:
        return _denied(result) if result.negated else result.reason or "the condition is false"
    return ""


def _misbehaviour(result: Result, counterexample: Counterexample) -> str:
    process = _called(result.process, "the implementation" if result.specification is not None else "the process")
    specification = _called(result.specification, "the specification")
    event = f"`{counterexample.event}`"
    after = _after(counterexample)
    match counterexample.kind:
        case "deadlock":
            unless = "" if TERMINATION_COUNTS in result.remarks else ", and it has not terminated"
            return f"{process} deadlocks {after}: nothing can happen{unless}"
        case "divergence":
            known = "" if result.specification is None else f", and {specification} does not"
            return f"{process} diverges {after}: it can go on for ever without a visible event{known}"
        case "nondeterminism":
            shown = "an event" if counterexample.event is None else event
            return f"{process} is not deterministic: {after} it can perform {shown}, and it can refuse it"
        case "refusal" | "trace" if result.kind == "has trace":
            if possible(counterexample):
                return f"{process} need not perform the trace: {after} it can refuse {event}"
            return f"{process} does not have the trace: {after} it cannot perform {event}"
        case "trace":
            after += _on_the_way(counterexample)
            return f"{process} performs {event} {after}, and {specification} does not allow it"
        case "refusal" if result.model is not None and result.model[0] in "VR":
            return _observed(counterexample, process, specification, after)
        case "refusal":
            return _refusal(counterexample, process, specification, after)
        case "obligation":
            return _broken(counterexample)


def _observed(counterexample: Counterexample, process: str, specification: str, after: str) -> str:
    """``P offers only {a} after 2 events, so it refuses {b}, and then performs `a`, and Q does not allow that``."""
    offered, refused = counterexample.offered or (), counterexample.refusal or ()
    words = f"{process} offers {f'only {some(offered)}' if is_short(offered) else 'little'} {after}"
    words += _on_the_way(counterexample)
    if refused:
        words += f", so it refuses {some(refused) if is_short(refused) else count(len(refused), 'event')}"
    if counterexample.event is not None:
        words += f", and then performs `{counterexample.event}`"
    return f"{words}, and {specification} does not allow that"


def _on_the_way(counterexample: Counterexample) -> str:
    """In refusal testing, what had to be refused before other events for the behaviour to be wrong."""
    if counterexample.refusals is None:
        return ""
    seen = [
        f"{some(refused) if is_short(refused) else count(len(refused), 'event')} before event {number}"
        for number, (event, refused) in enumerate(_numbered(counterexample), 1)
        if refused is not None and event
    ]
    return f", having refused {' and '.join(seen)}" if seen else ""


def _numbered(counterexample: Counterexample) -> list[tuple[str, tuple[str, ...] | None]]:
    """The visible events of the trace, each with what was seen to be refused before it."""
    refusals = counterexample.refusals or (None,) * len(counterexample.trace)
    return [step for step in zip(counterexample.trace, refusals, strict=True) if step[0] != counterexample.tau]


def _broken(counterexample: Counterexample) -> str:
    broken = counterexample.obligation
    if broken is None:
        return "the obligation does not hold"
    place = f" of `{broken.operation}`" if broken.operation is not None else ""
    return f"`{broken.name}`{place} does not hold: {broken.message}"


def _denied(result: Result) -> str:
    """What holds although the assertion says that it does not."""
    process = _called(result.process, "the process")
    match result.kind:
        case "refinement":
            specification = _called(result.specification, "the specification")
            holds = f"{_called(result.process, 'the implementation')} refines {specification}"
        case "has trace":
            holds = f"{process} has the trace"
        case "boolean":
            holds = "the condition is true"
        case "data refinement" | "subclass":
            holds = f"{process} refines {_called(result.specification, 'the other class')}"
        case _ if result.model is None:
            holds = f"`{result.kind}` holds of {process}"
        case _:
            holds = f"{process} is {result.kind}"
    return f"{holds}, and `not` denies it"


def _refusal(counterexample: Counterexample, process: str, specification: str, after: str) -> str:
    """``P refuses {c} after 2 events: it offers only {b}, and Q must offer {b, c}``."""
    refused, offered, allowed = counterexample.refusal, counterexample.offered, counterexample.allowed
    what = (
        f" {some(refused)}" if refused and is_short(refused) else f" {count(len(refused), 'event')}" if refused else ""
    )
    words = f"{process} refuses{what} {after}"
    parts = []
    if offered is not None and is_short(offered):
        parts.append(f"it offers only {some(offered)}" if offered else "it offers nothing")
    if allowed is not None and not any(allowed):
        parts.append(f"{specification} is never stable there, so that it may refuse nothing")
    elif allowed is not None and are_few(allowed):
        parts.append(f"{specification} must offer {' or all of '.join(map(some, allowed))}")
    elif allowed is not None:
        parts.append(
            f"{specification} must offer all of one of {len(allowed):,} sets"
            if len(allowed) > 1
            else f"{specification} must offer {count(len(allowed[0]), 'event')}"
        )
    return words + (f": {', and '.join(parts)}" if parts else "")


_SHORT = 4


def is_short(events: Sequence[str]) -> bool:
    """Whether a set of events can be named in a sentence."""
    return len(events) <= _SHORT


def are_few(acceptances: Sequence[Sequence[str]]) -> bool:
    """Whether sets of events can be named in a sentence."""
    return len(acceptances) <= 2 and all(map(is_short, acceptances))


def some(events: Sequence[str]) -> str:
    """A set of events."""
    return "{" + ", ".join(events) + "}"


def _called(text: str | None, otherwise: str) -> str:
    return f"`{text}`" if text and len(text) <= _LONGEST_NAME else otherwise


def _after(counterexample: Counterexample) -> str:
    steps = len(counterexample.trace)
    if not steps:
        return "at once"
    hidden = counterexample.trace.count(counterexample.tau)
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


def stopped_sentence(names: Sequence[str]) -> str:
    """``A and B do nothing any more``, for a deadlock without a circle of waiting."""
    if len(names) == 1:
        return f"Nobody waits in a circle; {names[0]} offers nothing any more"
    if len(names) > _SHORT:
        return f"Nobody waits in a circle; {len(names):,} components offer nothing any more"
    return f"Nobody waits in a circle; {', '.join(names[:-1])} and {names[-1]} offer nothing any more"


def as_sentence(text: str) -> str:
    """Words with a capital letter and a full stop."""
    return f"{text[:1].upper()}{text[1:]}" + ("" if text.endswith((".", "…")) else ".")
