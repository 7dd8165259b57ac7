"""Threads go on together while that gets more done, and are tried again, ever later, where it does not."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from cspcheck.checker.kernels import jit
from cspcheck.checker.packing.packed import pack
from cspcheck.checker.search import crew, expansion, levels, pace
from cspcheck.checker.search.exploration import explore
from cspcheck.checker.search.pace import Pace
from cspcheck.checker.search.visited import Visited
from cspcheck.checker.search.worker import Wave, Worker
from tests.checker.vehicle import cycle, synchronised


class Clock:
    """A clock that is put forward."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


def shares(runs: int, alone: float, together: float) -> list[tuple[float, bool]]:
    """When each run begins and whether all did it, for so many transitions a second by one thread and by all."""
    clock = Clock()
    chooses = Pace(clock)
    found = []
    for _ in range(runs):
        shared = chooses.is_for_all
        found.append((clock.now, shared))
        seconds = 0.01 if shared else 0.001
        clock.now += seconds
        chooses.note(round(seconds * (together if shared else alone)), seconds, together=shared)
    return found


def test_what_one_thread_does_is_known_first() -> None:
    assert [shared for _, shared in shares(4, 1e7, 2e7)] == [False, False, False, True]


def test_threads_that_gain_go_on_and_are_held_against_one_now_and_then() -> None:
    found = [shared for _, shared in shares(1000, 1e7, 1.6e7)]
    alone = [run for run, shared in enumerate(found) if not shared]
    assert alone[:3] == [0, 1, 2]
    assert set(distances(alone[3:])) == {pace.COMPARED + 1}


def distances(numbers: list[int]) -> list[int]:
    return [after - before for before, after in itertools.pairwise(numbers)]


@pytest.mark.parametrize("together", [0.5e7, 1e7, 1.04e7])
def test_threads_that_gain_nothing_are_tried_ever_more_seldom(together: float) -> None:
    found = shares(40_000, 1e7, together)
    trials = [now for (now, shared), (_, before) in zip(found[1:], found, strict=False) if shared and not before]
    pauses = [after - now for now, after in itertools.pairwise(trials)]
    assert len(pauses) >= 4
    for number, pause in enumerate(pauses):
        assert pause == pytest.approx(pace.PAUSE * 2**number, rel=0.2)
    assert sum(shared for _, shared in found) == pace.TRIAL * len(trials)


@pytest.mark.parametrize("together", [0.7e7, 0.9e7, 1.04e7])
@pytest.mark.parametrize("seconds", [0.2, 0.8, 3.0, 30.0])
def test_threads_that_gain_nothing_cost_next_to_nothing(together: float, seconds: float) -> None:
    """A search that one thread does in so many seconds, whose first shared runs are as small as those of a crew."""
    clock, alone = Clock(), 1e7
    chooses, left = Pace(clock), seconds * alone
    runs = 0
    begun = clock.now
    while left > 0:
        shared = chooses.is_for_all
        runs = runs + 1 if shared else 0
        many = min(left, crew.FIRST_RUN_TRANSITIONS << max(0, runs - pace.TRIAL - 1) if shared else expansion.CAPACITY)
        spent = many / (together if shared else alone)
        clock.now += spent
        chooses.note(round(many), spent, together=shared)
        left -= many
    trial = pace.TRIAL * crew.FIRST_RUN_TRANSITIONS * max(0, 1 / together - 1 / alone)
    trials = 1 + math.log2(1 + seconds / pace.PAUSE)
    assert clock.now - begun < seconds + trials * trial + 1e-6


def test_a_gain_that_ends_is_noticed() -> None:
    clock = Clock()
    chooses = Pace(clock)
    busy = []
    for run in range(300):
        shared = chooses.is_for_all
        busy.append(shared)
        seconds = 0.01
        clock.now += seconds
        rate = (1.8e7 if run < 100 else 0.8e7) if shared else 1e7
        chooses.note(round(seconds * rate), seconds, together=shared)
    assert all(busy[10:50])
    given_up = busy.index(False, 101)  # at 100 one thread does a run in between
    assert given_up < 110
    assert not any(busy[given_up : given_up + round(pace.PAUSE / 0.01)])


def test_small_searches_have_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object, **__: object) -> None:
        raise AssertionError("a crew was made")

    monkeypatch.setattr(levels, "Crew", refused)
    packed = pack(synchronised({name: cycle(*(f"{name}{i}" for i in range(10))) for name in "ABCDE"}))
    assert explore(packed, workers=2).levels[-1] == 100_000


def test_each_trial_begins_with_small_runs() -> None:
    packed = pack(synchronised({name: cycle(*(f"{name}{i}" for i in range(10))) for name in "ABC"}))
    found = Visited(packed.words)
    together = crew.Crew([Worker(packed, None) for _ in range(2)], found)
    code = jit.kernels(True)
    found.insert(code, packed.initial.copy(), 0, 1)
    together.divide(code)
    first = together.rows_per_run
    assert first == crew.FIRST_RUN_TRANSITIONS // 8
    try:
        step = Wave(packed.visible, True, found.rows, 0, np.zeros(0, dtype=np.uint8))
        done = 0
        while done < found.known:
            begin, done = done, found.known
            together.run(code, step, begin, done, lambda: together.grow(code))
        assert (found.known, together.transitions) == (1_000, 3_000)
        assert together.rows_per_run == crew.RUN_TRANSITIONS // 3  # 28 levels
        together.begin_again()
        assert together.rows_per_run == crew.FIRST_RUN_TRANSITIONS // 3
    finally:
        together.dismiss()


def test_runs_of_all_that_none_is_held_against_say_nothing() -> None:
    chooses = Pace(Clock())
    for _ in range(3 * pace.TRIAL):
        chooses.note(10_000, 0.01, together=True)
    assert not chooses.is_for_all
