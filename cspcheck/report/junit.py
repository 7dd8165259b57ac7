"""``junit``: for build servers. A test suite for each script, a test case for each assertion.

The document is valid against both schemas in use, that of Ant (``JUnit.xsd``) and that of Jenkins (``junit-10.xsd``):
it has every element and attribute that the one requires and none that the other does not know.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from xml.sax.saxutils import escape, quoteattr

from cspcheck.checker.verdict import Verdict
from cspcheck.cspm.diagnostics import Diagnostic, Severity
from cspcheck.report.diagnostics import render_diagnostic
from cspcheck.report.explanation import explanation
from cspcheck.report.sentences import sentence
from cspcheck.report.style import PLAIN, harmless, harmless_lines
from cspcheck.result import Result, Summary


@dataclass(slots=True)
class _Case:
    name: str
    seconds: float
    element: str | None = None
    type: str = ""
    message: str = ""
    text: str = ""


@dataclass(slots=True)
class _Suite:
    name: str
    cases: list[_Case] = field(default_factory=list)
    output: list[str] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)

    def count(self, element: str) -> int:
        return sum(case.element == element for case in self.cases)


class JunitReport:
    """One document, written when everything is known.

    A failure is a ``failure``, an unknown verdict or an error is an ``error``; what the script expects passes.
    """

    carries_diagnostics = True

    def __init__(
        self, write: Callable[[str], object], *, timestamp: str | None = None, hostname: str | None = None
    ) -> None:
        self._write = write
        self._timestamp = timestamp or time.strftime("%Y-%m-%dT%H:%M:%S")
        self._hostname = hostname
        self._suites: dict[str, _Suite] = {}

    def script(self, name: str, printed: Sequence[str] = ()) -> None:
        """A script has been loaded; its results follow."""
        self._suite(name).output.extend(printed)

    def diagnostics(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Errors and warnings of a script: a case that could not be run for an error, ``system-err`` for a warning."""
        for diagnostic in diagnostics:
            suite = self._suite(diagnostic.span.source.name if diagnostic.span else "cspcheck")
            text = render_diagnostic(diagnostic, PLAIN)
            if diagnostic.severity is Severity.WARNING:
                suite.errors.extend(text.split("\n"))
            else:
                name = f"{diagnostic.code} in line {diagnostic.span.line}" if diagnostic.span else diagnostic.code
                suite.cases.append(_Case(name, 0.0, "error", diagnostic.code, diagnostic.message, text))

    def result(self, result: Result) -> None:
        """One assertion's answer."""
        case = _Case(" ".join(result.assertion.split()), result.seconds)
        if not result.as_expected:
            case.element = "failure" if result.verdict in (Verdict.FAIL, Verdict.PASS) else "error"
            case.type = result.verdict.value
            case.message = sentence(result)
            place = f"{harmless(result.file)}:{result.line}"
            case.text = "\n".join([place, *explanation(result, PLAIN)])
            case.text += "".join(f"\n\n{render_diagnostic(diagnostic, PLAIN)}" for diagnostic in result.diagnostics)
        self._suite(result.file).cases.append(case)

    def unreached(self, results: Sequence[Result]) -> None:
        """They are unknown."""
        for result in results:
            self.result(result)

    def end(self, summary: Summary, *, interrupted: bool = False) -> None:
        """Write the document."""
        if self._hostname is None:
            import platform

            self._hostname = platform.node() or "localhost"
        self._write('<?xml version="1.0" encoding="UTF-8"?>\n<testsuites>\n')
        for number, suite in enumerate(self._suites.values()):
            self._write_suite(number, suite)
        self._write("</testsuites>\n")

    def _suite(self, name: str) -> _Suite:
        return self._suites.setdefault(name, _Suite(name))

    def _write_suite(self, number: int, suite: _Suite) -> None:
        attributes = {
            "name": suite.name,
            "package": "cspcheck",
            "id": str(number),
            "timestamp": self._timestamp,
            "hostname": self._hostname or "localhost",
            "tests": str(len(suite.cases)),
            "failures": str(suite.count("failure")),
            "errors": str(suite.count("error")),
            "skipped": "0",
            "time": f"{sum(case.seconds for case in suite.cases):.3f}",
        }
        self._write(f"  <testsuite{_attributes(attributes)}>\n    <properties/>\n")
        for case in suite.cases:
            opening = _attributes({"name": case.name, "classname": suite.name, "time": f"{case.seconds:.3f}"})
            if case.element is None:
                self._write(f"    <testcase{opening}/>\n")
                continue
            wrong = _attributes({"type": case.type, "message": case.message})
            self._write(
                f"    <testcase{opening}>\n      <{case.element}{wrong}>{_text(case.text)}</{case.element}>\n"
                "    </testcase>\n"
            )
        self._write(f"    <system-out>{_text(_lines(suite.output))}</system-out>\n")
        self._write(f"    <system-err>{_text(_lines(suite.errors))}</system-err>\n  </testsuite>\n")


_NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def _text(text: str) -> str:
    return escape(_NOT_IN_XML.sub("�", "\n".join(harmless_lines(text))))


def _attributes(values: dict[str, str]) -> str:
    return "".join(f" {name}={quoteattr(_NOT_IN_XML.sub('�', harmless(value)))}" for name, value in values.items())


def _lines(rows: Sequence[str]) -> str:
    return "".join(harmless(row) + "\n" for row in rows)
