"""The grammar of Object-Z: its table, its terminals, and the page that describes the notation."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from cspcheck.cspm.oz.reading.builder_paragraphs import ParagraphBuilder
from cspcheck.cspm.oz.reading.operators import SPELLINGS
from cspcheck.cspm.oz.reading.reader import OZ, parse_paragraph, table
from cspcheck.cspm.parsing.table import compute, from_json, table as stored
from cspcheck.cspm.source import Source

GRAMMAR = OZ.path.read_text(encoding="utf-8")
RULES = re.sub(r"//.*", "", GRAMMAR)
PAGE = (Path(__file__).resolve().parents[3] / "docs" / "csp-oz.md").read_text(encoding="utf-8")


class TestTable:
    def test_the_stored_table_is_the_computed_one_and_is_made_in_silence(
        self, capfd: pytest.CaptureFixture[str]
    ) -> None:
        value = compute(GRAMMAR, OZ.starts, OZ.greedy)
        assert capfd.readouterr() == ("", "")
        assert from_json(json.loads(json.dumps(value))) == stored(OZ)

    @pytest.mark.parametrize("left_out", sorted(OZ.greedy))
    def test_only_a_mu_takes_what_could_belong_to_something_else(self, left_out: str) -> None:
        from lark.exceptions import GrammarError

        with pytest.raises(GrammarError, match=f"at the end of {left_out}"):
            compute(GRAMMAR, OZ.starts, OZ.greedy - {left_out})
        without = re.sub(r'\n *\| "mu" binders.*', "", GRAMMAR)
        compute(without, OZ.starts)  # in which any conflict is an error

    def test_every_action_has_its_method(self) -> None:
        for rule in table().rules:
            if rule.action is None:
                assert rule.size == 1 or len(rule.kept) >= 1, rule
            elif rule.action not in ("nothing", "first", "more"):
                assert callable(getattr(ParagraphBuilder, rule.action)), rule

    def test_every_method_is_the_action_of_a_rule(self) -> None:
        actions = {rule.action for rule in table().rules}
        helpers = {"token", "index_at"}
        methods = {
            name
            for name in dir(ParagraphBuilder)
            if not name.startswith("_") and callable(getattr(ParagraphBuilder, name))
        }
        assert methods - helpers <= actions


def read(text: str) -> list[str]:
    """What is wrong in a paragraph."""
    return [error.message for error in parse_paragraph(Source("x", text), 0, len(text))[1]]


def forms(heading: str) -> list[str]:
    """The forms in the table of a section of the page."""
    section = PAGE.partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
    rows = [line for line in section.splitlines() if line.startswith("| `")]
    first = [re.split(r"(?<!\\) \| ", line)[0] for line in rows]
    return [form.replace("\\|", "|") for cell in first for form in re.findall(r"`([^`]+)`", cell)]


class TestPage:
    """``docs/csp-oz.md`` describes the notation that the grammar reads."""

    def test_it_names_every_word_and_sign_of_the_grammar(self) -> None:
        quoted = set(re.findall(r'"([^"\s]+)"', RULES.replace('"\\\\"', '"backslash"'))) - {"backslash"}
        page = PAGE.replace("\\|", "|")
        assert {word for word in quoted if word not in page} == set()

    def test_it_names_every_operator(self) -> None:
        page = PAGE.replace("\\|", "|")
        assert [spelling.text[0] for spelling in SPELLINGS if spelling.text[0] not in page] == []

    @pytest.mark.parametrize(
        "form", [f for f in forms("Paragraphs") if " " in f and not f.startswith(("class", "schema"))]
    )
    def test_its_paragraphs_are_read(self, form: str) -> None:
        whole = {"const N, M : nat where N < M end": form, "retrieve R between A and C where": f"{form} end"}
        assert read(whole.get(form, form)) == []

    @pytest.mark.parametrize("form", [f for f in forms("Sections of a class") if re.match(r"[a-z_]+ \w", f)])
    def test_its_sections_are_read(self, form: str) -> None:
        assert read(f"class C\n  {form}\nend") == []

    @pytest.mark.parametrize("form", forms("Operations of operations"))
    def test_its_operations_are_read(self, form: str) -> None:
        assert read(f"class C\n  op N = {form}\nend") == []

    @pytest.mark.parametrize(
        "form", [f for f in forms("Expressions and predicates") if re.search(r"\w\W+\w|\w[~^(]", f)]
    )
    def test_its_operators_are_read(self, form: str) -> None:
        assert read(f"X == {form}") == []


class TestLayout:
    """What only neighbours tell."""

    @pytest.mark.parametrize(
        "text",
        [
            "X == (forall i : s @ p) q",
            "X == f(x)(y)[a/b].c~",
            "X == {x, y : T; z : U | x = y @ (x, z)}",
            "X == (mu x : T | p @ x) + (mu y : T)",
            "X == [x : T; S | x = 1; y = 2]",
        ],
    )
    def test_what_it_admits(self, text: str) -> None:
        assert read(text) == []

    @pytest.mark.parametrize(
        ("text", "found"),
        [
            ("X == 1 q", "name `q`"),
            ("X == {forall i : s @ 1 q}", "name `q`"),
            ("X == if a then b else 1 q", "name `q`"),
            ("X == {x : T; y}", "`}`"),
            ("X == f(a, g(b +))", "`)`"),
        ],
    )
    def test_what_it_refuses(self, text: str, found: str) -> None:
        assert read(text) == [f"unexpected {found}"]
