"""The environments of the markup of classes, and what is made of each."""

from __future__ import annotations

import re
from typing import Final

BOXES: Final = {
    "class": "class",
    "state": "state",
    "anonschema": "state",
    "init": "init",
    "op": "op",
    "opschema": "op",
    "schema": "schema",
    "genschema": "schema",
    "axdef": "const",
    "const": "const",
    "uniqdef": "const",
    "gendef": "const",
    "retrieve": "retrieve",
    "ozlemma": "lemma",
    "theorem": "lemma",
}
"""Environments with the word that they stand for."""

LAYOUT: Final = frozenset(
    ["zed", "type", "zpar", "sidebyside", "array", "center", "math", "displaymath", "spec", "syntax"]
)
"""Environments whose content is read as if it stood around them."""

SKIPPED: Final = frozenset(["classcom", "proof", "argue", "infrule", "comment", "verbatim"])
"""Environments whose content is not read."""

_BLANK = r"(?:\s|\\\\|\\t[ \t]*[0-9])*"
_RENAMED = rf"{_BLANK}(?:\\_|\w)+['?!]*\s*/\s*(?:\\_|\w)+['?!~]*{_BLANK}"
RENAMING: Final = re.compile(rf"{_RENAMED}(?:,{_RENAMED})*")
"""What stands between brackets that give new names, and are no comment."""

_USAGE = r"[ \t\n]*(?:(?:grule|frule|rule|axiom|disabled)[ \t]+)*"
THEOREM_USAGE: Final = re.compile(_USAGE)
"""What a prover is to use a theorem for, before its name."""

THEOREM: Final = re.compile(
    r"theorem[~\s]+(?P<name>[A-Za-z](?:[A-Za-z0-9]|\\_|[~\s])*?)\s*(?P<generics>\[[^\]]*\])?\s*\\vdash\s*\?"
)
"""A conjecture with a name, in one line."""

_NAMED_THEOREM = re.compile(rf"[ \t\n]*\{{{_USAGE}[A-Za-z]\w*(?:\\_\w+)*[ \t]*\}}")


def is_claim(text: str, position: int) -> bool:
    """Whether the content of a ``theorem`` at *position* begins with a name, as a claim about the paragraphs does."""
    return _NAMED_THEOREM.match(text, position) is not None
