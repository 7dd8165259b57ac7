"""Times and sizes as people write them: ``5m``, ``8GiB``, ``2,519,424``."""

from __future__ import annotations

import re

_SECONDS = {"ms": 0.001, "s": 1.0, "m": 60.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
_BYTES = {
    "b": 1,
    **{f"{letter}{suffix}": 1024**power for power, letter in enumerate("kmgt", 1) for suffix in ("", "ib")},
    **{f"{letter}b": 1000**power for power, letter in enumerate("kmgt", 1)},
}
MOST = 10**18
"""Sizes and numbers from here on are a mistake of whoever writes them."""
_NUMBER = r"(\d+(?:\.\d+)?)"


def parse_duration(text: str) -> float:
    """Seconds of ``90``, ``90s``, ``5m``, ``1h``, ``1h30m``, ``1.5h``, ``500ms``; a bare number is seconds.

    Raises:
        ValueError: *text* is none of these, or not above zero.
    """
    parts = re.findall(rf"{_NUMBER}\s*(ms|min|s|m|h|d)", text.strip().lower())
    if re.fullmatch(_NUMBER, text.strip()):
        seconds = float(text)
    elif parts and re.sub(r"\s", "", text.lower()) == "".join(number + unit for number, unit in parts):
        seconds = sum(float(number) * _SECONDS[unit] for number, unit in parts)
    else:
        raise ValueError(f"`{text}` is not a time; write it like 90s, 5m or 1h30m")
    if seconds <= 0:
        raise ValueError(f"`{text}` is not a time above zero")
    return seconds


def parse_size(text: str) -> int:
    """Bytes of ``512MiB``, ``8GiB``, ``2GB``, ``8G``: ``K``, ``M``, ``G``, ``T`` alone count as KiB and so on.

    Raises:
        ValueError: *text* is no such size, or not above zero.
    """
    match = re.fullmatch(rf"{_NUMBER}\s*([a-z]*)", text.strip().lower())
    unit = _BYTES.get(match[2] or "b") if match else None
    if match is None or unit is None:
        raise ValueError(f"`{text}` is not a size; write it like 512MiB, 8GiB or 2GB")
    amount = float(match[1]) * unit
    if amount >= MOST:
        raise ValueError(f"`{text}` is more than any machine has")
    size = int(amount)
    if size <= 0:
        raise ValueError(f"`{text}` is not a size above zero")
    return size


def whole_number(text: str) -> int | None:
    """The number that decimal digits stand for; None if it is none, or has more than 18 digits, which nobody means."""
    digits = text.lstrip("0") or text[:1]
    return int(digits) if text.isascii() and text.isdecimal() and len(digits) < len(str(MOST)) else None


def show_seconds(seconds: float) -> str:
    """A wall time in the precision that matters: ``0.02 s``, ``12.3 s``, ``3 min 20 s``, ``2 h 5 min``."""
    if seconds < 9.995:
        return f"{seconds:.2f} s"
    if seconds < 99.95:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest} s"
    return f"{minutes // 60} h {minutes % 60} min"


def show_bytes(size: int) -> str:
    """A size in the largest binary unit that keeps it above one: ``512 B``, ``1.5 MiB``."""
    amount = float(size)
    for unit in ("B", "KiB", "MiB", "GiB"):
        if amount < 1023.95:
            return f"{size} B" if unit == "B" else f"{amount:.1f} {unit}"
        amount /= 1024
    return f"{amount:.1f} TiB"


def count(number: int, noun: str, plural: str | None = None) -> str:
    """``1 state``, ``2,519,424 states``."""
    return f"{number:,} {noun if number == 1 else plural or noun + 's'}"
