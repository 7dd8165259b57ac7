"""Scripts with classes, made from a text, and what is asked of them."""

from __future__ import annotations

from typing import Any

from cspcheck.checker.check import Checker
from cspcheck.cspm.notation import ClassReading
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
