"""Processes of classes with unbounded data, decided for all values."""

from __future__ import annotations

import pytest

from cspcheck.checker.check import Checker
from cspcheck.checker.proof.unbounded.answering import for_all_values
from cspcheck.checker.verdict import Outcome, Verdict
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source


def checked(text: str, assertion: str) -> Outcome:
    """What a user is told."""
    script = load(Source("test.csp", text))
    return Checker(script).check(script.assertion(assertion).node)


def invariant(outcome: Outcome) -> list[str]:
    """The invariants that were found."""
    return [remark for remark in outcome.remarks if remark.startswith("invariant")]


BUFFERS = """given ITEM
class Buffer
  chan put : [x? : ITEM]
  chan get : [x! : ITEM]
  state s : seq ITEM
  init s = <>
  op com_put Delta(s) x? : ITEM where s' = s ^ <x?>
  op com_get Delta(s) x! : ITEM where s /= <> and x! = head s and s' = tail s
end
class Bounded
  chan put : [x? : ITEM]
  chan get : [x! : ITEM]
  state s : seq ITEM where #s <= 2 end
  init s = <>
  op com_put Delta(s) x? : ITEM where s' = s ^ <x?>
  op com_get Delta(s) x! : ITEM where s /= <> and x! = head s and s' = tail s
end
"""


def test_an_unbounded_buffer_never_deadlocks() -> None:
    outcome = checked(BUFFERS, "Buffer :[deadlock free]")
    assert outcome.verdict is Verdict.PASS
    assert outcome.remarks == ("proved for all values of the data, whatever its size",)


def test_a_bounded_buffer_does_what_an_unbounded_one_does_but_refuses_more() -> None:
    traces = checked(BUFFERS, "Buffer [T= Bounded")
    assert traces.verdict is Verdict.PASS
    assert invariant(traces) == ["invariant where `get`, `put` is possible: `Bounded.s = Buffer.s`"]
    failures = checked(BUFFERS, "Buffer [F= Bounded")
    assert failures.verdict is Verdict.FAIL
    assert failures.counterexample is not None
    assert failures.counterexample.kind == "refusal"
    assert [event.split(".")[0] for event in failures.counterexample.trace] == ["put", "put"]
    (bounded,) = failures.counterexample.components
    assert (bounded.name, bounded.offers) == ("Bounded", ("get",))
    assert bounded.variables == {"s": "<>"}


RING = """const N : nat1 where N >= 2 end
class Ring
  chan pass
  chan enter, leave : [i : nat]
  state token : nat; inside : bool where token < N end
  init token = 0 and inside = false
  op com_pass Delta(token) where inside = false and token' = (token + 1) mod N
  op com_enter Delta(inside) i : nat where i = token and inside = false and inside' = true
  op com_leave Delta(inside) i : nat where i = token and inside = true and inside' = false
end
"""


def test_a_token_ring_of_any_size_never_deadlocks() -> None:
    outcome = checked(RING, "Ring :[deadlock free]")
    assert (outcome.verdict, outcome.readings) == (Verdict.PASS, ())
    assert "all values" in outcome.remarks[0]


def test_a_ring_that_is_right_for_small_sizes_only_is_refuted_with_a_size_for_which_it_is_not() -> None:
    text = RING.replace("where inside = false and token'", "where token /= 4 and inside = false and token'")
    text = text.replace("where i = token and inside = false", "where i = token and token < 4 and inside = false")
    outcome = checked(text, "Ring :[deadlock free]")
    assert outcome.verdict is Verdict.FAIL
    assert outcome.counterexample is not None
    assert outcome.counterexample.trace == ("pass", "pass", "pass", "pass")
    assert outcome.remarks[-1] == "where N = 5"


NUMBERS = """class Pair
  chan up, down, swap
  main = up -> B
  B = down -> main [] swap -> B
  state x, y : int
  init x = 0 and y = 0
  op com_up Delta(x, y) where x' = x + 1 and y' = y + 1
  op com_down Delta(x, y) where x = y and x' = x - 1 and y' = y - 1
  op com_swap Delta(x) where x > 100 and x' = x
end
class Stuck
  chan a, b
  main = a -> b -> main
  state n : int
  init n = 0
  op com_a Delta(n) where n' = n + 3
  op com_b Delta(n) where n < 9 and n' = n + 1
end
class Sum
  chan step
  state i, s : int
  init i = 0 and s = 0
  op com_step Delta(i, s) where 2*s = i*(i+1) and i' = i + 1 and s' = s + i + 1
end
class Producer
  chan put : [x? : int]
  chan mid : [x! : int]
  main = put -> mid -> main
  state a : int
  op com_put Delta(a) x? : int where a' = x?
  op com_mid x! : int where x! = a
end
class Consumer
  chan mid : [x? : int]
  chan got : [x! : int]
  main = mid -> got -> main
  state b : int
  op com_mid Delta(b) x? : int where x? >= 0 and b' = x?
  op com_got x! : int where x! = b
end
class Diverging
  chan go : [x? : int]
  state n : int
  op enable_go x? : int where x? > 0
  op effect_go Delta(n) x? : int where x? > 1 and n' = x?
end
"""


@pytest.mark.parametrize(
    ("name", "invariants"),
    [
        (
            "Pair",
            [
                "invariant where `up` is possible: `x = y`",
                "invariant where `down`, `swap` is possible: `x = y or 100 < x`",
            ],
        ),
        ("Sum", ["invariant where `step` is possible: `2 * s = i * (i + 1)`"]),
    ],
)
def test_the_invariant_that_was_found_is_told(name: str, invariants: list[str]) -> None:
    script = load(Source("test.csp", NUMBERS))
    outcome = for_all_values(script.assertion(f"{name} :[deadlock free]").node, script)
    assert outcome is not None
    assert outcome.verdict is Verdict.PASS
    assert invariant(outcome) == invariants


def test_a_deadlock_is_a_run_with_values_that_the_evaluator_has_seen() -> None:
    script = load(Source("test.csp", NUMBERS))
    outcome = for_all_values(script.assertion("Stuck :[deadlock free]").node, script)
    assert outcome is not None
    found = outcome.counterexample
    assert found is not None
    assert (found.kind, found.trace) == ("deadlock", ("a", "b", "a", "b", "a"))
    (stuck,) = found.components
    assert stuck.variables == {"n": "0"}
    assert [change["n"] for change in stuck.changes] == ["3", "4", "7", "8", "11"]


def test_a_composition_deadlocks_where_a_class_chooses_what_the_other_refuses() -> None:
    outcome = checked(NUMBERS, "Producer || Consumer :[deadlock free]")
    assert outcome.verdict is Verdict.FAIL
    assert outcome.counterexample is not None
    (event,) = outcome.counterexample.trace
    assert event.startswith("put.-")
    kind = NUMBERS.replace("chan put : [x? : int]", "chan put : [x? : nat]").replace(
        "x? : int where a'", "x? : nat where a'"
    )
    assert checked(kind, "Producer || Consumer :[deadlock free]").verdict is Verdict.PASS


def test_a_guard_that_does_not_cover_its_effect_is_never_taken_for_a_refusal() -> None:
    with pytest.raises(ScriptError, match="CSP681"):
        checked(NUMBERS, "Diverging :[deadlock free]")


def test_what_is_not_decided_is_said_with_the_bound_that_was_reached() -> None:
    text = """class C
  chan a
  state n, m : nat
  init n = 0 and m = 1
  op com_a Delta(n, m) where n < 1000 and n' = n + 1 and m' = m + m
end
"""
    script = load(Source("test.csp", text))
    outcome = for_all_values(script.assertion("C :[deadlock free]").node, script)
    assert outcome is not None
    assert outcome.verdict is Verdict.UNKNOWN
    assert outcome.reason == (
        "no invariant was found that proves it; no run of at most 8 steps refutes it, for any values"
    )


def test_a_process_that_looks_at_values_is_left_to_the_search() -> None:
    text = NUMBERS.replace("main = put -> mid -> main", "main = put?v -> mid!v -> main")
    script = load(Source("test.csp", text))
    outcome = for_all_values(script.assertion("Producer :[deadlock free]").node, script)
    assert outcome is not None
    assert (outcome.verdict, outcome.reason) == (Verdict.UNKNOWN, "its process equations look at the values of `put?v`")


def test_the_data_part_of_a_vehicle_is_checked_for_all_readings_of_its_sonars() -> None:
    text = """STATUS ::= normal | alert
class Avoid
  chan getSonarReadings : [readings? : seq real]
  chan avoid_move : [avoidCollData! : STATUS]
  method generateAvoid
  main = getSonarReadings -> generateAvoid -> avoid_move -> main
  state avoidData : STATUS; sonars : seq real where #sonars = 4 end
  init avoidData = normal
  op com_getSonarReadings Delta(sonars) readings? : seq real where #readings? = 4 and sonars' = readings?
  op generateAvoid Delta(avoidData) where
    PREDICATE
  end
  op com_avoid_move avoidCollData! : STATUS where avoidCollData! = avoidData
end
"""
    repaired = "if exists i : 1..4 @ sonars(i) > 1/2 then avoidData' = alert else avoidData' = normal"
    printed = "forall i : 1..4 @ if sonars(i) > 1/2 then avoidData' = alert else avoidData' = normal"
    assert checked(text.replace("PREDICATE", repaired), "Avoid :[deadlock free]").verdict is Verdict.PASS
    wrong = checked(text.replace("PREDICATE", printed), "Avoid :[deadlock free]")
    assert wrong.verdict is Verdict.FAIL
    assert wrong.counterexample is not None
    assert len(wrong.counterexample.trace) == 1


def test_a_constructor_where_an_event_binds_a_value_is_a_constant() -> None:
    text = """STATUS ::= normal | alert
class C
  chan set : [s? : STATUS]
  main = set?alert -> main
  op com_set s? : STATUS where s? = normal
end
"""
    script = load(Source("test.csp", text))
    outcome = for_all_values(script.assertion("C :[deadlock free]").node, script)
    assert outcome is not None
    assert (outcome.verdict, outcome.reason) == (
        Verdict.UNKNOWN,
        "its process equations look at the values of `set?alert`",
    )
    assert checked(text, "C :[deadlock free]").verdict is Verdict.FAIL


def test_a_channel_whose_values_the_script_declares_is_left_to_the_search() -> None:
    text = """channel put : {0..3}
class C
  chan put : [x? : nat]
  state n : nat
  init n = 0
  op com_put Delta(n) x? : nat where n < 4 and n' = x?
end
"""
    script = load(Source("test.csp", text))
    outcome = for_all_values(script.assertion("C :[deadlock free]").node, script)
    assert outcome is not None
    assert (outcome.verdict, outcome.reason) == (Verdict.UNKNOWN, "the script declares what `put` carries")


def test_channels_of_a_generic_class_are_its_own_and_those_of_its_instances_are_shared() -> None:
    text = """given ITEM
class Stack[T]
  chan push : [x? : T]
  state s : seq T
  init s = <>
  op com_push Delta(s) x? : T where s' = <x?> ^ s
end
class Items inherit Stack[ITEM] end
class Once
  chan push : [x? : ITEM]
  main = push -> STOP
end
"""
    apart = checked(text, "Stack || Once :[deadlock free]")
    assert apart.verdict is Verdict.PASS
    met = checked(text, "Items || Once :[deadlock free]")
    assert met.verdict is Verdict.FAIL
    assert met.counterexample is not None
    assert met.counterexample.trace == ("push.ITEM_1",)


def test_why_it_is_not_decided_for_all_values_is_told_beside_what_the_search_says() -> None:
    text = """reading nat = 0..3
class Grow
  chan a
  chan b : [x! : nat]
  state n : nat
  init n = 0
  op com_a Delta(n) where n' = n + 1
  op com_b x! : nat where x! = n
end
"""
    outcome = checked(text, "Grow [F= Grow")
    assert outcome.verdict is Verdict.UNKNOWN
    assert outcome.remarks[-1] == "not decided for all values: a class occurs twice"
    with pytest.raises(ScriptError) as error:
        checked(NUMBERS, "Diverging :[deadlock free]")
    (diagnostic,) = error.value.diagnostics
    assert diagnostic.notes[-1].startswith("not decided for all values: no invariant was found")
