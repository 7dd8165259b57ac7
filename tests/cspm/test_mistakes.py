"""What is documented of mistakes with names and evaluation: each example makes it, and each repair mends it."""

from __future__ import annotations

import pytest

from cspcheck.cspm.diagnostics import MISTAKES, ScriptError
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from tests.cspm.evaluator.test_corpus_evaluate import operands, unfold_all

CODES = sorted(code for code in MISTAKES if code.startswith(("CSP2", "CSP4")))
NO_SCRIPTS = {"CSP428", "CSP220"}
"""Mistakes whose examples are told in words, or need the command line."""


def codes(text: str, *, typed: bool) -> set[str]:
    try:
        script = load(Source("example.csp", text), typecheck=typed)
        for assertion in script.assertions:
            for term in operands(script, assertion.node):
                unfold_all(term)
    except ScriptError as error:
        return {diagnostic.code for diagnostic in error.diagnostics}
    return {diagnostic.code for diagnostic in script.warnings}


@pytest.mark.parametrize("code", [code for code in CODES if code not in NO_SCRIPTS])
def test_the_example_makes_the_mistake_and_the_repair_does_not(code: str) -> None:
    mistake = MISTAKES[code]
    assert code in codes(mistake.example, typed=True) | codes(mistake.example, typed=False)
    if code != "CSP404":
        assert codes(mistake.repair, typed=True) == set()


@pytest.mark.parametrize("code", CODES)
def test_titles_and_explanations_are_sentences(code: str) -> None:
    mistake = MISTAKES[code]
    assert mistake.title == mistake.title.strip(". ")
    assert mistake.explanation.endswith(".")
    assert len(mistake.title) < 80
