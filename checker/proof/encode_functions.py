"""Formulas for relations (sets of pairs) and functions (arrays of options)."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import TYPE_CHECKING

import z3

from cspcheck.checker.proof.encode_sets import finite as finite_set
from cspcheck.checker.proof.encoding_rules import LARGEST_EXPANSION, candidates, membership, value
from cspcheck.checker.proof.one_point import is_universe
from cspcheck.checker.proof.sorts import Expr, Unsupported, element_of, selected
from cspcheck.checker.proof.terms import integer
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Term

if TYPE_CHECKING:
    from cspcheck.checker.proof.encode import Encoder


def is_function(term: Term) -> bool:
    """Whether a term is a function, not a relation."""
    return isinstance(term.type, core.FunctionType)


def function_type(term: Term) -> core.FunctionType:
    """The type of a function."""
    assert isinstance(term.type, core.FunctionType)
    return term.type


def first_of(pair: Term) -> Term:
    """The first component of a pair."""
    return _side(pair, 0)


def second_of(pair: Term) -> Term:
    """The second component of a pair."""
    return _side(pair, 1)


def _side(pair: Term, index: int) -> Term:
    if isinstance(pair, Apply) and pair.operator == "tuple":
        return pair.operands[index]
    assert isinstance(pair.type, core.TupleType)
    return Apply(type=pair.type.items[index], operator="item", operands=(pair, integer(index)))


def keys(e: Encoder, function: Term) -> list[Expr] | None:
    """Values among which all arguments of a function are."""
    match function:
        case Apply(operator="function", operands=pairs):
            return [e.term(first_of(pair)) for pair in pairs]
        case Apply(operator="override", operands=(old, new)):
            lists = [keys(e, old), keys(e, new)]
            return None if lists[0] is None or lists[1] is None else [*lists[0], *lists[1]]
        case Apply(operator="dom_restrict", operands=(kept, inner)):
            few = [found for found in (e.candidates(kept), keys(e, inner)) if found is not None]
            return min(few, key=len, default=None)
        case Apply(operator="dom_subtract", operands=(_, inner)):
            return keys(e, inner)
        case Apply(operator="ran_restrict" | "ran_subtract" | "compose"):
            inner = function.operands[0]
            return keys(e, inner)
        case Apply(operator="sequence_to_function", operands=(sequence,)):
            from cspcheck.checker.proof.encode_sequences import longest

            length = longest(e, sequence)
            return None if length is None else [e.sorts.whole(i) for i in range(1, length + 1)]
        case core.Comprehension(kind="lambda", binders=(binder,)):
            return e.candidates(binder.carrier)
        case core.If():
            lists = [keys(e, function.then), keys(e, function.otherwise)]
            return None if lists[0] is None or lists[1] is None else [*lists[0], *lists[1]]
    if e.scope is not None and not isinstance(function, Apply):
        found = e.list_of(e.term(function))
        if found is not None:
            return found
    return e.enumeration(function_type(function).domain)


# --- carriers --------------------------------------------------------------------------------------------------------

_TOTAL = ("fun", "inj", "surj", "bij")
_INJECTIVE = ("pinj", "inj", "bij", "finj")
_SURJECTIVE = ("psurj", "surj", "bij")
_FINITE = ("ffun", "finj")


@membership("rel")
def _in_rel(e: Encoder, x: Expr, term: Apply) -> Expr:
    left, right = term.operands
    if is_universe(left) and is_universe(right):
        return e.sorts.truth(True)
    relation = element_of(term)
    assert isinstance(relation, core.SetType)
    pair = relation.element

    def inside(p: Expr) -> Expr:
        sides = [e.member(e.sorts.part(pair, p, i), c) for i, c in enumerate((left, right))]
        return z3.Implies(selected(x, p), e.all(sides))

    return e.forall(pair, inside, e.list_of(x))


@membership("pfun", "fun", "pinj", "inj", "psurj", "surj", "bij", "ffun", "finj")
def _in_functions(e: Encoder, x: Expr, term: Apply) -> Expr:
    domain, range_ = term.operands
    type_ = element_of(term)
    assert isinstance(type_, core.FunctionType)
    sorts = e.sorts
    arguments = e.list_of(x)
    kind = term.operator

    def there(a: Expr) -> Expr:
        return sorts.is_some(type_, selected(x, a))

    def result(a: Expr) -> Expr:
        return sorts.value(type_, selected(x, a))

    parts = []
    if not (is_universe(domain) and is_universe(range_)):
        parts.append(
            e.forall(
                type_.domain,
                lambda a: z3.Implies(there(a), e.all([e.member(a, domain), e.member(result(a), range_)])),
                arguments,
            )
        )
    if kind in _TOTAL:
        parts.append(e.forall(type_.domain, lambda a: z3.Implies(e.member(a, domain), there(a)), e.candidates(domain)))
    if kind in _INJECTIVE:
        parts.append(_injective(e, type_, x, arguments))
    if kind in _SURJECTIVE:
        parts.append(
            e.forall(
                type_.range,
                lambda b: z3.Implies(
                    e.member(b, range_),
                    e.exists(type_.domain, lambda a: z3.And(there(a), result(a) == b), arguments),
                ),
                e.candidates(range_),
            )
        )
    if kind in _FINITE and arguments is None:
        parts.append(_finite_domain(e, x, type_))
    return e.all(parts)


def _injective(e: Encoder, type_: core.FunctionType, x: Expr, arguments: list[Expr] | None) -> Expr:
    values = arguments if arguments is not None else e.enumeration(type_.domain)
    if values is not None and len(values) <= LARGEST_EXPANSION:
        return e.all(
            z3.Implies(z3.And(e.sorts.is_some(type_, selected(x, a)), selected(x, a) == selected(x, b)), a == b)
            for a, b in combinations(values, 2)
        )
    sort = e.sorts.sort(type_.domain)
    a, b = e.constant("a", sort), e.constant("b", sort)
    same = z3.And(e.sorts.is_some(type_, z3.Select(x, a)), z3.Select(x, a) == z3.Select(x, b))
    return z3.ForAll([a, b], z3.Implies(same, a == b))


def _finite_domain(e: Encoder, x: Expr, type_: core.FunctionType) -> Expr:
    """That a function given as an array is finite."""
    if e.list_of(x) is not None or e.enumeration(type_.domain) is not None:
        return e.sorts.truth(True)
    e.approximated.add("ffun")
    predicate = e.function("finite_function", type_, e.sorts.sort(type_), z3.BoolSort(e.sorts.context))
    return predicate(x)


FINITE_CARRIERS = {"finset": "power", "finset1": "power1", "ffun": "pfun", "finj": "pinj"}
"""Carriers of finite things, each with the one that drops finiteness."""


def finite(e: Encoder, term: Term) -> Expr:
    """That a set or function is finite, by the way that it is written."""
    if not is_function(term):
        return finite_set(e, term)
    if keys(e, term) is not None:
        return e.sorts.truth(True)
    opaque = _finite_domain(e, e.term(term), function_type(term))
    match term:
        case Apply(operator="override", operands=(old, new)):
            both = e.all([finite(e, old), finite(e, new)])
            e.fact(opaque == both)
            return both
        case Apply(operator="dom_restrict", operands=(chosen, inner)):
            e.fact(z3.Implies(e.any([finite(e, inner), finite_set(e, chosen)]), opaque))
        case Apply(operator="dom_subtract", operands=(_, inner)):
            e.fact(z3.Implies(finite(e, inner), opaque))
        case Apply(operator="ran_restrict" | "ran_subtract" | "compose", operands=(inner, _)):
            e.fact(z3.Implies(finite(e, inner), opaque))
        case Apply(operator="sequence_to_function" | "bag_to_function"):
            e.fact(opaque)
        case core.If():
            chosen_ = z3.If(e.term(term.test), finite(e, term.then), finite(e, term.otherwise))
            e.fact(opaque == chosen_)
    return opaque


# --- domains and ranges ----------------------------------------------------------------------------------------------


@membership("dom")
def _in_dom(e: Encoder, x: Expr, term: Apply) -> Expr:
    relation = term.operands[0]
    if is_function(relation):
        type_ = function_type(relation)
        return e.sorts.is_some(type_, selected(e.term(relation), x))
    pair = element_of(relation)
    assert isinstance(pair, core.TupleType)
    values = e.candidates(relation)
    if values is not None:
        return e.any(z3.And(e.member(p, relation), e.sorts.part(pair, p, 0) == x) for p in values)
    return e.exists(pair.items[1], lambda b: e.member(e.sorts.make(pair, [x, b]), relation))


@membership("ran")
def _in_ran(e: Encoder, x: Expr, term: Apply) -> Expr:
    relation = term.operands[0]
    if is_function(relation):
        type_ = function_type(relation)
        array = e.term(relation)
        wanted = e.sorts.some(type_, x)
        return e.exists(type_.domain, lambda a: selected(array, a) == wanted, keys(e, relation))
    pair = element_of(relation)
    assert isinstance(pair, core.TupleType)
    values = e.candidates(relation)
    if values is not None:
        return e.any(z3.And(e.member(p, relation), e.sorts.part(pair, p, 1) == x) for p in values)
    return e.exists(pair.items[0], lambda a: e.member(e.sorts.make(pair, [a, x]), relation))


@candidates("dom")
def _dom_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    relation = term.operands[0]
    if is_function(relation):
        return keys(e, relation)
    values = e.candidates(relation)
    return None if values is None else [e.sorts.part(element_of(relation), p, 0) for p in values]


@candidates("ran")
def _ran_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    relation = term.operands[0]
    if is_function(relation):
        arguments = keys(e, relation)
        if arguments is None:
            return None
        type_ = function_type(relation)
        array = e.term(relation)
        return [e.sorts.value(type_, selected(array, a)) for a in arguments]
    values = e.candidates(relation)
    return None if values is None else [e.sorts.part(element_of(relation), p, 1) for p in values]


@membership("function_to_relation")
def _in_graph(e: Encoder, x: Expr, term: Apply) -> Expr:
    function = term.operands[0]
    pair = element_of(term)
    argument, result = (e.sorts.part(pair, x, i) for i in range(2))
    return selected(e.term(function), argument) == e.sorts.some(function_type(function), result)


@candidates("function_to_relation")
def _graph_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    function = term.operands[0]
    arguments = keys(e, function)
    if arguments is None:
        return None
    type_, pair, array = function_type(function), element_of(term), e.term(function)
    return [e.sorts.make(pair, [a, e.sorts.value(type_, selected(array, a))]) for a in arguments]


# --- operations on relations and on functions alike ------------------------------------------------------------------


@membership("compose")
def _in_composition(e: Encoder, x: Expr, term: Apply) -> Expr:
    first, second = term.operands
    pair = element_of(term)
    left, right = element_of(first), element_of(second)
    assert isinstance(left, core.TupleType)
    a, c = (e.sorts.part(pair, x, i) for i in range(2))

    def linked(b: Expr) -> Expr:
        there = e.member(e.sorts.make(left, [a, b]), first)
        return z3.And(there, e.member(e.sorts.make(right, [b, c]), second))

    pairs = e.candidates(first)
    middle = None if pairs is None else [e.sorts.part(left, p, 1) for p in pairs]
    return e.exists(left.items[1], linked, middle)


@membership("dom_restrict", "dom_subtract")
def _in_dom_restriction(e: Encoder, x: Expr, term: Apply) -> Expr:
    chosen, relation = term.operands
    inside = e.member(e.sorts.part(element_of(term), x, 0), chosen)
    return z3.And(e.member(x, relation), inside if term.operator == "dom_restrict" else z3.Not(inside))


@membership("ran_restrict", "ran_subtract")
def _in_ran_restriction(e: Encoder, x: Expr, term: Apply) -> Expr:
    relation, chosen = term.operands
    inside = e.member(e.sorts.part(element_of(term), x, 1), chosen)
    return z3.And(e.member(x, relation), inside if term.operator == "ran_restrict" else z3.Not(inside))


@membership("inverse")
def _in_inverse(e: Encoder, x: Expr, term: Apply) -> Expr:
    relation = term.operands[0]
    first, second = (e.sorts.part(element_of(term), x, i) for i in range(2))
    return e.member(e.sorts.make(element_of(relation), [second, first]), relation)


@membership("override")
def _in_override(e: Encoder, x: Expr, term: Apply) -> Expr:
    old, new = term.operands
    pair = element_of(term)
    assert isinstance(pair, core.TupleType)
    domain = Apply(type=core.SetType(pair.items[0]), operator="dom", operands=(new,))
    changed = e.member(e.sorts.part(pair, x, 0), domain)
    return z3.Or(e.member(x, new), z3.And(e.member(x, old), z3.Not(changed)))


@membership("image")
def _in_image(e: Encoder, x: Expr, term: Apply) -> Expr:
    relation, chosen = term.operands
    if is_function(relation):
        type_ = function_type(relation)
        array, wanted = e.term(relation), e.sorts.some(function_type(relation), x)
        few = [found for found in (e.candidates(chosen), keys(e, relation)) if found is not None]
        return e.exists(
            type_.domain,
            lambda a: z3.And(e.member(a, chosen), selected(array, a) == wanted),
            min(few, key=len, default=None),
        )
    pair = element_of(relation)
    assert isinstance(pair, core.TupleType)
    return e.exists(
        pair.items[0],
        lambda a: z3.And(e.member(a, chosen), e.member(e.sorts.make(pair, [a, x]), relation)),
        e.candidates(chosen),
    )


@candidates("image")
def _image_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    ran = Apply(type=term.type, operator="ran", operands=(term.operands[0],))
    return _ran_candidates(e, ran)


@candidates("dom_restrict", "dom_subtract")
def _dom_restriction_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    return e.candidates(term.operands[1])


@candidates("ran_restrict", "ran_subtract")
def _ran_restriction_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    return e.candidates(term.operands[0])


@candidates("override")
def _override_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    lists = [e.candidates(operand) for operand in term.operands]
    return None if lists[0] is None or lists[1] is None else [*lists[0], *lists[1]]


@candidates("inverse")
def _inverse_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    relation = term.operands[0]
    values = e.candidates(relation)
    if values is None:
        return None
    old, new = element_of(relation), element_of(term)
    return [e.sorts.make(new, [e.sorts.part(old, p, 1), e.sorts.part(old, p, 0)]) for p in values]


@candidates("compose")
def _composition_candidates(e: Encoder, term: Apply) -> list[Expr] | None:
    lists = [e.candidates(operand) for operand in term.operands]
    if lists[0] is None or lists[1] is None or len(lists[0]) * len(lists[1]) > LARGEST_EXPANSION:
        return None
    left, right = (element_of(operand) for operand in term.operands)
    pair = element_of(term)
    return [
        e.sorts.make(pair, [e.sorts.part(left, p, 0), e.sorts.part(right, q, 1)]) for p in lists[0] for q in lists[1]
    ]


# --- functions as values ---------------------------------------------------------------------------------------------


@value("apply")
def _apply(e: Encoder, term: Apply) -> Expr:
    function, argument = term.operands
    match function.type:
        case core.FunctionType() as type_:
            return e.sorts.value(type_, selected(e.term(function), e.term(argument)))
        case core.SequenceType() as sequence_type:
            return selected(e.sorts.items(sequence_type, e.term(function)), e.term(argument))
        case core.BagType():
            return selected(e.term(function), e.term(argument))
    raise Unsupported(f"the application of a `{function.type}`")


@value("function")
def _function(e: Encoder, term: Apply) -> Expr:
    type_ = function_type(term)
    array = z3.K(e.sorts.sort(type_.domain), e.sorts.none(type_))
    arguments = [e.term(first_of(pair)) for pair in term.operands]
    for argument, pair in zip(arguments, term.operands, strict=True):
        array = z3.Store(array, argument, e.sorts.some(type_, e.term(second_of(pair))))
    return e.listed(array, arguments)


def _pointwise(e: Encoder, term: Apply, entry: Callable[[Expr], Expr]) -> Expr:
    """A function by what it gives for each argument."""
    type_ = function_type(term)
    formula = e.lambda_("x", type_.domain, entry)
    arguments = keys(e, term)
    return formula if arguments is None else e.listed(formula, arguments)


def _on_relations(e: Encoder, term: Apply) -> Expr:
    """The value of an operator on relations, by membership."""
    formula = e.lambda_("x", element_of(term), lambda x: e.member(x, term))
    values = e.candidates(term)
    return formula if values is None else e.listed(formula, values)


@value("override")
def _override(e: Encoder, term: Apply) -> Expr:
    if not is_function(term):
        return _on_relations(e, term)
    old, new = term.operands
    type_ = function_type(term)
    if isinstance(new, Apply) and new.operator == "function":
        array = e.term(old)
        for pair in new.operands:
            array = z3.Store(array, e.term(first_of(pair)), e.sorts.some(type_, e.term(second_of(pair))))
        arguments = keys(e, term)
        return array if arguments is None else e.listed(array, arguments)
    before, after = e.term(old), e.term(new)

    def entry(a: Expr) -> Expr:
        changed = selected(after, a)
        return z3.If(e.sorts.is_some(type_, changed), changed, selected(before, a))

    return _pointwise(e, term, entry)


@value("dom_restrict", "dom_subtract")
def _dom_restriction(e: Encoder, term: Apply) -> Expr:
    if not is_function(term):
        return _on_relations(e, term)
    chosen, function = term.operands
    type_, array = function_type(term), e.term(function)

    def entry(a: Expr) -> Expr:
        inside = e.member(a, chosen)
        kept = inside if term.operator == "dom_restrict" else z3.Not(inside)
        return z3.If(kept, selected(array, a), e.sorts.none(type_))

    return _pointwise(e, term, entry)


@value("ran_restrict", "ran_subtract")
def _ran_restriction(e: Encoder, term: Apply) -> Expr:
    if not is_function(term):
        return _on_relations(e, term)
    function, chosen = term.operands
    type_, array = function_type(term), e.term(function)

    def entry(a: Expr) -> Expr:
        option = selected(array, a)
        inside = e.member(e.sorts.value(type_, option), chosen)
        kept = inside if term.operator == "ran_restrict" else z3.Not(inside)
        return z3.If(z3.And(e.sorts.is_some(type_, option), kept), option, e.sorts.none(type_))

    return _pointwise(e, term, entry)


@value("compose")
def _composition(e: Encoder, term: Apply) -> Expr:
    if not is_function(term):
        return _on_relations(e, term)
    first, second = term.operands
    left, right = function_type(first), function_type(second)
    before, after = e.term(first), e.term(second)

    def entry(a: Expr) -> Expr:
        option = selected(before, a)
        linked = selected(after, e.sorts.value(left, option))
        return z3.If(e.sorts.is_some(left, option), linked, e.sorts.none(right))

    return _pointwise(e, term, entry)


@value("sequence_to_function")
def _sequence_to_function(e: Encoder, term: Apply) -> Expr:
    sequence = term.operands[0]
    type_ = function_type(term)
    sequence_type = sequence.type
    assert isinstance(sequence_type, core.SequenceType)
    formula = e.term(sequence)
    length, items = e.sorts.length(sequence_type, formula), e.sorts.items(sequence_type, formula)

    def entry(i: Expr) -> Expr:
        inside = z3.And(i >= 1, i <= length)
        return z3.If(inside, e.sorts.some(type_, selected(items, i)), e.sorts.none(type_))

    return _pointwise(e, term, entry)


@value("bag_to_function")
def _bag_to_function(e: Encoder, term: Apply) -> Expr:
    bag = e.term(term.operands[0])
    type_ = function_type(term)

    def entry(x: Expr) -> Expr:
        number = selected(bag, x)
        return z3.If(number > 0, e.sorts.some(type_, number), e.sorts.none(type_))

    return _pointwise(e, term, entry)
