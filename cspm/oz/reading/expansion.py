"""The tokens inside the paragraphs of a script, for the formatter, which puts comments back between tokens.

To the parser of CSPm a paragraph is one token. Here it becomes the tokens of the Object-Z notation, and in the
equations of a class those of CSPm.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from cspcheck.cspm.oz.reading.lexer import Scan, tokens
from cspcheck.cspm.oz.syntax import Class
from cspcheck.cspm.parsing.lexer import Tokens, tokenise
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as s

_SAME: Final = {"::=": "=="}
"""Kinds that stand for one another: `DATA ::= {x : nat}` is an abbreviation."""


@dataclass(frozen=True, slots=True)
class _Piece:
    """A token with its place."""

    kind: str
    start: int
    end: int


def expanded(found: Tokens, script: s.Script) -> tuple[Tokens, frozenset[int]]:
    """The tokens of a script with those inside its paragraphs, and the places of the latter by where they start."""
    paragraphs = {d.span.start: d for d in script.declarations if isinstance(d, s.Paragraph)}
    result = Tokens(found.source, comments=found.comments)
    inside: set[int] = set()
    for kind, start, end in zip(found.kinds, found.starts, found.ends, strict=True):
        pieces: Iterator[_Piece] | Sequence[_Piece] = (_Piece(kind, start, end),)
        if kind == "PARAGRAPH":
            pieces = _inside(found.source, paragraphs[start])
        for piece in pieces:
            if kind == "PARAGRAPH":
                inside.add(piece.start)
            result.kinds.append(piece.kind)
            result.starts.append(piece.start)
            result.ends.append(piece.end)
    return result, frozenset(inside)


def _inside(source: Source, paragraph: s.Paragraph) -> Iterator[_Piece]:
    """The tokens of a paragraph; before each that begins a line outside brackets stands a ``_NEWLINE``."""
    equations = list(paragraph.equations) if isinstance(paragraph, Class) else []
    depth = 0
    behind = -1  # where the equation ends whose tokens have been given
    for token in tokens(source, paragraph.span.start, paragraph.span.end, Scan()):
        if token.kind == "$END" or token.start < behind:
            continue
        if token.section:
            depth = 0
        if token.first and depth == 0 and token.start > paragraph.span.start:
            yield _Piece("_NEWLINE", token.start, token.start)
        if equations and token.start >= equations[0].span.start:
            span = equations.pop(0).span
            behind = span.end
            found = tokenise(source, start=span.start, end=span.end, form="equations")
            for kind, start, end in zip(found.kinds[:-1], found.starts, found.ends, strict=False):
                yield _Piece(kind, start, end)
            continue
        depth += (token.kind in "([{") - (token.kind in ")]}")
        yield _Piece(_SAME.get(token.kind, token.kind), token.start, token.end)
