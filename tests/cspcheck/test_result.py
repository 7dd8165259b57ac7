"""What verdicts mean for the exit code."""

from __future__ import annotations

from dataclasses import replace

import pytest

from cspcheck.checker.verdict import Verdict
from cspcheck.result import Exit, Result, exit_of, worst


@pytest.mark.parametrize(
    ("verdict", "expected", "code"),
    [
        ("pass", "pass", 0),
        ("fail", "pass", 1),
        ("unknown", "pass", 3),
        ("error", "pass", 2),
        ("pass", "fail", 1),
        ("fail", "fail", 0),
        ("unknown", "fail", 3),
        ("error", "fail", 2),
        ("pass", "unknown", 1),
        ("fail", "unknown", 1),
        ("unknown", "unknown", 0),
        ("error", "unknown", 2),
    ],
)
def test_the_exit_code_of_a_result(results: dict[str, Result], verdict: str, expected: str, code: int) -> None:
    sample = results["pass"]
    result = replace(sample, outcome=replace(sample.outcome, verdict=Verdict(verdict)), expected=Verdict(expected))

    assert exit_of(result) == code


def test_the_worst_wins() -> None:
    order = [Exit.INTERNAL, Exit.NOT_RUN, Exit.FAILED, Exit.UNKNOWN, Exit.NOTHING, Exit.OK]

    for i, code in enumerate(order):
        assert worst(reversed(order[i:])) is code
    assert [int(code) for code in order] == [4, 2, 1, 3, 5, 0]
    assert worst([]) is Exit.OK
