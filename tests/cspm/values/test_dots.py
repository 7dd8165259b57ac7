"""The dot: what is missing is filled first, however the dots are bracketed; productions and extensions by force."""

from __future__ import annotations

import itertools
from typing import Any

import pytest
from hypothesis import given, strategies as st

from cspcheck.cspm.script import Script, load
from cspcheck.cspm.source import Source
from cspcheck.cspm.values.dots import DotList, Dotted, Event, completions, dot, extensions
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.order import in_order

DECLARATIONS = """
datatype T = A | B.{0..1} | C.T2.Bool
datatype T2 = D.{0..1} | E
channel a
channel c : {0..2}
channel d : Bool.T.{0..1}
channel e : T2.T2
"""
SCRIPT = load(Source("dots.csp", DECLARATIONS))


def value(text: str, script: Script = SCRIPT) -> Any:
    return script._evaluator.run(lambda: script._evaluator.value(script._tied(text)[0], script._top)(()))


EVENTS = {
    "a": [()],
    "c": [(str(n),) for n in range(3)],
    "d": [
        (x, *t, n)
        for x in ("false", "true")
        for t in (("A",), ("B", "0"), ("B", "1"), *itertools.product("C", ("D.0", "D.1", "E"), ("false", "true")))
        for n in "01"
    ],
    "e": [(x, y) for x in ("D.0", "D.1", "E") for y in ("D.0", "D.1", "E")],
}
WORDS = [tuple(".".join([name, *fields]).split(".")) for name, events in EVENTS.items() for fields in events]
"""Every event as the words that are dotted together."""


def fold(words: tuple[Any, ...], cuts: list[int]) -> Any:
    """The words joined by dots, bracketed as the cuts say."""
    if len(words) == 1:
        return words[0]
    cut = 1 + cuts[0] % (len(words) - 1) if cuts else 1
    return dot(fold(words[:cut], cuts[1::2]), fold(words[cut:], cuts[2::2]))


@given(st.sampled_from(WORDS), st.lists(st.integers(0, 5), max_size=12))
def test_brackets_between_dots_make_no_difference(words: tuple[str, ...], cuts: list[int]) -> None:
    event = fold(tuple(value(word) for word in words), cuts)
    assert type(event) is Event
    assert repr(event) == ".".join(words)
    assert event is value(".".join(words))


def test_every_event_has_a_number_of_its_own_in_the_order_of_declaration() -> None:
    events = [value(".".join(words)) for words in WORDS]
    assert [event.number for event in events] == list(range(2, 2 + len(events)))
    assert [SCRIPT.events.name(event.number) for event in events] == [".".join(words) for words in WORDS]
    for event, words in zip(events, WORDS, strict=True):
        head, fields = event.parts
        assert head.name == words[0]
        assert head.complete(fields) is event


@given(st.sampled_from(WORDS), st.integers(1, 6))
def test_productions_and_extensions_are_what_completes(words: tuple[str, ...], length: int) -> None:
    prefix = words[:length]
    partial = value(".".join(prefix))
    expected = {w for w in WORDS if w[: len(prefix)] == prefix}
    found = completions(partial).elements()
    assert [repr(event) for event in found] == [".".join(w) for w in WORDS if w in expected]
    if type(partial) is Event:
        with pytest.raises(Failure):
            extensions(partial)
    else:
        more = extensions(partial).elements()
        assert {dot(partial, x) for x in more} == set(found)
        assert len(more) == len(found)


def test_a_list_of_values_stands_side_by_side() -> None:
    assert value("1.2.3").parts == (1, 2, 3)
    assert value("(1.2).3") == value("1.(2.3)")
    assert value("1.B.0").parts == (1, value("B.0"))
    assert type(value("A.A")) is DotList
    assert value("a.1").parts == (value("a"), 1)


def test_incomplete_values_are_values() -> None:
    partial = value("d.true.C")
    assert type(partial) is Dotted
    assert not partial.complete
    assert repr(partial) == "d.true.C"
    assert partial == dot(value("d"), value("true.C"))
    assert hash(partial) == hash(dot(value("d.true"), value("C")))


def test_complete_values_are_one_object() -> None:
    assert value("C.(D.1).true") is value("C.D.1.true")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("c.3", "`3` is outside the first field of channel `c`"),
        ("B.2", "`2` is outside the first field of constructor `B`"),
        ("d.true.A.2", "`2` is outside the third field of channel `d`"),
        ("C.E.true.1", None),
        ("e.D.5", "`5` is outside the first field of constructor `D`"),
    ],
)
def test_a_value_outside_its_field_is_refused(text: str, message: str | None) -> None:
    if message is None:
        assert type(value(text)) is DotList
        return
    with pytest.raises(Exception, match="is outside") as raised:
        value(text)
    assert raised.value.diagnostics[0].message == message  # type: ignore[attr-defined]


def test_a_constructor_of_another_type_is_refused_before_it_is_complete() -> None:
    script = load(Source("x.csp", "datatype X = Y.{0..1}\ndatatype Z = W.{0..1}\nchannel q : X.Bool"), typecheck=False)
    with pytest.raises(Exception, match="outside the first field of channel `q`"):
        value("q.W", script)


@given(st.randoms(use_true_random=False))
def test_values_of_constructors_keep_their_place_in_the_order(random: Any) -> None:
    script = load(Source("dots.csp", DECLARATIONS))
    texts = ["A", "B.0", "B.1", *map(".".join, itertools.product("C", ("D.0", "D.1", "E"), ("false", "true")))]
    ordered = [value(text, script) for text in texts]
    for _ in range(2):  # the second time they know their keys
        found = random.sample(ordered, len(ordered))
        assert in_order(found) == ordered
        assert in_order([(other, found[0]) for other in found]) == [(other, found[0]) for other in ordered]
