"""Relations, functions as relations, and bags as expressions of CSPm: sets of pairs and maps.

A relation is written as a set of pairs, a function as a map, a bag as the map from its items to how often they are
in it. What is said of pairs is said of all three, of sequences too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Term
from cspcheck.cspm.oz.writing.operators_cspm import AND, ATOM, COMPARED

if TYPE_CHECKING:
    from cspcheck.cspm.oz.writing.expressions import ExpressionWriter

Written = tuple[str, int]


def pairs_of(self: ExpressionWriter, term: Term) -> str:
    """The set of the pairs that a relation, a function, a bag or a sequence is."""
    text = self.text(term)
    match term.type:
        case core.FunctionType() | core.BagType():
            return f"set(mapToList({text}))"
        case core.SequenceType():
            n = self.local("n")
            return f"{{({n}, {self.helper('nth')}({text}, {n})) | {n} <- {{1..#({text})}}}}"
    return text


def _inverse(self: ExpressionWriter, term: Apply) -> Written:
    x, y = self.local("x"), self.local("y")
    return f"{{({y}, {x}) | ({x}, {y}) <- {pairs_of(self, term.operands[0])}}}", ATOM


def _image(self: ExpressionWriter, term: Apply) -> Written:
    relation, among = term.operands
    x, y = self.local("x"), self.local("y")
    return f"{{{y} | ({x}, {y}) <- {pairs_of(self, relation)}, member({x}, {self.text(among)})}}", ATOM


def _compose(self: ExpressionWriter, term: Apply) -> Written:
    first, second = term.operands
    k, v, x, y = (self.local(letter) for letter in "kvxy")
    if isinstance(term.type, core.FunctionType):
        after = self.text(second)
        found = f"({k}, mapLookup({after}, {v})) | ({k}, {v}) <- mapToList({self.text(first)}), mapMember({after}, {v})"
        return f"mapFromList(<{found}>)", ATOM
    generators = f"({x}, {k}) <- {pairs_of(self, first)}, ({v}, {y}) <- {pairs_of(self, second)}"
    return f"{{({x}, {y}) | {generators}, {k} == {v}}}", ATOM


def _closure(self: ExpressionWriter, term: Apply) -> Written:
    return f"{self.helper('closure')}({pairs_of(self, term.operands[0])})", ATOM


def _reflexive_closure(self: ExpressionWriter, term: Apply) -> Written:
    return f"{self.helper('closure')}({self.helper('with_identity')}({pairs_of(self, term.operands[0])}))", ATOM


def _identity(self: ExpressionWriter, term: Apply) -> Written:
    x = self.local("x")
    return f"{{({x}, {x}) | {x} <- {self.text(term.operands[0])}}}", ATOM


def _override(self: ExpressionWriter, term: Apply) -> Written:
    whole, change = term.operands
    if isinstance(term.type, core.FunctionType):
        if isinstance(change, Apply) and change.operator == "function":
            pairs = f"<{', '.join(self.text(pair) for pair in change.operands)}>"
        else:
            pairs = f"mapToList({self.text(change)})"
        return f"mapUpdateMultiple({self.text(whole)}, {pairs})", ATOM
    new = pairs_of(self, change)
    x, y, k = self.local("x"), self.local("y"), self.local("k")
    kept = f"({x}, {y}) <- {pairs_of(self, whole)}, not member({x}, {{{k} | ({k}, _) <- {new}}})"
    return f"union({{({x}, {y}) | {kept}}}, {new})", ATOM


def _sequence_to_function(self: ExpressionWriter, term: Apply) -> Written:
    text, n = self.text(term.operands[0]), self.local("n")
    return f"mapFromList(<({n}, {self.helper('nth')}({text}, {n})) | {n} <- <1..#({text})>>)", ATOM


def _extract(self: ExpressionWriter, term: Apply) -> Written:
    places, sequence = term.operands
    text, n = self.text(sequence), self.local("n")
    chosen = f"member({n}, {self.text(places)})"
    return f"<{self.helper('nth')}({text}, {n}) | {n} <- <1..#({text})>, {chosen}>", ATOM


def _suffix(self: ExpressionWriter, term: Apply) -> Written:
    reverse = self.helper("rev")
    left, right = (self.text(operand) for operand in term.operands)
    return f"{reverse}({left}) <= {reverse}({right})", COMPARED


def _infix(self: ExpressionWriter, term: Apply) -> Written:
    part, whole = (self.text(operand) for operand in term.operands)
    n, k, nth = self.local("n"), self.local("k"), self.helper("nth")
    piece = f"<{nth}({whole}, {n} + {k}) | {k} <- <1..#({part})>>"
    return f"not empty({{{n} | {n} <- {{0..#({whole}) - #({part})}}, {piece} == {part}}})", AND


def _squash(self: ExpressionWriter, term: Apply) -> Written:
    text, k = self.text(term.operands[0]), self.local("k")
    return f"<mapLookup({text}, {k}) | {k} <- seq({{{k} | ({k}, _) <- set(mapToList({text}))}})>", ATOM


def _same(self: ExpressionWriter, term: Apply) -> Written:
    return self.written(term.operands[0])


def counted(self: ExpressionWriter, bag: Term, item: Term) -> Written:
    """How often an item is in a bag."""
    text, at = self.text(bag), self.text(item)
    return f"(if mapMember({text}, {at}) then mapLookup({text}, {at}) else 0)", ATOM


def _count(self: ExpressionWriter, term: Apply) -> Written:
    return counted(self, *term.operands)


def _in_bag(self: ExpressionWriter, term: Apply) -> Written:
    item, bag = term.operands
    return f"mapMember({self.text(bag)}, {self.text(item)})", ATOM


def _items(self: ExpressionWriter, term: Apply) -> Written:
    x = self.local("x")
    return f"{self.helper('bag_union')}(emptyMap, <({x}, 1) | {x} <- {self.text(term.operands[0])}>)", ATOM


def _bag_display(self: ExpressionWriter, term: Apply) -> Written:
    once = ", ".join(f"({self.text(operand)}, 1)" for operand in term.operands)
    return f"{self.helper('bag_union')}(emptyMap, <{once}>)", ATOM


def _bag_union(self: ExpressionWriter, term: Apply) -> Written:
    left, right = (self.text(operand) for operand in term.operands)
    return f"{self.helper('bag_union')}({left}, mapToList({right}))", ATOM


RULES: Final[Mapping[str, Callable[[ExpressionWriter, Apply], Written]]] = {
    "inverse": _inverse,
    "image": _image,
    "compose": _compose,
    "closure": _closure,
    "reflexive_closure": _reflexive_closure,
    "id": _identity,
    "override": _override,
    "sequence_to_function": _sequence_to_function,
    "extract": _extract,
    "suffix": _suffix,
    "infix": _infix,
    "squash": _squash,
    "bag_to_function": _same,
    "count": _count,
    "in_bag": _in_bag,
    "items": _items,
    "bag_display": _bag_display,
    "bag_union": _bag_union,
}
"""How the operators are written, by their names in core terms."""
