"""The laws of CSP hold in the engine, and in the reference that the engine is compared with."""

from __future__ import annotations

import os

import pytest
from hypothesis import HealthCheck, given, reject, settings, strategies as st

from tests.differential.engine import checker, said
from tests.laws import choice, hiding, parallel, recursion, sequence  # noqa: F401  (they register the laws)
from tests.laws.notation import LAWS, Claim, Law
from tests.reference.denotations import Semantics, TooLarge
from tests.reference.processes import EVENTS
from tests.reference.text import script
from tests.reference.verdicts import refinement

pytestmark = pytest.mark.slow

EXAMPLES = max(4, int(os.environ.get("CSPCHECK_TRIPLES", "20000")) // 5_000)
"""For each law; each example is up to six refinements."""


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
@settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_law(law: Law, data: st.DataObject) -> None:
    claim = data.draw(law.claims())
    reference_agrees(law, claim)
    engine_agrees(law, claim)


def reference_agrees(law: Law, claim: Claim) -> None:
    semantics = Semantics(EVENTS, limit=2_000)
    left, right = semantics.of(claim.left), semantics.of(claim.right)
    try:
        for model in law.models:
            assert refinement(left, right, model) is None, (model, script(Spec=claim.left, Impl=claim.right))
            if claim.both_ways:
                assert refinement(right, left, model) is None, (model, script(Spec=claim.right, Impl=claim.left))
    except TooLarge:
        reject()


def engine_agrees(law: Law, claim: Claim) -> None:
    engine = checker()
    for model in law.models:
        passed = engine.check_refinement(claim.left, model, claim.right)
        assert said(passed) is not False, (model, script(Spec=claim.left, Impl=claim.right))
        if claim.both_ways:
            passed = engine.check_refinement(claim.right, model, claim.left)
            assert said(passed) is not False, (model, script(Spec=claim.right, Impl=claim.left))


def test_there_are_no_two_laws_of_one_name() -> None:
    assert len({law.name for law in LAWS}) == len(LAWS)
