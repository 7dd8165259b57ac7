"""Documents of plain Object-Z whose objects are references: what is typed, what is refused and why, what is run."""

from __future__ import annotations

import pytest

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.oz.objects.document import mistakes
from cspcheck.cspm.oz.typing.elaboration import Elaborated, elaborate
from cspcheck.cspm.oz.writing.latex_writer import write_latex
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.printing.printer import print_script
from cspcheck.cspm.source import Source

LAMPS = """
class Lamp
  visible INIT, watts, on, press, plug
  state
    watts : nat
    on : bool
  op press = [Delta(on) | on' = not on]
  op plug = [Delta(watts); w? : nat | watts' = w?]
end
class Dimmer
  visible INIT, watts, on, level, press, plug, dim
  inherit Lamp
  state level : nat
  op dim = [Delta(level); to? : nat | level' = to?]
end
class Candle
  visible INIT, on, wax, press, melt
  state
    on : bool
    wax : nat
  op press = [Delta(on) | on' = not on]
  op melt = [Delta(wax) | wax' = wax - 1]
end
"""

TYPED = {
    "classes that refer to each other": """
        class Owner
          state
            pet : Pet
            age : nat
          where
            pet.owner.pet.owner.age >= 0
          op feed = pet.feed
        end
        class Pet
          state
            owner : Owner
          op feed = [amount? : nat | amount? > 0]
          op greet = owner.feed and [word! : power nat]
        end
        """,
    "self": """
        class Node
          state
            next : Node
            below : power Node
          where
            below = {self} union next.below
            next.self = next
        end
        """,
    "any object": "class A\n  state n : nat\nend\nclass B\n  inherit A\nend\n"
    "const o : oid; a : A; b : A union B; c : poly A\n"
    "where\n  a in oid\n  o = a\n  b = o and c = o\nend\n",
    "a class under other names": """
        class Cell[X]
          all == X
          state held : X
          op put = [Delta(held); new? : X | held' = new?]
        end
        Renamed == Cell[nat][content/held, store/put]
        class User
          state
            cell : Renamed
            twice : (Cell[nat][a/held])[b/a]
            open : Cell
          where
            cell.content in cell.all
            twice.b = 1
            open.all = {1}
          op store = cell.store[value?/new?]
        end
        """,
    "a parent that is renamed twice": """
        class Cell[X]
          state held : X
          op put = [Delta(held); new? : X | held' = new?]
        end
        class Back
          inherit Cell[nat][content/held, store/put][held/content]
          init held = 1
          op again = store
        end
        """,
    "a generic constant": "const [X] none : power X\nclass A\n  state n : nat\nend\n"
    "const a : A where none = {a} and none = {1} end\n",
    "an open type becomes a union": """
        any[X] == X
        class A
          state n : nat
          op step = [to? : nat]
        end
        class B
          state n : nat
          op step = [to? : nat]
        end
        const x : any where x in A or x in B end
        const a : A; b : B; c : any where c = if true then a else b end
        class User
          state k : nat
          where
            x.n = k and c.n = 0
          op step = x.step
        end
        """,
    "an operation that is defined by itself": """
        class Walker
          state place : 0..9
          op left = [Delta(place) | place' = place - 1]
          op stay = [place = 0]
          op walk = (left ; walk) [] stay
        end
        class Walkers
          state all : seq Walker
          op walk = and w : ran all @ w.walk
          op report = ; w : ran all @ w.walk and [said! : nat]
        end
        """,
    "operations on all objects of a class": LAMPS
    + "class Hall\n  op dark = and l : Lamp @ l.press\n  op each = ; l : Lamp @ l.plug\nend\n",
    "an attribute that is overridden": "class A\n  size == 1\nend\nclass B\n  inherit A\n  size == 2\nend\n"
    "class C\n  state a : A\n  where a.size = 1\nend\n",
    "sets that are contained": LAMPS
    + "any[X] == X\nclass Room\n  state\n    l : Lamp %own\n    x : any %own\n    e : (Lamp union Candle) %own\n"
    "  where\n    x.watts = 1\n    x in Lamp\n    e.on = l.on\n  op press = l.press\nend\n",
    "a conjecture about objects": LAMPS + "lemma both : forall l : Lamp; c : Candle @ l.on or c.on or true\n",
}

NARROWED = [
    "l in Dimmer and l.level = 1",
    "l.level = 1 and l in Dimmer",
    "l in Dimmer => l.level = 1",
    "l.level = 1 <=> l in poly Dimmer",
    "(l in Dimmer and l.level = 1) or l.watts = 1",
    "forall k : poly Lamp | k in Dimmer @ k.level = 1",
    "not (l in Dimmer and l.level = 1)",
    "l.watts = (if l in Dimmer then l.level else 0)",
]
WIDE = [
    "l in Dimmer or l.level = 1",
    "l.level = 1 => l in Dimmer",
    "(l in Dimmer => l.level = 1) and l.level = 1",
    "(l in Dimmer <=> l.on) and l.level = 1",
    "not (l in Dimmer) and l.level = 1",
    "forall k : poly Lamp @ k in Dimmer and l.level = 1",
]

CELL = "class Cell[X]\n  state held : X\nend\n"
WRONG = [
    ("`poly` needs a class, this is `nat`", "const x : poly nat"),
    ("`poly` needs a class, this is `poly Lamp`", "const x : poly poly Lamp"),
    ("an object that is contained needs a class, this is `nat`", "const x : nat %own"),
    ("a union of classes needs a class, this is `Size`", "Size == nat\nBoth == Size union Lamp"),
    (
        "`Lamp` does not show `serial`",
        "class Lamp\n  visible watts\n  state watts, serial : nat\nend\nconst l : Lamp where l.serial = l.watts end",
    ),
    (
        "`watts` is of type `int` in `Lamp` and `power int` in `Lantern`",
        "class Lantern\n  state watts : power nat\nend\nconst x : Lamp union Lantern",
    ),
    (
        "`press` is of type `[]` in `Lamp` and `[hard? : int]` in `Switch`",
        "class Switch\n  op press = [hard? : nat]\nend\nclass User\n"
        "  state x : Lamp union Switch\n  op press = x.press\nend",
    ),
    (
        "`Hidden` inherits from `Lamp` and does not show `on`",
        "class Hidden\n  visible watts\n  inherit Lamp\nend\nconst l : poly Lamp",
    ),
    (
        "`Cell` has 1 generic parameters and `Two`, which inherits from it, 2",
        CELL + "class Two[X, Y]\n  inherit Cell[X]\nend\nconst c : poly Cell[nat]",
    ),
    (
        "`Cell[int]` and `Cell[power int]` are one class with different parameters",
        CELL + "const a : Cell[nat]; b : Cell[power nat] where a = b end",
    ),
    ("nothing says what the parameters of `Cell` are", CELL + "const a : Cell where a = a end"),
    ("`Cell` has 1 generic parameters, not 2", CELL + "const a : Cell[nat, nat]"),
    (
        "only an object has operations, `press` is asked of a value of type `int`",
        "class U\n  op press = [n : nat] @ n.press\nend",
    ),
    ("`Lamp` has no visible operation `dim`", "class U\n  state l : Lamp; m : poly Lamp\n  op dim = l.dim\nend"),
    (
        "`poly Lamp` has no visible operation `dim`",
        "class U\n  state l : poly Lamp\n  op dim = [l in Dimmer] [] l.dim\nend",
    ),
    ("`Lamp` has no field `watts`", "const l : Lamp[strength/watts] where l.strength = l.watts end"),
    (
        "the types `power A.Kind` and `power B.Kind` differ",
        "class A\n  given Kind\nend\nclass B\n  given Kind\nend\nclass U\n  state a : A; b : B\n"
        "  where a.Kind = b.Kind\nend",
    ),
    (
        "a value of type `Dimmer` is no element of a set of `Candle`",
        "class U\n  state l : poly Lamp\n  op both = [l in Dimmer] and [l in Candle]\nend",
    ),
    (
        "`to?` is of type `int` in one operand and `power int` in the other",
        "class U\n  state d : Dimmer; e : poly Lamp\n  op both = d.dim and [to? : power nat] and [e in Lamp]\nend",
    ),
    (
        "`watts` is declared twice: the operation has a parameter of that name",
        "class W\n  state n : nat\n  op step = [watts : nat | watts = n]\nend\nclass U\n"
        "  state all : power W\n  op step = ; watts : all @ watts.step\nend",
    ),
    ("`bulb` is not known here", "class U\n  state l : power Lamp\n  op press = and k : l @ bulb.press\nend"),
]


HEAP = "an object of `Loop` within itself would need a heap, which is not supported"


def elaborated(text: str) -> Elaborated:
    return elaborate(parse(Source("references.csp", text)))


def told(text: str) -> list[Diagnostic]:
    return mistakes(parse(Source("references.csp", text)).declarations)


@pytest.mark.parametrize("kind", TYPED)
def test_a_document_is_typed_whatever_can_be_run_of_it(kind: str) -> None:
    text = TYPED[kind]
    assert told(text) == []
    found = elaborated(text)
    assert {w.code for w in found.warnings} <= {"CSP673"}
    assert all(w.message.split(": ", 1)[1] for w in found.warnings)


@pytest.mark.parametrize("kind", TYPED)
def test_a_document_is_the_same_in_both_notations(kind: str) -> None:
    script = parse(Source("references.csp", TYPED[kind]))
    for name, text in (("again.csp", print_script(script)), ("again.tex", write_latex(script))):
        assert parse(Source(name, text)).declarations == script.declarations


@pytest.mark.parametrize("predicate", NARROWED)
def test_a_membership_tells_the_class_where_it_holds(predicate: str) -> None:
    assert told(f"{LAMPS}const l : poly Lamp where {predicate} end") == []


@pytest.mark.parametrize("predicate", WIDE)
def test_a_membership_tells_nothing_elsewhere(predicate: str) -> None:
    found = told(f"{LAMPS}const l : poly Lamp where {predicate} end")
    assert [d.message for d in found] == ["`poly Lamp` has no field `level`"]


@pytest.mark.parametrize("operand", ["and", "@"])
def test_an_operation_knows_the_class_of_an_object(operand: str) -> None:
    user = f"class U\n  state l : poly Lamp\n  op dim = [l in Dimmer] {operand} l.dim\nend"
    assert told(LAMPS + user) == []
    assert told(LAMPS + "class U\n  op dim = [o : oid | o in Dimmer] @ o.dim\nend") == []
    assert told(LAMPS + "class U\n  state l : poly Lamp\n  op dim = and n : nat | l in Dimmer @ l.dim\nend") == []


@pytest.mark.parametrize(("message", "text"), WRONG)
def test_a_document_is_refused_for_its_own_reason(message: str, text: str) -> None:
    text = text if text.startswith("class Lamp\n") else LAMPS + text
    with pytest.raises(ScriptError) as error:
        elaborated(text)
    messages = [d.message for d in error.value.diagnostics]
    assert messages[0].startswith(message), messages


def test_what_can_be_run_is_run_beside_what_cannot() -> None:
    text = LAMPS + "class Loop\n  state me : Loop\nend\nclass Around\n  state l : Loop\nend\n"
    found = elaborated(text)
    assert list(found.specification.classes) == ["Lamp", "Dimmer", "Candle"]
    assert [w.message for w in found.warnings] == [
        f"`Loop` is typed, but cannot be run: {HEAP}",
        "`Around` is typed, but cannot be run: it uses `Loop`",
    ]


@pytest.mark.parametrize(
    "claim",
    [
        "assert Loop :[deadlock free]",
        "assert Loop :[obligations]",
        "assert Lamp [OZ= Loop",
        "P = Loop",
        "assert not Lamp [T= Loop",
    ],
)
def test_nothing_is_claimed_of_what_cannot_be_run(claim: str) -> None:
    with pytest.raises(ScriptError) as error:
        elaborated(f"{LAMPS}class Loop\n  state me : Loop\nend\n{claim}\n")
    (found,) = error.value.diagnostics
    assert found.code == "CSP673"
    assert found.message.startswith(f"nothing can be claimed of `Loop`: {HEAP}")


def test_a_mistake_that_has_to_do_with_no_limit_stays_one() -> None:
    text = "class Loop\n  state\n    me : Loop\n    n : nat\n  op step = [n' = 1]\nend\n"
    with pytest.raises(ScriptError) as error:
        elaborated(text)
    assert [d.code for d in error.value.diagnostics] == ["CSP659", "CSP640"]


def test_two_parents_with_different_constants_are_a_mistake() -> None:
    with pytest.raises(ScriptError) as error:
        elaborated("class A\n  size == 1\nend\nclass B\n  size == 2\nend\nclass C\n  inherit A, B\nend\n")
    assert [d.code for d in error.value.diagnostics] == ["CSP657"]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("class A\n  state n : nat; me : power A\n  where me = {self}\nend\n", "an object of `A` within itself"),
        ("class A\n  state n : nat\n  op twice = [a : oid | a = self]\nend\n", "`self` would need a heap"),
        (TYPED["any object"], "`oid` would need a heap"),
        (TYPED["a class under other names"], "objects of the generic class `Cell` as values would need a heap"),
        (TYPED["an operation that is defined by itself"], "`walk` is defined by itself"),
        (LAMPS + "const l : poly Lamp where l in Dimmer end\n", "what it says of the classes of its objects"),
    ],
)
def test_the_reason_is_told_in_words_of_the_document(text: str, reason: str) -> None:
    assert elaborated(text).warnings[0].message.split("cannot be run: ")[1].startswith(reason)


def test_what_the_flattening_makes_is_called_as_the_document_calls_it() -> None:
    text = (
        "Node == Leaf union Fork\nclass Leaf\n  state all : finset Node\nend\n"
        "class Fork\n  state left : Node; all : finset Node\n  op turn = [left.all = {self}]\nend\n"
    )
    told = [w.message for w in elaborated(text).warnings]
    assert any("an object of `Leaf union Fork` within itself" in message for message in told)
    assert not any("_or_" in message for message in told)
