"""How far a search is, on standard error: one live line on a terminal, a line every ten seconds elsewhere."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from cspcheck.quantities import show_bytes
from cspcheck.report.style import Style, harmless

if TYPE_CHECKING:
    from checker.search import Progress

FIRST = 1.0
"""Seconds before anything is shown."""
LIVE_INTERVAL = 0.2
"""Seconds between two states of the live line."""
LINE_INTERVAL = 10.0
"""Seconds between two lines where there is no terminal."""
_ERASE = "\r\x1b[K"


class ProgressLine:
    """The progress of one check after the other.

    Everything else that is written while a check runs has to be written between two calls of :meth:`done` and
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
        self._start = self._next = 0.0
        self._shown = False
        self._last: tuple[float, int] = (0.0, 0)

    def begin(self, what: str) -> None:
        """A check starts; *what* is its assertion."""
        self._what = " ".join(harmless(what).split())
        self._start = self._clock()
        self._next = self._start + (FIRST if self._live else LINE_INTERVAL)
        self._last = (self._start, 0)

    def progress(self, progress: Progress) -> None:
        """Show where the search is, if it is time to."""
        self._poll()
        now = self._clock()
        if self._quiet or now < self._next:
            return
        self._next = now + (LIVE_INTERVAL if self._live else LINE_INTERVAL)
        text = self._text(progress, now)
        if self._live:
            self._write(_ERASE + self._style.paint(self._style.fit(text, self._style.width - 1), "dim"))
            self._shown = True
        else:
            self._write(text + "\n")

    def notify(self, line: str) -> None:
        """Say something once."""
        if not self._quiet:
            self.erase()
            self._write(harmless(line) + "\n")

    def done(self) -> None:
        """The check has ended."""
        self.erase()

    def erase(self) -> None:
        """Take the live line away."""
        if self._shown:
            self._write(_ERASE)
            self._shown = False

    def _text(self, progress: Progress, now: float) -> str:
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
        numbers = ", ".join(parts)
        room = self._style.width - 3 - len(numbers) if self._live else 200
        what = self._style.fit(self._what, room) if room >= 12 else ""
        return f"{what}: {numbers}" if what else numbers


def _short(number: float) -> str:
    for limit, unit in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if number >= limit:
            return f"{number / limit:.1f}{unit}"
    return f"{number:.0f}"
