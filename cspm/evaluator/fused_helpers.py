"""What fused functions of processes call: menus, terms and events put together, and values that are looked at.

See :mod:`cspcheck.cspm.evaluator.fused_processes`, which writes these functions.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from operator import itemgetter
from typing import Any

from cspcheck.cspm.evaluator.builtins_data import append
from cspcheck.cspm.evaluator.keys import native
from cspcheck.cspm.evaluator.prefixes import MOST_BRANCHES
from cspcheck.cspm.process.construction import external_choice
from cspcheck.cspm.process.terms import STOP, Menu, Prefix, Process, Reference
from cspcheck.cspm.values.dots import ChannelHead, Dotted, Event, Head, dot
from cspcheck.cspm.values.set_algebra import difference, intersection, union
from cspcheck.cspm.values.sets import FiniteSet, Set
from cspcheck.cspm.values.thunks import Env
from cspcheck.cspm.values.values import Boolean, Map, Sequence, deep

_NUMBER = itemgetter(0)


class Retreat(Exception):
    """A value is none that a fused function can go on with."""


class NoMenu(Exception):
    """This process does more than to offer events, or nobody knows before its term is made."""


def _one(number: int, then: Process) -> Process:
    return Prefix(((number, then),))


def _several_group(branches: list[tuple[int, Process]]) -> Menu:
    if not branches:
        return ()
    if len(branches) > 1:
        if len(branches) > MOST_BRANCHES:
            raise Retreat
        branches.sort(key=_NUMBER)
    return (tuple(branches),)


def _several(branches: list[tuple[int, Process]]) -> Process:
    group = _several_group(branches)
    return Prefix(group[0]) if group else STOP


def _same_group(numbers: list[int], then: Process) -> Menu:
    if len(numbers) > MOST_BRANCHES:
        raise Retreat
    return (tuple([(number, then) for number in sorted(numbers)]),)


def _same(numbers: list[int], then: Process) -> Process:
    return Prefix(_same_group(numbers, then)[0])


def _whole(process: Process) -> Menu:
    """The menu of a process."""
    if type(process) is Prefix:
        return (process.branches,)
    if type(process) is Reference:
        found = process.menu()
        if found is not None:
            return found
    raise NoMenu


def _groups(operand: Process) -> Menu:
    """What an operand adds to the menu of a choice: a choice that has a name stays one by itself."""
    if operand is STOP:
        return ()
    found = _whole(operand)
    return found if len(found) == 1 else (found,)


def _joined(menus: list[Menu]) -> Menu:
    return tuple([group for menu in menus for group in menu])


def is_one_field(value: Any) -> bool:
    """Whether a value is one field whatever stands around it."""
    return type(value) in (int, str, Boolean) or (type(value) is Dotted and value.complete)


def _listing(found: Any) -> list[Any]:
    """What a generator ranges over."""
    if isinstance(found, Set):
        return found.elements()
    if type(found) is Sequence:
        return found.items()
    raise Retreat


def _members(found: Any) -> list[Any]:
    """The values of an input with a set of its own."""
    if type(found) is FiniteSet or (isinstance(found, Set) and found.is_finite()):
        return found.elements()
    raise Retreat


def building(head: Head) -> Callable[[Env], Any]:
    """What makes the complete value of a constructor with these fields."""

    def build(fields: Env) -> Any:
        value = reduce(dot, fields, head.value)
        if type(value) is not Dotted or not value.complete:
            raise Retreat
        return value

    return build


def numbering(head: ChannelHead) -> Callable[[Env], int]:
    """What finds the number of the event with these fields, and keeps it."""

    def number(fields: Env) -> int:
        event = reduce(dot, fields, head.value)
        if type(event) is not Event:
            raise Retreat
        found: int = head.numbers.setdefault(fields, event.number)
        return found

    return number


OF_SETS: dict[str, Callable[..., Any]] = {"union": union, "diff": difference, "inter": intersection}
"""Built-in functions of sets without what makes sure of the types."""

HELPERS: dict[str, Any] = {
    "FiniteSet": FiniteSet,
    "STOP": STOP,
    "append": append,
    "choice": external_choice,
    "deep": deep,
    "frozenset": frozenset,
    "groups": _groups,
    "joined": _joined,
    "len": len,
    "listing": _listing,
    "members": _members,
    "native": native,
    "one": _one,
    "same": _same,
    "same_group": _same_group,
    "several": _several,
    "several_group": _several_group,
    "whole": _whole,
}
"""By the names that the text of fused functions calls them by."""


# --- parts of keys -------------------------------------------------------------------------------------------


def _encode_set(value: Any) -> Any:
    found = value if type(value) is FiniteSet else deep(value)
    if type(found) is not FiniteSet:
        raise Retreat
    return found.items


def _encode_ordered(value: Any) -> Any:
    return value.native


def _decode_sequence(key: tuple[Any, ...]) -> Sequence:
    return Sequence.evaluated(key)


def _decode_map(key: tuple[Any, ...]) -> Map:
    return Map.evaluated(key)


def _tail_of(key: tuple[Any, ...]) -> tuple[Any, ...]:
    if len(key) == 1:
        raise Retreat
    return key[:-1]


def _head_of(key: tuple[Any, ...]) -> Any:
    if len(key) == 1:
        raise Retreat
    return key[-1]


_DECODERS: dict[str, Callable[[Any], Any]] = {
    "set": FiniteSet,
    "sequence": _decode_sequence,
    "map": _decode_map,
}


def _decoding(kinds: tuple[str, ...]) -> Callable[[Env], Env]:
    """What makes the values of arguments of these kinds from their key."""
    ways = [_DECODERS.get(kind) for kind in kinds]

    def decode(key: Env) -> Env:
        return tuple([part if way is None else way(part) for part, way in zip(key, ways, strict=True)])

    return decode


NATIVE_HELPERS: dict[str, Any] = {
    "Map": Map,
    "Retreat": Retreat,
    "decode_map": _decode_map,
    "decode_sequence": _decode_sequence,
    "decode_set": FiniteSet,
    "decoding": _decoding,
    "dict": dict,
    "encode_map": _encode_ordered,
    "encode_sequence": _encode_ordered,
    "encode_set": _encode_set,
    "head_of": _head_of,
    "tail_of": _tail_of,
}
"""Those of functions of keys (:mod:`cspcheck.cspm.evaluator.native_menus`)."""
