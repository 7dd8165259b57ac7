"""A ``print`` line with a mistake in it shows nothing, and stops nothing else."""

from __future__ import annotations

import pytest

from cspcheck.checker.check import Checker
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.printing.formatter import format_source
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source


def test_a_wrong_line_is_a_warning_at_its_place() -> None:
    script = load(
        Source("p.csp", "channel a\nprint 1 + + 2\nP = a -> P\nprint 1 + 1\nprint <1,\nassert P :[deadlock free]\n")
    )

    assert [(w.code, w.span.text, w.span.start) for w in script.warnings if w.span] == [
        ("CSP017", "+", 20),
        ("CSP017", "<", 53),
    ]
    assert Checker(script).check(script.assertions[0].node).verdict.value == "pass"


@pytest.mark.parametrize("text", ["print 1 +\nP = = STOP\n", "P = STOP +\nprint 2 +\n"])
def test_other_mistakes_stay_errors(text: str) -> None:
    with pytest.raises(ScriptError) as error:
        load(Source("p.csp", text))

    assert "CSP017" not in [d.code for d in error.value.diagnostics]


def test_a_script_with_a_wrong_line_is_not_tidied() -> None:
    with pytest.raises(ScriptError) as error:
        format_source(Source("p.csp", "P=STOP\nprint (1\n"))

    assert [d.code for d in error.value.diagnostics] == ["CSP017"]


def test_what_goes_on_in_the_next_line_is_read_as_before() -> None:
    script = load(Source("p.csp", "print card({1,\n  2})\nP = STOP\n"))

    assert not script.warnings
