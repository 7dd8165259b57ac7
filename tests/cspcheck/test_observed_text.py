"""Failures in the models of revivals and refusal testing, as they are told."""

from __future__ import annotations

import cspcheck
from cspcheck.api import loads

SCRIPT = """
channel a, b, c
S = (a -> b -> STOP [] c -> STOP) |~| a -> c -> STOP
I = (a -> c -> STOP [] c -> STOP) |~| a -> b -> STOP
"""


def told(assertion: str) -> str:
    result = loads(SCRIPT).check(assertion)
    assert isinstance(result, cspcheck.Result)
    return " ".join(result.explain().split())


def test_a_refusal_on_the_way_is_told() -> None:
    text = told("S [R= I")

    assert "`I` performs `b` after 1 event and 1 internal step, having refused {b, c} before event 1" in text


def test_a_revival_is_told() -> None:
    text = told("(a -> STOP) [> STOP [V= a -> STOP |~| STOP")

    assert "offers only {a} after 1 internal step, and then performs `a`" in text
    assert "not allowed after that refusal" in text
