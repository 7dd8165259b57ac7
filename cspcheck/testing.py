"""Tests from specifications: follow a program while it runs, draw traces, drive an implementation through choices.

>>> script = cspcheck.load("buffer.csp")
>>> follower = cspcheck.testing.follow(script, "SYSTEM")     # a recorder: stops the program where it departs
>>> Program(tasks()).run("loop", recorder=follower, events=10_000)

>>> @given(cspcheck.testing.traces(script, "SPEC"))          # Hypothesis: lists of events that SPEC can perform
... def test_replay(trace): ...

>>> TestBuffer = cspcheck.testing.machine(script, "SPEC", MyBuffer, outputs={"right": 0}).TestCase

:func:`traces` and :func:`machine` need Hypothesis (``pip install 'cspcheck[testing]'``); nothing here imports it before
it is used.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Protocol

from cspcheck.cspm.process.events import TICK
from cspcheck.following import Departure, Follower

if TYPE_CHECKING:
    from hypothesis.stateful import RuleBasedStateMachine
    from hypothesis.strategies import SearchStrategy

    from cspcheck.api import Script


class Recorded(Protocol):
    """What the runtime of a program says of an event; every program has a runtime of its own."""

    @property
    def event(self) -> str:
        """The event as the script writes it."""

    @property
    def hidden(self) -> bool:
        """Whether it is hidden."""

    @property
    def inner(self) -> bool:
        """Whether a part of the composition hides it, not the whole."""

    @property
    def terminated(self) -> bool:
        """Whether it is successful termination, whatever events are called."""


class Departed(AssertionError):
    """A run has left its specification; ``departure`` says where and why."""

    def __init__(self, process: str, departure: Departure) -> None:
        self.departure = departure
        super().__init__(f"the run leaves `{process}`\n{departure.explain()}")


class Refused(Exception):
    """To be raised by an implementation under test that does not accept an event now."""


class _Following:
    """A recorder of a running program that follows a process. Create with :func:`follow`."""

    def __init__(self, follower: Follower, process: str) -> None:
        self._follower = follower
        self._process = process
        self.events = 0
        """How many events have been followed."""

    def record(self, record: Recorded) -> None:
        """Follow an event.

        Raises:
            Departed: the process does not allow it.
        """
        if not self._follower.follows(record.event, record.hidden, record.inner):
            return
        departure = self._follower.step(record.event, terminated=record.terminated)
        if departure is not None:
            raise Departed(self._process, departure)
        self.events += 1

    def close(self) -> None:
        """Be ready for another run, from the beginning of the process."""
        self._follower.restart()


def follow(script: Script, process: str, *, inside: bool = False) -> _Following:
    """A recorder for a program that stops it at the first event that *process* does not allow.

    Args:
        script: a loaded script.
        process: text of a process of it.
        inside: follow hidden events too: the process is taken without its outermost hiding.

    Raises:
        ScriptError: the text is no process of the script.
    """
    return _Following(_follower(script, process, inside), process)


def traces(script: Script, process: str, *, max_length: int = 30) -> SearchStrategy[list[str]]:
    """A Hypothesis strategy for traces of a process: lists of events as the script writes them.

    Shrinks towards short traces, and towards events that are declared first.

    Raises:
        ImportError: Hypothesis is not installed.
        ScriptError: the text is no process of the script.
    """
    st = _hypothesis("strategies")
    follower = _follower(script, process, False)

    @st.composite  # type: ignore[untyped-decorator]
    def trace(draw: Callable[[Any], Any]) -> list[str]:
        follower.restart()
        events: list[str] = []
        while len(events) < max_length:
            allowed = follower.allowed()
            # "stop" is the simplest choice, so shrinking ends traces early.
            if not allowed or not draw(st.integers(0, max_length)):
                break
            event = draw(st.sampled_from(allowed))
            follower.step(event)
            events.append(event)
            if event == script._script.events.tick:
                break
        return events

    strategy: SearchStrategy[list[str]] = trace()
    return strategy


def machine(
    script: Script,
    process: str,
    implementation: Callable[[], Any],
    *,
    outputs: Mapping[str, int] | None = None,
) -> type[RuleBasedStateMachine]:
    """A Hypothesis state machine that drives an implementation through what a process allows.

    For each run ``implementation()`` makes a new one. An event ``c.1.2`` is performed by calling its method
    ``c(1, 2)``, which may raise :class:`Refused`. For a channel in *outputs* the implementation decides: the method is
    called with so many of the first fields and returns the rest, a value or a tuple of several, which must be allowed.

    Failures say what was done, what came of it and what was allowed: a value that the specification does not allow; a
    refusal of what it always accepts. Where the specification may refuse an event too, a refusal is in order.

    Values are as :meth:`cspcheck.Script.evaluate` gives them: constants of datatypes are their names.

    Raises:
        ImportError: Hypothesis is not installed.
        ScriptError: the text is no process of the script.
        ValueError: a channel in *outputs* is none of the script.
    """
    stateful, st = _hypothesis("stateful"), _hypothesis("strategies")
    follower = _follower(script, process, False)
    deciding = dict(outputs or {})
    unknown = deciding.keys() - {channel.name for channel in script._script.events.channels}
    if unknown:
        raise ValueError(f"no channels of the script: {', '.join(sorted(unknown))}")

    class Conformance(stateful.RuleBasedStateMachine):  # type: ignore[misc, name-defined]
        """Does what the specification allows, one event after the other."""

        def __init__(self) -> None:
            super().__init__()
            follower.restart()
            self.subject = implementation()
            self.done: list[str] = []

        @stateful.precondition(lambda self: bool(self.calls()))  # type: ignore[untyped-decorator]
        @stateful.rule(data=st.data())  # type: ignore[untyped-decorator]
        def step(self, data: Any) -> None:
            calls = self.calls()
            call = data.draw(st.sampled_from(list(calls)), label="call")
            self.perform(call, calls[call])

        def calls(self) -> dict[tuple[str, tuple[Any, ...]], dict[tuple[Any, ...], str]]:
            return _calls(script, follower, deciding)

        def perform(self, call: tuple[str, tuple[Any, ...]], events: Mapping[tuple[Any, ...], str]) -> None:
            channel, given = call
            try:
                result = getattr(self.subject, channel)(*given)
            except Refused:
                for event in events.values():
                    if all(event in offer for offer in follower.offers()) and follower.offers():
                        self.fail(f"it refuses `{event}`, which `{process}` always accepts there")
                return
            rest: tuple[Any, ...] = ()
            if channel in deciding:
                missing = {len(values) for values in events}
                rest = tuple(result) if missing != {1} else (result,)
            performed = events.get(rest)
            if performed is None:
                shown = ".".join([channel, *map(str, (*given, *rest))])
                self.fail(f"it performs `{shown}`, which `{process}` does not allow there")
                return
            follower.step(performed)
            self.done.append(performed)

        def fail(self, why: str) -> None:
            before = f"<{', '.join(self.done)}>"
            raise AssertionError(f"after {before}: {why}; allowed are {', '.join(follower.allowed())}")

    Conformance.__name__ = Conformance.__qualname__ = "Conformance"
    return Conformance


def _calls(
    script: Script, follower: Follower, deciding: Mapping[str, int]
) -> dict[tuple[str, tuple[Any, ...]], dict[tuple[Any, ...], str]]:
    """The calls that can be made now, each with the values that it may give, and the event that happens then."""
    table = script._script.events
    calls: dict[tuple[str, tuple[Any, ...]], dict[tuple[Any, ...], str]] = {}
    for number in follower.allowed_numbers():
        if number == TICK:
            continue
        channel, fields = table.parts(number)
        values = tuple(script._script.plain(field) for field in fields)
        count = deciding.get(channel.name, len(values))
        calls.setdefault((channel.name, values[:count]), {})[values[count:]] = table.name(number)
    return calls


def _follower(script: Script, process: str, inside: bool) -> Follower:
    return Follower(script._script, script._script.process(process), hidden=inside)


def _hypothesis(module: str) -> Any:
    from importlib import import_module

    try:
        import_module("hypothesis")
        return import_module(f"hypothesis.{module}")
    except ModuleNotFoundError as missing:
        if missing.name != "hypothesis":
            raise
        raise ImportError("this needs Hypothesis: pip install 'cspcheck[testing]'") from None
