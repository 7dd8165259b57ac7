"""Compositions in which something is chased: the whole and its parts are explored in turns, never such a part alone.

What is chased may have no end by itself, or nearly none (an eavesdropper can learn anything in any order), and few
states in company. Its states are worked out when the whole gets there. The other components are explored before.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import product

from cspcheck.checker.lts import Lts
from cspcheck.checker.network.actions import TooManyActions
from cspcheck.checker.network.chased import CHASES, Chased, Chases, NotChasable
from cspcheck.checker.network.lazy_terms import LazyTerms
from cspcheck.checker.network.network import Network
from cspcheck.checker.network.shapes import JOINING, STATIC_UNARY
from cspcheck.checker.network.skeleton import Component, Told, compile_parts
from cspcheck.checker.network.trees import OperatorTree, tree_of
from cspcheck.checker.semantics.transitions import Explored, MoreStates, Poll, Semantics, TooMany, spanned
from cspcheck.cspm.process.events import TICK
from cspcheck.cspm.process.terms import Compressed, External, Process, Reference

Locals = tuple[int, ...]
Moves = tuple[tuple[int, int], ...]


def is_chased(process: Process) -> bool:
    """Whether something is chased among the components of a skeleton."""
    seen = {process}
    pending = [process]
    while pending:
        term = pending.pop()
        if isinstance(term, Reference):
            below: tuple[Process, ...] = (term.body(),)
        elif isinstance(term, (Compressed, STATIC_UNARY)):
            below = (term.process,)
        elif isinstance(term, JOINING):
            below = term.active()
        elif isinstance(term, External) and term.function in CHASES:
            return True
        else:
            continue
        fresh = [operand for operand in below if operand not in seen]
        seen.update(fresh)
        pending.extend(fresh)
    return False


class LazyComposition:
    """A composition whose chased components are explored as the whole gets to their states.

    Args:
        process: the composition, nowhere prioritised.
        chases: what is chased.
        semantics: brings terms to head normal form.
        component: explores a component that is not chased.
        is_machine, has_machines: as in ``skeleton.compile_skeleton``.

    Attributes:
        components: what stands in each slot.
        network: the rules; the machine of what is chased is not the one that it has.
        chased: by slot, what is chased.
        initial: the local state of each component at the beginning.
        driven: by slot and label, the rules that this slot is asked for: what comes of it and what the others must do.

    Raises:
        Unsuited: nothing is chased, or the composition is not of such a kind.
    """

    def __init__(
        self,
        process: Process,
        chases: Chases,
        semantics: Semantics,
        component: Callable[[Component], Explored],
        is_machine: Told,
        has_machines: Told,
    ) -> None:
        self.process = process

        def explored(part: Component) -> Explored:
            found = chases.of(semantics.state(part.process))
            if found is None:
                return component(part)
            # All that it may ever do, in one state: the rules need no more.
            row = [(label, 0) for label in found[0].alphabet]
            return Explored(Lts.from_successors([row]), (found[0].term(found[1]),))

        try:
            self.network, self.components = compile_parts(process, explored, is_machine, has_machines)
        except TooManyActions:
            raise NotChasable from None
        self.chased: dict[int, Chased] = {}
        self._has_machines = has_machines
        initial = [0] * len(self.components)
        for slot, part in enumerate(self.components):
            found = chases.of(semantics.state(part.process))
            if found is not None:
                self.chased[slot], initial[slot] = found
        if not self.chased or any(rule.result == TICK for rule in self.network.rules):
            raise NotChasable
        self.initial: Locals = tuple(initial)
        self._rows = [
            None if slot in self.chased else _rows(component_.lts) for slot, component_ in enumerate(self.network.slots)
        ]
        self.driven = self._drivers(self.network)
        self._candidates: dict[tuple[int, int], list[tuple[int, tuple[int, ...], Moves]]] = {}

    def explored(self, most: int, poll: Poll | None) -> Explored:
        """The machine of the whole.

        Raises:
            MoreStates: it has more than *most* states.
        """
        states: list[Locals] = []
        tree: OperatorTree = tree_of(self.process, self.components)

        def term(number: int) -> Process:
            return tree.put_together([self._local_term(*found) for found in enumerate(states[number])])

        try:
            lts = spanned(self.initial, self._successors, most, poll, states)
        except TooMany:
            raise MoreStates(LazyTerms(len(states), term)) from None
        return Explored(lts, LazyTerms(len(states), term))

    def network_of(self, machines: Mapping[int, tuple[Lts, Sequence[int]]]) -> Network:
        """The network, given the machine of each component that is chased, and which of its states the machine has."""
        slots = list(self.network.slots)
        for slot, (lts, states) in machines.items():
            chased = self.chased[slot]
            terms = LazyTerms(len(states), partial(_term_of, chased, states))
            compressed = self.components[slot].process if self._has_machines(terms[0]) else None
            slots[slot] = replace(slots[slot], lts=lts, terms=terms, compressed=compressed)
        return replace(self.network, slots=tuple(slots))

    def _local_term(self, slot: int, state: int) -> Process:
        return self.chased[slot].term(state) if slot in self.chased else self.network.slots[slot].terms[state]

    def _drivers(self, network: Network) -> list[dict[int, list[tuple[int, Moves]]]]:
        """By slot and label: the rules that this slot is asked for first, each with what the others must do.

        That slot is not chased if there is another, and of the others one that has few transitions in a state.
        """
        width = [max(map(len, rows), default=0) if rows is not None else 1 << 60 for rows in self._rows]
        driven: list[dict[int, list[tuple[int, Moves]]]] = [{} for _ in network.slots]
        for rule in network.rules:
            first = min(rule.moves, key=lambda move: width[move[0]])
            others = tuple(move for move in rule.moves if move is not first)
            driven[first[0]].setdefault(first[1], []).append((rule.result, others))
        return driven

    def _successors(self, state: Locals) -> list[tuple[int, Locals]]:
        steps: dict[tuple[int, Locals], None] = {}
        for slot, local in enumerate(state):
            for result, targets, others in self._candidates_of(slot, local):
                outcomes = [targets]
                for other, label in others:
                    possible = self._after(other, state[other], label)
                    if not possible:
                        break
                    outcomes.append(possible)
                else:
                    moved = (slot, *(other for other, _ in others))
                    for outcome in product(*outcomes):
                        after = list(state)
                        for place, target in zip(moved, outcome, strict=True):
                            after[place] = target
                        steps[result, tuple(after)] = None
        return list(steps)

    def _candidates_of(self, slot: int, local: int) -> list[tuple[int, tuple[int, ...], Moves]]:
        """The rules that a slot is asked for first, in one of its states: event, its own targets, the others' moves."""
        found = self._candidates.get((slot, local))
        if found is None:
            found = self._candidates[slot, local] = [
                (result, targets, others)
                for label, driven in self.driven[slot].items()
                if (targets := self._after(slot, local, label))
                for result, others in driven
            ]
        return found

    def _after(self, slot: int, local: int, label: int) -> tuple[int, ...]:
        rows = self._rows[slot]
        return self.chased[slot].after(local, label) if rows is None else rows[local].get(label, ())


def _term_of(chased: Chased, states: Sequence[int], number: int) -> Process:
    return chased.term(states[number])


def _rows(lts: Lts) -> list[dict[int, tuple[int, ...]]]:
    rows: list[dict[int, tuple[int, ...]]] = []
    for state in range(lts.states):
        row: dict[int, tuple[int, ...]] = {}
        for label, target in lts.successors(state):
            row[label] = (*row.get(label, ()), target)
        rows.append(row)
    return rows
