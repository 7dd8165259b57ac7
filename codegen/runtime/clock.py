"""Clocks: what time it is, in seconds since the program's start.

A monotonic clock is that of the machine. A virtual clock stands still while anything can happen and jumps to the
next release when nothing can, so an hour of a program takes as long as its events take to compute, and every run
is the same.
"""

from __future__ import annotations

import time


class MonotonicClock:
    """The machine's clock; setting the time of day does not change it."""

    virtual = False

    def __init__(self) -> None:
        self._start = time.monotonic()

    def start(self) -> None:
        """Begin at zero."""
        self._start = time.monotonic()

    def now(self) -> float:
        """Seconds since the start."""
        return time.monotonic() - self._start


class VirtualClock:
    """Time that passes only when every task waits."""

    virtual = True

    def __init__(self) -> None:
        self._now = 0.0

    def start(self) -> None:
        """Begin at zero."""
        self._now = 0.0

    def now(self) -> float:
        """Seconds since the start."""
        return self._now

    def advance(self, to: float) -> None:
        """Jump to a later time."""
        self._now = max(self._now, to)


Clock = MonotonicClock | VirtualClock
