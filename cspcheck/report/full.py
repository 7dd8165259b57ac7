"""``full``: for people. A line for each assertion, what is wrong below it, a summary at the end."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Callable, Iterable, Sequence

from cspcheck.checker.verdict import EverySize, Verdict
from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.quantities import count, show_seconds
from cspcheck.report.coverage import coverage_lines
from cspcheck.report.diagnostics import render_diagnostic
from cspcheck.report.explanation import Detail, explanation
from cspcheck.report.style import PLAIN, Style, columns, harmless, wrapped
from cspcheck.result import Result, Summary

_MARKS = {"pass": "✓", "fail": "✗", "unknown": "?", "error": "!"}
_ASCII_MARKS = {"pass": "+", "fail": "x", "unknown": "?", "error": "!"}
_COLORS = {"pass": "green", "fail": "red", "unknown": "yellow", "error": "red"}


class FullReport:
    """The report for people.

    *verbosity* below 0 leaves out what is as it should be; above 0 nothing is folded and the behaviour behind an
    expected failure is shown too.
    """

    carries_diagnostics = False

    def __init__(self, write: Callable[[str], object], style: Style = PLAIN, verbosity: int = 0) -> None:
        self._write = write
        self._style = style
        self._verbosity = verbosity
        self._begun = False
        self._gap = False
        self._heading: str | None = None

    def script(self, name: str, printed: Sequence[str] = ()) -> None:
        """A script has been loaded; its results follow. *printed* is what its ``print`` lines say."""
        self._heading = name
        if self._verbosity >= 0:
            self._head()
            for line in printed:
                self._line(f"  {harmless(line)}")

    def diagnostics(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Nothing: this report leaves diagnostics to standard error."""

    def result(self, result: Result) -> None:
        """One assertion's answer."""
        if self._verbosity < 0 and result.as_expected:
            return
        self._head()
        self._line(headline(result, self._style))
        lines = _below(result, self._style, self._verbosity)
        for line in lines:
            self._line(f"  {line}".rstrip())
        self._gap = len(lines) > 1 and not result.diagnostics  # which follow on standard error

    def unreached(self, results: Sequence[Result]) -> None:
        """How many there are of each script."""
        numbers = Counter(result.file for result in results)
        if numbers:
            self._gap = self._begun
            told = ", ".join(f"{harmless(file)} ({number:,})" for file, number in numbers.items())
            for line in wrapped(f"not reached: {told}", self._style.width, rest="  "):
                self._line(self._style.paint(line, "dim"))

    def end(self, summary: Summary, *, interrupted: bool = False) -> None:
        """The summary line."""
        if self._verbosity < 0:
            return
        self._gap = self._begun
        self._line(summary_line(summary, self._style, interrupted=interrupted))

    def _head(self) -> None:
        if self._heading is not None:
            self._gap = self._begun
            self._line(self._style.paint(harmless(self._heading), "bold"))
            self._heading = None

    def _line(self, text: str) -> None:
        self._write("\n" * self._gap + text + "\n")
        self._begun, self._gap = True, False


def headline(result: Result, style: Style) -> str:
    """Mark, assertion, and what it took; on two lines where one is too narrow."""
    looks = "pass" if result.as_expected else "fail" if result.verdict is Verdict.PASS else result.verdict.value
    mark = style.paint((_MARKS if style.unicode else _ASCII_MARKS)[looks], "bold", _COLORS[looks])
    text = harmless(" ".join(result.assertion.split()))
    took = _took(result)
    gap = style.width - 2 - columns(text) - columns(took)
    if gap >= 2:
        return f"{mark} {text}{' ' * gap}{style.paint(took, 'dim')}"
    return f"{mark} {text}\n{' ' * (style.width - columns(took))}{style.paint(took, 'dim')}"


def _took(result: Result) -> str:
    seconds = show_seconds(result.seconds)
    if not result.states and not result.transitions:
        return seconds
    return f"{count(result.states, 'state')}, {count(result.transitions, 'transition')}, {seconds}"


def _below(result: Result, style: Style, verbosity: int) -> list[str]:
    """The lines below the headline: nothing for a pass, a sentence where the script expects what came out.

    A result about classes says first under what it holds.
    """
    condition = [style.paint(line, "dim") for line in condition_lines(result, style.width - 2)]
    remarks = [line for remark in remarks_of(result) for line in wrapped(f"note: {harmless(remark)}", style.width - 2)]
    if result.coverage is not None:
        remarks += coverage_lines(result.coverage, style)
    if result.verdict is Verdict.PASS and result.as_expected and verbosity <= 0:
        return [*condition, *remarks]
    detail: Detail = "whole" if verbosity > 0 else "sentence" if result.as_expected else "folded"
    lines = explained(result, style, detail, "-v shows them")
    again = replay_lines(result, style)
    return [*condition, *lines, *([""] if lines and remarks else []), *remarks, *again]


def replay_lines(result: Result, style: Style) -> list[str]:
    """How to step through the counterexample, for a failure of a script in a file that has one."""
    counterexample = result.counterexample
    if result.as_expected or not result.line or counterexample is None or counterexample.run is None:
        return []
    if result.file.startswith("<"):
        return []
    place = shlex.quote(harmless(result.file))
    return ["", style.paint(f"step through it: cspcheck probe --at {place}:{result.line}", "dim")]


def condition_lines(result: Result, width: int = 10_000) -> list[str]:
    """Under what finite readings, or in which view, a result about classes holds; for which sizes it passes."""
    lines = []
    if result.control:
        lines.append("in the control view: data dropped")
    if result.readings:
        lines.append(harmless(f"reading {'; '.join(result.readings)}"))
    if result.verdict is Verdict.PASS:
        for size in result.every_size:
            lines += wrapped(harmless(every_size(size)), width, rest="  ")
    return lines


def remarks_of(result: Result) -> list[str]:
    """What is worth knowing behind the explanation; of a failure also that it is there for every size of a type."""
    sizes = () if result.verdict is Verdict.PASS else result.every_size
    return [*result.remarks, *(every_size(size) for size in sizes if size.tells)]


def every_size(size: EverySize) -> str:
    """What a verdict says of other sizes of a type, with the conditions that were checked."""
    checked = "values are only passed on; none is named, counted or compared"
    if size.tests:
        checked = "values are only compared and passed on; none is named or counted"
        checked += f", at most {size.held} held at one time and {size.new} new in a step"
    if not size.tells:
        return f"{size.type} has {count(size.size, 'value')}; {size.sufficient} would tell for every size ({checked})"
    least = f" from {size.least} on" if size.least > 1 else ""
    return f"the same for every size of {size.type}{least} ({checked})"


def explained(result: Result, style: Style, detail: Detail = "folded", hint: str = "") -> list[str]:
    """Where the assertion stands, and the explanation; nothing where there is nothing to explain."""
    lines = explanation(result, style, detail, hint)
    if lines and not result.as_expected and result.line:
        lines.insert(0, style.paint(f"--> {harmless(result.file)}:{result.line}", "dim"))
    return lines


def summary_line(summary: Summary, style: Style, *, interrupted: bool = False) -> str:
    """``3 assertions: 2 pass, 1 fail (expected), in 1.20 s``."""
    reached = summary.verdicts | {"unknown": summary.verdicts["unknown"] - summary.unreached}
    words = {verdict: f"{number:,} {verdict}" for verdict, number in reached.items() if number}
    if summary.verdicts["error"]:
        words["error"] = count(max(summary.errors, summary.verdicts["error"]), "error")
    parts = [style.paint(text, _COLORS[verdict]) for verdict, text in words.items()]
    text = ", ".join(parts) or "nothing was checked"
    if interrupted:
        text = style.paint("interrupted", "bold", "yellow") + f"; until then: {text}"
        if summary.unreached:
            text += f"; {count(summary.unreached, 'assertion')} without an answer"
        return f"{text}, in {show_seconds(summary.seconds)}"
    total = sum(summary.verdicts.values())
    if total and not summary.unexpected and summary.verdicts["pass"] != total:
        text += ", all as expected"
    elif summary.unexpected and summary.unexpected != total - summary.verdicts["pass"]:
        text += f", {summary.unexpected:,} not as expected"
    return f"{text}, in {show_seconds(summary.seconds)}"


def explain(result: Result, style: Style = PLAIN) -> str:
    """One result as this report shows it, with its diagnostics; without a line break at the end."""
    below = [*condition_lines(result, style.width - 2), *explained(result, style)]
    lines = [headline(result, style), *(f"  {line}".rstrip() for line in below)]
    for diagnostic in result.diagnostics:
        lines += ["", render_diagnostic(diagnostic, style)]
    return "\n".join(lines)
