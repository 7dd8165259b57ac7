"""Whether several threads are worth their while: found out by doing both, since nothing else tells.

Threads gain nothing where levels are narrow, where tables still fit a cache, or where the processors have other work to
do; what a search does next is not known before. So it is tried for a few rounds, once enough has been found, held
against what one thread did shortly before, and given up for a while where it gains nothing; each time for longer. Now
and then a run is done by one thread in between, so that both numbers stay up to date. What is found does not depend on
any of that.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from statistics import median

GAIN = 1.05
"""Threads go on together while they do more than this many times what one does."""
TRIAL = 3
"""Rounds after which it is first seen whether they do."""
COMPARED = 48
"""Rounds after which one thread does a run in between."""
PAUSE = 0.25
"""Seconds for which one thread goes on after the first trial that gained nothing; each later time twice as many."""
LONGEST_PAUSE = 64.0
TOLD = 1_000
"""Runs with fewer transitions say nothing."""


class Pace:
    """What one thread and what several get done, and which of the two is to do the next run."""

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self.clock = clock
        self._alone: deque[float] = deque(maxlen=3)
        self._together: deque[float] = deque(maxlen=5)
        self._rounds = 0
        self._pause = PAUSE
        self._until = 0.0
        self._in_between = False

    @property
    def is_for_all(self) -> bool:
        """Whether the next run is one for all threads."""
        return len(self._alone) > 2 and not self._in_between and self.clock() >= self._until

    def note(self, transitions: int, seconds: float, *, together: bool) -> None:
        """Take note of a run."""
        if transitions < TOLD or seconds <= 0:
            return
        rates = self._together if together else self._alone
        rates.append(transitions / seconds)
        if not together:
            self._in_between = False
            return
        self._rounds += 1
        if self._rounds % TRIAL == 0 and self._alone and median(self._together) < GAIN * median(self._alone):
            self._until = self.clock() + self._pause
            self._pause = min(2 * self._pause, LONGEST_PAUSE)
            self._together.clear()
            self._alone.clear()
            self._rounds = 0
        elif self._rounds % COMPARED == 0:
            self._in_between = True
