"""Values as the language writes them."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from cspcheck.cspm.process.terms import DIV, SKIP, STOP, Compressed, Process, Reference
from cspcheck.cspm.values.dots import DotList, Dotted, Event
from cspcheck.cspm.values.order import in_order
from cspcheck.cspm.values.sets import EventsSet, FiniteSet, Set
from cspcheck.cspm.values.thunks import Thunk
from cspcheck.cspm.values.values import Boolean, Function, Map, Sequence, deep

ESCAPES = {"\n": "\\n", "\r": "\\r", "\t": "\\t"}
SHORT = 60
"""The usual width of a value inside a sentence."""
_AT_ONCE = 13_000
"""Bits of an integer that Python writes in decimal without further ado."""


def show(value: Any) -> str:
    """The whole value, evaluated as far as it must be to be shown.

    Raises:
        Failure: a part of it cannot be evaluated.
    """
    out: list[str] = []
    _write(deep(value), out, None)
    return "".join(out)


def digits(number: int) -> str:
    """An integer in decimal; Python itself refuses those of more than 4,300 digits."""
    if number < 0:
        return f"-{digits(-number)}"
    if number.bit_length() < _AT_ONCE:
        return str(number)
    half = number.bit_length() * 3 // 20
    high, low = divmod(number, 10**half)
    return digits(high) + digits(low).zfill(half)


def show_short(value: Any, width: int = SHORT) -> str:
    """The value as far as it is known, in about *width* characters; what does not fit or is not known is ``...``."""
    out: list[str] = []
    _write(value, out, width)
    text = "".join(out)
    return text if len(text) <= width + 12 else text[:width] + "..."


def _full(out: list[str], width: int | None) -> bool:
    return width is not None and sum(map(len, out[-64:])) + 2 * max(0, len(out) - 64) > width


def _items(items: Any, out: list[str], width: int | None, separator: str = ", ") -> None:
    for i, item in enumerate(items):
        if i:
            out.append(separator)
        if _full(out, width):
            out.append("...")
            return
        _write(item, out, width)


_NAMED: dict[Process, str] = {STOP: "STOP", SKIP: "SKIP", DIV: "DIV"}
"""The processes that have one name, whatever the events of the script are called."""


def _write(value: Any, out: list[str], width: int | None) -> None:
    kind = type(value)
    if kind is Thunk:
        if value.code is not None:
            out.append("...")
            return
        value = value.value
        kind = type(value)
    if kind is int:
        out.append(digits(value) if width is None or value.bit_length() < _AT_ONCE else "...")
    elif kind is Boolean:
        out.append("true" if value.truth else "false")
    elif kind is str:
        out.append(f"'{_escaped(value, chr(39))}'")
    elif kind is tuple:
        out.append("(")
        _items(value, out, width)
        out.append(")")
    elif kind is Sequence:
        _write_sequence(value, out, width)
    elif kind is Map:
        out.append("(| ")
        for i, key in enumerate(in_order(value.entries)):
            kept = value.entries[key]
            out.append(", " if i else "")
            if _full(out, width):
                out.append("...")
                break
            _write(key, out, width)
            out.append(" => ")
            _write(kept, out, width)
        out.append(" |)" if value.entries else "|)")
    elif kind is Event:
        head, fields = value.parts
        _write_dotted(head.name, fields, out, width)
    elif kind is Dotted:
        _write_dotted(value.head.name, value.fields, out, width)
    elif kind is DotList:
        _write_dotted(None, value.parts, out, width)
    elif isinstance(value, FiniteSet):
        start = len(out)
        out.append("{")
        _items(value.elements() if width is None or value.size() < 10_000 else list(value.items)[:width], out, width)
        if out[start + 1 :] and out[start + 1].startswith("-"):
            out[start] = "{ "  # `{-` would open a comment
        out.append("}")
    elif isinstance(value, EventsSet):
        out.append("{")
        _items(value.listed(), out, width)
        out.append("}")
    elif isinstance(value, Set):
        out.append(value.describe())
    elif isinstance(value, Reference):
        out.append(value.text)
    elif isinstance(value, Compressed):
        out.append(f"{value.function}(")
        _write(value.process, out, width)
        out.append(")")
    elif isinstance(value, Process):
        out.append(_NAMED.get(value) or f"<process {type(value).__name__}>")
    elif kind is Function:
        out.append(f"<function {value.routine.name}>")
    else:
        out.append(str(value))


def _write_dotted(name: str | None, fields: tuple[Any, ...], out: list[str], width: int | None) -> None:
    parts: list[Any] = list(fields)
    if name is not None:
        out.append(name)
    for i, part in enumerate(parts):
        if name is not None or i:
            out.append(".")
        if _full(out, width):
            out.append("...")
            return
        _write(part, out, width)


def _write_sequence(value: Sequence, out: list[str], width: int | None) -> None:
    known, open_end = value.known()
    characters = [item.value if type(item) is Thunk and item.code is None else item for item in known]
    if characters and not open_end and all(type(c) is str for c in characters):
        text = "".join(_escaped(c, '"') for c in characters)
        out.append(f'"{text if width is None else text[: width + 1]}"')
        return
    out.append("<")
    _items(known, out, width)
    if open_end:
        out.append(", ..." if known else "...")
    out.append(">")


def _escaped(character: str, quote: str) -> str:
    if character in (quote, "\\"):
        return "\\" + character
    return ESCAPES.get(character, character)


def show_real(value: Fraction) -> str:
    """A real as people write it: ``0.5`` where it has few decimals, else ``1/3``; whole ones as ``2``."""
    if value.denominator == 1:
        return str(value.numerator)
    rest = value.denominator
    twos = fives = 0
    while rest % 2 == 0:
        rest //= 2
        twos += 1
    while rest % 5 == 0:
        rest //= 5
        fives += 1
    places = max(twos, fives)
    if rest != 1 or places > 12:
        return f"{value.numerator}/{value.denominator}"
    digits = str(abs(value.numerator) * 10**places // value.denominator).rjust(places + 1, "0")
    return f"{'-' if value < 0 else ''}{digits[:-places]}.{digits[-places:]}"
