"""Mistakes that published specifications make, rebuilt, and that they are found."""

from __future__ import annotations

from cspcheck.checker.proof.finding import Finding
from tests.checker.proof.classes import findings, wrong

SHUNT = """
DIRECTION ::= LEFT | RIGHT | UP | DOWN
class Shunter
  chan move : [d? : DIRECTION]
  main = move -> main
  state
    posn : int
  init
    posn = 24
  op move
    Delta(posn)
    d? : DIRECTION
  where
    d? = LEFT => posn' = posn - 1
    d? = RIGHT => posn' = posn + 1
    d? = UP => posn' = posn - 7
    d? = DOWN => POSN = posn + 7
end
"""


def refuted(text: str) -> dict[str, Finding]:
    return {f"{f.obligation} {f.place}": f for f in findings(text) if f.status == "refuted"}


def test_a_missing_prime_makes_one_direction_impossible() -> None:
    """In a shunting puzzle: types, invariant and initialisation are right, and no state lets the engine go down."""
    found = refuted(SHUNT.replace("POSN", "posn"))

    assert list(found) == ["inputs usable move `d? = DOWN`", "branch reachable move `d? = DOWN`"]
    reasons = found["inputs usable move `d? = DOWN`"].lines
    assert [span.text for span in reasons] == ["d? = DOWN => posn = posn + 7"]
    assert wrong(SHUNT.replace("POSN", "posn'")) == []


MAZE = """
given NODE
DIRECTION ::= LEFT | RIGHT
class Walker
  chan step : [d? : DIRECTION]
  main = step -> main
  const root : NODE
  const next : DIRECTION cross NODE cross NODE -|-> NODE
  state
    here : NODE
  where
    forall d : DIRECTION @ (d, root, here) in dom next
  init
    here = root
  op step
    Delta(here)
    d? : DIRECTION
  where
    here' = next(ARGUMENTS)
end
"""


def test_swapped_arguments_of_one_type() -> None:
    """Types cannot tell the two nodes apart; the domain can."""
    swapped = findings(MAZE.replace("ARGUMENTS", "d?, here, root"), "applied in domain")
    right = findings(MAZE.replace("ARGUMENTS", "d?, root, here"), "applied in domain")

    assert [f.status for f in swapped] == ["refuted"]
    assert swapped[0].failing == "(d?, here, root) in dom next"
    assert [f.status for f in right] == ["proved"]


TREE = """
given KEY, VALUE
class Store
  chan read : [v! : VALUE]
  main = read -> main
  const content : KEY -|-> VALUE
  state
    current : KEY
  op read
    v! : VALUE
  where
    current in dom content => v! = content(current)
MORE
end
"""


def test_an_implication_leaves_the_output_open() -> None:
    """When the condition fails, nothing is said of the output."""
    assert "output defined read `v!`" in refuted(TREE.replace("MORE", ""))
    assert "output defined read `v!`" not in refuted(TREE.replace("MORE", "    current in dom content"))


def test_a_subclass_says_again_what_the_delta_list_says() -> None:
    """``n' = n`` of a variable outside the Delta-list is no mistake; inside, it is told that it never changes."""
    text = """
class Parent
  chan go : []
  main = go -> main
  state
    n, k : nat
  op go
    Delta(n)
  where
    n' = n + 1
end
class Child
  inherit Parent
  main = go -> main
  op go
    Delta(k)
  where
    k' = k
end
"""
    assert wrong(text) == ["delta changes go `k`"]


VEHICLE = """
STATUS ::= normal | alert
class AvoidCollision
  method generateAvoid
  main = generateAvoid -> main
  const LIMIT : real
  state
    avoidData : STATUS
    sonars : 0..3 -> real
  op generateAvoid
    Delta(avoidData)
  where
    EFFECT
end
"""


def test_a_universal_conditional_blocks_where_its_cases_differ() -> None:
    """In a vehicle's collision avoidance: each of four sonars decides, and two that disagree leave no status at all."""
    each = "forall i : 0..3 @ if sonars(i) > LIMIT then avoidData' = alert else avoidData' = normal"
    some = "if exists i : 0..3 @ sonars(i) > LIMIT then avoidData' = alert else avoidData' = normal"
    guarded = "op effect_generateAvoid"

    def divergent(effect: str) -> list[str]:
        text = VEHICLE.replace("EFFECT", effect).replace("op generateAvoid", guarded)
        return [f.status for f in findings(text, "guard covers effect")]

    assert divergent(each) == ["refuted"]
    assert divergent(some) == ["proved"]
