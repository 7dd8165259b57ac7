"""The built-in processes and functions on processes, and ``Events``: what depends on the script's channels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cspcheck.cspm.evaluator.builtins import Builtin
from cspcheck.cspm.evaluator.builtins_data import DATA, as_pair, as_sequence, as_set
from cspcheck.cspm.prelude import DEPRECATED_IMPORTS, TRANSPARENT
from cspcheck.cspm.process import terms as process
from cspcheck.cspm.process.definitions import Definition
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.dots import Channels, Event, is_incomplete
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.sets import EventsSet, Set, event_set
from cspcheck.cspm.values.symbolic_sets import AllEvents
from cspcheck.cspm.values.thunks import force

_LIKE_CHASE = ("chase", "chase_nocache")


def builtins_for(channels: Channels) -> dict[str, Any]:
    """All built-in values and functions by name; ``Events`` is a Python function of no arguments."""
    found: dict[str, Any] = dict(DATA)
    found.update(STOP=process.STOP, SKIP=process.SKIP, DIV=process.DIV)

    def add(name: str, kinds: str, call: Callable[..., Any]) -> None:
        found[name] = Builtin(name, kinds, call)

    add("CHAOS", "v", lambda events: process.Chaos(event_set(events)))
    add("RUN", "v", _run)
    for name in sorted(TRANSPARENT):
        add(name, "p", _chase(name) if name in _LIKE_CHASE else _compression(name))
    for name in ("prioritise", "prioritise_nocache"):
        add(name, "pv", prioritise)
    add("prioritisepo", "pvvv", _prioritisepo)
    add("deter", "p", lambda p: process.External("deter", p, ()))
    add("loop", "p", _loop)
    for name in ("failure_watchdog", "trace_watchdog"):
        add(name, "pvv", _watchdog(name))
    add("BUFFER", "vv", lambda n, pairs: _buffer("BUFFER", n, (), pairs))
    add("WEAK_BUFFER", "vvv", lambda n, explode, pairs: _buffer("WEAK_BUFFER", n, (explode,), pairs))
    add("SIGNAL_BUFFER", "vvvv", lambda n, full, empty, pairs: _buffer("SIGNAL_BUFFER", n, (full, empty), pairs))
    found["Events"] = lambda: all_events(channels)
    return found


def all_events(channels: Channels) -> Set:
    """``Events``; where a channel has an infinite field, a set that can only be tested.

    Raises:
        Failure: the events of some channel cannot be told.
    """
    if channels.broken:
        raise Failure(channels.broken[0].diagnostic)
    if any(channel.size is None for channel in channels.table.channels):
        return AllEvents()
    return EventsSet.of(channels.table.all_events(), channels)


def as_event(value: Any) -> Event:
    """*value*, which must be a complete event.

    Raises:
        Failure: it is something else.
    """
    value = force(value)
    if type(value) is Event:
        return value
    if is_incomplete(value) and value.head.is_channel:
        raise Failure(messages.incomplete_event(value, None))
    raise Failure(messages.wrong_kind("an event", value))


def _number(value: Any) -> int:
    if type(value) is int:
        return value
    raise Failure(messages.wrong_kind("a number", value))


def _run(events: Any) -> Process:
    found = event_set(events)
    return process.Run(found) if found else process.STOP


def _compression(name: str) -> Callable[[Process], Process]:
    called = DEPRECATED_IMPORTS.get(name, name)
    return lambda p: process.Compressed(called, p)


def _chase(name: str) -> Callable[[Process], Process]:
    return lambda p: process.External(name, p, ())


def _watchdog(name: str) -> Callable[[Process, Any, Any], Process]:
    return lambda p, alphabet, bark: process.External(name, p, (event_set(alphabet), as_event(bark).number))


def _loop(p: Process) -> Process:
    """``loop(P) = P ; loop(P)``."""

    def unfold() -> Process:
        return process.Sequential(p, again)

    def text() -> str:
        from cspcheck.cspm.values.text import show_short

        return f"loop({show_short(p)})"

    again = process.Reference(("loop", p), Definition(text, None, unfold))
    return again


def prioritise(p: Process, levels: Any) -> Process:
    """``prioritise(P, <A0, A1, ...>)``."""
    found = tuple([event_set(level) for level in as_sequence(levels).values()])
    if not found:
        raise Failure(messages.no_priorities())
    return process.Prioritised(p, found)


def _prioritisepo(p: Process, prioritised: Any, order: Any, maximal: Any) -> Process:
    """The order is closed transitively and checked; its pairs are (higher, lower)."""
    events = event_set(prioritised)
    top = event_set(maximal)
    below: dict[int, set[int]] = {}
    by_number: dict[int, Event] = {}
    for pair in as_set(order).elements():
        high, low = (as_event(event) for event in as_pair(pair))
        for event in (high, low):
            if event.number not in events:
                raise Failure(messages.not_prioritised(event))
            by_number[event.number] = event
        below.setdefault(high.number, set()).add(low.number)
    closed: set[tuple[int, int]] = set()
    for start, lower in below.items():
        reached: dict[int, int] = {}
        stack = [(number, start) for number in sorted(lower)]
        while stack:
            number, before = stack.pop()
            if number in reached:
                continue
            reached[number] = before
            if number == start:
                cycle = [start]
                while len(cycle) == 1 or cycle[-1] != start:
                    cycle.append(reached[cycle[-1]])
                raise Failure(messages.cyclic_priorities([by_number[n] for n in reversed(cycle)]))
            stack.extend((next_number, number) for next_number in sorted(below.get(number, ())))
        closed.update((start, number) for number in reached)
    for above, beneath in sorted(closed):
        if beneath in top:
            raise Failure(messages.not_maximal(by_number[beneath], by_number[above]))
    return process.External("prioritisepo", p, (events, tuple(sorted(closed)), top))


def _buffer(kind: process.BufferKind, capacity: Any, signals: tuple[Any, ...], pairs: Any) -> Process:
    size = _number(capacity)
    if size < 1:
        raise Failure(messages.buffer_capacity(kind, size))
    used: set[int] = set()

    def use(value: Any) -> int:
        event = as_event(value)
        if event.number in used:
            raise Failure(messages.buffer_event_twice(kind, event))
        used.add(event.number)
        return event.number

    signal_numbers = tuple([use(signal) for signal in signals])
    found: list[tuple[int, int]] = []
    for pair in as_set(pairs).elements():
        source, target = as_pair(pair)
        found.append((use(source), use(target)))
    return process.Buffer(kind, size, signal_numbers, tuple(sorted(found)), ())
