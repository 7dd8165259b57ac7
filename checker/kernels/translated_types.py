"""What kernels work with, in LLVM's language: arrays, named tuples of them, and integers as the words of a call."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import FunctionType
from typing import Any, get_args, get_origin, get_type_hints

from llvmlite import ir

from cspcheck.checker.arrays import Int32Array, Int64Array, UInt8Array

WORD = ir.IntType(64)
BIT = ir.IntType(1)
BYTE = ir.IntType(8)
ELEMENTS: Mapping[Any, int] = {Int64Array: 64, Int32Array: 32, UInt8Array: 8}
"""Arrays by the bits of an element; those of 8 bits have no sign."""

Place = Any
"""An address or a value in LLVM's language."""


class Untranslatable(Exception):
    """A kernel uses something that this part of Python does not have."""

    def __init__(self, node: ast.AST, what: str) -> None:
        super().__init__(f"line {getattr(node, 'lineno', '?')}: {what} has no translation")


@dataclass(frozen=True)
class ArraySpan:
    """An array: where it begins, and its length."""

    begin: Place
    length: Place
    bits: int


@dataclass(frozen=True)
class KernelRecord:
    """A named tuple: its members by name."""

    members: Mapping[str, Any]


Thing = Any
"""A value of a kernel: a number or truth in LLVM's language, a :class:`ArraySpan`, a :class:`KernelRecord`."""


WIDE = "table"
"""The parameters of this name are arrays of 64 bits in wide kernels."""


def parameters(function: FunctionType, wide: bool = False) -> list[tuple[str, Any]]:
    """The parameters of a kernel and their types."""
    hints = get_type_hints(function)
    return [
        (name, Int64Array if wide and name == WIDE else hints[name]) for name in inspect.signature(function).parameters
    ]


def results(function: FunctionType) -> tuple[Any, ...]:
    """The types of what a kernel returns: none, one or several."""
    kind = get_type_hints(function).get("return")
    if kind is type(None):
        return ()
    return get_args(kind) if get_origin(kind) is tuple else (kind,)


@cache
def members(kind: Any) -> tuple[tuple[str, Any], ...]:
    """The members of a named tuple and their types; found once, for each call of a kernel asks for them."""
    hints = get_type_hints(kind)
    return tuple((name, hints[name]) for name in kind._fields)


def words_of(kind: Any) -> list[Any]:
    """The machine types in which a value of a type is handed on."""
    if kind in (int, bool):
        return [WORD]
    if kind in ELEMENTS:
        return [ir.IntType(ELEMENTS[kind]).as_pointer(), WORD]
    return [word for _, member in members(kind) for word in words_of(member)]


def thing_of(kind: Any, words: list[Any]) -> Thing:
    """The value of a type whose words are the next of *words*, which are taken away."""
    if kind in (int, bool):
        return words.pop(0)
    if kind in ELEMENTS:
        begin, length = words.pop(0), words.pop(0)
        return ArraySpan(begin, length, ELEMENTS[kind])
    return KernelRecord({name: thing_of(member, words) for name, member in members(kind)})


def words_in(thing: Thing) -> list[Any]:
    """The words of a value."""
    if isinstance(thing, ArraySpan):
        return [thing.begin, thing.length]
    if isinstance(thing, KernelRecord):
        return [word for member in thing.members.values() for word in words_in(member)]
    return [thing]


def entry_name(name: str) -> str:
    """What the machine code of a kernel that is called from outside is known by."""
    return f"cspcheck_{name}"
