"""The precondition of an operation is computed and written as the script would."""

from __future__ import annotations

import pytest

from cspcheck.checker.proof.precondition import Precondition, precondition
from cspcheck.cspm.oz.writing.core_text import text
from tests.checker.proof.classes import cell, prover


def computed(source: str) -> Precondition:
    proof = prover(source)
    return precondition(proof, proof.model.operations["go"])


def shown(source: str) -> list[str]:
    found = computed(source)
    assert found.exact
    return [text(term) for term in found.conjuncts]


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        (cell(effect="n' = n + 1"), []),
        (cell(effect="n' = n - 1"), ["1 <= n"]),
        (cell(invariant="n <= 9", effect="n' = n + 1"), ["n <= 8"]),
        (cell(state="n : int", effect="n = n' + 3; n' > 2"), ["5 < n"]),
        (cell(effect="n' > n; n' < 9"), ["n <= 7"]),
        (cell(effect="2 * n' = n"), ["n mod 2 = 0"]),
        (cell(state="s : seq nat", init="s = <>", delta="s", invariant="#s <= 3", effect="s' = s ^ <1>"), ["#s <= 2"]),
        (
            cell(state="s : seq nat", init="s = <>", delta="s", parameters="o! : nat", effect="s = <o!> ^ s'"),
            ["s != <>"],
        ),
        (cell(state="n : 0..9", parameters="i? : nat", effect="n' = n + i?"), ["n + i? <= 9"]),
        (
            cell(state="n : 0..9", parameters="i? : 0..1", effect="i? = 0 => n' = n - 1; i? = 1 => n' = n + 1"),
            ["i? = 0 => 1 <= n", "i? = 1 => n <= 8"],
        ),
        (
            cell(state="n : 0..9", parameters="i? : 0..1", effect="i? = 0 => n' = n; i? = 1 => n = n + 1"),
            ["i? != 1"],
        ),
        (cell(effect="false; n' = 1"), ["false"]),
    ],
)
def test_preconditions(source: str, expected: list[str]) -> None:
    assert shown(source) == expected


def test_the_guard_is_told_beside_the_precondition_of_the_effect() -> None:
    found = computed(cell(state="n : nat", enable="n < 9", effect="n' = n - 1"))

    assert found.guard is not None
    assert [text(term) for term in found.guard] == ["n < 9"]
    assert [text(term) for term in found.conjuncts] == ["1 <= n"]


def test_what_cannot_be_eliminated_stays_and_is_told() -> None:
    found = computed(cell(state="s : seq nat", init="s = <>", delta="s", effect="s' ^ s' = s"))

    assert not found.exact
    assert [text(term) for term in found.conjuncts] == ["exists s' : seq nat @ s' ^ s' = s"]
