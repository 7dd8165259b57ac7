"""The visited states are a set, whatever their width, the size of the table, and who adds to it."""

from __future__ import annotations

import functools
import itertools
import operator
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from cspcheck.checker.kernels import jit, table as kernels
from cspcheck.checker.kernels.jit import Kernels
from cspcheck.checker.packing.packed import pack
from cspcheck.checker.search import crew as parallel_search, levels as level_search, reserve, visited
from cspcheck.checker.search.exploration import explore
from cspcheck.checker.search.visited import NO_NUMBERS, Visited
from tests.checker.vehicle import PROCESSES, cycle, synchronised
from tests.examples import examples

Row = tuple[int, ...]

INVERSE = pow(kernels.GOLDEN, -1, 1 << 63)
"""A one-word row times this has a given hash."""


def rows_of(stride: int) -> st.SearchStrategy[list[Row]]:
    """Rows with many repetitions and near misses: small numbers, single bits, numbers that hash next to each other."""
    words = st.one_of(
        st.integers(0, 3),
        st.integers(0, 62).map(lambda bit: 1 << bit),
        st.integers(0, (1 << 63) - 1),
        st.integers(0, 40).map(lambda h: h * INVERSE % (1 << 63)),
        st.integers(0, 40).map(lambda h: (((1 << 63) - 1) - h) * INVERSE % (1 << 63)),
    )
    most = 2 * kernels.AHEAD + 20
    return st.lists(st.tuples(*[words] * stride), max_size=most)


def flat(rows: list[Row]) -> np.ndarray:
    return np.array([word for row in rows for word in row], dtype=np.int64)


def listed_rows(flat_rows: np.ndarray, begin: int, end: int, stride: int) -> list[Row]:
    return [tuple(row) for row in flat_rows[begin * stride : end * stride].reshape(-1, stride).tolist()]


def listed(found: Visited) -> list[Row]:
    return [tuple(row) for row in found.states.tolist()]


def add(found: Visited, kernels: Kernels, rows: list[Row]) -> list[int]:
    """Insert rows, growing when there is no room; their numbers."""
    targets, numbers = flat(rows), np.zeros(max(1, len(rows)), dtype=np.int64)
    position = 0
    while True:
        position = found.insert(kernels, targets, position, len(rows), numbers)
        if position == len(rows):
            return numbers[: len(rows)].tolist()
        found.grow(kernels)


@pytest.fixture
def small_tables(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[int, int], None]]:
    """Sets the sizes from which on tables have wide entries and grow where they are."""

    def set_bits(wide: int, reserved: int) -> None:
        monkeypatch.setattr(visited, "WIDE_BITS", wide)
        monkeypatch.setattr(visited, "RESERVE_BITS", reserved)

    return set_bits


checked = settings(
    max_examples=examples(100), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@pytest.mark.parametrize(
    ("compiled", "wide_bits", "reserve_bits"),
    [
        (False, 31, 20),
        (True, 31, 20),
        (False, 4, 20),
        (False, 1, 20),
        (True, 31, 4),
        (False, 6, 4),
        (True, 31, 1),
        (True, 4, 20),
    ],
)
@checked
@given(data=st.data(), stride=st.integers(1, 3))
def test_each_row_has_one_number_in_the_order_of_first_occurrence(
    small_tables: Callable[[int, int], None],
    compiled: bool,
    wide_bits: int,
    reserve_bits: int,
    data: st.DataObject,
    stride: int,
) -> None:
    small_tables(wide_bits, reserve_bits)
    found = Visited(stride, bits=2)
    code = jit.kernels(compiled)
    rows = data.draw(rows_of(stride))
    expected: dict[Row, int] = {}
    for row in rows:
        expected.setdefault(row, len(expected))
    assert add(found, code, rows) == [expected[row] for row in rows]
    assert listed(found) == list(expected)
    assert found.table.dtype == (np.int64 if found.bits >= wide_bits else np.int32)
    others = rows + data.draw(rows_of(stride))
    numbers = np.zeros(max(1, len(others)), dtype=np.int64)
    found.find(code, flat(others), len(others), numbers)
    assert numbers[: len(others)].tolist() == [expected.get(row, -1) for row in others]


@pytest.mark.skipif(sys.platform != "linux", reason="address space alone is only to be had on Linux")
def test_in_a_reserve_rows_stay_where_they_are(small_tables: Callable[[int, int], None]) -> None:
    small_tables(31, 4)
    found, code = Visited(1, bits=2), jit.kernels(False)
    places = set()
    for row in range(200):
        add(found, code, [(row,)])
        if found.bits >= 4:
            places.add((found.rows.ctypes.data, found.table.ctypes.data))
    assert len(places) == 1
    assert listed(found) == [(row,) for row in range(200)]


def test_without_address_space_to_spare_rows_are_copied(
    small_tables: Callable[[int, int], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*arguments: object, **options: object) -> None:
        raise OSError(12, "Cannot allocate memory")

    monkeypatch.setattr(reserve.mmap, "mmap", refuse)
    small_tables(31, 4)
    found = Visited(1, bits=2)
    assert add(found, jit.kernels(False), [(row,) for row in range(200)]) == list(range(200))


def test_what_outgrows_its_reserve_moves_out(
    small_tables: Callable[[int, int], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reserve.Reserve, "holds", lambda self, nbytes: nbytes <= 512)
    small_tables(31, 4)
    found = Visited(1, bits=2)
    assert add(found, jit.kernels(False), [(row,) for row in range(200)]) == list(range(200))
    assert listed(found) == [(row,) for row in range(200)]


@checked
@given(data=st.data(), stride=st.integers(1, 3), partition_bits=st.integers(0, 4), bits=st.integers(5, 8))
def test_a_divided_table_finds_the_same_or_says_that_a_partition_is_full(
    data: st.DataObject, stride: int, partition_bits: int, bits: int
) -> None:
    code = jit.kernels(False)
    found = Visited(stride, bits=bits)
    found.rebuild(code, bits, partition_bits)
    rows = data.draw(rows_of(stride))
    position = found.insert(code, flat(rows), 0, len(rows))
    assert listed(found) == list(dict.fromkeys(rows[:position]))
    if position < len(rows) and found.known < found.room:
        partition = int(kernels.hash_of(rows[position], 0, stride) >> (63 - partition_bits))
        size = 1 << (bits - partition_bits)
        assert (found.table[partition * size : (partition + 1) * size] >= 0).all()
    numbers = np.zeros(max(1, position), dtype=np.int64)
    for division in (partition_bits, 0, 4):
        found.rebuild(code, bits, division)
        found.find(code, flat(rows), position, numbers)
        assert [listed(found)[number] for number in numbers[:position]] == rows[:position]


@pytest.mark.parametrize("compiled", [False, True])
@checked
@given(data=st.data(), stride=st.integers(1, 2), owners=st.integers(1, 4), room=st.integers(1, 20))
def test_owners_add_what_one_thread_would(
    compiled: bool, data: st.DataObject, stride: int, owners: int, room: int
) -> None:
    """Rows sorted by owner, added by each to stretches of its own, and the gaps closed are the set of all rows."""
    code = jit.kernels(compiled)
    found = Visited(stride, bits=12)
    found.rebuild(code, 12, 3)
    before = data.draw(rows_of(stride))
    add(found, code, before)
    rows = data.draw(rows_of(stride))
    capacity = max(1, len(rows))
    ends = np.zeros(owners, dtype=np.int64)
    outbox = np.zeros(owners * capacity * stride, dtype=np.int64)
    code.sort_by_owner(flat(rows), len(rows), stride, 3, owners, capacity, ends, outbox)
    parts = [listed_rows(outbox, o * capacity, int(ends[o]), stride) for o in range(owners)]
    assert sorted(functools.reduce(operator.iadd, parts, [])) == sorted(rows)
    for one in range(owners):
        for other in range(one):
            assert not set(parts[one]) & set(parts[other])
    waiting = {o: (o * capacity, int(ends[o])) for o in range(owners)}
    stretches = dict.fromkeys(range(owners), (0, 0))
    while waiting:
        for o, (begin, end) in waiting.items():
            place, last = stretches[o]
            if place == last:
                place, last = found.known, found.known + room
                found.known = last
            begin, place = code.insert(
                outbox, begin, end, stride, found.rows, place, last,
                found.table, found.bits, found.entry_bits, 3, NO_NUMBERS,
            )  # fmt: skip
            stretches[o], waiting[o] = (place, last), (begin, end)
        waiting = {o: (begin, end) for o, (begin, end) in waiting.items() if begin < end}
    for place, last in sorted(stretches.values(), reverse=True):
        moved = min(last - place, found.known - last)
        code.move(found.rows, found.known - moved, place, moved, stride, found.table, found.bits, 3)
        found.known -= last - place
    assert len(listed(found)) == len(set(before + rows))
    assert set(listed(found)) == set(before + rows)
    numbers = np.zeros(max(1, len(rows)), dtype=np.int64)
    found.find(code, flat(rows), len(rows), numbers)
    assert [listed(found)[number] for number in numbers[: len(rows)]] == rows


@pytest.mark.parametrize("workers", [2, 3])
def test_a_bad_hash_costs_time_and_nothing_else(monkeypatch: pytest.MonkeyPatch, workers: int) -> None:
    """All states fall into one partition, which is soon full."""
    network = synchronised({name: cycle(f"{name}1", f"{name}2", f"{name}3") for name in "PQRST"})
    expected = explore(pack(network), compiled=False)
    monkeypatch.setattr(kernels, "wrapping_product", lambda a, b: a)
    monkeypatch.setattr(level_search, "PARALLEL_ROWS", 1)
    monkeypatch.setattr(level_search, "PARALLEL_STATES", 0)
    monkeypatch.setattr(level_search.Pace, "is_for_all", True)
    monkeypatch.setattr(parallel_search, "DIVIDED_BITS", 10)
    found = explore(pack(network), compiled=False, workers=workers)
    assert (found.levels, found.transitions) == (expected.levels, expected.transitions)
    assert found.levels[-1] == 3**5


def test_several_workers_find_the_same_levels() -> None:
    """A part of the vehicle, large enough for many rounds and for tables that grow meanwhile."""
    left_out = {"Sonar", "Compass", "Altimeter"}
    processes = {name: transitions for name, transitions in PROCESSES.items() if name not in left_out}
    packed = pack(synchronised(processes, blocked={"autonomo_s1"}))
    expected = explore(packed, compiled=True)
    assert expected.levels[-1] == 2_519_424 // 27
    levels = [np.sort(expected.states_at(slice(*part)), axis=0) for part in pairs(expected.levels)]
    for workers in (2, 3):
        found = explore(packed, workers=workers, compiled=True)
        assert (found.levels, found.transitions) == (expected.levels, expected.transitions)
        for part, states in zip(pairs(found.levels), levels, strict=True):
            assert np.array_equal(np.sort(found.states_at(slice(*part)), axis=0), states)


def pairs(numbers: tuple[int, ...]) -> list[tuple[int, int]]:
    return list(itertools.pairwise(numbers))


def test_a_search_that_grows_changes_to_compiled_kernels_with_the_same_result(monkeypatch: pytest.MonkeyPatch) -> None:
    packed = pack(synchronised({name: cycle(f"{name}1", f"{name}2", f"{name}3") for name in "PQRST"}))
    interpreted = explore(packed, compiled=False)
    monkeypatch.setattr(level_search, "INTERPRETED_TRANSITIONS", 100)
    monkeypatch.setattr(jit, "is_loaded", lambda: False)
    changed = explore(packed)
    assert changed.levels == interpreted.levels
    assert np.array_equal(changed.states, interpreted.states)
    assert changed.transitions == interpreted.transitions == 5 * 3**5


def test_several_threads_may_ask_for_the_kernels() -> None:
    with ThreadPoolExecutor(4) as pool:
        assert len({id(form) for form in pool.map(lambda _: jit.kernels(False), range(8))}) == 1
