"""The steps of a counterexample as a table: what the implementation does, and beside it what the specification does."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from cspcheck.checker.verdict import Counterexample
from cspcheck.quantities import count
from cspcheck.report.sentences import possible
from cspcheck.report.style import Style, columns, harmless, pad
from cspcheck.result import Result

LONG_TRACE = 40
"""Traces above this length are folded."""
_HEAD, _TAIL = 12, 20
_NARROWEST = 20


@dataclass(frozen=True, slots=True)
class _Row:
    """One line: a step of the implementation, a step of the specification, or both of the same event.

    ``specification`` is the state of the specification afterwards; ``remark`` says what is wrong with the step.
    """

    number: str = ""
    step: str = ""
    who: str = ""
    specification: str = ""
    remark: str = ""


def step_text(event: str, cause: str | None) -> str:
    """An event, and for a tau what was hidden in it: ``tau (mid.0)``."""
    return event if cause is None or cause == event else f"{event} ({cause})"


def step_lines(result: Result, counterexample: Counterexample, style: Style, whole: bool, hint: str) -> list[str]:
    """The lines of the table, without colour codes that a file would not want; none where nothing happens.

    Args:
        result: what is explained.
        counterexample: its behaviour.
        style: how it looks.
        whole: nothing is folded or cut.
        hint: how to see what is folded, in brackets with a space before it, or empty.
    """
    rows = list(_rows(result, counterexample, style))
    if not rows:
        return []
    width = style.width - 2
    number_width = max(len(row.number) for row in rows)
    step_width = min(max(columns(row.step) for row in rows), max(width // 2, _NARROWEST))
    beside = any(row.specification for row in rows)
    room = width - 2 - number_width - 2 - step_width - 2
    who_width = max(columns(row.who) for row in rows)
    if beside:
        theirs = max(columns(row.specification or row.remark) for row in rows)
        who_width = min(who_width, max(room - 2 - max(theirs, len("specification")), room // 2 - 1))
        # The head of the column needs room too.
        who_width = max(who_width, len("implementation") - step_width - 2)
    lines = []
    for row in rows:
        cells = [style.paint(row.number.rjust(number_width), "dim"), "  "]
        step, who, theirs_text = row.step, row.who, row.specification
        if not whole:
            step, who = style.fit(step, step_width), style.fit(who, who_width if beside else room)
            theirs_text = style.fit(theirs_text, room - who_width - 2)
        if row.remark:
            cells += [style.paint(step, "bold", "red"), " " * max(step_width - columns(step), 0), "  "]
            if beside or who:
                cells += [style.paint(pad(who, who_width), "dim"), "  "]
            cells.append(row.remark)
        else:
            cells += [pad(step, step_width), "  ", style.paint(pad(who, who_width) if beside else who, "dim")]
            cells += ["  ", theirs_text] if beside else []
        lines.append(f"  {''.join(cells)}".rstrip())
    lines = folded(lines, style, whole, hint)
    if beside:
        head = pad("implementation", step_width + 2 + who_width)
        lines.insert(0, "  " + " " * (number_width + 2) + style.paint(f"{head}  specification", "dim"))
    return lines


def folded(lines: list[str], style: Style, whole: bool, hint: str) -> list[str]:
    """The lines, the middle left out where they are many."""
    if whole or len(lines) <= LONG_TRACE:
        return lines
    missing = len(lines) - _HEAD - _TAIL
    note = style.paint(f"{style.ellipsis} {count(missing, 'step')} not shown{hint}", "dim")
    return [*lines[:_HEAD], f"  {note}", *lines[-_TAIL:]]


def _rows(result: Result, counterexample: Counterexample, style: Style) -> Iterator[_Row]:
    theirs = _Specification(counterexample)
    causes = counterexample.causes or (None,) * len(counterexample.trace)
    beginning = _beginning(counterexample)
    if beginning:
        yield _Row(who=harmless(beginning))
    for i, (event, cause) in enumerate(zip(counterexample.trace, causes, strict=True)):
        if event != counterexample.tau:
            yield from theirs.internal_steps()
        yield _Row(
            str(i + 1),
            harmless(step_text(event, cause)),
            harmless(_actors(counterexample, i)),
            theirs.step() if event != counterexample.tau else "",
        )
    yield from theirs.internal_steps()
    if counterexample.event is not None and counterexample.kind in ("trace", "refusal", "nondeterminism"):
        yield _Row(
            str(len(counterexample.trace) + 1),
            harmless(counterexample.event),
            harmless(names(counterexample, counterexample.event_parts, {counterexample.event})),
            remark=_what_is_wrong(result, counterexample, style),
        )


class _Specification:
    """The run of the specification, taken step by step."""

    def __init__(self, counterexample: Counterexample) -> None:
        run = counterexample.specification
        visible = any(event != counterexample.tau for event in counterexample.trace)
        self._steps = list(zip(run.trace, run.causes, run.states[1:], strict=True)) if run and visible else []
        self._next = 0
        self._tau = counterexample.tau

    def internal_steps(self) -> Iterator[_Row]:
        """Rows for the taus before the next event."""
        while self._next < len(self._steps) and self._steps[self._next][0] == self._tau:
            event, cause, state = self._steps[self._next]
            self._next += 1
            yield _Row(specification=harmless(f"{step_text(event, cause)}: {state}"))

    def step(self) -> str:
        """The state after the next event."""
        if self._next >= len(self._steps):
            return ""
        self._next += 1
        return harmless(self._steps[self._next - 1][2])


def _actors(counterexample: Counterexample, position: int) -> str:
    """Who of several components takes part in a step, with their own name of the event where it is another, and what
    the variables of classes are afterwards where the step has changed them.
    """
    shown = {counterexample.trace[position]}
    if counterexample.causes and (cause := counterexample.causes[position]) is not None:
        shown.add(cause)
    told, any_values = [], False
    for component in counterexample.components:
        own = component.trace[position]
        who = "" if own is None else names(counterexample, [(component.name, own)], shown)
        new = _values(component.changes[position]) if component.changes else ""
        any_values |= bool(new)
        told.append(f"{who or component.name}: {new}" if new and len(counterexample.components) > 1 else who or new)
    return ("; " if any_values else ", ").join([text for text in told if text])


def _beginning(counterexample: Counterexample) -> str:
    """What the variables of classes are at the beginning."""
    alone = len(counterexample.components) == 1
    classes = [component for component in counterexample.components if component.variables]
    texts = [(component.name, _values(component.variables)) for component in classes]
    return "; ".join(text if alone else f"{name}: {text}" for name, text in texts)


def _values(values: Mapping[str, str]) -> str:
    return ", ".join(f"{name} = {value}" for name, value in values.items())


def names(
    counterexample: Counterexample, parts: list[tuple[str, str]] | tuple[tuple[str, str], ...], shown: set[str]
) -> str:
    """Components by name, each with its own name of the event where it is none of those *shown*."""
    if len(counterexample.components) == 1:
        return ""
    return ", ".join(name if own in shown else f"{name} ({own})" for name, own in parts)


def _what_is_wrong(result: Result, counterexample: Counterexample, style: Style) -> str:
    arrow = "←" if style.unicode else "<-"
    match counterexample.kind:
        case "trace" if result.specification is not None:
            return f"{arrow} not allowed here"
        case "refusal" if counterexample.offered is not None:
            return f"{arrow} not allowed after that refusal"
        case "nondeterminism":
            return f"{arrow} can be refused here"
        case _:
            return f"{arrow} can be refused here" if possible(counterexample) else f"{arrow} not possible here"
