"""A replayed run told by its terms: what was hidden in each tau, and what each component did, however deep it hangs.

A network knows its components and nothing about what is inside them. Small processes are often a single component,
with whole compositions in it; here these are taken apart again.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property

from cspcheck.checker.explain.blocked_slots import shortest_cycle
from cspcheck.checker.explain.blocked_terms import waiting
from cspcheck.checker.explain.replay import Replay
from cspcheck.checker.explain.running import Performed, Runner, Running, RunningComponent, distinct_names
from cspcheck.checker.verdict import ComponentBehaviour
from cspcheck.cspm.process.events import EventTable
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.process.text import describe

Data = tuple[Mapping[str, str], tuple[Mapping[str, str], ...]]
"""Variables of a class: all of them at the beginning, and those that have another value after each step."""


class Told:
    """The run of a replay, step by step.

    Args:
        process: the whole.
        replay: the replay of a behaviour of it, to the end.
    """

    def __init__(self, process: Process, replay: Replay) -> None:
        self._process = process
        self._replay = replay
        self._runner = Runner(replay.semantics)

    @cached_property
    def run(self) -> tuple[tuple[int, Process], ...]:
        """The events, each with the term after it."""
        return tuple(self._replay.run())

    @property
    def causes(self) -> tuple[int | None, ...]:
        """For each step the event that was hidden in it, if one was."""
        return tuple(performed.cause for _, performed in self._steps)

    @property
    def loop_causes(self) -> tuple[int | None, ...]:
        """The same for the steps of the loop at the end."""
        return tuple(performed.cause for performed in self._loop)

    def loop_parts(self, events: EventTable) -> tuple[tuple[tuple[str, str], ...], ...]:
        """What the components that take part in each step of the loop perform."""
        return tuple(self._named_parts(performed, events) for performed in self._loop)

    @property
    def is_composed(self) -> bool:
        """Whether there was ever more than one component."""
        return len(self._met) > 1

    def components(self, events: EventTable) -> tuple[ComponentBehaviour, ...]:
        """What each component did, and where it stands; those that are gone have the empty state."""
        final = dict(self._ends[-1].components())
        waits_for = waiting(self._runner.semantics, self._ends[-1])
        names = self._names
        values = {component: self._data(component) for component in self._met}
        behaviours = []
        for component in self._met:
            row = self._runner.semantics.transitions(final[component]) if component in final else ()
            behaviours.append(
                ComponentBehaviour(
                    name=names[component],
                    trace=tuple(
                        events.name(performed.parts[component]) if component in performed.parts else None
                        for _, performed in self._steps
                    ),
                    state=describe(final[component], events) if component in final else "",
                    line=component.span.line if component.span is not None else None,
                    offers=tuple(events.name(event) for event in sorted({event for event, _ in row})),
                    waiting_for=tuple(names[other] for other in waits_for.get(component, ())),
                    variables=values[component][0],
                    changes=values[component][1],
                )
            )
        return tuple(behaviours)

    def _data(self, component: RunningComponent) -> Data:
        """The variables of a class at the beginning, and what is new of them after each step."""
        states = (
            next((state for other, state in running.components() if other is component), None) for running in self._ends
        )
        return self.data(component.name, states)

    def data(self, component: str, states: Iterable[Process | None]) -> Data:
        """The variables of a class at the beginning, and what is new of them after each step.

        Args:
            component: what a component is called.
            states: its states, before the first step and after each; None where it is not there.
        """
        known: dict[str, str] = {}
        found: list[Mapping[str, str]] = []
        for state in states:
            values = {} if state is None else self._runner.variables(state, component)
            new = {name: value for name, value in values.items() if known.get(name) != value}
            known |= new
            found.append(new)
        return found[0], tuple(found[1:]) if known else ()

    def parts_in(self, event: int, events: EventTable) -> tuple[tuple[str, str], ...]:
        """The components that take part in an event possible at the end, each with its own name of it."""
        running = self._ends[-1]
        after = next((after for label, after in self._runner.steps(running) if label == event), None)
        if after is None:
            return ()
        return self._named_parts(self._runner.performed(running, event, after), events)

    def _named_parts(self, performed: Performed, events: EventTable) -> tuple[tuple[str, str], ...]:
        names = self._names
        return tuple((names[component], events.name(own)) for component, own in performed.parts.items())

    def waiting_cycle(self) -> tuple[str, ...] | None:
        """The shortest cycle of components each of which waits for the next, the last for the first."""
        number = {component: i for i, component in enumerate(self._met)}
        waits_for = waiting(self._runner.semantics, self._ends[-1], sure=True)
        cycle = shortest_cycle({number[one]: {number[other] for other in others} for one, others in waits_for.items()})
        return None if cycle is None else tuple(self._names[self._met[i]] for i in cycle)

    @cached_property
    def _steps(self) -> list[tuple[Running, Performed]]:
        running = self._runner.start(self._process)
        steps = []
        for event, after in self.run:
            running, performed = self._runner.perform(running, event, after)
            steps.append((running, performed))
        return steps

    @cached_property
    def _loop(self) -> list[Performed]:
        running = self._ends[-1]
        steps = []
        for event, after in self._replay.loop():
            running, performed = self._runner.perform(running, event, after)
            # A loop may pass through components that are there in no state of the run.
            self._met.extend(c for c, _ in running.components() if c not in self._met)
            steps.append(performed)
        return steps

    @cached_property
    def _ends(self) -> list[Running]:
        """The process before the first step and after each."""
        return [self._runner.start(self._process), *(running for running, _ in self._steps)]

    @cached_property
    def _met(self) -> list[RunningComponent]:
        """All components of the run, in the order in which they came."""
        return list(dict.fromkeys(component for running in self._ends for component, _ in running.components()))

    @cached_property
    def _names(self) -> dict[RunningComponent, str]:
        return dict(zip(self._met, distinct_names(component.name for component in self._met), strict=True))
