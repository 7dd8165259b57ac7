"""Sorted runs on disk are sets, whatever the width of a row and the size of a block."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from cspcheck.checker.kernels import jit
from cspcheck.checker.search import runs
from cspcheck.checker.search.runs import RunSet, RunWriter, Sieve, SortedRun, blocks_of, ordered, united
from tests.examples import examples

Row = tuple[int, ...]

checked = settings(
    max_examples=examples(40), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
some = st.integers(1, 3).flatmap(
    lambda stride: st.tuples(
        st.just(stride),
        st.lists(
            st.frozensets(
                st.tuples(*[st.one_of(st.integers(0, 3), st.integers(0, (1 << 63) - 1))] * stride), max_size=25
            ),
            min_size=1,
            max_size=5,
        ),
    )
)


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runs, "BLOCK", 4)


def flat(rows: frozenset[Row], stride: int) -> np.ndarray:
    return ordered(np.array(list(rows), dtype=np.int64).reshape(-1), stride)


def listed(rows: np.ndarray, stride: int) -> list[Row]:
    return [tuple(row) for row in rows.reshape(-1, stride).tolist()]


def written(path: Path, rows: frozenset[Row], stride: int) -> SortedRun:
    writer = RunWriter(path, 0, stride, own=True)
    for piece in cut(flat(rows, stride), stride, 3):
        writer.add(piece)
    return writer.finished()


def cut(rows: np.ndarray, stride: int, size: int) -> Iterator[np.ndarray]:
    for place in range(0, len(rows), size * stride):
        yield rows[place : place + size * stride]


@checked
@given(sets=some)
def test_a_union_is_ascending_and_has_each_row_once(tmp_path: Path, sets: tuple[int, list[frozenset[Row]]]) -> None:
    stride, all_rows = sets
    kernels = jit.kernels(False)
    found = [written(tmp_path / str(i), rows, stride) for i, rows in enumerate(all_rows)]
    pieces = list(united(kernels, map(blocks_of, found), stride))
    assert [row for piece in pieces for row in listed(piece, stride)] == sorted(frozenset().union(*all_rows))
    for run in found:
        run.drop()


@checked
@given(sets=some, wanted=st.booleans(), size=st.integers(1, 30))
def test_a_sieve_tells_what_is_in_a_run(
    tmp_path: Path, sets: tuple[int, list[frozenset[Row]]], wanted: bool, size: int
) -> None:
    stride, (inside, *others) = sets
    rows = frozenset().union(*others, list(inside)[::2])
    run = written(tmp_path / "run", inside, stride)
    sieve = Sieve(jit.kernels(False), run)
    pieces = [sieve.sift(piece.copy(), wanted=wanted) for piece in cut(flat(rows, stride), stride, size)]
    expected = rows & inside if wanted else rows - inside
    assert [row for piece in pieces for row in listed(piece, stride)] == sorted(expected)
    run.drop()


@checked
@given(sets=some)
def test_a_set_of_runs_knows_what_is_new(tmp_path: Path, sets: tuple[int, list[frozenset[Row]]]) -> None:
    stride, all_rows = sets
    kernels = jit.kernels(False)
    known: frozenset[Row] = frozenset()
    among = RunSet(tmp_path, stride)
    for i, rows in enumerate(all_rows):
        new = [row for piece in among.new_ones(kernels, [flat(rows, stride)]) for row in listed(piece, stride)]
        assert new == sorted(rows - known)
        among.add(kernels, written(tmp_path / f"new-{i}", rows - known, stride))
        known |= rows
        sizes = [run.count for run in among.runs]
        assert sum(sizes) == len(known)
        assert all(larger >= 2 * smaller for larger, smaller in pairwise(sizes))
    for run in among.runs:
        run.drop()


def test_a_file_that_has_lost_rows_is_not_believed(tmp_path: Path) -> None:
    run = written(tmp_path / "run", frozenset((i,) for i in range(10)), 1)
    run.path.write_bytes(run.path.read_bytes()[:-8])
    with pytest.raises(OSError, match="less in the file"):
        list(blocks_of(run))
