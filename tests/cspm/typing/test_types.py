"""Types are written the way annotations are, and schemes are copied without mixing their variables up."""

import pytest

from cspcheck.cspm.prelude import BUILTINS, EXTERNAL, TIMED_BUILTINS, TRANSPARENT
from cspcheck.cspm.typing.builtins import SIGNATURES, builtin_scheme, read_signature
from cspcheck.cspm.typing.types import (
    BOOL,
    COMPLETE,
    EQ,
    EVENT,
    INT,
    NOTHING,
    ORD,
    PROC,
    SET,
    YIELDABLE,
    Datatype,
    Dot,
    Dotable,
    Extendable,
    Function,
    MapOf,
    Rigid,
    Row,
    Scheme,
    SequenceOf,
    SetOf,
    TupleOf,
    Variable,
    dotable,
    dotted,
    essential,
    free_variables,
    implied,
    larger_than,
    parts,
    resolve,
    show,
    show_scheme,
    spread,
    substitute,
)


@pytest.mark.parametrize(
    ("type_", "text"),
    [
        (INT, "Int"),
        (SetOf(INT), "{Int}"),
        (SequenceOf(SetOf(BOOL)), "<{Bool}>"),
        (TupleOf([INT, BOOL]), "(Int, Bool)"),
        (MapOf(INT, SetOf(BOOL)), "(| Int => {Bool} |)"),
        (Function([INT, BOOL], PROC), "(Int, Bool) -> Proc"),
        (Function([], INT), "() -> Int"),
        (Function([INT], Function([BOOL], PROC)), "(Int) -> (Bool) -> Proc"),
        (Function([Function([INT], BOOL)], PROC), "((Int) -> Bool) -> Proc"),
        (Dot(INT, Dot(BOOL, INT)), "Int.Bool.Int"),
        (Dot(Dot(INT, BOOL), INT), "Int.Bool.Int"),
        (Dotable(INT, EVENT), "Int => Event"),
        (dotable([INT, BOOL], EVENT), "Int => Bool => Event"),
        (Dotable(Dot(INT, BOOL), EVENT), "Int => Bool => Event"),
        (Dotable(Dotable(INT, BOOL), EVENT), "(Int => Bool) => Event"),
        (Dot(Dotable(INT, EVENT), BOOL), "(Int => Event).Bool"),
        (SetOf(Dotable(INT, EVENT)), "{Int => Event}"),
        (Datatype("M::T"), "M::T"),
        (Rigid("thing", 1), "thing"),
    ],
)
def test_a_type_is_written_as_in_an_annotation(type_: object, text: str) -> None:
    assert show(type_) == (text,)  # type: ignore[arg-type]


def test_variables_get_letters_in_the_order_of_their_occurrence() -> None:
    a, b = Variable(1), Variable(1)
    assert show(Function([b, a], b), SetOf(a)) == ("(a, b) -> a", "{b}")


def test_the_letters_of_variables_avoid_the_names_in_annotations() -> None:
    assert show(TupleOf([Variable(1), Rigid("a", 1)])) == ("(b, a)",)


def test_there_are_letters_for_any_number_of_variables() -> None:
    (text,) = show(TupleOf([Variable(1) for _ in range(30)]))
    assert text.endswith("y, z, a1, b1, c1, d1)")


def test_extendable_types_show_what_is_known_of_their_fields() -> None:
    row = Variable(1)
    open_end = Extendable(row, EVENT)
    assert show(open_end) == ("a =>* Event",)
    rest = Variable(1)
    row.binding = Row(INT, rest)
    assert show(open_end) == ("Int => a =>* Event",)
    rest.binding = NOTHING
    assert show(open_end) == ("Int => Event",)


def test_the_constraints_of_a_scheme_stand_in_front_and_the_implied_ones_are_left_out() -> None:
    a, b = Variable(1, ORD | EQ | SET), Variable(1, SET | COMPLETE)
    assert show_scheme(Scheme((a, b), Function([a], b))) == "(Ord a, Set b, Complete b) => (a) -> b"
    assert show_scheme(Scheme((a,), Function([a], INT))) == "Ord a => (a) -> Int"
    assert show_scheme(Scheme((), INT)) == "Int"


def test_what_constraints_imply() -> None:
    assert implied(ORD) == ORD | EQ | SET
    assert implied(YIELDABLE) == YIELDABLE | COMPLETE | SET
    assert implied(COMPLETE) == COMPLETE
    assert essential(ORD | EQ | SET) == ORD
    assert essential(EQ | COMPLETE) == EQ | COMPLETE
    assert essential(YIELDABLE | SET | EQ) == YIELDABLE | EQ


def test_parts_and_dotted_are_inverse() -> None:
    items = [INT, BOOL, SetOf(INT)]
    assert parts(dotted(items)) == items
    assert parts(Dot(Dot(INT, BOOL), items[2])) == items


def test_spread_looks_through_variables_and_known_rows() -> None:
    alias, row = Variable(1), Variable(1)
    alias.binding = Dotable(Dot(INT, BOOL), Extendable(row, EVENT))
    row.binding = Row(INT, NOTHING)
    fields, result = spread(alias)
    assert fields == [INT, BOOL, INT]
    assert result is EVENT


def test_resolve_follows_chains_of_variables() -> None:
    first, second = Variable(1), Variable(1)
    first.binding = second
    assert resolve(first) is second
    second.binding = INT
    assert resolve(first) is INT


def test_substitution_copies_only_what_changes() -> None:
    a = Variable(1)
    kept = SetOf(INT)
    whole = TupleOf([kept, SequenceOf(a)])
    copy = substitute(whole, {a: BOOL}.get)
    assert show(copy) == ("({Int}, <Bool>)",)
    assert copy.items[0] is kept  # type: ignore[attr-defined]
    assert substitute(whole, {}.get) is whole


def test_free_variables_are_listed_once_in_order() -> None:
    a, b, bound = Variable(1), Variable(1), Variable(1)
    bound.binding = b
    assert free_variables(Function([bound, a], SetOf(bound))) == [b, a]


def test_the_size_of_a_type_counts_shared_parts_as_often_as_they_are_written() -> None:
    type_ = TupleOf([INT, INT])
    for _ in range(40):
        type_ = TupleOf([type_, type_])
    assert larger_than(type_, 1000)
    assert not larger_than(TupleOf([INT, INT]), 3)


def test_a_type_that_is_far_too_large_is_written_in_part() -> None:
    type_ = TupleOf([INT, INT])
    for _ in range(60):
        type_ = TupleOf([type_, type_])
    (text,) = show(type_)
    assert text.startswith("((((")
    assert text.endswith("...)")
    assert len(text) < 20_000


def test_every_name_of_the_language_has_a_type() -> None:
    assert set(SIGNATURES) == BUILTINS | TIMED_BUILTINS | TRANSPARENT | EXTERNAL


@pytest.mark.parametrize("name", sorted(SIGNATURES))
def test_the_types_of_the_language_read_back_as_written(name: str) -> None:
    scheme = builtin_scheme(name)
    again = read_signature(show_scheme(scheme))
    assert show_scheme(again) == show_scheme(scheme)
    assert len(scheme.variables) == len(free_variables(scheme.type))
