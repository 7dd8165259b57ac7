"""Limits hold in any work, and leave nothing behind when they were passed."""

from __future__ import annotations

import subprocess
import sys
import time

import pytest

from cspcheck.checker.guard import Guard, set_aside, working_time
from cspcheck.cspm.interruption import Stopped

AFTERWARDS = """
import sys, time
from cspcheck.checker.guard import Guard
from cspcheck.cspm.interruption import Stopped

def step(frame, event, argument):
    return step

for case in range(20):
    guard = Guard(seconds=-1)
    try:
        with guard:
            # The end of the work and the exception meet somewhere, from case to case elsewhere.
            while guard.reached is None and case % 4 < 3:
                pass
            for _ in range(case * 100):
                pass
    except Stopped:
        pass
sys.settrace(step)
print(sum(range(100)), [number for number in range(3)])
"""


def test_work_is_stopped() -> None:
    guard = Guard(seconds=0)
    with pytest.raises(Stopped):
        guard.run(lambda: [None for _ in iter(int, 1)])
    assert guard.reached == "seconds"


class Busy:
    """An object that is at work while it goes."""

    def __init__(self, guard: Guard, reports: list[str]) -> None:
        self.guard, self.reports = guard, reports

    def __del__(self) -> None:
        while self.guard.reached is None:
            pass
        for _ in range(100_000):
            pass
        self.reports.append("not stopped in the finaliser")  # Python drops what arrived before


def test_what_a_finaliser_drops_arrives_again(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("cspcheck.checker.guard.AGAIN", float("inf"))  # never without a reason
    reports: list[str] = []
    guard = Guard(seconds=-1)

    def work() -> None:
        Busy(guard, reports)
        while True:
            pass

    with pytest.raises(Stopped):
        guard.run(work)
    assert guard.reached == "seconds"
    assert not reports
    assert capsys.readouterr().err == ""


def test_work_that_ends_in_time_is_let_alone() -> None:
    assert Guard(seconds=60).run(lambda: 42) == 42


def test_nothing_arrives_behind_the_end() -> None:
    for length in range(40):
        guard = Guard(seconds=-1)
        try:
            with guard:
                until = time.monotonic() + length / 1000
                while time.monotonic() < until:
                    pass
        except Stopped:
            assert guard.reached == "seconds"
        for _ in range(1000):
            pass


def test_a_debugger_goes_on_after_a_limit_was_passed() -> None:
    ended = subprocess.run([sys.executable, "-c", AFTERWARDS], capture_output=True, text=True, timeout=120, check=True)
    assert ended.stdout == "4950 [0, 1, 2]\n"


def test_what_is_set_aside_is_no_time_of_the_work() -> None:
    """Until it is over it is: a limit holds meanwhile."""
    start, real = working_time(), time.monotonic()
    with set_aside():
        time.sleep(0.1)
        assert working_time() - start >= 0.1
    assert working_time() - start <= time.monotonic() - real - 0.1

    def forever() -> None:
        while True:
            time.sleep(0.01)

    with pytest.raises(Stopped), Guard(seconds=0.1), set_aside():
        forever()
    with Guard(seconds=60) as held, set_aside():
        time.sleep(0.01)
    assert held.reached is None
