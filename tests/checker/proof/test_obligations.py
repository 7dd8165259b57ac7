"""Each obligation: a class for which it holds, and one that violates exactly that."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cspcheck.checker.proof.obligations import OBLIGATIONS
from cspcheck.checker.proof.question import Impossible, Question, SolverSettings
from cspcheck.checker.proof.solver import Solver
from tests.checker.proof.classes import cell, findings, prover, told, wrong

GOOD = cell(invariant="n <= 9", effect="n < 9; n' = n + 1")

CASES: dict[str, tuple[str, str, list[str]]] = {
    # obligation: a class for which it holds, one for which it does not, everything that is refuted of the latter
    "axioms consistent": (
        cell(inside="const max : nat where 3 <= max <= 9", invariant="n <= max", effect="n < max; n' = n + 1"),
        cell(inside="const max : nat where max < 3 and max > 5", effect="n' = n + 1"),
        ["axioms consistent"],
    ),
    "lemma": (
        cell(inside="lemma odd : forall i : nat @ (2 * i + 1) mod 2 = 1", effect="n' = n + 1"),
        cell(inside="lemma odd : forall i : nat @ 3 * i mod 2 = 1", effect="n' = n + 1"),
        ["lemma `odd`"],
    ),
    "state inhabited": (
        GOOD,
        cell(invariant="n > 3; n < 2", init="n > 3; n < 2", effect="n' = n"),
        ["state inhabited", "initialisation", "feasible go"],
    ),
    "initialisation": (
        GOOD,
        cell(invariant="n <= 9", init="n = 0; n = 1", effect="n < 9; n' = n + 1"),
        ["initialisation"],
    ),
    "initial invariant": (
        GOOD,
        cell(invariant="n <= 9", init="n < 20", effect="n < 9; n' = n + 1"),
        ["initial invariant `n <= 9`"],
    ),
    "feasible": (GOOD, cell(invariant="n <= 9", effect="n > 9; n' = n - 1"), ["feasible go"]),
    "invariant preserved": (
        GOOD,
        cell(invariant="n <= 9", effect="n' = n + 1"),
        ["invariant preserved go `n <= 9`"],
    ),
    "total function": (
        cell(state="f : 0..2 -> nat", init="f(0) = 0", delta="f", effect="f' = f (+) {1 |-> 5}"),
        cell(
            state="f : 0..2 -> nat", init="f(0) = 0", delta="f", parameters="i? : nat", effect="f' = f (+) {i? |-> 5}"
        ),
        ["total function go `f'`"],
    ),
    "carrier kept": (
        cell(state="n : 0..9", effect="n < 9; n' = n + 1"),
        cell(state="n : 0..9", effect="n' = n + 1"),
        ["carrier kept go `n'`"],
    ),
    "alternative kept": (
        cell(state="n : 0..9", effect="n = 9 and n' = 0 or n < 9 and n' = n + 1"),
        cell(state="n : 0..9", effect="n = 9 and n' = 0 or n <= 9 and n' = n + 1"),
        ["alternative kept go `n <= 9 and n' = n + 1`"],
    ),
    "guard covers effect": (
        cell(state="n : 0..9", enable="n < 9", effect="n' = n + 1"),
        cell(state="n : int", enable="n < 9", effect="n' = n + 1; n' > 0"),
        ["guard covers effect go", "guard is precondition go"],
    ),
    "guard satisfiable": (
        cell(state="n : 0..9", enable="n < 9", effect="n' = n + 1"),
        cell(state="n : 0..9", enable="n > 9", effect="n' = n"),
        ["feasible go", "guard satisfiable go", "guard is precondition go"],
    ),
    "guard not redundant": (
        cell(state="n : 0..9", enable="n < 9", effect="n' = n + 1"),
        cell(state="n : 0..9", enable="n < 10", effect="n' = 9 - n"),
        ["guard not redundant go"],
    ),
    "guard is precondition": (
        cell(state="n : 0..9", enable="n < 9", effect="n < 9; n' = n + 1"),
        cell(state="n : 0..9", enable="n < 8", effect="n < 9; n' = n + 1"),
        ["guard is precondition go"],
    ),
    "inputs usable": (
        cell(state="n : 0..9", parameters="i? : 0..2", effect="n' = i?"),
        cell(state="n : 0..9", parameters="i? : 0..2", effect="i? < 2; n' = i?"),
        ["inputs usable go `i? = 2`"],
    ),
    "branch reachable": (
        cell(state="n : 0..9", parameters="i? : nat", effect="i? > 5 => n' = 1; i? <= 5 => n' = 0"),
        cell(state="n : 0..9", parameters="i? : nat", effect="i? = 7 => n' > 9; n' = 3"),
        ["branch reachable go `i? = 7`"],
    ),
    "deterministic operation": (
        GOOD,
        cell(state="n : 0..9", effect="n' in {1, 2}"),
        ["deterministic operation go `n'`"],
    ),
    "output defined": (
        cell(parameters="o! : nat", effect="o! = n; n' = n + 1"),
        cell(parameters="o! : nat", effect="n > 3 => o! = n; n' = n + 1"),
        ["deterministic operation go `o!`", "output defined go `o!`"],
    ),
    "delta changes": (GOOD, cell(effect="n' = n"), ["delta changes go `n`"]),
    "applied in domain": (
        cell(state="n : nat; s : seq nat", init="s = <>", effect="s != <>; n' = head s"),
        cell(state="n : nat; s : seq nat", init="s = <>", effect="n' = head s"),
        ["applied in domain go `head(s)`"],
    ),
    "no blocked control state": (
        cell(state="n : 0..9", effect="n' = 9 - n", main="go -> main"),
        cell(state="n : 0..9", effect="n < 9; n' = n + 1", main="go -> main"),
        ["no blocked control state `go`"],
    ),
}


def test_there_is_a_case_for_each_obligation() -> None:
    assert list(CASES) == [obligation.name for obligation in OBLIGATIONS]


@pytest.mark.parametrize("name", CASES)
def test_an_obligation_holds(name: str) -> None:
    found = findings(CASES[name][0], name)

    assert found
    assert {f.status for f in found} == {"proved"}
    assert not any(f.vacuous for f in found)


@pytest.mark.parametrize("name", CASES)
def test_an_obligation_is_violated_and_nothing_else(name: str) -> None:
    assert wrong(CASES[name][1]) == CASES[name][2]


def test_a_counterexample_has_the_values_of_the_step() -> None:
    (found,) = findings(CASES["invariant preserved"][1], "invariant preserved")

    assert dict(found.values) == {"n": "9", "n'": "10"}
    assert found.failing == "n' <= 9"
    assert found.message == "the operation breaks the invariant `n <= 9`"
    assert found.span is not None
    assert found.span.text == "n <= 9"


def test_a_dead_operation_names_the_lines_that_exclude_each_other() -> None:
    (found,) = findings(cell(invariant="n <= 9", effect="n > 9; n' = n - 1"), "feasible")

    assert [span.text for span in found.lines] == ["n <= 9", "n > 9"]


def test_a_proof_about_a_dead_operation_is_marked_as_saying_nothing() -> None:
    found = findings(cell(invariant="n <= 9", effect="n > 9; n' = n - 1"), "invariant preserved")

    assert [(f.status, f.vacuous) for f in found] == [("proved", True)]


def test_one_operation_can_be_asked_for() -> None:
    text = """
class Two
  chan up, down : []
  main = up -> main [] down -> main
  state
    n : int
  op up
    Delta(n)
  where
    n' = n + 1
  op down
    Delta(n)
  where
    n' = n - 1
end
"""
    assert told(findings(text, "feasible", operation="down")) == ["feasible down: proved"]


def test_a_variable_that_the_invariant_gives_is_no_mistake() -> None:
    follows = cell(
        state="n : nat; odd : bool", invariant="odd = true <=> n mod 2 = 1", delta="n, odd", effect="n' = n + 1"
    )
    assert wrong(follows) == []
    # Of the outcomes that are allowed the invariant leaves some.
    assert wrong(cell(invariant="n <= 9", effect="n' < n + 3")) == ["deterministic operation go `n'`"]
    # Here it leaves none at 9.
    assert wrong(cell(invariant="n <= 9", effect="n' > n", init="n = 0")) == [
        "invariant preserved go `n <= 9`",
        "deterministic operation go `n'`",
    ]


def test_an_alternative_is_asked_for_with_the_conditions_around_it() -> None:
    nested = "n > 3 => (n' = n - 1 or n' = n + 1 and n < 9); n <= 3 => n' = n"
    assert wrong(cell(state="n : 0..9", effect=nested)) == ["deterministic operation go `n'`"]
    inside = "if n > 3 then n' = n - 4 else n' = n or n' = n + 7"
    assert wrong(cell(state="n : 0..9", effect=inside)) == [
        "alternative kept go `n' = n + 7`",
        "deterministic operation go `n'`",
    ]


def test_secondary_variables_follow_the_invariant() -> None:
    """It is enough that they can have values: the operation does not say them."""
    text = """
given ITEM
class Stack
  chan push : [x? : ITEM]
  chan pop : [y! : ITEM]
  main = push -> main [] pop -> main
  const max : nat where 1 <= max <= 4
  state
    items : seq ITEM
    Delta
    size : nat
  where
    size = #items
    size <= max
  init
    items = <>
  op push
    Delta(items)
    x? : ITEM
  where
    PUSH
    items' = <x?> ^ items
  op pop
    Delta(items)
    y! : ITEM
  where
    items != <>
    y! = head items
    items' = tail items
end
"""
    assert wrong(text.replace("PUSH", "#items < max")) == []
    assert wrong(text.replace("PUSH", "true")) == ["invariant preserved push values for `size`"]


def test_a_choice_within_the_carrier_keeps_it() -> None:
    """What an operation leaves open is chosen inside the carrier; only what it says can lead out."""
    assert wrong(cell(state="n : 0..9", effect="n' >= n")) == ["deterministic operation go `n'`"]


def test_real_numbers_are_real() -> None:
    text = cell(
        state="x : real", init="x = 0.0", delta="x", effect="x' = (x + 1.0) / 2.0", invariant="x < 1.0; x >= 0.0"
    )

    assert wrong(text) == []
    assert wrong(text.replace("(x + 1.0) / 2.0", "x * 2.0"))[0] == "invariant preserved go `x < 1.0`"


def test_division_rounds_down_and_the_remainder_has_the_sign_of_the_divisor() -> None:
    text = cell(
        state="n : int", init="n = 0", effect="n' = -7 div -2; n' = 3; -7 mod -2 = -1; -7 mod 2 = 1; 7 div -2 = -4"
    )

    assert told(findings(text, "feasible")) == ["feasible go: proved"]


def test_the_page_about_proof_lists_every_obligation_with_its_weight() -> None:
    page = (Path(__file__).resolve().parents[3] / "docs" / "proof.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([a-z ]+)` \| .* \| (error|warning|info) \| ", page, re.MULTILINE)

    assert rows == [(obligation.name, obligation.severity) for obligation in OBLIGATIONS]


TREES = """
TREE ::= leaf | node<<TREE cross nat cross TREE>>
class Trees
  chan grow : [n? : nat]
  chan top : [n! : nat]
  main = grow -> main [] top -> main
  state
    t : TREE
    log : seq nat
  init
    t = leaf
    log = <>
  op grow
    Delta(t, log)
    n? : nat
  where
    t' = node(t, n?, leaf)
    log' = log ^ <n?>
  op top
    n! : nat
  where
    exists l, r : TREE @ t = node(l, n!, r)
end
"""


def test_recursive_free_types() -> None:
    assert {f.status for f in findings(TREES)} == {"proved"}
    # What the wrong tree may be afterwards is a question that the solver works at for half a minute.
    asked = findings(TREES.replace("node(t, n?, leaf)", "node(t, n? - 1, leaf)"), "applied in domain")
    assert [(f.operation, f.status) for f in asked] == [("grow", "refuted"), ("top", "proved")]


def test_the_least_element_of_a_set() -> None:
    """``min`` is defined for a finite set that is not empty, and for no other that is known of."""
    text = cell(
        state="s : finset nat",
        init="s = {}",
        delta="s",
        parameters="o! : nat",
        effect="s != {}; o! = min s; s' = s \\ {o!}",
    )
    assert {f.status for f in findings(text)} == {"proved"}
    assert "applied in domain go `min(s)`" in wrong(text.replace("    s != {}\n", ""))


def test_a_counterexample_may_need_more_elements_than_the_small_scopes_have() -> None:
    text = cell(
        state="s : finset nat",
        init="s = {}",
        delta="s",
        parameters="i? : nat",
        invariant="#s <= 5",
        effect="s' = s union {i?}",
    )
    (found,) = findings(text, "invariant preserved")

    assert found.status == "refuted"
    assert found.values["s"].count(",") == 4


def test_a_contradiction_that_the_solver_finds_in_one_way_only_proves_nothing() -> None:
    """Z3 has answered `unsat` here for one seed, at once, though the last seat can be sold."""
    text = """
given PERSON
class Cinema
  chan book : [s? : 1..20; p? : PERSON]
  state
    seat : 1..20 -|-> PERSON
    free : nat
  where
    free = 20 - #seat
    free > 0
  init
    seat = {} and free = 20
  op book
    Delta(seat, free)
    s? : 1..20
    p? : PERSON
  where
    s? notin dom seat
    seat' = seat (+) {s? |-> p?}
    free' = free - 1
end
"""
    asked = prover(text)
    situation, operation = asked.situation, asked.model.operations["book"]
    premises = [*situation.state(), *situation.inputs(operation), *situation.effect(operation)]
    premises += situation.carriers("after")
    parts = (*premises, asked.fails(situation.possible(operation)))

    answer = Solver(asked.specification, asked.model, SolverSettings(seconds=0.5)).ask(Question(parts, proof=0.4))

    assert not isinstance(answer, Impossible)
