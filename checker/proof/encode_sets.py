"""Formulas for sets and carriers: membership, candidates, values."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import z3

from cspcheck.checker.proof.encoding_rules import LARGEST_EXPANSION, candidates, membership, value
from cspcheck.checker.proof.one_point import is_universe
from cspcheck.checker.proof.sorts import Expr, Unsupported, element_of, selected
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Constant, Term

if TYPE_CHECKING:
    from cspcheck.checker.proof.encode import Encoder

_LARGEST_RANGE = 64

# --- membership ------------------------------------------------------------------------------------------------------


@membership("Int", "Real", "Bool", "All", "AllRecords")
def _in_type(e: Encoder, x: Expr, term: Apply) -> Expr:
    return e.sorts.truth(True)


@membership("Nat")
def _in_nat(e: Encoder, x: Expr, term: Apply) -> Expr:
    return x >= 0


@membership("Nat1")
def _in_nat1(e: Encoder, x: Expr, term: Apply) -> Expr:
    return x >= 1


@membership("Records")
def _in_records(e: Encoder, x: Expr, term: Apply) -> Expr:
    type_ = element_of(term)
    assert isinstance(type_, core.RecordType)
    definition = e.sorts.record(type_)
    if definition is None:
        return e.sorts.truth(True)
    table = {(name, "bound"): e.sorts.part(type_, x, i) for i, (name, _) in enumerate(type_.fields)}
    with e.bound(table, opened=False):
        inside = [e.member(table[field.name, "bound"], field.carrier) for field in definition.fields]
        return e.all([*inside, *[e.term(part) for part in definition.predicates]])


@membership("range")
def _in_range(e: Encoder, x: Expr, term: Apply) -> Expr:
    low, high = term.operands
    return z3.And(e.term(low) <= x, x <= e.term(high))


@membership("union")
def _in_union(e: Encoder, x: Expr, term: Apply) -> Expr:
    return e.any(e.member(x, operand) for operand in term.operands)


@membership("inter")
def _in_inter(e: Encoder, x: Expr, term: Apply) -> Expr:
    return e.all(e.member(x, operand) for operand in term.operands)


@membership("diff")
def _in_diff(e: Encoder, x: Expr, term: Apply) -> Expr:
    return z3.And(e.member(x, term.operands[0]), z3.Not(e.member(x, term.operands[1])))


@membership("symdiff")
def _in_symdiff(e: Encoder, x: Expr, term: Apply) -> Expr:
    return z3.Xor(e.member(x, term.operands[0]), e.member(x, term.operands[1]))


@membership("Union")
def _in_bigunion(e: Encoder, x: Expr, term: Apply) -> Expr:
    sets = term.operands[0]
    values = e.candidates(sets)
    return e.exists(element_of(sets), lambda s: z3.And(e.member(s, sets), selected(s, x)), values)


@membership("Inter")
def _in_biginter(e: Encoder, x: Expr, term: Apply) -> Expr:
    sets = term.operands[0]
    values = e.candidates(sets)
    return e.forall(element_of(sets), lambda s: z3.Implies(e.member(s, sets), selected(s, x)), values)


@membership("power", "power1", "finset", "finset1")
def _in_power(e: Encoder, x: Expr, term: Apply) -> Expr:
    carrier = term.operands[0]
    element = element_of(carrier)
    values = e.list_of(x)
    parts = []
    if not is_universe(carrier):
        parts.append(e.forall(element, lambda y: z3.Implies(selected(x, y), e.member(y, carrier)), values))
    if term.operator.endswith("1"):
        parts.append(e.exists(element, lambda y: selected(x, y), values))
    if term.operator.startswith("fin"):
        parts.append(finite_array(e, x, core.SetType(element), values))
    return e.all(parts)


@membership("cross")
def _in_cross(e: Encoder, x: Expr, term: Apply) -> Expr:
    type_ = element_of(term)
    return e.all(e.member(e.sorts.part(type_, x, i), operand) for i, operand in enumerate(term.operands))


@membership("id")
def _in_id(e: Encoder, x: Expr, term: Apply) -> Expr:
    type_ = element_of(term)
    first, second = (e.sorts.part(type_, x, i) for i in range(2))
    return z3.And(first == second, e.member(first, term.operands[0]))


# --- candidates ------------------------------------------------------------------------------------------------------


@candidates("set")
def _display_candidates(e: Encoder, term: Apply) -> list[Expr]:
    return [e.term(operand) for operand in term.operands]


@candidates("range")
def _range_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    low, high = least(e, term.operands[0]), greatest(e, term.operands[1])
    if low is None or high is None or high - low >= _LARGEST_RANGE:
        return None
    return [e.sorts.whole(i) for i in range(low, high + 1)]


@candidates("union", "symdiff")
def _union_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    lists = [e.candidates(operand) for operand in term.operands]
    found: list[Expr] = []
    for values in lists:
        if values is None:
            return None
        found += values
    return found


@candidates("inter")
def _inter_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    lists = [values for values in map(e.candidates, term.operands) if values is not None]
    return min(lists, key=len, default=None)


@candidates("diff")
def _diff_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    return e.candidates(term.operands[0])


@candidates("cross")
def _cross_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    return e._products(element_of(term), [e.candidates(operand) for operand in term.operands])


@candidates("id")
def _id_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    values = e.candidates(term.operands[0])
    return None if values is None else [e.sorts.make(element_of(term), [v, v]) for v in values]


@candidates("power", "finset", "power1", "finset1")
def _power_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    values = e.candidates(term.operands[0])
    if values is None or 2 ** len(values) > LARGEST_EXPANSION:
        return None
    sort = e.sorts.sort(element_of(term.operands[0]))
    found = []
    for size in range(len(values) + 1):
        for chosen in combinations(values, size):
            array = z3.K(sort, e.sorts.truth(False))
            for element in chosen:
                array = z3.Store(array, element, e.sorts.truth(True))
            found.append(e.listed(array, list(chosen)))
    return found


def least(e: Encoder, term: Term) -> int | None:
    """A number that an integer term is never below."""
    match term:
        case Constant(value=value):
            return int(value)
        case Apply(operator="length" | "card" | "count"):
            return 0
        case Apply(operator="plus", operands=(left, right)):
            return _sum(least(e, left), least(e, right))
        case Apply(operator="minus", operands=(left, right)):
            high = greatest(e, right)
            return _sum(least(e, left), None if high is None else -high)
        case Apply(operator="negate", operands=(inner,)):
            high = greatest(e, inner)
            return None if high is None else -high
    return None


def greatest(e: Encoder, term: Term) -> int | None:
    """A number that an integer term is never above."""
    from cspcheck.checker.proof.encode_sequences import longest

    match term:
        case Constant(value=value):
            return int(value)
        case Apply(operator="length", operands=(sequence,)):
            return longest(e, sequence)
        case Apply(operator="card", operands=(collection,)):
            values = e.candidates(collection)
            return None if values is None else len(values)
        case Apply(operator="plus", operands=(left, right)):
            return _sum(greatest(e, left), greatest(e, right))
        case Apply(operator="minus", operands=(left, right)):
            low = least(e, right)
            return _sum(greatest(e, left), None if low is None else -low)
        case Apply(operator="negate", operands=(inner,)):
            low = least(e, inner)
            return None if low is None else -low
    return None


def _sum(left: int | None, right: int | None) -> int | None:
    return None if left is None or right is None else left + right


# --- values ----------------------------------------------------------------------------------------------------------


@membership("set")
def _in_display(e: Encoder, x: Expr, term: Apply) -> Expr:
    return e.any(x == e.term(operand) for operand in term.operands)


@value("set")
def _display(e: Encoder, term: Apply) -> Expr:
    assert isinstance(term.type, core.SetType)
    array = z3.K(e.sorts.sort(term.type.element), e.sorts.truth(False))
    values = [e.term(operand) for operand in term.operands]
    for element in values:
        array = z3.Store(array, element, e.sorts.truth(True))
    return e.listed(array, values)


@value("subset", "proper_subset")
def _subset(e: Encoder, term: Apply) -> Expr:
    left, right = term.operands
    inside = _included(e, left, right)
    if term.operator == "subset":
        return inside
    return z3.And(inside, z3.Not(_included(e, right, left)))


def _included(e: Encoder, left: Term, right: Term) -> Expr:
    element = element_of(left)
    return e.forall(element, lambda x: z3.Implies(e.member(x, left), e.member(x, right)), e.candidates(left))


@value("disjoint")
def _disjoint(e: Encoder, term: Apply) -> Expr:
    return e.all(_apart(e, one, other) for one, other in combinations(term.operands, 2))


def _apart(e: Encoder, one: Term, other: Term) -> Expr:
    both = [values for values in (e.candidates(one), e.candidates(other)) if values is not None]
    few = min(both, key=len, default=None)
    return e.forall(element_of(one), lambda x: z3.Not(z3.And(e.member(x, one), e.member(x, other))), few)


@value("partition")
def _partition(e: Encoder, term: Apply) -> Expr:
    whole, *parts = term.operands
    pairs = [_apart(e, one, other) for one, other in combinations(parts, 2)]
    inside = [_included(e, part, whole) for part in parts]
    covered = e.forall(
        element_of(whole),
        lambda x: z3.Implies(e.member(x, whole), e.any(e.member(x, part) for part in parts)),
        e.candidates(whole),
    )
    return e.all([*pairs, *inside, covered])


@value("card")
def _card(e: Encoder, term: Apply) -> Expr:
    return cardinality(e, term.operands[0])


def cardinality(e: Encoder, collection: Term) -> Expr:
    """The number of elements of a set."""
    sorts = e.sorts
    match collection:
        case core.If(test=test, then=then, otherwise=otherwise):
            return z3.If(e.term(test), cardinality(e, then), cardinality(e, otherwise))
        case Apply(operator="dom" as operator, operands=(core.If(test=test, then=then, otherwise=otherwise),)):
            branches = [Apply(type=collection.type, operator=operator, operands=(b,)) for b in (then, otherwise)]
            return z3.If(e.term(test), *[cardinality(e, branch) for branch in branches])
        case Apply(operator="range", operands=(low, high)):
            first, last = e.term(low), e.term(high)
            return z3.If(first <= last, last - first + 1, 0)
        case Apply(operator="function_to_relation", operands=(function,)):
            domain = core.SetType(_domain_type(function))
            return cardinality(e, Apply(type=domain, operator="dom", operands=(function,)))
        case Apply(operator="dom", operands=(Apply(operator="sequence_to_function", operands=(sequence,)),)):
            type_ = sequence.type
            assert isinstance(type_, core.SequenceType)
            return sorts.length(type_, e.term(sequence))
        case Apply(operator="dom", operands=(Apply(operator="override", operands=(old, new)),)):
            type_ = collection.type
            domains = [Apply(type=type_, operator="dom", operands=(part,)) for part in (old, new)]
            return cardinality(e, Apply(type=type_, operator="union", operands=tuple(domains)))
        case Apply(operator="dom", operands=(Apply(operator="function", operands=pairs),)):
            from cspcheck.checker.proof.encode_functions import first_of

            elements = tuple(first_of(pair) for pair in pairs)
            return cardinality(e, Apply(type=collection.type, operator="set", operands=elements))
        case Apply(operator="dom", operands=(Apply(operator="dom_subtract", operands=(removed, old)),)):
            type_ = collection.type
            domain_term = Apply(type=type_, operator="dom", operands=(old,))
            return cardinality(e, Apply(type=type_, operator="diff", operands=(domain_term, removed)))
    values = e.candidates(collection)
    if values is not None and len(values) <= LARGEST_EXPANSION:
        return _counted(e, collection, values)
    match collection:
        case Apply(operator="union", operands=(left, right)):
            for base, extra in ((left, right), (right, left)):
                values = e.candidates(extra)
                if values is not None and len(values) <= LARGEST_EXPANSION:
                    return cardinality(e, base) + _counted(e, extra, values, outside=base)
        case Apply(operator="diff", operands=(base, extra)):
            values = e.candidates(extra)
            if values is not None and len(values) <= LARGEST_EXPANSION:
                return cardinality(e, base) - _counted(e, extra, values, inside=base)
    return _measured(e, collection)


def _domain_type(function: Term) -> core.Type:
    assert isinstance(function.type, core.FunctionType)
    return function.type.domain


def _counted(
    e: Encoder, collection: Term, values: list[Expr], *, outside: Term | None = None, inside: Term | None = None
) -> Expr:
    """How many of the candidates are in a set (and not in *outside*, and in *inside*), equal ones once."""
    total = e.sorts.whole(0)
    for i, element in enumerate(values):
        conditions = [e.member(element, collection), *[element != earlier for earlier in values[:i]]]
        if outside is not None:
            conditions.append(z3.Not(e.member(element, outside)))
        if inside is not None:
            conditions.append(e.member(element, inside))
        total = total + z3.If(e.all(conditions), e.sorts.whole(1), e.sorts.whole(0))
    return total


def _measured(e: Encoder, collection: Term) -> Expr:
    """A cardinality as an uninterpreted function of the set, with facts."""
    type_ = collection.type
    array = e.term(collection)
    sort = e.sorts.sort(type_)
    number = e.function("card", type_, sort, z3.IntSort(e.sorts.context))(array)
    e.approximated.add("card")
    assert isinstance(type_, core.SetType)
    empty = z3.K(e.sorts.sort(type_.element), e.sorts.truth(False))
    e.fact(number >= 0)
    e.fact((number == 0) == (array == empty))
    for other_type, other, size in e.measured:
        if other_type == type_ and not other.eq(array):
            for small, large, few, many in ((array, other, number, size), (other, array, size, number)):
                inside = z3.IsSubset(small, large)
                e.fact(z3.Implies(inside, z3.And(few <= many, z3.Implies(few == many, small == large))))
    e.measured.append((type_, array, number))
    return number


def finite_array(e: Encoder, array: Expr, type_: core.SetType, values: list[Expr] | None) -> Expr:
    """That a set given as an array is finite."""
    if values is not None or e.enumeration(type_.element) is not None:
        return e.sorts.truth(True)
    e.approximated.add("finset")
    predicate = e.function("finite", type_, e.sorts.sort(type_), z3.BoolSort(e.sorts.context))
    return predicate(array)


def finite(e: Encoder, term: Term) -> Expr:
    """That a set is finite, by the way that it is written."""
    from cspcheck.checker.proof import encode_functions

    assert isinstance(term.type, core.SetType)
    if e.candidates(term) is not None:
        return e.sorts.truth(True)
    match term:
        case Apply(operator="range" | "set"):
            return e.sorts.truth(True)
        case Apply(operator="Int" | "Nat" | "Nat1" | "Real"):
            return e.sorts.truth(False)
    opaque = finite_array(e, e.term(term), term.type, None)
    match term:
        case Apply(operator="union", operands=operands):
            both = e.all(finite(e, operand) for operand in operands)
            e.fact(opaque == both)
            return both
        case Apply(operator="inter", operands=operands):
            reason = e.any(finite(e, operand) for operand in operands)
            e.fact(z3.Implies(reason, opaque))
            return z3.Or(reason, opaque)  # what is a fact is not told of bound variables
        case Apply(operator="diff", operands=(base, _)):
            reason = finite(e, base)
            e.fact(z3.Implies(reason, opaque))
            return z3.Or(reason, opaque)
        case Apply(operator="dom" | "ran" | "image" | "function_to_relation" as operator, operands=(inner, *_)):
            reason = encode_functions.finite(e, inner)
            same = operator in ("dom", "function_to_relation") and encode_functions.is_function(inner)
            e.fact(opaque == reason if same else z3.Implies(reason, opaque))
        case core.If():
            e.fact(opaque == z3.If(e.term(term.test), finite(e, term.then), finite(e, term.otherwise)))
        case core.Comprehension(binders=(binder,)):
            e.fact(z3.Implies(finite(e, binder.carrier), opaque))
    return opaque


def _some_closure(e: Encoder, term: Apply, pair: core.TupleType) -> Expr:
    """The closure as an uninterpreted function: a transitive relation that contains the given one.

    That it is the least one no formula of first order says.
    """
    if e.scope is not None:
        raise Unsupported("the closure of a large relation")
    relation = term.operands[0]
    sort, element = e.sorts.sort(term.type), e.sorts.sort(pair.items[0])
    array = e.term(relation)
    closed = e.function(term.operator, term.type, sort, sort)(array)
    e.approximated.add(term.operator)
    x, y, z = (z3.Const(f"{name}%{len(e.facts)}c", element) for name in "xyz")

    def related(formula: Expr, a: Expr, b: Expr) -> Expr:
        return selected(formula, e.sorts.make(pair, [a, b]))

    e.fact(z3.ForAll([x, y], z3.Implies(related(array, x, y), related(closed, x, y))))
    both = z3.And(related(closed, x, y), related(closed, y, z))
    e.fact(z3.ForAll([x, y, z], z3.Implies(both, related(closed, x, z))))
    if term.operator == "reflexive_closure":
        in_field = z3.Or(related(array, x, y), related(array, y, x))
        e.fact(z3.ForAll([x, y], z3.Implies(in_field, related(closed, x, x))))
    return closed


@value("closure", "reflexive_closure")
def _closure(e: Encoder, term: Apply) -> Expr:
    """The transitive closure of a relation on a small finite type: enough compositions, by squaring."""
    relation = term.operands[0]
    pair = element_of(relation)
    assert isinstance(pair, core.TupleType)
    values = e.enumeration(pair.items[0])
    if values is None:
        pairs = e.candidates(relation)
        if pairs is None:
            return _some_closure(e, term, pair)
        values = [e.sorts.part(pair, p, side) for p in pairs for side in range(2)]
    if len(values) > 16:
        return _some_closure(e, term, pair)
    steps = [[e.member(e.sorts.make(pair, [a, b]), relation) for b in values] for a in values]
    same = [[a == b for b in values] for a in values]
    size = len(values)
    reach = steps
    for _ in range(max(1, size - 1).bit_length()):
        linked = [
            [e.any([z3.And(reach[i][k], reach[k][j]) for k in range(size)]) for j in range(size)] for i in range(size)
        ]
        reach = [[z3.Or(reach[i][j], linked[i][j]) for j in range(size)] for i in range(size)]
    reflexive = term.operator == "reflexive_closure"

    def inside(x: Expr) -> Expr:
        first, second = (e.sorts.part(pair, x, side) for side in range(2))
        cases = []
        for i, a in enumerate(values):
            for j, b in enumerate(values):
                there = reach[i][j]
                if reflexive:
                    in_field = e.any([z3.Or(steps[i][k], steps[k][i]) for k in range(size)])
                    there = z3.Or(there, z3.And(same[i][j], in_field))
                cases.append(z3.And(first == a, second == b, there))
        return e.any(cases)

    return e.lambda_("p", pair, inside)
