"""Where a node is printed, and what it looks like in brackets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from cspcheck.cspm.parsing.precedence import SIGN_LEVELS
from cspcheck.cspm.printing.layout import LINE, SOFT, Doc, cat, first_text, group, join, nest
from cspcheck.cspm.syntax import tree as s

OPERAND: Final = 1
DOT: Final = 12
STEP: Final = 15
BOTH: Final = 24


@dataclass(frozen=True, slots=True)
class NodePlace:
    """Where a node is printed.

    ``level`` is the loosest operator that needs no brackets there. ``follow`` is the level of the operator behind
    it in its row, None if its row ends. ``begins_row`` holds for the first operand of a row of process operators.
    ``in_sequence`` holds where a bare ``>`` would close a sequence. ``tight`` leaves out blanks around arithmetic.
    """

    level: int = BOTH
    follow: int | None = None
    begins_row: bool = True
    in_sequence: bool = False
    tight: bool = False


ANYWHERE: Final = NodePlace()


_CHARACTERS: Final = {"\n": "\\n", "\r": "\\r", "\t": "\\t", "\\": "\\\\"}


def literal(kind: str, value: int | bool | str) -> str:
    """The text of a literal."""
    if kind == "bool":
        return "true" if value else "false"
    if kind == "int":
        return str(value)
    quote = "'" if kind == "char" else '"'
    escapes = _CHARACTERS | {quote: "\\" + quote}
    return quote + "".join(escapes.get(character, character) for character in str(value)) + quote


def bracketed(doc: Doc) -> Doc:
    """The document in round brackets."""
    return group("(", nest(cat(SOFT, doc)), SOFT, ")")


def after_colon(doc: Doc) -> Doc:
    """The document, in brackets where ``:`` would make it the property of an assertion."""
    return bracketed(doc) if first_text(doc).startswith("[ ") else doc


def commas(docs: Sequence[Doc]) -> Doc:
    """The documents with commas, broken all or none."""
    return join(cat(",", LINE), docs)


def enclosed(opening: str, docs: Sequence[Doc], closing: str, nodes: Sequence[s.Node]) -> Doc:
    """Items in brackets: on one line; else simple items filling the lines, others each on its own."""
    if not docs:
        return f"{opening} {closing}" if opening == "{|" else opening + closing
    # `{-` opens a comment, `{|` productions, and `<-` is a token to other tools.
    blank = opening == "{|" or (opening in "{<" and first_text(docs[0]).startswith(("-", "|")))
    edge = LINE if opening == "{|" else SOFT
    if len(docs) > 1 and all(isinstance(node, _SIMPLE) for node in nodes):
        inner = cat(docs[0], *(cat(",", group(LINE, doc)) for doc in docs[1:]))
    else:
        inner = commas(docs)
    return group(opening, nest(cat(LINE if blank else SOFT, inner)), edge, closing)


_SIMPLE: Final = (s.Name, s.LiteralExpr, s.Dot, s.NamePattern, s.Wildcard, s.LiteralPattern, s.DotPattern)


def part_of(
    place: NodePlace,
    brackets: bool,
    *,
    level: int | None = None,
    follow: int | str | None = "",
    begins_row: bool | None = None,
    tight: bool = False,
) -> NodePlace:
    """The place of a part of a node at *place*, inside its brackets if it gets some."""
    if brackets:
        place = ANYWHERE
    return NodePlace(
        level=place.level if level is None else level,
        follow=place.follow if isinstance(follow, str) else follow,
        begins_row=place.begins_row if begins_row is None else begins_row,
        in_sequence=place.in_sequence,
        tight=tight,
    )


def captures(sign: str, place: NodePlace) -> bool:
    """Whether a sign at this place needs brackets to end where its operand does."""
    if place.level == OPERAND:
        return True
    return place.follow is not None and place.follow < SIGN_LEVELS[sign]


def needs_end(place: NodePlace) -> bool:
    """Whether what extends as far to the right as it can needs brackets at this place."""
    return place.follow is not None or place.level == OPERAND
