"""How many events a second a generated Python program lets happen, beside what a person would write by hand.

``python tests/benchmarks/bench_runtime.py`` generates for each shape a program and runs it with each runner, in turns
with a program by hand for the same: with threads and queues of one place for the threads, with asyncio and its queues
for the event loop and the plain loop. By hand, too, a sender waits until its item has been taken, as on a synchronous
channel, and a choice is a queue that all senders share. Nothing is recorded. It prints the medians of the events a
second of processor time and of the ratios of runs next to one another; ``taskset -c 1`` keeps threads on one processor,
and ``--wall`` counts the time of the clock instead.
"""

from __future__ import annotations

import asyncio
import importlib
import queue
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cspcheck
from cspcheck.codegen.design.program import design
from cspcheck.codegen.emit.keeping import write
from cspcheck.codegen.emit.project import project

EVENTS = 4_000
RUNS = 9
RUNNERS = ("threads", "asyncio", "loop")
CLOCK = time.perf_counter if "--wall" in sys.argv else time.process_time

SCRIPTS = {
    "pair": """
channel c : {0..9}
P(n) = c!n -> P((n + 1) % 10)
C = c?x -> C
SYSTEM = P(0) [| {| c |} |] C
""",
    "ring": """
channel c : {0..9}.{0..9}
NODE(i) = c.i?x -> c.((i + 1) % 10)!x -> NODE(i)
FIRST = c.1!0 -> NODE(0)
SYSTEM = || i : {0..9} @ [{| c.i, c.((i + 1) % 10) |}] (if i == 0 then FIRST else NODE(i))
""",
    "family of 8": """
channel c : {0..7}.{0..9}
P(i, n) = c.i!n -> P(i, (n + 1) % 10)
C = c?i?x -> C
SYSTEM = (||| i : {0..7} @ P(i, 0)) [| {| c |} |] C
""",
    "choice of 8": """
channel c0, c1, c2, c3, c4, c5, c6, c7 : {0..9}
"""
    + "\n".join(f"P{i}(n) = c{i}!n -> P{i}((n + 1) % 10)" for i in range(8))
    + f"""
C = {" [] ".join(f"c{i}?x -> C" for i in range(8))}
SYSTEM = ({" ||| ".join(f"P{i}(0)" for i in range(8))}) [| {{| c0, c1, c2, c3, c4, c5, c6, c7 |}} |] C
""",
}


def timed(threads: list[Callable[[], None]]) -> float:
    """Run the first of some functions, the others each in a thread beside it; events a second."""
    beside = [threading.Thread(target=one) for one in threads[1:]]
    started = CLOCK()
    for thread in beside:
        thread.start()
    threads[0]()
    for thread in beside:
        thread.join()
    return EVENTS / (CLOCK() - started)


def pair_by_threads() -> float:
    """Two threads: each item is taken before the next is put."""
    there: queue.Queue[int] = queue.Queue(1)
    back: queue.Queue[None] = queue.Queue(1)

    def produce() -> None:
        value = 0
        for _ in range(EVENTS):
            there.put(value)
            back.get()
            value = (value + 1) % 10

    def consume() -> None:
        for _ in range(EVENTS):
            there.get()
            back.put(None)

    return timed([consume, produce])


def ring_by_threads() -> float:
    """Ten threads pass a value round; None ends them."""
    there: list[queue.Queue[int | None]] = [queue.Queue(1) for _ in range(10)]
    back: list[queue.Queue[None]] = [queue.Queue(1) for _ in range(10)]

    def node(me: int) -> Callable[[], None]:
        source, target, taken, passed = there[me], there[(me + 1) % 10], back[me], back[(me + 1) % 10]

        def run() -> None:
            left = EVENTS // 10
            if me == 0:
                target.put(0)
                passed.get()
                left -= 1
            while True:
                value = source.get()
                taken.put(None)
                if value is None:
                    if me != 0:
                        target.put(None)
                        passed.get()
                    return
                target.put(None if me == 0 and left == 0 else value)
                left -= 1
                passed.get()

        return run

    return timed([node(i) for i in range(10)])


def choice_by_threads() -> float:
    """Eight threads send to one that takes whatever comes."""
    there: queue.Queue[tuple[int, int]] = queue.Queue(1)
    back: list[queue.Queue[bool]] = [queue.Queue(1) for _ in range(8)]

    def produce(me: int) -> Callable[[], None]:
        def run() -> None:
            value = 0
            while True:
                there.put((me, value))
                if back[me].get():
                    return
                value = (value + 1) % 10

        return run

    def consume() -> None:
        for _ in range(EVENTS - 8):
            me, _value = there.get()
            back[me].put(False)
        for _ in range(8):
            me, _value = there.get()
            back[me].put(True)

    return timed([consume, *[produce(i) for i in range(8)]])


def pair_by_asyncio() -> float:
    """The same in an event loop."""

    async def main() -> None:
        there: asyncio.Queue[int] = asyncio.Queue(1)
        back: asyncio.Queue[None] = asyncio.Queue(1)

        async def produce() -> None:
            value = 0
            for _ in range(EVENTS):
                await there.put(value)
                await back.get()
                value = (value + 1) % 10

        async def consume() -> None:
            for _ in range(EVENTS):
                await there.get()
                await back.put(None)

        await asyncio.gather(produce(), consume())

    return timed([lambda: asyncio.run(main())])


def ring_by_asyncio() -> float:
    """The same in an event loop."""

    async def main() -> None:
        there: list[asyncio.Queue[int]] = [asyncio.Queue(1) for _ in range(10)]
        back: list[asyncio.Queue[None]] = [asyncio.Queue(1) for _ in range(10)]

        async def node(me: int) -> None:
            source, target, taken, passed = there[me], there[(me + 1) % 10], back[me], back[(me + 1) % 10]
            if me == 0:
                await target.put(0)
                await passed.get()
            left = EVENTS // 10
            while me != 0 or left > 0:
                value = await source.get()
                await taken.put(None)
                await target.put(value)
                await passed.get()
                left -= 1

        nodes = [asyncio.ensure_future(node(i)) for i in range(10)]
        await nodes[0]
        for one in nodes[1:]:
            one.cancel()

    return timed([lambda: asyncio.run(main())])


def choice_by_asyncio() -> float:
    """The same in an event loop."""

    async def main() -> None:
        there: asyncio.Queue[tuple[int, int]] = asyncio.Queue(1)
        back: list[asyncio.Queue[None]] = [asyncio.Queue(1) for _ in range(8)]

        async def produce(me: int) -> None:
            value = 0
            while True:
                await there.put((me, value))
                await back[me].get()
                value = (value + 1) % 10

        senders = [asyncio.ensure_future(produce(i)) for i in range(8)]
        for _ in range(EVENTS):
            me, _value = await there.get()
            await back[me].put(None)
        for sender in senders:
            sender.cancel()

    return timed([lambda: asyncio.run(main())])


BY_HAND = {
    "pair": (pair_by_threads, pair_by_asyncio),
    "ring": (ring_by_threads, ring_by_asyncio),
    "family of 8": (choice_by_threads, choice_by_asyncio),
    "choice of 8": (choice_by_threads, choice_by_asyncio),
}


def generated(script: str, name: str, folder: Path) -> Callable[[str], float]:
    """The program of a script; its events a second with a runner."""
    write(project(design(cspcheck.loads(script)._script, "SYSTEM"), name), folder / name)
    main = importlib.import_module(f"{name}.main")
    runtime = importlib.import_module(f"{name}.runtime")

    def run(runner: str) -> float:
        program = runtime.Program(main.tasks())
        started = CLOCK()
        summary = program.run(runner, events=EVENTS)
        taken = CLOCK() - started
        assert summary.events == EVENTS
        return EVENTS / taken

    return run


def main() -> None:
    """Measure and print."""
    with tempfile.TemporaryDirectory() as folder:
        sys.path.insert(0, folder)
        for shape, script in SCRIPTS.items():
            run = generated(script, shape.replace(" ", "_"), Path(folder))
            for runner in RUNNERS:
                by_hand = BY_HAND[shape][0 if runner == "threads" else 1]
                speeds = [(run(runner), by_hand()) for _ in range(RUNS)]
                ours, theirs = (median(pair[i] for pair in speeds) for i in (0, 1))
                ratio = median(own / other for own, other in speeds)
                text = f"{ours:10,.0f} events/s   by hand {theirs:10,.0f}"
                print(f"{shape:12s} {runner:8s} {text}   {ratio:5.2f} x", flush=True)


if __name__ == "__main__":
    main()
