"""``html``: one page for people who were not there. It needs nothing beside itself, and runs no script."""

from __future__ import annotations

import html
import time
from collections.abc import Callable, Iterable, Sequence

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.quantities import count, show_seconds
from cspcheck.report.diagnostics import render_diagnostic
from cspcheck.report.explanation import explanation
from cspcheck.report.full import condition_lines, remarks_of, summary_line
from cspcheck.report.sentences import sentence
from cspcheck.report.style import PLAIN, harmless, harmless_lines
from cspcheck.result import Result, Summary

_NUMBER = ' class="number"'
_MARKS = {"pass": "✓", "fail": "✗", "unknown": "?", "error": "!"}

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1f2933; max-width: 72rem; margin: 2rem auto; padding: 0 1.2rem; }
h1 { font-size: 1.4rem; margin-bottom: .2rem; } h2 { font-size: 1.1rem; margin: 2rem 0 .5rem; }
.about { color: #52606d; }
table { border-collapse: collapse; width: 100%; }
td, th { text-align: left; padding: .3rem .6rem; border-top: 1px solid #e1e7ed; vertical-align: top; }
th { font-size: .8rem; color: #52606d; } td.number, th.number { text-align: right; white-space: nowrap; width: 6rem; }
code, pre { font-family: ui-monospace, 'DejaVu Sans Mono', Consolas, monospace; font-size: .85rem; }
pre { background: #f6f8fa; border: 1px solid #e1e7ed; border-radius: 5px; padding: .7rem .9rem; overflow-x: auto; }
.pass { color: #2e7d32; } .fail, .error { color: #b3261e; } .unknown { color: #a06a00; }
.mark { font-weight: 700; text-align: center; width: 1.6rem; }
details { margin: .2rem 0 .6rem; } summary { cursor: pointer; }
figure { margin: .8rem 0; overflow-x: auto; } figcaption { font-size: .8rem; color: #52606d; }
figure svg { max-width: 100%; height: auto; }
.bar { display: flex; height: .6rem; border-radius: 4px; overflow: hidden; margin: .6rem 0; background: #e1e7ed; }
.bar i { display: block; } .bar .pass { background: #66a966; } .bar .fail { background: #d9776f; }
.bar .unknown { background: #d9ad57; } .bar .error { background: #9c4742; }
.interrupted { background: #fff7e0; border: 1px solid #d9ad57; border-radius: 5px; padding: .5rem .8rem; }
@media print { details > * { display: block; } }
"""


def escape(text: str) -> str:
    """Text in lines of ours as the content of an element: no markup, and nothing that steers who reads it."""
    escaped = html.escape("\n".join(harmless_lines(text)))
    # A page that is printed in a build is obeyed line by line, too.
    return escaped.replace("::", "&#58;:").replace("##[", "&#35;#[")


class HtmlReport:
    """The page, written when everything is known."""

    carries_diagnostics = True

    def __init__(self, write: Callable[[str], object], version: str, *, when: str | None = None) -> None:
        self._write = write
        self._version = version
        self._when = when or time.strftime("%Y-%m-%d %H:%M")
        self._scripts: dict[str, list[Result]] = {}
        self._printed: dict[str, Sequence[str]] = {}
        self._diagnostics: list[Diagnostic] = []

    def script(self, name: str, printed: Sequence[str] = ()) -> None:
        """A script has been loaded; its results follow. *printed* is what its ``print`` lines say."""
        self._scripts.setdefault(name, [])
        self._printed[name] = printed

    def diagnostics(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Errors and warnings."""
        self._diagnostics.extend(diagnostics)

    def result(self, result: Result) -> None:
        """One assertion's answer."""
        self._scripts.setdefault(result.file, []).append(result)
        self.diagnostics(result.diagnostics)

    def unreached(self, results: Sequence[Result]) -> None:
        """They are unknown."""
        for result in results:
            self.result(result)

    def end(self, summary: Summary, *, interrupted: bool = False) -> None:
        """Write the page."""
        parts = [
            "<!doctype html>",
            '<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">',
            f"<title>cspcheck: {escape(', '.join(map(harmless, self._scripts)))}</title><style>{_STYLE}</style>",
            "<h1>What was checked</h1>",
            f'<p class="about">{escape(self._when)}, cspcheck {escape(self._version)}: '
            f"{escape(summary_line(summary, PLAIN, interrupted=interrupted))}</p>",
        ]
        if interrupted:
            parts.append('<p class="interrupted">The run was interrupted; what it did not come to is unknown.</p>')
        parts.append(_bar(summary))
        if self._diagnostics:
            parts.append("<h2>Errors and warnings</h2>")
            parts += [f"<pre>{escape(render_diagnostic(d, PLAIN))}</pre>" for d in self._diagnostics]
        for name, results in self._scripts.items():
            parts += self._script(name, results)
        self._write("\n".join([*parts, "</html>", ""]))

    def _script(self, name: str, results: Sequence[Result]) -> list[str]:
        parts = [f"<h2>{escape(harmless(name))}</h2>"]
        if self._printed.get(name):
            parts.append(f"<pre>{escape(chr(10).join(map(harmless, self._printed[name])))}</pre>")
        heads = ("", "assertion", "line", "states", "transitions", "time")
        parts.append(
            "<table><tr>"
            + "".join(f"<th{_NUMBER if head in heads[2:] else ''}>{head}</th>" for head in heads)
            + "</tr>"
        )
        for result in results:
            mark = result.verdict if not result.as_expected else "pass"
            parts.append(
                f'<tr><td class="mark {mark}">{_MARKS[mark]}</td><td>{_told(result)}</td>'
                f'<td class="number">{result.line or ""}</td><td class="number">{_counted(result.states)}</td>'
                f'<td class="number">{_counted(result.transitions)}</td>'
                f'<td class="number">{escape(show_seconds(result.seconds))}</td></tr>'
            )
        return [*parts, "</table>"]


def _counted(number: int) -> str:
    """A number; nothing for a proof, which explores nothing."""
    return f"{number:,}" if number else ""


def _told(result: Result) -> str:
    """The assertion with what is to be said of it; a counterexample opens where it was not expected."""
    text = f"<code>{escape(harmless(result.assertion))}</code>"
    if not result.as_expected or result.verdict != "pass":
        text += f' <b class="{result.verdict}">{result.verdict}</b>'
        if result.as_expected:
            text += " as expected"
    conditions = "; ".join(condition_lines(result))
    if conditions:
        text += f"<br><small>{escape(conditions)}</small>"
    for remark in remarks_of(result):
        text += f"<br><small>note: {escape(harmless(remark))}</small>"
    inside = "".join(_figures(result))
    lines = explanation(result, PLAIN, "whole")
    if lines:
        inside = f"<pre>{escape(chr(10).join(line.rstrip() for line in lines))}</pre>" + inside
    if not inside:
        return text
    shown = " open" if not result.as_expected else ""
    words = escape(harmless(sentence(result) or ("the machine" if result.machine else "more")))
    return f"{text}<details{shown}><summary>{words}</summary>{inside}</details>"


def _figures(result: Result) -> Iterable[str]:
    found = result.counterexample
    if found is not None and found.kind != "obligation":
        from cspcheck.drawing import sequence

        chart = sequence.render(result.assertion, found)
        yield f"<figure>{chart}<figcaption>the run, component by component</figcaption></figure>"
    if result.machine is not None:
        yield f"<figure>{result.machine}<figcaption>the machine of {escape(result.process)}</figcaption></figure>"
    if result.coverage is not None:
        from cspcheck.report.coverage import coverage_lines

        yield f"<pre>{escape(chr(10).join(coverage_lines(result.coverage, PLAIN)))}</pre>"


def _bar(summary: Summary) -> str:
    total = sum(summary.verdicts.values())
    pieces = [
        f'<i class="{verdict}" style="width:{100 * number / total:.2f}%" title="{count(number, verdict)}"></i>'
        for verdict, number in summary.verdicts.items()
        if number
    ]
    return f'<div class="bar">{"".join(pieces)}</div>'
