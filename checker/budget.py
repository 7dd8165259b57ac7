"""What one assertion may still use, what it has used, and how a search that had to end early is described."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

from cspcheck.checker.guard import Guard, process_memory, working_time
from cspcheck.checker.verdict import Counterexample, Limits, Outcome, Verdict
from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.interruption import Stopped, doing, told


class Covered(Protocol):
    """What is said of an exploration that ran into a limit: the limit, and the depth and states that it got to."""

    @property
    def stop(self) -> str | None:
        """The limit that ended it: ``states``, ``seconds``, ``memory``; None if none did."""

    @property
    def depth(self) -> int:
        """The last depth, in visible events, whose states were all met."""

    @property
    def levels(self) -> Sequence[int]:
        """How many states there were up to each depth."""


class Incomplete(Exception):
    """A machine that a check needs as a whole could not be explored to its end; the message says what was covered.

    Attributes:
        states, transitions: what was covered.
        endless: whether a component has too many states to be explored by itself, so that no search has begun.
    """

    def __init__(self, reason: str, states: int = 0, transitions: int = 0, *, endless: bool = False) -> None:
        super().__init__(reason)
        self.reason = reason
        self.endless = endless
        self.states = states
        self.transitions = transitions


class Budget:
    """The limits of one assertion, whose clock starts when this is made.

    Attributes:
        limits: as given.
        peak_memory_bytes: the most that :meth:`used` has been told.
    """

    __slots__ = ("_started", "limits", "peak_memory_bytes")

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.peak_memory_bytes = 0
        self._started = working_time()

    @property
    def seconds(self) -> float:
        """Time since the start."""
        return working_time() - self._started

    def remaining(self) -> Limits:
        """What is left for a search: the time, and the memory that nothing else in this process has.

        How many bytes others have is found out now, and taken to stay: while a search goes on nothing else grows.
        """
        left = self.limits
        if left.seconds is not None:
            left = replace(left, seconds=max(0.0, left.seconds - self.seconds))
        if left.memory_bytes is not None:
            left = replace(left, memory_bytes=max(1, left.memory_bytes - (process_memory() or 0)))
        return left

    def narrowed(self, states: int) -> Budget:
        """A budget of its own for something optional: what is left of this one, and no more than so many states."""
        most = states if self.limits.states is None else min(states, self.limits.states)
        # Its clock is that of this one, and so is what it says when the time is over.
        narrower = Budget(replace(self.limits, states=most))
        narrower._started = self._started
        return narrower

    def used(self, memory_bytes: int) -> None:
        """Take note of the size of arrays that were in use at one time."""
        self.peak_memory_bytes = max(self.peak_memory_bytes, memory_bytes)

    def outcome(
        self,
        verdict: Verdict,
        reason: str | None,
        states: int,
        transitions: int,
        counterexample: Counterexample | None = None,
    ) -> Outcome:
        """The answer, with the time and the memory that it took."""
        return Outcome(verdict, reason, states, transitions, self.seconds, self.peak_memory_bytes, counterexample)

    def is_over(self) -> bool:
        """Whether there is no time left."""
        return self.limits.seconds is not None and self.seconds >= self.limits.seconds

    def check_time(self, what: str = "") -> None:
        """Give up when the time is over.

        Args:
            what: what is going on (``normalising the specification``), if nobody has said (``during``).

        Raises:
            Incomplete: it is.
        """
        if self.is_over():
            said = doing()
            raise Incomplete(f"{_reached('seconds', self.limits)} while {told(said[-1]) if said else what}")

    def shortfall(self, exploration: Covered, nothing: str) -> str:
        """Why an exploration without a result is no proof, and what it covered.

        Args:
            exploration: one that ran into a limit.
            nothing: what would have been a result (``deadlock``); empty if it was not looked for yet.
        """
        among = f", no {nothing} among them" if nothing and exploration.levels[-1] else ""
        return f"{self.reached(exploration)}: {coverage(exploration)}{among}"

    def too_many_terms(self, limit: LimitReached) -> str:
        """What to say when a component is too large to be explored by itself."""
        of_states = self.limits.states is not None and limit.states >= self.limits.states
        if self.limits.memory_bytes is None or of_states:
            return f"{limit.diagnostic.message}; `--max-states` raises the limit"
        return f"{self.memory_reached()}: {limit.diagnostic.message}"

    def memory_reached(self) -> str:
        """``memory limit of 8 GiB (`--max-memory`) reached``."""
        return _reached("memory", self.limits)

    def reached(self, exploration: Covered) -> str:
        """The limit that ended an exploration: ``state limit of 1,000 (`--max-states`) reached``."""
        return _reached(exploration.stop, self.limits)


def coverage(exploration: Covered) -> str:
    """``1,000 states explored to depth 7``; depth counts visible events."""
    states = int(exploration.levels[-1])
    if states == 0:
        # How many states of the unfinished depth were met may depend on how the work was shared out.
        return "not even depth 0 was completed"
    noun = "state" if states == 1 else "states"
    return f"{states:,} {noun} explored to depth {exploration.depth}"


NO_ROOM = "no room left on the disk of `--spill`"
"""The reason of a verdict where a search on disk had nowhere to go on."""

OUT_OF_MEMORY = "out of memory"
"""The reason of a verdict where the system had no more memory to give."""


def why(guard: Guard, limits: Limits, stopped: Stopped) -> str:
    """What to say of work that a guard stopped: the limit, the option that sets it, and what was going on.

    ``time limit of 2 s (`--timeout`) reached while evaluating `fib(45)` ``.
    """
    going_on = f" while {_going_on(stopped)}" if stopped.doing or stopped.outermost is not None else ""
    if guard.reached == "machine":
        return f"{OUT_OF_MEMORY}: the machine has next to none left{going_on}"
    return f"{_reached(guard.reached, limits)}{going_on}"


def _going_on(stopped: Stopped) -> str:
    if stopped.doing:
        return stopped.doing[0]
    assert stopped.outermost is not None
    outermost = stopped.outermost()
    inside = f", in the call `{stopped.innermost}`" if stopped.innermost != outermost else ""
    return f"evaluating `{outermost}`{inside}"


def _reached(stop: str | None, limits: Limits) -> str:
    if stop == "states":
        return f"state limit of {limits.states:,} (`--max-states`) reached"
    if stop == "seconds":
        return f"time limit of {limits.seconds:g} s (`--timeout`) reached"
    if stop == "disk":
        return NO_ROOM
    if stop == "memory":
        return f"memory limit of {_bytes(limits.memory_bytes or 0)} (`--max-memory`) reached"
    raise AssertionError(f"a search without a result ended for the reason {stop}")


def _bytes(number: int) -> str:
    """``8 GiB``."""
    size = float(number)
    for unit in ("bytes", "KiB", "MiB", "GiB"):
        if size < 1024 or unit == "GiB":
            break
        size /= 1024
    return f"{size:g} {unit}" if size == int(size) else f"{size:.1f} {unit}"


class LimitReached(Exception):
    """There are more states than the limit allows; the verdict of what depends on it is ``unknown``.

    Attributes:
        diagnostic: CSP503 to CSP505: which definition, and what grows.
        states: how many states were found.
    """

    def __init__(self, diagnostic: Diagnostic, states: int) -> None:
        self.diagnostic = diagnostic
        self.states = states
        super().__init__(diagnostic.message)
