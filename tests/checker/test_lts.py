"""Explicit machines made of transitions in any order."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.checker import lts as machines
from cspcheck.checker.lts import Lts, machine
from tests.examples import examples

STATES, LABELS = 7, 5
MOVES = st.lists(st.tuples(st.integers(0, STATES - 1), st.integers(0, LABELS), st.integers(0, STATES - 1)))


def made(moves: list[tuple[int, int, int]], kind: type[np.signedinteger[np.typing.NBitBase]]) -> list[object]:
    starts, labels, targets = np.array(moves, dtype=kind).reshape(-1, 3).T
    return told(machine(STATES, starts, labels, targets, 3))


def told(lts: Lts) -> list[object]:
    assert {array.dtype for array in (lts.offsets, lts.labels, lts.targets)} == {np.dtype(np.int64)}
    return [lts.offsets.tolist(), lts.labels.tolist(), lts.targets.tolist(), lts.root]


@settings(max_examples=examples(100))
@given(MOVES, st.sampled_from([np.int32, np.int64]))
def test_a_machine_has_each_transition_once_and_in_order(
    moves: list[tuple[int, int, int]], kind: type[np.signedinteger[np.typing.NBitBase]]
) -> None:
    rows: list[list[tuple[int, int]]] = [[] for _ in range(STATES)]
    for source, label, target in moves:
        rows[source].append((label, target))
    expected = told(Lts.from_successors(rows, 3))
    assert made(moves, kind) == expected
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(machines, "ONE_NUMBER", 0)  # so many states that a transition is no number
        assert made(moves, kind) == expected


def test_a_machine_may_have_no_transitions_and_no_states() -> None:
    none = np.zeros(0, dtype=np.int64)
    assert told(machine(0, none, none, none)) == [[0], [], [], 0]
    assert told(machine(2, none, none, none)) == [[0, 0, 0], [], [], 0]


def test_labels_and_states_may_be_large_numbers() -> None:
    far = np.array([2**40, 3, 2**40], dtype=np.int64)
    zeros = np.zeros(3, dtype=np.int64)
    assert told(machine(1, zeros, far, zeros)) == [[0, 2], [3, 2**40], [0, 0], 0]
