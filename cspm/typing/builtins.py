"""The types of the names that belong to the language, written the way an annotation would be.

They are the types of FDR's open front end. A name's type is read when a script first uses it.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from cspcheck.cspm.typing.types import (
    ATOMS,
    CONSTRAINT_NAMES,
    Constraints,
    Dotable,
    Extendable,
    Function,
    MapOf,
    Scheme,
    SequenceOf,
    SetOf,
    TupleOf,
    Type,
    Variable,
)

_COMPRESSION = "(Proc) -> Proc"

SIGNATURES: dict[str, str] = {
    # sets of values
    "Int": "{Int}",
    "Bool": "{Bool}",
    "Char": "{Char}",
    "Proc": "{Proc}",
    "Events": "{Event}",
    "True": "Bool",
    "False": "Bool",
    # processes
    "STOP": "Proc",
    "SKIP": "Proc",
    "DIV": "Proc",
    "CHAOS": "({Event}) -> Proc",
    "RUN": "({Event}) -> Proc",
    "WAIT": "(Int) -> Proc",
    "BUFFER": "(Int, {(Event, Event)}) -> Proc",
    "WEAK_BUFFER": "(Int, Event, {(Event, Event)}) -> Proc",
    "SIGNAL_BUFFER": "(Int, Event, Event, {(Event, Event)}) -> Proc",
    # sets
    "union": "Set a => ({a}, {a}) -> {a}",
    "inter": "Set a => ({a}, {a}) -> {a}",
    "diff": "Set a => ({a}, {a}) -> {a}",
    "Union": "Set a => ({{a}}) -> {a}",
    "Inter": "Set a => ({{a}}) -> {a}",
    "set": "Set a => (<a>) -> {a}",
    "Set": "Set a => ({a}) -> {{a}}",
    "Seq": "Set a => ({a}) -> {<a>}",
    "card": "Eq a => ({a}) -> Int",
    "empty": "Eq a => ({a}) -> Bool",
    "member": "Eq a => (a, {a}) -> Bool",
    "seq": "Eq a => ({a}) -> <a>",
    # sequences
    "length": "(<a>) -> Int",
    "null": "(<a>) -> Bool",
    "head": "(<a>) -> a",
    "tail": "(<a>) -> <a>",
    "concat": "(<<a>>) -> <a>",
    "elem": "Eq a => (a, <a>) -> Bool",
    # maps
    "emptyMap": "Set k => (| k => v |)",
    "mapFromList": "Set k => (<(k, v)>) -> (| k => v |)",
    "mapToList": "Set k => ((| k => v |)) -> <(k, v)>",
    "mapLookup": "Set k => ((| k => v |), k) -> v",
    "mapMember": "Set k => ((| k => v |), k) -> Bool",
    "mapUpdate": "Set k => ((| k => v |), k, v) -> (| k => v |)",
    "mapUpdateMultiple": "Set k => ((| k => v |), <(k, v)>) -> (| k => v |)",
    "mapDelete": "Set k => ((| k => v |), k) -> (| k => v |)",
    "Map": "({k}, {v}) -> {(| k => v |)}",
    # dots
    "extensions": "Yieldable b => (a => b) -> {a}",
    "productions": "Yieldable a => (b =>* a) -> {a}",
    # anything
    "error": "(<Char>) -> a",
    "show": "(a) -> <Char>",
    # imported as transparent
    **dict.fromkeys(
        (
            "normal",
            "normalise",
            "lazynorm",
            "sbisim",
            "dbisim",
            "wbisim",
            "diamond",
            "tau_loop_factor",
            "model_compress",
            "explicate",
            "lazyenumerate",
            "chase",
            "chase_nocache",
        ),
        _COMPRESSION,
    ),
    # imported as external
    "prioritise": "(Proc, <{Event}>) -> Proc",
    "prioritise_nocache": "(Proc, <{Event}>) -> Proc",
    "prioritisepo": "(Proc, {Event}, {(Event, Event)}, {Event}) -> Proc",
    "deter": "(Proc) -> Proc",
    "loop": "(Proc) -> Proc",
    "failure_watchdog": "(Proc, {Event}, Event) -> Proc",
    "trace_watchdog": "(Proc, {Event}, Event) -> Proc",
    "timed_priority": "(Proc) -> Proc",
    "mtransclose": "Eq a => ({(a, a)}, {a}) -> {(a, a)}",
    "relational_image": "(Eq a, Set b) => ({(a, b)}) -> (a) -> {b}",
    "relational_inverse_image": "(Set a, Eq b) => ({(a, b)}) -> (b) -> {a}",
    "transpose": "(Set a, Set b) => ({(a, b)}) -> {(b, a)}",
}

DEPRECATED: dict[str, str] = {"True": "true", "False": "false"}
"""Names that still work, with what should be written instead."""

_schemes: dict[str, Scheme] = {}


def builtin_scheme(name: str) -> Scheme:
    """The type of a name of the language. Raises KeyError for any other name."""
    scheme = _schemes.get(name)
    if scheme is None:
        scheme = _schemes[name] = read_signature(SIGNATURES[name])
    return scheme


def read_signature(text: str) -> Scheme:
    """The scheme written as *text*, in which every identifier is a variable unless it is one of the atoms."""
    return _Reader(text).scheme()


class _Reader:
    """Reads one signature, by recursive descent."""

    def __init__(self, text: str) -> None:
        self._tokens: list[str] = re.findall(r"\(\||\|\)|->|=>\*|=>|[{}<>(),]|\w+", text)
        self._next = 0
        self._variables: dict[str, Variable] = {}

    def scheme(self) -> Scheme:
        constraints = self._constraints()
        type_ = self._type()
        assert self._next == len(self._tokens), self._tokens
        for name, single in constraints:
            self._variable(name).constraints |= single
        return Scheme(tuple(self._variables.values()), type_)

    def _constraints(self) -> list[tuple[str, Constraints]]:
        by_name = {name: single for single, name in CONSTRAINT_NAMES.items()}
        found: list[tuple[str, Constraints]] = []
        start = 1 if self._tokens[0] == "(" else 0
        while self._tokens[start] in by_name and self._tokens[start + 1].isidentifier():
            found.append((self._tokens[start + 1], by_name[self._tokens[start]]))
            start += 3  # the constraint, its variable, and the comma, bracket or arrow behind them
        if found:
            self._next = start + 1 if self._tokens[start] == "=>" else start
        return found

    def _variable(self, name: str) -> Variable:
        return self._variables.setdefault(name, Variable(1))

    def _take(self, token: str | None = None) -> str:
        taken = self._tokens[self._next]
        assert token is None or taken == token, (token, taken)
        self._next += 1
        return taken

    def _at(self, token: str) -> bool:
        return self._next < len(self._tokens) and self._tokens[self._next] == token

    def _type(self) -> Type:
        left = self._plain()
        if self._at("=>"):
            self._take()
            return Dotable(left, self._type())
        if self._at("=>*"):
            self._take()
            return Extendable(left, self._type())
        return left

    def _plain(self) -> Type:
        token = self._take()
        if token == "{":
            return self._closed(SetOf, "}")
        if token == "<":
            return self._closed(SequenceOf, ">")
        if token == "(|":
            key = self._plain()
            self._take("=>")
            value = self._type()
            self._take("|)")
            return MapOf(key, value)
        if token == "(":
            items = [self._type()]
            while self._at(","):
                self._take()
                items.append(self._type())
            self._take(")")
            if self._at("->"):
                self._take()
                return Function(items, self._type())
            return items[0] if len(items) == 1 else TupleOf(items)
        return ATOMS.get(token) or self._variable(token)

    def _closed(self, kind: Callable[[Type], Type], end: str) -> Type:
        inner = self._type()
        self._take(end)
        return kind(inner)
