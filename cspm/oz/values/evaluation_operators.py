"""What each operator of core terms does with the values of its operands."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from itertools import combinations
from typing import Any, Final

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply
from cspcheck.cspm.oz.values.carriers import Carrier, Frame, TooLarge, Unbounded, Undefined, listed
from cspcheck.cspm.oz.values.terms import show_term
from cspcheck.cspm.oz.values.values import LARGEST, Graph, in_order

Code = Callable[[Frame], Any]
Factory = Callable[[Apply, Sequence[Code]], Code]

OPERATIONS: Final[dict[str, Factory]] = {}
"""How each operator that evaluates all its operands is compiled, from the term and the operands' codes."""


def _operation(*names: str) -> Callable[[Factory], Factory]:
    def register(factory: Factory) -> Factory:
        for name in names:
            OPERATIONS[name] = factory
        return factory

    return register


def _unary(name: str, function: Callable[[Any], Any]) -> None:
    def factory(term: Apply, codes: Sequence[Code]) -> Code:
        (a,) = codes
        return lambda frame: function(a(frame))

    OPERATIONS[name] = factory


def _binary(name: str, function: Callable[[Any, Any], Any]) -> None:
    def factory(term: Apply, codes: Sequence[Code]) -> Code:
        a, b = codes
        return lambda frame: function(a(frame), b(frame))

    OPERATIONS[name] = factory


def _partial(name: str, function: Callable[..., Any], why: str) -> None:
    """An operator that is undefined where *function* raises a LookupError, ValueError or division by zero."""

    def factory(term: Apply, codes: Sequence[Code]) -> Code:
        def apply(frame: Frame) -> Any:
            values = [code(frame) for code in codes]
            try:
                return function(*values)
            except (LookupError, ValueError, ZeroDivisionError):
                raise Undefined(f"`{show_term(term)}` has no value: {why}", term.span) from None

        return apply

    OPERATIONS[name] = factory


def _variadic(name: str, function: Callable[[list[Any]], Any]) -> None:
    def factory(term: Apply, codes: Sequence[Code]) -> Code:
        return lambda frame: function([code(frame) for code in codes])

    OPERATIONS[name] = factory


# --- logic and equality ----------------------------------------------------------------------------------------------


@_operation("not")
def _not(term: Apply, codes: Sequence[Code]) -> Code:
    (a,) = codes
    return lambda frame: not a(frame)


@_operation("equal", "iff")
def _equal(term: Apply, codes: Sequence[Code]) -> Code:
    a, b = codes
    if _holds_sets(term.operands[0].type):
        return lambda frame: same(a(frame), b(frame))
    return lambda frame: a(frame) == b(frame)


def _holds_sets(type_: core.Type) -> bool:
    """Whether values of a type can be carriers that are not written out."""
    return not isinstance(type_, core.BoolType | core.IntType | core.RealType | core.GivenType)


def same(a: Any, b: Any) -> bool:
    """Whether two values of one type are equal.

    Raises:
        Unbounded: they are infinite sets of which that cannot be told.
    """
    if isinstance(a, Carrier) or isinstance(b, Carrier):
        if a is b:
            return True
        infinite = [s for s in (a, b) if isinstance(s, Carrier) and not s.exact]
        if len(infinite) == 1 and _surely_infinite(infinite[0]):
            return False
        return listed(a) == listed(b)
    return bool(a == b)


def _surely_infinite(carrier: Carrier) -> bool:
    return getattr(carrier.term, "operator", None) in ("Int", "Nat", "Nat1", "Real")


# --- numbers ---------------------------------------------------------------------------------------------------------


@_operation("less")
def _less(term: Apply, codes: Sequence[Code]) -> Code:
    a, b = codes
    return lambda frame: a(frame) < b(frame)


@_operation("at_most")
def _at_most(term: Apply, codes: Sequence[Code]) -> Code:
    a, b = codes
    return lambda frame: a(frame) <= b(frame)


@_operation("plus")
def _plus(term: Apply, codes: Sequence[Code]) -> Code:
    a, b = codes
    return lambda frame: a(frame) + b(frame)


@_operation("minus")
def _minus(term: Apply, codes: Sequence[Code]) -> Code:
    a, b = codes
    return lambda frame: a(frame) - b(frame)


_binary("times", lambda a, b: a * b)
_unary("negate", lambda a: -a)
_unary("abs", abs)
_partial("divide", lambda a, b: a / b, "the divisor is zero")
_partial("div", lambda a, b: a // b, "the divisor is zero")
_partial("mod", lambda a, b: a % b, "the divisor is zero")
_partial("min", lambda s: min(listed(s)), "the set is empty")
_partial("max", lambda s: max(listed(s)), "the set is empty")
_unary("int_to_real", Fraction)
_unary("floor", math.floor)


# --- tuples and sets -------------------------------------------------------------------------------------------------

_variadic("tuple", tuple)
_variadic("set", frozenset)


@_operation("range")
def _range(term: Apply, codes: Sequence[Code]) -> Code:
    a, b = codes

    def interval(frame: Frame) -> frozenset[int]:
        low, high = a(frame), b(frame)
        if high - low >= LARGEST:
            raise TooLarge(show_term(term), term.span)
        return frozenset(range(low, high + 1))

    return interval


def _set_algebra(name: str, finite: Callable[[Any, Any], Any], member: Callable[[bool, bool], bool]) -> None:
    """A binary operator on sets; of one that is not written out, as far as its elements can be gone through."""

    def factory(term: Apply, codes: Sequence[Code]) -> Code:
        a, b = codes

        def combine(frame: Frame) -> Any:
            left, right = a(frame), b(frame)
            if type(left) is frozenset and type(right) is frozenset:
                return finite(left, right)
            return _combined(term, left, right, member)

        return combine

    OPERATIONS[name] = factory


def _combined(term: Apply, left: Any, right: Any, member: Callable[[bool, bool], bool]) -> Any:
    def contains(value: Any) -> bool:
        return member(value in left, value in right)

    def elements_of(side: Any) -> Iterable[Any]:
        return side if type(side) is frozenset else side.listing()

    def exact(side: Any) -> bool:
        return type(side) is frozenset or side.exact

    needed = [side for side, alone in ((left, member(True, False)), (right, member(False, True))) if alone]
    if not needed:  # an intersection: either side has all its elements
        needed = [left if exact(left) else right]
    if all(map(exact, needed)):
        return frozenset(value for side in needed for value in elements_of(side) if contains(value))
    return Carrier(
        term,
        contains,
        lambda: in_order({value for side in needed for value in elements_of(side) if contains(value)}),
        False,
    )


_set_algebra("union", lambda a, b: a | b, lambda a, b: a or b)
_set_algebra("inter", lambda a, b: a & b, lambda a, b: a and b)
_set_algebra("diff", lambda a, b: a - b, lambda a, b: a and not b)
_set_algebra("symdiff", lambda a, b: a ^ b, lambda a, b: a != b)
_unary("Union", lambda s: frozenset[Any]().union(*map(listed, listed(s))))
_partial("Inter", lambda s: _intersection([listed(x) for x in listed(s)]), "it is the intersection of no sets")


def _intersection(sets: list[frozenset[Any]]) -> frozenset[Any]:
    return sets[0].intersection(*sets[1:])


def subset(a: Any, b: Any) -> bool:
    """Whether one set is within another.

    Raises:
        Unbounded: the first has to be gone through and is infinite.
    """
    if type(a) is frozenset and type(b) is frozenset:
        return a <= b
    return a is b or all(value in b for value in listed(a))


_binary("subset", subset)
_binary("proper_subset", lambda a, b: subset(a, b) and not subset(b, a))
_variadic("disjoint", lambda sets: all(listed(a).isdisjoint(listed(b)) for a, b in combinations(sets, 2)))


def _partition(sets: list[Any]) -> bool:
    whole, *parts = map(listed, sets)
    return sum(map(len, parts)) == len(whole) and frozenset().union(*parts) == whole


_variadic("partition", _partition)


@_operation("card")
def _card(term: Apply, codes: Sequence[Code]) -> Code:
    (a,) = codes

    def size(frame: Frame) -> int:
        found = a(frame)
        try:
            return len(found if isinstance(found, Graph) else listed(found))
        except Unbounded:
            raise Undefined(f"`{show_term(term)}` has no value: the set is infinite", term.span) from None

    return size


# --- relations and functions -----------------------------------------------------------------------------------------


def pairs(value: Any) -> Iterable[tuple[Any, Any]]:
    """The pairs of a relation or a function."""
    if isinstance(value, Graph):
        return value.items()
    return listed(value)


def _keeping(chosen: Callable[[Any, Any, Any], bool]) -> Callable[[Any, Any], Any]:
    """A restriction: keeps the pairs that are chosen by first, second and set; a function stays one."""

    def keep(relation: Any, among: Any) -> Any:
        kept = [(a, b) for a, b in pairs(relation) if chosen(a, b, among)]
        return Graph(kept) if isinstance(relation, Graph) else frozenset(kept)

    return keep


_dom_restrict = _keeping(lambda a, b, among: a in among)
_dom_subtract = _keeping(lambda a, b, among: a not in among)
_binary("dom_restrict", lambda s, r: _dom_restrict(r, s))
_binary("dom_subtract", lambda s, r: _dom_subtract(r, s))
_binary("ran_restrict", _keeping(lambda a, b, among: b in among))
_binary("ran_subtract", _keeping(lambda a, b, among: b not in among))
_unary("dom", lambda r: frozenset([a for a, _ in pairs(r)]))
_unary("ran", lambda r: frozenset([b for _, b in pairs(r)]))
_unary("id", lambda s: frozenset([(a, a) for a in listed(s)]))
_unary("inverse", lambda r: frozenset([(b, a) for a, b in pairs(r)]))
_binary("image", lambda r, s: frozenset([b for a, b in pairs(r) if a in s]))


def _compose(r: Any, s: Any) -> Any:
    if isinstance(r, Graph) and isinstance(s, Graph):
        return Graph((a, s[b]) for a, b in r.items() if b in s)
    second: dict[Any, list[Any]] = {}
    for b, c in pairs(s):
        second.setdefault(b, []).append(c)
    return frozenset([(a, c) for a, b in pairs(r) for c in second.get(b, ())])


@_operation("compose")
def _composition(term: Apply, codes: Sequence[Code]) -> Code:
    r, s = codes
    if isinstance(term.type, core.FunctionType):
        return lambda frame: _compose(r(frame), s(frame))
    return lambda frame: frozenset(pairs(_compose(r(frame), s(frame))))


def _override(r: Any, s: Any) -> Any:
    if isinstance(r, Graph) and isinstance(s, Graph):
        return Graph({**r, **s})
    replaced = {a for a, _ in pairs(s)}
    return frozenset([*[(a, b) for a, b in pairs(r) if a not in replaced], *pairs(s)])


_binary("override", _override)


def _closure(relation: Any) -> frozenset[Any]:
    after: dict[Any, set[Any]] = {}
    for a, b in pairs(relation):
        after.setdefault(a, set()).add(b)
    found: set[tuple[Any, Any]] = set()
    for start in after:
        waiting = list(after[start])
        seen: set[Any] = set()
        while waiting:
            b = waiting.pop()
            if b not in seen:
                seen.add(b)
                found.add((start, b))
                waiting.extend(after.get(b, ()))
    return frozenset(found)


def _reflexive_closure(relation: Any) -> frozenset[Any]:
    field = {x for pair in pairs(relation) for x in pair}
    return _closure(relation) | frozenset((x, x) for x in field)


_unary("closure", _closure)
_unary("reflexive_closure", _reflexive_closure)
_unary("function_to_relation", lambda f: frozenset(f.items()))
_unary("bag_to_function", lambda b: b)


@_operation("apply")
def _application(term: Apply, codes: Sequence[Code]) -> Code:
    function, argument = codes
    if isinstance(term.operands[0].type, core.BagType):
        return lambda frame: function(frame).get(argument(frame), 0)
    if isinstance(term.operands[0].type, core.SequenceType):

        def element(frame: Frame) -> Any:
            items, position = function(frame), argument(frame)
            if 1 <= position <= len(items):
                return items[position - 1]
            raise _outside(term, position, f"1..{len(items)}")

        return element

    def apply(frame: Frame) -> Any:
        graph, at = function(frame), argument(frame)
        try:
            return graph[at]
        except KeyError:
            raise _outside(term, at, "its domain") from None

    return apply


def _outside(term: Apply, at: Any, where: str) -> Undefined:
    from cspcheck.cspm.oz.values.values import show

    shown = show(at, term.operands[1].type)
    return Undefined(f"`{show_term(term)}` has no value: {shown} is outside {where}", term.span)


@_operation("function")
def _function(term: Apply, codes: Sequence[Code]) -> Code:
    def display(frame: Frame) -> Graph:
        graph = Graph()
        for code in codes:
            a, b = code(frame)
            if graph.setdefault(a, b) != b:
                raise Undefined(f"`{show_term(term)}` is not a function: two of its pairs begin alike", term.span)
        return graph

    return display


# --- sequences and bags ----------------------------------------------------------------------------------------------

_variadic("sequence", tuple)
_unary("length", len)
_unary("rev", lambda s: s[::-1])
_unary("flatten", lambda s: tuple([item for inner in s for item in inner]))
_unary("sequence_to_function", lambda s: Graph(enumerate(s, 1)))
_binary("filter", lambda s, among: tuple([item for item in s if item in among]))
_binary("extract", lambda among, s: tuple([item for i, item in enumerate(s, 1) if i in among]))
_binary("prefix", lambda s, t: t[: len(s)] == s)
_binary("suffix", lambda s, t: len(s) <= len(t) and t[len(t) - len(s) :] == s)
_binary("infix", lambda s, t: any(t[i : i + len(s)] == s for i in range(len(t) - len(s) + 1)))
_unary("squash", lambda f: tuple([f[i] for i in sorted(f)]))


@_operation("concat")
def _concat(term: Apply, codes: Sequence[Code]) -> Code:
    a, b = codes
    return lambda frame: a(frame) + b(frame)


def _of_nonempty(name: str, function: Callable[[tuple[Any, ...]], Any]) -> None:
    def take(items: tuple[Any, ...]) -> Any:
        if not items:
            raise IndexError
        return function(items)

    _partial(name, take, "the sequence is empty")


_of_nonempty("head", lambda s: s[0])
_of_nonempty("tail", lambda s: s[1:])
_of_nonempty("last", lambda s: s[-1])
_of_nonempty("front", lambda s: s[:-1])


def _counted(items: Iterable[Any]) -> Graph:
    bag = Graph()
    for item in items:
        bag[item] = bag.get(item, 0) + 1
    return bag


_variadic("bag_display", _counted)
_unary("items", _counted)
_binary("count", lambda bag, item: bag.get(item, 0))
_binary("in_bag", lambda item, bag: item in bag)


def _bag_union(a: Graph, b: Graph) -> Graph:
    total = Graph(a)
    for item, count in b.items():
        total[item] = total.get(item, 0) + count
    return total


_binary("bag_union", _bag_union)
# Of the solver only: what is left of a sequence when its first or last items have been taken off, and the parts of a
# value of a free type.
_binary("%drop", lambda s, n: s[n:])
_binary("%drop_last", lambda s, n: s[: len(s) - n])
_unary("%rank", lambda value: value.rank)
_unary("%argument", lambda value: value.argument)
