"""Places as editors count them: lines and columns from 0, columns in units of UTF-16."""

from __future__ import annotations

import os
from urllib.parse import quote, unquote, urlsplit

from lsprotocol import types

from cspcheck.cspm.source import Source, Span


def _units(text: str) -> int:
    """How many units of UTF-16 a text has."""
    return len(text) + sum(character > "\uffff" for character in text)


def position(source: Source, offset: int) -> types.Position:
    """The place of an offset."""
    line, column = source.position(offset)
    return types.Position(line - 1, _units(source.line_text(line)[: column - 1]))


def offset(source: Source, place: types.Position) -> int:
    """The offset of a place; the end of the line for a column behind it."""
    line = source.line_text(place.line + 1)
    start = len("\n".join(source.text.split("\n")[: place.line])) + (place.line > 0)
    units = 0
    for i, character in enumerate(line):
        if units >= place.character:
            return start + i
        units += 1 + (character > "\uffff")
    return min(start + len(line), len(source.text))


def range_of(span: Span) -> types.Range:
    """A span."""
    return types.Range(position(span.source, span.start), position(span.source, span.end))


def location(span: Span) -> types.Location:
    """A span with its file."""
    return types.Location(uri_of(span.source.name), range_of(span))


def path_of(uri: str) -> str:
    """The path of a file; other addresses stay as they are."""
    parts = urlsplit(uri)
    if parts.scheme != "file":
        return uri
    path = unquote(parts.path)
    if os.name == "nt" and path[:1] == "/":  # /C:/models/x.csp
        path = path[1:]
    return os.path.normpath(path)


def uri_of(path: str) -> str:
    """The address of a file."""
    if "://" in path or path.startswith("untitled:"):
        return path
    absolute = os.path.abspath(path).replace(os.sep, "/")
    return "file://" + ("" if absolute.startswith("/") else "/") + quote(absolute)
