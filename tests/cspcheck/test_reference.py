"""The page of operators and functions: each law and each example holds, and nothing is left out."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import cspcheck
from cspcheck.cspm.prelude import BUILTINS, EXTERNAL, TIMED_BUILTINS, TRANSPARENT
from cspcheck.cspm.process import terms

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "reference.md").read_text(encoding="utf-8")
(PREAMBLE,) = re.findall(r"```csp\n(.*?)```", PAGE, re.DOTALL)
LAWS = re.findall(r"### ([^\n]*)\n(?:(?!```)[^\n]*\n)*```law\n(.*?)```", PAGE, re.DOTALL)
EXAMPLES = [
    row[-1].strip("` ").replace(r"\|", "|")
    for row in (re.split(r"(?<!\\)\|", line.strip("|")) for line in PAGE.splitlines() if line.startswith("| `"))
    if len(row) == 3
]
RELATIONS = "external transpose, mtransclose, relational_image, relational_inverse_image\n"


def assertions(law: str) -> list[str]:
    """A law as what is to be checked."""
    if "  [FD=  " in law:
        return [" [FD= ".join(f"({side})" for side in law.split("  [FD=  "))]
    left, right = law.split("  =  ")
    return [f"({left}) [FD= ({right})", f"({right}) [FD= ({left})"]


@pytest.mark.parametrize(("section", "laws"), LAWS, ids=[section for section, _ in LAWS])
def test_the_laws_of(section: str, laws: str) -> None:
    found = [claim for law in laws.splitlines() for claim in assertions(law)]
    results = cspcheck.loads(PREAMBLE + "".join(f"assert {claim}\n" for claim in found)).check()

    assert [result.assertion for result in results if not result] == []


def test_a_law_that_does_not_hold_is_noticed() -> None:
    (first, second) = assertions("P [] Q  =  P |~| Q")
    script = cspcheck.loads(PREAMBLE)
    assert [bool(script.check(claim)) for claim in (first, second)] == [False, True]


def test_the_examples() -> None:
    script = cspcheck.loads(RELATIONS + PREAMBLE)

    assert len(EXAMPLES) > 40
    assert [example for example in EXAMPLES if script.evaluate(example) is not True] == []


def test_every_operator_and_function_is_there() -> None:
    symbols = {term.symbol for term in vars(terms).values() if isinstance(term, type) and getattr(term, "symbol", "")}
    words = set(re.findall(r"\w+", PAGE))

    assert (BUILTINS | EXTERNAL | TRANSPARENT | TIMED_BUILTINS) - words == set()
    # A symbol with a place for a set or a pair is written with one here.
    written = {symbol: re.escape(symbol).replace(r"\ ", ".*") for symbol in symbols - {"compression", "prioritise"}}
    assert [symbol for symbol, form in written.items() if not re.search(form, PAGE)] == []
