"""Formulas for sequences (a length and an array) and bags (an array of counts)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import z3

from cspcheck.checker.proof.encoding_rules import membership, value
from cspcheck.checker.proof.one_point import is_universe
from cspcheck.checker.proof.sorts import Expr, Unsupported, element_of, selected
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Term

if TYPE_CHECKING:
    from cspcheck.checker.proof.encode import Encoder


def _type(term: Term) -> core.SequenceType:
    assert isinstance(term.type, core.SequenceType)
    return term.type


def longest(e: Encoder, term: Term) -> int | None:
    """A length that a sequence never exceeds, None where none is known."""
    match term:
        case Apply(operator="sequence", operands=items):
            return len(items)
        case Apply(operator="concat", operands=(left, right)):
            lengths = longest(e, left), longest(e, right)
            return None if lengths[0] is None or lengths[1] is None else lengths[0] + lengths[1]
        case Apply(operator="tail" | "front", operands=(inner,)):
            length = longest(e, inner)
            return None if length is None else max(0, length - 1)
        case Apply(operator="rev", operands=(inner,)) | Apply(operator="filter", operands=(inner, _)):
            return longest(e, inner)
        case Apply(operator="extract", operands=(_, inner)):
            return longest(e, inner)
        case Apply(operator="flatten", operands=(Apply(operator="sequence", operands=parts),)):
            lengths_ = [longest(e, part) for part in parts]
            return None if any(n is None for n in lengths_) else sum(n for n in lengths_ if n is not None)
        case core.If():
            lengths = longest(e, term.then), longest(e, term.otherwise)
            return None if lengths[0] is None or lengths[1] is None else max(lengths[0], lengths[1])
        case core.Variable(role="bound"):
            found = e.values.get((term.name, term.role))
            return None if found is None else e.bound_of(found)
    if e.scope is None:
        return None
    if isinstance(term, Apply) and term.operator not in ("apply", "head", "last", "item"):
        return None
    known = e.bound_of(e.term(term))
    if known is None and isinstance(term, core.Variable | core.Field):
        return None
    return known


def _parts(e: Encoder, term: Term) -> tuple[Expr, Expr]:
    """Length and array of a sequence."""
    formula = e.term(term)
    return e.sorts.length(_type(term), formula), e.sorts.items(_type(term), formula)


def _by_position(
    e: Encoder, type_: core.SequenceType, length: Expr, item: Callable[[Expr], Expr], bound: int | None
) -> Expr:
    """A sequence by its length and what stands at each position inside it; *bound* is the greatest length."""
    junk = e.sorts.junk(type_.element)
    if bound is not None and e.scope is not None:
        array = z3.K(z3.IntSort(e.sorts.context), junk)
        for position in range(1, bound + 1):
            i = e.sorts.whole(position)
            array = z3.Store(array, i, z3.If(length >= i, item(i), junk))
        return e.bounded(e.sorts.sequence(type_, length, array), bound)

    def entry(i: Expr) -> Expr:
        return z3.If(z3.And(i >= 1, i <= length), item(i), junk)

    return e.sorts.sequence(type_, length, e.lambda_("i", core.INT, entry))


def _empty(e: Encoder, type_: core.SequenceType) -> Expr:
    junk = e.sorts.junk(type_.element)
    return e.sorts.sequence(type_, e.sorts.whole(0), z3.K(z3.IntSort(e.sorts.context), junk))


# --- carriers --------------------------------------------------------------------------------------------------------


@membership("seq", "seq1", "iseq")
def _in_sequences(e: Encoder, x: Expr, term: Apply) -> Expr:
    carrier = term.operands[0]
    type_ = element_of(term)
    assert isinstance(type_, core.SequenceType)
    length, items = e.sorts.length(type_, x), e.sorts.items(type_, x)
    bound = e.bound_of(x)
    indices = None if bound is None else [e.sorts.whole(i) for i in range(1, bound + 1)]

    def within(i: Expr) -> Expr:
        return z3.And(i >= 1, i <= length)

    parts = [] if term.operator != "seq1" else [length >= 1]
    if not is_universe(carrier):
        parts.append(
            e.forall(core.INT, lambda i: z3.Implies(within(i), e.member(selected(items, i), carrier)), indices)
        )
    if term.operator == "iseq":
        parts.append(
            e.forall(
                core.INT,
                lambda i: e.forall(
                    core.INT,
                    lambda j: z3.Implies(z3.And(i >= 1, i < j, j <= length), selected(items, i) != selected(items, j)),
                    indices,
                ),
                indices,
            )
        )
    return e.all(parts)


@membership("bag")
def _in_bags(e: Encoder, x: Expr, term: Apply) -> Expr:
    carrier = term.operands[0]
    if is_universe(carrier):
        return e.sorts.truth(True)
    element = element_of(carrier)
    return e.forall(element, lambda y: z3.Implies(selected(x, y) > 0, e.member(y, carrier)), e.list_of(x))


# --- sequences -------------------------------------------------------------------------------------------------------


@value("sequence")
def _sequence(e: Encoder, term: Apply) -> Expr:
    type_ = _type(term)
    array = z3.K(z3.IntSort(e.sorts.context), e.sorts.junk(type_.element))
    for i, operand in enumerate(term.operands, 1):
        array = z3.Store(array, e.sorts.whole(i), e.term(operand))
    return e.sorts.sequence(type_, e.sorts.whole(len(term.operands)), array)


@value("length")
def _length(e: Encoder, term: Apply) -> Expr:
    return _parts(e, term.operands[0])[0]


@value("concat")
def _concat(e: Encoder, term: Apply) -> Expr:
    left, right = term.operands
    type_ = _type(term)
    first, items = _parts(e, left)
    if e.scope is None and isinstance(right, Apply) and right.operator == "sequence":
        array = items
        for offset, operand in enumerate(right.operands, 1):
            array = z3.Store(array, first + offset, e.term(operand))
        return e.sorts.sequence(type_, first + len(right.operands), array)
    second, others = _parts(e, right)

    def item(i: Expr) -> Expr:
        return z3.If(i <= first, selected(items, i), selected(others, i - first))

    return _by_position(e, type_, first + second, item, longest(e, term))


@value("head")
def _head(e: Encoder, term: Apply) -> Expr:
    _, items = _parts(e, term.operands[0])
    return selected(items, e.sorts.whole(1))


@value("last")
def _last(e: Encoder, term: Apply) -> Expr:
    length, items = _parts(e, term.operands[0])
    return selected(items, length)


def _shorter(length: Expr) -> Expr:
    return z3.If(length >= 1, length - 1, length)


def _next(e: Encoder, i: Expr) -> Expr:
    return e.sorts.whole(i.as_long() + 1) if z3.is_int_value(i) else i + 1


@value("tail")
def _tail(e: Encoder, term: Apply) -> Expr:
    length, items = _parts(e, term.operands[0])
    return _by_position(e, _type(term), _shorter(length), lambda i: selected(items, _next(e, i)), longest(e, term))


@value("front")
def _front(e: Encoder, term: Apply) -> Expr:
    length, items = _parts(e, term.operands[0])
    return _by_position(e, _type(term), _shorter(length), lambda i: selected(items, i), longest(e, term))


@value("rev")
def _rev(e: Encoder, term: Apply) -> Expr:
    length, items = _parts(e, term.operands[0])
    return _by_position(e, _type(term), length, lambda i: selected(items, length + 1 - i), longest(e, term))


@value("prefix", "suffix", "infix")
def _part_of(e: Encoder, term: Apply) -> Expr:
    part, whole = term.operands
    few, ours = _parts(e, part)
    many, theirs = _parts(e, whole)
    bound = longest(e, part)
    indices = None if bound is None else [e.sorts.whole(i) for i in range(1, bound + 1)]

    def at(offset: Expr) -> Expr:
        def same(i: Expr) -> Expr:
            return z3.Implies(z3.And(i >= 1, i <= few), selected(ours, i) == selected(theirs, i + offset))

        return z3.And(offset >= 0, offset + few <= many, e.forall(core.INT, same, indices))

    if term.operator == "prefix":
        return at(e.sorts.whole(0))
    if term.operator == "suffix":
        return at(many - few)
    room = longest(e, whole)
    return e.exists(core.INT, at, None if room is None else [e.sorts.whole(i) for i in range(room + 1)])


def _folded(
    e: Encoder, type_: core.SequenceType, length: Expr, items: Expr, bound: int, keep: Callable[[Expr, Expr], Expr]
) -> Expr:
    """The items that *keep* accepts by position and value, in order, of a sequence of at most *bound* items."""
    result_length = e.sorts.whole(0)
    array = z3.K(z3.IntSort(e.sorts.context), e.sorts.junk(type_.element))
    for i in range(1, bound + 1):
        position = e.sorts.whole(i)
        item = selected(items, position)
        kept = z3.And(length >= i, keep(position, item))
        array = z3.If(kept, z3.Store(array, result_length + 1, item), array)
        result_length = z3.If(kept, result_length + 1, result_length)
    return e.sorts.sequence(type_, result_length, array)


@value("filter", "extract")
def _filter(e: Encoder, term: Apply) -> Expr:
    type_ = _type(term)
    by_value = term.operator == "filter"
    sequence, chosen = term.operands if by_value else (term.operands[1], term.operands[0])
    length, items = _parts(e, sequence)

    def keep(position: Expr, item: Expr) -> Expr:
        return e.member(item if by_value else position, chosen)

    bound = longest(e, sequence)
    if bound is not None:
        return _folded(e, type_, length, items, bound, keep)
    set_sort = e.sorts.sort(chosen.type)
    function = e.function(term.operator, type_, e.sorts.sort(type_), set_sort, e.sorts.sort(type_))
    result = function(e.term(sequence), e.term(chosen))
    e.approximated.add(term.operator)
    e.fact(e.shaped(result, type_))
    e.fact(e.sorts.length(type_, result) <= length)
    inner = e.sorts.items(type_, result)
    if by_value:
        e.fact(
            e.forall(
                core.INT,
                lambda i: z3.Implies(
                    z3.And(i >= 1, i <= e.sorts.length(type_, result)), e.member(selected(inner, i), chosen)
                ),
            )
        )
    return result


@value("squash")
def _squash(e: Encoder, term: Apply) -> Expr:
    """An uninterpreted function of the right length; what it is more laws say."""
    from cspcheck.checker.proof.encode_sets import cardinality

    if e.scope is not None:
        raise Unsupported("`squash`")
    function, type_ = term.operands[0], _type(term)
    result = e.function("squash", type_, e.sorts.sort(function.type), e.sorts.sort(type_))(e.term(function))
    e.approximated.add("squash")
    e.fact(e.shaped(result, type_))
    domain = Apply(type=core.SetType(core.INT), operator="dom", operands=(function,))
    e.fact(e.sorts.length(type_, result) == cardinality(e, domain))
    return result


@value("flatten")
def _flatten(e: Encoder, term: Apply) -> Expr:
    outer = term.operands[0]
    type_ = _type(term)
    if isinstance(outer, Apply) and outer.operator == "sequence":
        result: Term = Apply(type=type_, operator="sequence")
        for part in outer.operands:
            result = Apply(type=type_, operator="concat", operands=(result, part))
        return e.term(result)
    raise Unsupported("`flatten` of a sequence that is not written out")


# --- bags ------------------------------------------------------------------------------------------------------------


def _bag_type(term: Term) -> core.BagType:
    assert isinstance(term.type, core.BagType)
    return term.type


@value("bag_display")
def _bag_display(e: Encoder, term: Apply) -> Expr:
    array = z3.K(e.sorts.sort(_bag_type(term).element), e.sorts.whole(0))
    values = [e.term(operand) for operand in term.operands]
    for element in values:
        array = z3.Store(array, element, selected(array, element) + 1)
    return e.listed(array, values)


@value("count")
def _count(e: Encoder, term: Apply) -> Expr:
    bag, element = term.operands
    return selected(e.term(bag), e.term(element))


@value("in_bag")
def _in_bag(e: Encoder, term: Apply) -> Expr:
    element, bag = term.operands
    return selected(e.term(bag), e.term(element)) > 0


@value("bag_union")
def _bag_union(e: Encoder, term: Apply) -> Expr:
    left, right = (e.term(operand) for operand in term.operands)
    formula = e.lambda_("x", _bag_type(term).element, lambda x: selected(left, x) + selected(right, x))
    lists = e.list_of(left), e.list_of(right)
    return formula if lists[0] is None or lists[1] is None else e.listed(formula, [*lists[0], *lists[1]])


@value("items")
def _items(e: Encoder, term: Apply) -> Expr:
    sequence = term.operands[0]
    type_ = _bag_type(term)
    length, items = _parts(e, sequence)
    bound = longest(e, sequence)
    if bound is None:
        function = e.function("items", type_, e.sorts.sort(sequence.type), e.sorts.sort(type_))
        e.approximated.add("items")
        result = function(e.term(sequence))
        e.fact(e.shaped(result, type_))
        return result
    array = z3.K(e.sorts.sort(type_.element), e.sorts.whole(0))
    values = [selected(items, e.sorts.whole(i)) for i in range(1, bound + 1)]
    for i, element in enumerate(values, 1):
        array = z3.If(length >= i, z3.Store(array, element, selected(array, element) + 1), array)
    return e.listed(array, values)
