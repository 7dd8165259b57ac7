"""Stepping through a process: where it is, what it can do next, and the way there.

Nothing is explored ahead: a state is looked at when the process gets there, so processes of any size can be probed.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cspcheck.checker.explain.blocked_terms import waiting
from cspcheck.checker.explain.running import Performed, Runner, Running, RunningComponent, distinct_names
from cspcheck.cspm.process.events import TAU, TICK, EventTable
from cspcheck.cspm.process.terms import Process, Terminated

HIDDEN = 10_000
"""States that are looked at to find the taus before a wanted event."""


@dataclass(frozen=True, slots=True)
class ProbeStep:
    """One thing that the process can do next.

    Attributes:
        number: its number, from 1.
        event: what it performs.
        after: the term after it.
    """

    number: int
    event: int
    after: Process


@dataclass(frozen=True, slots=True)
class Point:
    """A point of the way: the process there, and the step that led to it."""

    running: Running
    performed: Performed | None = None


class NoSuchStep(Exception):
    """What was asked for cannot be done here; the message says why."""


class Probe:
    """A process that is stepped through.

    Args:
        process: the process.
        events: names its events.
        run: a run of it to be followed (:meth:`next_of_run`): events, each with the term after it.
        seed: where random walks start from.

    Attributes:
        way: the points passed, the first before any step.
    """

    def __init__(
        self, process: Process, events: EventTable, *, run: Sequence[tuple[int, Process]] = (), seed: int = 0
    ) -> None:
        self.events = events
        self.run = tuple(run)
        self._runner = Runner()
        self._random = random.Random(seed)
        self.way = [Point(self._runner.start(process))]
        # Found out at once, so that what cannot be probed is said before anything is shown.
        self._runner.steps(self.here)

    @property
    def here(self) -> Running:
        """The process now."""
        return self.way[-1].running

    def steps(self) -> list[ProbeStep]:
        """What the process can do now, numbered; by event, in the order of declaration, tau and tick first."""
        return [ProbeStep(i, event, after) for i, (event, after) in enumerate(self._runner.steps(self.here), 1)]

    def performed(self, step: ProbeStep) -> Performed:
        """What would happen in a step."""
        return self._runner.performed(self.here, step.event, step.after)

    def after(self, step: ProbeStep) -> Running:
        """Where a step leads."""
        return self._runner.perform(self.here, step.event, step.after)[0]

    def take(self, step: ProbeStep) -> None:
        """Perform a step."""
        running, performed = self._runner.perform(self.here, step.event, step.after)
        # What the new state can do is found out now: a definition that cannot be evaluated leaves everything as it was.
        self._runner.steps(running)
        self.way.append(Point(running, performed))

    def undo(self, steps: int = 1) -> int:
        """Go back some steps; how many it were."""
        back = min(steps, len(self.way) - 1)
        if back:
            del self.way[-back:]
        return back

    def restart(self) -> None:
        """Go back to the start."""
        del self.way[1:]

    def perform(self, name: str) -> None:
        """Perform an event or a tick, or a tau that hides the event, with as few other taus as possible before it.

        Raises:
            NoSuchStep: it cannot happen, however many taus come first.
        """
        known: dict[Process, Running | None] = {self.here.state: None}
        came: dict[Process, Point] = {self.here.state: self.way[-1]}
        order = [self.here]
        for running in order:
            for event, after in self._runner.steps(running):
                if event != TAU and self.events.name(event) != name:
                    continue
                following, performed = self._runner.perform(running, event, after)
                if name in (self.events.name(event), performed.cause and self.events.name(performed.cause)):
                    before: list[Point] = []
                    back: Running | None = running
                    while back is not None and back is not self.here:
                        before.append(came[back.state])
                        back = known[back.state]
                    self._runner.steps(following)
                    self.way.extend([*reversed(before), Point(following, performed)])
                    return
                if event == TAU and after not in known:
                    known[after] = running
                    came[after] = Point(following, performed)
                    order.append(following)
            if len(known) > HIDDEN:
                raise NoSuchStep(f"`{name}` is not among the events after the nearest {HIDDEN:,} internal states")
        behind = " even after internal steps" if len(known) > 1 else " here"
        raise NoSuchStep(f"`{name}` cannot happen{behind}")

    def copy(self) -> Probe:
        """Another probe at the same point."""
        other = object.__new__(Probe)
        other.events, other.run, other.way = self.events, self.run, list(self.way)
        other._runner, other._random = self._runner, random.Random()
        other._random.setstate(self._random.getstate())
        return other

    def offers(self, state: Process) -> list[int]:
        """The events that a component in a state could perform by itself, tau and tick apart."""
        return list(dict.fromkeys(event for event, _ in self._runner.semantics.transitions(state) if event > TICK))

    def walk(self, steps: int, seed: int | None = None) -> int:
        """Take steps at random, each as likely as any other; how many it were before nothing could happen.

        Args:
            steps: how many at most.
            seed: start the choices anew from here.
        """
        if seed is not None:
            self._random = random.Random(seed)
        for taken in range(steps):
            choices = self.steps()
            if not choices:
                return taken
            self.take(self._random.choice(choices))
        return steps

    def followed(self) -> int | None:
        """How many steps of the run to follow have been taken; None if the way has left it."""
        taken = len(self.way) - 1
        if taken > len(self.run):
            return None
        for point, (event, after) in zip(self.way[1:], self.run, strict=False):
            if point.performed is None or point.performed.event != event or point.running.state is not after:
                return None
        return taken

    def next_of_run(self) -> ProbeStep | None:
        """The next step of the run to follow, among the steps here; None at its end or off it."""
        position = self.followed()
        if position is None or position >= len(self.run):
            return None
        event, after = self.run[position]
        return next((step for step in self.steps() if (step.event, step.after) == (event, after)), None)

    def trace(self) -> list[Performed]:
        """What happened so far."""
        return [point.performed for point in self.way if point.performed is not None]

    def components(self) -> list[tuple[str, RunningComponent, Process]]:
        """Names, components and states; equal names are numbered."""
        return _named(self.here)

    def data(self) -> list[dict[str, Mapping[str, str]]]:
        """At each point of the way, from the start: the variables of components that are classes, by their names."""
        return [
            {
                name: variables
                for name, component, state in _named(point.running)
                if (variables := self._runner.variables(state, component.name))
            }
            for point in self.way
        ]

    def waiting(self) -> dict[RunningComponent, list[RunningComponent]]:
        """Who waits for whom."""
        return waiting(self._runner.semantics, self.here)

    def surely_waiting(self) -> dict[RunningComponent, list[RunningComponent]]:
        """Who waits for whom, without those of whom it may be another one."""
        return waiting(self._runner.semantics, self.here, sure=True)

    @property
    def has_terminated(self) -> bool:
        """Whether the process has ticked."""
        return isinstance(self.here.state, Terminated)


def _named(running: Running) -> list[tuple[str, RunningComponent, Process]]:
    found = running.components()
    names = distinct_names(component.name for component, _ in found)
    return [(name, component, state) for name, (component, state) in zip(names, found, strict=True)]


def step_name(events: EventTable, performed: Performed) -> str:
    """An event as it is shown and typed: ``mid.0``, ``tau``, ``tau (mid.0)``, ``tick``."""
    name = events.name(performed.event)
    if performed.cause is not None:
        return f"{name} ({events.name(performed.cause)})"
    return name
