"""What ``explain`` prints of a mistake is true: its example makes the mistake, its repair does not."""

from __future__ import annotations

import pytest

from checker import messages
from checker.composition import compile_network
from checker.transitions import LimitReached, UnsupportedOperator
from checker.verdict import Limits
from cspm import script
from cspm.diagnostics import MISTAKES, ScriptError
from cspm.source import Source

CODES = ["CSP501", "CSP502", "CSP503", "CSP504", "CSP505", "CSP506"]


def mistakes_in(text: str) -> set[str]:
    """The codes of what is wrong with the processes that a script makes assertions about."""
    loaded = script.load(Source("example.csp", text))
    codes = set()
    for assertion in loaded.assertions:
        node = assertion.node
        node = getattr(node, "assertion", node)
        try:
            compile_network(loaded.process(node.process), Limits(states=3_000))
        except ScriptError as error:
            codes |= {diagnostic.code for diagnostic in error.diagnostics}
        except (LimitReached, UnsupportedOperator) as reached:
            codes.add(reached.diagnostic.code)
    return codes


@pytest.mark.parametrize("code", CODES)
def test_the_example_makes_the_mistake(code: str) -> None:
    assert mistakes_in(MISTAKES[code].example) == {code}


@pytest.mark.parametrize("code", [code for code in CODES if "assert" in MISTAKES[code].repair])
def test_the_repair_repairs_it(code: str) -> None:
    assert mistakes_in(MISTAKES[code].repair) == set()


def test_these_are_all_the_mistakes_of_the_module() -> None:
    builders = [name for name, value in vars(messages).items() if callable(value) and value.__module__ == messages.__name__]
    assert len([name for name in builders if not name.startswith("_")]) == len(CODES)
