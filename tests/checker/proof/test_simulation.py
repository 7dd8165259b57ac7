"""Data refinement: each rule with classes that keep it and classes that break exactly that."""

from __future__ import annotations

import pytest

from cspcheck.checker.proof.finding import Finding
from cspcheck.checker.proof.simulation import projection, refinement, retrieve
from tests.checker.proof.classes import specification

BUFFER = """
given MSG
class Buffer
  chan put : [m? : MSG]
  chan get : [m! : MSG]
  main = put -> main [] get -> main
  const max : nat1
  state
    items : seq MSG
  where
    #items <= max
  init
    items = <>
  op put
    Delta(items)
    m? : MSG
  where
    items' = items ^ <m?>
  op get
    Delta(items)
    m! : MSG
  where
    items = <m!> ^ items'
end
class Halves
  chan put : [x? : MSG]
  chan get : [y! : MSG]
  main = put -> main [] get -> main
  const top : nat1
  state
    old, new : seq MSG
  where
    #old + #new <= top
  init
    old = <>
    new = <>
  op put
    Delta(new)
    x? : MSG
  where
    new' = new ^ <x?>
  op get
    Delta(old, new)
    y! : MSG
  where
    old ^ new != <>
    y! = head (old ^ new)
    old' = tail (old ^ new)
    new' = <>
end
retrieve R between Buffer and Halves where
  items = old ^ new
  max = top
end
"""

FORK = """
class Fork
  chan a, b : []
  main = a -> main [] b -> main
  state
    s : 0..2
  init
    s in {1, 2}
  op a
    Delta(s)
  where
    s = 1
    s' = 0
  op b
    Delta(s)
  where
    s = 2
    s' = 0
end
class Dead
  chan a, b : []
  main = a -> main [] b -> main
  state
    t : 0..2
  init
    t = 0
  op a
  where
    false
  op b
  where
    false
end
retrieve R between Fork and Dead where
  t = 0 => s in {1, 2}
end
"""


def rules(text: str, *, upward: bool = False) -> list[Finding]:
    spec = specification(text)
    return list(refinement(spec, retrieve(spec.retrieves["R"]), upward=upward))


def broken(text: str, *, upward: bool = False) -> list[str]:
    """The rules that do not hold, each with its operation."""
    return [f"{f.obligation} {f.place}".strip() for f in rules(text, upward=upward) if f.status != "proved"]


def changed(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new, 1)


def test_a_buffer_in_two_halves_is_a_buffer() -> None:
    assert broken(BUFFER) == []
    assert broken(BUFFER, upward=True) == []


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("    old = <>\n    new = <>", "    #old = 1\n    new = <>", ["initial states"]),
        ("    new' = new ^ <x?>", "    #new < 2\n    new' = new ^ <x?>", ["applicability put"]),
        ("    y! = head (old ^ new)", "    y! = last (old ^ new)", ["correctness get"]),
        ("    old' = tail (old ^ new)", "    old' = <>", ["correctness get"]),
        ("    #old + #new <= top", "    #old + #new <= top + 1", ["retrieve relation total", "applicability put back"]),
        ("  items = old ^ new", "  #items = #old + #new\n  #items < 0", ["retrieve relation consistent"]),
        ("  chan put : [x? : MSG]", "  chan put : [x? : MSG]\n  chan drop : []", ["channels"]),
    ],
)
def test_each_rule_is_broken_by_itself(old: str, new: str, expected: list[str]) -> None:
    found = broken(changed(BUFFER, old, new))

    assert found[: len(expected)] == expected


def test_a_broken_rule_has_the_step() -> None:
    found = [
        f for f in rules(changed(BUFFER, "y! = head (old ^ new)", "y! = last (old ^ new)")) if f.status == "refuted"
    ]

    (correctness,) = found
    assert correctness.message == "`Buffer` has no step that matches this one of `Halves`"
    assert {"Buffer.items", "Halves.old", "Halves.new", "m!", "Halves.old'"} <= set(correctness.values)


def test_refusing_everything_does_not_refine_a_choice() -> None:
    """The textbook rule asks for each operation by itself, and accepts this (Bolton and Davies 2002)."""
    assert broken(FORK) == ["applicability a", "applicability b"]
    assert broken(FORK, upward=True) == ["applicability all operations"]
    for operation in ("a", "b"):
        alone = changed(
            FORK, f"  op {operation}\n    Delta(s)\n  where\n    s = {1 if operation == 'a' else 2}\n    s' = 0\n", ""
        )
        alone = changed(alone, f"  op {operation}\n  where\n    false\n", "")
        alone = alone.replace("chan a, b", f"chan {'b' if operation == 'a' else 'a'}").replace(
            "main = a -> main [] b -> main", f"main = {'b' if operation == 'a' else 'a'} -> main"
        )
        assert "applicability all operations" not in broken(alone, upward=True)


LATE = """
class Early
  chan flip : [], out : [v! : 0..1]
  main = flip -> out -> main
  state
    k : 0..1
    on : bool
  init
    on = false
  op flip
    Delta(k, on)
  where
    on = false
    on' = true
  op out
    Delta(k, on)
    v! : 0..1
  where
    on = true
    v! = k
    on' = false
end
class Late
  chan flip : [], out : [v! : 0..1]
  main = flip -> out -> main
  state
    up : bool
  init
    up = false
  op flip
    Delta(up)
  where
    up = false
    up' = true
  op out
    Delta(up)
    v! : 0..1
  where
    up = true
    up' = false
end
retrieve R between Early and Late where
  on = up
end
""".replace("chan flip : [], out : [v! : 0..1]", "chan flip : []\n  chan out : [v! : 0..1]")


def test_a_choice_made_later_needs_upward_simulation() -> None:
    """The abstract class chooses the output when it flips, the concrete one when it puts it out."""
    assert broken(LATE) == ["correctness out"]
    assert broken(LATE, upward=True) == []


def test_guards_must_agree_and_effects_stay_possible() -> None:
    text = """
class A
  chan go : []
  main = go -> main
  state
    n : 0..9
  op enable_go
  where
    n < 9
  op effect_go
    Delta(n)
  where
    n' = n + 1
end
class C
  chan go : []
  main = go -> main
  state
    k : 0..9
  op enable_go
  where
    k < 9
  op effect_go
    Delta(k)
  where
    k' = k + 1
end
retrieve R between A and C where
  n = k
end
"""
    assert broken(text) == []
    assert broken(changed(text, "k < 9", "k < 8")) == ["applicability go"]
    assert broken(changed(text, "k < 9", "k < 10")) == ["applicability go back"]
    assert "definedness go" in broken(changed(text, "k' = k + 1", "k < 5\n    k' = k + 1"))


def test_a_subclass_refines_its_parent_unless_it_takes_something_away() -> None:
    text = """
class Counter
  chan up : []
  main = up -> main
  state
    n : nat
  init
    n = 0
  op up
    Delta(n)
  where
    n' = n + 1
end
class Named
  inherit Counter
  chan rename : [i? : nat]
  main = up -> main [] rename -> main
  state
    name : nat
  op rename
    Delta(name)
    i? : nat
  where
    name' = i?
end
"""

    def told(source: str) -> list[str]:
        spec = specification(source)
        found = refinement(spec, projection(spec, "Counter", "Named"))
        return [f"{f.obligation} {f.place}".strip() for f in found if f.status != "proved"]

    assert told(text) == []
    assert told(changed(text, "    name' = i?\n", "    name' = i?\n  op up\n  where\n    n < 3\n")) == [
        "applicability up"
    ]
    assert told(changed(text, "    Delta(name)", "    Delta(name, n)")) == ["correctness rename"]
