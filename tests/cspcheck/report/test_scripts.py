"""What ``typecheck`` says: the diagnostics are the result."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from syrupy.assertion import SnapshotAssertion

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.report import FORMATS, scripts_report
from cspcheck.report.style import Style
from cspcheck.result import Summary

Written = Callable[..., str]


@pytest.fixture
def written(mistakes: dict[str, Diagnostic]) -> Written:
    """A run over two good scripts and a bad one."""

    def write(form: Any, verbosity: int = 0, *, interrupted: bool = False) -> str:
        pieces: list[str] = []
        to = scripts_report(form, pieces.append, Style(), verbosity)
        to.script("a.csp")
        to.diagnostics([mistakes["plain"], mistakes["no place"]])
        to.script("b.csp")
        summary = Summary.empty()
        summary.add_broken_script()
        to.end(summary, interrupted=interrupted)
        return "".join(pieces)

    return write


def test_full(written: Written, snapshot: SnapshotAssertion) -> None:
    assert written("full") == snapshot


def test_full_when_interrupted(written: Written) -> None:
    assert written("full", interrupted=True).endswith(
        "\ninterrupted; until then: 2 scripts without errors, 1 script with errors\n"
    )


def test_quiet(written: Written) -> None:
    assert written("full", -1).startswith("error[CSP201]")
    assert "✓" not in written("full", -1)


def test_concise(written: Written) -> None:
    assert written("concise") == (
        "table.csp:4:12: error[CSP201]: `Foo` is not defined\nerror[CSP001]: no such file: `x.csp`\n"
    )


@pytest.mark.parametrize("form", FORMATS)
def test_every_format_tells_the_errors(written: Written, form: str) -> None:
    assert "`Foo` is not defined" in written(form)
