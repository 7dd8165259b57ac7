"""Limits that hold wherever the work is.

Searches look at their limits themselves, at places where they can say what they have covered. All other work (the
evaluation of a script, compressions, normal forms, printing, explaining) is watched from a thread: when the time is
over, or the process has more memory than it may, :class:`~cspcheck.cspm.interruption.Stopped` arrives in the working
thread between two steps of the program. What was half done then is of no use to anybody: who catches it starts anew.

Machine code is not interrupted. Loops in it come back several times a second; the compiler of the kernels runs in a
thread of its own, the solver in a process.
"""

from __future__ import annotations

import ctypes
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Literal, Self, TypeVar

from cspcheck.cspm.interruption import Stopped

T = TypeVar("T")
Limit = Literal["seconds", "memory", "machine"]

INTERVAL = 0.02
"""Seconds between two looks."""
PATIENCE = 0.2
"""Seconds that work which looks at its time itself may take to notice that it is over."""
AGAIN = 1.0
"""Seconds after which who has not stopped is told again: somebody on the way may have dropped the exception.

What is dropped by Python itself, because it came inside a finaliser or the callback of a weak reference, is told again
at once (:class:`_Dropped`)."""
SPARE = 1.03
"""A search may use all of its memory limit; other work is stopped a little above, so that the search stops first."""
SCARCE = 0.02
"""The machine has no memory left when less than this part of it is available."""
SMALL = 256 << 20
"""A process of less than this is not to blame for a machine without memory."""


class _Aside:
    """How many seconds have been set aside."""

    seconds = 0.0


def working_time() -> float:
    """A clock in seconds that leaves out what was set aside, once that is over."""
    return time.monotonic() - _Aside.seconds


@contextmanager
def set_aside() -> Iterator[None]:
    """In the block something is done that is done once on a machine: no check has it counted as its own time."""
    start = time.monotonic()
    yield
    _Aside.seconds += time.monotonic() - start


def process_memory() -> int | None:
    """Bytes of memory that this process has now; None where the system does not tell."""
    try:
        with open("/proc/self/statm", "rb", buffering=0) as file:
            return int(file.read(128).split()[1]) * _PAGE
    except (OSError, ValueError, IndexError):
        return _other_process_memory()


def _other_process_memory() -> int | None:
    if sys.platform == "win32":
        return None
    import resource

    # The most so far: more than now, perhaps, and then a limit is reached too early rather than too late.
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def available_memory() -> int | None:
    """Bytes of memory that the machine could still give to somebody; None where the system does not tell."""
    try:
        with open("/proc/meminfo", "rb", buffering=0) as file:
            for line in file.read(4096).splitlines():
                if line.startswith(b"MemAvailable:"):
                    return int(line.split()[1]) * 1024
    except (OSError, ValueError, IndexError):
        pass
    return None


def machine_memory() -> int | None:
    """Bytes of memory of the machine, or of what a control group lets this process have of it."""
    try:
        size = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return None
    for path in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        try:
            with open(path, encoding="ascii") as file:
                size = min(size, int(file.read()))
        except (OSError, ValueError):
            continue
    return size


_PAGE = os.sysconf("SC_PAGE_SIZE") if hasattr(os, "sysconf") else 4096


class Guard:
    """Holds the work of a thread to limits.

    Args:
        seconds: how long it may take, from when the block is entered; None: for ever.
        memory_bytes: how much memory the process may have; None: any amount.

    Attributes:
        reached: the limit that was passed, or None.
    """

    def __init__(self, seconds: float | None = None, memory_bytes: int | None = None) -> None:
        self.reached: Limit | None = None
        self._seconds = seconds
        self._memory = None if memory_bytes is None else int(memory_bytes * SPARE)
        self._thread = 0
        self._end = float("inf")
        self._asked = float("-inf")
        self._words: list[object] = []

    def run(self, work: Callable[[], T]) -> T:
        """Do *work*.

        Raises:
            Stopped: it passed a limit; :attr:`reached` says which.
        """
        with self:
            return work()

    def __enter__(self) -> Self:
        self._thread = threading.get_ident()
        self._end = float("inf") if self._seconds is None else working_time() + self._seconds + PATIENCE
        _Dropped.install()
        _watcher.add(self)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        removed = False
        while True:
            try:
                _watcher.remove(self)
                removed = True
                if self.reached is not None:
                    _raise_in(self._thread, Stopped)
                    while True:
                        time.sleep(0)
                return
            except Stopped:
                # One that was on its way came just now, behind the end of the work; or, when nobody sends any more,
                # the one sent here to take it back with. It cannot be taken back with no exception in its place:
                # CPython 3.11 then looks for one at every step for ever, and a traced program does not go on at all.
                if removed:
                    return

    def look(self, now: float) -> None:
        """Stop the work if it has passed a limit. Called by the watching thread."""
        if self.reached is None:
            self.reached = self._passed(now)
        if self.reached is not None and now - self._asked >= AGAIN:
            self._asked = now
            _raise_in(self._thread, Stopped)

    def afford(self, thread: int, more: int) -> None:
        """Stop the work of a thread if it is this one's and *more* bytes would be too much.

        Raises:
            Stopped: they would.
        """
        if thread != self._thread or self._memory is None:
            return
        used = process_memory()
        if used is not None and used + more > self._memory:
            self.reached = self.reached or "memory"
            raise Stopped

    def tell_again(self, thread: int) -> None:
        """What was sent to a thread did not arrive."""
        if thread == self._thread:
            self._asked = float("-inf")

    def _passed(self, now: float) -> Limit | None:
        if working_time() > self._end:
            return "seconds"
        used = process_memory()
        if used is None:
            return None
        if self._memory is not None and used > self._memory:
            return "memory"
        if used > SMALL and _watcher.memory_is_scarce(now):
            return "machine"
        return None


LARGE = 4 << 20
"""Fewer bytes than this are taken without asking."""


def afford(more: int) -> None:
    """Ask before *more* bytes are taken at one blow, as by an array that is copied to one of twice its length.

    Between two looks of a guard such a step would take the process far over its limit.

    Raises:
        Stopped: the memory limit of a guard of this thread would be passed.
    """
    if more >= LARGE:
        _watcher.afford(more)


class _Dropped:
    """Where Python reports what it cannot raise: a :class:`Stopped` among it is sent again instead of printed."""

    def __init__(self, other: Callable[[sys.UnraisableHookArgs], object]) -> None:
        self._other = other

    def __call__(self, unraisable: sys.UnraisableHookArgs, /) -> None:
        if issubclass(unraisable.exc_type, Stopped):
            _watcher.tell_again(threading.get_ident())
        else:
            self._other(unraisable)

    @staticmethod
    def install() -> None:
        """Put it before whoever hears of such exceptions now."""
        if not isinstance(sys.unraisablehook, _Dropped):
            sys.unraisablehook = _Dropped(sys.unraisablehook)


def _raise_in(thread: int, kind: type[BaseException]) -> None:
    """Have an exception arrive in a thread, in the place of one that has not arrived yet."""
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(kind))


class _Watcher:
    """The thread that looks after all guards. It ends when there are none, and does not outlive a fork."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._guards: list[Guard] = []
        self._thread: threading.Thread | None = None
        self._process = 0
        self._looked = 0.0
        self._scarce = False

    def add(self, guard: Guard) -> None:
        """Look after a guard from now on."""
        with self._lock:
            if self._process != os.getpid():
                self._process, self._thread, self._guards = os.getpid(), None, []
            self._guards.append(guard)
            if self._thread is None or not self._thread.is_alive():
                self._thread = threading.Thread(target=self._watch, daemon=True, name="limits")
                self._thread.start()

    def remove(self, guard: Guard) -> None:
        """Look after it no more. Nothing is sent to its thread afterwards; what was sent before may still arrive."""
        with self._lock:
            if guard in self._guards:
                self._guards.remove(guard)

    def tell_again(self, thread: int) -> None:
        """Send what a thread did not get once more, without waiting."""
        # Without the lock, which this thread may hold: it can have been stopped anywhere.
        for guard in list(self._guards):
            guard.tell_again(thread)

    def afford(self, more: int) -> None:
        """Ask the guards of this thread."""
        for guard in list(self._guards):
            guard.afford(threading.get_ident(), more)

    def memory_is_scarce(self, now: float) -> bool:
        """Whether the machine has next to no memory left."""
        if now - self._looked > 0.1:
            self._looked = now
            available, size = available_memory(), machine_memory()
            self._scarce = available is not None and size is not None and available < SCARCE * size
        return self._scarce

    def _watch(self) -> None:
        idle = 0
        while idle < 50:
            time.sleep(INTERVAL)
            with self._lock:
                idle = 0 if self._guards else idle + 1
                now = time.monotonic()
                for guard in self._guards:
                    guard.look(now)
                if idle >= 50:
                    self._thread = None


_watcher = _Watcher()
