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

_NAMED_THEOREM = re.compile(
    r"[ \t\n]*\{[ \t]*(?:(?:grule|frule|rule|axiom|disabled)[ \t]+)*([A-Za-z]\w*(?:\\_\w+)*)[ \t]*\}"
)


def is_claim(text: str, position: int) -> bool:
    """Whether the content of a ``theorem`` at *position* begins with a name, as a claim about the paragraphs does."""
    return _NAMED_THEOREM.match(text, position) is not None
