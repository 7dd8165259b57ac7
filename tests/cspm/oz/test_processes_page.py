"""What docs/csp-oz-processes.md shows is what comes out."""

from __future__ import annotations

import re
from pathlib import Path

import cspcheck

PAGE = (Path(__file__).parents[3] / "docs" / "csp-oz-processes.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```\n(.*?)```", PAGE, re.DOTALL)


def test_the_script_of_the_page_passes() -> None:
    for result in cspcheck.loads(BLOCKS[0]).check():
        assert result, result.explain()


def test_leaving_a_reading_looks_as_the_page_says() -> None:
    (result, *_) = cspcheck.loads(BLOCKS[0].replace("n < 3 and ", "")).check()

    shown = re.sub(r"\s+\d+ states.*?s\n", "\n", result.explain())
    told = re.sub(r"\s+\d+ states.*?s\n", "\n", BLOCKS[1])
    assert [line.strip() for line in shown.splitlines() if "-->" not in line] == [
        line.strip() for line in told.splitlines()
    ]
    assert result.readings == ("nat = 0..3",)
