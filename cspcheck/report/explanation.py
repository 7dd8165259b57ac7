"""A counterexample as a person reads it: the sentence, the trace, what is refused, and who waits for whom."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from typing import Literal

from cspcheck.checker.verdict import ComponentBehaviour, Counterexample
from cspcheck.quantities import count
from cspcheck.report.obligation import obligation_lines, value_lines
from cspcheck.report.sentences import are_few, as_sentence, circle_sentence, is_short, sentence, stopped_sentence
from cspcheck.report.steps import folded, names, step_lines, step_text
from cspcheck.report.style import Style, columns, harmless, pad, wrapped
from cspcheck.result import Result

_ACCEPTANCES = 8
_EVENTS = 12
_NARROWEST = 12
ENDED = "(has ended)"
"""The state of a component that is not there any more at the end."""


Detail = Literal["sentence", "folded", "whole"]


def explanation(result: Result, style: Style, detail: Detail = "folded", hint: str = "") -> list[str]:
    """The lines that explain a result, without indentation; none for a plain pass.

    *detail*: the sentence alone; everything but with long traces, sets and states folded; everything whole. *hint*
    stands where something is folded and says how to see it.
    """
    words = sentence(result)
    if not words:
        return []
    lines = wrapped(as_sentence(words), style.width - 2)
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
        yield step_lines(self.result, self.counterexample, self.style, self.everything, self.hint)
        yield self._loop()
        yield self._refusal()
        yield self._values()
        yield self._obligation()
        yield self._waiting()
        yield self._components()

    def _loop(self) -> list[str]:
        if self.counterexample.loop is None:
            return []
        counterexample = self.counterexample
        tau = counterexample.tau
        steps = [step_text(tau, cause) for cause in counterexample.loop or ()]
        actors = [
            names(counterexample, parts, {tau, cause})
            for cause, parts in zip(counterexample.loop or (), counterexample.loop_parts, strict=False)
        ]
        width = max(map(columns, steps))
        lines = []
        for step, who in zip_longest(map(harmless, steps), map(harmless, actors), fillvalue=""):
            text = f"{pad(step, width)}  {self.style.paint(who, 'dim')}" if who else step
            lines.append(f"     {text if self.everything else self.style.fit(text, self.width - 5)}")
        head = "then for ever:" if counterexample.trace else "for ever:"
        return [head, *folded(lines, self.style, self.everything, self.hint)]

    def _refusal(self) -> list[str]:
        """What is refused there and what the specification accepts."""
        counterexample = self.counterexample
        lines = []
        if counterexample.kind == "nondeterminism":
            other = counterexample.alternative
            if other is not None:
                lines += wrapped(f"Another run performs it: <{', '.join(other)}>.", self.width)
        elif counterexample.kind == "refusal" and self.result.specification is not None:
            if counterexample.refusal is not None and not is_short(counterexample.refusal):
                lines += wrapped(f"The implementation refuses there {self._set(counterexample.refusal)}.", self.width)
            if counterexample.offered is not None and not is_short(counterexample.offered):
                lines += wrapped(f"It offers there only {self._set(counterexample.offered)}.", self.width)
            if counterexample.allowed is not None and not are_few(counterexample.allowed):
                lines += self._acceptances(counterexample.allowed)
        elif counterexample.kind in ("trace", "refusal") and counterexample.allowed is not None:
            events = tuple(dict.fromkeys(event for acceptance in counterexample.allowed for event in acceptance))
            who = "The specification allows there" if self.result.specification is not None else "Possible there:"
            lines += wrapped(f"{who} {self._set(events) if events else 'no event at all'}.", self.width)
        return lines

    def _acceptances(self, acceptances: Sequence[Sequence[str]]) -> list[str]:
        if len(acceptances) == 1:
            return wrapped(f"The specification offers there {self._set(acceptances[0])}.", self.width)
        shown = acceptances if self.everything else acceptances[:_ACCEPTANCES]
        lines = ["The specification offers there all of at least one of these sets:"]
        lines += [line for acceptance in shown for line in wrapped(self._set(acceptance), self.width, "  ", "   ")]
        if len(acceptances) > len(shown):
            lines.append(f"  {self.style.ellipsis} {count(len(acceptances) - len(shown), 'set')} not shown{self.hint}")
        return lines

    def _set(self, events: Sequence[str]) -> str:
        shown = list(events) if self.everything or len(events) <= _EVENTS else list(events[: _EVENTS - 2])
        if len(shown) < len(events):
            shown.append(f"{self.style.ellipsis} {len(events) - len(shown)} more")
        return "{" + ", ".join(shown) + "}"

    def _waiting(self) -> list[str]:
        """For a deadlock the circle of waiting, or who it is that others wait for in vain."""
        counterexample = self.counterexample
        if counterexample.waiting_cycle:
            return wrapped(circle_sentence(counterexample.waiting_cycle) + ".", self.width)
        present = [part for part in counterexample.components if part.state]
        stuck = [part.name for part in present if not part.offers]
        if counterexample.kind != "deadlock" or not stuck or len(present) == 1:
            return []
        return wrapped(stopped_sentence(stuck) + ".", self.width)

    def _values(self) -> list[str]:
        values = self.counterexample.values
        return value_lines(values, self.style, self.everything) if values else []

    def _obligation(self) -> list[str]:
        broken = self.counterexample.obligation
        return [] if broken is None else obligation_lines(broken, self.style, self.everything, self.hint)

    def _components(self) -> list[str]:
        """The table of components at the end; one stacked block each with *everything*."""
        components = self.counterexample.components
        if not components:
            return []
        if self.everything:
            return [line for component in components for line in self._stacked(component)]
        rows = [
            (
                c.name,
                str(c.line or ""),
                c.state or ENDED,
                ", ".join(c.offers) or ("nothing" if c.state else ""),
                ", ".join(c.waiting_for),
            )
            for c in components
        ]
        heads = ("component", "line", "state at the end", "offers", "waits for")
        kept = [i for i in range(5) if i in (0, 2, 3) or any(row[i] for row in rows)]
        widths = {i: max(columns(harmless(row[i])) for row in (heads, *rows)) for i in kept}
        room = self.width - 2 - 2 * (len(kept) - 1)
        # The widest columns give way first, and the names last.
        while sum(widths.values()) > room:
            able = [i for i in (2, 3, 4) if widths.get(i, 0) > (_NARROWEST if i > 2 else len(heads[2]))]
            widths[max(able, key=widths.__getitem__) if able else 0] -= 1
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
            ("state", component.state or ENDED),
        ]
        if component.state:
            parts.append(("offers", ", ".join(component.offers) or "nothing"))
        if component.waiting_for:
            parts.append(("waits for", ", ".join(component.waiting_for)))
        for head, text in parts:
            yield from wrapped(harmless(text), self.width, f"    {head:<11}", " " * 15)
