"""What ``explain`` prints of a mistake is true: its example makes the mistake, its repair does not."""

from __future__ import annotations

import pytest

from cspcheck.checker.network.compiler import compile_network
from cspcheck.checker.semantics.transitions import LimitReached
from cspcheck.checker.verdict import Limits
from cspcheck.cspm import script
from cspcheck.cspm.diagnostics import MISTAKES, ScriptError
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax.tree import Property

CODES = ["CSP501", "CSP502", "CSP503", "CSP504", "CSP505", "CSP506"]


def mistakes_in(text: str) -> set[str]:
    """The codes of what is wrong with the processes that a script makes assertions about."""
    loaded = script.load(Source("example.csp", text))
    codes = set()
    for assertion in loaded.assertions:
        assert isinstance(assertion.node, Property)
        try:
            compile_network(loaded.process(assertion.node.process), Limits(states=3_000))
        except ScriptError as error:
            codes |= {diagnostic.code for diagnostic in error.diagnostics}
        except LimitReached as reached:
            codes.add(reached.diagnostic.code)
    return codes


@pytest.mark.parametrize("code", CODES)
def test_the_example_makes_the_mistake(code: str) -> None:
    assert mistakes_in(MISTAKES[code].example) == {code}


@pytest.mark.parametrize("code", [code for code in CODES if "assert" in MISTAKES[code].repair])
def test_the_repair_repairs_it(code: str) -> None:
    assert mistakes_in(MISTAKES[code].repair) == set()
