"""Which types have equality, order and so on: the table of constraints, held one cell at a time."""

import pytest

from cspcheck.cspm.typing.constraints import Unsatisfied, lacks_equality
from cspcheck.cspm.typing.types import (
    BOOL,
    CHAR,
    COMPLETE,
    EQ,
    EVENT,
    INT,
    ORD,
    PROC,
    SET,
    YIELDABLE,
    Constraints,
    Datatype,
    Dot,
    Dotable,
    Extendable,
    Function,
    MapOf,
    Rigid,
    SequenceOf,
    SetOf,
    TupleOf,
    Type,
    Variable,
    implied,
    show,
)
from cspcheck.cspm.typing.unification import Unifier

PLAIN, CARRIER = Datatype("Plain"), Datatype("Carrier")
PLAIN.comparable, CARRIER.comparable = True, False
FUNCTION = Function([INT], INT)
CHANNEL = Dotable(INT, EVENT)

HOLDS: list[tuple[Type, Constraints]] = [
    (INT, EQ | ORD | SET | COMPLETE),
    (CHAR, EQ | ORD | SET | COMPLETE),
    (BOOL, EQ | SET | COMPLETE),
    (EVENT, EQ | SET | COMPLETE | YIELDABLE),
    (PROC, SET | COMPLETE),
    (PLAIN, EQ | SET | COMPLETE | YIELDABLE),
    (CARRIER, SET | COMPLETE | YIELDABLE),
    (FUNCTION, 0),
    (CHANNEL, EQ | SET),
    (Dotable(INT, CARRIER), SET),
    (SetOf(BOOL), EQ | ORD | SET | COMPLETE),
    (SetOf(PROC), SET | COMPLETE),
    (SequenceOf(EVENT), EQ | ORD | SET | COMPLETE),
    (SequenceOf(PROC), SET | COMPLETE),
    (SequenceOf(FUNCTION), COMPLETE),
    (TupleOf([INT, CHAR]), EQ | ORD | SET | COMPLETE),
    (TupleOf([INT, BOOL]), EQ | SET | COMPLETE),
    (TupleOf([INT, PROC]), SET | COMPLETE),
    (TupleOf([INT, FUNCTION]), COMPLETE),
    (TupleOf([INT, SetOf(BOOL)]), EQ | ORD | SET | COMPLETE),
    (MapOf(INT, INT), EQ | ORD | SET | COMPLETE),
    (MapOf(INT, BOOL), EQ | SET | COMPLETE),
    (MapOf(INT, PROC), SET | COMPLETE),
    (Dot(INT, BOOL), EQ | SET | COMPLETE),
    (Dot(INT, PROC), SET | COMPLETE),
    (Dot(INT, FUNCTION), 0),
    (Dot(INT, CHANNEL), EQ | SET),
    (Dot(CHANNEL, INT), EQ | SET | COMPLETE | YIELDABLE),
    (Dot(CHANNEL, Dot(INT, INT)), EQ | SET | COMPLETE),
    (Dot(Dotable(PLAIN, EVENT), Dot(Dotable(INT, PLAIN), INT)), EQ | SET | COMPLETE | YIELDABLE),
    (Rigid("a", 1, EQ), EQ | SET),
    (Rigid("a", 1, ORD), EQ | ORD | SET),
    (Rigid("a", 1, YIELDABLE), SET | COMPLETE | YIELDABLE),
    (Rigid("a", 1), 0),
]


@pytest.mark.parametrize(
    ("type_", "constraints"), HOLDS, ids=lambda cell: show(cell)[0] if isinstance(cell, Type) else ""
)
@pytest.mark.parametrize(
    "single", [EQ, ORD, SET, COMPLETE, YIELDABLE], ids=["Eq", "Ord", "Set", "Complete", "Yieldable"]
)
def test_a_type_satisfies_exactly_the_constraints_of_its_row(
    type_: Type, constraints: Constraints, single: Constraints
) -> None:
    unifier = Unifier()
    if constraints & single:
        unifier.constrain(single, type_)
    else:
        with pytest.raises(Unsatisfied) as raised:
            unifier.constrain(single, type_)
        assert raised.value.constraint in (single, EQ)


@pytest.mark.parametrize(("type_", "constraints"), HOLDS)
def test_the_rows_agree_with_what_constraints_imply(type_: Type, constraints: Constraints) -> None:
    assert implied(constraints) & ~constraints & ~COMPLETE == 0


@pytest.mark.parametrize(("type_", "constraints"), HOLDS)
def test_a_constrained_variable_stands_only_for_types_that_satisfy_it(type_: Type, constraints: Constraints) -> None:
    for single in (EQ, ORD, SET, COMPLETE, YIELDABLE):
        if isinstance(type_, Rigid):
            continue
        unifier, variable = Unifier(), Variable(1, single)
        if constraints & single:
            unifier.unify(variable, type_)
            assert show(unifier.settle(variable)) == show(unifier.settle(type_))
        else:
            with pytest.raises(Unsatisfied):
                unifier.unify(variable, type_)


def test_the_constraints_of_a_variable_pass_to_the_parts_of_what_it_stands_for() -> None:
    unifier, whole, part = Unifier(), Variable(1, ORD), Variable(1)
    unifier.unify(whole, SetOf(part))
    assert part.constraints == EQ


def test_two_variables_that_become_one_have_the_constraints_of_both() -> None:
    unifier, one, other = Unifier(), Variable(1, EQ), Variable(1, COMPLETE)
    unifier.unify(one, other)
    unifier.unify(other, INT)
    assert show(one) == ("Int",)
    with pytest.raises(Unsatisfied):
        Unifier().unify(Variable(1, EQ), PROC)


def test_an_extendable_that_must_be_complete_has_no_more_fields() -> None:
    unifier, row = Unifier(), Variable(1)
    open_end = Extendable(row, EVENT)
    unifier.constrain(COMPLETE, open_end)
    assert show(open_end) == ("Event",)


def test_equality_of_a_datatype_that_is_not_known_yet_is_noted() -> None:
    unifier, unknown = Unifier(), Datatype("T")
    unifier.constrain(EQ, SetOf(unknown))
    assert unifier.undecided == [unknown]


def test_the_culprit_of_missing_equality_is_found_without_binding_anything() -> None:
    variable = Variable(1)
    assert lacks_equality(TupleOf([INT, variable])) is None
    assert variable.binding is None
    assert lacks_equality(SetOf(TupleOf([INT, CARRIER]))) is CARRIER
    assert lacks_equality(SequenceOf(FUNCTION)) is FUNCTION
    assert lacks_equality(MapOf(INT, PROC)) is PROC


def test_a_failure_names_the_types_around_the_culprit() -> None:
    with pytest.raises(Unsatisfied) as raised:
        Unifier().constrain(EQ, SetOf(TupleOf([INT, PROC])))
    assert raised.value.type is PROC
    assert [show(type_)[0] for _, type_ in raised.value.trail] == ["(Int, Proc)", "{(Int, Proc)}"]
