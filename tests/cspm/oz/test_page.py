"""What docs/csp-oz.md shows is so."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cspcheck.cspm.oz.reading.lexer import INFIX, POSTFIX, PREFIX
from cspcheck.cspm.oz.writing.latex_writer import write_latex
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.printing.formatter import format_source
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "csp-oz.md").read_text(encoding="utf-8")
SCRIPTS = re.findall(r"```csp\n(.*?)```", PAGE, re.DOTALL)
DOCUMENTS = re.findall(r"```latex\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("text", SCRIPTS, ids=["producer", "stack", "queue", "bank", "aquarium"])
def test_its_scripts_load_and_have_the_standard_layout(text):
    assert load(Source("page.csp", text)).warnings == ()
    assert format_source(Source("page.csp", text)) == text


@pytest.mark.parametrize("text", SCRIPTS, ids=["producer", "stack", "queue", "bank", "aquarium"])
def test_its_scripts_are_the_same_in_latex(text):
    script = parse(Source("page.csp", text))
    document = Source("page.tex", write_latex(script))
    assert parse(document).declarations == script.declarations


def test_its_document_is_read():
    (text,) = DOCUMENTS
    script = parse(Source("page.tex", text))
    assert [type(d).__name__ for d in script.declarations] == ["Class", "AssertDeclaration"]
    assert script.remarks == ()


def test_it_names_every_operator():
    table = PAGE.replace("\\|", "|")
    for spelling in [*INFIX.values(), *PREFIX.values(), *POSTFIX.values()]:
        assert spelling.text[0] in table
        for symbol in spelling.symbol[:1]:
            assert symbol in table or symbol in "−∗∼⁀", symbol
