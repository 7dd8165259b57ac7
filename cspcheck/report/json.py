"""``json`` and ``jsonl``: for programs. The documents of the schema ``cspcheck/1``."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from cspcheck.checker.verdict import BrokenObligation, Counterexample
from cspcheck.coverage import Coverage
from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.result import Result, Summary

SCHEMA = "cspcheck/1"


class JsonReport:
    """One document, written when everything is known."""

    carries_diagnostics = True

    def __init__(self, write: Callable[[str], object], version: str) -> None:
        self._write = write
        self._version = version
        self._results: list[dict[str, Any]] = []
        self._diagnostics: list[dict[str, Any]] = []

    def script(self, name: str, printed: Sequence[str] = ()) -> None:
        """Nothing: each result names its file."""

    def diagnostics(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Errors and warnings of a script."""
        self._diagnostics.extend(map(diagnostic_object, diagnostics))

    def result(self, result: Result) -> None:
        """One assertion's answer."""
        self._results.append(result_object(result))
        self.diagnostics(result.diagnostics)

    def unreached(self, results: Sequence[Result]) -> None:
        """They are unknown."""
        for result in results:
            self.result(result)

    def end(self, summary: Summary, *, interrupted: bool = False) -> None:
        """Write the document."""
        document = {
            "schema": SCHEMA,
            "version": self._version,
            "interrupted": interrupted,
            "results": self._results,
            "diagnostics": self._diagnostics,
            "summary": summary.verdicts,
        }
        self._write(json.dumps(document, indent=2) + "\n")


class JsonLinesReport:
    """The objects of the document, results and diagnostics, one a line as they come."""

    carries_diagnostics = True

    def __init__(self, write: Callable[[str], object]) -> None:
        self._write = write

    def script(self, name: str, printed: Sequence[str] = ()) -> None:
        """Nothing: each result names its file."""

    def diagnostics(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Errors and warnings of a script."""
        for diagnostic in diagnostics:
            self._write(json.dumps(diagnostic_object(diagnostic)) + "\n")

    def result(self, result: Result) -> None:
        """One assertion's answer."""
        self._write(json.dumps(result_object(result)) + "\n")
        self.diagnostics(result.diagnostics)

    def unreached(self, results: Sequence[Result]) -> None:
        """They are unknown."""
        for result in results:
            self.result(result)

    def end(self, summary: Summary, *, interrupted: bool = False) -> None:
        """Nothing, since every line stands for itself; but that it is the last one too early is said."""
        if interrupted:
            self._write(json.dumps({"interrupted": True}) + "\n")


def result_object(result: Result) -> dict[str, Any]:
    """A result as the schema writes it."""
    counterexample = result.counterexample
    return {
        "file": result.file,
        "line": result.line,
        "assertion": result.assertion,
        "kind": result.kind,
        "model": result.model,
        "verdict": result.verdict.value,
        "expected": result.expected.value,
        "reason": result.reason,
        "states": result.states,
        "transitions": result.transitions,
        "seconds": round(result.seconds, 6),
        "peak_memory_bytes": result.peak_memory_bytes,
        "counterexample": None if counterexample is None else counterexample_object(counterexample),
        **_condition(result),
    }


def _condition(result: Result) -> dict[str, Any]:
    """Under what a result holds, and how far: only where there is something to say."""
    found: dict[str, Any] = {}
    if result.readings:
        found["readings"] = list(result.readings)
    if result.control:
        found["view"] = "control"
    if result.every_size:
        found["every_size"] = [
            {
                "type": size.type,
                "size": size.size,
                "sufficient": size.sufficient,
                "same_from": size.least if size.tells else None,
                "compared": size.tests,
                "held": size.held,
                "new": size.new,
            }
            for size in result.every_size
        ]
    if result.outcome.reduction is not None:
        found["reduction"] = result.outcome.reduction
    if result.coverage is not None:
        found["coverage"] = coverage_object(result.coverage)
    return found


def coverage_object(coverage: Coverage) -> dict[str, Any]:
    """What never happened as the schema writes it."""
    return {
        "prefixes": coverage.prefixes,
        "performed": coverage.performed,
        "never": [
            {
                "kind": never.kind,
                "text": never.text,
                "why": never.why,
                "file": never.file or None,
                "line": never.line or None,
                "column": never.column or None,
            }
            for never in coverage.never
        ],
    }


def counterexample_object(counterexample: Counterexample) -> dict[str, Any]:
    """A counterexample as the schema writes it."""
    return {
        "kind": counterexample.kind,
        "trace": list(counterexample.trace),
        "event": counterexample.event,
        "refusal": None if counterexample.refusal is None else list(counterexample.refusal),
        "allowed": None if counterexample.allowed is None else [list(events) for events in counterexample.allowed],
        "loop": None if counterexample.loop is None else list(counterexample.loop),
        "components": [
            {
                "name": component.name,
                "trace": list(component.trace),
                "state": component.state,
                "line": component.line,
                "offers": list(component.offers),
                "waiting_for": list(component.waiting_for),
                "variables": dict(component.variables) or None,
                "changes": [dict(new) or None for new in component.changes] or None,
            }
            for component in counterexample.components
        ],
        "values": counterexample.values,
        "obligation": None if counterexample.obligation is None else _obligation_object(counterexample.obligation),
        "causes": list(counterexample.causes or (None,) * len(counterexample.trace)),
        "offered": None if counterexample.offered is None else list(counterexample.offered),
        "refusals": None
        if counterexample.refusals is None
        else [None if refused is None else list(refused) for refused in counterexample.refusals],
        "waiting_cycle": None if counterexample.waiting_cycle is None else list(counterexample.waiting_cycle),
        "specification": None
        if counterexample.specification is None
        else {
            "trace": list(counterexample.specification.trace),
            "causes": list(counterexample.specification.causes),
            "states": list(counterexample.specification.states),
        },
    }


def _obligation_object(broken: BrokenObligation) -> dict[str, Any]:
    return {
        "name": broken.name,
        "subject": broken.subject,
        "operation": broken.operation,
        "message": broken.message,
        "line": broken.line,
        "failing": broken.failing,
        "lines": [{"line": number, "text": text} for number, text in broken.lines],
        "others": list(broken.others),
    }


def diagnostic_object(diagnostic: Diagnostic) -> dict[str, Any]:
    """A diagnostic as the schema writes it."""
    span = diagnostic.span
    return {
        "severity": diagnostic.severity.value,
        "code": diagnostic.code,
        "message": diagnostic.message,
        "file": None if span is None else span.source.name,
        "line": None if span is None else span.line,
        "column": None if span is None else span.column,
        "end_line": None if span is None else span.end_line,
        "end_column": None if span is None else span.end_column,
        "help": diagnostic.help,
    }
