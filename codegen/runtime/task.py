"""Tasks: the processes of a program.

A task's :meth:`Task.run` is written once, as a coroutine; whether a thread or an event loop carries it is decided when
the program is run. Nothing but the methods of this class may be awaited in it.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Coroutine, Generator, Sequence
from dataclasses import dataclass
from types import coroutine
from typing import TYPE_CHECKING, Any, Final

from .alternation import Choice
from .channel import ANY, Offer, OneOf, Undecided, Values

if TYPE_CHECKING:
    from .run import Run


class Stopped(BaseException):
    """The program is being shut down. Raised where a task waits; tasks may clean up and must let it pass.

    Not an ``Exception``, so that a task that catches its own errors does not catch this one.
    """


class WrongMethods(Exception):
    """Methods written by hand that do not fit their task: the specification has changed since."""

    def __init__(self, task: str, file: str, problems: Sequence[str]) -> None:
        self.problems = tuple(problems)
        super().__init__(
            "\n".join(
                [
                    f"{task}: its methods in {file} do not fit the specification any more",
                    *[f"  {problem}" for problem in problems],
                    "  change them there; `cspcheck gen` shows how they should look",
                ]
            )
        )


@coroutine
def _wait(offers: tuple[Offer | None, ...]) -> Generator[tuple[Offer | None, ...], Choice, Choice]:
    """Hand a selection to whoever carries the task, and get the choice."""
    return (yield offers)


@dataclass(frozen=True, slots=True)
class Next:
    """The state with which a task goes on."""

    state: State
    values: tuple[Any, ...]


State = Callable[..., Coroutine[Any, Any, Next | None]]
"""A named process of a task: does some things and says what comes next; None when it has come to its end."""


def go(state: State, *values: Any) -> Next:
    """Go on with a state: the last thing that a state does."""
    return Next(state, values)


class Task:
    """A process.

    Args:
        name: what records and messages call it, and what channels know it by.
        priority: of several possible events that of the most urgent task happens first; higher is more urgent.
        period: seconds between releases, for a periodic task.
        offset: the time of its first release.
    """

    def __init__(self, name: str, *, priority: int = 0, period: float | None = None, offset: float = 0.0) -> None:
        if period is not None and period <= 0:
            raise ValueError(f"the period of {name} must be above zero, not {period}")
        self.name: Final = name
        self.priority = priority
        self.period = period
        self.offset = offset
        self.releases = 0
        """How many releases there have been."""
        self.missed = 0
        """How many releases did not happen before the next one was due: too late, or left out."""
        self._next = 0
        self._run: Run | None = None

    def run(self) -> Coroutine[Any, Any, None]:
        """What the task does, from beginning to end. Subclasses write it as ``async def run(self) -> None``."""
        raise NotImplementedError

    # --- what a task can do ----------------------------------------------------------------------------------

    async def select(self, *offers: Offer | None) -> Choice:
        """Wait until one of the *offers* is taken: external choice.

        None stands for an offer whose guard is false. Without any offer the task has stopped for ever.
        """
        choice = await _wait(offers)
        offer = offers[choice.taken]
        if offer is None or offer.body is None:
            return choice
        return Choice(choice.taken, self._call(offer))

    async def perform(self, offer: Offer) -> Values:
        """Wait until the only *offer* is taken; the values of the event."""
        choice = await _wait((offer,))
        return choice.values if offer.body is None else self._call(offer)

    async def follow(self, state: State, *values: Any) -> None:
        """``P(values)``, where P is a state that says what comes next, until something comes to its end (``SKIP``)."""
        step: Next | None = Next(state, values)
        while step is not None:
            step = await step.state(*step.values)

    async def stop(self) -> None:
        """``STOP``: never go on."""
        await _wait(())

    def decide(self, ways: int) -> int:
        """``P |~| Q``: a number below *ways*, as the program's policy has it."""
        return self.carrier.decide(self.name, ways)

    # --- periodic tasks --------------------------------------------------------------------------------------

    @property
    def release(self) -> float:
        """When the task's next release is due: ``offset + n * period``, never a time computed from another."""
        assert self.period is not None, f"{self.name} is not periodic"
        return self.offset + self._next * self.period

    def released(self) -> None:
        """Count a release that has just happened.

        Releases whose whole period has passed meanwhile are left out: the task goes on with one that is due, where it
        was due from the beginning, and never hurries after what is lost.
        """
        assert self.period is not None
        behind = int((self.carrier.clock.now() - self.release) / self.period + 1e-9)
        self.releases += 1
        self.missed += behind
        self._next += max(1, behind)

    # --- what carries it -------------------------------------------------------------------------------------

    @property
    def carrier(self) -> Run:
        """The run that the task is part of."""
        assert self._run is not None, f"{self.name} is not running"
        return self._run

    def begin(self, run: Run) -> None:
        """Become part of a run.

        Raises:
            WrongMethods: methods written by hand do not have the parameters that they will be called with.
        """
        methods = getattr(self, "methods", None)
        if methods is not None:
            check_methods(self.name, methods)
        self._run = run
        self.releases = self.missed = self._next = 0

    def _call(self, offer: Offer) -> Values:
        """Call the body of an offer that was taken, and have the event recorded."""
        assert offer.body is not None
        given = [field for field in offer.fields if field is not ANY and type(field) is not OneOf]
        result = offer.body(*given)
        if isinstance(result, Undecided):
            result = self.carrier.decided(self.name, offer)
            if len(offer.fields) - len(given) == 1:
                (result,) = result
        missing = len(offer.fields) - len(given)
        rest = iter(result if missing > 1 else (result,))
        values = tuple(next(rest) if field is ANY or type(field) is OneOf else field for field in offer.fields)
        self.carrier.done(self.name, offer, values)
        return values


def check_methods(task: str, methods: object) -> None:
    """Make sure that methods written by hand can be called as those of the class that they are derived from.

    Raises:
        WrongMethods: one has other parameters, or there is one that nothing calls.
    """
    written = type(methods)
    (wanted, *_) = written.__bases__
    if wanted is object:
        return
    problems = []
    for name, method in vars(written).items():
        if name.startswith("_") or not inspect.isfunction(method):
            continue
        original = getattr(wanted, name, None)
        if original is None:
            problems.append(f"`{name}` is no method of it any more")
        elif [*inspect.signature(method).parameters] != [*inspect.signature(original).parameters]:
            problems.append(f"`{name}{_parameters(method)}` is written, and should be `{name}{_parameters(original)}`")
    if problems:
        file = inspect.getsourcefile(written) or written.__module__
        raise WrongMethods(task, file.replace("\\", "/").rpartition("/")[2], problems)


def _parameters(method: Callable[..., Any]) -> str:
    return f"({', '.join(inspect.signature(method).parameters)})"
