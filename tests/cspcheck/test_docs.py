"""The documentation says what is so."""

from __future__ import annotations

import re
from pathlib import Path

import click
import pytest

import cspcheck
from cspcheck.cli import VERBS, front_door
from cspcheck.cli.probe_commands import COMMANDS
from cspcheck.configuration import KEYS
from cspcheck.report import FORMATS
from cspcheck.report.codes import code_pages
from cspcheck.result import Exit

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"


def test_the_pages_of_codes_are_those_of_the_register() -> None:
    pages = code_pages()

    assert {f"codes/{path.name}" for path in (DOCS / "codes").iterdir()} == pages.keys() - {"codes.md"}
    for path, text in pages.items():
        assert (DOCS / path).read_text(encoding="utf-8") == text, (
            f"docs/{path} is out of date: python -m cspcheck.report.codes docs"
        )


def test_the_command_line_page_names_every_verb_format_and_exit_code() -> None:
    page = (DOCS / "command-line.md").read_text(encoding="utf-8")

    for verb in VERBS:
        assert f"| `{verb}" in page
    for form in FORMATS:
        assert f"| `{form}` |" in page
    for code in Exit:
        assert f"| {int(code)} |" in page


@pytest.mark.parametrize("verb", ["check", "fmt", "sweep", "probe", "graph"])
def test_the_command_line_page_names_every_option(verb: str) -> None:
    page = (DOCS / "command-line.md").read_text(encoding="utf-8")
    with front_door.make_context("cspcheck", [verb], resilient_parsing=True) as context:
        command = front_door.get_command(context, verb)
    assert command is not None
    for option in command.params:
        if isinstance(option, click.Option):
            assert any(f"`{name}" in page for name in option.opts), option.opts


def test_the_command_line_page_names_every_setting_and_every_command_of_probe() -> None:
    page = (DOCS / "command-line.md").read_text(encoding="utf-8")

    assert all(f"`{key}`" in page for key in KEYS)
    for command in COMMANDS.values():
        for part in command.usage.split(" | "):
            assert f"`{part}`" in page


def test_the_pytest_page_names_every_option() -> None:
    page = (DOCS / "pytest.md").read_text(encoding="utf-8")
    plugin = (DOCS.parent / "cspcheck" / "pytest_plugin.py").read_text(encoding="utf-8")
    options = set(re.findall(r'"(--csp-[a-z-]+)"', plugin))

    assert len(options) == 9
    for option in options:
        assert f"`{option}" in page


def test_the_python_page_speaks_of_names_that_there_are() -> None:
    page = (DOCS / "python.md").read_text(encoding="utf-8")
    names = set(re.findall(r"\bcspcheck\.([A-Za-z]\w*)", page))

    assert names <= set(cspcheck.__all__)
    assert {"load", "loads", "ScriptError", "Incomplete", "Verdict", "Counterexample"} <= names


PAGES = sorted(page.relative_to(ROOT).as_posix() for page in [*DOCS.glob("**/*.md"), *ROOT.glob("*.md")])


def anchors(page: Path) -> set[str]:
    """What the headings of a page can be linked by."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {
        re.sub(r"[^\w -]", "", re.sub(r"\]\([^)]*\)", "", heading)).lower().replace(" ", "-") for heading in headings
    }


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: str) -> None:
    text = re.sub(r"```.*?```|`[^`\n]*`", "", (ROOT / page).read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if "://" in target:
            continue
        path, _, anchor = target.partition("#")
        found = (ROOT / page).parent / path if path else ROOT / page
        assert found.exists(), target
        assert not anchor or anchor in anchors(found), target


def test_what_the_page_of_differences_says_comes_out() -> None:
    page = (DOCS / "coming-from-fdr.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```csp\n(.*?)```", page, re.DOTALL)
    results = list(cspcheck.loads(text).check())

    assert len(results) == text.count("-- expect:") == text.count("assert ")
    assert [(r.assertion, r.verdict) for r in results] == [(r.assertion, r.expected) for r in results]


def test_the_contents_of_the_site_are_its_pages() -> None:
    contents = re.findall(r"^```\{toctree\}\n(?::.*\n)*\n((?:.+\n)+)```", (DOCS / "index.md").read_text(), re.MULTILINE)
    named = [name for block in contents for name in block.split()]
    pages = {page.stem for page in DOCS.glob("*.md")} - {"index"}
    assert sorted(named) == sorted({*pages, "decisions/README"})
