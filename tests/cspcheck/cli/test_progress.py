"""Progress on standard error: a live line on a terminal, a line now and then elsewhere, nothing at first."""

from __future__ import annotations

import io
import time
from dataclasses import dataclass

import pytest

from cspcheck.cli.progress import Heartbeat, ProgressLine
from cspcheck.report.style import Style


@dataclass(frozen=True)
class Progress:
    states: int
    transitions: int = 0
    depth: int = 7
    frontier: int = 1000
    seconds: float = 0.0
    memory_bytes: int = 3 * 1024**2


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def run(times: list[float], *, live: bool = True, quiet: bool = False, width: int = 100) -> str:
    """Progress of 1,000 states a second, told at the given times after the beginning."""
    stream, clock = io.StringIO(), Clock()
    line = ProgressLine(stream.write, Style(width=width), live=live, quiet=quiet, clock=clock)
    line.begin("SYSTEM :[deadlock free [FD]]")
    for moment in times:
        clock.now = 100.0 + moment
        line.progress(Progress(int(1000 * moment)))  # type: ignore[arg-type]
    line.done()
    return stream.getvalue()


@pytest.mark.parametrize("live", [True, False])
def test_nothing_in_the_first_second(live: bool) -> None:
    assert run([0.1, 0.5, 0.99], live=live) == ""


def test_a_live_line_on_a_terminal() -> None:
    text = run([0.5, 1.0, 1.1, 1.25, 2.0])

    assert text.split("\r\x1b[K") == [
        "",
        "SYSTEM :[deadlock free [FD]]: 1,000 states, 1.0k states/s, depth 7, frontier 1,000, 3.0 MiB, 1 s",
        "SYSTEM :[deadlock free [FD]]: 1,250 states, 1.0k states/s, depth 7, frontier 1,000, 3.0 MiB, 1 s",
        "SYSTEM :[deadlock free [FD]]: 2,000 states, 1.0k states/s, depth 7, frontier 1,000, 3.0 MiB, 2 s",
        "",
    ]


def test_the_live_line_never_wraps() -> None:
    for width in (40, 60, 80):
        assert max(map(len, run([1, 2, 3], width=width).split("\r\x1b[K"))) < width


def test_a_line_every_ten_seconds_elsewhere() -> None:
    assert run([1, 5, 9.9, 10, 15, 19.9, 20.5, 25], live=False).splitlines() == [
        "SYSTEM :[deadlock free [FD]]: 10,000 states, 1.0k states/s, depth 7, frontier 1,000, 3.0 MiB, 10 s",
        "SYSTEM :[deadlock free [FD]]: 20,500 states, 1.0k states/s, depth 7, frontier 1,000, 3.0 MiB, 20 s",
    ]


def test_quiet_is_quiet() -> None:
    assert run([1, 2, 20], quiet=True) == ""


def test_a_notice_takes_the_live_line_away_first() -> None:
    stream, clock = io.StringIO(), Clock()
    line = ProgressLine(stream.write, Style(), live=True, clock=clock)
    line.begin("P")
    clock.now += 2
    line.progress(Progress(5))  # type: ignore[arg-type]
    line.notify("compiling")

    assert stream.getvalue().endswith("\r\x1b[Kcompiling\n")


def test_work_that_tells_nothing_shows_its_time() -> None:
    stream, clock = io.StringIO(), Clock()
    line = ProgressLine(stream.write, Style(), live=True, clock=clock)
    line.begin("reading large.csp")
    for _ in range(6):
        clock.now += 0.5
        line.beat()
    line.done()
    clock.now += 10
    line.beat()

    assert stream.getvalue().split("\r\x1b[K") == [
        "",
        "reading large.csp: 1 s",
        "reading large.csp: 2 s",
        "reading large.csp: 2 s",
        "reading large.csp: 2 s",
        "reading large.csp: 3 s",
        "",
    ]


def test_a_beat_does_not_hide_the_numbers_of_a_search() -> None:
    stream, clock = io.StringIO(), Clock()
    line = ProgressLine(stream.write, Style(), live=True, clock=clock)
    line.begin("P")
    for _ in range(10):
        clock.now += 0.3
        line.progress(Progress(5))  # type: ignore[arg-type]
        clock.now += 0.3
        line.beat()

    assert all("states" in shown for shown in stream.getvalue().split("\r\x1b[K")[1:])


def test_the_heart_beats_until_the_end() -> None:
    beats: list[float] = []
    with Heartbeat(lambda: beats.append(time.monotonic())):
        time.sleep(0.7)
    count = len(beats)
    time.sleep(0.3)

    assert count >= 1
    assert len(beats) == count


def test_each_check_has_its_own_second() -> None:
    stream, clock = io.StringIO(), Clock()
    line = ProgressLine(stream.write, Style(), live=True, clock=clock)
    for _ in range(5):
        line.begin("P")
        clock.now += 0.9
        line.progress(Progress(5))  # type: ignore[arg-type]
        line.done()

    assert stream.getvalue() == ""
