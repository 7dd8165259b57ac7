"""The types of the operators and functions of the mathematical toolkit of ISO Z (13568), and of reals and bags."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import cache
from typing import Final

from cspcheck.cspm.oz.objects.types import (
    NUMBER,
    TRUTH,
    Given,
    ObjectZType,
    Open,
    Power,
    Product,
    pairs,
    sequence,
)

# `P(a)` sets, `R(a,b)` relations, `S(a)` sequences, `G(a)` bags, `X(a,b)` pairs, `N` numbers, `B` truth values.
_OPERATORS: Final[Mapping[str, str]] = {
    **dict.fromkeys(["plus", "minus", "times", "divide", "div", "mod"], "N N > N"),
    "negate": "N > N",
    "size": "P(a) > N",
    "dom": "R(a,b) > P(a)",
    "ran": "R(a,b) > P(b)",
    "id": "P(a) > R(a,a)",
    "Union": "P(P(a)) > P(a)",
    "Inter": "P(P(a)) > P(a)",
    "flatten": "S(S(a)) > S(a)",
    **dict.fromkeys(["power", "power1", "finset", "finset1"], "P(a) > P(P(a))"),
    **dict.fromkeys(["seq", "seq1", "iseq"], "P(a) > P(S(a))"),
    "bag": "P(a) > P(G(a))",
    "inverse": "R(a,b) > R(b,a)",
    "closure": "R(a,a) > R(a,a)",
    "reflexive_closure": "R(a,a) > R(a,a)",
    "image": "R(a,b) P(a) > P(b)",
    "maplet": "a b > X(a,b)",
    "range": "N N > P(N)",
    **dict.fromkeys(["symdiff", "union", "diff", "inter"], "P(a) P(a) > P(a)"),
    "concat": "S(a) S(a) > S(a)",
    "bag_union": "G(a) G(a) > G(a)",
    "filter": "S(a) P(a) > S(a)",
    "compose": "R(a,b) R(b,c) > R(a,c)",
    "circ": "R(b,c) R(a,b) > R(a,c)",
    "extract": "P(N) S(a) > S(a)",
    "override": "R(a,b) R(a,b) > R(a,b)",
    **dict.fromkeys(["ran_restrict", "ran_subtract"], "R(a,b) P(b) > R(a,b)"),
    **dict.fromkeys(["dom_restrict", "dom_subtract"], "P(a) R(a,b) > R(a,b)"),
    **dict.fromkeys(
        ["rel", "pfun", "fun", "pinj", "inj", "psurj", "surj", "bij", "ffun", "finj"], "P(a) P(b) > P(R(a,b))"
    ),
    "disjoint": "R(a,P(b)) > B",
    # relations
    **dict.fromkeys(["equal", "not_equal"], "a a > B"),
    **dict.fromkeys(["less", "at_most", "greater", "at_least"], "N N > B"),
    **dict.fromkeys(["in", "notin"], "a P(a) > B"),
    **dict.fromkeys(["subset", "proper_subset"], "P(a) P(a) > B"),
    **dict.fromkeys(["prefix", "suffix", "infix"], "S(a) S(a) > B"),
    "in_bag": "a G(a) > B",
    "partition": "R(a,P(b)) P(b) > B",
}

_NAMES: Final[Mapping[str, str]] = {
    **dict.fromkeys(["nat", "nat1", "int", "real", "arithmos"], "P(N)"),
    "bool": "P(B)",
    **dict.fromkeys(["head", "last"], "R(S(a),a)"),
    **dict.fromkeys(["tail", "front", "rev"], "R(S(a),S(a))"),
    "squash": "R(R(N,a),S(a))",
    "items": "R(S(a),G(a))",
    "count": "R(G(a),R(a,N))",
    **dict.fromkeys(["min", "max"], "R(P(N),N)"),
    **dict.fromkeys(["abs", "succ", "floor"], "R(N,N)"),
    "first": "R(X(a,b),a)",
    "second": "R(X(a,b),b)",
    **dict.fromkeys(["Delta", "Xi", "pre", "theta"], ""),
}

_MAKERS: Final[Mapping[str, Callable[..., ObjectZType]]] = {
    "P": Power,
    "R": pairs,
    "S": sequence,
    "G": lambda element: pairs(element, NUMBER),
    "X": lambda left, right: Product((left, right)),
}
_TOKEN = re.compile(r"[A-Za-z(),]")


@cache
def _tokens(text: str) -> tuple[str, ...]:
    return tuple(_TOKEN.findall(text))


class _Pattern:
    """Reads the types of one line of a table."""

    def __init__(self, text: str, variables: dict[str, ObjectZType]) -> None:
        self._tokens = list(_tokens(text))
        self._variables = variables

    def read(self) -> ObjectZType:
        token = self._tokens.pop(0)
        if token == "N":
            return NUMBER
        if token == "B":
            return TRUTH
        if token.islower():
            return self._variables.setdefault(token, Open())
        items = []
        while self._tokens.pop(0) != ")":
            items.append(self.read())
        return _MAKERS[token](*items)


def operator_type(name: str) -> tuple[list[ObjectZType], ObjectZType] | None:
    """What the operands of an operator are of, and its value; None for one that the toolkit has not."""
    line = _OPERATORS.get(name)
    if line is None:
        return None
    variables: dict[str, ObjectZType] = {}
    operands, _, value = line.partition(">")
    return [_Pattern(o, variables).read() for o in operands.split()], _Pattern(value.strip(), variables).read()


def name_type(name: str) -> ObjectZType | None:
    """What a name of the toolkit is of; None for one that it has not."""
    line = _NAMES.get(name)
    return _Pattern(line, {}).read() if line else None


def is_toolkit_name(name: str) -> bool:
    """Whether a script that declares nothing of that name has it from the toolkit."""
    return name in _NAMES


RELATIONS: Final = frozenset(name for name, line in _OPERATORS.items() if line.endswith("> B"))
"""The operators whose value is a truth value."""

GIVEN_NAMES: Final = (NUMBER, TRUTH, Given("arithmos"))
