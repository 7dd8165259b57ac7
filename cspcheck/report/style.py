"""How text looks on the stream that it goes to: colour, width, and the characters that it can show."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TextIO

ColorChoice = Literal["auto", "always", "never"]

_SGR = {
    "bold": "1",
    "dim": "2",
    "red": "31",
    "green": "32",
    "yellow": "33",
    "blue": "34",
    "cyan": "36",
}
WIDTH = 80
"""Columns where there is no terminal to ask."""


@dataclass(frozen=True, slots=True)
class Style:
    """Colour or not, Unicode or ASCII marks, and the number of columns."""

    color: bool = False
    unicode: bool = True
    width: int = WIDTH

    def paint(self, text: str, *attributes: str) -> str:
        """*text* with the given attributes (``bold``, ``red``, ...) where colour is on."""
        if not self.color or not attributes or not text:
            return text
        return f"\x1b[{';'.join(_SGR[a] for a in attributes)}m{text}\x1b[0m"

    @property
    def ellipsis(self) -> str:
        """What stands for something left out."""
        return "…" if self.unicode else "..."

    def fit(self, text: str, width: int) -> str:
        """*text* cut to at most *width* columns, with an ellipsis where something is missing."""
        if columns(text) <= width:
            return text
        room = max(width - len(self.ellipsis), 0)
        for i, character in enumerate(text):
            room -= columns(character)
            if room < 0:
                return text[:i] + self.ellipsis
        return text + self.ellipsis


PLAIN = Style()


def style_for(stream: TextIO, color: ColorChoice = "auto", environment: Mapping[str, str] = os.environ) -> Style:
    """The style for a stream.

    ``auto`` colours terminals, unless ``NO_COLOR`` is set; ``FORCE_COLOR`` colours everything. Where there is no
    terminal, the width is 80, so that the same run writes the same text.
    """
    terminal = is_terminal(stream)
    if color == "auto":
        if environment.get("NO_COLOR"):
            colored = False
        elif environment.get("FORCE_COLOR"):
            colored = True
        else:
            colored = terminal and environment.get("TERM") != "dumb"
    else:
        colored = color == "always"
    width = WIDTH
    if terminal:
        import shutil

        width = min(max(shutil.get_terminal_size((WIDTH, 24)).columns, 40), 120)
    return Style(colored, _can_show(stream, "✓✗…│"), width)


def is_terminal(stream: TextIO) -> bool:
    """Whether a person is looking at the stream."""
    try:
        return stream.isatty()
    except (AttributeError, ValueError):
        return False


def _can_show(stream: TextIO, characters: str) -> bool:
    try:
        characters.encode(getattr(stream, "encoding", None) or "ascii")
    except (UnicodeEncodeError, LookupError):
        return False
    return True


def columns(text: str) -> int:
    """How many columns of a terminal *text* takes (wide characters two, combining ones none)."""
    if text.isascii():
        return len(text)
    import unicodedata

    return sum(
        0
        if unicodedata.category(c) in ("Mn", "Me", "Cf")
        else 2
        if unicodedata.east_asian_width(c) in ("W", "F")
        else 1
        for c in text
    )


def pad(text: str, width: int) -> str:
    """*text* filled up with spaces to *width* columns."""
    return text + " " * (width - columns(text))


_CONTROL = {
    **dict.fromkeys((*range(0x20), *range(0x7F, 0xA0), *range(0x202A, 0x202F), *range(0x2066, 0x206A)), "�"),
    **dict.fromkeys((0x0A, 0x0D, 0x85, 0x2028, 0x2029), "␤"),
    0x09: "\t",
}
_COMMAND = re.compile(r"^((?:[^\S\n]|\x1b\[[0-9;]*[mK])*)(?=::|##\[)", re.MULTILINE)
"""What a build server takes for a command to itself: ``::error::`` and ``##[error]`` at the beginning of a line."""


def harmless(text: str) -> str:
    """*text* from a script, a file name or a recorded run as one line that does nothing to who reads it.

    Control characters and the bidirectional overrides, which would steer a terminal or reorder what is read, become
    U+FFFD, and line breaks a sign; tabs stay.
    """
    return text.translate(_CONTROL)


def harmless_lines(text: str) -> list[str]:
    """The lines of a text that we have written in several, each made :func:`harmless`."""
    return [harmless(line) for line in text.split("\n")]


def unobeyed(text: str) -> str:
    """Whole lines of output, without any that a build server would obey: those get a backslash in front."""
    if "::" not in text and "##[" not in text:
        return text
    return _COMMAND.sub(r"\1\\", text)


def wrapped(text: str, width: int, first: str = "", rest: str = "") -> list[str]:
    """*text* in lines of about *width* columns, the first one behind *first*, the others behind *rest*."""
    import textwrap

    return textwrap.wrap(
        harmless(text),
        max(width, 30),
        initial_indent=first,
        subsequent_indent=rest,
        break_long_words=False,
        break_on_hyphens=False,
    )
