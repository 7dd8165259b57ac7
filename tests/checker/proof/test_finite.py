"""What is false of few values is refuted by the evaluator; what is true of each case is proved case by case."""

from __future__ import annotations

import random
from itertools import product

import pytest

from cspcheck.checker.proof.cases import cases
from cspcheck.checker.proof.definedness import Definedness
from cspcheck.checker.proof.finite import found_in_scope
from cspcheck.checker.proof.question import Constraint
from cspcheck.checker.proof.simulation import refinement, retrieve
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import BOOL, INT, Apply, Constant, If, Term, Variable
from cspcheck.cspm.oz.values.evaluation import TermEvaluator
from tests.checker.proof.classes import findings, prover, specification

EXCHANGE = """
given PHONE
class Exchange
  chan connect : [a?, b? : PHONE]
  state
    free : power PHONE
    conn : PHONE -|-> PHONE
  where
    free = PHONE \\ (dom conn union ran conn)
  init
    conn = {}
  op connect
    Delta(free, conn)
    a?, b? : PHONE
  where
    a? /= b?
    a? in free and b? in free
    conn' = conn union {a? |-> b?}
end
"""

BUFFERS = """
given ITEM
const MAX : nat1 where MAX = 2 end
class Queue
  chan put : [i? : ITEM]
  state q : seq ITEM where #q <= MAX
  init q = <>
  op put
    Delta(q)
    i? : ITEM
  where
    #q < MAX
    q' = q ^ <i?>
end
class Ring
  chan put : [i? : ITEM]
  state
    cell : 0..MAX - 1 -> ITEM
    first : 0..MAX - 1
    n : 0..MAX
  init n = 0 and first = 0
  op put
    Delta(cell, n)
    i? : ITEM
  where
    n < MAX
    cell' = cell (+) {(first + n + 1) mod MAX |-> i?}
    n' = n + 1
end
retrieve R between Queue and Ring where
  #q = n
  forall i : 1..n @ q(i) = cell((first + i - 1) mod MAX)
end
"""


def test_two_phones_show_that_a_call_is_possible() -> None:
    asked = prover(EXCHANGE)
    operation = asked.model.operations["connect"]
    step = asked.situation.with_constants(asked.situation.step(operation))
    parts = [Constraint(t, p.what) for p in step for t in asked.solver.definedness.holding([p.term])]

    assert found_in_scope(asked.specification, asked.model, parts, (), 1, 10_000) is None
    found = found_in_scope(asked.specification, asked.model, parts, (), 2, 10_000)

    assert found is not None
    assert {v.name for v in found.values} == {"free", "conn", "a", "b"}
    (finding,) = findings(EXCHANGE, "feasible")
    assert finding.status == "proved"


def test_a_buffer_that_is_wrong_by_one_is_refuted_by_two_cells() -> None:
    spec = specification(BUFFERS)
    found = list(refinement(spec, retrieve(spec.retrieves["R"])))

    assert [f.operation for f in found if f.obligation == "correctness" and f.status == "refuted"] == ["put"]
    assert all(f.status == "proved" for f in found if f.obligation in ("initial states", "applicability"))


def test_a_conditional_is_proved_branch_by_branch() -> None:
    (finding,) = findings(
        """
given CAR
class Park
  chan enter : [q? : CAR]
  const K : nat1
  state
    inside : finset CAR
  where
    #inside <= K
  init
    inside = {}
  op enter
    Delta(inside)
    q? : CAR
  where
    if #inside < K then inside' = inside union {q?} else inside' = inside
end
""",
        "invariant preserved",
    )
    assert finding.status == "proved"


# --- cases ------------------------------------------------------------------------------------------------------------

NAMES = ("p", "q", "r")


def predicate(chance: random.Random, depth: int) -> Term:
    """A predicate over three truth values and a division, which is undefined where its divisor is zero."""
    if depth == 0:
        name = chance.choice([*NAMES, "division"])
        if name == "division":
            over = Variable(type=INT, name="n", role="before")
            one = Constant(type=INT, value=1)
            return Apply(
                type=BOOL, operator="equal", operands=(Apply(type=INT, operator="div", operands=(one, over)), one)
            )
        return Variable(type=BOOL, name=name, role="before")
    match chance.choice(["and", "or", "not", "implies", "if", "iff", "value"]):
        case "not":
            return Apply(type=BOOL, operator="not", operands=(predicate(chance, depth - 1),))
        case "if":
            test, then, otherwise = (predicate(chance, depth - 1) for _ in range(3))
            return If(type=BOOL, test=test, then=then, otherwise=otherwise)
        case "value":
            one, two = (Constant(type=INT, value=value) for value in (1, 2))
            chosen = If(type=INT, test=predicate(chance, depth - 1), then=one, otherwise=two)
            return Apply(type=BOOL, operator="equal", operands=(chosen, chance.choice([one, two])))
        case operator:
            return Apply(
                type=BOOL, operator=operator, operands=(predicate(chance, depth - 1), predicate(chance, depth - 1))
            )


def holds(term: Term, values: dict[tuple[str, core.Role], object]) -> bool:
    from cspcheck.cspm.oz.values.carriers import Undefined

    try:
        return TermEvaluator(core.Specification()).holds(term, values)
    except Undefined:
        return False


@pytest.mark.parametrize("seed", range(40))
def test_a_predicate_holds_where_one_of_its_cases_does(seed: int) -> None:
    chance = random.Random(seed)
    parts = (Constraint(predicate(chance, 2), "claim"), Constraint(predicate(chance, 1), "claim"))
    split = cases(parts, Definedness({}).total)

    for p, q, r, n in product([False, True], [False, True], [False, True], [0, 1]):
        values: dict[tuple[str, core.Role], object] = {("p", "before"): p, ("q", "before"): q}
        values |= {("r", "before"): r, ("n", "before"): n}
        whole = all(holds(part.term, values) for part in parts)
        some = any(all(holds(part.term, values) for part in case) for case in split)
        assert not split or whole == some, (values, parts, split)
