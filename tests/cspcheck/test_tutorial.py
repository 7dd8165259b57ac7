"""The pages that teach: every script in them does what the page says."""

import re
from pathlib import Path

import pytest

from cspcheck import loads

DOCS = Path(__file__).resolve().parents[2] / "docs"
BLOCKS = re.findall(r"```csp\n(.*?)```", (DOCS / "tutorial.md").read_text(encoding="utf-8"), re.DOTALL)
WRONG = "Watchdog = kickC -> kickP -> Watchdog"


@pytest.mark.parametrize("number", range(len(BLOCKS)))
def test_a_script_of_the_tutorial(number: int) -> None:
    text = BLOCKS[number]
    results = loads(text).check()
    if WRONG in text:
        (result,) = results
        assert result.verdict == "fail"
        page = (DOCS / "tutorial.md").read_text(encoding="utf-8")
        explained = result.explain().split("\n", 1)[1].split("    component")[0]
        shown = "\n".join(line for line in explained.rstrip().splitlines() if "-->" not in line)
        assert shown in page
        assert shown in (DOCS / "counterexamples.md").read_text(encoding="utf-8")
        return
    assert all(result.as_expected for result in results), [r.explain() for r in results if not r.as_expected]


@pytest.mark.parametrize(
    "page", ["tutorial.md", "counterexamples.md", "explorer.md", "editors.md", "continuous-integration.md"]
)
def test_links_lead_somewhere(page: str) -> None:
    for target in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", (DOCS / page).read_text(encoding="utf-8")):
        assert (DOCS / target).exists(), target
