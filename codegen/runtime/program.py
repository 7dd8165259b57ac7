"""Programs: tasks put together, and the ways to run them.

The same tasks are carried by threads (one each), by an asyncio event loop, or by a plain loop in the calling
thread. What they do is the same algorithm each time, that of :class:`~.run.Run`; with a virtual
clock it is also the same run, event for event.
"""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import Callable, Generator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Literal

from .alternation import Fair, Policy
from .channel import Offer
from .clock import Clock, MonotonicClock, VirtualClock
from .recorder import Nothing, Recorder
from .run import Party, Run
from .task import Stopped, Task

Runner = Literal["threads", "asyncio", "loop"]
"""Who carries the tasks."""

PATIENCE = 5.0
"""Seconds that tasks get to end when the program is stopped."""


@dataclass(frozen=True, slots=True)
class Summary:
    """What a run came to.

    Attributes:
        events: how many events happened.
        seconds: the time of the clock at the end.
        terminated: whether all tasks ended of themselves; otherwise the run was stopped.
        missed: for each periodic task how many of its releases were missed.
        lingering: tasks that had not ended some seconds after they were told to.
    """

    events: int
    seconds: float
    terminated: bool
    missed: dict[str, int]
    lingering: tuple[str, ...] = ()


class Program:
    """Some tasks that belong together."""

    def __init__(self, tasks: Sequence[Task]) -> None:
        self.tasks = tuple(tasks)
        self._current: Run | None = None

    def run(
        self,
        runner: Runner = "threads",
        *,
        clock: Clock | None = None,
        policy: Policy | None = None,
        recorder: Recorder | None = None,
        events: int | None = None,
        seconds: float | None = None,
        serial: bool | None = None,
    ) -> Summary:
        """Run the program until all tasks have ended, or as long as is allowed.

        Args:
            runner: who carries the tasks.
            clock: a monotonic clock unless another is given.
            policy: what decides between several possible events; :class:`Fair` if none is given.
            recorder: is told every event; nothing is kept unless one is given.
            events: stop after so many events.
            seconds: stop at this time of the clock.
            serial: whether one task runs at a time. It must be so with a virtual clock and in a plain loop, and is
                otherwise as the runner likes it.

        Raises:
            Deadlock: all tasks wait for ever.
            Exception: whatever a task or the recorder raised; all tasks have been stopped by then.
        """
        clock = clock if clock is not None else MonotonicClock()
        recorder = recorder if recorder is not None else Nothing()
        must = runner == "loop" or isinstance(clock, VirtualClock)
        if must and serial is False:
            raise ValueError("with a virtual clock or in a plain loop one task runs at a time")
        run = Run(
            clock,
            policy if policy is not None else Fair(),
            recorder,
            serial=must or bool(serial),
            most=events,
            until=seconds,
        )
        self._current = run
        lingering: tuple[str, ...] = ()
        try:
            if events is None or events > 0:
                if runner == "threads":
                    lingering = _threads(run, self.tasks)
                elif runner == "asyncio":
                    lingering = _aside(run, lambda: asyncio.run(_event_loop(run, self.tasks)))
                else:
                    lingering = _aside(run, lambda: _plain_loop(run, self.tasks))
        finally:
            self._current = None
            recorder.close()
        if run.failure is not None:
            raise run.failure
        missed = {task.name: task.missed for task in self.tasks if task.period is not None}
        return Summary(run.events, clock.now(), run.terminated, missed, lingering)

    def stop(self) -> None:
        """Stop the program, from another thread or from a task."""
        if self._current is not None:
            self._current.stop()


def _aside(run: Run, carry: Callable[[], None]) -> tuple[str, ...]:
    """Carry all tasks by one thread that can be left behind; the task that keeps it from ending, if one does.

    A body that waits for something that never comes would otherwise keep the whole program from being stopped.
    """
    raised: list[BaseException] = []

    def carried() -> None:
        try:
            carry()
        except BaseException as error:
            raised.append(error)
        finally:
            run.over.set()

    thread = threading.Thread(target=carried, name="tasks", daemon=True)
    thread.start()
    try:
        run.wait()
    finally:
        run.stop()
        thread.join(PATIENCE)
    if raised:
        raise raised[0]
    return (run.current,) if thread.is_alive() and run.current is not None else ()


def _waits(run: Run, party: Party) -> Generator[tuple[Offer | None, ...] | None, None, None]:
    """Carry one task from one place where it waits to the next.

    Yields:
        What it offers, where it has to pass its gate before it goes on; None where it goes on at once.
    """
    run.current = party.task.name
    coroutine = party.task.run()
    error: BaseException | None = None
    try:
        offers: tuple[Offer | None, ...] = coroutine.send(None)
        while True:
            try:
                outcome = run.submit(party, offers)
            except Exception as wrong:
                offers = coroutine.throw(wrong)
                continue
            if outcome is None:
                yield offers
                outcome, party.outcome = party.outcome, None
            else:
                yield None
            run.current = party.task.name
            offers = coroutine.throw(outcome) if isinstance(outcome, Stopped) else coroutine.send(outcome)
    except StopIteration:
        pass
    except GeneratorExit:  # nobody carries it on
        coroutine.close()
        raise
    except BaseException as raised:
        error = raised
    run.leave(party, error)


# --- threads ---------------------------------------------------------------------------------------------------


class _Latch:
    """A gate for threads: a lock that is closed when it is made and when it has been passed."""

    __slots__ = ("_lock",)

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._lock.acquire()

    def open(self) -> None:
        self._lock.release()

    def wait(self, seconds: float | None) -> bool:
        """Pass the gate; False if it did not open in time."""
        if seconds is None:
            return self._lock.acquire()
        return self._lock.acquire(timeout=min(seconds, threading.TIMEOUT_MAX))


def _threads(run: Run, tasks: Sequence[Task]) -> tuple[str, ...]:
    """Carry each task by a thread of its own; the names of those that would not end."""
    latches = [_Latch() for _ in tasks]
    parties = [Party(task, latch) for task, latch in zip(tasks, latches, strict=True)]
    threads = [
        threading.Thread(target=_thread, args=(run, party, latch), name=party.task.name, daemon=True)
        for party, latch in zip(parties, latches, strict=True)
    ]
    run.begin(parties)
    try:
        for thread in threads:
            thread.start()
        run.wait()
    finally:
        # Also when the main thread is interrupted: nobody is left behind.
        run.stop()
        for thread in threads:
            if thread.ident is not None:
                thread.join(PATIENCE)
    return tuple(thread.name for thread in threads if thread.is_alive())


def _thread(run: Run, party: Party, latch: _Latch) -> None:
    """Carry one task."""
    if run.serial:
        latch.wait(None)
    for offers in _waits(run, party):
        if offers is not None:
            while not latch.wait(run.patience(party, offers)):
                run.retry(party)


# --- one thread for all ----------------------------------------------------------------------------------------


class _Turn:
    """A gate that notes whose turn it is."""

    __slots__ = ("open",)

    def __init__(self, turns: deque[int], position: int) -> None:
        self.open = partial(turns.append, position)


def _plain_loop(run: Run, tasks: Sequence[Task]) -> None:
    """Carry all tasks in the calling thread."""
    turns: deque[int] = deque()
    parties = [Party(task, _Turn(turns, i)) for i, task in enumerate(tasks)]
    waits = [_waits(run, party) for party in parties]
    run.begin(parties)
    while turns:
        for offers in waits[turns.popleft()]:
            if offers is not None:
                break


TURNS = 100
"""So many turns of tasks are one turn of the event loop that carries them."""


async def _event_loop(run: Run, tasks: Sequence[Task]) -> None:
    """Carry the tasks in an event loop, which waits only when all of them do.

    No future is made for a task, and no turn of the event loop goes by for it: tasks await nothing but one another.
    """
    turns: deque[int] = deque()
    rung = asyncio.Event()
    loop = asyncio.get_running_loop()

    def ring() -> None:
        with suppress(RuntimeError):  # the loop may have come to its end meanwhile
            loop.call_soon_threadsafe(rung.set)

    run.alarm = ring
    parties = [Party(task, _Turn(turns, i)) for i, task in enumerate(tasks)]
    waits = [_waits(run, party) for party in parties]
    run.begin(parties)
    if not run.serial:
        turns.extend(range(len(parties)))
    left = len(parties)
    sleeping: dict[int, tuple[Offer | None, ...]] = {}
    """Those that wait for a time as well, and what they offer."""
    while left:
        for _ in range(TURNS):
            if not turns:
                break
            i = turns.popleft()
            if sleeping:
                sleeping.pop(i, None)
            try:
                offers = next(waits[i])
            except StopIteration:
                left -= 1
                continue
            if offers is None:
                turns.append(i)  # a task that never has to wait must not keep the others from running
            elif run.timed and run.patience(parties[i], offers) is not None:
                sleeping[i] = offers
        seconds: float | None = None
        for i, offers in list(sleeping.items()):
            patience = run.patience(parties[i], offers)
            if patience is not None and patience <= 0.0:
                run.retry(parties[i])
                patience = run.patience(parties[i], offers)
            if patience is not None and (seconds is None or patience < seconds):
                seconds = patience
        if turns:
            await asyncio.sleep(0)
        elif left:
            with suppress(TimeoutError):
                await asyncio.wait_for(rung.wait(), seconds)
            rung.clear()
