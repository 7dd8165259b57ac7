"""The machines of components: a process term that runs inside a composition, explored on its own.

What a component's machine is depends on where the component runs, its *role*: by itself it ticks as it is; under a
parallel operator termination is distributed (``cspcheck.checker.semantics.parallel``); as the right of an interrupt it
runs only until its first visible event.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from cspcheck.checker.collecting import seldom
from cspcheck.checker.lts import Lts, machine, reachable
from cspcheck.checker.semantics.growth import so_far
from cspcheck.checker.semantics.machine_states import ExplicitMachine
from cspcheck.checker.semantics.menus import States, explored
from cspcheck.checker.semantics.parallel import waits
from cspcheck.checker.semantics.steps import Row, Step
from cspcheck.checker.semantics.transitions import Explored, MoreStates, Poll, Semantics, TooMany
from cspcheck.cspm.interruption import during
from cspcheck.cspm.process.events import TAU, TICK, EventSet
from cspcheck.cspm.process.terms import NO_EVENTS, SKIP, MachineState, Process


@dataclass(frozen=True, slots=True)
class Alone:
    """The component is the whole, or the left of an interrupt: it ticks when it can."""


@dataclass(frozen=True, slots=True)
class Joined:
    """The component is an operand of a parallel operator, perhaps hidden and renamed.

    In states where it can tick and also do something else it has, instead of the tick, a tau to SKIP. So it ticks
    only where that is all it can do, or where it waits: where it offers one of the *clocks* of the operator.
    """

    clocks: EventSet = NO_EVENTS


@dataclass(frozen=True, slots=True)
class Interrupting:
    """The component is the right of an interrupt; what it does visibly, except *events*, takes over."""

    events: EventSet


Role = Alone | Joined | Interrupting
ALONE = Alone()


def joined(row: Row, clocks: EventSet) -> list[Step]:
    """The transitions of a component under a parallel operator, given those that it has by itself."""
    if len(row) > 1 and any(event == TICK for event, _ in row) and not waits(row, clocks):
        rest = [(event, state) for event, state in row if event != TICK]
        return [*rest, *([(TAU, SKIP)] if (TAU, SKIP) not in rest else [])]
    return list(row)


def joined_machine(lts: Lts, clocks: EventSet) -> Lts:
    """The machine of a component under a parallel operator, given the one that it has by itself."""
    starts = np.repeat(np.arange(lts.states), np.diff(lts.offsets))
    early = (lts.labels == TICK) & (np.diff(lts.offsets)[starts] > 1)
    if clocks:
        waiting = np.zeros(lts.states, dtype=np.bool_)
        waiting[starts[np.isin(lts.labels, list(clocks))]] = True
        early &= ~waiting[starts]
    if not early.any():
        return lts
    # As in :func:`joined`, with two more states: SKIP and what is left of it.
    skip, terminated = lts.states, lts.states + 1
    labels, targets = lts.labels.copy(), lts.targets.copy()
    labels[early], targets[early] = TAU, skip
    return reachable(
        machine(
            lts.states + 2,
            np.append(starts, skip),
            np.append(labels, TICK),
            np.append(targets, terminated),
            lts.root,
        )
    )


def _machine_at(state: MachineState, role: Alone | Joined) -> Explored:
    """What a state of an explicit machine reaches, without looking at the states one by one."""
    assert isinstance(state.machine, ExplicitMachine)
    lts = reachable(replace(state.machine.lts, root=state.state))
    if isinstance(role, Joined):
        lts = joined_machine(lts, role.clocks)
    return Explored(lts, (state,) * lts.states)


ExploreMost = Callable[[int, Poll | None], Explored]
"""Explores a term up to so many states, or raises ``MoreStates``."""
Explorer = Callable[[Process], ExploreMost | None]
"""Gives another way to explore a term, if there is one."""

REMEMBERED = 20_000
"""So many terms of a component that has too many are remembered, to say so again at once."""


class ComponentMachines:
    """The machines of components by themselves and under parallel operators, each built once.

    Args:
        semantics: the transitions of terms.
        explorer: explores what is chased, if that is to be done in a faster way than by its rule.

    Attributes:
        poll: called now and then with the number of states of the machine being built; what it raises ends that.
    """

    def __init__(self, semantics: Semantics, explorer: Explorer | None = None) -> None:
        self.poll: Poll | None = None
        self._explorer = explorer
        self._semantics = semantics
        self._known: dict[tuple[Process, Role], Explored] = {}
        self._at_most: dict[Process, int] = {}
        self._too_big: dict[tuple[Process, Role], Sequence[Process]] = {}

    def of(self, state: Process, role: Alone | Joined, most: int) -> Explored:
        """The machine of a component.

        Raises:
            MoreStates: it has more than *most* states.
        """
        key = (state, role)
        found = self._known.get(key)
        if found is None and isinstance(state, MachineState):
            found = self._known[key] = _machine_at(state, role)
        if found is None and self._explorer is not None and (explore := self._explorer(state)) is not None:
            # It never ticks, so it is under a parallel operator what it is by itself.
            found = self._known[key] = self._of_chase(explore, most, key)
        if found is None:
            successors: Callable[[Process], list[Step] | Row] = self._semantics.transitions
            if isinstance(role, Joined):
                successors = partial(self._joined_successors, role.clocks)
            met = self._too_big.get(key, ())
            if len(met) >= most:
                raise MoreStates(met[:most])
            heads = self._semantics.heads
            terms = States(heads)
            try:
                with during(partial(so_far, terms, heads)), seldom():
                    lts = explored(state, successors, most, self.poll, terms, heads)
                    found = self._known[key] = Explored(lts, terms)
            except TooMany:
                self._too_big[key] = terms[:REMEMBERED]
                raise MoreStates(terms) from None
        if found.lts.states > most:
            raise MoreStates(found.terms[:most])
        return found

    def _of_chase(self, explore: ExploreMost, most: int, key: tuple[Process, Role]) -> Explored:
        if len(self._too_big.get(key, ())) >= most:
            raise MoreStates(self._too_big[key][:most])
        try:
            return explore(most, self.poll)
        except MoreStates as more:
            self._too_big[key] = list(more.terms[:REMEMBERED])
            raise

    def has_at_most(self, state: Process, most: int) -> bool:
        """Whether a term has no more than *most* states."""
        if self._at_most.get(state, most + 1) <= most:
            return True
        try:
            found = self.of(state, ALONE, most)
        except MoreStates:
            return False
        # Whatever it becomes has no more states than it has; else each of them would be explored for itself.
        for term in found.terms:
            self._at_most.setdefault(term, found.lts.states)
        return True

    def _joined_successors(self, clocks: EventSet, state: Process) -> list[Step]:
        return joined(self._semantics.transitions(state), clocks)
