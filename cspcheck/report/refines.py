"""``cspcheck refines``: the output of FDR4's command line, as text and as the JSON that programs read from it.

The keys and the numbers of events are those of FDR4: 0 no event, 1 τ, 2 ✓, the others as they occur.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Final

from cspcheck.checker.verdict import Counterexample, CounterexampleKind, Verdict
from cspcheck.cspm.diagnostics import Diagnostic, Severity
from cspcheck.report.style import Style
from cspcheck.result import Result, Summary

NO_EVENT, TAU, TICK = 0, 1, 2
UNCHANGED: Final = "<unchanged>"
_TYPES: Final[dict[CounterexampleKind, str]] = {
    "trace": "trace",
    "refusal": "min_acceptance",
    "deadlock": "deadlock",
    "divergence": "divergence",
    "nondeterminism": "determinism",
    "obligation": "obligation",
}


class EventNumbers:
    """The numbers of the events of one document, given as they are asked for."""

    def __init__(self) -> None:
        self._numbers: dict[str, int] = {}

    def __call__(self, name: str) -> int:
        """The number of an event."""
        return self._numbers.setdefault(name, len(self._numbers) + TICK + 1)

    def names(self) -> dict[str, str]:
        """The event map: numbers, as text, with the names."""
        return {str(TAU): "τ", str(TICK): "✓", **{str(number): name for name, number in self._numbers.items()}}


class _Run:
    """A counterexample with its events as numbers."""

    def __init__(self, found: Counterexample, number: EventNumbers, reveal: bool) -> None:
        self._found = found
        self._number = number
        self._reveal = reveal

    def event(self, name: str | None, cause: str | None = None) -> int:
        """The number of a step; *cause* is what a tau hides."""
        if name is None:
            return NO_EVENT
        if name == self._found.tau:
            return self._number(cause) if self._reveal and cause is not None else TAU
        return TICK if name in ("tick", "✓") else self._number(name)

    def trace(self) -> list[int]:
        """The steps of the implementation."""
        causes = self._found.causes or (None,) * len(self._found.trace)
        return [self.event(name, cause) for name, cause in zip(self._found.trace, causes, strict=True)]

    def implementation(self, machine: str) -> dict[str, Any]:
        """What the process does that it must not."""
        found = self._found
        behaviour: dict[str, Any] = {"machine_name": machine, "type": "min_acceptance", "trace": self.trace()}
        if found.kind == "trace":
            behaviour |= {"type": "trace", "error_event": self.event(found.event)}
        elif found.kind == "divergence":
            behaviour |= {"type": "loop", "loop_index": len(found.trace)}
            behaviour["trace"] += [self.event(found.tau, cause) for cause in found.loop or ()]
        else:
            if found.event is not None:
                behaviour["error_event"] = self.event(found.event)
            behaviour["min_acceptance"] = [self.event(name) for name in found.offered or ()]
        children = [
            {
                "machine_name": component.name,
                "type": "trace",
                "trace": [self.event(name) for name in component.trace],
            }
            for component in found.components
        ]
        if len(children) > 1:
            behaviour["child_behaviours"] = children
        return behaviour

    def specification(self, machine: str) -> dict[str, Any]:
        """What the specification does beside it: no event, and no other state, where the process does a tau."""
        found = self._found
        behaviour: dict[str, Any] = {
            "machine_name": machine,
            "type": "min_acceptance" if found.kind == "refusal" else "trace",
            "error_event": NO_EVENT,
            "trace": [NO_EVENT if name == found.tau else self.event(name) for name in found.trace],
        }
        if found.allowed is not None:
            key = "acceptances" if found.kind == "refusal" else "allowed_events"
            behaviour[key] = [[self.event(name) for name in events] for events in found.allowed]
        if found.specification is not None:
            behaviour["states"] = self._states(found.specification.trace, found.specification.states)
        return behaviour

    def _states(self, trace: Sequence[str], states: Sequence[str]) -> list[str]:
        """The states of the specification, beside the steps of the implementation."""
        settled = [states[0]]  # after each visible event, and the taus that follow it
        for name, state in zip(trace, states[1:], strict=True):
            if name == self._found.tau:
                settled[-1] = state
            else:
                settled.append(state)
        beside = iter(settled)
        return [next(beside), *(UNCHANGED if name == self._found.tau else next(beside) for name in self._found.trace)]


def counterexample_object(result: Result, found: Counterexample, number: EventNumbers, reveal: bool) -> dict[str, Any]:
    """A counterexample as FDR4 writes it."""
    steps = _Run(found, number, reveal)
    behaviours = {"implementation_behaviour": steps.implementation(result.process)}
    if result.specification is not None:
        behaviours["specification_behaviour"] = steps.specification(result.specification)
    return {"type": _TYPES[found.kind], **behaviours}


def _wrongs(diagnostics: Iterable[Diagnostic], severity: Severity) -> list[str]:
    """The diagnostics of one severity, a text each."""
    return [_text(diagnostic) for diagnostic in diagnostics if diagnostic.severity is severity]


def _text(diagnostic: Diagnostic) -> str:
    span = diagnostic.span
    place = "" if span is None else f"{span.source.name}:{span.line}:{span.column}: "
    return place + diagnostic.message


def _errors(result: Result) -> list[str]:
    """Why there is no answer."""
    found = _wrongs(result.diagnostics, Severity.ERROR)
    undecided = result.verdict in (Verdict.UNKNOWN, Verdict.ERROR)
    return found or ([result.reason or str(result.verdict)] if undecided else [])


class RefinesJson:
    """The document of one file, on one line."""

    carries_diagnostics = True

    def __init__(self, write: Callable[[str], object], name: str, version: str, *, reveal: bool) -> None:
        self._write = write
        self._name = name
        self._version = version
        self._reveal = reveal
        self._number = EventNumbers()
        self._printed: tuple[str, ...] = ()
        self._results: list[dict[str, Any]] = []
        self._diagnostics: list[Diagnostic] = []

    def script(self, name: str, printed: Sequence[str] = ()) -> None:
        """What the file prints."""
        self._printed = tuple(printed)

    def diagnostics(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Errors and warnings of the file."""
        self._diagnostics.extend(diagnostics)

    def result(self, result: Result) -> None:
        """One assertion's answer; 1 is a pass, and nothing else is."""
        found = result.counterexample
        self._results.append(
            {
                "assertion_string": result.assertion,
                "errors": _errors(result),
                "is_negated": int(result.negated),
                "result": int(result.verdict is Verdict.PASS),
                "visited_states": result.states,
                "visited_transitions": result.transitions,
                "visited_plys": None,
                "counterexamples": []
                if found is None or found.kind == "obligation"
                else [counterexample_object(result, found, self._number, self._reveal)],
            }
        )

    def unreached(self, results: Sequence[Result]) -> None:
        """They have no answer."""
        for result in results:
            self.result(result)

    def end(self, summary: Summary, *, interrupted: bool = False) -> None:
        """Write the document."""
        document = {
            "copyright_notice": f"cspcheck {self._version}",
            "results": self._results,
            "print_statement_results": list(self._printed),
            "file_name": self._name,
            "event_map": self._number.names(),
            "warnings": _wrongs(self._diagnostics, Severity.WARNING),
            "errors": _wrongs(self._diagnostics, Severity.ERROR),
        }
        self._write(json.dumps(document, ensure_ascii=False) + "\n")


class RefinesText:
    """The answers as text, each with its numbers and, unless *brief*, its counterexample."""

    carries_diagnostics = False

    def __init__(self, write: Callable[[str], object], style: Style, *, brief: bool, reveal: bool) -> None:
        self._write = write
        self._style = style
        self._brief = brief
        self._reveal = reveal

    def script(self, name: str, printed: Sequence[str] = ()) -> None:
        """What the file prints."""
        for text in printed:
            self._write(text + "\n")

    def diagnostics(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Nothing: they go to standard error."""

    def result(self, result: Result) -> None:
        """One assertion's answer."""
        lines = [f"{result.assertion}:"]
        if result.verdict in (Verdict.PASS, Verdict.FAIL):
            word, color = ("Passed", "green") if result.verdict is Verdict.PASS else ("Failed", "red")
            lines.append(f"    Result: {self._style.paint(word, color)}")
            if not self._brief:
                lines += [f"    Visited States: {result.states}", f"    Visited Transitions: {result.transitions}"]
                if result.counterexample is not None and result.counterexample.kind != "obligation":
                    lines += ["    " + line for line in self._counterexample(result, result.counterexample)]
        else:
            lines += [f"    Error: {text}" for text in _errors(result)]
        self._write("\n".join(lines) + "\n")

    def unreached(self, results: Sequence[Result]) -> None:
        """They have no answer."""
        for result in results:
            self.result(result)

    def end(self, summary: Summary, *, interrupted: bool = False) -> None:
        """Nothing follows."""

    def _counterexample(self, result: Result, found: Counterexample) -> list[str]:
        number = EventNumbers()
        steps = counterexample_object(result, found, number, self._reveal)
        names = {NO_EVENT: "-", **{int(key): name for key, name in number.names().items()}}

        def events(numbers: Iterable[int], opening: str, closing: str) -> str:
            return opening + ", ".join(names[event] for event in numbers) + closing

        def behaviour(one: dict[str, Any]) -> list[str]:
            lines = [
                f"{one['machine_name']} ({_title(one['type'])} Behaviour):",
                f"    Trace: {events(one['trace'], '<', '>')}",
            ]
            if "loop_index" in one:
                lines.append(f"    Loops to: {one['loop_index']}")
            if one.get("error_event", NO_EVENT) != NO_EVENT:
                lines.append(f"    Error Event: {names[one['error_event']]}")
            if "min_acceptance" in one:
                lines.append(f"    Min Acceptance: {events(one['min_acceptance'], '{', '}')}")
            for child in one.get("child_behaviours", ()):
                lines += ["    " + line for line in behaviour(child)]
            return lines

        lines = [f"Counterexample ({_title(steps['type'])})"]
        if (specification := steps.get("specification_behaviour")) is not None:
            lines += ["    Specification Debug:", f"        Trace: {events(specification['trace'], '<', '>')}"]
            for key, words in (("allowed_events", "Available Events"), ("acceptances", "Acceptance")):
                lines += [f"        {words}: {events(allowed, '{', '}')}" for allowed in specification.get(key, ())]
        lines.append("    Implementation Debug:")
        return lines + ["        " + line for line in behaviour(steps["implementation_behaviour"])]


def _title(kind: str) -> str:
    return kind.replace("_", " ").title()
