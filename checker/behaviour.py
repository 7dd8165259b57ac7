"""From a failed search to an explained behaviour: what the whole did, and what each component did and waits for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from checker.blocking import Blocked, blocked, shortest_cycle
from checker.network import Network, Slot
from checker.packed import PackedNetwork
from checker.paths import Step, tau_loop
from checker.replay import Replay
from checker.search import Exploration
from checker.transitions_rows import Row
from checker.verdict import ComponentBehaviour, Counterexample
from cspm.events import FIRST_EVENT, TAU, EventTable
from cspm.process import Process
from cspm.process_text import describe


def visible(path: Iterable[Step]) -> tuple[int, ...]:
    """The trace of a path: its events without the taus."""
    return tuple(step.event for step in path if step.event != TAU)


@dataclass(eq=False)
class Behaviour:
    """A run of a process through its network, ready to be explained.

    Attributes:
        process: the whole.
        packed: its network.
        path: the run, from the initial state.
        events: names the events.
    """

    process: Process
    packed: PackedNetwork
    path: tuple[Step, ...]
    events: EventTable
    _used: list[set[int]] = field(init=False)

    def __post_init__(self) -> None:
        network = self.packed.network
        self._used = [{slot for slot, _ in network.initial}]
        for step in self.path:
            used = set(self._used[-1])
            switch = network.rules[step.rule].switch
            if switch is not None:
                used -= set(switch.cleared)
                used |= {slot for slot, _ in switch.started}
            self._used.append(used)

    @property
    def trace(self) -> tuple[str, ...]:
        """The names of the events in order, each tau as ``tau``."""
        return tuple(self.events.name(step.event) for step in self.path)

    @property
    def causes(self) -> tuple[str | None, ...]:
        """For each step the event that was hidden in it, if one was."""
        return tuple(
            None if cause is None or step.event != TAU else self.events.name(cause)
            for step, cause in ((step, self._cause(step)) for step in self.path)
        )

    def loop_names(self, loop: Iterable[Step]) -> tuple[str, ...]:
        """A cycle of taus by what was hidden in them; ``tau`` where nothing was."""
        causes = (self._cause(step) for step in loop)
        return tuple("tau" if cause is None else self.events.name(cause) for cause in causes)

    def alphabet(self) -> tuple[str, ...]:
        """The names of all visible events that the network can ever perform, in order."""
        return self.names(event for event in self.packed.events.tolist() if event >= FIRST_EVENT)

    def names(self, events: Iterable[int]) -> tuple[str, ...]:
        """The names of events, in the order of their identifiers."""
        return tuple(self.events.name(event) for event in sorted(events))

    def confirm(self, holds: Callable[[Row], bool], claim: str, loop: Sequence[Step] = ()) -> None:
        """Replay the behaviour on the terms and check its end.

        Args:
            holds: tells from the transitions of the state at the end whether it is what was claimed.
            claim: that in words.
            loop: for a divergence the cycle of taus behind the path.

        Raises:
            ReplayFailure: the process does not behave like that.
        """
        replay = Replay(self.process)
        for step, used in zip(self.path, self._used[1:], strict=True):
            replay.step(step.event, self._terms(step, used))
        replay.expect(holds, claim)
        if loop:
            replay.expect_loop(self._terms(step, self._used[-1]) for step in loop)

    def components(self) -> tuple[ComponentBehaviour, ...]:
        """What each component that was ever in use did, and where it stands.

        The components that took part and are not in use any more (the left of a ``;`` that has passed on) have the
        empty state.
        """
        network = self.packed.network
        final = self._local_states()
        waits_for = self._blocked
        behaviours = []
        for number in sorted(set().union(*self._used)):
            slot = network.slots[number]
            in_use = number in self._used[-1]
            behaviours.append(
                ComponentBehaviour(
                    name=slot.name,
                    trace=tuple(self._part(number, step) for step in self.path),
                    state=describe(slot.terms[final[number]], self.events) if in_use else "",
                    line=slot.span.line if slot.span is not None else None,
                    offers=self._offer_names(slot, final[number]) if in_use else (),
                    waiting_for=tuple(
                        dict.fromkeys(network.slots[other].name for other in sorted(waits_for.get(number, ())))
                    ),
                )
            )
        return tuple(behaviours)

    def waiting_cycle(self) -> tuple[str, ...] | None:
        """The shortest cycle of components each of which waits for the next, the last for the first.

        Of several the one that starts with the earliest component; None if there is none.
        """
        cycle = shortest_cycle(self._blocked)
        return None if cycle is None else tuple(self.packed.network.slots[slot].name for slot in cycle)

    def _cause(self, step: Step) -> int | None:
        cause = self.packed.network.rules[step.rule].cause
        return None if cause == TAU else cause

    def _part(self, slot: int, step: Step) -> str | None:
        """What the component in a slot performed in a step."""
        for participant, label in self.packed.network.rules[step.rule].moves:
            if participant == slot:
                return self.events.name(local_event(self.packed.network, label))
        return None

    def _local_states(self) -> tuple[int, ...]:
        return self._local(self.path[-1]) if self.path else self.packed.local_states(self.packed.initial)

    def _local(self, step: Step) -> tuple[int, ...]:
        return self.packed.local_states(np.array(step.state, dtype=np.int64))

    def _terms(self, step: Step, used: set[int]) -> list[Process]:
        local = self._local(step)
        return [self.packed.network.slots[slot].terms[local[slot]] for slot in used]

    def _offer_names(self, slot: Slot, state: int) -> tuple[str, ...]:
        network = self.packed.network
        return self.names({local_event(network, label) for label, _ in slot.lts.successors(state)})

    @cached_property
    def _blocked(self) -> Blocked:
        local = self._local_states()
        used = {slot: local[slot] for slot in self._used[-1]}
        return blocked(self.process, self.packed.network, self._format(), used)

    def _format(self) -> int:
        current = self.packed.network.initial_format
        for step in self.path:
            switch = self.packed.network.rules[step.rule].switch
            if switch is not None:
                current = switch.format
        return current


def diverging(
    process: Process, exploration: Exploration, path: tuple[Step, ...], end: int, events: EventTable
) -> Counterexample:
    """A path to the state with index *end*, and the shortest cycle of taus through that state."""
    loop = tau_loop(exploration, end)
    behaviour = Behaviour(process, exploration.packed, path, events)
    behaviour.confirm(bool, "a state with transitions", loop)
    return Counterexample(
        "divergence",
        behaviour.trace,
        behaviour.causes,
        loop=behaviour.loop_names(loop),
        components=behaviour.components(),
    )


def local_event(network: Network, label: int) -> int:
    """The event identifier that a component's label stands for."""
    if label >= network.first_private_label:
        return network.private_labels[label - network.first_private_label]
    return label
