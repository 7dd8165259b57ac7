"""What programs read: JSON, lines of JSON, JUnit, GitHub's annotations, and one line an assertion."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any

import pytest
from syrupy.assertion import SnapshotAssertion

from cspcheck.checker.verdict import Verdict
from cspcheck.cspm.diagnostics import Diagnostic, Severity
from cspcheck.report import FORMATS, Report, report
from cspcheck.report.concise import ConciseReport
from cspcheck.report.explanation import explanation
from cspcheck.report.github import GithubReport
from cspcheck.report.json import JsonLinesReport, JsonReport
from cspcheck.report.junit import JunitReport
from cspcheck.report.sentences import sentence
from cspcheck.report.style import PLAIN, Style, harmless
from cspcheck.result import Result, Summary


def fill(to: Report, results: dict[str, Result], mistakes: dict[str, Diagnostic], summary: Summary) -> None:
    to.diagnostics(mistakes.values())
    to.script("table.csp", ("{1, 2}",))
    for result in results.values():
        to.result(result)
    to.end(summary)


@pytest.fixture
def pieces() -> list[str]:
    return []


@pytest.fixture
def document(
    pieces: list[str], results: dict[str, Result], mistakes: dict[str, Diagnostic], summary: Summary
) -> dict[str, Any]:
    fill(JsonReport(pieces.append, "0.1.0"), results, mistakes, summary)
    parsed: dict[str, Any] = json.loads("".join(pieces))
    return parsed


def plain(value: object) -> Any:
    """A value of the results in the forms that JSON has."""
    if isinstance(value, Enum):
        return value.value
    if is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {key: plain(content) for key, content in value.items()}
    if isinstance(value, tuple | list):
        return [plain(content) for content in value]
    return value


class TestJson:
    def test_every_member_is_what_the_result_has(
        self, document: dict[str, Any], results: dict[str, Result], mistakes: dict[str, Diagnostic], summary: Summary
    ) -> None:
        for found, result in zip(document["results"], results.values(), strict=True):
            counterexample = found.pop("counterexample")
            assert found.pop("seconds") == pytest.approx(result.seconds, abs=1e-6)
            assert found == {name: plain(getattr(result, name)) for name in found}
            if result.counterexample is None:
                assert counterexample is None
                continue
            expected = plain(result.counterexample)
            expected["causes"] = expected["causes"] or [None] * len(result.counterexample.trace)
            for component in expected["components"]:
                component["variables"] = component["variables"] or None
                component["changes"] = [new or None for new in component["changes"]] or None
            if expected["obligation"] is not None:
                lines = [{"line": line, "text": text} for line, text in expected["obligation"]["lines"]]
                expected["obligation"]["lines"] = lines
            for name, member in counterexample.items():
                if isinstance(member, dict) and isinstance(expected[name], dict):
                    assert member == {key: expected[name][key] for key in member}, name
                else:
                    assert member == expected[name], name
        for found, diagnostic in zip(document["diagnostics"], mistakes.values(), strict=True):
            assert (found["severity"], found["code"], found["message"], found["help"]) == (
                diagnostic.severity.value, diagnostic.code, diagnostic.message, diagnostic.help
            )  # fmt: skip
            if diagnostic.span is not None:
                span = diagnostic.span
                assert (found["file"], found["line"], found["column"]) == (span.source.name, span.line, span.column)
                assert (found["end_line"], found["end_column"]) == (span.end_line, span.end_column)
        assert document["summary"] == summary.verdicts

    def test_the_keys_and_their_order(self, document: dict[str, Any]) -> None:
        assert list(document) == ["schema", "version", "interrupted", "results", "diagnostics", "summary"]
        assert document["schema"] == "cspcheck/1"
        assert list(document["summary"]) == ["pass", "fail", "unknown", "error"]
        for result in document["results"]:
            assert list(result) == [
                "file", "line", "assertion", "kind", "model", "verdict", "expected", "reason", "states", "transitions",
                "seconds", "peak_memory_bytes", "counterexample",
            ]  # fmt: skip
            if result["counterexample"] is None:
                continue
            assert list(result["counterexample"]) == [
                "kind", "trace", "event", "refusal", "allowed", "loop", "components", "values", "obligation",
                "causes", "offered", "refusals", "waiting_cycle", "specification",
            ]  # fmt: skip
            for component in result["counterexample"]["components"]:
                assert list(component) == [
                    *("name", "trace", "state", "line", "offers", "waiting_for", "variables", "changes")
                ]
                assert len(component["trace"]) == len(result["counterexample"]["trace"])
        for diagnostic in document["diagnostics"]:
            assert list(diagnostic) == [
                "severity", "code", "message", "file", "line", "column", "end_line", "end_column", "help"
            ]  # fmt: skip

    def test_it_is_ascii_so_that_any_terminal_and_pipe_carries_it(
        self, document: dict[str, Any], pieces: list[str]
    ) -> None:
        assert document
        assert "".join(pieces).isascii()

    def test_an_interrupted_run_is_still_a_document(self, pieces: list[str]) -> None:
        JsonReport(pieces.append, "0.1.0").end(Summary.empty(), interrupted=True)

        assert json.loads("".join(pieces))["results"] == []


def test_lines_of_json_are_the_objects_of_the_document(
    document: dict[str, Any], results: dict[str, Result], mistakes: dict[str, Diagnostic], summary: Summary
) -> None:
    lines: list[str] = []
    fill(JsonLinesReport(lines.append), results, mistakes, summary)

    assert all(line.endswith("\n") and line.count("\n") == 1 for line in lines)
    assert [json.loads(line) for line in lines] == document["diagnostics"] + document["results"]


def test_concise(
    pieces: list[str],
    results: dict[str, Result],
    mistakes: dict[str, Diagnostic],
    summary: Summary,
    snapshot: SnapshotAssertion,
) -> None:
    fill(ConciseReport(pieces.append), results, mistakes, summary)

    told = r"\S+:\d+: (pass|fail|unknown|error): \S|(\S+:\d+:\d+: )?(error|warning)\[CSP\d{3}\]: \S"
    assert all(re.match(told, line) and line.count("\n") == 1 for line in pieces)
    assert "".join(pieces) == snapshot


def test_quiet_concise_leaves_out_what_is_as_expected(
    pieces: list[str], results: dict[str, Result], summary: Summary
) -> None:
    fill(ConciseReport(pieces.append, -1), results, {}, summary)

    assert len(pieces) == sum(not result.as_expected for result in results.values())


class TestGithub:
    def test_word_for_word(
        self,
        pieces: list[str],
        results: dict[str, Result],
        mistakes: dict[str, Diagnostic],
        summary: Summary,
        snapshot: SnapshotAssertion,
    ) -> None:
        fill(GithubReport(pieces.append), results, mistakes, summary)

        assert "".join(pieces) == snapshot

    def test_a_run_that_is_as_expected_has_no_annotation(
        self, pieces: list[str], results: dict[str, Result], summary: Summary
    ) -> None:
        fill(GithubReport(pieces.append), {n: r for n, r in results.items() if r.as_expected}, {}, summary)

        assert len(pieces) == 1
        assert "::" not in pieces[0]

    def test_separators_in_properties_and_text_are_escaped(
        self, pieces: list[str], results: dict[str, Result], mistakes: dict[str, Diagnostic]
    ) -> None:
        to = GithubReport(pieces.append)
        to.result(results["hostile"])
        to.diagnostics([mistakes["hostile"]])

        assert all(line.count("\n") == 1 for line in pieces)
        assert pieces[0].startswith("::error file=a%25b%2Cc%3Ad.csp,line=40,title=assertion%3A fail::")
        assert pieces[1].endswith("title=CSP001::bad \ufffd[2Jtext\u2424::error::100%25\n")

    def test_columns_are_for_places_within_a_line(self, pieces: list[str], mistakes: dict[str, Diagnostic]) -> None:
        GithubReport(pieces.append).diagnostics([mistakes["plain"], mistakes["several lines"]])

        assert "line=4,endLine=4,col=12,endColumn=14,title=" in pieces[0]
        assert "line=7,endLine=9,title=" in pieces[1]


def decoded(text: str) -> str:
    """A text as it comes back from a document: without what would act on a terminal or has no place in XML."""
    return re.sub("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "\ufffd", harmless(text))


class TestJunit:
    @pytest.fixture
    def xml(
        self, pieces: list[str], results: dict[str, Result], mistakes: dict[str, Diagnostic], summary: Summary
    ) -> str:
        to = JunitReport(pieces.append, timestamp="2024-01-02T03:04:05", hostname="here")
        fill(to, results, mistakes, summary)
        return "".join(pieces)

    def test_every_case_is_what_the_result_or_mistake_says(
        self, xml: str, results: dict[str, Result], mistakes: dict[str, Diagnostic]
    ) -> None:
        cases = {(case.attrib["classname"], case.attrib["name"]): case for case in ET.fromstring(xml).iter("testcase")}
        rows = [case for case in ET.fromstring(xml).iter("testcase") if not case.attrib["name"].startswith("CSP")]
        for result in results.values():
            case = next(row for row in rows if row.attrib["classname"] == decoded(result.file))
            rows.remove(case)
            assert case.attrib["name"] == decoded(" ".join(result.assertion.split()))
            assert float(case.attrib["time"]) == pytest.approx(result.seconds, abs=1e-3)
            assert (len(case) == 0) == result.as_expected
            for wrong in case:
                assert wrong.tag == ("failure" if result.verdict in (Verdict.PASS, Verdict.FAIL) else "error")
                assert wrong.attrib == {"type": result.verdict.value, "message": decoded(sentence(result))}
                told = "\n".join([f"{result.file}:{result.line}", *explanation(result, PLAIN)])
                assert (wrong.text or "").startswith("\n".join(map(decoded, told.split("\n"))))
        assert not rows
        for mistake in mistakes.values():
            if mistake.severity is Severity.ERROR and mistake.span is not None:
                case = cases[decoded(mistake.span.source.name), f"{mistake.code} in line {mistake.span.line}"]
                assert case[0].attrib == {"type": mistake.code, "message": decoded(mistake.message)}
                assert (case[0].text or "").startswith(f"error[{mistake.code}]: ")

    def test_it_has_what_the_schemas_of_ant_and_jenkins_want_and_nothing_else(self, xml: str) -> None:
        """The rules of ``JUnit.xsd`` (Ant) and ``junit-10.xsd`` (Jenkins), both at once."""
        root = ET.fromstring(xml)
        assert (root.tag, root.attrib) == ("testsuites", {})
        for i, suite in enumerate(root):
            assert suite.tag == "testsuite"
            assert set(suite.attrib) == {
                "name", "package", "id", "timestamp", "hostname", "tests", "failures", "errors", "skipped", "time"
            }  # fmt: skip
            assert suite.get("id") == str(i)
            assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d", suite.attrib["timestamp"])
            assert all(suite.attrib[name].strip() for name in ("name", "hostname"))
            assert re.fullmatch(r"\d+\.\d+", suite.attrib["time"])
            tags = [child.tag for child in suite]
            cases = suite.findall("testcase")
            assert tags == ["properties", *["testcase"] * len(cases), "system-out", "system-err"]
            for attribute, element in (("failures", "failure"), ("errors", "error")):
                assert int(suite.attrib[attribute]) == len(suite.findall(f"testcase/{element}"))
            assert int(suite.attrib["tests"]) == len(cases)
            for case in cases:
                assert set(case.attrib) == {"name", "classname", "time"}
                assert len(case) <= 1
                for wrong in case:
                    assert wrong.tag in ("failure", "error")
                    assert set(wrong.attrib) == {"type", "message"}

    def test_what_the_script_expects_passes(self, xml: str, results: dict[str, Result]) -> None:
        cases = [case for case in ET.fromstring(xml).iter("testcase") if case.attrib["classname"] == "table.csp"]
        wrong = [r for r in results.values() if not r.as_expected and r.file == "table.csp"]

        assert sum(len(case) == 1 for case in cases if not case.attrib["name"].startswith("CSP")) == len(wrong)

    def test_a_run_without_scripts_is_still_a_document(self, pieces: list[str]) -> None:
        JunitReport(pieces.append).end(Summary.empty())

        assert len(ET.fromstring("".join(pieces))) == 0


@pytest.mark.parametrize("form", FORMATS)
def test_every_format_takes_everything(
    form: Any, pieces: list[str], results: dict[str, Result], mistakes: dict[str, Diagnostic], summary: Summary
) -> None:
    fill(report(form, pieces.append, Style()), results, mistakes, summary)

    assert "".join(pieces).endswith("\n")
