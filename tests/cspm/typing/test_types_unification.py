"""Unification against the textbook on ordinary types, and against known fields on dotted ones."""

from __future__ import annotations

from contextlib import suppress
from itertools import count

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.cspm.typing.types import (
    BOOL,
    CHAR,
    EVENT,
    INT,
    PROC,
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
    components,
    dotable,
    dotted,
    parts,
    rebuilt,
    resolve,
    show,
)
from cspcheck.cspm.typing.unification import CannotUnify, Clash, InfiniteType, TypeClash, Unifier
from tests.examples import examples

ATOMS = [INT, BOOL, CHAR, PROC, EVENT]
UNHURRIED = settings(deadline=None)


# --- ordinary types against Robinson's algorithm ----------------------------------------------------------------

Term = tuple[str, ...] | tuple[object, ...] | int
"""The textbook's terms: a number is a variable, a tuple a constructor with its arguments."""


def terms(depth: int = 3) -> st.SearchStrategy[Term]:
    leaf = st.integers(0, 3) | st.sampled_from([(atom.name,) for atom in ATOMS])
    return st.recursive(
        leaf,
        lambda inner: st.one_of(
            st.tuples(st.just("set"), inner),
            st.tuples(st.just("sequence"), inner),
            st.tuples(st.just("map"), inner, inner),
            st.tuples(st.just("tuple"), inner, inner),
            st.tuples(st.just("function"), inner, inner),
        ),
        max_leaves=8,
    )


def to_type(term: Term, variables: list[Variable]) -> Type:
    if isinstance(term, int):
        return variables[term]
    head, *arguments = term
    below = [to_type(argument, variables) for argument in arguments]  # type: ignore[arg-type]
    match head:
        case "set":
            return SetOf(*below)
        case "sequence":
            return SequenceOf(*below)
        case "map":
            return MapOf(*below)
        case "tuple":
            return TupleOf(below)
        case "function":
            return Function(below[:1], below[1])
    return next(atom for atom in ATOMS if atom.name == head)


def robinson(one: Term, other: Term) -> dict[int, Term] | None:
    """The most general unifier, by substitution all over; None if there is none."""
    substitution: dict[int, Term] = {}

    def apply(term: Term) -> Term:
        if isinstance(term, int):
            return apply(substitution[term]) if term in substitution else term
        return (term[0], *[apply(argument) for argument in term[1:]])  # type: ignore[arg-type]

    def occurs(variable: int, term: Term) -> bool:
        return term == variable if isinstance(term, int) else any(occurs(variable, a) for a in term[1:])  # type: ignore[arg-type]

    work = [(one, other)]
    while work:
        left, right = (apply(term) for term in work.pop())
        if left == right:
            continue
        if isinstance(right, int):
            left, right = right, left
        if isinstance(left, int):
            if occurs(left, right):
                return None
            substitution[left] = right
        elif isinstance(right, int) or left[0] != right[0] or len(left) != len(right):
            return None
        else:
            work.extend(zip(left[1:], right[1:], strict=True))  # type: ignore[arg-type]
    return {variable: apply(variable) for variable in range(4)}


@UNHURRIED
@given(terms(), terms())
def test_ordinary_types_unify_as_in_the_textbook(one: Term, other: Term) -> None:
    variables = [Variable(1) for _ in range(4)]
    expected = robinson(one, other)
    left, right = to_type(one, variables), to_type(other, variables)
    if expected is None:
        with pytest.raises((CannotUnify, InfiniteType)):
            Unifier().unify(left, right)
    else:
        Unifier().unify(left, right)
        fresh = [Variable(1) for _ in range(4)]
        assert show(*variables) == show(*[to_type(expected[i], fresh) for i in range(4)])
        assert show(left) == show(right)


@UNHURRIED
@given(terms(), terms(), terms())
def test_rolling_back_restores_every_variable(first: Term, one: Term, other: Term) -> None:
    variables = [Variable(level, level) for level in range(4)]
    unifier = Unifier()
    with suppress(*TypeClash):
        unifier.unify(to_type(first, variables), to_type(first, variables[::-1]))
    before = [(show(v), v.binding, v.constraints, v.level) for v in variables]
    mark = unifier.mark()
    with suppress(*TypeClash):
        unifier.unify(to_type(one, variables), to_type(other, variables))
    unifier.rollback(mark)
    assert [(show(v), v.binding, v.constraints, v.level) for v in variables] == before


def test_a_variable_takes_on_the_level_of_what_it_is_unified_with() -> None:
    outer, inner = Variable(1), Variable(5)
    Unifier().unify(outer, SetOf(inner))
    assert inner.level == 1


def test_the_variable_of_an_annotation_unifies_with_itself_only() -> None:
    rigid = Rigid("a", 1)
    Unifier().unify(SetOf(rigid), SetOf(rigid))
    for other in (INT, Rigid("b", 1), SetOf(rigid)):
        with pytest.raises(CannotUnify):
            Unifier().unify(rigid, other)


def test_the_variable_of_an_inner_annotation_cannot_get_outside() -> None:
    with pytest.raises(CannotUnify) as raised:
        Unifier().unify(Variable(1), SetOf(Rigid("a", 2)))
    assert raised.value.clash is Clash.ESCAPES


def test_a_clash_knows_the_pairs_around_it() -> None:
    with pytest.raises(CannotUnify) as raised:
        Unifier().unify(SetOf(TupleOf([INT, BOOL])), SetOf(TupleOf([INT, CHAR])))
    clash = raised.value
    assert (clash.expected, clash.actual) == (BOOL, CHAR)
    assert [show(*pair) for pair in clash.trail] == [
        ("(Int, Bool)", "(Int, Char)"),
        ("{(Int, Bool)}", "{(Int, Char)}"),
    ]


# --- dotted types against known fields --------------------------------------------------------------------------


class World:
    """A channel and constructors whose fields are known, and an event written out with all constructors."""

    def __init__(self, data: st.DataObject) -> None:
        self.data = data
        self.constructors: list[tuple[Type, list[Type], Datatype]] = []
        numbers = count()
        for _ in range(data.draw(st.integers(0, 3))):
            datatype = Datatype(f"T{next(numbers)}")
            datatype.comparable = True
            fields = [self.field() for _ in range(data.draw(st.integers(1, 3)))]
            self.constructors.append((dotable(fields, datatype), fields, datatype))
        self.fields = [self.field() for _ in range(data.draw(st.integers(1, 4)))]
        self.channel = dotable(self.fields, EVENT)

    def field(self) -> Type:
        known = [datatype for _, _, datatype in self.constructors]
        return self.data.draw(st.sampled_from([INT, BOOL, SetOf(INT), TupleOf([INT, BOOL]), *known]))

    def spelled(self, field: Type) -> list[Type]:
        """One way to write a value of *field*: as a value, or constructor and fields."""
        for constructor, fields, datatype in self.constructors:
            if datatype is field and self.data.draw(st.booleans()):
                return [constructor, *[item for inner in fields for item in self.spelled(inner)]]
        return [field]

    def bracketed(self, items: list[Type]) -> Type:
        """The items with brackets set anyhow: a dot is a list, however it was nested."""
        while len(items) > 1:
            i = self.data.draw(st.integers(0, len(items) - 2))
            items[i : i + 2] = [Dot(items[i], items[i + 1])]
        return items[0]


@UNHURRIED
@given(st.data())
def test_a_channel_with_all_its_fields_is_an_event_however_it_is_written(data: st.DataObject) -> None:
    world = World(data)
    items = [world.channel, *[item for field in world.fields for item in world.spelled(field)]]
    Unifier().unify(EVENT, world.bracketed(list(items)))
    Unifier().unify(world.bracketed(list(items)), EVENT)
    assert Unifier().settle(world.bracketed(list(items))) is EVENT


@UNHURRIED
@given(st.data())
def test_a_field_too_many_or_of_another_type_is_no_event(data: st.DataObject) -> None:
    world = World(data)
    items = [world.channel, *[item for field in world.fields for item in world.spelled(field)]]
    with pytest.raises(CannotUnify):
        Unifier().unify(EVENT, dotted([*items, INT]))
    i = data.draw(st.integers(1, len(items) - 1))
    with pytest.raises(CannotUnify):
        Unifier().unify(EVENT, dotted([*items[:i], CHAR, *items[i + 1 :]]))


@UNHURRIED
@given(st.data())
def test_a_variable_in_the_last_place_stands_for_all_fields_that_are_left(data: st.DataObject) -> None:
    world = World(data)
    taken = data.draw(st.integers(0, len(world.fields) - 1))
    front = [item for field in world.fields[:taken] for item in world.spelled(field)]
    last = Variable(1)
    Unifier().unify(EVENT, dotted([world.channel, *front, last]))
    assert parts(last) == world.fields[taken:]


@UNHURRIED
@given(st.data())
def test_variables_in_other_places_stand_for_one_field_each(data: st.DataObject) -> None:
    world = World(data)
    variables = [Variable(1) for _ in world.fields]
    Unifier().unify(EVENT, dotted([world.channel, *variables]))
    assert [resolve(variable) for variable in variables] == world.fields


@UNHURRIED
@given(st.data())
def test_a_channel_that_is_a_variable_wants_what_it_is_given(data: st.DataObject) -> None:
    world = World(data)
    channel = Variable(1)
    Unifier().unify(EVENT, dotted([channel, *world.fields]))
    Unifier().unify(channel, world.channel)
    assert show(channel) == show(world.channel)


@UNHURRIED
@given(st.data())
def test_an_event_with_some_fields_wants_the_others(data: st.DataObject) -> None:
    world = World(data)
    taken = data.draw(st.integers(1, len(world.fields)))
    front = [item for field in world.fields[:taken] for item in world.spelled(field)]
    wanted = dotable(world.fields[taken:], EVENT)
    Unifier().unify(wanted, dotted([world.channel, *front]))
    row = Variable(1)
    Unifier().unify(Extendable(row, EVENT), dotted([world.channel, *front]))
    assert show(Extendable(row, EVENT)) == show(wanted)


@UNHURRIED
@given(st.data())
def test_the_last_variable_in_a_set_of_productions_takes_one_field(data: st.DataObject) -> None:
    world = World(data)
    last, row = Variable(1), Variable(1)
    Unifier().unify(Extendable(row, EVENT), dotted([world.channel, last]))
    assert resolve(last) is world.fields[0]
    assert show(Extendable(row, EVENT)) == show(dotable(world.fields[1:], EVENT))


@UNHURRIED
@given(st.data())
def test_a_parameter_that_is_a_channel_or_a_part_of_one_takes_it(data: st.DataObject) -> None:
    world = World(data)
    channel, field = Variable(1), Variable(1)
    unifier = Unifier()
    unifier.unify(EVENT, Dot(channel, field))
    taken = data.draw(st.integers(0, len(world.fields) - 1))
    unifier.argument(channel, dotted([world.channel, *world.fields[:taken]]))
    assert parts(field) == world.fields[taken:]


def test_a_plain_dot_pattern_does_not_split_an_event_or_a_constructor() -> None:
    for value in (EVENT, Datatype("T"), Dotable(INT, EVENT), Dot(Dotable(INT, EVENT), INT)):
        with pytest.raises(CannotUnify) as raised:
            Unifier().argument(Dot(Variable(1), Variable(1)), value)
        assert raised.value.clash is Clash.SPLITS
    Unifier().argument(Dot(Variable(1), Variable(1)), Dot(INT, Dot(BOOL, INT)))


def test_open_fields_of_two_channels_become_the_same() -> None:
    unifier, row = Unifier(), Variable(1)
    side = Extendable(row, EVENT)
    unifier.unify(side, Dotable(INT, Dotable(BOOL, EVENT)))
    unifier.unify(side, Dot(dotable([CHAR, INT, BOOL], EVENT), CHAR))
    with pytest.raises(CannotUnify):
        unifier.unify(side, EVENT)


def opened(*fields: Type) -> Type:
    """Something that wants *fields*, and perhaps more, to be an event."""
    return dotable(fields, Extendable(Variable(1), EVENT))


@pytest.mark.parametrize("swapped", [False, True])
def test_two_open_types_share_the_fields_of_both(swapped: bool) -> None:
    one, other = opened(INT), opened(INT, BOOL)
    Unifier().unify(*((other, one) if swapped else (one, other)))
    assert show(one) == show(other) == ("Int => Bool => a =>* Event",)


def test_two_open_types_with_the_same_fields_stay_open_together() -> None:
    one, other = opened(INT), opened(INT)
    unifier = Unifier()
    unifier.unify(one, other)
    unifier.unify(one, dotable([INT, BOOL], EVENT))
    assert show(other) == ("Int => Bool => Event",)


@pytest.mark.parametrize("swapped", [False, True])
def test_a_variable_for_all_fields_takes_those_of_an_open_type_and_closes_it(swapped: bool) -> None:
    whole, fields = opened(INT, BOOL), Variable(1)
    Unifier().unify(*((Dotable(fields, EVENT), whole) if swapped else (whole, Dotable(fields, EVENT))))
    assert show(whole, fields) == ("Int => Bool => Event", "Int.Bool")


@pytest.mark.parametrize("swapped", [False, True])
def test_an_open_type_wants_no_fewer_fields_than_are_known(swapped: bool) -> None:
    whole, channel = opened(INT, BOOL), Dotable(INT, EVENT)
    with pytest.raises(CannotUnify):
        Unifier().unify(*((channel, whole) if swapped else (whole, channel)))
    whole, channel = opened(INT), dotable([INT, BOOL], EVENT)
    Unifier().unify(*((channel, whole) if swapped else (whole, channel)))
    assert show(whole) == ("Int => Bool => Event",)


def test_open_fields_cannot_contain_themselves() -> None:
    row = Variable(1)
    with pytest.raises(InfiniteType):
        Unifier().unify(Extendable(row, EVENT), Dotable(INT, Extendable(row, EVENT)))


def test_productions_of_an_open_type_with_a_field_leave_it_open() -> None:
    row, more = Variable(1), Variable(1)
    Unifier().unify(Extendable(more, EVENT), Dot(Extendable(row, EVENT), INT))
    assert show(Extendable(row, EVENT), Extendable(more, EVENT)) == ("Int => a =>* Event", "a =>* Event")


@pytest.mark.parametrize("swapped", [False, True])
def test_a_last_variable_against_a_pair_with_an_event_takes_the_fields_and_the_rest(swapped: bool) -> None:
    last = Variable(1)
    pair, written = Dot(EVENT, INT), Dot(Dotable(BOOL, EVENT), last)
    Unifier().unify(*((written, pair) if swapped else (pair, written)))
    assert parts(last) == [BOOL, INT]


def test_a_variable_that_a_dot_settles_to_is_no_infinite_type() -> None:
    variable = Variable(1)
    Unifier().unify(variable, Dot(Dotable(INT, variable), INT))
    assert variable.binding is None


def test_settling_reads_the_dots_inside_other_types() -> None:
    channel = dotable([INT, BOOL], EVENT)
    last = Variable(1)
    whole = Function([SetOf(Dot(channel, last))], TupleOf([INT, SequenceOf(Dot(channel, INT))]))
    assert show(Unifier().settle(whole)) == ("({Event}) -> (Int, <Bool => Event>)",)
    assert show(last) == ("Int.Bool",)


# --- anything at all --------------------------------------------------------------------------------------------


def tangled() -> st.SearchStrategy[Type]:
    """Types in which everything occurs everywhere, four shared variables among them."""
    return st.deferred(lambda: _TANGLED)


_POOL = [Variable(1) for _ in range(4)]
_DATATYPE = Datatype("T")
_DATATYPE.comparable = True
_TANGLED: st.SearchStrategy[Type] = st.recursive(
    st.sampled_from([*_POOL, INT, EVENT, _DATATYPE, PROC, Rigid("r", 1)]),
    lambda inner: st.one_of(
        st.builds(SetOf, inner),
        st.builds(Dot, inner, inner),
        st.builds(Dot, inner, inner),
        st.builds(Dotable, inner, inner),
        st.builds(Dotable, inner, st.sampled_from([EVENT, _DATATYPE])),
        st.builds(lambda result: Extendable(Variable(1), result), inner),
        st.builds(lambda a, b: TupleOf([a, b]), inner, inner),
        st.builds(lambda a, b: Function([a], b), inner, inner),
    ),
    max_leaves=10,
)


def copied(type_: Type, memo: dict[Type, Type]) -> Type:
    if isinstance(type_, Variable):
        return memo.setdefault(type_, Variable(1))
    below = [copied(part, memo) for part in components(type_)]
    return rebuilt(type_, below) if below else type_


@settings(UNHURRIED, max_examples=examples(400))
@given(tangled(), tangled(), st.booleans())
def test_unification_ends_in_a_type_or_in_a_clash(one: Type, other: Type, as_argument: bool) -> None:
    memo: dict[Type, Type] = {}
    left, right = copied(one, memo), copied(other, memo)
    unifier = Unifier()
    try:
        (unifier.argument if as_argument else unifier.unify)(left, right)
        unifier.settle(left)
    except TypeClash:
        return
    # Nothing contains itself, so everything can be written down.
    assert len(show(left)[0]) < 100_000
    assert len(show(right)[0]) < 100_000
