"""The evaluator of core terms gives the values that the obvious interpreter gives, and says where there is none."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from typing import Any

import pytest
from hypothesis import event, given, strategies as st

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import (
    BOOL,
    INT,
    REAL,
    Apply,
    Binder,
    Comprehension,
    Constant,
    Quantifier,
    SetType,
    Term,
    Variable,
)
from cspcheck.cspm.oz.values.carriers import Carrier, TooLarge, Unbounded, Undefined
from cspcheck.cspm.oz.values.evaluation import FrameScope, TermEvaluator
from cspcheck.cspm.oz.values.solving import SoughtVariable, solver
from cspcheck.cspm.oz.values.terms import free_variables
from cspcheck.cspm.oz.values.values import Construction, Element, Graph, show
from cspcheck.cspm.source import Source, Span
from tests.cspm.oz.naive import FUN, INTS, NAMES, REL, SEQ, TRUE, apply, environments, interpret, number, terms

EVALUATOR = TermEvaluator(core.Specification())
TYPES = (BOOL, INT, INTS, SEQ, FUN, REL)
NAT = apply("Nat", INTS)
HERE = Span(Source("here", "reading"), 0, 7)


def before(name: str, type_: core.Type = INT) -> Variable:
    return Variable(type=type_, name=name, role="before")


def bound(name: str, type_: core.Type = INT) -> Variable:
    return Variable(type=type_, name=name, role="bound")


def assignment(env: dict[str, Any]) -> dict[tuple[str, core.Role], Any]:
    return {(name, "before"): value for name, value in env.items()}


@given(st.data(), environments)
def test_values_are_those_of_the_obvious_interpreter(data: st.DataObject, env: dict[str, Any]) -> None:
    type_ = data.draw(st.sampled_from(TYPES))
    term = data.draw(terms(type_))
    expected = interpret(term, env)
    event(f"defined: {expected is not None}")

    if expected is None:
        with pytest.raises(Undefined):
            EVALUATOR.value(term, assignment(env))
    else:
        assert EVALUATOR.value(term, assignment(env)) == expected


@given(st.data(), environments)
def test_a_solver_finds_exactly_the_solutions(data: st.DataObject, env: dict[str, Any]) -> None:
    names = ("x%0", "x%1")
    predicates = [data.draw(terms(BOOL, names, 3)) for _ in range(data.draw(st.integers(1, 3)))]
    if data.draw(st.booleans()):
        value = data.draw(terms(INT, names[1:], 2))
        predicates.append(apply("equal", BOOL, *data.draw(st.permutations([bound("x%0"), value]))))
    whole = core.conjunction(tuple(predicates))
    carrier = apply("range", INTS, number(-2), number(3))
    expected = {
        values: interpret(whole, {**env, **dict(zip(names, values, strict=True))})
        for values in product(range(-2, 4), repeat=2)
    }

    scope = FrameScope(assignment(env))
    found = solver(EVALUATOR, scope, [SoughtVariable(name, "bound", carrier) for name in names], predicates)
    frame = scope.frame(assignment(env))
    solutions: set[tuple[int, ...]] = set()

    def take(frame: list[Any]) -> bool:
        solutions.add(tuple(frame[scope.slot(name, "bound")] for name in names))
        return False

    undefined = None in expected.values()
    event(f"solutions: {min(2, sum(value is True for value in expected.values()))}, undefined: {undefined}")
    try:
        found.run(frame, take)
    except Undefined:
        assert undefined
    else:  # of `(1, x) = (2, head <>)` the solver knows that it is false, whatever the head
        assert solutions == {values for values, holds in expected.items() if holds}


@pytest.mark.parametrize(
    ("operator", "operands", "message"),
    [
        ("head", (apply("sequence", SEQ),), "`head <>` has no value: the sequence is empty"),
        ("div", (number(1), number(0)), "`1 div 0` has no value: the divisor is zero"),
        ("max", (apply("set", INTS),), "`max {}` has no value: the set is empty"),
        ("card", (NAT,), "`#nat` has no value: the set is infinite"),
        ("apply", (apply("function", FUN), number(2)), "`{}(2)` has no value: 2 is outside its domain"),
        ("apply", (apply("sequence", SEQ, number(7)), number(2)), "`<7>(2)` has no value: 2 is outside 1..1"),
    ],
)
def test_a_term_without_a_value_says_why(operator: str, operands: tuple[Term, ...], message: str) -> None:
    with pytest.raises(Undefined) as failure:
        EVALUATOR.value(apply(operator, INT, *operands))

    assert failure.value.diagnostic.message == message
    assert failure.value.diagnostic.code == "CSP680"


def test_div_and_mod_are_those_of_iso_z() -> None:
    """Rounded down, and the sign of the divisor."""
    values = [
        tuple(EVALUATOR.value(apply(operator, INT, number(a), number(b))) for operator in ("div", "mod"))
        for a, b in ((7, 2), (-7, 2), (7, -2), (-7, -2))
    ]

    assert values == [(3, 1), (-4, 1), (-4, -1), (3, -1)]


def test_what_is_false_anyway_need_not_have_a_value() -> None:
    """Kleene's logic, whichever way round it is written."""
    guarded = (apply("less", BOOL, number(0), apply("length", INT, before("q", SEQ))),)
    uses_head = apply("equal", BOOL, apply("head", INT, before("q", SEQ)), number(1))

    for operands in ((*guarded, uses_head), (uses_head, *guarded)):
        assert not EVALUATOR.holds(apply("and", BOOL, *operands), {("q", "before"): ()})
        assert EVALUATOR.holds(apply("and", BOOL, *operands), {("q", "before"): (1,)})


# --- infinite sets ---------------------------------------------------------------------------------------------------


def evens(condition: Term = TRUE) -> Comprehension:
    x = bound("x%9")
    even = apply("equal", BOOL, apply("mod", INT, x, number(2)), number(0))
    return Comprehension(
        type=INTS,
        kind="set",
        binders=(Binder("x%9", INT, NAT, "x"),),
        condition=apply("and", BOOL, even, condition),
        body=x,
    )


def test_membership_in_an_infinite_set_needs_no_enumeration() -> None:
    assert EVALUATOR.contains(evens(), 10**9)
    assert not EVALUATOR.contains(evens(), 10**9 + 1)
    assert EVALUATOR.holds(apply("in", BOOL, number(4), evens()))
    assert EVALUATOR.contains(apply("power", SetType(INTS), NAT), frozenset({1, 2}))
    assert not EVALUATOR.contains(apply("seq", SetType(SEQ), NAT), (1, -1))
    assert isinstance(EVALUATOR.value(evens()), Carrier)
    assert EVALUATOR.value(apply("inter", INTS, evens(), apply("range", INTS, number(1), number(5)))) == {2, 4}
    assert EVALUATOR.value(apply("subset", BOOL, apply("set", INTS, number(2)), evens()))


def test_going_through_an_infinite_set_is_refused_with_the_reading_that_would_help() -> None:
    with pytest.raises(Unbounded) as failure:
        EVALUATOR.enumerate(NAT)

    assert failure.value.diagnostic.message == "a value can be anything in `nat`, which is not finite"
    assert failure.value.diagnostic.help == "give it a finite reading: `reading nat = 0..3`"


def test_inequalities_bound_what_is_gone_through() -> None:
    """No reading is needed where the predicate itself bounds a variable of an infinite type."""
    assert EVALUATOR.enumerate(evens(apply("less", BOOL, bound("x%9"), number(7)))) == [0, 2, 4, 6]
    x = bound("x%3")
    square = Quantifier(
        type=BOOL,
        kind="exists",
        binders=(Binder("x%3", INT, NAT, "x"),),
        condition=apply("at_most", BOOL, x, before("i")),
        body=apply("equal", BOOL, apply("times", INT, x, x), before("i")),
    )
    assert [i for i in range(20) if EVALUATOR.holds(square, {("i", "before"): i})] == [0, 1, 4, 9, 16]


def test_an_equation_gives_the_value_of_a_bound_variable() -> None:
    """The one-point rule, through a sum, a concatenation and a tuple."""
    x, rest = bound("x%1"), bound("t%2", SEQ)
    pattern = apply("concat", SEQ, apply("sequence", SEQ, apply("plus", INT, x, number(1))), rest)
    term = Comprehension(
        type=SetType(core.TupleType((INT, SEQ))),
        kind="set",
        binders=(Binder("x%1", INT, NAT, "x"), Binder("t%2", SEQ, apply("seq", SetType(SEQ), NAT), "t")),
        condition=apply("equal", BOOL, pattern, before("q", SEQ)),
        body=apply("tuple", core.TupleType((INT, SEQ)), x, rest),
    )

    assert EVALUATOR.value(term, {("q", "before"): (5, 7, 8)}) == {(4, (7, 8))}
    assert EVALUATOR.value(term, {("q", "before"): (0, 7)}) == frozenset()
    assert EVALUATOR.value(term, {("q", "before"): ()}) == frozenset()


def test_a_finite_set_may_be_too_large_to_be_gone_through() -> None:
    with pytest.raises(TooLarge):
        EVALUATOR.enumerate(apply("power", SetType(INTS), apply("range", INTS, number(0), number(40))))


# --- readings --------------------------------------------------------------------------------------------------------


def reading(subject: Term, text: str, values: Term | None = None, bound: int | None = None) -> core.FiniteReading:
    span = Span(Source("here", f"reading {text}"), 0, len(text) + 8)
    return core.FiniteReading(subject=subject, text=text, values=values, bound=bound, span=span)


MESSAGE = core.GivenType("MESSAGE")
MESSAGES = Apply(type=SetType(MESSAGE), operator="All")
QUEUES = Apply(type=SetType(core.SequenceType(MESSAGE)), operator="seq", operands=(MESSAGES,))


def with_readings(*readings: core.FiniteReading, **more: Any) -> TermEvaluator:
    return TermEvaluator(core.Specification(readings=readings, **more))


def test_a_reading_says_what_is_taken_of_a_wide_set() -> None:
    evaluator = with_readings(
        reading(NAT, "nat = 0..2", values=apply("range", INTS, number(0), number(2))),
        reading(MESSAGES, "MESSAGE = 2", bound=2),
        reading(QUEUES, "seq MESSAGE = 1", bound=1),
    )
    one, two = Element("MESSAGE", 1), Element("MESSAGE", 2)

    assert evaluator.enumerate(NAT) == [0, 1, 2]
    assert evaluator.enumerate(apply("Nat1", INTS)) == [1, 2]
    assert evaluator.enumerate(QUEUES) == [(), (one,), (two,)]
    assert evaluator.contains(QUEUES, (one, one)), "membership is about the real set"
    assert list(evaluator.used) == ["nat = 0..2", "seq MESSAGE = 1", "MESSAGE = 2"]
    assert show(one) == "MESSAGE_1"


def test_a_reading_of_an_abbreviation_is_found_whatever_its_bound_variable_is_called() -> None:
    half = Constant(type=REAL, value=Fraction(1, 2))

    def speeds(name: str) -> Comprehension:
        x = Variable(type=REAL, name=name, role="bound")
        return Comprehension(
            type=SetType(REAL),
            kind="set",
            binders=(Binder(name, REAL, apply("Real", SetType(REAL)), "x"),),
            condition=apply("at_most", BOOL, x, half),
            body=x,
        )

    evaluator = with_readings(reading(speeds("x%1"), "SPEED = {0.5, 1.0}", values=apply("set", SetType(REAL), half)))

    assert evaluator.enumerate(speeds("x%2")) == [Fraction(1, 2)]


def test_values_of_a_recursive_free_type_are_taken_up_to_a_depth() -> None:
    tree = core.FreeType("TREE")
    trees = Apply(type=SetType(tree), operator="All")
    pair = Apply(type=SetType(core.TupleType((tree, tree))), operator="cross", operands=(trees, trees))
    definition = core.FreeDefinition(name="TREE", branches=(("leaf", None), ("node", pair)), span=HERE)
    leaf = Construction(0, "leaf")
    evaluator = with_readings(reading(trees, "TREE = 2", bound=2), frees={"TREE": definition})

    assert evaluator.enumerate(trees) == [leaf, Construction(1, "node", (leaf, leaf))]
    with pytest.raises(Unbounded):
        with_readings(frees={"TREE": definition}).enumerate(trees)


@pytest.mark.parametrize(
    ("operator", "size"),
    [("pfun", 9), ("fun", 4), ("pinj", 7), ("inj", 2), ("psurj", 2), ("surj", 2), ("bij", 2), ("rel", 16)],
)
def test_function_spaces_have_the_sizes_that_they_should(operator: str, size: int) -> None:
    """Between two sets of two elements; and what is gone through is what membership allows."""
    two = apply("range", INTS, number(1), number(2))
    whole = enumerated("pfun", two)
    space = Apply(type=SetType(FUN if operator != "rel" else REL), operator=operator, operands=(two, two))

    found = EVALUATOR.enumerate(space)

    assert len(found) == len(set(found)) == size
    assert all(EVALUATOR.contains(space, value) for value in found)
    if operator != "rel":
        assert [f for f in whole if EVALUATOR.contains(space, f)] == sorted(found, key=whole.index)


def enumerated(operator: str, base: Term) -> list[Graph]:
    return EVALUATOR.enumerate(Apply(type=SetType(FUN), operator=operator, operands=(base, base)))


def test_constants_are_found_from_their_axioms() -> None:
    declared = [core.Declared(name=n, type=INT, carrier=NAT, span=HERE) for n in ("max", "half")]
    most, half = (Variable(type=INT, name=n, role="constant") for n in ("max", "half"))
    axioms = (apply("equal", BOOL, most, number(8)), apply("equal", BOOL, apply("plus", INT, half, half), most))
    bounded = (*axioms[:1], apply("equal", BOOL, half, apply("div", INT, most, number(2))))

    evaluator = TermEvaluator(core.Specification(constants=tuple(declared), axioms=bounded))

    assert evaluator.constants == {"max": 8, "half": 4}
    assert evaluator.value(apply("plus", INT, most, number(1))) == 9


def test_the_names_of_the_tests_terms_are_all_used() -> None:
    assert set(NAMES.values()) == {BOOL, INT, INTS, SEQ, FUN, REL}


@given(st.data(), st.lists(st.integers(0, 2), max_size=4).map(tuple))
def test_all_ways_to_take_a_sequence_apart_are_found(data: st.DataObject, whole: tuple[int, ...]) -> None:
    """Concatenations of unknown sequences, known ones, and single items, bracketed anyhow."""
    names = ("x%0", "x%1")
    part = st.sampled_from(
        [bound("x%0", SEQ), bound("x%1", SEQ), before("q", SEQ), apply("sequence", SEQ, bound("x%2", INT))]
    )
    items = data.draw(st.lists(part, min_size=2, max_size=4))
    while len(items) > 1:
        at = data.draw(st.integers(0, len(items) - 2))
        items[at : at + 2] = [apply("concat", SEQ, *items[at : at + 2])]
    predicates = [apply("equal", BOOL, *data.draw(st.permutations([items[0], before("s", SEQ)])))]
    env: dict[str, Any] = {"s": whole, "q": data.draw(st.sampled_from([(), (0,), (0, 1)]))}
    sequences = [s for n in range(5) for s in product(range(3), repeat=n)]
    keys = [name for name in (*names, "x%2") if (name, "bound") in free_variables(predicates[0])]
    choices = [range(3) if name == "x%2" else sequences for name in keys]
    expected = {v for v in product(*choices) if interpret(predicates[0], {**env, **dict(zip(keys, v, strict=True))})}

    scope = FrameScope(assignment(env))
    sets = {"x%2": apply("range", INTS, number(0), number(2))}
    all_sequences = apply("seq", SetType(SEQ), apply("Int", INTS))
    found = solver(EVALUATOR, scope, [SoughtVariable(n, "bound", sets.get(n, all_sequences)) for n in keys], predicates)
    solutions: set[tuple[Any, ...]] = set()

    def take(frame: list[Any]) -> bool:
        solutions.add(tuple(frame[scope.slot(name, "bound")] for name in keys))
        return False

    found.run(scope.frame(assignment(env)), take)

    assert found.exact
    assert solutions == expected
