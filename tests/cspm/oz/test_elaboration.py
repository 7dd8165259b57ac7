"""From the text of classes to typed terms and flattened classes, and what is said where that fails."""

from __future__ import annotations

import random
import re

import pytest

import cspcheck.cspm.oz.typing.messages
import cspcheck.cspm.oz.typing.type_messages  # noqa: F401 -- both register their mistakes
from cspcheck.cspm.diagnostics import MISTAKES, Diagnostic, ScriptError
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.typing.elaboration import Elaborated, elaborate
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.source import Source

CODES = sorted(code for code in MISTAKES if "CSP630" <= code < "CSP680")


def elaborated(text: str) -> Elaborated:
    return elaborate(parse(Source("test.csp", text)))


def diagnostics(text: str) -> list[Diagnostic]:
    try:
        return list(elaborated(text).warnings)
    except ScriptError as error:
        return list(error.diagnostics)


def told(text: str) -> list[str]:
    """What is said of a script, each with its line."""
    return [f"{d.span.line if d.span else '-'}: {d.code} {d.message}" for d in diagnostics(text)]


def with_state(declarations: str, predicate: str = "true", more: str = "") -> str:
    state = "\n    ".join(declarations.split("; "))
    return (
        f"{more}\nclass C\n  chan c : [a : nat; i? : nat; o! : nat]\n  main = c -> main\n  state\n    {state}\n"
        f"  op c\n    Delta(x)\n    a : nat\n    i? : nat\n    o! : nat\n  where\n    {predicate}\nend\n"
    )


def effect(predicate: str, declarations: str = "x, y : nat", more: str = "") -> core.Term:
    text = with_state(declarations, predicate, more)
    return elaborated(text).specification.classes["C"].operations["c"].effect[0]


@pytest.mark.parametrize("code", CODES)
def test_the_example_makes_the_mistake_and_the_repair_does_not(code: str) -> None:
    mistake = MISTAKES[code]
    assert code in {diagnostic.code for diagnostic in diagnostics(mistake.example)}
    assert diagnostics(mistake.repair) == []


@pytest.mark.parametrize("code", CODES)
def test_titles_and_explanations_are_sentences(code: str) -> None:
    mistake = MISTAKES[code]
    assert mistake.title == mistake.title.strip(". ")
    assert mistake.explanation.endswith(".")
    assert len(mistake.title) < 80


@pytest.mark.parametrize(
    ("expression", "declarations", "type_"),
    [
        ("x + 1", "x : nat", "int"),
        ("x + 0.5", "x : nat", "real"),
        ("<1, 2> ^ <x>", "x : nat", "seq int"),
        ("{1, x} union {}", "x : nat", "power int"),
        ("(x, {x})", "x : nat", "(int cross power int)"),
        ("{n : 1..3 | n > x @ n |-> true}", "x : nat", "power (int cross bool)"),
        ("lambda n : nat @ n + x", "x : nat", "(int pfun int)"),
        ("f (+) {1 |-> x}", "x : nat; f : nat -|-> nat", "(int pfun int)"),
        ("f (+) {}", "x : nat; f : nat -|-> nat", "(int pfun int)"),
        ("dom s", "x : nat; s : seq bool", "power int"),
        ("ran s", "x : nat; s : seq bool", "power bool"),
        ("s(1)", "x : nat; s : seq bool", "bool"),
        ("head s", "x : nat; s : seq bool", "bool"),
        ("#s", "x : nat; s : seq bool", "int"),
        ("f~", "x : nat; f : nat -|-> bool", "power (bool cross int)"),
        ("f(| {1} |)", "x : nat; f : nat -|-> bool", "power bool"),
        ("{1} <| f", "x : nat; f : nat -|-> bool", "(int pfun bool)"),
        ("first((x, true))", "x : nat", "int"),
        ("bigunion {{1}, {x}}", "x : nat", "power int"),
        ("items(<x>)", "x : nat", "bag int"),
        ("if x > 1 then 1 else 0.5", "x : nat", "real"),
        ("mu n : nat | n = x @ n", "x : nat", "int"),
        ("let n == x + 1 @ n * n", "x : nat", "int"),
        ("max {1, x}", "x : nat", "int"),
    ],
)
def test_expressions_have_types(expression: str, declarations: str, type_: str) -> None:
    term = effect(f"({expression}) = ({expression})", declarations)
    assert isinstance(term, core.Apply)
    assert term.operator == "equal"
    assert str(term.operands[0].type) == type_


def test_integers_stand_for_reals_and_literals_become_them() -> None:
    term = effect("r = 1", "x : nat; r : real")
    assert isinstance(term, core.Apply)
    assert isinstance(term.operands[1], core.Constant)
    assert (term.operands[1].type, term.operands[1].value) == (core.REAL, 1)
    mixed = effect("r < x", "x : nat; r : real")
    assert isinstance(mixed, core.Apply)
    assert isinstance(mixed.operands[1], core.Apply)
    assert mixed.operands[1].operator == "int_to_real"


def test_the_type_of_an_empty_collection_must_be_said() -> None:
    (message,) = told(with_state("x : nat", "x' = #(<> ^ <>)"))
    assert message.endswith("CSP634 what this empty collection could hold is not said")


def test_roles_are_those_of_the_decorations() -> None:
    term = effect("x' = x + i? + o! + a")
    names = set()
    pending = [term]
    while pending:
        part = pending.pop()
        if isinstance(part, core.Variable):
            names.add((part.name, part.role))
        pending.extend(core.parts(part))
    assert names == {("x", "after"), ("x", "before"), ("i", "input"), ("o", "output"), ("a", "simple")}


def test_an_interval_written_as_a_comprehension_is_a_range() -> None:
    model = elaborated("DATA == {v : nat | 0 <= v <= 10}\n" + with_state("x : DATA")).specification.classes["C"]
    carrier = model.primary[0].carrier
    assert isinstance(carrier, core.Apply)
    assert carrier.operator == "range"
    assert [operand.value for operand in carrier.operands if isinstance(operand, core.Constant)] == [0, 10]


def test_types_of_the_script_are_types_of_classes() -> None:
    text = "datatype Colour = red | green\nN = 2 + 1\nnametype Small = {0..N}\n" + with_state(
        "x : Small; k : Colour", "x' = N and k = red"
    )
    found = elaborated(text).specification
    assert found.frees["Colour"].branches == (("red", None), ("green", None))
    assert str(found.classes["C"].primary[1].type) == "Colour"


def test_schemas_of_an_event_and_their_forms() -> None:
    text = (
        "class C\n  chan a, b, c, d\n  main = a -> b -> c -> d -> main\n  state\n    x : nat\n"
        "  op a\n    Delta(x)\n  where\n    x' = 1\n"
        "  op enable_b\n  where\n    x > 0\n  op effect_b\n    Delta(x)\n  where\n    x' = 2\n"
        "  op effect_c\n    Delta(x)\n  where\n    x' = 3\n"
        "  op enable_d\n  where\n    x = 3\nend\n"
    )
    operations = elaborated(text).specification.classes["C"].operations
    assert {name: o.form for name, o in operations.items()} == {
        "a": "com",
        "b": "guarded",
        "c": "effect",
        "d": "enable",
    }
    assert [len(operations[name].guard) for name in "abcd"] == [0, 1, 0, 1]


def test_parameters_take_their_decoration_from_the_schema_where_the_channel_has_none() -> None:
    text = (
        "class C\n  chan c : [v : nat; w : nat]\n  main = c -> main\n  state\n    x : nat\n"
        "  op com_c\n    v? : nat\n    w! : nat\n  where\n    w! = v?\nend\n"
    )
    model = elaborated(text).specification.classes["C"]
    assert [(p.name, p.kind) for p in model.channels["c"].parameters] == [("v", "input"), ("w", "output")]
    assert model.operations["c"].parameters == model.channels["c"].parameters


INHERITED = """\
class Base
  method tick
  main = tick -> main
  const PERIOD : nat where PERIOD = 100
  state
    next : nat
  where
    next > 0
  init
    next = 1
  op tick
    Delta(next)
  where
    next' = next + PERIOD
end
class Child
  inherit Base
  chan c : [v! : nat]
  main = c -> tick -> main
  state
    seen : nat
  init
    seen = 0
  op com_c
    Delta(seen)
    v! : nat
  where
    v! = seen
    seen' = seen + next
  op tick
    Delta(seen)
  where
    seen' = 0
end
"""


def test_a_child_has_all_that_its_parent_has() -> None:
    model = elaborated(INHERITED).specification.classes["Child"]
    assert model.parents == ("Base",)
    assert [v.name for v in model.primary] == ["next", "seen"]
    assert [c.name for c in model.constants] == ["PERIOD"]
    assert len(model.axioms) == 1
    assert len(model.invariant) == 1
    assert model.initial is not None
    assert len(model.initial) == 2
    assert list(model.channels) == ["tick", "c"]
    assert model.operations["tick"].delta == ("next", "seen")
    assert len(model.operations["tick"].effect) == 2
    assert [part.owner for part in model.processes] == ["Base", "Child"]


def test_a_parent_can_be_renamed() -> None:
    text = INHERITED.replace("inherit Base", "inherit Base[step/tick]").replace("c -> tick", "c -> step")
    text = text.replace("  op tick\n    Delta(seen)", "  op step\n    Delta(seen)")
    model = elaborated(text).specification.classes["Child"]
    assert list(model.operations) == ["step", "c"]
    assert "step" in repr(model.processes[0].equations)
    assert "tick" not in repr(model.processes[0].equations)


STACK = """\
class Stack[T]
  chan push : [item? : T]
  chan pop : [item! : T]
  main = push -> main [] pop -> main
  state
    items : seq T
  init
    items = <>
  op push
    Delta(items)
    item? : T
  where
    items' = <item?> ^ items
  op pop
    Delta(items)
    item! : T
  where
    items = <item!> ^ items'
end
class Numbers
  inherit Stack[nat]
  main = push -> main
end
"""


def test_generic_parameters_are_given_sets_until_they_are_known() -> None:
    found = elaborated(STACK)
    stack, numbers = found.specification.classes["Stack"], found.specification.classes["Numbers"]
    assert str(stack.primary[0].type) == "seq T"
    assert "T" in found.specification.givens
    assert str(numbers.primary[0].type) == "seq int"
    argument = parse(Source("", "reading bool = {true}")).declarations[0]
    instance = found.instance("Stack", (argument.subject,))  # type: ignore[attr-defined]
    assert str(instance.primary[0].type) == "seq bool"


def test_operations_defined_from_others() -> None:
    text = (
        "class C\n  chan both, either, after\n  main = both -> either -> after -> main\n  state\n    x, y : nat\n"
        "  op a\n    Delta(x)\n  where\n    x' = 1\n  op b\n    Delta(y)\n  where\n    y' = x\n"
        "  op both = a and b\n  op either = a [] b\n  op after = a ; b\nend\n"
    )
    operations = elaborated(text).specification.classes["C"].operations
    assert {name: o.delta for name, o in operations.items()} == dict.fromkeys(("both", "either", "after"), ("x", "y"))
    assert len(operations["both"].effect) == 2
    (choice,) = operations["either"].effect
    assert isinstance(choice, core.Apply)
    assert choice.operator == "or"
    (sequence,) = operations["after"].effect
    assert isinstance(sequence, core.Quantifier)
    assert [binder.written for binder in sequence.binders] == ["x", "y"]


def test_retrieve_relations_speak_of_both_classes() -> None:
    text = STACK + (
        "class Array[T]\n  chan push : [item? : T]\n  main = push -> main\n"
        "  state\n    items : seq T\n    top : nat\nend\n"
        "retrieve R between Stack and Array where\n  Stack.items = Array.items\n  top = #Stack.items\nend\n"
    )
    relation = elaborated(text).specification.retrieves["R"]
    assert (relation.abstract, relation.concrete, len(relation.predicates)) == ("Stack", "Array", 2)
    assert "CSP630 both classes have `items`" in told(text.replace("#Stack.items", "#items"))[0]


def test_readings() -> None:
    text = "given ITEM\nreading ITEM = 2\nreading real = {-1, 0, 1/2}\nreading seq ITEM = 3\n"
    items, reals, sequences = elaborated(text).specification.readings
    assert (items.text, items.bound, items.values) == ("ITEM", 2, None)
    assert reals.values is not None
    assert str(reals.values.type) == "power real"
    assert (sequences.text, sequences.bound) == ("seq ITEM", 3)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (with_state("x : nat", "x' = direcshun", "const direction : nat end"), "did you mean `direction`?"),
        (with_state("x : nat", "x' = i"), "the parameter is written `i?`"),
        (with_state("x : nat", "x' = i!"), "did you mean `i?`?"),
        (with_state("x, y : nat", "y' = 1"), "add `y` to the Delta-list"),
    ],
)
def test_help_says_what_to_write(text: str, expected: str) -> None:
    assert expected in [diagnostic.help for diagnostic in diagnostics(text)]


def test_one_wrong_declaration_makes_one_message() -> None:
    assert told(with_state("x : nat; y : nothing", "x' = y + y\n    y > 0")) == [
        "7: CSP630 `nothing` is not known here"
    ]


def test_several_mistakes_are_told_at_once() -> None:
    text = with_state("x : nat", "x' = oops\n    {x} = 1\n    x' = 1 and z' = 2")
    assert [message.split(" ")[1] for message in told(text)] == ["CSP630", "CSP631", "CSP630"]


def test_a_unary_minus_on_a_record_is_refused() -> None:
    record = "schema Data\n  vx : real\nend"
    (message,) = told(with_state("x : nat; d : Data", "x' = 0 and d = -d", record))
    assert message.endswith("CSP632 a number is needed here, not a value of type `Data`")


def test_an_implication_without_a_prime_is_noticed() -> None:
    """The commonest slip in published specifications: a branch that compares where it should assign."""
    directions = "DIRECTION ::= LEFT | DOWN"
    text = with_state("x : nat; d : DIRECTION", "d = LEFT => x' = x - 1\n    d = DOWN => x = x + 7", directions)
    assert [d.code for d in diagnostics(text)] == ["CSP643"]
    assert diagnostics(text.replace("DOWN => x =", "DOWN => x' =")) == []


def test_damaged_scripts_end_in_diagnostics() -> None:
    """Pieces of one script put in other places: names, types and decorations go wrong in every way."""
    chance = random.Random(7)
    text = STACK + INHERITED.replace("class Child", "class Child2")
    words = re.findall(r"\w+[?!']?|\S", text)
    pattern = re.compile(r"\w+[?!']?")
    for _ in range(400):
        damaged = text
        for _ in range(chance.randint(1, 4)):
            places = [match.span() for match in pattern.finditer(damaged)]
            start, end = chance.choice(places)
            damaged = damaged[:start] + chance.choice(words) + damaged[end:]
        for diagnostic in diagnostics(damaged):
            assert diagnostic.code.startswith("CSP")
