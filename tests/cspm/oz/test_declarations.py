"""Every declaration in a class is a predicate: what it says of a value holds, wherever the value comes from."""

from __future__ import annotations

import pytest

from cspcheck.checker.check import Checker
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from tests.checker.proof.classes import told


def possible(text: str, trace: str, process: str = "C") -> bool:
    """Whether a process of a script has a trace."""
    script = load(Source("classes.csp", text))
    outcome = Checker(script).check(script.assertion(f"{process} :[has trace [T]]: <{trace}>").node)
    assert outcome.verdict.value in ("pass", "fail"), outcome.reason
    return outcome.verdict.value == "pass"


def finds(operations: str, *, main: str = "find -> main", state: str = "n : 0..3", init: str = "n = 2") -> str:
    """A class whose channel ``find`` carries 0..3."""
    lines = "\n".join(f"  {line}" for line in operations.splitlines())
    return f"class C\n  chan find : [k? : 0..3]\n  main = {main}\n  state {state}\n  init {init}\n{lines}\nend\n"


@pytest.mark.parametrize(
    "operations",
    [
        "op find k? : 0..1",
        "op com_find k? : 0..1 where true",
        "op enable_find k? : 0..1",
        "op find k? : {0, 1}",
        "op find k? : (0..3) inter (-4..1)",
        "op narrow k? : 0..1 where true\nop wide k? : 0..3 where true\nop find = wide and narrow",
        "op narrow k? : 0..1 where true\nop wide k? : 0..3 where true\nop find = narrow and wide",
        "op narrow k? : 0..1 where true\nop wide k? : 0..3 where true\nop find = wide ; narrow",
        "op a k? : 0..0 where true\nop b k? : 1..1 where true\nop find = a [] b",
        "op find\n  k? : 0..n - 1",
    ],
)
def test_the_set_of_a_parameter_holds(operations: str) -> None:
    text = finds(operations)
    assert [possible(text, f"find.{k}") for k in range(4)] == [True, True, False, False]


def test_an_input_outside_the_set_of_an_effect_diverges() -> None:
    script = load(Source("c.csp", finds("op enable_find k? : 0..2\nop effect_find k? : 0..1")))
    checker = Checker(script)
    divergent = checker.check(script.assertion("C :[divergence free]").node)
    assert divergent.verdict.value == "fail"
    assert divergent.counterexample is not None
    assert divergent.counterexample.trace == ("find.2",)


def test_a_set_may_depend_on_the_state() -> None:
    text = """
class C
  method find
  chan up
  main = find -> main [] up -> main
  state n : 0..3
  init n = 0
  op find
    s! : 0..n
  op up
    Delta(n)
  where
    n < 3
    n' = n + 1
end
"""
    process = "C::visible"
    assert possible(text, "C::find.0", process)
    assert not possible(text, "C::find.1", process)
    assert possible(text, "up, up, C::find.2", process)
    assert not possible(text, "up, up, C::find.3", process)
    assert all(line.endswith((": proved", "`s!`: refuted")) for line in _findings(text))


def _findings(text: str) -> list[str]:
    from tests.checker.proof.classes import findings

    return told(findings(text))


@pytest.mark.parametrize("order", ["A, B", "B, A"])
def test_what_two_parents_declare_lies_in_both_sets(order: str) -> None:
    text = f"""
class A
  const N : 0..3
  chan go, k : [v : 0..4]
  state n : 0..3
  op go
    Delta(n)
    v : 0..4
  where
    n' = v
end
class B
  const N : 3..5
  chan go, k : [v : 1..5]
  state n : 1..5
  op k v : 1..5 where v = N
end
class C
  inherit {order}
end
"""
    assert [possible(text, f"go.{v}") for v in range(1, 5)] == [True, True, True, False]
    assert [possible(text, f"k.{v}") for v in range(1, 5)] == [False, False, True, False]


def test_a_class_performs_what_it_declares_of_a_channel_that_others_share() -> None:
    text = """
class C
  chan c : [x? : 0..1]
  main = c -> main
end
class Q
  chan c : [x! : 0..3]
  main = c -> SKIP
  op com_c x! : 0..3
end
S = C || Q
"""
    assert possible(text, "c.1")
    assert not possible(text, "c.3")
    assert not possible(text, "c.3", "S")
    assert possible(text, "c.3", "Q")


def test_a_parameter_that_a_child_calls_otherwise_is_the_same() -> None:
    text = """
class A
  chan c : [x? : 0..3]
  state n : 0..3
  init n = 0
  op c
    Delta(n)
    x? : 0..3
  where
    n' = x?
    x? /= n
end
class C
  inherit A
  chan c : [y? : 0..3]
  op c y? : 0..3 where y? > 1
end
"""
    assert [possible(text, f"c.{v}") for v in range(4)] == [False, False, True, True]
    assert not possible(text, "c.2, c.2")


HOLDER = """
T ::= leaf | node<<0..3>>
schema S
  x : 0..3
end
class C
  chan c
  main = c -> main
  state
    n : 0..3
    s : S
    f : 0..1 -> 0..1
    t : T
    q : seq (0..1)
    g : power (0..1)
    p : (0..1) cross (0..1)
  init
    n = 3 and s = (| x == 3 |) and f = {0 |-> 0, 1 |-> 0} and t = leaf and q = <> and g = {} and p = (0, 0)
  op c
    Delta(%s)
  where
    %s
end
"""


@pytest.mark.parametrize(
    ("variable", "inside", "outside"),
    [
        ("n", "n' = n", "n' = n + 1"),
        ("s", "s' = (| x == n |)", "s' = (| x == n + 1 |)"),
        ("f", "f' = f (+) {0 |-> 1}", "f' = f (+) {0 |-> 2}"),
        ("f", "f' = f (+) {0 |-> 1}", "f' = f (+) {2 |-> 0}"),
        ("f", "f' = f", "f' = {0} </| f"),
        ("t", "t' = node(n)", "t' = node(n) and t' notin T"),
        ("q", "#q < 2 and q' = q ^ <1>", "q' = q ^ <2>"),
        ("g", "g' = {1}", "g' = {2}"),
        ("p", "p' = (1, 0)", "p' = (1, 2)"),
        ("n", "exists k : 0..4 @ n' = k and k = 3", "exists k : 0..4 @ n' = k and k = 4"),
        ("n", "n' in {k : 2..5 | k > 2}", "n' in {k : 4..5 | k > 2}"),
        ("n", "n' = #{k : 0..1; j : 0..0 @ (k, j)}", "n' = #{k : 0..1; j : 0..1 @ (k, j)}"),
        ("n", "n' = (lambda k : 0..1 @ k)(1)", "n' = #(lambda k : 0..4 @ k)"),
        ("n", "n' = (mu k : 0..1 | k > 0)", "n' = (mu k : 3..5 | k > 4)"),
    ],
)
def test_values_lie_in_the_sets_of_their_declarations(variable: str, inside: str, outside: str) -> None:
    assert possible(HOLDER % (variable, inside), "c")
    assert not possible(HOLDER % (variable, outside), "c")


def test_two_meanings_of_a_name_are_a_mistake() -> None:
    text = "class A\n  a == 1\nend\nclass B\n  a == 2\nend\nclass C\n  inherit A, B\nend\n"
    with pytest.raises(ScriptError) as caught:
        load(Source("c.csp", text))
    assert [d.message for d in caught.value.diagnostics] == ["`a` of `B` is something else in `A`"]
    assert load(Source("c.csp", text.replace("a == 2", "a == 1")))


@pytest.mark.parametrize("again", ["const a : nat", "state a : nat"])
def test_a_name_is_of_one_kind(again: str) -> None:
    with pytest.raises(ScriptError) as caught:
        load(Source("c.csp", f"class A\n  a == 1\nend\nclass C\n  inherit A\n  {again}\nend\n"))
    assert [d.code for d in caught.value.diagnostics] == ["CSP638"]


def test_types_of_classes_are_told_apart_by_their_names() -> None:
    first = "class A\n  T ::= x | y\nend\n"
    with pytest.raises(ScriptError) as caught:
        load(Source("c.csp", first + "class B\n  T ::= u | v\nend\n"))
    assert [d.code for d in caught.value.diagnostics] == ["CSP638"]
    # Constructors and generic abbreviations are inherited with the types.
    child = "class C\n  inherit A\n  chan c\n  state t : T\n  op c where t = y\nend\n"
    assert load(Source("c.csp", first + child))


def test_nothing_is_said_of_a_variable_that_the_invariant_gives() -> None:
    text = """
class C
  chan c
  state
    n : 0..9
    odd : bool
  where
    odd = true <=> n mod 2 = 1
    %s
  op c
    Delta(n, odd)
  where
    n' = 1
end
"""
    assert load(Source("c.csp", text % "n <= 8")).warnings == ()
    (warning,) = load(Source("c.csp", text.replace("odd = true <=> n mod 2 = 1", "odd = true") % "")).warnings
    assert (warning.code, warning.annotation) == ("CSP641", "gets any value that the invariant allows")
