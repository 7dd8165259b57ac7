"""The functions that a person's C or Ada file defines, as far as a generator must know them: what they take and give.

Heads are looked for in the text without its comments; names of parameters are the person's own.
"""

from __future__ import annotations

import re
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class FunctionHead:
    """The head of a function.

    Attributes:
        shown: as it is written, on one line.
        shape: what a caller relies on: types and modes, without the names of parameters.
    """

    shown: str
    shape: tuple[str, ...]


_C_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
_C_HEAD = re.compile(r"(?m)^(?P<gives>\w[\w \t*]*?)\s*\b(?P<name>\w+)\s*\((?P<takes>[^();{}]*)\)\s*\{")
_ADA_COMMENT = re.compile(r"--[^\n]*")
_ADA_HEAD = re.compile(
    r"\b(?P<kind>procedure|function)\s+(?P<name>\w+)\s*(?:\((?P<takes>[^()]*)\))?\s*(?:return\s+(?P<gives>[\w.]+))?\s*is\b",
    re.IGNORECASE,
)


def heads_in(name: str, text: str) -> dict[str, FunctionHead]:
    """The functions that the text of the file *name* (``.c`` or ``.adb``) defines, by name; none of another file."""
    if name.endswith(".c"):
        found = _C_HEAD.finditer(_C_COMMENT.sub(" ", text))
        return {
            one["name"]: FunctionHead(_line(one[0].rstrip("{")), _c_shape(one["gives"], one["takes"])) for one in found
        }
    if name.endswith(".adb"):
        found = _ADA_HEAD.finditer(_ADA_COMMENT.sub(" ", text))
        return {
            one["name"].lower(): FunctionHead(_line(one[0][:-2]), _ada_shape(one["takes"] or "", one["gives"] or ""))
            for one in found
        }
    return {}


def _line(text: str) -> str:
    return " ".join(text.split())


def _c_shape(gives: str, takes: str) -> tuple[str, ...]:
    parameters = [] if takes.strip() in ("", "void") else takes.split(",")
    return (_line(gives), *(_line(re.sub(r"\b\w+\s*$", "", parameter)) for parameter in parameters))


def _ada_shape(takes: str, gives: str) -> tuple[str, ...]:
    shape = [gives.lower()]
    for group in filter(str.strip, takes.split(";")):
        names, _, what = group.partition(":")
        mode = re.sub(r"^in (?!out )", "", _line(what).lower())  # `in` is what nothing means
        shape += [mode] * len(names.split(","))
    return tuple(shape)
