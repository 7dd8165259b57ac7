"""``github``: annotations on the lines of a pull request, as GitHub's runners read them from a job's output.

The form is that of workflow commands, ``::error file=x.csp,line=3::text``. In the text ``%``, carriage return and
line feed are written as ``%25``, ``%0D`` and ``%0A``; in the properties ``:`` and ``,`` as ``%3A`` and ``%2C`` too.
Columns are given for places within one line only: GitHub shows no annotation that has them for several.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence

from cspcheck.checker.verdict import Verdict
from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.quantities import count
from cspcheck.report.excerpt import last_line
from cspcheck.report.explanation import explanation
from cspcheck.report.style import PLAIN, harmless, harmless_lines
from cspcheck.result import Result, Summary


class GithubReport:
    """An annotation for everything that is not as it should be."""

    carries_diagnostics = True

    def __init__(self, write: Callable[[str], object]) -> None:
        self._write = write
        self._told: set[tuple[object, ...]] = set()

    def script(self, name: str, printed: Sequence[str] = ()) -> None:
        """Nothing: each annotation names its file."""

    def diagnostics(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Errors and warnings of a script; those of an included file once, not for each that includes it."""
        for diagnostic in diagnostics:
            place: dict[str, object] = {}
            span = diagnostic.span
            key = (diagnostic.code, diagnostic.message, span and (span.source.name, span.start, span.end))
            if key in self._told:
                continue
            self._told.add(key)
            if span is not None:
                place = {"file": span.source.name, "line": span.line, "endLine": last_line(span)}
                if span.line == span.end_line:
                    place |= {"col": span.column, "endColumn": max(span.end_column - 1, span.column)}
            text = harmless(diagnostic.message) + (f"\nhelp: {diagnostic.help}" if diagnostic.help else "")
            self._annotate(diagnostic.severity.value, place | {"title": diagnostic.code}, text)

    def result(self, result: Result) -> None:
        """One assertion's answer."""
        self.diagnostics(result.diagnostics)
        if result.as_expected:
            return
        place: dict[str, object] = {"file": result.file, "line": result.line} if result.line else {}
        level = "warning" if result.verdict is Verdict.UNKNOWN else "error"
        text = "\n".join([harmless(" ".join(result.assertion.split())), *explanation(result, PLAIN)])
        self._annotate(level, place | {"title": f"assertion: {result.verdict}"}, text)

    def unreached(self, results: Sequence[Result]) -> None:
        """One annotation for each script, for GitHub shows no more than ten."""
        numbers = Counter(result.file for result in results)
        for file, number in numbers.items():
            text = f"interrupted: {count(number, 'assertion')} not reached"
            self._annotate("warning", {"file": file, "title": "assertions: unknown"}, text)

    def end(self, summary: Summary, *, interrupted: bool = False) -> None:
        """The counts, as a plain line of the log."""
        counts = ", ".join(f"{number} {verdict}" for verdict, number in summary.verdicts.items())
        self._write(f"cspcheck: {'interrupted; ' if interrupted else ''}{counts}\n")

    def _annotate(self, level: str, properties: dict[str, object], text: str) -> None:
        listed = ",".join(f"{name}={_property(harmless(str(value)))}" for name, value in properties.items())
        self._write(f"::{level} {listed}::{_data(chr(10).join(harmless_lines(text)))}\n")


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
