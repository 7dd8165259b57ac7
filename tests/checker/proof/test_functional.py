"""Unions and differences of functions as overrides and removals, against an obvious interpreter."""

from __future__ import annotations

from typing import Any

from hypothesis import event, given, settings, strategies as st

from cspcheck.checker.proof.functional import functional
from cspcheck.cspm.oz.core import BOOL, INT, Apply, Term, TupleType
from tests.checker.proof.classes import findings
from tests.cspm.oz.naive import FUN, REL, apply, environments, interpret, terms
from tests.examples import examples


def relations(depth: int) -> st.SearchStrategy[Term]:
    """Relations that are put together from functions."""
    pairs = st.builds(lambda x, y: apply("tuple", TupleType((INT, INT)), x, y), terms(INT, (), 1), terms(INT, (), 1))
    displays = st.lists(pairs, min_size=1, max_size=2).map(lambda found: apply("function", FUN, *found))
    plain = (displays | terms(FUN, (), 1)).map(lambda function: apply("function_to_relation", REL, function))
    if depth == 0:
        return plain
    inner = relations(depth - 1)
    return plain | st.builds(
        lambda operator, one, other: apply(operator, REL, one, other), st.sampled_from(["union", "diff"]), inner, inner
    )


@settings(max_examples=examples(200))
@given(terms(FUN, (), 1), relations(2), st.booleans(), environments)
def test_what_is_said_stays(function: Term, relation: Term, swapped: bool, env: dict[str, Any]) -> None:
    sides = [apply("function_to_relation", REL, function), relation]
    said = apply("equal", BOOL, *(sides[::-1] if swapped else sides))
    expected = interpret(said, env)
    if expected is None:
        return
    again = functional(said)
    event(f"changed: {again != said}, true: {expected}")

    assert interpret(again, env) == expected


def test_a_pair_that_is_added_or_taken_away_determines_a_function() -> None:
    text = """
given A, B
class C
  chan join, part : [a? : A; b? : B]
  state
    f : A >-|-> B
  init
    f = {}
  op join
    Delta(f)
    a? : A
    b? : B
  where
    a? notin dom f and b? notin ran f
    f' = f union {a? |-> b?}
  op part
    Delta(f)
    a? : A
    b? : B
  where
    (a?, b?) in f
    f' = f \\ {a? |-> b?}
end
"""
    found = findings(text, "carrier kept", "deterministic operation", "feasible")

    assert {finding.status for finding in found} == {"proved"}
    assert isinstance(functional(apply("equal", BOOL, *_sides())), Apply)


def _sides() -> tuple[Term, Term]:
    from cspcheck.cspm.oz.core import Variable

    f, g = (Variable(type=FUN, name=name, role="before") for name in "fg")
    relation = [apply("function_to_relation", REL, one) for one in (f, g)]
    return relation[0], apply("union", REL, relation[1], relation[0])
