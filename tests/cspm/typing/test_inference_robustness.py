"""No script breaks inference: scrambled ones are accepted or get messages, and nothing else happens."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest

from cspcheck.cspm.diagnostics import MISTAKES, Diagnostic, ScriptError, Severity
from cspcheck.cspm.naming import resolve as names
from cspcheck.cspm.parsing import reading as parser
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.typing.inference import infer

SCRIPTS = sorted((Path(__file__).parents[2] / "corpus" / "types").glob("*/*.csp"))
WORD = re.compile(r"[A-Za-z][A-Za-z0-9_]*'*|\d+|<[^<>\n]{0,9}>|\{[^{}\n]{0,9}\}|[-+*/%^#?!$.]|==|<=|\[\]|->")
KEPT = {"if", "then", "else", "let", "within", "channel", "datatype", "module", "exports", "endmodule", "assert"}
"""Words without which nothing would parse."""


def scrambled(text: str, chance: random.Random) -> str:
    """The text with a few of its words replaced by others of it."""
    for _ in range(chance.randint(1, 3)):
        found = [match for match in WORD.finditer(text) if match.group() not in KEPT]
        place, other = chance.choice(found), chance.choice(found).group()
        text = text[: place.start()] + other + text[place.end() :]
    return text


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_a_scrambled_script_gets_types_or_messages(path: Path) -> None:
    chance = random.Random(path.stem)
    original = path.read_text()
    for _ in range(6):
        text = scrambled(original, chance)
        try:
            script = parser.parse(Source("scrambled.csp", text))
            tied = names.resolve(script)
        except ScriptError:
            continue
        found = told(script, tied)
        for diagnostic in found:
            assert diagnostic.code in MISTAKES
            assert diagnostic.code.startswith("CSP3")
            assert diagnostic.severity is Severity.ERROR
            assert diagnostic.span is not None
            assert diagnostic.message


def told(script: syntax.Script, tied: names.Names) -> tuple[Diagnostic, ...]:
    """The mistakes of a script; if it has none, its types can all be written down."""
    try:
        types = infer(script, tied)
    except ScriptError as error:
        assert error.diagnostics, "an error without a mistake"  # noqa: PT017
        return error.diagnostics
    assert all(text for _, text in types.listing())
    return ()
