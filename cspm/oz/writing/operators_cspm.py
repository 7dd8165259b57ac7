"""How CSPm writes the operators of core terms that it has a sign, a function or a short definition for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

ATOM: Final = 100
COMPARED: Final = 40
NOT: Final = 35
AND: Final = 30
OR: Final = 20
INFIX: Final[Mapping[str, tuple[str, int]]] = {
    "and": ("and", AND),
    "or": ("or", OR),
    "plus": ("+", 60),
    "minus": ("-", 60),
    "times": ("*", 70),
    "div": ("/", 70),
    "mod": ("%", 70),
    "less": ("<", COMPARED),
    "at_most": ("<=", COMPARED),
    "equal": ("==", COMPARED),
    "iff": ("==", COMPARED),
    "subset": ("<=", COMPARED),
    "proper_subset": ("<", COMPARED),
    "prefix": ("<=", COMPARED),
    "concat": ("^", 80),
}
"""The operators that CSPm writes between operands. Both round quotients down."""
CALLED: Final[Mapping[str, str]] = {
    "union": "union",
    "inter": "inter",
    "diff": "diff",
    "Union": "Union",
    "Inter": "Inter",
    "card": "card",
    "head": "head",
    "tail": "tail",
    "flatten": "concat",
}
HELPERS: Final[Mapping[str, str]] = {
    "last": "{name}({s}^<{x}>) = {x}",
    "front": "{name}({s}^<{x}>) = {s}",
    "rev": "{name}(<>) = <>\n{name}(<{x}>^{s}) = {name}({s})^<{x}>",
    "abs": "{name}({x}) = if {x} < 0 then 0 - {x} else {x}",
    "min": "{name}({a}) = let {f}(<{x}>) = {x}\n  {f}(<{x}, {y}>^{s}) = {f}(<if {x} < {y} then {x} else {y}>^{s})\n"
    "within {f}(seq({a}))",
    "max": "{name}({a}) = let {f}(<{x}>) = {x}\n  {f}(<{x}, {y}>^{s}) = {f}(<if {x} < {y} then {y} else {x}>^{s})\n"
    "within {f}(seq({a}))",
    "functions": "{name}(<>, {a}) = {{emptyMap}}\n"
    "{name}(<{x}>^{s}, {a}) = {{mapUpdate({f}, {x}, {y}) | {f} <- {name}({s}, {a}), {y} <- {a}}}",
    "closure": "{name}({a}) = let {f}({s}) = let {n} = union({s}, {{({x}, {y}) | ({x}, {k}) <- {s}, ({v}, {y}) <- {a}, "
    "{k} == {v}}})\n  within if {n} == {s} then {s} else {f}({n})\nwithin {f}({a})",
    "with_identity": "{name}({a}) = union({a}, {{({x}, {x}) | ({k}, {v}) <- {a}, {x} <- {{{k}, {v}}}}})",
    "bag_union": "{name}({f}, <>) = {f}\n{name}({f}, <({x}, {n})>^{s}) = "
    "{name}(mapUpdate({f}, {x}, {n} + (if mapMember({f}, {x}) then mapLookup({f}, {x}) else 0)), {s})",
    "nth": "{name}({s}, {n}) = if {n} == 1 then head({s}) else {name}(tail({s}), {n} - 1)",
}
"""Functions of one argument (``nth``, ``functions`` and ``bag_union``: two) that CSPm has no name for."""
