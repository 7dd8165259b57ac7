"""What people read, word for word."""

from __future__ import annotations

from dataclasses import replace

import pytest
from syrupy.assertion import SnapshotAssertion

from cspcheck.checker.verdict import ComponentBehaviour, Verdict
from cspcheck.report.full import FullReport, explain
from cspcheck.report.style import Style, columns
from cspcheck.result import Result, Summary


def written(results: dict[str, Result], names: list[str], style: Style, verbosity: int = 0) -> str:
    pieces: list[str] = []
    report = FullReport(pieces.append, style, verbosity)
    report.script("table.csp", ("{1, 2}",))
    total = Summary.empty()
    for name in names:
        total.add(results[name])
        report.result(results[name])
    total.seconds = 75.4
    report.end(total)
    return "".join(pieces)


def test_each_result_is_explained(result: Result, snapshot: SnapshotAssertion) -> None:
    assert explain(result) == snapshot


def test_each_result_is_explained_in_ascii(result: Result, snapshot: SnapshotAssertion) -> None:
    text = explain(result, Style(unicode=False))

    assert text.replace("\ufffd", "").isascii()
    assert text == snapshot


def test_each_result_keeps_to_eighty_columns(result: Result) -> None:
    assert max(columns(line) for line in explain(result).splitlines()) <= 80


def test_a_run(results: dict[str, Result], snapshot: SnapshotAssertion) -> None:
    names = ["pass", "deadlock", "unknown", "expected failure", "negated pass", "unexpected pass", "pass"]

    assert written(results, names, Style()) == snapshot


def test_a_run_in_color(results: dict[str, Result], snapshot: SnapshotAssertion) -> None:
    assert written(results, ["pass", "trace", "unknown", "expected failure"], Style(color=True)) == snapshot


def test_a_quiet_run_says_only_what_is_wrong(results: dict[str, Result], snapshot: SnapshotAssertion) -> None:
    names = ["pass", "expected failure", "divergence", "expected unknown"]

    assert written(results, names, Style(), verbosity=-1) == snapshot


def test_a_quiet_run_without_a_fault_says_nothing(results: dict[str, Result]) -> None:
    assert written(results, ["pass", "expected failure", "expected unknown"], Style(), verbosity=-1) == ""


def test_a_verbose_run_folds_nothing(results: dict[str, Result], snapshot: SnapshotAssertion) -> None:
    names = ["pass", "expected failure", "negated pass", "folded"]

    assert written(results, names, Style(), verbosity=1) == snapshot


def test_two_scripts_have_a_heading_each(results: dict[str, Result], snapshot: SnapshotAssertion) -> None:
    pieces: list[str] = []
    report = FullReport(pieces.append)
    report.script("a.csp")
    report.result(results["pass"])
    report.script("b.csp")
    report.result(results["false"])
    total = Summary({"pass": 1, "fail": 1, "unknown": 0, "error": 0}, unexpected=1, seconds=0.5)
    report.end(total)

    assert "".join(pieces) == snapshot


@pytest.mark.parametrize(
    ("verdicts", "unexpected", "interrupted", "line"),
    [
        ((3, 0, 0, 0), 0, False, "3 pass, in 12.3 s"),
        ((2, 1, 0, 0), 1, False, "2 pass, 1 fail, in 12.3 s"),
        ((2, 1, 0, 0), 0, False, "2 pass, 1 fail, all as expected, in 12.3 s"),
        ((2, 2, 1, 0), 1, False, "2 pass, 2 fail, 1 unknown, 1 not as expected, in 12.3 s"),
        ((1000, 0, 0, 1), 1, False, "1,000 pass, 1 error, in 12.3 s"),
        ((1, 0, 0, 0), 1, False, "1 pass, 1 not as expected, in 12.3 s"),
        ((1, 0, 0, 0), 0, True, "interrupted; until then: 1 pass, in 12.3 s"),
        ((0, 0, 0, 0), 0, False, "nothing was checked, in 12.3 s"),
    ],
)
def test_the_summary(verdicts: tuple[int, ...], unexpected: int, interrupted: bool, line: str) -> None:
    pieces: list[str] = []
    passed, failed, unknown, error = verdicts
    counts = {"pass": passed, "fail": failed, "unknown": unknown, "error": error}
    FullReport(pieces.append).end(Summary(counts, unexpected, 12.3), interrupted=interrupted)  # type: ignore[arg-type]

    assert "".join(pieces) == line + "\n"


def test_long_cells_of_the_table_are_cut_to_the_width(results: dict[str, Result], snapshot: SnapshotAssertion) -> None:
    outcome = results["deadlock"].outcome
    assert outcome.counterexample is not None
    component = ComponentBehaviour(
        "Controller(<1,2,3,4,5,6,7,8>)",
        (None, None, None),
        "(a.0 -> b.0 -> Controller(<1,2,3>)) [] (c.0 -> STOP) [] (c.1 -> SKIP)",
        7,
        tuple(f"channel.{i}" for i in range(30)),
        tuple(f"Neighbour({i})" for i in range(30)),
    )
    behaviour = replace(outcome.counterexample, components=(component,), waiting_cycle=None)
    text = explain(replace(results["deadlock"], outcome=replace(outcome, counterexample=behaviour)))

    assert max(map(columns, text.splitlines())) <= 80
    assert text == snapshot


def test_a_narrow_terminal_puts_the_numbers_on_their_own_line(results: dict[str, Result]) -> None:
    lines = explain(results["pass"], Style(width=50)).splitlines()

    assert lines == ["✓ SYSTEM :[deadlock free [FD]]", "           1,234 states, 5,678 transitions, 0.25 s"]


def test_explain_is_what_the_method_of_a_result_gives(result: Result) -> None:
    assert result.explain() == explain(result)


def test_a_result_with_diagnostics_shows_them(results: dict[str, Result], mistakes: dict[str, object]) -> None:
    wrong = replace(results["error"], diagnostics=(mistakes["no place"],))  # type: ignore[arg-type]

    assert explain(wrong).endswith("\n\nerror[CSP001]: no such file: `x.csp`\n  = help: check the name")


def test_truth_is_the_verdict_pass(result: Result) -> None:
    assert bool(result) is (result.verdict is Verdict.PASS)
