"""Where the CSP part of a class waits, read off its equations."""

from __future__ import annotations

import pytest

from cspcheck.checker.proof.control import control_states
from tests.checker.proof.classes import findings, specification

CLASS = """
class C
  chan a, b, c : []
  chan d : [i? : 0..3]
  EQUATIONS
  state
    n : 0..3
  op a
  where
    n = 0
  op b
  where
    n > 0
  op c
  where
    n > 1
  op d
    i? : 0..3
  where
    i? = n
end
"""


def waited(equations: str) -> list[list[str]]:
    """The sets of events, inexact ones with a mark, place by place."""
    model = specification(CLASS.replace("EQUATIONS", equations)).classes["C"]
    return [
        ["".join(sorted(way.channels)) + ("" if way.exact else "*") for way in state.ways]
        for state in control_states(model)
    ]


@pytest.mark.parametrize(
    ("equations", "expected"),
    [
        ("main = a -> b -> main", [["a"], ["b"]]),
        ("main = a -> main [] b -> main", [["ab"]]),
        ("main = a -> main |~| b -> main", [["a", "b"]]),
        ("main = (a -> SKIP) ; (b -> main)", [["a"], ["b"]]),
        ("main = a -> X\n  X = b -> main [] c -> X", [["a"], ["bc"]]),
        ("main = d?x -> main", [["d"]]),
        ("main = d.1 -> main", [["d*"]]),
        ("main = a -> STOP", [["a"]]),
        ("main = X(1)\n  X(k) = if k == 1 then a -> X(2) else b -> main", [["a", "b"]]),
        ("main = a -> main ||| b -> main", [["a"], ["b"]]),
    ],
)
def test_what_is_waited_for(equations: str, expected: list[list[str]]) -> None:
    found = waited(equations)

    for ways in expected:
        assert ways in found
    if "|||" in equations:
        assert ["ab"] not in found


@pytest.mark.parametrize(
    ("equations", "status"),
    [
        ("main = a -> main [] b -> main", "proved"),
        ("main = a -> main [] c -> main", "refuted"),
        ("main = d?x -> main", "proved"),
        ("main = d.1 -> main", "unknown"),
    ],
)
def test_a_place_is_blocked_where_the_data_refuse_everything(equations: str, status: str) -> None:
    (found,) = findings(CLASS.replace("EQUATIONS", equations), "no blocked control state")

    assert found.status == status
    if status == "refuted":
        assert dict(found.values) == {"n": "1"}
        assert found.message == "the process waits here for `a`, `c`, and the data refuse each of them"
