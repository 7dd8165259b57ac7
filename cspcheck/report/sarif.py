"""``sarif``: for code scanning (GitHub, Azure, editors). A log of the format SARIF 2.1.0 (OASIS, 2020).

Diagnostics and assertions that are not as expected are results; the rules are their codes, with ``assertion`` for the
latter. What an interrupted run did not reach makes the invocation an unsuccessful one.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import PurePath
from typing import Any
from urllib.parse import quote

from cspcheck.checker.verdict import Verdict
from cspcheck.cspm.diagnostics import MISTAKES, Diagnostic
from cspcheck.report.explanation import explanation
from cspcheck.report.style import PLAIN, harmless
from cspcheck.result import Result, Summary

VERSION = "2.1.0"
SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
ASSERTION = "assertion"
"""The rule of an assertion with another verdict than the expected one."""


class SarifReport:
    """One log, written when everything is known."""

    carries_diagnostics = True

    def __init__(self, write: Callable[[str], object], version: str) -> None:
        self._write = write
        self._version = version
        self._rules: dict[str, dict[str, Any]] = {}
        self._results: list[dict[str, Any]] = []
        self._told: set[str] = set()

    def script(self, name: str, printed: Sequence[str] = ()) -> None:
        """Nothing: each result names its file."""

    def diagnostics(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Errors and warnings of a script; those of an included file once."""
        for diagnostic in diagnostics:
            text = harmless(diagnostic.message) + (f"\n{harmless(diagnostic.help)}" if diagnostic.help else "")
            result = self._result(diagnostic.code, diagnostic.severity.value, text)
            span = diagnostic.span
            if span is not None:
                region = {
                    "startLine": span.line,
                    "startColumn": span.column,
                    "endLine": span.end_line,
                    "endColumn": span.end_column,
                }
                result["locations"] = [_location(span.source.name, region)]
            key = json.dumps(result)
            if key not in self._told:
                self._told.add(key)
                self._results.append(result)

    def result(self, result: Result) -> None:
        """One assertion's answer."""
        self.diagnostics(result.diagnostics)
        if result.as_expected:
            return
        level = "warning" if result.verdict is Verdict.UNKNOWN else "error"
        text = "\n".join([harmless(" ".join(result.assertion.split())), *explanation(result, PLAIN)])
        found = self._result(ASSERTION, level, text)
        found["properties"] = {"verdict": result.verdict.value, "expected": result.expected.value}
        if result.line:
            found["locations"] = [_location(result.file, {"startLine": result.line})]
        self._results.append(found)

    def unreached(self, results: Sequence[Result]) -> None:
        """They are unknown."""
        for result in results:
            self.result(result)

    def end(self, summary: Summary, *, interrupted: bool = False) -> None:
        """Write the log."""
        driver = {
            "name": "cspcheck",
            "version": self._version,
            "rules": list(self._rules.values()),
        }
        run = {
            "tool": {"driver": driver},
            "invocations": [{"executionSuccessful": not interrupted}],
            "columnKind": "unicodeCodePoints",
            "results": self._results,
        }
        self._write(json.dumps({"$schema": SCHEMA, "version": VERSION, "runs": [run]}, indent=2) + "\n")

    def _result(self, rule: str, level: str, text: str) -> dict[str, Any]:
        if rule not in self._rules:
            self._rules[rule] = {"id": rule, "shortDescription": {"text": _title(rule)}}
        index = list(self._rules).index(rule)
        return {"ruleId": rule, "ruleIndex": index, "level": level, "message": {"text": text}}


def _title(rule: str) -> str:
    if rule == ASSERTION:
        return "an assertion with another verdict than the expected one"
    known = MISTAKES.get(rule)
    return rule if known is None else known.title


def _location(file: str, region: dict[str, int]) -> dict[str, Any]:
    uri = quote(PurePath(file).as_posix(), safe="/")
    return {"physicalLocation": {"artifactLocation": {"uri": uri}, "region": region}}
