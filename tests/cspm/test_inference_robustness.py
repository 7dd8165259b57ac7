"""No script breaks inference: scrambled ones are accepted or get messages, and nothing else happens."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest

from cspm import names, parser
from cspm.diagnostics import MISTAKES, ScriptError, Severity
from cspm.inference import infer
from cspm.source import Source
from cspm.types import show_scheme

SCRIPTS = sorted((Path(__file__).parent.parent / "corpus" / "types").glob("*/*.csp"))
WORD = re.compile(r"[A-Za-z][A-Za-z0-9_]*'*|\d+|<[^<>\n]{0,9}>|\{[^{}\n]{0,9}\}|[-+*/%^#?!$.]|==|<=|\[\]|->")
FIXED = frozenset("if then else let within channel datatype subtype nametype assert module exports endmodule".split())


def scrambled(text: str, chance: random.Random) -> str:
    """The text with a few of its words replaced by others of it."""
    found = [match for match in WORD.finditer(text) if match.group() not in FIXED]
    for _ in range(chance.randint(1, 3)):
        place, other = chance.choice(found), chance.choice(found).group()
        text = text[: place.start()] + other + text[place.end() :]
        found = [match for match in WORD.finditer(text) if match.group() not in FIXED]
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
        try:
            types = infer(script, tied)
        except ScriptError as error:
            assert error.diagnostics
            for diagnostic in error.diagnostics:
                assert diagnostic.code in MISTAKES
                assert diagnostic.code.startswith("CSP3")
                assert diagnostic.severity is Severity.ERROR
                assert diagnostic.span is not None
                assert diagnostic.message
        else:
            for symbol in types.declared:
                assert show_scheme(types.scheme(symbol))
