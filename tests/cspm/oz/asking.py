"""Scripts with classes, made from a text, and what is asked of them."""

from __future__ import annotations

from typing import Any

import pytest

from cspcheck.checker.check import Checker
from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.notation import ClassReading
from cspcheck.cspm.oz.typing.elaboration import elaborate
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.script import Script, load
from cspcheck.cspm.source import Source


def script(text: str, **semantics: Any) -> Script:
    """The loaded script, with classes read as *semantics* says."""
    return load(Source("classes.csp", text), semantics=ClassReading(**semantics))


def outcome(text: str, assertion: str, **semantics: Any) -> tuple[str, str | None]:
    """Verdict and reason of an assertion about a script."""
    loaded = script(text, **semantics)
    found = Checker(loaded).check(loaded.assertion(assertion).node)
    return found.verdict.value, found.reason


def refusal(text: str) -> Diagnostic:
    """The first thing that is wrong with the classes of a script, which must be refused."""
    with pytest.raises(ScriptError) as error:
        elaborate(parse(Source("classes.csp", text)))
    return error.value.diagnostics[0]
