"""``cspcheck refines``: FDR4's command line, so that what calls ``refines`` changes one word."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from jsonschema import validate

from cspcheck.cli import run
from cspcheck.report.schemas import schema

SCRIPT = """\
channel a, b, c
P = a -> (b -> P [] c -> STOP)
Q = a -> b -> Q
H = (a -> b -> c -> STOP) \\ {b}
S = a -> SKIP
print 1 + 1
assert Q [T= P
assert P :[deadlock free]
assert Q [F= P |~| Q
assert (let D = b -> D within a -> D \\ {b}) :[divergence free]
assert Q [FD= Q
assert a -> STOP |~| a -> b -> STOP :[deterministic]
assert not Q [T= P
assert Q [T= H
assert S :[deadlock free]
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "r.csp").write_text(SCRIPT)
    return tmp_path


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = run(["refines", *arguments])
    out, err = capsys.readouterr()
    return code, out, err


def document(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    _, out, _ = said(capsys, "--format", "json", "--quiet", *arguments)
    parsed: dict[str, Any] = json.loads(out)
    validate(parsed, schema("refines"))
    return parsed


def named(found: dict[str, Any], behaviour: dict[str, Any]) -> list[str]:
    """A trace as a program that reads FDR4's output turns it into names."""
    return [found["event_map"][str(event)] for event in behaviour["trace"]]


class TestJson:
    def test_has_what_programs_look_up(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        found = document(capsys, "r.csp")

        assert found["file_name"] == "r.csp"
        assert found["errors"] == found["warnings"] == []
        assert found["print_statement_results"] == ["2"]
        assert [r["result"] for r in found["results"]] == [0, 0, 0, 0, 1, 0, 1, 0, 0]
        assert [r["is_negated"] for r in found["results"]] == [0, 0, 0, 0, 0, 0, 1, 0, 0]
        assert found["results"][0]["assertion_string"] == "Q [T= P"
        assert found["results"][4]["counterexamples"] == []
        assert found["results"][4]["visited_states"] == 2

    def test_traces_are_numbers_that_the_event_map_names(
        self, folder: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        found = document(capsys, "r.csp")
        [counterexample] = found["results"][0]["counterexamples"]
        run_ = counterexample["implementation_behaviour"]

        assert counterexample["type"] == run_["type"] == "trace"
        assert run_["machine_name"] == "P"
        assert named(found, run_) == ["a"]
        assert found["event_map"][str(run_["error_event"])] == "c"
        assert (found["event_map"]["1"], found["event_map"]["2"]) == ("τ", "✓")
        assert counterexample["specification_behaviour"]["error_event"] == 0
        assert counterexample["specification_behaviour"]["machine_name"] == "Q"
        assert counterexample["specification_behaviour"]["trace"] == run_["trace"]
        assert counterexample["specification_behaviour"]["states"] == ["Q", "b -> Q"]

    def test_the_specification_stands_still_at_a_tau(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        found = document(capsys, "r.csp")
        [counterexample] = found["results"][7]["counterexamples"]

        assert named(found, counterexample["implementation_behaviour"]) == ["a", "τ"]
        assert counterexample["specification_behaviour"]["trace"][1] == 0
        assert counterexample["specification_behaviour"]["states"][2] == "<unchanged>"

    def test_taus_are_revealed_on_request(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        found = document(capsys, "--reveal-taus", "r.csp")
        [counterexample] = found["results"][7]["counterexamples"]

        assert named(found, counterexample["implementation_behaviour"]) == ["a", "b"]

    def test_the_kinds_of_counterexamples(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        found = document(capsys, "r.csp")
        kinds = [[c["type"] for c in r["counterexamples"]] for r in found["results"]]

        assert kinds == [
            ["trace"], ["deadlock"], ["trace"], ["divergence"], [], ["determinism"], ["trace"], ["trace"], ["deadlock"],
        ]  # fmt: skip
        [deadlock] = found["results"][1]["counterexamples"]
        assert deadlock["implementation_behaviour"]["min_acceptance"] == []
        assert "specification_behaviour" not in deadlock
        [divergence] = found["results"][3]["counterexamples"]
        looping = divergence["implementation_behaviour"]
        assert (looping["type"], looping["loop_index"], named(found, looping)) == ("loop", 1, ["a", "τ"])
        [terminated] = found["results"][8]["counterexamples"]
        assert named(found, terminated["implementation_behaviour"]) == ["a", "τ"]

    def test_components_are_children_of_the_behaviour(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        Path("two.csp").write_text(
            "channel a, b, c\nP = a -> b -> P\nQ = c -> b -> c -> Q\nassert STOP [T= P [| {b} |] Q \\ {a, c}\n"
        )
        found = document(capsys, "two.csp")
        behaviour = found["results"][0]["counterexamples"][0]["implementation_behaviour"]

        assert [child["machine_name"] for child in behaviour["child_behaviours"]] == ["P", "Q"]
        assert {len(child["trace"]) for child in behaviour["child_behaviours"]} == {len(behaviour["trace"])}

    def test_an_error_is_told_in_the_document(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        Path("bad.csp").write_text("channel a\nP = b -> P\nassert P :[deadlock free]\n")
        found = document(capsys, "bad.csp")

        assert found["file_name"] == "bad.csp"
        assert found["results"] == []
        assert [text.startswith("bad.csp:2:5: ") for text in found["errors"]] == [True]

    def test_one_document_a_file_and_a_line(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        Path("ok.csp").write_text("channel a\nP = a -> P\nassert P :[deadlock free]\n")
        _, out, _ = said(capsys, "--format=framed_json", "-q", "ok.csp", "r.csp")

        assert [json.loads(line)["file_name"] for line in out.splitlines()] == ["ok.csp", "r.csp"]

    def test_what_was_given_up_is_an_error_and_no_pass(
        self, folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        Path("u.csp").write_text("channel a : Int\nP(n) = a!n -> P(n + 1)\nassert P(0) :[deadlock free]\n")
        code, out, _ = said(capsys, "--format", "json", "-q", "--max-states", "50", "u.csp")
        [result] = json.loads(out)["results"]

        assert (code, result["result"]) == (1, 0)
        assert "50" in result["errors"][0]


class TestExitCodes:
    """0 says that everything was answered, as programs that call FDR4 expect; the answers are in the output."""

    @pytest.mark.parametrize(
        ("text", "plain", "strict"),
        [
            ("channel a\nP = a -> P\nassert P :[deadlock free]\n", 0, 0),
            ("channel a\nP = a -> STOP\nassert P :[deadlock free]\n", 0, 1),
            ("channel a\nP = b -> STOP\nassert P :[deadlock free]\n", 1, 2),
            ("channel a\nP = a -> head(<>)\nassert P :[deadlock free]\n", 1, 2),
        ],
    )
    def test_of(self, text: str, plain: int, strict: int, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        Path("x.csp").write_text(text)

        assert said(capsys, "x.csp")[0] == plain
        assert said(capsys, "--strict", "x.csp")[0] == strict


class TestPlain:
    def test_says_the_results(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        Path("p.csp").write_text("channel a, b\nP = a -> STOP\nQ = a -> Q\nassert P [T= Q\nassert Q :[deadlock free]\n")
        code, out, _ = said(capsys, "-q", "p.csp")

        assert code == 0
        assert out == (
            "P [T= Q:\n"
            "    Result: Failed\n"
            "    Visited States: 2\n"
            "    Visited Transitions: 1\n"
            "    Counterexample (Trace)\n"
            "        Specification Debug:\n"
            "            Trace: <a>\n"
            "            Available Events: {}\n"
            "        Implementation Debug:\n"
            "            Q (Trace Behaviour):\n"
            "                Trace: <a>\n"
            "                Error Event: a\n"
            "Q :[deadlock free]:\n"
            "    Result: Passed\n"
            "    Visited States: 1\n"
            "    Visited Transitions: 1\n"
        )

    def test_in_short(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        _, out, _ = said(capsys, "-b", "-q", "r.csp")

        assert "Counterexample" not in out
        assert out.count("Result: Failed") == 7
        assert out.count("Result: Passed") == 2

    def test_types_only(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert said(capsys, "--typecheck", "r.csp")[:2] == (0, "r.csp: types are right\n")

    def test_from_standard_input(
        self, folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        import io
        import sys

        class Input:
            buffer = io.BytesIO(b"channel a\nassert a -> STOP :[divergence free]\n")

        monkeypatch.setattr(sys, "stdin", Input())
        code, out, _ = said(capsys, "-q", "-")

        assert (code, "Result: Passed" in out) == (0, True)


class TestOptions:
    def test_components_are_always_told(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert said(capsys, "-q", "--divide", "r.csp") == said(capsys, "-q", "r.csp")

    @pytest.mark.parametrize("option", ["--archive=x.arch", "--remote=host"])
    def test_refused_in_words(self, option: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        code, out, err = said(capsys, option, "r.csp")

        assert (code, out) == (2, "")
        assert option.split("=")[0] in err

    def test_other_formats_are_refused_with_those_that_there_are(
        self, folder: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        code, _, err = said(capsys, "--format", "yaml", "r.csp")

        assert code == 2
        assert "framed_json" in err

    def test_those_of_the_engine_are_read(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        given = ["--compiler-reuse-machines=off", "--refinement-bfs-workers", "2", "--refinement.storage.type=b"]
        code, out, err = said(capsys, *given, "-b", "r.csp")

        assert code == 0
        assert out.count("Result:") == 9
        assert "`--compiler-reuse-machines` has no effect" in err
        assert "workers" not in err

    def test_can_be_cut_short(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert said(capsys, "--qui", "--bri", "r.csp") == said(capsys, "--quiet", "--brief", "r.csp")

    def test_version(self, capsys: pytest.CaptureFixture[str]) -> None:
        code, out, _ = said(capsys, "--version")

        assert code == 0
        assert "refines" in out
        assert "cspcheck" in out
