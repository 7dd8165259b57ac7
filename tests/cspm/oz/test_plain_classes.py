"""Object-Z without channels: the visible operations of a class are its interface, and it offers them for ever."""

from __future__ import annotations

import pytest

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.oz.typing.elaboration import elaborate
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.source import Source
from tests.cspm.oz.test_meaning import outcome, script, states

QUEUE = """
given ITEM
reading ITEM = 2
class Queue[T]
  visible INIT, Join, Leave
  const max : nat where max = 2
  state
    items : seq T
  where
    #items <= max
  init
    items = <>
  op Join
    Delta(items)
    item? : T
  where
    items' = items ^ <item?>
  op Leave
    Delta(items)
    item! : T
  where
    items = <item!> ^ items'
  op Turn = Leave ; Join
end
class Ring
  visible Push, Pop, Turn
  inherit Queue[ITEM][Push/Join, Pop/Leave]
end
class Ticket
  visible Join
  state
    n : 0..2
  init
    n = 0
  op Join [Delta(n); by! : 1..2; slack : 0..1 | by! = 1 + slack; n' = n + by!]
end
class Office
  state
    open : bool
  init
    open = true
  op Join = [known? : bool | open = known?]
end
""".replace("op Join [", "op Join = [")

TRACES = {
    "Ring :[deadlock free]": True,
    # What leaves the queue joins it again, by a value that nobody sees.
    "Ring :[has trace]: <Push.ITEM_1, Push.ITEM_2, Turn, Pop.ITEM_2>": True,
    "Ring :[has trace]: <Push.ITEM_1, Push.ITEM_2, Turn, Pop.ITEM_1>": False,
    "Ring :[has trace]: <Turn>": False,
    # An operation of the same name with other parameters is another one, where the classes do not meet.
    "Ticket :[has trace]: <Ticket::Join.2>": True,
    "Ticket :[has trace]: <Ticket::Join.2, Ticket::Join.1>": False,
    "Office :[has trace]: <Office::Join.true, Office::Join.true>": True,
}


@pytest.mark.parametrize(("assertion", "holds"), list(TRACES.items()))
def test_the_visible_operations_are_offered_for_ever(assertion: str, holds: bool) -> None:
    text = f"{QUEUE}\nassert {assertion}"
    assert outcome(text, assertion) == ("pass" if holds else "fail", None)


def test_a_class_has_the_states_of_its_data() -> None:
    assert states(script(QUEUE), "Ring") == 1 + 2 + 4


def test_what_is_not_visible_is_no_event() -> None:
    with pytest.raises(ScriptError):
        script(f"{QUEUE}\nassert Ring :[has trace]: <Queue::Turn>").assertion("Ring :[has trace]: <Queue::Turn>")


def test_classes_that_meet_must_agree_on_an_operation() -> None:
    with pytest.raises(ScriptError) as error:
        elaborate(parse(Source("classes.csp", f"{QUEUE}\nS = Office || Ticket")))
    assert "Join" in error.value.diagnostics[0].message


def test_a_class_with_channels_declares_all_of_them() -> None:
    with pytest.raises(ScriptError) as error:
        elaborate(
            parse(
                Source(
                    "classes.csp",
                    "class C\n  chan c\n  state\n    n : nat\n  op d\n    Delta(n)\n  where\n    n' = n\nend",
                )
            )
        )
    assert error.value.diagnostics[0].code == "CSP644"


def test_abstract_and_concrete_classes_are_compared_by_their_operations() -> None:
    text = """
class Set
  state s : power (0..1)
  init s = {}
  op add = [Delta(s); k? : 0..1 | s' = s union {k?}]
  op has = [k? : 0..1 | k? in s]
end
class Flags
  state f : 0..1 -> bool
  init forall k : 0..1 @ not f(k) = true
  op add = [Delta(f); k? : 0..1 | f' = f (+) {k? |-> true}]
  op has = [k? : 0..1 | f(k?) = true]
end
assert Set [FD= Flags
assert Flags [FD= Set
"""
    assert outcome(text, "Set [FD= Flags") == ("pass", None)
    assert outcome(text, "Flags [FD= Set") == ("pass", None)


STACK = """class Stack[X]
  top_of == X
  state items : seq X
  where #items <= 2
  init items = <>
  op push = [Delta(items); x? : X | items' = <x?> ^ items]
  op pop = [Delta(items); x! : X | items = <x!> ^ items']
end
"""


@pytest.mark.parametrize(
    ("trace", "possible"),
    [("put.1, put.0, take.0", True), ("put.1, put.0, put.0", False), ("put.1, look.1", True), ("put.1, swap", True)],
)
def test_variables_of_a_parent_have_other_names_in_a_child(trace: str, possible: bool) -> None:
    pile = (
        "class Pile\n  inherit Stack[0..1][cards/items, put/push, take/pop]\n  state\n    full : bool\n  Delta\n"
        "    height : 0..2\n  where height = #cards\n  op look = [t! : 0..2 | t! = height]\n"
        "  op swap = take ; put\nend\n"
    )
    claim = f"Pile :[has trace]: <{trace}>"
    assert outcome(f"{STACK}{pile}assert {claim}\n", claim)[0] == ("pass" if possible else "fail")


def test_names_of_a_parent_are_exchanged() -> None:
    pair = "class Pair\n  state a, b : 0..1\n  init a = 0 and b = 1\n  op step = [x! : 0..1 | x! = a]\nend\n"
    child = "class Child\n  inherit Pair[b/a, a/b]\nend\n"
    claim = "Child :[has trace]: <step.0>"
    assert outcome(f"{pair}{child}assert {claim}\n", claim)[0] == "pass"
    (model,) = [
        m for n, m in elaborate(parse(Source("p.csp", pair + child))).specification.classes.items() if n == "Child"
    ]
    assert [d.name for d in model.primary] == ["b", "a"]


MORE = """class Base
  state n : 0..3
  init n = 0
  op add = [Delta(n); x? : 0..1 | n' = n + x?]
end
class More
  inherit Base
  op add = [y? : 0..1; s! : 0..3 | y? <= x?; s! = n + y?]
  op twice = add \\ (y?, s!)
end
"""


@pytest.mark.parametrize(
    ("trace", "possible"),
    [
        ("More::add.1.0.0, More::add.1.1.2", True),
        ("More::add.0.1.1", False),
        ("twice.1, More::add.1.0.1", True),
        ("More::add.1.1.0", False),
    ],
)
def test_an_operation_of_a_child_has_more_parameters(trace: str, possible: bool) -> None:
    claim = f"More :[has trace]: <{trace}>"
    assert outcome(f"{MORE}assert {claim}\n", claim)[0] == ("pass" if possible else "fail")
