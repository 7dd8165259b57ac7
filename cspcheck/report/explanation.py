"""A counterexample as a person reads it: the sentence, the trace, what is refused, and who waits for whom."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from typing import Literal

from checker.verdict import ComponentBehaviour, Counterexample
from cspcheck.quantities import count
from cspcheck.report.sentences import circle_sentence, possible, sentence
from cspcheck.report.style import Style, columns, harmless, pad
from cspcheck.result import Result

LONG_TRACE = 40
"""Traces above this length are folded."""
_HEAD, _TAIL = 12, 20
_ACCEPTANCES = 8
_EVENTS = 12
_LOWEST_STATE = 16


Detail = Literal["sentence", "folded", "whole"]


def explanation(result: Result, style: Style, detail: Detail = "folded", hint: str = "") -> list[str]:
    """The lines that explain a result, without indentation; none for a plain pass.

    *detail*: the sentence alone; everything but with long traces, sets and states folded; everything whole. *hint*
    stands where something is folded and says how to see it.
    """
    words = sentence(result)
    if not words:
        return []
    lines = _wrap(_sentence_case(words), style.width - 2)
    if result.counterexample is not None and detail != "sentence":
        for block in _Explanation(result, result.counterexample, style, detail == "whole", hint).blocks():
            if block:
                lines.append("")
                lines.extend(block)
    return lines


class _Explanation:
    """The blocks of lines below the sentence."""

    def __init__(
        self, result: Result, counterexample: Counterexample, style: Style, everything: bool, hint: str
    ) -> None:
        self.result = result
        self.counterexample = counterexample
        self.style = style
        self.everything = everything
        self.hint = f" ({hint})" if hint else ""
        self.width = style.width - 2

    def blocks(self) -> Iterator[list[str]]:
        yield self._trace()
        yield self._loop()
        yield self._refusal()
        yield self._values()
        if self.counterexample.waiting_cycle:
            yield _wrap(circle_sentence(self.counterexample.waiting_cycle) + ".", self.width)
        yield self._components()

    def _trace(self) -> list[str]:
        """A numbered row for each step: the event, the cause of a tau, and who takes part."""
        counterexample = self.counterexample
        steps = [
            _step(event, cause)
            for event, cause in zip(
                counterexample.trace, counterexample.causes or (None,) * len(counterexample.trace), strict=True
            )
        ]
        steps = list(map(harmless, steps))
        actors = [harmless(self._actors(i)) for i in range(len(steps))]
        marks = ["plain"] * len(steps)
        if counterexample.event is not None and counterexample.kind in ("trace", "refusal", "nondeterminism"):
            steps.append(harmless(counterexample.event))
            actors.append("")
            marks.append("wrong")
        if not steps:
            return []
        number_width = len(str(len(steps)))
        event_width = min(max(map(columns, steps)), max(self.width // 2, 20))
        rows = []
        for i, (step, who, mark) in enumerate(zip(steps, actors, marks, strict=True)):
            text = self.style.paint(f"{i + 1:>{number_width}}", "dim") + "  "
            if mark == "wrong":
                text += self.style.paint(step, "bold", "red")
                text += " " * max(event_width - columns(step), 0) + f"  {self._what_is_wrong()}"
            else:
                room = self.width - number_width - 2 - event_width - 4
                if not self.everything:
                    step, who = self.style.fit(step, event_width), self.style.fit(who, room)
                text += pad(step, event_width) + "  " + self.style.paint(who, "dim")
            rows.append("  " + text.rstrip())
        return self._folded(rows)

    def _what_is_wrong(self) -> str:
        arrow = "←" if self.style.unicode else "<-"
        match self.counterexample.kind:
            case "trace" if self.result.specification is not None:
                return f"{arrow} not allowed here"
            case "nondeterminism":
                return f"{arrow} refused here, and possible"
            case _:
                return f"{arrow} can be refused here" if possible(self.counterexample) else f"{arrow} not possible here"

    def _folded(self, rows: list[str]) -> list[str]:
        if self.everything or len(rows) <= LONG_TRACE:
            return rows
        missing = len(rows) - _HEAD - _TAIL
        note = self.style.paint(f"{self.style.ellipsis} {count(missing, 'step')} not shown{self.hint}", "dim")
        return [*rows[:_HEAD], f"  {note}", *rows[-_TAIL:]]

    def _actors(self, position: int) -> str:
        """Who of several components takes part in a step, with their own name of the event where it is another."""
        counterexample = self.counterexample
        if len(counterexample.components) == 1:
            return ""
        shown = {counterexample.trace[position]}
        if counterexample.causes and (cause := counterexample.causes[position]) is not None:
            shown.add(cause)
        names = []
        for component in counterexample.components:
            own = component.trace[position]
            if own is not None:
                names.append(component.name if own in shown else f"{component.name} ({own})")
        return ", ".join(names)

    def _loop(self) -> list[str]:
        if self.counterexample.loop is None:
            return []
        steps = [_step("tau", None if cause == "tau" else cause) for cause in self.counterexample.loop]
        head = "then for ever:" if self.counterexample.trace else "for ever:"
        return [head, *self._folded([f"     {harmless(step)}" for step in steps])]

    def _refusal(self) -> list[str]:
        """What is refused there and what the specification accepts."""
        counterexample = self.counterexample
        lines = []
        if counterexample.kind == "nondeterminism":
            other = counterexample.alternative
            if other is not None and other != (*counterexample.trace, counterexample.event):
                lines += _wrap(f"Another run performs it: <{', '.join(other)}>.", self.width)
        elif counterexample.kind == "refusal" and self.result.specification is not None:
            if counterexample.refusal is not None:
                lines += _wrap(f"The implementation refuses there {self._set(counterexample.refusal)}.", self.width)
            if counterexample.allowed is not None:
                lines.append("The specification accepts there at least one of these sets in full:")
                lines += self._acceptances(counterexample.allowed)
        elif counterexample.kind in ("trace", "refusal") and counterexample.allowed is not None:
            events = tuple(dict.fromkeys(event for acceptance in counterexample.allowed for event in acceptance))
            who = "The specification allows" if self.result.specification is not None else "Possible are"
            lines += _wrap(f"{who} there {self._set(events) if events else 'no event at all'}.", self.width)
        return lines

    def _acceptances(self, acceptances: Sequence[Sequence[str]]) -> list[str]:
        shown = acceptances if self.everything else acceptances[:_ACCEPTANCES]
        lines = [line for acceptance in shown for line in _wrap(self._set(acceptance), self.width, "  ", "   ")]
        if len(acceptances) > len(shown):
            lines.append(f"  {self.style.ellipsis} {count(len(acceptances) - len(shown), 'set')} not shown{self.hint}")
        return lines

    def _set(self, events: Sequence[str]) -> str:
        shown = list(events) if self.everything or len(events) <= _EVENTS else list(events[: _EVENTS - 2])
        if len(shown) < len(events):
            shown.append(f"{self.style.ellipsis} {len(events) - len(shown)} more")
        return "{" + ", ".join(shown) + "}"

    def _values(self) -> list[str]:
        values = self.counterexample.values
        if not values:
            return []
        width = max(map(columns, values))
        return [f"  {pad(harmless(name), width)} = {harmless(value)}" for name, value in values.items()]

    def _components(self) -> list[str]:
        """The table of components at the end; one stacked block each with *everything*."""
        components = self.counterexample.components
        if not components:
            return []
        if self.everything:
            return [line for component in components for line in self._stacked(component)]
        rows = [
            (c.name, str(c.line or ""), c.state, ", ".join(c.offers) or "nothing", ", ".join(c.waiting_for))
            for c in components
        ]
        heads = ("component", "line", "state at the end", "offers", "waits for")
        kept = [i for i in range(5) if i in (0, 2, 3) or any(row[i] for row in rows)]
        widths = {i: max(columns(harmless(row[i])) for row in (heads, *rows)) for i in kept}
        room = self.width - 2 - 2 * (len(kept) - 1)
        for i, least in ((2, _LOWEST_STATE), (3, 14), (4, 14), (0, 12)):
            if i in widths and (excess := sum(widths.values()) - room) > 0:
                widths[i] = max(min(least, widths[i]), widths[i] - excess)
        lines = ["  " + self.style.paint("  ".join(pad(heads[i], widths[i]) for i in kept).rstrip(), "dim")]
        for row in rows:
            cells = [pad(self.style.fit(harmless(row[i]), widths[i]), widths[i]) for i in kept]
            lines.append("  " + "  ".join(cells).rstrip())
        return lines

    def _stacked(self, component: ComponentBehaviour) -> Iterator[str]:
        place = f" (line {component.line})" if component.line else ""
        yield f"  {self.style.paint(harmless(component.name), 'bold')}{place}"
        own = [event for event in component.trace if event is not None]
        parts = [
            ("trace", f"<{', '.join(own)}>"),
            ("state", component.state),
            ("offers", ", ".join(component.offers) or "nothing"),
        ]
        if component.waiting_for:
            parts.append(("waits for", ", ".join(component.waiting_for)))
        for head, text in parts:
            yield from _wrap(harmless(text), self.width, f"    {head:<11}", " " * 15)


def _step(event: str, cause: str | None) -> str:
    return event if cause is None or cause == event else f"{event} ({cause})"


def _sentence_case(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}" + ("" if text.endswith((".", "…")) else ".")


def _wrap(text: str, width: int, first: str = "", rest: str = "") -> list[str]:
    return textwrap.wrap(
        harmless(text),
        max(width, 30),
        initial_indent=first,
        subsequent_indent=rest,
        break_long_words=False,
        break_on_hyphens=False,
    )
