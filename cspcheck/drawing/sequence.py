"""A counterexample as a message-sequence chart: one line of life a component, one row an event."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, zip_longest

from cspcheck.checker.verdict import Counterexample
from cspcheck.drawing.svg import BASELINE, LINE_HEIGHT, document, text_width
from cspcheck.drawing.text import escape
from cspcheck.report.steps import step_text

ROW = 30.0
HEAD = 30.0
COLUMN_GAP = 24.0
_LONGEST_VALUE = 48
"""Characters of a variable with its value; what is longer is cut."""

CHART_STYLE = """<style>
.life { stroke: #9aa5b1; stroke-width: 1; }
.message { stroke: #33658a; stroke-width: 1.6; }
.message.hidden { stroke-dasharray: 4 3; }
.part { fill: #33658a; }
.bad { fill: #b3261e; }
.message.wrong { stroke: #b3261e; }
.part.wrong, .label.wrong { fill: #b3261e; }
.label.hidden { fill: #52606d; }
.value { fill: #2e7d32; }
.loop { fill: none; stroke: #b3261e; stroke-dasharray: 2 3; }
</style>"""


@dataclass(frozen=True, slots=True)
class _Row:
    """One event: its words, the columns of those who take part, and how it looks.

    ``values`` are, for the columns of classes, the variables with the values that they have afterwards, where those are
    new. Without columns it is no event, but the beginning.
    """

    label: str
    columns: tuple[int, ...]
    style: str = ""
    values: Mapping[int, tuple[str, ...]] = field(default_factory=dict)

    @property
    def height(self) -> float:
        """How much room it needs from the top to the bottom."""
        lines = max(map(len, self.values.values()), default=0)
        return (ROW if self.columns else 0) + lines * LINE_HEIGHT


def render(title: str, counterexample: Counterexample) -> str:
    """The chart as an SVG document.

    Participants of an event are dots on its row joined by a line; a hidden event is dashed and says what it was. A loop
    of hidden events stands in a frame, an event that is not allowed is red. Beside the line of a class stand its
    variables: their values at the beginning, and behind an event those that are new. Below stands what is wrong at the
    end.
    """
    names = [component.name for component in counterexample.components] or ["process"]
    run = list(_run(counterexample))
    loop = list(_loop(counterexample, names))
    rows = run + loop
    boxes = [text_width(name) + 20 for name in names]
    centres = _columns(boxes, rows)
    tops = list(accumulate((row.height for row in rows), initial=HEAD + ROW / 4))
    height = tops[-1] + 1.25 * ROW
    life = height - ROW / 2
    parts = [CHART_STYLE]
    for name, box, x in zip(names, boxes, centres, strict=True):
        corner = f'x="{x - box / 2:.1f}" y="0"'
        parts.append(
            f'<line class="life" x1="{x:.1f}" y1="{HEAD:.1f}" x2="{x:.1f}" y2="{life:.1f}"/>'
            f'<rect class="node component" {corner} width="{box:.1f}" height="{HEAD - 4:.0f}" rx="4"/>'
            f'<text class="text" x="{x:.1f}" y="{HEAD / 2 - 2 + BASELINE:.1f}">{escape(name)}</text>'
        )
    width = max(x + box / 2 for x, box in zip(centres, boxes, strict=True))
    width = max([width, *(centres[row.columns[0]] + 12 + text_width(row.label) for row in rows if row.columns)])
    width = max([width, *(centres[c] + 10 + _widest(lines) for row in rows for c, lines in row.values.items())])
    if loop:
        top = tops[len(run)]
        size = f'width="{width + 16:.1f}" height="{tops[-1] - top + 6:.1f}"'
        parts.append(f'<rect class="loop" x="-8" y="{top:.1f}" {size} rx="4"/>')
    parts += [_drawn(top, row, centres) for top, row in zip(tops, rows, strict=False)]
    end = list(_verdict(counterexample))
    for i, line in enumerate(end):
        parts.append(f'<text class="bad" x="0" y="{height + i * LINE_HEIGHT:.1f}">{escape(line)}</text>')
    width = max([width, text_width(title) * 1.2, *map(text_width, end)])
    return document(title, width, height + (len(end) - 1) * LINE_HEIGHT, parts)


def _run(counterexample: Counterexample) -> Iterator[_Row]:
    causes = counterexample.causes or (None,) * len(counterexample.trace)
    beginning = {n: _told(c.variables) for n, c in enumerate(counterexample.components) if c.variables}
    if beginning:
        yield _Row("", (), values=beginning)
    for i, (event, cause) in enumerate(zip(counterexample.trace, causes, strict=True)):
        columns = tuple(number for number, c in enumerate(counterexample.components) if c.trace[i] is not None)
        new = {n: _told(c.changes[i]) for n, c in enumerate(counterexample.components) if c.changes and c.changes[i]}
        yield _Row(step_text(event, cause), columns or (0,), "hidden" if event == counterexample.tau else "", new)
    if counterexample.kind == "trace" and counterexample.event is not None:
        names = [component.name for component in counterexample.components]
        columns = tuple(sorted(names.index(name) for name, _ in counterexample.event_parts if name in names))
        yield _Row(counterexample.event, columns or (0,), "wrong")


def _told(values: Mapping[str, str]) -> tuple[str, ...]:
    """Variables with their values, a line each."""
    lines = [f"{name} = {value}" for name, value in values.items()]
    return tuple([line if len(line) <= _LONGEST_VALUE else line[: _LONGEST_VALUE - 1] + "…" for line in lines])


def _widest(lines: Sequence[str]) -> float:
    return max(map(text_width, lines), default=0.0)


def _loop(counterexample: Counterexample, names: list[str]) -> Iterator[_Row]:
    loop = counterexample.loop or ()
    for cause, parts in zip_longest(loop, counterexample.loop_parts, fillvalue=()):
        columns = tuple(sorted(names.index(name) for name, _ in parts if name in names))
        yield _Row(step_text(counterexample.tau, str(cause)), columns or (0,), "hidden")


def _columns(boxes: list[float], rows: list[_Row]) -> list[float]:
    """The middle of each line of life: a label must fit between its outermost participants, or beside the only one, and
    values between their line and the next.
    """
    widths = list(boxes)
    for row in rows:
        for column, lines in row.values.items():
            widths[column] = max(widths[column], boxes[column] / 2 + _widest(lines))
    for row in rows:
        if not row.columns:
            continue
        first, last = min(row.columns), max(row.columns)
        needed = text_width(row.label) + 16
        if first == last:
            widths[first] = max(widths[first], boxes[first] / 2 + needed - COLUMN_GAP)
            continue
        between = sum(widths[first:last]) + (last - first) * COLUMN_GAP - boxes[first] / 2 + boxes[last] / 2
        widths[last - 1] += max(needed - between, 0)
    centres = []
    left = 0.0
    for box, width in zip(boxes, widths, strict=True):
        centres.append(left + box / 2)
        left += width + COLUMN_GAP
    return centres


def _drawn(top: float, row: _Row, centres: list[float]) -> str:
    y = top + (0.75 * ROW if row.columns else -BASELINE)
    values = "".join(
        f'<text class="value" x="{centres[column] + 8:.1f}" y="{y + (i + 1) * LINE_HEIGHT:.1f}">{escape(line)}</text>'
        for column, lines in row.values.items()
        for i, line in enumerate(lines)
    )
    if not row.columns:
        return values
    first, last = centres[row.columns[0]], centres[row.columns[-1]]
    size = f'width="{text_width(row.label) + 2:.1f}" height="15"'
    ground = f'<rect class="ground" x="{first + 6:.1f}" y="{y - 18:.1f}" {size}/>'
    line = f'<line class="message {row.style}" x1="{first:.1f}" y1="{y:.1f}" x2="{last:.1f}" y2="{y:.1f}"/>'
    dots = "".join(f'<circle class="part {row.style}" cx="{centres[p]:.1f}" cy="{y:.1f}" r="4"/>' for p in row.columns)
    words = f'<text class="label {row.style}" x="{first + 7:.1f}" y="{y - 6:.1f}">{escape(row.label)}</text>'
    return ground + line + dots + words + values


def _verdict(counterexample: Counterexample) -> Iterator[str]:
    """What is wrong at the end, in lines."""
    match counterexample.kind:
        case "trace":
            yield f"The specification does not allow {counterexample.event}."
        case "deadlock":
            yield "Nothing more can happen."
            circle = counterexample.waiting_cycle or ()
            for name, other in zip(circle, circle[1:] + circle[:1], strict=True):
                yield f"{name} waits for {other}."
        case "divergence":
            yield "The framed events go on for ever."
        case "nondeterminism":
            yield f"{counterexample.event} is both possible and refusable."
        case _:
            yield "Refused: " + ", ".join(counterexample.refusal or ())
