"""Who waits for whom in a running composition, read off the terms: the components that an offered event lacks.

As ``cspcheck.checker.explain.blocked_slots`` does it for networks; here no component's machine is needed, only what
its state offers and, where it is cheap to find out, which events it can ever perform.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from cspcheck.checker.explain.joining import Missing, joined, linked, renamed, within
from cspcheck.checker.explain.running import Running, RunningComponent, RunningTree
from cspcheck.checker.semantics.parallel import is_ready
from cspcheck.checker.semantics.steps import Step
from cspcheck.checker.semantics.transitions import MoreStates, Semantics, breadth_first
from cspcheck.cspm.process.events import TAU, TICK, EventSet
from cspcheck.cspm.process.terms import (
    NO_EVENTS,
    AlphabetisedParallel,
    Hide,
    LinkedParallel,
    Parallel,
    Process,
    Project,
    Rename,
)
from cspcheck.cspm.recursion import deep_recursion

LOOKED_AT = 500
"""States of a component that are looked at to find out what it can ever perform."""
TRANSITIONS_LOOKED_AT = 20_000
"""And transitions: what may hear anything has thousands of them in every state."""

Offer = tuple[RunningComponent, int]
"""A component and an event that its state offers."""
Offers = dict[int, set[Offer]]
"""By event of a composition, the offers of components that it is made of."""


def waiting(
    semantics: Semantics, running: Running, *, sure: bool = False
) -> dict[RunningComponent, list[RunningComponent]]:
    """For each component with an offer that cannot be taken up, the components that do not play their part in it.

    Offers that can be taken up in some way are left out. Of a group of which nobody can ever take one up, all are
    meant; with *sure* nobody is. Components stand in the order of the composition.
    """
    with deep_recursion():
        found = _Waiting(semantics, sure)
        for offers in found.offers(running.tree, running.state).values():
            found.possible |= offers
    order = {component: i for i, (component, _) in enumerate(running.components())}
    result: dict[RunningComponent, list[RunningComponent]] = {}
    for component in order:
        lacking = {
            other
            for offer, others in found.lacking.items()
            if offer[0] is component and offer not in found.possible
            for other in others
        }
        if lacking:
            result[component] = sorted(lacking, key=order.__getitem__)
    return result


class _Waiting:
    def __init__(self, semantics: Semantics, sure: bool) -> None:
        self._semantics = semantics
        self._sure = sure
        self._alphabets: dict[Process, frozenset[int] | None] = {}
        self._looked_at = 0
        self.possible: set[Offer] = set()
        self.lacking: dict[Offer, set[RunningComponent]] = {}

    def offers(self, tree: RunningTree, state: Process, clocks: EventSet = NO_EVENTS) -> Offers:
        """What a part of the composition can perform now, taus apart; what gets stuck or is hidden is noted.

        *clocks* are those of the parallel operator around.
        """
        if tree.component is not None:
            row = self._semantics.transitions(state)
            # Who could still do something else, and does not wait, terminates by itself, by a tau.
            ends = is_ready(row, clocks)
            return {event: {(tree.component, event)} for event, _ in row if event != TAU and (event != TICK or ends)}
        clocks = _clocks(state, clocks)
        parts = [self.offers(child, q, clocks) for child, q in zip(tree.children, state.active(), strict=True)]
        match state:
            case Parallel():
                return joined(parts, [state.events] * len(parts), self._note(tree, state))
            case AlphabetisedParallel():
                parts = [within(part, alphabet) for part, alphabet in zip(parts, state.alphabets, strict=True)]
                return joined(parts, state.alphabets, self._note(tree, state))
            case LinkedParallel():
                return linked(parts[0], parts[1], state.links, self._note(tree, state), self.possible.update)
            case Hide():
                return self._hidden(parts[0], lambda event: event in state.events)
            case Project():
                return self._hidden(parts[0], lambda event: event != TICK and event not in state.events)
            case Rename():
                return renamed(parts[0], state.pairs)
        # Of the others only priority keeps a component from what it could do, and nobody plays a part in that.
        merged: Offers = {}
        for part in parts:
            for event, offers in part.items():
                merged.setdefault(event, set()).update(offers)
        return merged

    def _hidden(self, part: Offers, is_hidden: Callable[[int], bool]) -> Offers:
        for event in [event for event in part if is_hidden(event)]:
            self.possible |= part.pop(event)
        return part

    def _note(self, tree: RunningTree, state: Process) -> Callable[[set[Offer], Missing], None]:
        def note(offers: set[Offer], missing: Missing) -> None:
            operands = state.active()
            components = set().union(*[self.missing(tree.children[i], operands[i], event) for i, event in missing])
            for offer in offers:
                self.lacking.setdefault(offer, set()).update(components)

        return note

    def missing(self, tree: RunningTree, state: Process, event: int) -> set[RunningComponent]:
        """The components in a part that would have to offer something for the part to perform *event*.

        Where none of several ever can, all of them or, if only sure ones are wanted, none.
        """
        found = self._missing(tree, state, event)
        return found or self._all({component for component, _ in Running(state, tree).components()})

    def _all(self, components: set[RunningComponent]) -> set[RunningComponent]:
        return set() if self._sure and len(components) > 1 else components

    def _missing(self, tree: RunningTree, state: Process, event: int) -> set[RunningComponent]:
        if tree.component is not None:
            return {tree.component}
        operands = state.active()
        children = list(zip(tree.children, operands, strict=True))
        match state:
            case Rename():
                wanted = [old for old, new in state.pairs if new == event]
                if all(old != event for old, _ in state.pairs):
                    wanted.append(event)
                return set().union(*[self._missing(*children[0], old) for old in wanted])
            case AlphabetisedParallel():
                chosen = [
                    child for child, a in zip(children, state.alphabets, strict=True) if event == TICK or event in a
                ]
            case Parallel() | LinkedParallel() if event == TICK or (
                isinstance(state, Parallel) and event in state.events
            ):
                chosen = children
            case _:
                chosen = [child for child in children if self._is_able(child[1], event)]
                if not chosen:
                    return set()
                return set().union(*[self._missing(*child, event) for child in chosen])
        clocks = _clocks(state)
        absent = [child for child in chosen if not self._offers(child[1], event, clocks)]
        return set().union(*[self._missing(*child, event) for child in absent])

    def _offers(self, state: Process, event: int, clocks: EventSet) -> bool:
        row = self._semantics.transitions(state)
        # Who could still do something else, and does not wait, does not end together with the others.
        return is_ready(row, clocks) if event == TICK else any(label == event for label, _ in row)

    def _few(self, state: Process) -> Iterator[Step]:
        """The transitions of a state, as long as not too many of a component have been looked at."""
        row = self._semantics.transitions(state)
        self._looked_at += len(row)
        if self._looked_at > TRANSITIONS_LOOKED_AT:
            raise MoreStates((state,))
        return iter(row)

    def _is_able(self, state: Process, event: int) -> bool:
        if state not in self._alphabets:
            try:
                self._looked_at = 0
                machine = breadth_first(state, self._few, LOOKED_AT, None)
                self._alphabets[state] = frozenset(machine.alphabet())
            except MoreStates:
                self._alphabets[state] = None
        alphabet = self._alphabets[state]
        return alphabet is None or event in alphabet


def _clocks(state: Process, around: EventSet = NO_EVENTS) -> EventSet:
    """The clocks of a parallel operator; of another one those of the operator around."""
    return state.clocks if isinstance(state, Parallel | AlphabetisedParallel | LinkedParallel) else around
