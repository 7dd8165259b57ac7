"""What is said item by item exists, where it can; and nothing else is taken to exist."""

from __future__ import annotations

import pytest

from cspcheck.checker.proof.obligations import discharge
from tests.checker.proof.classes import prover

LEMMA = """
given ITEM
lemma there : forall n : {numbers}; f : nat -|-> ITEM | {known} @ exists {sought} @ {said}
class C
end
"""
ITEMS = "#q = n and (forall i : 1..n @ q(i) = f(i - 1))"


@pytest.mark.parametrize(
    ("numbers", "known", "sought", "said", "status"),
    [
        ("nat", "0..n - 1 subseteq dom f", "q : seq ITEM", ITEMS, "proved"),
        ("nat", "dom f = nat", "q : seq ITEM", f"{ITEMS} and (forall i : dom q @ q(i) in ran f)", "proved"),
        ("nat", "n > 0 and dom f = nat", "q : seq ITEM", f"q /= <> and {ITEMS}", "proved"),
        ("nat", "dom f = nat", "g : nat -|-> ITEM", "dom g = 0..n and (forall i : 0..n @ g(i) = f(n - i))", "proved"),
        # no sequence has a length below zero, nor items that are undefined
        ("int", "dom f = nat", "q : seq ITEM", ITEMS, "refuted"),
        ("nat", "true", "q : seq ITEM", ITEMS, "refuted"),
        ("nat", "dom f = nat", "q : seq ITEM", f"{ITEMS} and #q > 2", "refuted"),
        ("nat", "dom f = nat", "g : nat -|-> ITEM", "dom g = 1..n and (forall i : 0..n @ g(i) = f(i))", "refuted"),
    ],
)
def test_there_is_what_is_said_item_by_item(numbers: str, known: str, sought: str, said: str, status: str) -> None:
    text = LEMMA.format(numbers=numbers, known=known, sought=sought, said=said)
    (found,) = discharge(prover(text, seconds=10.0 if status == "proved" else 0.3), ["lemma"])

    assert (found.status == "proved") == (status == "proved"), found
