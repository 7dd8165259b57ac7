"""A counterexample as a message-sequence chart: one line of life a component, one row an event."""

from __future__ import annotations

from html import escape

from checker.verdict import Counterexample
from cspcheck.drawing.svg import BASELINE, document, text_width

ROW = 30.0
HEAD = 30.0
COLUMN_GAP = 24.0

CHART_STYLE = """<style>
.life { stroke: #9aa5b1; stroke-width: 1; }
.message { stroke: #33658a; stroke-width: 1.6; }
.message.hidden { stroke-dasharray: 4 3; }
.part { fill: #33658a; }
.bad { fill: #b3261e; }
</style>"""


def render(title: str, counterexample: Counterexample) -> str:
    """The chart as an SVG document.

    Participants of an event are dots on its row joined by a line; a hidden event is dashed and says what it was.
    The last row says what is wrong at the end.
    """
    names = [component.name for component in counterexample.components] or ["process"]
    labels = _labels(counterexample)
    widths = [text_width(name) + 20 for name in names]
    for label, (first, last) in zip(labels, _extents(counterexample, len(names)), strict=True):
        # A label must fit between the outermost participants, or beside the only one.
        missing = text_width(label) + 16 - sum(widths[first : last + 1])
        if missing > 0:
            widths[last] += missing
    centres = []
    left = 0.0
    for name, width in zip(names, widths, strict=True):
        centres.append(left + (text_width(name) + 20) / 2)
        left += width + COLUMN_GAP
    height = HEAD + (len(labels) + 1.5) * ROW
    parts = [CHART_STYLE]
    for name, x in zip(names, centres, strict=True):
        box = text_width(name) + 20
        corner = f'x="{x - box / 2:.1f}" y="0"'
        parts.append(
            f'<line class="life" x1="{x:.1f}" y1="{HEAD:.1f}" x2="{x:.1f}" y2="{height - ROW / 2:.1f}"/>'
            f'<rect class="node component" {corner} width="{box:.1f}" height="{HEAD - 4:.0f}" rx="4"/>'
            f'<text class="text" x="{x:.1f}" y="{HEAD / 2 - 2 + BASELINE:.1f}">{escape(name)}</text>'
        )
    for i, label in enumerate(labels):
        parts.append(_row(i, label, counterexample, centres))
    end = _verdict(counterexample)
    parts.append(f'<text class="bad" x="0" y="{height:.1f}">{escape(end)}</text>')
    return document(title, max(left, text_width(end), text_width(title) * 1.2), height, parts)


def _labels(counterexample: Counterexample) -> list[str]:
    causes = counterexample.causes or (None,) * len(counterexample.trace)
    return [f"{event} ({cause})" if cause else event for event, cause in zip(counterexample.trace, causes, strict=True)]


def _participants(counterexample: Counterexample, row: int) -> list[int]:
    taking_part = [i for i, c in enumerate(counterexample.components) if c.trace[row] is not None]
    return taking_part or [0]


def _extents(counterexample: Counterexample, columns: int) -> list[tuple[int, int]]:
    found = []
    for row in range(len(counterexample.trace)):
        participants = _participants(counterexample, row) if columns else [0]
        found.append((min(participants), max(participants)))
    return found


def _row(row: int, label: str, counterexample: Counterexample, centres: list[float]) -> str:
    participants = _participants(counterexample, row)
    y = HEAD + (row + 1) * ROW
    hidden = " hidden" if counterexample.trace[row] == "tau" else ""
    first, last = centres[participants[0]], centres[participants[-1]]
    line = f'<line class="message{hidden}" x1="{first:.1f}" y1="{y:.1f}" x2="{last:.1f}" y2="{y:.1f}"/>'
    dots = "".join(f'<circle class="part" cx="{centres[p]:.1f}" cy="{y:.1f}" r="4"/>' for p in participants)
    return f'{line}{dots}<text class="label" x="{first + 7:.1f}" y="{y - 6:.1f}">{escape(label)}</text>'


def _verdict(counterexample: Counterexample) -> str:
    kind = counterexample.kind
    if kind == "trace":
        return f"then {counterexample.event}, which the specification does not allow"
    if kind == "deadlock":
        return "then nothing more can happen"
    if kind == "divergence":
        return "then internal events without end: " + ", ".join(counterexample.loop or ())
    if kind == "nondeterminism":
        return f"then {counterexample.event} is both possible and refusable"
    return "then refused: " + ", ".join(counterexample.refusal or ())
