"""A function is a set of pairs, whichever way it is declared: held against the definitions of the toolkit."""

from __future__ import annotations

from collections.abc import Callable
from itertools import chain, combinations, product

import pytest

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.typing.elaboration import elaborate
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.source import Source
from tests.cspm.oz.naive import interpret
from tests.cspm.oz.test_meaning import outcome

Pairs = frozenset[tuple[int, int]]
Test = Callable[[Pairs, frozenset[int], frozenset[int]], bool]


def domain(r: Pairs) -> frozenset[int]:
    return frozenset(a for a, _ in r)


def image(r: Pairs) -> frozenset[int]:
    return frozenset(b for _, b in r)


def functional(r: Pairs, x: frozenset[int], y: frozenset[int]) -> bool:
    return len(domain(r)) == len(r) and domain(r) <= x and image(r) <= y


def injective(r: Pairs, x: frozenset[int], y: frozenset[int]) -> bool:
    return functional(r, x, y) and len(image(r)) == len(r)


def sequence(r: Pairs, x: frozenset[int], y: frozenset[int]) -> bool:
    return functional(r, frozenset(range(1, len(r) + 1)), y) and len(domain(r)) == len(r)


SPACES: dict[str, Test] = {
    "0..1 -|-> 1..2": functional,
    "0..1 -> 1..2": lambda r, x, y: functional(r, x, y) and domain(r) == x,
    "0..1 >-|-> 1..2": injective,
    "0..1 >--> 1..2": lambda r, x, y: injective(r, x, y) and domain(r) == x,
    "0..1 -|->> 1..2": lambda r, x, y: functional(r, x, y) and image(r) == y,
    "0..1 -->> 1..2": lambda r, x, y: functional(r, x, y) and image(r) == y and domain(r) == x,
    "0..1 >-->> 1..2": lambda r, x, y: injective(r, x, y) and image(r) == y and domain(r) == x,
    "seq (1..2)": sequence,
    "seq1 (1..2)": lambda r, x, y: sequence(r, x, y) and len(r) > 0,
    "iseq (1..2)": lambda r, x, y: sequence(r, x, y) and injective(r, domain(r), y),
}


def invariant(predicate: str, declarations: str = "r : 0..2 <-> 0..2") -> core.Term:
    text = f"class C\n  state\n    {declarations}\n  where\n    {predicate}\nend"
    (term,) = elaborate(parse(Source("everyday.csp", text))).specification.classes["C"].invariant
    return term


def relations() -> list[Pairs]:
    pairs = list(product((0, 1, 2), (1, 2)))
    return [frozenset(found) for found in chain.from_iterable(combinations(pairs, n) for n in range(4))]


@pytest.mark.parametrize("space", SPACES)
def test_a_relation_is_a_function_by_its_pairs(space: str) -> None:
    term = invariant(f"r in {space}")
    x, y = frozenset([0, 1]), frozenset([1, 2])
    for relation in relations():
        assert interpret(term, {("r", "before"): relation}) == SPACES[space](relation, x, y), relation


@pytest.mark.parametrize(("power", "steps"), [(1, 1), (2, 2), (3, 3), (-1, -1), (-2, -2)])
def test_iterates_of_a_relation(power: int, steps: int) -> None:
    term = invariant(f"(0 |-> 2) in r ^ {power}")
    for relation in relations():
        forwards = relation if steps > 0 else frozenset((b, a) for a, b in relation)
        reached = {0}
        for _ in range(abs(steps)):
            reached = {b for a, b in forwards if a in reached}
        assert interpret(term, {("r", "before"): relation}) == (2 in reached), relation


def test_how_often_is_known() -> None:
    with pytest.raises(ScriptError) as error:
        invariant("(0 |-> 2) in r ^ n", "r : 0..2 <-> 0..2; n : nat")
    assert "number that is written out" in error.value.diagnostics[0].message


def test_tuples_constructors_and_functions_as_sets() -> None:
    text = """
TREE ::= tip | leaf<<0..2>>
class Z
  state
    r : 0..2 <-> 0..2
    f : 0..2 -|-> 0..2
    t : TREE
    p : (0..1) cross (0..2)
  where
    f = r
  init
    r = {0 |-> 1, 1 |-> 2}
    t = leaf(2)
    p = (1, 2)
  op twice = [a! : 0..2 | (0 |-> a!) in r ^ 2]
  op leaf_of = [v! : 0..2 | v! = leaf~(t) and p.2 = v! and t in ran leaf]
end
"""
    assertion = "Z :[has trace]: <twice.2, leaf_of.2>"
    assert outcome(f"{text}assert {assertion}", assertion)[0] == "pass"


def test_a_name_between_what_it_relates() -> None:
    relations = [frozenset(pairs) for size in range(3) for pairs in combinations(product(range(3), repeat=2), size)]
    for relation in relations:
        written = "{" + ", ".join(f"{a} |-> {b}" for a, b in sorted(relation)) + "}"
        for a, b in product(range(3), repeat=2):
            said = invariant(f"{a} inrel r {b}", "r : 0..2 <-> 0..2")
            assert interpret(said, {"r": relation}) is ((a, b) in relation), (written, a, b)


def test_a_function_relates_its_argument_to_its_value_and_the_types_must_fit() -> None:
    assert interpret(invariant("1 <= 1 inrel f 2", "f : 0..2 -> 0..2"), {"f": {0: 0, 1: 2, 2: 0}}) is True
    with pytest.raises(ScriptError, match="CSP631"):
        invariant("true inrel r 1")
    with pytest.raises(ScriptError, match="`s`"):
        invariant("1 inrel s 1")
