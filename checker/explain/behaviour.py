"""From a failed search to an explained behaviour: what the whole did, and what each component did and waits for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from cspcheck.checker.explain.blocked_slots import Blocked, blocked, shortest_cycle
from cspcheck.checker.explain.replay import Replay, ReplayFailure, states_after
from cspcheck.checker.explain.running import distinct_names
from cspcheck.checker.explain.story import Data, Told
from cspcheck.checker.network.network import Network, Slot
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.exploration import Exploration
from cspcheck.checker.search.paths import PathStep, tau_loop
from cspcheck.checker.semantics.steps import Row
from cspcheck.checker.semantics.transitions import offer
from cspcheck.checker.verdict import ComponentBehaviour, Counterexample, CounterexampleKind, ReplayedRun
from cspcheck.cspm.process.events import FIRST_EVENT, TAU, TICK, EventTable
from cspcheck.cspm.process.terms import STOP, Process
from cspcheck.cspm.process.text import describe

REPLAYED_COMPONENT = 5_000
"""A compressed component is replayed if no more states than this of its operand must be looked at."""


def visible(path: Iterable[PathStep]) -> tuple[int, ...]:
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
    path: tuple[PathStep, ...]
    events: EventTable
    _used: list[set[int]] = field(init=False)
    _told: Told | None = field(init=False, default=None)

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
        inside = self._told.causes if self._told is not None and self._has_own_taus(self.path) else ()
        inside = inside or (None,) * len(self.path)
        causes = [self._cause(step, told) for step, told in zip(self.path, inside, strict=True)]
        return tuple(None if cause is None else self.events.name(cause) for cause in causes)

    @property
    def run(self) -> ReplayedRun | None:
        """The run as terms, once it has been confirmed."""
        return None if self._told is None else ReplayedRun(self.process, self._told.run)

    def loop_names(self, loop: Sequence[PathStep]) -> tuple[str, ...]:
        """A cycle of taus by what was hidden in them; the word for tau where nothing was."""
        inside = self._told.loop_causes if self._told is not None and self._has_own_taus(loop) else ()
        inside = inside or (None,) * len(loop)
        causes = [self._cause(step, told) for step, told in zip(loop, inside, strict=True)]
        return tuple(self.events.tau if cause is None else self.events.name(cause) for cause in causes)

    def loop_parts(self, loop: Sequence[PathStep]) -> tuple[tuple[tuple[str, str], ...], ...]:
        """The components that take part in each tau of a cycle, each with what it performs itself."""
        if self._is_told_in_terms:
            assert self._told is not None
            return self._told.loop_parts(self.events)
        network = self.packed.network
        return tuple(
            tuple(
                (self._slot_names[slot], self.events.name(local_event(network, label)))
                for slot, label in network.rules[step.rule].moves
            )
            for step in loop
        )

    def alphabet(self) -> tuple[str, ...]:
        """The names of all visible events that the network can ever perform, in order."""
        return self.names(event for event in self.packed.events.tolist() if event >= FIRST_EVENT)

    def names(self, events: Iterable[int]) -> tuple[str, ...]:
        """The names of events, in the order of their identifiers."""
        return tuple(self.events.name(event) for event in sorted(events))

    def confirm(self, holds: Callable[[Row], bool], claim: str, loop: Sequence[PathStep] = ()) -> None:
        """Replay the behaviour on the terms and check its end.

        Args:
            holds: tells from the transitions of the state at the end whether it is what was claimed.
            claim: that in words.
            loop: for a divergence the cycle of taus behind the path.

        Raises:
            ReplayFailure: the process does not behave like that.
        """
        if self.packed.network.is_compressed:
            self._confirm_components(loop)
            return
        try:
            replay = self._replayed(holds, claim, loop, in_order=True)
        except ReplayFailure:
            # The components may stand in another order than they have in the network.
            replay = self._replayed(holds, claim, loop, in_order=False)
        self._told = Told(self.process, replay)

    def _replayed(
        self, holds: Callable[[Row], bool], claim: str, loop: Sequence[PathStep], *, in_order: bool
    ) -> Replay:
        replay = Replay(self.process, in_order=in_order)
        for step, used in zip(self.path, self._used[1:], strict=True):
            replay.step(step.event, self._terms(step, used))
        replay.expect(holds, claim)
        if loop:
            replay.expect_loop(self._terms(step, self._used[-1]) for step in loop)
        return replay

    def _confirm_components(self, loop: Sequence[PathStep]) -> None:
        """Replay what each component did, where some are compressed and their taus are not those of the terms.

        A compressed component is followed by all runs of its operand with the same visible events; where these are too
        many it is taken on trust that it can do what it stands for.

        Raises:
            ReplayFailure: a component does not behave like that.
        """
        network = self.packed.network
        if network.formats > 1:
            return  # which terms came and went in a slot is not told by its labels
        final = self._local_states()
        for number, slot in enumerate(network.slots):
            labels = [label for step in (*self.path, *loop) for label in self._labels(number, step) if label != TAU]
            process = slot.terms[0] if slot.compressed is None else slot.compressed
            rows = states_after(process, labels, REPLAYED_COMPONENT)
            if rows is None:
                continue
            accepted = None if loop else offer(tuple((label, STOP) for label, _ in slot.lts.successors(final[number])))
            offers = (offer(row) for row in rows)
            if not rows or (accepted is not None and not any(o is not None and o <= accepted for o in offers)):
                raise ReplayFailure(f"{slot.name} does not behave as it was found to")

    def _labels(self, slot: int, step: PathStep) -> list[int]:
        moves = self.packed.network.rules[step.rule].moves
        return [label for participant, label in moves if participant == slot]

    def components(self) -> tuple[ComponentBehaviour, ...]:
        """What each component that was ever in use did, and where it stands.

        The components that took part and are not in use any more (the left of a ``;`` that has passed on) have the
        empty state.
        """
        if self._is_told_in_terms:
            assert self._told is not None
            return self._told.components(self.events)
        network = self.packed.network
        final = self._local_states()
        waits_for = self._waits_for()
        names = self._slot_names
        behaviours = []
        for number in sorted(set().union(*self._used)):
            slot = network.slots[number]
            in_use = number in self._used[-1]
            variables, changes = self._data(number)
            behaviours.append(
                ComponentBehaviour(
                    name=names[number],
                    trace=tuple(self._part(number, step) for step in self.path),
                    state=describe(slot.terms[final[number]], self.events) if in_use else "",
                    line=slot.span.line if slot.span is not None else None,
                    offers=self._offer_names(slot, final[number]) if in_use else (),
                    waiting_for=tuple(names[other] for other in sorted(waits_for.get(number, ()))),
                    variables=variables,
                    changes=changes,
                )
            )
        return tuple(behaviours)

    def parts_in(self, event: int) -> tuple[tuple[str, str], ...]:
        """The components that take part in an event possible at the end, each with its own name of it."""
        if self._is_told_in_terms:
            assert self._told is not None
            return self._told.parts_in(event, self.events)
        network, local = self.packed.network, self._local_states()
        offers = {
            slot: {label for label, _ in network.slots[slot].lts.successors(local[slot])} for slot in self._used[-1]
        }
        for rule in network.rules:
            able = all(label in offers.get(slot, ()) for slot, label in rule.moves)
            if able and rule.result == event and rule.format == self._format():
                return tuple(
                    (self._slot_names[slot], self.events.name(local_event(network, label)))
                    for slot, label in rule.moves
                )
        return ()

    def waiting_cycle(self) -> tuple[str, ...] | None:
        """The shortest cycle of components each of which waits for the next, the last for the first.

        Of several the one that starts with the earliest component; None if there is none.
        """
        if self._is_told_in_terms:
            assert self._told is not None
            return self._told.waiting_cycle()
        cycle = shortest_cycle(self._waits_for(sure=True))
        return None if cycle is None else tuple(self._slot_names[slot] for slot in cycle)

    @property
    def _is_told_in_terms(self) -> bool:
        """Whether the network has the whole as one component, and the terms know what it is made of."""
        return len(self.packed.network.slots) == 1 and self._told is not None and self._told.is_composed

    @cached_property
    def _slot_names(self) -> list[str]:
        return distinct_names(slot.name for slot in self.packed.network.slots)

    def _has_own_taus(self, steps: Iterable[PathStep]) -> bool:
        """Whether some tau is a component's own, so that only the terms can tell what was hidden in it."""
        rules = self.packed.network.rules
        return any(step.event == TAU and rules[step.rule].cause in (TAU, TICK) for step in steps)

    def _cause(self, step: PathStep, inside: int | None) -> int | None:
        """What was hidden in a tau: by the rules, or inside a component."""
        if step.event != TAU:
            return None
        cause = self.packed.network.rules[step.rule].cause
        return inside if cause in (TAU, TICK) else cause

    def _part(self, slot: int, step: PathStep) -> str | None:
        """What the component in a slot performed in a step."""
        for participant, label in self.packed.network.rules[step.rule].moves:
            if participant == slot:
                return self.events.name(local_event(self.packed.network, label))
        return None

    def _local_states(self) -> tuple[int, ...]:
        return self._local(self.path[-1]) if self.path else self.packed.local_states(self.packed.initial)

    def _local(self, step: PathStep) -> tuple[int, ...]:
        return self.packed.local_states(np.array(step.state, dtype=np.int64))

    def _data(self, slot: int) -> Data:
        """The variables of a component that is a class, as far as the run has been replayed on the terms."""
        if self._told is None:
            return {}, ()
        name, terms = self.packed.network.slots[slot].name, self.packed.network.slots[slot].terms
        states = [self.packed.local_states(self.packed.initial), *map(self._local, self.path)]
        own = (terms[local[slot]] if slot in used else None for local, used in zip(states, self._used, strict=True))
        return self._told.data(name, own)

    def _terms(self, step: PathStep, used: set[int]) -> list[Process]:
        local = self._local(step)
        return [self.packed.network.slots[slot].terms[local[slot]] for slot in sorted(used)]

    def _offer_names(self, slot: Slot, state: int) -> tuple[str, ...]:
        network = self.packed.network
        return self.names({local_event(network, label) for label, _ in slot.lts.successors(state)})

    def _waits_for(self, *, sure: bool = False) -> Blocked:
        local = self._local_states()
        used = {slot: local[slot] for slot in self._used[-1]}
        return blocked(self.process, self.packed.network, self._format(), used, sure=sure)

    def _format(self) -> int:
        current = self.packed.network.initial_format
        for step in self.path:
            switch = self.packed.network.rules[step.rule].switch
            if switch is not None:
                current = switch.format
        return current


def begun(
    kind: CounterexampleKind, process: Process, packed: PackedNetwork, path: tuple[PathStep, ...], events: EventTable
) -> Counterexample:
    """A path as a counterexample of which nothing more is known yet."""
    behaviour = Behaviour(process, packed, path, events)
    return Counterexample(kind, behaviour.trace, behaviour.causes)


def deadlocked(
    process: Process, packed: PackedNetwork, path: tuple[PathStep, ...], events: EventTable
) -> Counterexample:
    """A path to a deadlock."""
    behaviour = Behaviour(process, packed, path, events)
    behaviour.confirm(lambda row: not row, "a deadlock")
    return Counterexample(
        "deadlock",
        behaviour.trace,
        behaviour.causes,
        refusal=behaviour.alphabet(),
        components=behaviour.components(),
        run=behaviour.run,
        waiting_cycle=behaviour.waiting_cycle(),
    )


def diverging(
    process: Process, exploration: Exploration, path: tuple[PathStep, ...], end: int, events: EventTable
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
        loop_parts=behaviour.loop_parts(loop),
        components=behaviour.components(),
        run=behaviour.run,
    )


def local_event(network: Network, label: int) -> int:
    """The event identifier that a component's label stands for."""
    if label >= network.first_private_label:
        return network.private_labels[label - network.first_private_label]
    return label
