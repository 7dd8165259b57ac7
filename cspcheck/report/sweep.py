"""What came of a sweep: a table for each assertion, a row for each combination of values; or one JSON document."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Sequence

from cspcheck.checker.verdict import Verdict
from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.quantities import show_seconds
from cspcheck.report.json import SCHEMA, diagnostic_object, result_object
from cspcheck.report.style import Style, columns, harmless, pad, unobeyed
from cspcheck.result import Result, Summary
from cspcheck.sweeping import Swept

_COLORS = {"pass": "green", "fail": "red", "unknown": "yellow", "error": "red"}
_LOWEST_REASON = 16


class Collected:
    """A report that keeps what it is told about one combination of values."""

    carries_diagnostics = True

    def __init__(self, swept: Swept) -> None:
        self._swept = swept

    def script(self, name: str, printed: Sequence[str] = ()) -> None:
        """Nothing: each result names its file."""

    def diagnostics(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Errors and warnings."""
        self._swept.diagnostics.extend(diagnostics)

    def result(self, result: Result) -> None:
        """One assertion's answer."""
        self._swept.results.append(result)
        self._swept.diagnostics.extend(result.diagnostics)

    def unreached(self, results: Sequence[Result]) -> None:
        """They are unknown."""
        for result in results:
            self.result(result)

    def end(self, summary: Summary, *, interrupted: bool = False) -> None:
        """Nothing: the sweep goes on."""


Key = tuple[str, int, str]
"""File, line and text of an assertion."""


def table(sweep: Sequence[Swept], names: Sequence[str], style: Style) -> str:
    """The tables, one for each assertion, with the values of *names* in front of each row."""
    keys = dict.fromkeys(_key(result) for swept in sweep for result in swept.results)
    parts: list[str] = []
    file = None
    for key in keys:
        if key[0] != file:
            file = key[0]
            parts.append(style.paint(harmless(file), "bold"))
        parts.append("\n".join(_one(key, sweep, names, style)))
    return unobeyed("\n\n".join(parts) + "\n") if parts else ""


def _key(result: Result) -> Key:
    return result.file, result.line, " ".join(result.assertion.split())


def _one(key: Key, sweep: Sequence[Swept], names: Sequence[str], style: Style) -> Iterable[str]:
    heads = [*map(harmless, names), "", "verdict", "states", "transitions", "time"]
    rows: list[list[str]] = []
    reasons: list[str] = []
    looks: list[str] = []
    for swept in sweep:
        result = next((result for result in swept.results if _key(result) == key), None)
        values = [swept.definitions[name] for name in names]
        if result is None:
            broken = any(diagnostic.severity == "error" for diagnostic in swept.diagnostics)
            rows.append([*values, "!" if broken else "", "error" if broken else "not there", "", "", ""])
            reasons.append("")
            looks.append("error")
            continue
        looks.append(_look(result))
        rows.append(
            [
                *values,
                _mark(result, style),
                result.verdict.value,
                f"{result.states:,}",
                f"{result.transitions:,}",
                show_seconds(result.seconds),
            ]
        )
        reasons.append(result.reason or "" if result.verdict is not Verdict.FAIL else "")
    cells = [[harmless(cell) for cell in row] for row in rows]
    widths = [max(columns(row[i]) for row in [heads, *cells]) for i in range(len(heads))]
    words = len(names) + 1
    yield f"  {harmless(key[2])}"
    yield "    " + style.paint("  ".join(_cell(heads, i, widths, words) for i in range(len(heads))).rstrip(), "dim")
    room = style.width - sum(widths) - 2 * len(widths) - 6
    for row, reason, look in zip(cells, reasons, looks, strict=True):
        shown = [_cell(row, i, widths, words) for i in range(len(heads))]
        shown[words - 1 : words + 1] = [style.paint(text, _COLORS[look]) for text in shown[words - 1 : words + 1]]
        line = "    " + "  ".join(shown)
        if reason and room >= _LOWEST_REASON:
            line += "  " + style.paint(style.fit(harmless(reason), room), "dim")
        yield line.rstrip()


def _cell(row: Sequence[str], i: int, widths: Sequence[int], words: int) -> str:
    """Values and numbers to the right, words to the left."""
    if i in (words - 1, words):
        return pad(row[i], widths[i])
    return " " * (widths[i] - columns(row[i])) + row[i]


def _look(result: Result) -> str:
    if result.as_expected:
        return "pass"
    return "fail" if result.verdict is Verdict.PASS else result.verdict.value


def _mark(result: Result, style: Style) -> str:
    marks = {"pass": "✓", "fail": "✗", "unknown": "?", "error": "!"}
    plain = {"pass": "+", "fail": "x", "unknown": "?", "error": "!"}
    return (marks if style.unicode else plain)[_look(result)]


_COLUMNS = ("file", "line", "assertion", "verdict", "expected", "states", "transitions", "seconds", "reason")


def comma_separated(sweep: Sequence[Swept], names: Sequence[str]) -> str:
    """A line for each assertion and combination of values, with the values of *names* in front (RFC 4180).

    What a spreadsheet would take for a formula has a quote in front.
    """
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow([*map(_cell_text, names), *_COLUMNS])
    for swept in sweep:
        for result in swept.results:
            writer.writerow(
                [
                    *[_cell_text(swept.definitions[name]) for name in names],
                    _cell_text(result.file),
                    result.line,
                    _cell_text(" ".join(result.assertion.split())),
                    result.verdict.value,
                    result.expected.value,
                    result.states,
                    result.transitions,
                    f"{result.seconds:.6f}",
                    _cell_text(result.reason or ""),
                ]
            )
    return text.getvalue()


def _cell_text(text: str) -> str:
    text = harmless(text)
    return f"'{text}" if text.startswith(("=", "+", "@", "\t")) or (text[:1] == "-" and not _is_number(text)) else text


def _is_number(text: str) -> bool:
    return text.removeprefix("-").isdecimal()


def document(sweep: Sequence[Swept], version: str, *, interrupted: bool = False) -> str:
    """The document of the schema ``cspcheck/1`` with one key more in each result: ``definitions``."""
    results = [
        result_object(result) | {"definitions": swept.definitions} for swept in sweep for result in swept.results
    ]
    total = Summary.empty()
    for swept in sweep:
        for result in swept.results:
            total.add(result)
        if not swept.results and any(diagnostic.severity == "error" for diagnostic in swept.diagnostics):
            total.add_broken_script()
    return (
        json.dumps(
            {
                "schema": SCHEMA,
                "version": version,
                "interrupted": interrupted,
                "results": results,
                "diagnostics": [
                    diagnostic_object(diagnostic) | {"definitions": swept.definitions}
                    for swept in sweep
                    for diagnostic in swept.diagnostics
                ],
                "summary": total.verdicts,
            },
            indent=2,
        )
        + "\n"
    )
