"""Values between this process and that of the solver: pickled, each with its length in front.

Terms know where they stand in a source; a source is sent once and is the same object afterwards, on both sides. What
comes back may only be made of the values that questions and answers are made of.
"""

from __future__ import annotations

import io
import pickle
import struct
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import is_dataclass
from enum import Enum
from typing import Any, BinaryIO

from cspcheck.cspm.recursion import enlarge_stack
from cspcheck.cspm.source import Source

_LENGTH = struct.Struct(">Q")
_DEPTH = 20_000
"""Nested calls that pickling may use: terms nest, and the interpreter's own limit is low."""
_ROOMS = ("cspcheck.cspm.", "cspcheck.checker.proof.")
_PLAIN = {
    ("fractions", "Fraction"),
    ("builtins", "frozenset"),
    ("builtins", "set"),
    ("builtins", "complex"),
    ("collections", "OrderedDict"),
    ("copyreg", "_reconstructor"),
    ("builtins", "object"),
    ("types", "MappingProxyType"),
}


class TooDeep(Exception):
    """A value is nested too deeply to be sent."""


class ForeignValue(Exception):
    """What came is no value of ours."""


class Sources:
    """The sources that both sides know, by number."""

    def __init__(self) -> None:
        self._known: list[Source] = []
        self._numbers: dict[int, int] = {}

    def number(self, source: Source) -> tuple[int, str | None, str | None]:
        """The number of a source, with its name and text where the other side does not know it yet."""
        number = self._numbers.get(id(source))
        if number is not None:
            return number, None, None
        number = self._numbers[id(source)] = len(self._known)
        self._known.append(source)
        return number, source.name, source.text

    def source(self, number: int, name: str | None, text: str | None) -> Source:
        """The source with a number."""
        if name is not None and text is not None:
            if number != len(self._known):
                raise ForeignValue("a source out of turn")
            source = Source(name, text)
            self._numbers[id(source)] = number
            self._known.append(source)
        return self._known[number]


class _Pickler(pickle.Pickler):
    def __init__(self, file: BinaryIO, sources: Sources) -> None:
        super().__init__(file, protocol=5)
        self._sources = sources

    def persistent_id(self, value: Any) -> Any:
        return self._sources.number(value) if isinstance(value, Source) else None


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: BinaryIO, sources: Sources) -> None:
        super().__init__(file)
        self._sources = sources

    def persistent_load(self, pid: Any) -> Any:
        return self._sources.source(*pid)

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) in _PLAIN or (module.startswith(_ROOMS) and "." not in name):
            found = super().find_class(module, name)
            # Values are made by their fields alone; nothing else of ours can be called from here.
            if (module, name) in _PLAIN or is_dataclass(found) or (isinstance(found, type) and issubclass(found, Enum)):
                return found
        raise ForeignValue(f"{module}.{name}")


@contextmanager
def _deep() -> Iterator[None]:
    before = sys.getrecursionlimit()
    enlarge_stack()
    sys.setrecursionlimit(max(before, _DEPTH))
    try:
        yield
    finally:
        sys.setrecursionlimit(before)


def packed(value: Any, sources: Sources) -> bytes:
    """A value as bytes.

    Raises:
        TooDeep: it is nested too deeply.
    """
    buffer = io.BytesIO()
    with _deep():
        try:
            _Pickler(buffer, sources).dump(value)
        except RecursionError:
            raise TooDeep from None
    return buffer.getvalue()


def unpacked(content: bytes, sources: Sources) -> Any:
    """The value that bytes stand for.

    Raises:
        Foreign: they stand for none of ours.
    """
    with _deep():
        try:
            return _Unpickler(io.BytesIO(content), sources).load()
        except ForeignValue:
            raise
        except Exception as error:
            raise ForeignValue(f"{type(error).__name__}: {error}") from None


def framed(content: bytes) -> bytes:
    """Bytes with their length in front."""
    return _LENGTH.pack(len(content)) + content


def read(stream: BinaryIO) -> bytes | None:
    """The next piece of a stream; None at its end."""
    head = stream.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        return None
    (length,) = _LENGTH.unpack(head)
    content = stream.read(length)
    return content if len(content) == length else None


class Incoming:
    """Pieces that come bit by bit."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def add(self, some: bytes) -> bytes | None:
        """The piece that *some* makes whole, if it does."""
        self._bytes += some
        if len(self._bytes) < _LENGTH.size:
            return None
        (length,) = _LENGTH.unpack_from(self._bytes)
        if len(self._bytes) < _LENGTH.size + length:
            return None
        content = bytes(self._bytes[_LENGTH.size : _LENGTH.size + length])
        del self._bytes[: _LENGTH.size + length]
        return content
