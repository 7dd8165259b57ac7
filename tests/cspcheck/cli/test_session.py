"""How a run goes on when something goes wrong: interrupts, mistakes of ours, readers that leave."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from cspcheck import checking
from cspcheck.checker.verdict import Outcome, Verdict
from cspcheck.cli import run
from cspcheck.cspm.diagnostics import Diagnostic, ScriptError, Severity
from cspcheck.cspm.source import Source, Span
from cspcheck.cspm.syntax.tree import Assertion, BooleanAssertion, LiteralExpr

Answer = Verdict | BaseException


@dataclass(frozen=True)
class FakeAssertion:
    text: str
    span: Span
    node: Assertion
    expected: str | None = None


@dataclass
class FakeScript:
    source: Source
    answers: dict[str, Answer]
    warnings: tuple[Diagnostic, ...] = ()
    printed: tuple[str, ...] = ()
    assertions: tuple[FakeAssertion, ...] = field(init=False)

    def __post_init__(self) -> None:
        self.assertions = tuple(
            FakeAssertion(text, span := self.source.span(0, 1), BooleanAssertion(condition=boolean(span), span=span))
            for text in self.answers
        )


def boolean(span: Span) -> LiteralExpr:
    return LiteralExpr(kind="bool", value=True, span=span)


class FakeChecker:
    def __init__(self, script: FakeScript) -> None:
        self._script = script

    def check(self, node: Assertion) -> Outcome:
        (text,) = (assertion.text for assertion in self._script.assertions if assertion.node is node)
        answer = self._script.answers[text]
        if isinstance(answer, BaseException):
            raise answer
        return Outcome(answer, "a limit" if answer is Verdict.UNKNOWN else None, 3, 4, 0.5, 0)


Scripts = Callable[..., None]


@pytest.fixture
def scripts(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Scripts:
    """Let scripts be what a test says instead of what files hold."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cspcheck.failure.tempfile.tempdir", str(tmp_path))

    def set_up(**known: dict[str, Answer] | BaseException) -> None:
        def load(path: str, settings: checking.Settings) -> FakeScript:
            content = known[path.removesuffix(".csp")]
            if isinstance(content, BaseException):
                raise content
            return FakeScript(Source(path, "assert true\n"), content)

        monkeypatch.setattr(checking, "load", load)
        monkeypatch.setattr(checking, "checker_for", lambda script, settings, watch: FakeChecker(script))

    return set_up


PASS, FAIL, UNKNOWN = Verdict.PASS, Verdict.FAIL, Verdict.UNKNOWN


@pytest.mark.parametrize(
    ("contents", "code"),
    [
        ({"a": {"P": PASS}}, 0),
        ({"a": {"P": PASS, "Q": FAIL}}, 1),
        ({"a": {"P": PASS, "Q": UNKNOWN}}, 3),
        ({"a": {"P": FAIL, "Q": UNKNOWN}}, 1),
        ({"a": {"P": ScriptError(Diagnostic("CSP401", "bad"))}}, 2),
        ({"a": {"P": FAIL}, "b": ScriptError(Diagnostic("CSP101", "bad"))}, 2),
        ({"a": {"P": FAIL}, "b": {"P": ValueError("ours")}}, 4),
        ({"a": ZeroDivisionError("ours"), "b": {"P": PASS}}, 4),
        ({"a": {"P": MemoryError()}}, 3),
        ({"a": {}}, 5),
        ({"a": {}, "b": {"P": PASS}}, 0),
        ({"a": {}, "b": ScriptError(Diagnostic("CSP101", "bad"))}, 2),
        ({"a": {"P": FAIL, "Q": KeyboardInterrupt()}}, 130),
        ({"a": KeyboardInterrupt()}, 130),
    ],
)
def test_the_exit_code_of_a_run(scripts: Scripts, contents: dict[str, dict[str, Answer]], code: int) -> None:
    scripts(**contents)

    assert run([f"{name}.csp" for name in contents]) == code


def test_an_interrupt_prints_what_was_finished(scripts: Scripts, capsys: pytest.CaptureFixture[str]) -> None:
    scripts(a={"P": PASS, "Q": KeyboardInterrupt(), "R": PASS}, b={"S": PASS})

    assert run(["a.csp", "b.csp"]) == 130
    out, err = capsys.readouterr()
    assert out.startswith("a.csp\n✓ P ")
    assert "\n? Q " in out
    assert "\nnot reached: a.csp (1)\n\ninterrupted; until then: 1 pass; 2 assertions without an answer, in " in out
    assert "R" not in out
    assert err == ""


def test_an_interrupted_document_is_whole(scripts: Scripts, capsys: pytest.CaptureFixture[str]) -> None:
    scripts(a={"P": PASS, "Q": KeyboardInterrupt()})

    assert run(["a.csp", "--format", "json"]) == 130
    document = json.loads(capsys.readouterr().out)
    assert document["interrupted"] is True
    assert [(result["assertion"], result["verdict"], result["reason"]) for result in document["results"]] == [
        ("P", "pass", None),
        ("Q", "unknown", "interrupted"),
    ]


UNREACHED = """\
include "part.csp"
assert STOP [T= STOP
-- expect: fail
assert STOP :[deadlock free]
Timed { assert SKIP :[deadlock free] }
"""


class TestUnreached:
    """An interrupted run tells every selected assertion that it has not come to, so that no report looks complete."""

    @pytest.fixture(autouse=True)
    def _interrupted(self, scripts: Scripts) -> None:
        scripts(a={"P": PASS, "Q": KeyboardInterrupt(), "R": PASS})
        Path("b.csp").write_text(UNREACHED)
        Path("part.csp").write_text("assert RUN({}) :[divergence free]\n")
        Path("broken.csp").write_text("P = = STOP\n")

    def told(self, capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
        assert run(["a.csp", "b.csp", "broken.csp", "no_such_file.csp", *arguments]) == 130
        out, err = capsys.readouterr()
        assert err == ""
        return out

    def test_in_json(self, capsys: pytest.CaptureFixture[str]) -> None:
        document = json.loads(self.told(capsys, "--format", "json"))
        assert document["summary"] == {"pass": 1, "fail": 0, "unknown": 6, "error": 0}
        found = [(r["file"], r["line"], r["assertion"], r["verdict"], r["expected"]) for r in document["results"][1:]]
        assert found == [
            ("a.csp", 1, "Q", "unknown", "pass"),
            ("a.csp", 1, "R", "unknown", "pass"),
            ("part.csp", 1, "RUN({}) :[divergence free]", "unknown", "pass"),
            ("b.csp", 2, "STOP [T= STOP", "unknown", "pass"),
            ("b.csp", 4, "STOP :[deadlock free]", "unknown", "fail"),
            ("b.csp", 5, "SKIP :[deadlock free]", "unknown", "pass"),
        ]
        assert {result["reason"] for result in document["results"][1:]} == {"interrupted"}

    def test_only_what_is_selected(self, capsys: pytest.CaptureFixture[str]) -> None:
        document = json.loads(self.told(capsys, "--format", "json", "--assert", "Q", "--assert", "SKIP"))
        assert [result["assertion"] for result in document["results"]] == ["Q", "SKIP :[deadlock free]"]

    def test_in_junit(self, capsys: pytest.CaptureFixture[str]) -> None:
        root = ET.fromstring(self.told(capsys, "--format", "junit"))
        counts = {s.get("name"): (s.get("tests"), s.get("failures"), s.get("errors")) for s in root}
        assert counts == {"a.csp": ("3", "0", "2"), "b.csp": ("3", "0", "3"), "part.csp": ("1", "0", "1")}
        assert {error.get("type") for error in root.iter("error")} == {"unknown"}

    def test_in_lines(self, capsys: pytest.CaptureFixture[str]) -> None:
        *results, last = map(json.loads, self.told(capsys, "--format", "jsonl").splitlines())
        assert [result["verdict"] for result in results] == ["pass", *["unknown"] * 6]
        assert last == {"interrupted": True}

    def test_in_concise_and_github(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert self.told(capsys, "--format", "concise").splitlines()[-1] == (
            "b.csp:5: unknown: SKIP :[deadlock free] -- interrupted"
        )
        lines = self.told(capsys, "--format", "github").splitlines()
        assert lines[1:3] == [
            "::warning file=a.csp,title=assertions%3A unknown::interrupted: 1 assertion not reached",
            "::warning file=part.csp,title=assertions%3A unknown::interrupted: 1 assertion not reached",
        ]
        assert lines[-1] == "cspcheck: interrupted; 1 pass, 0 fail, 6 unknown, 0 error"

    def test_for_people(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert "\nnot reached: a.csp (1), part.csp (1), b.csp (3)\n" in self.told(capsys)


def test_a_mistake_of_ours_is_reported_and_does_not_stop_the_others(
    scripts: Scripts, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    scripts(a={"P": IndexError("list index out of range"), "Q": PASS})

    assert run(["a.csp"]) == 4
    out, err = capsys.readouterr()
    assert "✓ Q" in out
    assert "1 pass, 1 error" in out
    lines = err.splitlines()
    assert lines[0] == "error[CSP900]: internal error while checking `P`: IndexError: list index out of range"
    assert lines[1].startswith("  = note: cspcheck 0.1.0, Python 3.")
    assert lines[2].startswith("          arguments: ")
    assert lines[3].startswith(f"  = note: the traceback is in {tmp_path}/cspcheck-error-")
    assert lines[4].startswith("  = note: this is a mistake in cspcheck, not in your script: please report it")
    assert "Traceback" not in err
    (kept,) = tmp_path.glob("cspcheck-error-*.txt")
    assert "Traceback" in kept.read_text()
    assert "IndexError: list index out of range" in kept.read_text()


def test_several_mistakes_of_ours_share_a_file_and_the_facts(
    scripts: Scripts, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    scripts(a={"P": IndexError("first"), "Q": KeyError("second")})

    assert run(["a.csp"]) == 4
    err = capsys.readouterr().err
    (kept,) = tmp_path.glob("cspcheck-error-*.txt")
    assert err.count("please report it") == 1
    assert err.count(f"the traceback is in {kept}") == 2
    assert kept.read_text().count("Traceback") == 2


def test_verbose_shows_the_traceback_of_a_mistake_of_ours(
    scripts: Scripts, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    scripts(a=RecursionError("too deep"))

    assert run(["a.csp", "-v"]) == 4
    assert "Traceback" in capsys.readouterr().err
    assert not list(tmp_path.glob("cspcheck-error-*"))


def test_a_mistake_of_ours_is_in_the_document_too(scripts: Scripts, capsys: pytest.CaptureFixture[str]) -> None:
    scripts(a={"P": IndexError("ours"), "Q": PASS})

    assert run(["a.csp", "--format=json"]) == 4
    out, err = capsys.readouterr()
    document = json.loads(out)
    assert document["diagnostics"][0]["code"] == "CSP900"
    assert [result["verdict"] for result in document["results"]] == ["error", "pass"]
    assert document["summary"] == {"pass": 1, "fail": 0, "unknown": 0, "error": 1}
    assert err == ""


def test_running_out_of_memory_is_unknown(scripts: Scripts, capsys: pytest.CaptureFixture[str]) -> None:
    scripts(a={"P": MemoryError()})

    assert run(["a.csp", "--format=json"]) == 3
    (result,) = json.loads(capsys.readouterr().out)["results"]
    assert (result["verdict"], result["reason"]) == ("unknown", "out of memory")


def test_an_error_in_an_assertion_does_not_stop_the_others(
    scripts: Scripts, capsys: pytest.CaptureFixture[str]
) -> None:
    scripts(a={"P": ScriptError(Diagnostic("CSP401", "the head of an empty sequence")), "Q": PASS})

    assert run(["a.csp"]) == 2
    out, err = capsys.readouterr()
    assert "! P" in out
    assert "  The head of an empty sequence.\n" in out
    assert "✓ Q" in out
    assert err == "error[CSP401]: the head of an empty sequence\n\n"


def test_warnings_go_to_standard_error_unless_quiet(
    scripts: Scripts, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    scripts(a={"P": PASS})
    warning = Diagnostic("CSP399", "odd", severity=Severity.WARNING)
    load = checking.load

    def load_with_warning(path: str, settings: checking.Settings) -> object:
        script = load(path, settings)
        script.warnings = (warning,)  # type: ignore[misc]
        return script

    monkeypatch.setattr(checking, "load", load_with_warning)

    assert run(["a.csp"]) == 0
    assert capsys.readouterr().err == "warning[CSP399]: odd\n\n"
    assert run(["a.csp", "-q"]) == 0
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("arguments", "selected"),
    [
        (["--assert", "first"], ["first one"]),
        (["--assert", "f*one", "--assert", "second"], ["first one", "second"]),
    ],
)
def test_patterns_select(
    scripts: Scripts, capsys: pytest.CaptureFixture[str], arguments: list[str], selected: list[str]
) -> None:
    scripts(a={"first one": PASS, "second": PASS, "third": FAIL}, b={"other": FAIL})

    assert run(["a.csp", "b.csp", "--format=json", *arguments]) == 0
    assert [r["assertion"] for r in json.loads(capsys.readouterr().out)["results"]] == selected


def test_a_pattern_that_selects_nothing(scripts: Scripts, capsys: pytest.CaptureFixture[str]) -> None:
    scripts(a={"first one": PASS})

    assert run(["a.csp", "--assert", "nothing"]) == 5
    out, err = capsys.readouterr()
    assert out.startswith("nothing was checked, in ")
    assert err == (
        "warning[CSP903]: no assertion selected for `nothing`\n"
        "  = note: the assertions are\n"
        "          a.csp:1: first one\n\n"
    )


def test_a_line_without_an_assertion_is_told_although_others_are_checked(
    scripts: Scripts, capsys: pytest.CaptureFixture[str]
) -> None:
    scripts(a={"first": PASS}, b={"second": PASS})

    assert run(["a.csp:7", "b.csp:1"]) == 0
    assert "no assertion selected for `a.csp:7`" in capsys.readouterr().err


def test_a_script_without_assertions_is_told(scripts: Scripts, capsys: pytest.CaptureFixture[str]) -> None:
    scripts(a={})

    assert run(["a.csp"]) == 5
    assert capsys.readouterr().err == (
        "warning[CSP902]: `a.csp` has no assertions\n"
        "  = help: add one, as in `assert P :[deadlock free]`, or use `cspcheck typecheck`\n\n"
    )


class TestCheckpoints:
    def test_a_run_goes_on_where_another_ended(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("cspcheck.checker.search.checkpoint.EVERY", 0.0)
        (tmp_path / "s.csp").write_text(
            "channel a : {0..3}\nP(i) = a.i -> P((i + 1) % 4)\nassert P(0) :[deadlock free]\n"
        )
        monkeypatch.chdir(tmp_path)
        assert run(["s.csp", "--full", "--checkpoint", "runs"]) == 0
        assert list((tmp_path / "runs").glob("*/*.rows"))
        assert run(["s.csp", "--full", "--resume", "runs", "--workers", "1", "--timeout", "5m"]) == 0

    def test_a_folder_of_something_else_is_refused_in_words(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (tmp_path / "part.csp").write_text("channel a\n")
        (tmp_path / "s.csp").write_text('include "part.csp"\nassert STOP [T= STOP\n')
        monkeypatch.chdir(tmp_path)
        assert run(["s.csp", "--resume", "runs"]) == 2
        assert "cannot be used for `s.csp`: it has no checkpoints" in capsys.readouterr().err
        assert run(["s.csp", "--checkpoint", "runs"]) == 0
        assert run(["s.csp", "--checkpoint", "runs"]) == 2
        assert "it has checkpoints already" in capsys.readouterr().err
        assert run(["s.csp", "--resume", "runs", "--full"]) == 2
        assert "those of another set of options" in capsys.readouterr().err
        (tmp_path / "part.csp").write_text("channel a, b\n")
        assert run(["s.csp", "--resume", "runs"]) == 2
        assert "error[CSP930]" in capsys.readouterr().err
        assert run(["s.csp", "--resume", "runs", "--checkpoint", "runs"]) == 2
