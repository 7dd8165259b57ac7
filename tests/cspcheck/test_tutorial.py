"""The pages that teach: every script in them does what the page says."""

import re
from pathlib import Path

import pytest

from cspcheck import Verdict, loads

DOCS = Path(__file__).resolve().parents[2] / "docs"
TEACHING = ["tutorial.md", "csp-oz-tutorial.md", "cookbook.md"]
BLOCK = re.compile(r"```csp\n(.*?)```(?:(?:\n(?!#|```)[^\n]*)*\n```\n(.*?)```)?", re.DOTALL)
"""A script of a page, and what is printed for it where the page shows that before its next heading."""


def blocks(page: str) -> list[tuple[str, int, str, str]]:
    found = BLOCK.findall((DOCS / page).read_text(encoding="utf-8"))
    return [(page, number, text, shown) for number, (text, shown) in enumerate(found)]


SCRIPTS = [block for page in TEACHING for block in blocks(page)]


@pytest.mark.parametrize(("text", "shown"), [s[2:] for s in SCRIPTS], ids=[f"{page}-{n}" for page, n, *_ in SCRIPTS])
def test_a_script_of_a_page(text: str, shown: str) -> None:
    results = loads(text).check()

    assert len(results) == text.count("\nassert ")
    if not shown:
        assert all(result.as_expected for result in results), [r.explain() for r in results if not r.as_expected]
        return
    (result,) = results
    assert result.verdict is Verdict.FAIL
    head, *rest = (line.rstrip() for line in result.explain().splitlines())
    first, *told = shown.rstrip().splitlines()
    assert head.startswith(first)
    assert "\n".join(line for line in rest if "-->" not in line).startswith("\n".join(told))


@pytest.mark.parametrize("page", TEACHING)
def test_there_are_scripts_and_what_is_printed_for_some(page: str) -> None:
    assert len(blocks(page)) >= 7
    assert page == "cookbook.md" or any(shown for *_, shown in blocks(page))


def test_the_page_of_counterexamples_reads_that_of_the_tutorial() -> None:
    (shown,) = [shown for *_, shown in blocks("tutorial.md") if shown]
    assert shown.split("\n", 1)[1].rstrip() in (DOCS / "counterexamples.md").read_text(encoding="utf-8")
