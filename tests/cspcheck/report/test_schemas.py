"""What is written for programs is what the published schemas say, with no key too many and none too few."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from cspcheck.cli import run
from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.report.json import JsonLinesReport, JsonReport
from cspcheck.report.sarif import SarifReport
from cspcheck.report.schemas import SCHEMAS, schema
from cspcheck.result import Result, Summary

SCRIPT = """\
N = 2
channel c : {0..9}
channel hidden
Count(n) = if n >= N then SKIP else c.n -> Count(n + 1)
assert c.0 -> STOP [T= Count(0)
-- expect: fail
assert Count(0) :[divergence free]
assert (hidden -> Count(0)) \\ {hidden} [F= STOP
assert 1 / 0 == 1
"""
CLASSES = """\
class Counter
  method up
  main = up -> main
  state
    n : nat
  init
    n = 0
  op up
    Delta(n)
  where
    n' = n + 1 and n' < 3
end
assert Counter :[invariant preserved]
"""


def valid(name: str, document: Any) -> bool:
    """Whether a document has this schema; the first thing that is wrong is shown."""
    errors = sorted(Draft202012Validator(schema(name)).iter_errors(document), key=lambda error: list(error.path))
    assert not errors, f"{list(errors[0].path)}: {errors[0].message[:300]}"
    return True


@pytest.mark.parametrize("name", SCHEMAS)
def test_each_is_a_schema(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    Draft202012Validator.check_schema(schema(name))
    assert run(["schema", name]) == 0
    assert json.loads(capsys.readouterr().out) == schema(name)


def test_they_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["schema"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(SCHEMAS)
    assert run(["schema", "no"]) == 2
    capsys.readouterr()


def objects(part: Any) -> Any:
    """All objects of a document, with a way to change each."""
    if isinstance(part, dict):
        yield part
        for value in part.values():
            yield from objects(value)
    elif isinstance(part, list):
        for value in part:
            yield from objects(value)


def test_every_kind_of_result_and_diagnostic(results: dict[str, Result], mistakes: dict[str, Diagnostic]) -> None:
    whole: list[str] = []
    lines: list[str] = []
    for report in (JsonReport(whole.append, "0.1.0"), JsonLinesReport(lines.append)):
        report.diagnostics(mistakes.values())
        for result in results.values():
            report.result(result)
        report.end(Summary.empty(), interrupted=True)
    document = json.loads("".join(whole))
    assert valid("check", document)
    assert all(valid("lines", json.loads(line)) for line in lines)
    # They are strict: a key more is refused wherever it stands, and so is one that is missing.
    validator = Draft202012Validator(schema("check"))
    for part in list(objects(document)):
        if set(part) <= {"amount?", "n", "n'", "old!"} or not part:
            continue  # named values
        part["more"] = 1
        assert not validator.is_valid(document), part
        del part["more"]
    first = document["results"][0]
    for key in list(first):
        value = first.pop(key)
        assert validator.is_valid(document) == (key in ("readings", "view", "reduction", "coverage"))
        first[key] = value


@pytest.fixture
def written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., str]:
    monkeypatch.chdir(tmp_path)
    Path("count.csp").write_text(SCRIPT)
    Path("counter.csp").write_text(CLASSES)
    Path("mutated.csp").write_text("channel a, b\nP = a -> b -> P\nassert P :[deadlock free]\n")
    Path("run.jsonl").write_text('"c.0"\n"c.7"\n')

    def write(*arguments: str) -> str:
        run([*arguments, "-o", "out"])
        return Path("out").read_text(encoding="utf-8")

    return write


def test_real_documents(written: Callable[..., str], capsys: pytest.CaptureFixture[str]) -> None:
    document = json.loads(written("check", "count.csp", "no_such.csp", "--format", "json"))
    assert valid("check", document)
    assert {result["verdict"] for result in document["results"]} == {"pass", "fail", "error"}
    for line in written("check", "count.csp", "--format", "jsonl").splitlines():
        assert valid("lines", json.loads(line))
    assert valid("check", json.loads(written("typecheck", "count.csp", "--format", "json")))
    assert valid("sweep", json.loads(written("sweep", "count.csp", "-D", "N=1,true", "--format", "json")))
    assert valid("prove", json.loads(written("prove", "counter.csp", "--format", "json")))
    assert valid("check", json.loads(written("check", "count.csp", "--coverage", "--format", "json")))
    assert valid("mutate", json.loads(written("mutate", "mutated.csp", "--format", "json")))
    assert valid("prove", json.loads(written("prove", "counter.csp", "--precondition", "up", "--format", "json")))
    capsys.readouterr()
    for process in ("Count(0)", "Count(7)"):
        run(["trace", "count.csp", "--process", process, "run.jsonl", "--format", "json"])
        assert valid("trace", json.loads(capsys.readouterr().out))


def test_a_record_of_the_runtime() -> None:
    from cspcheck.codegen.runtime.recorder import Record

    record = Record(3, 0.25, "c.1", "c", (1, frozenset({2})), ("P", "Q"), False)
    assert valid("record", json.loads(record.to_json()))
    assert valid("record", json.loads(record._replace(inner=True, terminated=True).to_json()))


class TestSweepAsTable:
    def test_a_line_for_each_assertion_and_value(self, written: Callable[..., str]) -> None:
        rows = list(csv.reader(io.StringIO(written("sweep", "count.csp", "-D", "N=1..2", "--format", "csv"))))
        assert rows[0] == [
            "N", "file", "line", "assertion", "verdict", "expected", "states", "transitions", "seconds", "reason"
        ]  # fmt: skip
        assert [row[0] for row in rows[1:]] == ["1"] * 4 + ["2"] * 4
        assert [row[4] for row in rows[1:4]] == ["fail", "pass", "fail"]
        assert all(len(row) == 10 for row in rows)

    def test_nothing_is_a_formula(self) -> None:
        from cspcheck.report.sweep import comma_separated
        from cspcheck.sweeping import Swept

        text = comma_separated([], ["=cmd()", "-1", "-x", "+y", "@z", "N"])
        assert text.startswith("'=cmd(),-1,'-x,'+y,'@z,N,file")
        assert Swept({}).results == []


class TestSarif:
    @pytest.fixture
    def log(self, results: dict[str, Result], mistakes: dict[str, Diagnostic]) -> dict[str, Any]:
        pieces: list[str] = []
        report = SarifReport(pieces.append, "0.1.0")
        report.diagnostics([*mistakes.values(), *mistakes.values()])
        for result in results.values():
            report.result(result)
        report.end(Summary.empty())
        log: dict[str, Any] = json.loads("".join(pieces))
        return log

    def test_its_results_are_what_is_not_as_expected(
        self, log: dict[str, Any], results: dict[str, Result], mistakes: dict[str, Diagnostic]
    ) -> None:
        (run_,) = log["runs"]
        wrong = [result for result in results.values() if not result.as_expected]
        found = [result for result in run_["results"] if result["ruleId"] == "assertion"]
        assert len(found) == len(wrong)
        told = [result for result in run_["results"] if result["ruleId"] != "assertion"]
        assert len(told) >= len(mistakes)
        assert all(result["level"] in ("error", "warning") for result in run_["results"])

    def test_each_result_points_to_its_rule(self, log: dict[str, Any]) -> None:
        (run_,) = log["runs"]
        rules = run_["tool"]["driver"]["rules"]
        assert all(rules[result["ruleIndex"]]["id"] == result["ruleId"] for result in run_["results"])
        assert len({rule["id"] for rule in rules}) == len(rules)

    def test_places_are_uris_and_regions(self, log: dict[str, Any]) -> None:
        for result in log["runs"][0]["results"]:
            for location in result.get("locations", []):
                place = location["physicalLocation"]
                assert " " not in place["artifactLocation"]["uri"]
                assert all(number >= 1 for number in place["region"].values())

    def test_an_interrupted_run_is_not_a_success(self, results: dict[str, Result]) -> None:
        pieces: list[str] = []
        report = SarifReport(pieces.append, "0.1.0")
        report.unreached([replace(results["pass"])])
        report.end(Summary.empty(), interrupted=True)
        assert json.loads("".join(pieces))["runs"][0]["invocations"] == [{"executionSuccessful": False}]
