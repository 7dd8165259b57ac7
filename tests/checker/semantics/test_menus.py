"""Menus say what a choice between prefixes offers, however little that is and however deep it stands."""

from __future__ import annotations

import pytest

from cspcheck.checker.semantics.menus import steps_of
from cspcheck.cspm.process.terms import SKIP, STOP, ExternalChoice, Prefix
from tests.differential.engine import checker, said

A, B = (7, STOP), (8, SKIP)


@pytest.mark.parametrize(
    ("menu", "steps"),
    [
        ((), []),
        (((),), []),
        (((), ()), []),
        (((), (A,)), [A]),
        (((A, B),), [A, B]),
        ((((), (A,)), (B,)), [A, B]),
        ((((),), (B,)), [B]),
    ],
)
def test_the_steps_of_a_menu_are_those_of_its_groups(menu: tuple, steps: list) -> None:
    assert steps_of(menu) == steps


def test_a_choice_between_nothing_is_stop() -> None:
    nothing = Prefix(())
    for process in (nothing, ExternalChoice((nothing, nothing)), ExternalChoice((ExternalChoice((nothing,)), nothing))):
        for model in ("T", "F", "FD"):
            assert said(checker().check_refinement(STOP, model, process)) is True  # type: ignore[arg-type]
            assert said(checker().check_refinement(process, model, STOP)) is True  # type: ignore[arg-type]
