"""Following a run event by event: is it a trace of a process, and if not, where does it leave it?

The states in which the process can be after a trace are a set, closed under what it can do unseen. Sets that were
met before are known by number, with what each event makes of them, so a long run through a finite process costs a
look into a table for each event. Of what is composed only the event at hand is worked out, and what is known is
forgotten from time to time, so that a run that never meets the same states again takes no more memory.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from cspcheck.checker.semantics.directed import Directed
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.process.events import TAU, TICK, EventSet, EventTable
from cspcheck.cspm.process.terms import Hide, Parallel, Process, Reference
from cspcheck.cspm.process.text import describe
from cspcheck.report.style import harmless

if TYPE_CHECKING:
    from cspcheck.cspm.script import Script

MOST_STATES = 100_000
"""The process may be in so many states at a time."""
MOST_SETS = 20_000
"""So many sets of states are known at a time."""


@dataclass(frozen=True, slots=True)
class Departure:
    """Where a run leaves a process.

    Attributes:
        position: which event of the run, from 0, hidden ones included.
        event: the event that is not allowed.
        why: in a few words.
        allowed: the events that were, in the order of declaration.
        before: the last events that were followed, oldest first.
        states: what the process was there, as text; some of them.
    """

    position: int
    event: str
    why: str
    allowed: tuple[str, ...]
    before: tuple[str, ...]
    states: tuple[str, ...]

    def explain(self) -> str:
        """The departure in some lines. What comes from the recorded run does nothing to who reads them."""
        allowed = ", ".join(self.allowed) if self.allowed else "nothing"
        lines = [
            f"event {self.position + 1} of the run, `{self.event}`, is not allowed there: {self.why}",
            f"  before it   {' -> '.join(self.before) if self.before else 'nothing: it is the first'}",
            f"  allowed     {allowed}",
        ]
        for i, state in enumerate(self.states):
            lines.append(f"  {'in the state' if i == 0 else '          or'} {state}")
        return "\n".join(map(harmless, lines))


class TooManyStates(Exception):
    """A process can be in more states at a time than are followed."""


class Follower:
    """The states in which a process can be after what it has performed.

    Args:
        script: the script that events are read against.
        process: the process.
        hidden: whether the events of the outermost hiding are followed too: the process is then taken without it.
    """

    def __init__(self, script: Script, process: Process, *, hidden: bool = False) -> None:
        self.script = script
        self.hidden = hidden
        self.followed = 0
        """How many events have been followed."""
        self._forgot = False
        """Whether there have been states that are not known any more."""
        self._events: dict[str, int | None] = {script.events.tick: TICK}
        self._hidden_events: EventSet | None = None
        if hidden:
            process, self._hidden_events = shown(process, script.events)
        self._process = process
        self._forget()
        self._now = self._number([process])
        self._recent: list[str] = []

    def restart(self) -> None:
        """Go back to the beginning."""
        self._now = self._number([self._process])
        self.followed = 0
        self._recent.clear()

    def follows(self, event: str, hidden: bool, inner: bool = False) -> bool:
        """Whether an event is to be followed that was *hidden* or not when it was recorded, *inner* by a part."""
        if not hidden or inner:
            return not hidden
        number = self._event(event)
        return self._hidden_events is not None and number is not None and number in self._hidden_events

    def step(self, event: str, *, terminated: bool = False) -> Departure | None:
        """Follow an event as the script writes it; what is wrong if it is not allowed (then nothing has moved).

        *terminated*: it is successful termination, whatever it is called.
        """
        number = TICK if terminated else self._event(event)
        if number is None:
            return self._departure(event, "the script has no such event")
        target = self._table[self._now].get(number)
        if target is None:
            if len(self._sets) >= MOST_SETS:
                states = self._sets[self._now]
                self._forgot = True
                self._forget()
                self._now = self._number(states)
            target = self._advance(self._now, number)
            if target is None:
                known = self._forgot or number in self._seen_events()
                why = (
                    "the process does not offer it after these events" if known else "it is not met in the process yet"
                )
                return self._departure(event, why)
        self._now = target
        self.followed += 1
        self._recent.append(event)
        if len(self._recent) > 64:
            del self._recent[:-16]
        return None

    def allowed(self) -> tuple[str, ...]:
        """The events that are allowed now, in the order of declaration."""
        return tuple(self.script.events.name(event) for event in self.allowed_numbers())

    def allowed_numbers(self) -> tuple[int, ...]:
        """The events that are allowed now, ascending."""
        return tuple(sorted(self._offered(self._now)))

    def can_stop(self) -> bool:
        """Whether the process may refuse everything now: it is in a stable state without events."""
        transitions = self._semantics.transitions
        return any(not transitions(state) for state in self._sets[self._now])

    def offers(self) -> tuple[frozenset[str], ...]:
        """What each stable state that the process may be in offers, without those that offer more than another."""
        found = set()
        for state in self._sets[self._now]:
            row = self._semantics.transitions(state)
            if all(event != TAU for event, _ in row):
                found.add(frozenset(event for event, _ in row))
        least = [offer for offer in found if not any(other < offer for other in found)]
        name = self.script.events.name
        return tuple(frozenset(map(name, offer)) for offer in sorted(least, key=sorted))

    def automaton(self, most: int) -> list[dict[int, int]]:
        """The whole: for each set of states what every event makes of it; the first is that of the beginning.

        Raises:
            TooManyStates: there are more than *most*.
        """
        number = 0
        while number < len(self._sets):
            if number >= most:
                raise TooManyStates
            for event in sorted(self._offered(number)):
                if event not in self._table[number]:
                    self._advance(number, event)
            number += 1
        return [dict(row) for row in self._table]

    # --- sets of states --------------------------------------------------------------------------------------

    def _forget(self) -> None:
        """Know nothing but what the process is."""
        self._semantics = Semantics()
        self._directed = Directed(self._semantics)
        self._sets: list[frozenset[Process]] = []
        self._numbers: dict[frozenset[Process], int] = {}
        self._table: list[dict[int, int]] = []

    def _number(self, states: Iterable[Process]) -> int:
        """The number of the set of *states*, closed under tau."""
        semantics, directed = self._semantics, self._directed
        closed: dict[Process, None] = {}
        todo = [semantics.state(state) for state in states]
        while todo:
            state = todo.pop()
            if state in closed:
                continue
            closed[state] = None
            if len(closed) > MOST_STATES:
                raise TooManyStates
            todo += [semantics.state(target) for target in directed.after(state, TAU)]
        key = frozenset(closed)
        number = self._numbers.get(key)
        if number is None:
            number = self._numbers[key] = len(self._sets)
            self._sets.append(key)
            self._table.append({})
        return number

    def _advance(self, source: int, event: int) -> int | None:
        directed = self._directed
        targets = [target for state in self._sets[source] for target in directed.after(state, event)]
        if not targets:
            return None
        number = self._table[source][event] = self._number(targets)
        return number

    def _offered(self, number: int) -> set[int]:
        """The events of a set of states, taus apart."""
        return {event for state in self._sets[number] for event in self._directed.initials(state)} - {TAU}

    def _seen_events(self) -> set[int]:
        return {event for number in range(len(self._sets)) for event in self._offered(number)}

    def _event(self, text: str) -> int | None:
        """The number of an event by its text; None if the script has no such event."""
        if text not in self._events:
            try:
                (number,) = self.script.trace(f"<{text}>")
            except (ScriptError, ValueError):
                self._events[text] = self._named(text)
            else:
                self._events[text] = number
        return self._events[text]

    def _named(self, text: str) -> int | None:
        """The number of an event that is called so: one with values that no expression has, such as real numbers."""
        table = self.script.events
        for channel in table.channels:
            if text.startswith(f"{channel.name}.") and channel.size is not None and channel.size <= MOST_STATES:
                for event in range(channel.base, channel.base + channel.size):
                    if table.name(event) == text:
                        return event
        return None

    def _departure(self, event: str, why: str) -> Departure:
        states = [describe(state, self.script.events, width=90) for state in list(self._sets[self._now])[:3]]
        return Departure(self.followed, event, why, self.allowed(), tuple(self._recent[-6:]), tuple(sorted(states)))


def shown(process: Process, table: EventTable) -> tuple[Process, EventSet]:
    """A process without its outermost hiding, and the events that this hides."""
    events = EventSet()
    while True:
        if isinstance(process, Reference):
            body = process.body()
            if not isinstance(body, (Hide, Parallel)):
                return process, events
            process = body
        elif isinstance(process, Hide):
            events = events | process.events
            process = process.process
        elif isinstance(process, Parallel):
            parts = [_shown_part(operand, table) for operand in process.operands]
            for _, own in parts:
                events = events | own
            return Parallel(process.events, tuple(part for part, _ in parts), process.clocks), events
        else:
            return process, events


def _shown_part(process: Process, table: EventTable) -> tuple[Process, EventSet]:
    """An operand of a parallel without its outermost hiding, if that hides only what is a class's own.

    Nobody else takes part in these events, so it makes no difference where they are hidden.
    """
    shown_one, events = shown(process, table)
    own = all("::" in table.name(event) for event in events)
    return (shown_one, events) if own else (process, EventSet())


def at(departure: Departure, position: int) -> Departure:
    """The same departure at another position: that in a run with events that were not followed."""
    return replace(departure, position=position)
