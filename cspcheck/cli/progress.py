"""How far a search is, on standard error: one live line on a terminal, a line every ten seconds elsewhere."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Self

from cspcheck.cspm.interruption import Words, doing, told
from cspcheck.quantities import show_bytes
from cspcheck.report.style import Style, harmless

if TYPE_CHECKING:
    from cspcheck.checker.search.exploration import Progress

FIRST = 1.0
"""Seconds before anything is shown."""
LIVE_INTERVAL = 0.2
"""Seconds between two states of the live line."""
LINE_INTERVAL = 10.0
"""Seconds between two lines where there is no terminal."""
LOOK_INTERVAL = 2.0
"""Seconds between two looks at what is going on inside."""
LONG = 10.0
"""Seconds after which what is going on inside is told, too."""
STALE = 1.0
"""Seconds after which the numbers of a search are old and only the time is shown."""
_ERASE = "\r\x1b[K"


class ProgressLine:
    """The progress of one piece of work after the other.

    Searches tell their progress. Other work that takes long (reading, building machines) does not: for it :meth:`beat`
    has to be called now and then, from any thread (:class:`Heartbeat`), and shows the time.

    Everything else that is written while work goes on has to be written between two calls of :meth:`done` and
    :meth:`begin`, or after :meth:`erase`, so that the live line is not in its way.
    """

    def __init__(
        self,
        write: Callable[[str], object],
        style: Style,
        *,
        live: bool,
        quiet: bool = False,
        clock: Callable[[], float] = time.monotonic,
        poll: Callable[[], None] = lambda: None,
    ) -> None:
        """*poll* is called with every progress and may raise, to end the search."""
        self._write = write
        self._style = style
        self._live = live
        self._quiet = quiet
        self._clock = clock
        self._poll = poll
        self._what = ""
        self._doing: Sequence[Words] = ()
        self._said = (-LOOK_INTERVAL, "")
        self._start = self._next = 0.0
        self._shown = False
        self._working = False
        self._told = 0.0
        self._last: tuple[float, int] = (0.0, 0)
        self.latest: Progress | None = None
        """Where the search of the present work is; None if it has not told."""
        self._lock = threading.RLock()

    def begin(self, what: str) -> None:
        """Some work starts; *what* it is."""
        with self._lock:
            self._what = " ".join(harmless(what).split())
            self._doing = doing()
            self._start = self._told = self._clock()
            self._next = self._start + (FIRST if self._live else LINE_INTERVAL)
            self._last = (self._start, 0)
            self.latest = None
            self._working = True

    def progress(self, progress: Progress) -> None:
        """Show where the search is, if it is time to."""
        self.latest = progress
        self._poll()
        with self._lock:
            now = self._told = self._clock()
            if now >= self._next:
                self._show(self._numbers(progress, now), now)

    def beat(self) -> None:
        """Show how long the work has been going on, if it is time to and nothing else is known of it."""
        with self._lock:
            now = self._clock()
            if self._working and now >= self._next and now - self._told >= STALE:
                self._show(f"{now - self._start:.0f} s{self._inside(now)}", now)

    def _inside(self, now: float) -> str:
        """What is going on inside the work, once it has been going on for long."""
        if now - self._start < LONG or not self._doing:
            return ""
        looked, said = self._said
        if now - looked >= LOOK_INTERVAL or looked < self._start:
            try:
                said = ", " + harmless(told(self._doing[-1]))
            except Exception:  # it is another thread's, and just now something else
                said = ""
            self._said = (now, said)
        return said

    def notify(self, line: str) -> None:
        """Say something once."""
        with self._lock:
            if not self._quiet:
                self.erase()
                self._write(harmless(line) + "\n")

    def done(self) -> None:
        """The work has ended."""
        with self._lock:
            self._working = False
            self.erase()

    def erase(self) -> None:
        """Take the live line away."""
        with self._lock:
            if self._shown:
                self._write(_ERASE)
                self._shown = False

    def _show(self, numbers: str, now: float) -> None:
        if self._quiet:
            return
        self._next = now + (LIVE_INTERVAL if self._live else LINE_INTERVAL)
        room = self._style.width - 3 - len(numbers) if self._live else 200
        what = self._style.fit(self._what, room) if room >= 12 else ""
        text = f"{what}: {numbers}" if what else numbers
        if self._live:
            self._write(_ERASE + self._style.paint(self._style.fit(text, self._style.width - 1), "dim"))
            self._shown = True
        else:
            self._write(text + "\n")

    def _numbers(self, progress: Progress, now: float) -> str:
        before, states = self._last
        rate = (progress.states - states) / (now - before) if now > before and progress.states >= states else 0.0
        self._last = (now, progress.states)
        parts = [
            f"{progress.states:,} states",
            f"{_short(rate)} states/s",
            f"depth {progress.depth:,}",
            f"frontier {progress.frontier:,}",
            show_bytes(progress.memory_bytes),
            f"{now - self._start:.0f} s",
        ]
        return ", ".join(parts)


class Heartbeat:
    """While this is entered, something is done several times a second, in a thread of its own."""

    def __init__(self, beat: Callable[[], None]) -> None:
        self._beat = beat
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True, name="progress")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._end.wait(LIVE_INTERVAL):
            self._beat()


def _short(number: float) -> str:
    for limit, unit in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if number >= limit:
            return f"{number / limit:.1f}{unit}"
    return f"{number:.0f}"
