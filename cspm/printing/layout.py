"""Documents that can be laid out in lines of a given width.

The algebra is Wadler's ("A prettier printer", 2003): a group is set on one line if it fits, otherwise its own line
breaks are taken, and the groups inside it decide for themselves. Each document knows its width on one line, so
that most groups are decided at once; everything runs on explicit stacks, so that documents may be very deep.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

WIDTH: Final = 100
DEEPEST_INDENT: Final = 60
"""Columns of indentation at most; deeper nesting is no longer shown, which keeps the text of deep trees small."""

ENDLESS: Final = 1 << 30
"""The width of what cannot be set on one line."""


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A possible line break; ``flat`` is what stands there on one line, None for a break that is always taken."""

    flat: str | None


@dataclass(frozen=True, slots=True, eq=False)
class Cat:
    """Documents in a row."""

    parts: Sequence[Doc]
    width: int


@dataclass(frozen=True, slots=True, eq=False)
class Nest:
    """A document whose line breaks are indented further."""

    by: int
    inner: Doc
    width: int


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """A document that is set on one line if it fits."""

    inner: Doc
    width: int


Doc: TypeAlias = "str | Line | Cat | Nest | Group"

LINE: Final = Line(" ")
SOFT: Final = Line("")
HARD: Final = Line(None)


def width(doc: Doc) -> int:
    """The width of the document on one line, ``ENDLESS`` or more if it has none."""
    if isinstance(doc, str):
        return len(doc)
    if isinstance(doc, Line):
        return ENDLESS if doc.flat is None else len(doc.flat)
    return doc.width


def cat(*parts: Doc) -> Doc:
    """The documents in a row."""
    return Cat(parts, min(sum(map(width, parts)), ENDLESS))


def join(separator: Doc, parts: Iterable[Doc]) -> Doc:
    """The documents with a separator between each two."""
    row: list[Doc] = []
    for part in parts:
        if row:
            row.append(separator)
        row.append(part)
    return cat(*row)


def nest(inner: Doc, by: int = 2) -> Doc:
    """The document with its line breaks indented by *by* columns more."""
    return Nest(by, inner, width(inner))


def group(*parts: Doc, broken: bool = False) -> Doc:
    """The documents on one line if they fit; with *broken*, their line breaks are taken anyway."""
    inner = cat(*parts)
    return Group(inner, ENDLESS if broken else width(inner))


def first_text(doc: Doc) -> str:
    """The first piece of the document's text, empty if it has none."""
    work: list[Doc] = [doc]
    while work:
        match work.pop():
            case str() as text if text:
                return text
            case Cat(parts=parts):
                work.extend(reversed(parts))
            case Nest(inner=inner) | Group(inner=inner):
                work.append(inner)
    return ""


_PRINT: Final = re.compile(r'"(?:[^"\\\n]|\\.)*"|(?<![\w\'])print (?=(\S))')


def names_kept(text: str) -> str:
    """The text with no blank behind a name `print`: before a blank it would be the word that begins a line."""

    def kept(found: re.Match[str]) -> str:
        start, after = found.start(), found[1]
        # At the start of a line it is the word, unless that line defines the name or gives it a type.
        if after is None or ((start == 0 or text[start - 1] == "\n") and not text.startswith(("=", "::"), found.end())):
            return found[0]
        return "print\n  " if after.isalnum() else "print"

    return _PRINT.sub(kept, text) if "print " in text else text


def lay_out(doc: Doc, columns: int = WIDTH) -> str:
    """The text of the document in lines of *columns* where that is possible; no line ends in blanks."""
    out: list[str] = []
    column = 0
    # Each entry: indentation, whether line breaks are taken, document.
    work: list[tuple[int, bool, Doc]] = [(0, True, doc)]
    while work:
        indent, broken, item = work.pop()
        if isinstance(item, str):
            out.append(item)
            column += len(item)
        elif isinstance(item, Cat):
            work.extend((indent, broken, part) for part in reversed(item.parts))
        elif isinstance(item, Nest):
            work.append((indent + item.by, broken, item.inner))
        elif isinstance(item, Group):
            fits = not broken or (item.width <= columns - column and _fits(work, columns - column - item.width))
            work.append((indent, not fits, item.inner))
        elif broken or item.flat is None:
            column = min(indent, DEEPEST_INDENT)
            out.append("\n" + " " * column)
        else:
            out.append(item.flat)
            column += len(item.flat)
    return "\n".join(line.rstrip() for line in names_kept("".join(out)).split("\n"))


def _fits(rest: Sequence[tuple[int, bool, Doc]], room: int) -> bool:
    """Whether what follows up to the next line break that is taken has *room* columns."""
    place = len(rest)
    work: list[tuple[bool, Doc]] = []
    while room >= 0:
        if work:
            broken, item = work.pop()
        elif place:
            place -= 1
            _, broken, item = rest[place]
        else:
            return True
        if isinstance(item, str):
            room -= len(item)
        elif isinstance(item, Cat):
            work.extend((broken, part) for part in reversed(item.parts))
        elif isinstance(item, Nest):
            work.append((broken, item.inner))
        elif isinstance(item, Group):
            # A group that follows can still be broken, so its first line break ends the line.
            work.append((broken, item.inner))
        elif broken or item.flat is None:
            return True
        else:
            room -= len(item.flat)
    return False
