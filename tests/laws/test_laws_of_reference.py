"""The laws of CSP hold in the denotational reference. So what the engine is compared with is CSP."""

from __future__ import annotations

import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st

from tests.laws import choice, hiding, parallel, recursion, sequence  # noqa: F401  (they register the laws)
from tests.laws.notation import LAWS, Claim, Law
from tests.reference.denotations import Semantics, TooLarge
from tests.reference.processes import EVENTS
from tests.reference.text import script
from tests.reference.verdicts import refinement


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
@settings(max_examples=20, deadline=None)
@given(data=st.data())
def test_law(law: Law, data: st.DataObject) -> None:
    claim = data.draw(law.claims())
    semantics = Semantics(EVENTS, limit=2000)
    try:
        hold(law, claim, semantics)
    except TooLarge:
        reject()


def hold(law: Law, claim: Claim, semantics: Semantics) -> None:
    left, right = semantics.of(claim.left), semantics.of(claim.right)
    for model in law.models:
        assert refinement(left, right, model) is None, (model, script(Spec=claim.left, Impl=claim.right))
        if claim.both_ways:
            assert refinement(right, left, model) is None, (model, script(Spec=claim.right, Impl=claim.left))
