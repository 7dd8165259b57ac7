"""Periodic tasks and clocks: releases are absolute, so nothing drifts, and virtual time is free."""

from __future__ import annotations

import time

import pytest

from cspcheck.codegen.runtime import Channel, Deadlock, Memory, Program, Runner, Task, VirtualClock

RUNNERS: tuple[Runner, ...] = ("threads", "asyncio", "loop")


class Periodic(Task):
    """A task with one event a period."""

    def __init__(self, name: str, channel: Channel, period: float, work: float = 0.0, **settings: float) -> None:
        super().__init__(name, period=period, **settings)
        self.channel = channel
        self.work = work

    async def run(self) -> None:
        while True:
            await self.perform(self.channel.offer(after=self.release))
            self.released()
            if self.work:
                time.sleep(self.work)


def test_an_hour_of_cycles_takes_seconds_and_does_not_drift() -> None:
    fast, slow = Channel("fast", parties=["Fast"]), Channel("slow", parties=["Slow"])
    tasks = [Periodic("Fast", fast, 0.1), Periodic("Slow", slow, 60.0, offset=0.05)]
    memory = Memory()
    summary = Program(tasks).run("loop", clock=VirtualClock(), recorder=memory, seconds=3600.0)
    times = [record.time for record in memory.records if record.channel == "fast"]
    assert len(times) == 36_000
    assert times == [n * 0.1 for n in range(36_000)]
    assert [record.time for record in memory.records if record.channel == "slow"] == [0.05 + n * 60 for n in range(60)]
    assert summary.seconds == 3600.0
    assert summary.missed == {"Fast": 0, "Slow": 0}


@pytest.mark.parametrize("runner", RUNNERS)
def test_virtual_time_is_the_same_for_every_runner(runner: Runner) -> None:
    channels = [Channel(f"c{i}", parties=[f"T{i}"]) for i in range(3)]
    tasks = [Periodic(f"T{i}", channel, 0.3 + 0.1 * i, offset=0.01 * i) for i, channel in enumerate(channels)]
    memory = Memory()
    Program(tasks).run(runner, clock=VirtualClock(), recorder=memory, seconds=2.0)
    assert [(round(record.time, 2), record.event) for record in memory.records] == sorted(
        (round(0.01 * i + n * (0.3 + 0.1 * i), 2), f"c{i}")
        for i in range(3)
        for n in range(10)
        if 0.01 * i + n * (0.3 + 0.1 * i) < 2
    )


@pytest.mark.parametrize("runner", RUNNERS)
def test_real_time_keeps_to_the_grid(runner: Runner) -> None:
    """However late a release comes, it is never early, and the next is due where it was due from the start."""
    c = Channel("c", parties=["T"])
    task = Periodic("T", c, 0.02)
    memory = Memory()
    summary = Program([task]).run(runner, recorder=memory, seconds=0.3)
    assert len(memory.records) + task.missed <= 16
    previous = -1
    for record in memory.records:
        due = int(record.time / 0.02 + 1e-9)
        assert due > previous
        previous = due
    assert summary.seconds >= 0.3


def test_missed_deadlines_are_counted_and_left_out() -> None:
    """Work of two and a half periods: no release comes within its period, and half of them do not come at all."""
    c = Channel("c", parties=["T"])
    clock = VirtualClock()

    class Busy(Task):
        async def run(self) -> None:
            while True:
                clock.advance(clock.now() + 2.5)
                await self.perform(c.offer(after=self.release))
                self.released()

    memory = Memory()
    task = Busy("T", period=1.0)
    summary = Program([task]).run("loop", clock=clock, recorder=memory, events=4)
    assert [record.time for record in memory.records] == [2.5, 5.0, 7.5, 10.0]
    assert (task.releases, summary.missed) == (4, {"T": 10})


def test_a_time_that_will_come_is_no_deadlock() -> None:
    c, never = Channel("c", parties=["T"]), Channel("never", parties=[("T", "U")])

    class Patient(Task):
        async def run(self) -> None:
            choice = await self.select(never.put(), c.offer(after=5.0))
            assert choice.taken == 1
            await self.perform(never.put())

    memory = Memory()
    with pytest.raises(Deadlock):
        Program([Patient("T")]).run("loop", clock=VirtualClock(), recorder=memory)
    assert [(record.time, record.event) for record in memory.records] == [(5.0, "c")]


def test_a_virtual_clock_needs_one_task_at_a_time() -> None:
    with pytest.raises(ValueError, match="one task runs at a time"):
        Program([]).run("threads", clock=VirtualClock(), serial=False)
