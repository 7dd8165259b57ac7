"""The laws of the toolkit: each is proved from what it names, or says what an operator is; all hold of small values."""

from __future__ import annotations

import random
import re
from dataclasses import replace
from pathlib import Path

import pytest

from cspcheck.checker.proof.finite import _Samples, grounded
from cspcheck.checker.proof.induction import opened
from cspcheck.checker.proof.lemmas import Claim
from cspcheck.checker.proof.prover import Prover
from cspcheck.checker.proof.question import Impossible
from cspcheck.checker.proof.replay import PredicateReplay, Replayed
from cspcheck.cspm.oz import core, laws
from cspcheck.cspm.source import Source
from tests.checker.proof.classes import findings

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "proof.md").read_text(encoding="utf-8")
NOWHERE = Source("", "").span(0, 0)


def of_laws() -> core.Specification:
    table = laws.laws()
    return core.Specification(lemmas=table, givens={given: NOWHERE for law in table.values() for given in law.givens})


@pytest.mark.parametrize("name", [name for name in laws.names() if name not in laws.defining()])
def test_a_law_is_proved(name: str) -> None:
    claims = {n: Claim(law, law=True) for n, law in laws.laws().items()}
    asked = Prover(of_laws(), core.ClassModel(name="laws", span=NOWHERE), claims=claims)

    assert isinstance(asked.lemma(claims[name]), Impossible)


@pytest.mark.parametrize("name", laws.names())
def test_a_law_holds_of_small_values(name: str) -> None:
    law = laws.laws()[name]
    specification = of_laws()
    sizes = dict.fromkeys(law.givens, 2)
    specification = replace(specification, givens=dict.fromkeys(sizes, NOWHERE))
    assumed, said, named = opened(law.term)
    rng = random.Random(name)
    samples = {v: _Samples(specification, 2).of(v.type) for v in named.values()}
    held = 0
    for _ in range(60):
        values = {v: grounded(rng.choice(samples[v]), v.type, {}) for v in named.values()}
        replay = PredicateReplay(specification, None, sizes, values)
        if all(replay.holds(part.term) is Replayed.HOLDS for part in assumed):
            assert replay.holds(said) is Replayed.HOLDS, values
            held += 1
    assert held


def test_the_page_names_every_law() -> None:
    section = PAGE.partition("### Laws")[2].partition("\n## ")[0]

    assert set(re.findall(r"`([a-z_]+)`", section)) == set(laws.names())


def test_a_law_helps_by_itself_and_is_told() -> None:
    text = """
given NODE
class Net
  chan join : [a?, b? : NODE]
  main = join -> main
  state
    g, old : NODE <-> NODE
  where
    old^+ subseteq g^+
  init
    g = {}
    old = {}
  op join
    Delta(g)
    a?, b? : NODE
  where
    g' = g union {a? |-> b?}
end
"""
    (found,) = findings(text, "invariant preserved")

    assert found.status == "proved"
    assert "closure_is_monotonic" in found.hypotheses or "closure_is_least" in found.hypotheses
