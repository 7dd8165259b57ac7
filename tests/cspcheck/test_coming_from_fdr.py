"""The differences from FDR4 that the page of differences lists, each as it is said there."""

from __future__ import annotations

from pathlib import Path

import pytest

import cspcheck
from cspcheck.checker.verdict import DIVERGENCE_COUNTS, TERMINATES, TERMINATION_COUNTS
from cspcheck.cli import run

PAGE = Path(__file__).parents[2] / "docs" / "coming-from-fdr.md"
SCRIPT = """
channel a
P = a -> SKIP
Q = a -> Q
R = P ; Q
S = P ||| Q
Inner = (a -> SKIP) ; a -> STOP
assert P :[deadlock free]
assert Q :[deadlock free]
assert R :[deadlock free]
assert S :[deadlock free]
assert SKIP ||| SKIP :[deadlock free [F]]
"""


@pytest.fixture
def script(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("x.csp").write_text(SCRIPT)
    return Path("x.csp")


def verdicts(capsys: pytest.CaptureFixture[str], *arguments: str) -> list[str]:
    run(["check", "x.csp", "--format", "concise", *arguments])
    return [line.split(": ")[1] for line in capsys.readouterr().out.splitlines()]


class TestTermination:
    def test_is_no_deadlock_and_the_result_says_so(self) -> None:
        results = cspcheck.loads(SCRIPT).check()
        assert all(results)
        assert [TERMINATES in result.remarks for result in results] == [True, False, False, False, True]

    def test_is_one_on_request(self, script: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert verdicts(capsys) == ["pass"] * 5
        assert verdicts(capsys, "--termination", "deadlock") == ["fail", "pass", "pass", "pass", "fail"]

    def test_is_one_where_the_project_says_so(self, script: Path, capsys: pytest.CaptureFixture[str]) -> None:
        Path("pyproject.toml").write_text('[tool.cspcheck]\ntermination = "deadlock"\n')
        assert verdicts(capsys) == ["fail", "pass", "pass", "pass", "fail"]
        assert verdicts(capsys, "--termination", "success") == ["pass"] * 5

    def test_the_report_says_what_counts(self, script: Path, capsys: pytest.CaptureFixture[str]) -> None:
        run(["check", "x.csp:8", "--termination", "deadlock"])
        out = " ".join(capsys.readouterr().out.split())
        assert TERMINATION_COUNTS in out
        assert "has not terminated" not in out


def test_divergence_is_nondeterminism_and_the_result_says_so() -> None:
    (result,) = cspcheck.loads("assert DIV :[deterministic [FD]]").check()
    assert not result
    assert DIVERGENCE_COUNTS in result.remarks


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("Seq({}) == {<>}", True),
        ("inter({1..5}, {3..}) == {3..5}", True),
        ("{1..} <= {0..}", True),
        ("#<-1..2>", 4),
        ("head(<-1, 5>)", -1),
    ],
)
def test_values(text: str, value: object) -> None:
    assert cspcheck.loads("").evaluate(text) == value


@pytest.mark.parametrize(
    "assertion",
    ["STOP :[has trace]: <>", "1 == 1", "STOP [V= STOP", "STOP [RD= STOP", "STOP [T= STOP :[partial order reduce]"],
)
def test_assertions(assertion: str) -> None:
    (result,) = cspcheck.loads(f"assert {assertion}").check()
    assert result


def test_a_circle_of_includes_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "a.csp").write_text('include "b.csp"\n')
    (tmp_path / "b.csp").write_text('include "a.csp"\n')
    with pytest.raises(cspcheck.ScriptError) as caught:
        cspcheck.load(tmp_path / "a.csp")
    assert [diagnostic.code for diagnostic in caught.value.diagnostics] == ["CSP011"]


def test_what_traces_do_not_tell_is_answered_in_f() -> None:
    result, other = cspcheck.loads("assert STOP :[deadlock free [T]]\nassert STOP :[deterministic [T]]").check()
    assert not result
    assert other
    assert all("checked in F" in r.remarks[-1] for r in (result, other))


def test_an_input_that_matches_no_event_is_a_warning() -> None:
    script = cspcheck.loads("channel c : {0..1}\nP = c?5 -> P\nassert P [T= STOP")
    assert all(script.check())
    assert [warning.code for warning in script.warnings] == ["CSP221"]


def test_a_print_line_with_a_mistake_is_left_out() -> None:  # the row of the `print` line
    script = cspcheck.loads("print 1 + + 2\nassert STOP [T= STOP")
    assert [warning.code for warning in script.warnings] == ["CSP017"]
    assert all(script.check())


def test_a_specification_without_end_is_followed() -> None:
    text = "channel a, b\nCount(n) = a -> Count(n + 1) [] n > 0 & b -> Count(n - 1)\n"
    good, bad = cspcheck.loads(
        text + "assert Count(0) [T= a -> b -> STOP\nassert Count(0) [FD= a -> b -> b -> STOP"
    ).check()
    assert good
    assert not bad


def test_every_row_of_the_page_is_held_here() -> None:
    rows = PAGE.read_text(encoding="utf-8").partition("## Differences that stay")[2].split("\n\n")[1].splitlines()[2:]
    here = Path(__file__).read_text(encoding="utf-8")
    needles = ["deadlock free", "deterministic", "Seq({})", "inter(", "<= {0..}", "has trace", "circle", "<-1"]
    needles += ["1 == 1", "[V=", "normalise", "partial order", "deadlock free [T]", "matches no event", "`print` line"]
    needles += ["without end"]
    assert len(rows) == len(needles)
    for row, needle in zip(rows, needles, strict=True):
        assert needle in row
        assert needle in here


def test_normalise_of_fdr2_is_read_with_a_warning() -> None:
    script = cspcheck.loads("transparent normalise\nassert normalise(STOP) [F= STOP")
    assert script.warnings
    assert all(script.check())
