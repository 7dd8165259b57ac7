"""A broken obligation as a person reads it: the values of the step, what fails, the lines that exclude each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cspcheck.checker.verdict import BrokenObligation
from cspcheck.report.style import Style, columns, harmless, pad, wrapped

_MOST_LINES = 12


def value_lines(values: Mapping[str, str], style: Style, everything: bool) -> list[str]:
    """The values, headed by what they are: before, input, output, after; in the order given."""
    shown = {harmless(name): harmless(value) for name, value in values.items()}
    heads = [_head(name, set(values)) for name in values]
    head_width = max(map(columns, heads))
    name_width = max(map(columns, shown))
    lines = []
    last = None
    for head, (name, value) in zip(heads, shown.items(), strict=True):
        prefix = pad("" if head == last else head, head_width)
        last = head
        line = f"  {style.paint(prefix, 'dim')}  {pad(name, name_width)} = {value}"
        lines.append(line if everything else style.fit(line, style.width - 2))
    return lines


def _head(name: str, names: set[str]) -> str:
    if name.endswith("'"):
        return "after"
    if name.endswith("?"):
        return "input"
    if name.endswith("!"):
        return "output"
    return "before" if f"{name}'" in names else "value"


def hypothesis_lines(hypotheses: Sequence[tuple[int | None, str, str]], style: Style) -> list[str]:
    """What a proof needed: the number of a line (None: no line says it), its text, what it is."""
    if not hypotheses:
        return ["No line beside the claim itself was needed."]
    numbers = [f"{number}" if number is not None else "" for number, _, _ in hypotheses]
    width = max(map(len, numbers))
    texts = max(columns(harmless(text)) for _, text, _ in hypotheses)
    lines = ["What was needed:"]
    for shown, (number, text, what) in zip(numbers, hypotheses, strict=True):
        kind = "" if number is None else f"  {style.paint(harmless(what), 'dim')}"
        said = pad(harmless(text), min(texts, 48)) if kind else harmless(text)
        lines.append(f"  {style.paint(f'{shown:>{width}}', 'dim')}  {said}{kind}")
    return lines


def obligation_lines(broken: BrokenObligation, style: Style, everything: bool, hint: str) -> list[str]:
    """What fails, the lines that cannot hold together, and the other obligations that do not hold."""
    width = style.width - 2
    lines: list[str] = []
    if broken.failing is not None:
        lines += wrapped(f"There `{harmless(broken.failing)}` does not hold.", width)
    if broken.lines:
        many = len(broken.lines) > 1
        lines.append("These lines cannot hold together:" if many else "The reason is this line:")
        shown = broken.lines if everything else broken.lines[:_MOST_LINES]
        number_width = max(len(str(number)) for number, _ in shown)
        for number, text in shown:
            line = f"  {style.paint(f'{number:>{number_width}}', 'dim')}  {harmless(text)}"
            lines.append(line if everything else style.fit(line, width))
        if len(shown) < len(broken.lines):
            lines.append(f"  {style.ellipsis} {len(broken.lines) - len(shown)} more{hint}")
    if broken.others:
        lines.append("Nor do these hold:" if lines else "These do not hold either:")
        for other in broken.others:
            lines += wrapped(harmless(other), width, "  ", "    ")
    return lines
