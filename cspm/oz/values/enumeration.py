"""Going through the sets that variables are taken from, and telling what is in them without going through them.

A carrier has three faces: what is in it (:func:`membership`), what a search takes of it (:func:`enumeration`; where
it is wide that is what its finite reading says), and what is in that (:func:`membership` with ``reading=True``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, combinations, combinations_with_replacement, permutations, product
from math import comb, perm
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Comprehension, Constant, FiniteReading, If, Term
from cspcheck.cspm.oz.values.carriers import Carrier, Frame, TooLarge, Unbounded, capped
from cspcheck.cspm.oz.values.readings import COLLECTIONS
from cspcheck.cspm.oz.values.terms import free_variables, show_term
from cspcheck.cspm.oz.values.values import LARGEST, Construction, Element, Graph, in_order

if TYPE_CHECKING:
    from cspcheck.cspm.oz.values.evaluation import FrameScope, TermEvaluator

Member: TypeAlias = Callable[[Frame, Any], bool]

CARRIERS: Final = COLLECTIONS | {"Int", "Nat", "Nat1", "Real", "All", "Records", "Bool", "cross"}
"""The operators whose values may be too many to write out."""
MOST_REMEMBERED: Final = 1 << 18
"""Of so many collections it is remembered whether they are in a set."""
NUMBERS: Final = frozenset({"Int", "Nat", "Nat1", "Real"})


@dataclass(frozen=True, slots=True)
class Enumeration:
    """A way through a set.

    Attributes:
        code: gives the elements in order; raises Unbounded where there is no way.
        readings: the finite readings that it follows; without any, it is the whole set.
        bounded: whether there is a way at all.
        at_least: how many elements there are, or fewer than that, without going through them; None: nobody knows.
    """

    code: Callable[[Frame], Iterable[Any]]
    readings: tuple[FiniteReading, ...] = ()
    bounded: bool = True
    at_least: Callable[[Frame], int] | None = None

    @property
    def exact(self) -> bool:
        """Whether it goes through all of the set."""
        return self.bounded and not self.readings


def _nowhere(term: Term) -> Enumeration:
    def fail(frame: Frame) -> Iterable[Any]:
        raise Unbounded(term)

    return Enumeration(fail, (), False)


# --- membership ------------------------------------------------------------------------------------------------------


def membership(evaluator: TermEvaluator, term: Term, scope: FrameScope, *, reading: bool = False) -> Member:
    """Whether a value is in the set that *term* is; with *reading*, whether it is in its finite reading."""
    if reading:
        found = evaluator.readings.of(term)
        if found is not None:
            return _in_reading(evaluator, term, found, scope)
    if isinstance(term, Apply):
        rule = _MEMBERSHIP.get(term.operator)
        if rule is not None:
            return rule(evaluator, term, scope, reading)
        if term.operator in COLLECTIONS:
            test = _collection_member(evaluator, term, scope, reading)
            return _remembered(test) if not free_variables(term) else test
    if isinstance(term, Comprehension) and term.kind == "set":
        from cspcheck.cspm.oz.values.binding import comprehension_member

        return comprehension_member(evaluator, term, scope, reading)
    if isinstance(term, If):
        chosen = evaluator.code(term.test, scope)
        then, otherwise = (membership(evaluator, t, scope, reading=reading) for t in (term.then, term.otherwise))
        return lambda frame, value: then(frame, value) if chosen(frame) else otherwise(frame, value)
    value_of = evaluator.code(term, scope)
    return lambda frame, value: value in value_of(frame)


def _remembered(test: Member) -> Member:
    """The same for a set that is always the same: collections are gone through once."""
    known: dict[Any, bool] = {}

    def remembered(frame: Frame, value: Any) -> bool:
        if isinstance(value, Carrier):
            return test(frame, value)
        found = known.get(value)
        if found is None:
            if len(known) > MOST_REMEMBERED:
                known.clear()
            found = known[value] = test(frame, value)
        return found

    return remembered


def _in_reading(evaluator: TermEvaluator, term: Term, reading: FiniteReading, scope: FrameScope) -> Member:
    readings = evaluator.readings
    inside = membership(evaluator, term, scope)
    if reading.values is not None:
        kept: list[frozenset[Any]] = []

        def listed_in(frame: Frame, value: Any) -> bool:
            if not kept:
                kept.append(frozenset(readings.values(reading)))
            return value in kept[0] and inside(frame, value)

        return listed_in
    bound = reading.bound
    assert bound is not None
    if isinstance(term, Apply) and term.operator in COLLECTIONS:
        parts = _collection_member(evaluator, term, scope, True)
        return lambda frame, value: len(value) <= bound and parts(frame, value)
    return inside


MembershipRule = Callable[["TermEvaluator", Apply, "FrameScope", bool], Member]


def _anything(evaluator: TermEvaluator, term: Apply, scope: FrameScope, reading: bool) -> Member:
    return lambda frame, value: True


def _from(low: int) -> MembershipRule:
    return lambda evaluator, term, scope, reading: lambda frame, value: value >= low


def _range_member(evaluator: TermEvaluator, term: Apply, scope: FrameScope, reading: bool) -> Member:
    a, b = term.operands
    if isinstance(a, Constant) and isinstance(b, Constant):
        first, last = a.value, b.value
        return lambda frame, value: first <= value <= last
    low, high = (evaluator.code(o, scope) for o in term.operands)
    return lambda frame, value: low(frame) <= value <= high(frame)


def _cross_member(evaluator: TermEvaluator, term: Apply, scope: FrameScope, reading: bool) -> Member:
    tests = [membership(evaluator, o, scope, reading=reading) for o in term.operands]
    return lambda frame, value: all(test(frame, item) for test, item in zip(tests, value, strict=True))


def _combined_member(together: Callable[[bool, bool], bool]) -> MembershipRule:
    def rule(evaluator: TermEvaluator, term: Apply, scope: FrameScope, reading: bool) -> Member:
        a, b = (membership(evaluator, o, scope, reading=reading) for o in term.operands)
        return lambda frame, value: together(a(frame, value), b(frame, value))

    return rule


def _all_member(evaluator: TermEvaluator, term: Apply, scope: FrameScope, reading: bool) -> Member:
    from cspcheck.cspm.oz.values.evaluation import FrameScope

    assert isinstance(term.type, core.SetType)
    kind = term.type.element
    if not isinstance(kind, core.FreeType):
        return lambda frame, value: True
    definition = evaluator.specification.frees[kind.name]
    if all(carrier is None for _, carrier in definition.branches):
        return lambda frame, value: True
    tests: list[Member] = []
    own = FrameScope()
    own_frame: Frame = []

    def test(frame: Frame, value: Construction) -> bool:
        if not tests:  # only now, for the type may be within itself
            tests.extend(
                _nothing_member if carrier is None else membership(evaluator, carrier, own, reading=reading)
                for _, carrier in definition.branches
            )
            own_frame.extend(own.frame())
        return tests[value.rank](own_frame, value.argument)

    return test


def _nothing_member(frame: Frame, value: Any) -> bool:
    return True


def _records_member(evaluator: TermEvaluator, term: Apply, scope: FrameScope, reading: bool) -> Member:
    assert isinstance(term.type, core.SetType)
    kind = term.type.element
    assert isinstance(kind, core.RecordType)
    definition = evaluator.specification.records[kind.name]
    tests = [membership(evaluator, f.carrier, scope, reading=reading) for f in definition.fields]
    predicate = evaluator.record_test(kind.name)

    def test(frame: Frame, value: tuple[Any, ...]) -> bool:
        return all(test(frame, item) for test, item in zip(tests, value, strict=True)) and predicate(value)

    return test


def _collection_member(evaluator: TermEvaluator, term: Apply, scope: FrameScope, reading: bool) -> Member:
    parts = [membership(evaluator, o, scope, reading=reading) for o in term.operands]
    operator = term.operator
    if len(parts) == 2:
        return _relation_member(evaluator, term, parts, scope)
    (item,) = parts
    nonempty = operator.endswith("1")
    distinct = operator == "iseq"

    def test(frame: Frame, value: Any) -> bool:
        if isinstance(value, Carrier):
            value = value.listed()
        if nonempty and not value:
            return False
        if distinct and len(set(value)) != len(value):
            return False
        return all(item(frame, part) for part in value)

    return test


def _relation_member(evaluator: TermEvaluator, term: Apply, parts: Sequence[Member], scope: FrameScope) -> Member:
    first, second = parts
    total = term.operator in ("fun", "inj", "surj", "bij")
    injective = term.operator in ("pinj", "inj", "bij", "finj")
    onto = term.operator in ("psurj", "surj", "bij")
    domain = enumeration(evaluator, term.operands[0], scope) if total else None
    range_ = enumeration(evaluator, term.operands[1], scope) if onto else None

    def test(frame: Frame, value: Any) -> bool:
        if isinstance(value, Carrier):
            value = value.listed()
        items = value.items() if isinstance(value, Graph) else value
        if not all(first(frame, a) and second(frame, b) for a, b in items):
            return False
        if injective and len(set(value.values())) != len(value):
            return False
        if domain is not None and len(value) != sum(1 for _ in domain.code(frame)):
            return False
        return range_ is None or len(set(value.values())) == sum(1 for _ in range_.code(frame))

    return test


_MEMBERSHIP: Final[dict[str, MembershipRule]] = {
    "Bool": _anything,
    "Int": _anything,
    "Real": _anything,
    "Nat": _from(0),
    "Nat1": _from(1),
    "range": _range_member,
    "cross": _cross_member,
    "union": _combined_member(lambda a, b: a or b),
    "inter": _combined_member(lambda a, b: a and b),
    "diff": _combined_member(lambda a, b: a and not b),
    "All": _all_member,
    "Records": _records_member,
}


# --- enumeration -----------------------------------------------------------------------------------------------------


def enumeration(
    evaluator: TermEvaluator, term: Term, scope: FrameScope, inside: frozenset[str] = frozenset()
) -> Enumeration:
    """A way through the set that *term* is. *inside* are the free types being gone through already."""
    reading = evaluator.readings.of(term)
    if reading is not None:
        found = _by_reading(evaluator, term, reading, scope, inside)
    else:
        found = _enumeration(evaluator, term, scope, inside)
    if found.bounded and not free_variables(term):
        return _kept(found, term)
    return found


def _kept(found: Enumeration, term: Term) -> Enumeration:
    """The same for a set that is always the same: gone through once."""
    kept: list[list[Any]] = []

    def code(frame: Frame) -> list[Any]:
        if not kept:
            if found.at_least is not None and found.at_least(frame) > LARGEST:
                raise TooLarge(show_term(term), term.span)
            kept.append(capped(found.code(frame), term))
        return kept[0]

    return Enumeration(code, found.readings)


def _by_reading(
    evaluator: TermEvaluator, term: Term, reading: FiniteReading, scope: FrameScope, inside: frozenset[str]
) -> Enumeration:
    readings = evaluator.readings
    if reading.values is not None:
        test = membership(evaluator, term, scope)

        return Enumeration(lambda frame: [v for v in readings.values(reading) if test(frame, v)], (reading,))
    bound = reading.bound
    assert bound is not None
    if isinstance(term, Apply) and term.operator == "All":
        assert isinstance(term.type, core.SetType)
        kind = term.type.element
        if isinstance(kind, core.GivenType):
            name = kind.name

            elements = [Element(name, number) for number in range(1, bound + 1)]
            return Enumeration(lambda frame: elements, () if reading.whole else (reading,))
        if isinstance(kind, core.FreeType):
            return _nested(evaluator, kind.name, bound, reading, scope)
    if isinstance(term, Apply) and term.operator in COLLECTIONS:
        parts = [enumeration(evaluator, o, scope, inside) for o in term.operands]
        if all(part.bounded for part in parts):
            code = _collection(term.operator, parts, bound)
            return Enumeration(code, (reading, *_readings(parts)), True, _count(term.operator, parts, bound))
    return _enumeration(evaluator, term, scope, inside)


def _nested(evaluator: TermEvaluator, name: str, depth: int, reading: FiniteReading, scope: FrameScope) -> Enumeration:
    """The values of a free type that are built of at most so many constructors on top of each other."""
    definition = evaluator.specification.frees[name]
    used: list[FiniteReading] = [reading]

    def to_depth(levels: int) -> Callable[[Frame], list[Any]]:
        ways: list[tuple[int, str, Callable[[Frame], Iterable[Any]] | None]] = []
        for rank, (constructor, carrier) in enumerate(definition.branches):
            if carrier is None:
                ways.append((rank, constructor, None))
            elif levels > 1:
                inner = _Levels(evaluator, name, to_depth(levels - 1))
                way = inner.enumeration(carrier, scope)
                used.extend(way.readings)
                ways.append((rank, constructor, way.code))
        return lambda frame: [
            Construction(rank, constructor, argument)
            for rank, constructor, code in ways
            for argument in ((None,) if code is None else code(frame))
        ]

    code = to_depth(depth)
    return Enumeration(code, tuple({id(reading): reading for reading in used}.values()))


class _Levels:
    """Enumerates carriers in which a free type stands for its values of fewer levels."""

    def __init__(self, evaluator: TermEvaluator, name: str, smaller: Callable[[Frame], list[Any]]) -> None:
        self._evaluator = evaluator
        self._name = name
        self._smaller = smaller

    def enumeration(self, term: Term, scope: FrameScope) -> Enumeration:
        """A way through a carrier."""
        if isinstance(term, Apply):
            if term.operator == "All" and term.type == core.SetType(core.FreeType(self._name)):
                return Enumeration(self._smaller)
            if term.operator == "cross":
                return _product([self.enumeration(o, scope) for o in term.operands])
            reading = self._evaluator.readings.of(term)
            if term.operator in COLLECTIONS and reading is not None and reading.bound is not None:
                parts = [self.enumeration(o, scope) for o in term.operands]
                if all(part.bounded for part in parts):
                    code = _collection(term.operator, parts, reading.bound)
                    return Enumeration(code, (reading, *_readings(parts)))
        return enumeration(self._evaluator, term, scope, frozenset([self._name]))


def _readings(parts: Iterable[Enumeration]) -> tuple[FiniteReading, ...]:
    return tuple({id(reading): reading for part in parts for reading in part.readings}.values())


def _enumeration(evaluator: TermEvaluator, term: Term, scope: FrameScope, inside: frozenset[str]) -> Enumeration:
    """A way through a set of which there is no reading itself."""
    if isinstance(term, Comprehension) and term.kind == "set":
        from cspcheck.cspm.oz.values.binding import comprehension_enumeration

        return comprehension_enumeration(evaluator, term, scope)
    if isinstance(term, Apply):
        match term.operator:
            case "Bool":
                return Enumeration(lambda frame: (False, True))
            case "Int" | "Nat" | "Nat1" | "Real":
                return _nowhere(term)
            case "range":
                low, high = (evaluator.code(o, scope) for o in term.operands)
                return Enumeration(lambda frame: range(low(frame), high(frame) + 1))
            case "All":
                return _all(evaluator, term, scope, inside)
            case "Records":
                return _records(evaluator, term, scope, inside)
            case "cross":
                return _product([enumeration(evaluator, o, scope, inside) for o in term.operands])
            case "union":
                a, b = (enumeration(evaluator, o, scope, inside) for o in term.operands)
                return Enumeration(
                    lambda frame: in_order({*a.code(frame), *b.code(frame)}), _readings((a, b)), a.bounded and b.bounded
                )
            case "inter":
                return _filtered_either(evaluator, term, scope, inside)
            case "diff":
                kept = enumeration(evaluator, term.operands[0], scope, inside)
                without = membership(evaluator, term.operands[1], scope)
                return Enumeration(
                    lambda frame: [v for v in kept.code(frame) if not without(frame, v)], kept.readings, kept.bounded
                )
        if term.operator in COLLECTIONS:
            return _unlimited(term, [enumeration(evaluator, o, scope, inside) for o in term.operands])
    value = evaluator.code(term, scope)

    def elements(frame: Frame) -> Iterable[Any]:
        found = value(frame)
        return in_order(found) if type(found) is frozenset else found.listing()

    return Enumeration(elements)


def _filtered_either(evaluator: TermEvaluator, term: Apply, scope: FrameScope, inside: frozenset[str]) -> Enumeration:
    a, b = (enumeration(evaluator, o, scope, inside) for o in term.operands)
    through, other = (a, term.operands[1]) if a.exact or not b.exact else (b, term.operands[0])
    test = membership(evaluator, other, scope)
    return Enumeration(
        lambda frame: [v for v in through.code(frame) if test(frame, v)], through.readings, through.bounded
    )


def _product(parts: Sequence[Enumeration]) -> Enumeration:
    if not all(part.bounded for part in parts):
        return Enumeration(next(part.code for part in parts if not part.bounded), (), False)
    return Enumeration(lambda frame: product(*[part.code(frame) for part in parts]), _readings(parts))


def _all(evaluator: TermEvaluator, term: Apply, scope: FrameScope, inside: frozenset[str]) -> Enumeration:
    assert isinstance(term.type, core.SetType)
    kind = term.type.element
    if not isinstance(kind, core.FreeType) or kind.name in inside:
        return _nowhere(term)
    definition = evaluator.specification.frees[kind.name]
    parts: list[Enumeration | None] = [
        None if carrier is None else enumeration(evaluator, carrier, scope, inside | {kind.name})
        for _, carrier in definition.branches
    ]
    arguments = [part for part in parts if part is not None]
    if not all(part.bounded for part in arguments):
        return _product(arguments)

    def values(frame: Frame) -> list[Any]:
        return [
            Construction(rank, constructor, argument)
            for rank, ((constructor, _), part) in enumerate(zip(definition.branches, parts, strict=True))
            for argument in ((None,) if part is None else part.code(frame))
        ]

    return Enumeration(values, _readings(arguments))


def _records(evaluator: TermEvaluator, term: Apply, scope: FrameScope, inside: frozenset[str]) -> Enumeration:
    assert isinstance(term.type, core.SetType)
    kind = term.type.element
    assert isinstance(kind, core.RecordType)
    definition = evaluator.specification.records[kind.name]
    whole = _product([enumeration(evaluator, f.carrier, scope, inside) for f in definition.fields])
    if not whole.bounded or not definition.predicates:
        return whole
    test = evaluator.record_test(kind.name)
    return Enumeration(lambda frame: [value for value in whole.code(frame) if test(value)], whole.readings)


# --- collections -----------------------------------------------------------------------------------------------------


def _unlimited(term: Apply, parts: Sequence[Enumeration]) -> Enumeration:
    """A way through collections of which no reading gives the greatest size."""
    if not all(part.bounded for part in parts):
        return Enumeration(next(part.code for part in parts if not part.bounded), (), False)
    if term.operator in ("seq", "seq1", "bag"):
        return _nowhere(term)
    return Enumeration(
        _collection(term.operator, parts, None), _readings(parts), True, _count(term.operator, parts, None)
    )


def _collection(operator: str, parts: Sequence[Enumeration], bound: int | None) -> Callable[[Frame], Iterable[Any]]:
    """All collections of at most *bound* items."""
    if len(parts) == 1:
        (items,) = parts
        build = _OF_ITEMS[operator]
        return lambda frame: build(list(items.code(frame)), bound)
    first, second = parts
    if operator == "rel":
        return lambda frame: _subsets(list(product(first.code(frame), second.code(frame))), bound)
    return lambda frame: _graphs(operator, list(first.code(frame)), list(second.code(frame)), bound)


def _count(operator: str, parts: Sequence[Enumeration], bound: int | None) -> Callable[[Frame], int]:
    """How many collections there are at least."""

    def count(frame: Frame) -> int:
        sizes = [sum(1 for _ in part.code(frame)) for part in parts]
        first, last = sizes[0], sizes[-1]
        if operator == "rel":
            return _subset_count(first * last, bound)
        if len(parts) == 2:
            if operator in ("fun", "pfun", "ffun"):
                most = first if bound is None or operator == "fun" else min(first, bound)
                return 1 << most if last > 1 else 1
            if operator in ("inj", "pinj", "finj"):
                most = first if bound is None or operator == "inj" else min(first, bound)
                return perm(last, most) if most <= last else 1
            return 1
        if operator in ("seq", "seq1"):
            return 1 << (bound or 0) if first > 1 else 1
        if operator in ("iseq", "bag"):
            return 1
        return _subset_count(first, bound)

    return count


def _subset_count(items: int, bound: int | None) -> int:
    most = items if bound is None else min(items, bound)
    return comb(items, min(most, items // 2))


def _sizes(items: Sequence[Any], bound: int | None, low: int = 0) -> range:
    most = len(items) if bound is None else bound
    return range(low, most + 1)


def _sequences(items: list[Any], bound: int | None, low: int = 0) -> Iterator[tuple[Any, ...]]:
    return chain.from_iterable(product(items, repeat=size) for size in _sizes(items, bound, low))


def _subsets(items: list[Any], bound: int | None, low: int = 0) -> Iterator[frozenset[Any]]:
    sizes = range(low, min(len(items), len(items) if bound is None else bound) + 1)
    return (frozenset(chosen) for size in sizes for chosen in combinations(items, size))


def _bags(items: list[Any], bound: int | None) -> Iterator[Graph]:
    for size in _sizes(items, bound):
        for chosen in combinations_with_replacement(items, size):
            bag = Graph()
            for item in chosen:
                bag[item] = bag.get(item, 0) + 1
            yield bag


def _injective_sequences(items: list[Any], bound: int | None) -> Iterator[tuple[Any, ...]]:
    sizes = range(min(len(items), len(items) if bound is None else bound) + 1)
    return chain.from_iterable(permutations(items, size) for size in sizes)


_OF_ITEMS: Final[dict[str, Callable[[list[Any], int | None], Iterable[Any]]]] = {
    "seq": _sequences,
    "seq1": lambda items, bound: _sequences(items, bound, 1),
    "iseq": _injective_sequences,
    "bag": _bags,
    "power": _subsets,
    "finset": _subsets,
    "power1": lambda items, bound: _subsets(items, bound, 1),
    "finset1": lambda items, bound: _subsets(items, bound, 1),
}


def _graphs(operator: str, domain: list[Any], range_: list[Any], bound: int | None) -> Iterator[Graph]:
    injective = operator in ("pinj", "inj", "bij", "finj")
    onto = operator in ("psurj", "surj", "bij")
    total = operator in ("fun", "inj", "surj", "bij")
    most = len(domain) if bound is None or total else min(bound, len(domain))
    for size in range(len(domain) if total else 0, most + 1):
        for keys in combinations(domain, size):
            images = permutations(range_, size) if injective else product(range_, repeat=size)
            for image in images:
                if not onto or len(set(image)) == len(range_):
                    yield Graph(zip(keys, image, strict=True))


# --- carriers as values ----------------------------------------------------------------------------------------------


def carrier_value(evaluator: TermEvaluator, term: Apply, scope: FrameScope) -> Callable[[Frame], Any]:
    """Code for the value of a carrier: small finite ones are written out when they are gone through."""
    member, way = membership(evaluator, term, scope), enumeration(evaluator, term, scope)
    if term.operator == "Bool":
        return lambda frame: frozenset((False, True))

    def build(frame: Frame) -> Carrier:
        kept = list(frame)
        return Carrier(term, lambda value: member(kept, value), lambda: capped(way.code(kept), term), way.exact)

    return build
