"""Small scripts with their right verdicts in remarks: every one is checked as a user would check it.

A script's assertion says what must come out, ``-- expect: pass`` or ``-- expect: fail``, on its line or on the one
above. A line that is wrong, or odd, says so with the code of the message: ``-- error: CSP101``, ``-- warning: CSP216``;
a script with errors need not load. Nothing else may be reported. To add a case, put a file into this folder.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import pytest

import cspcheck
from cspcheck.cspm.diagnostics import Diagnostic

SCRIPTS = sorted(Path(__file__).parent.glob("**/*.csp"))
SAID = re.compile(r"-- (error|warning): (CSP\d+)")


def said(path: Path) -> set[tuple[int, str, str]]:
    """What a script says of its own lines: number, severity and code."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return {(number, *found) for number, line in enumerate(lines, 1) for found in SAID.findall(line)}


def reported(diagnostics: Iterable[Diagnostic]) -> set[tuple[int, str, str]]:
    return {(d.span.line if d.span is not None else 0, d.severity, d.code) for d in diagnostics}


def loaded(path: Path) -> tuple[cspcheck.Script | None, tuple[Diagnostic, ...]]:
    """The script, or why it cannot be loaded."""
    try:
        return cspcheck.load(path), ()
    except cspcheck.ScriptError as error:
        return None, error.diagnostics


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_a_script_gets_the_verdicts_and_messages_that_it_says(path: Path) -> None:
    expected = said(path)
    script, mistakes = loaded(path)
    if script is None:
        assert reported(mistakes) == expected
        return
    assert reported(script.warnings) == expected
    results = list(script.check())
    assert results or expected, "the script says nothing"
    verdicts = [(result.line, result.assertion, result.verdict) for result in results]
    assert verdicts == [(result.line, result.assertion, result.expected) for result in results]
