"""How many events a second a generated program's runtime lets happen, beside a hand-over through ``queue.Queue``.

``python tests/benchmarks/bench_runtime.py`` prints for each shape of program and each runner the events per second of
the best of some runs, and the ratio to the same by hand with threads and queues of one place, measured in turns: a
producer waits until its item has been taken, as with a synchronous channel. A choice by hand is a queue that all
producers share. The ring is compared with the hand-over between two threads.
"""

from __future__ import annotations

import queue
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from cspcheck.codegen.runtime import Channel, Fair, Integers, Program, Record, Runner, Task

EVENTS = 20_000
RUNS = 3
RUNNERS: tuple[Runner, ...] = ("threads", "asyncio", "loop")


class Nothing:
    """Records nothing."""

    def record(self, record: Record) -> None:
        """Forget it."""

    def close(self) -> None:
        """Nothing is left."""


class Put(Task):
    """Sends for ever."""

    def __init__(self, name: str, channel: Channel) -> None:
        super().__init__(name)
        self.channel = channel

    async def run(self) -> None:
        """For ever."""
        value = 0
        while True:
            await self.perform(self.channel.put(value))
            value = (value + 1) % 10


class Pass(Task):
    """Receives and sends on; the first one begins."""

    def __init__(self, name: str, source: Channel, target: Channel, begins: bool) -> None:
        super().__init__(name)
        self.source, self.target, self.begins = source, target, begins

    async def run(self) -> None:
        """For ever."""
        if self.begins:
            await self.perform(self.target.put(0))
        while True:
            (value,) = await self.perform(self.source.get())
            await self.perform(self.target.put(value))


class Choose(Task):
    """Takes from whichever of some channels."""

    def __init__(self, name: str, channels: list[Channel]) -> None:
        super().__init__(name)
        self.channels = channels

    async def run(self) -> None:
        """For ever."""
        while True:
            await self.select(*[channel.get() for channel in self.channels])


def pair() -> list[Task]:
    """Two tasks and a channel."""
    channel = Channel("c", [Integers(0, 9)], parties=[("P", "C")])
    return [Put("P", channel), Choose("C", [channel])]


def ring() -> list[Task]:
    """Ten tasks that pass a value round."""
    names = [f"T{i}" for i in range(10)]
    channels = [Channel(f"c{i}", [Integers(0, 9)], parties=[(names[i - 1], names[i])]) for i in range(10)]
    return [Pass(names[i], channels[i], channels[(i + 1) % 10], i == 0) for i in range(10)]


def choice() -> list[Task]:
    """Eight senders and a task that takes from any of them."""
    channels = [Channel(f"c{i}", [Integers(0, 9)], parties=[(f"P{i}", "C")]) for i in range(8)]
    return [*[Put(f"P{i}", channel) for i, channel in enumerate(channels)], Choose("C", channels)]


def queue_hand_over() -> float:
    """Hand-overs a second between two threads: each item is taken before the next is put."""
    there: queue.Queue[int] = queue.Queue(1)
    back: queue.Queue[int] = queue.Queue(1)
    count = EVENTS // 2

    def consume() -> None:
        for _ in range(count):
            there.get()
            back.put(0)

    thread = threading.Thread(target=consume)
    started = time.perf_counter()
    thread.start()
    for i in range(count):
        there.put(i)
        back.get()
    thread.join()
    return count / (time.perf_counter() - started)


def queue_choice() -> float:
    """Hand-overs a second from eight threads to one that takes whatever comes."""
    there: queue.Queue[tuple[int, int]] = queue.Queue(1)
    back: list[queue.Queue[bool]] = [queue.Queue(1) for _ in range(8)]
    count = EVENTS // 2

    def produce(me: int) -> None:
        value = 0
        while True:
            there.put((me, value))
            if back[me].get():
                return
            value = (value + 1) % 10

    for i in range(8):
        threading.Thread(target=produce, args=(i,), daemon=True).start()
    started = time.perf_counter()
    for _ in range(count):
        me, _value = there.get()
        back[me].put(False)
    taken = time.perf_counter() - started
    for _ in range(8):
        me, _value = there.get()
        back[me].put(True)
    return count / taken


def events_a_second(tasks: Callable[[], list[Task]], runner: Runner) -> float:
    """The speed of a program."""
    program = Program(tasks())
    started = time.perf_counter()
    summary = program.run(runner, recorder=Nothing(), policy=Fair(), events=EVENTS)
    assert summary.events == EVENTS
    return EVENTS / (time.perf_counter() - started)


def main() -> None:
    """Measure and print."""
    for shape, by_hand in ((pair, queue_hand_over), (ring, queue_hand_over), (choice, queue_choice)):
        speeds: dict[str, float] = {}
        for _ in range(RUNS):
            speeds["by hand"] = max(speeds.get("by hand", 0.0), by_hand())
            for runner in RUNNERS:
                speeds[runner] = max(speeds.get(runner, 0.0), events_a_second(shape, runner))
        for name, speed in speeds.items():
            text = f"{shape.__name__}, {name}"
            print(f"{text:28s} {speed:10,.0f} events/s   {speed / speeds['by hand']:5.2f} x", flush=True)


if __name__ == "__main__":
    main()
