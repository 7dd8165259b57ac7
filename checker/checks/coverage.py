"""What a composition does in all of its reachable states: the part that each component takes, seen from its own side.

A check says whether something bad can happen. What never happens at all is the other question that a passed check
leaves open: a component that never moves, an event that nobody takes up. The network is explored without any
reduction; each transition of it is a rule, a rule names the local step of each participant, and a local step is derived
by the operational semantics down to the prefix that performs it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int64Array
from cspcheck.checker.network.network import Network, Slot
from cspcheck.checker.packing.layout import BitField
from cspcheck.checker.search.exploration import Exploration
from cspcheck.checker.search.walk import CHUNK
from cspcheck.checker.semantics.derivation import NotDerivable, derive
from cspcheck.checker.semantics.steps import Row, Step
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.cspm.process.events import TAU, TICK
from cspcheck.cspm.process.terms import Hide, LinkedParallel, Prefix, Process, Project, Rename
from cspcheck.cspm.recursion import deep_recursion
from cspcheck.cspm.source import Span

MOST_STEPS = 100_000
"""So many different local steps are traced back to their prefixes."""


@dataclass(frozen=True, slots=True)
class ComponentActivity:
    """A component and whether it ever does anything.

    Attributes:
        name, span: what it is called and where it is defined.
        moves: whether it takes part in any transition.
    """

    name: str
    span: Span | None
    moves: bool


@dataclass(slots=True)
class Happened:
    """What can happen in a composition.

    Attributes:
        performed: the prefixes that are performed, each with the event (that of the prefix itself, before renaming).
        offered: the prefixes that a component comes to offer in a reachable state, performed or not.
        events: the events of the whole, hidden ones by what they were.
        visible: those that are not hidden.
        able: the events that components can perform by themselves.
        parts: the components.
        states: how many states there are.
    """

    performed: set[tuple[Process, int]] = field(default_factory=set)
    offered: set[tuple[Process, int]] = field(default_factory=set)
    events: set[int] = field(default_factory=set)
    visible: set[int] = field(default_factory=set)
    able: set[int] = field(default_factory=set)
    parts: list[ComponentActivity] = field(default_factory=list)
    states: int = 0


_CHANGING = (Hide, Project, Rename, LinkedParallel)
"""Operators under which an event is no longer called what the prefix calls it."""


class TooManySteps(Exception):
    """There are more than ``MOST_STEPS`` local steps to be traced back."""


def happened(exploration: Exploration) -> Happened:
    """What happens in the reachable states of a complete exploration of a network that is not compressed.

    Raises:
        TooManySteps: the components have too many steps.
        ScriptError: a definition cannot be evaluated.
    """
    packed = exploration.packed
    network = packed.network
    labels = [sorted(set(slot.lts.labels.tolist())) for slot in network.slots]
    fired, reached, rules = _fired(exploration, labels)
    found = Happened(states=exploration.levels[-1])
    for number in np.flatnonzero(rules).tolist():
        rule = network.rules[number]
        found.events.add(rule.result if rule.result != TAU else rule.cause)
        found.visible.add(rule.result)
    found.events -= {TAU, TICK}
    found.visible -= {TAU, TICK}
    tracer = _Tracer(network, found)
    with deep_recursion():
        for slot, steps, states, known in zip(network.slots, fired, reached, labels, strict=True):
            tracer.slot(slot, steps, states, known)
    return found


def _fired(exploration: Exploration, labels: list[list[int]]) -> tuple[list[BoolArray], list[BoolArray], BoolArray]:
    """For each slot which labels it performs in which local states and which of these are reached; the rules used.

    The rules are held against the states directly: of several rules that give the same transition the search keeps one.
    """
    packed = exploration.packed
    network = packed.network
    able = [_able(slot, known) for slot, known in zip(network.slots, labels, strict=True)]
    fired = [np.zeros_like(table) for table in able]
    reached = [np.zeros(slot.lts.states, np.bool_) for slot in network.slots]
    columns = [{label: i for i, label in enumerate(known)} for known in labels]
    moves = [
        [(slot, columns[slot][label]) for slot, label in rule.moves if label in columns[slot]] for rule in network.rules
    ]
    possible = [len(found) == len(rule.moves) for found, rule in zip(moves, network.rules, strict=True)]
    rules = np.zeros(len(network.rules), np.bool_)
    open_rules = [number for number, can in enumerate(possible) if can]
    for start in range(0, exploration.levels[-1], CHUNK):
        words = exploration.states_at(slice(start, min(exploration.levels[-1], start + CHUNK)))
        local = [_field(words, field) for field in packed.layout.slots]
        formats = _field(words, packed.layout.format)
        for slot, states in enumerate(local):
            reached[slot][states] = True
        left = []
        for number in open_rules:
            enabled = formats == network.rules[number].format
            for slot, column in moves[number]:
                enabled &= able[slot][local[slot], column]
            if enabled.any():
                rules[number] = True
                for slot, column in moves[number]:
                    fired[slot][local[slot][enabled], column] = True
            if not rules[number] or any((able[s][:, c] & ~fired[s][:, c]).any() for s, c in moves[number]):
                left.append(number)
        open_rules = left
    return fired, reached, rules


def _able(slot: Slot, labels: list[int]) -> BoolArray:
    """Which labels each local state has."""
    table = np.zeros((slot.lts.states, len(labels)), np.bool_)
    sources = np.repeat(np.arange(slot.lts.states), np.diff(slot.lts.offsets))
    table[sources, np.searchsorted(labels, slot.lts.labels)] = True
    return table


def _field(words: Int64Array, field: BitField) -> Int64Array:
    """A field of each of some packed states."""
    found: Int64Array = words[:, field.word] >> field.shift & (1 << field.width) - 1
    return found


class _Tracer:
    """Traces local steps back to the prefixes that perform them."""

    def __init__(self, network: Network, found: Happened) -> None:
        self._network = network
        self._found = found
        self._semantics = Semantics()
        self._seen: set[tuple[Process, int, Process]] = set()

    def slot(self, slot: Slot, fired: BoolArray, reached: BoolArray, labels: list[int]) -> None:
        """The steps of one component. *fired* has a row for each local state and a column for each label."""
        events = {label: self._event(label) for label in labels}
        self._found.able.update(event for event in events.values() if event not in (TAU, TICK))
        self._found.parts.append(ComponentActivity(slot.name, slot.span, bool(fired.any())))
        for state in np.flatnonzero(reached).tolist():
            term = slot.terms[state]
            row = fired[state]
            offers, changing = self._offers(term)
            self._found.offered |= offers
            missing = offers - self._found.performed
            if not missing:
                continue  # what the state does is performed by these prefixes, and each of them has been already
            wanted = {event for _, event in missing}
            for column, label in enumerate(labels):
                if row[column] and (changing or events[label] in wanted):
                    for target_label, target in slot.lts.successors(state):
                        if target_label == label:
                            self._trace(term, events[label], slot.terms[target])

    def _event(self, label: int) -> int:
        first = self._network.first_private_label
        return self._network.private_labels[label - first] if label >= first else label

    def _trace(self, term: Process, event: int, after: Process) -> None:
        """Note every prefix by which a step can come about; of several ways to the same step all are meant."""
        todo = [(term, event, after)]
        while todo:
            step = todo.pop()
            if step in self._seen:
                continue
            self._seen.add(step)
            if len(self._seen) > MOST_STEPS:
                raise TooManySteps
            part, event, after = step
            if isinstance(part, Prefix):
                self._found.performed.add((part, event))
            operands = part.active()
            if operands:
                todo += [(operands[i], *premise) for i, premise in self._premises(part, event, after)]

    def _premises(self, term: Process, event: int, after: Process) -> list[tuple[int, Step]]:
        """The steps of operands that a step can be made of."""
        rows = [self._semantics.transitions(operand) for operand in term.active()]

        def gives(chosen: list[Row]) -> bool:
            return (event, after) in self._semantics.applied(term, chosen)

        any_name = isinstance(term, _CHANGING) or event in (TAU, TICK)
        likely = [[step for step in row if any_name or step[0] == event] for row in rows]
        none: list[Row] = [()] * len(rows)
        alone = [
            (i, step) for i, row in enumerate(likely) for step in row if gives([*none[:i], (step,), *none[i + 1 :]])
        ]
        if alone:
            return alone
        # Several operands step together: whatever stands for one of them while the others do as they did.
        try:
            moves = derive(self._semantics, term, event, after).moves
        except NotDerivable:
            return []  # the tau with which a component under a parallel operator terminates early
        together = list(none)
        for i, move in moves:
            together[i] = ((move.event, move.after),)
        return [
            (i, step) for i, _ in moves for step in likely[i] if gives([*together[:i], (step,), *together[i + 1 :]])
        ]

    def _offers(self, term: Process) -> tuple[set[tuple[Process, int]], bool]:
        """The prefixes among which a state chooses, each with its events; whether these get other names on the way."""
        todo = [term]
        found: set[tuple[Process, int]] = set()
        changing = False
        while todo:
            current = todo.pop()
            if isinstance(current, Prefix):
                found.update((current, event) for event, _ in current.branches)
            changing = changing or isinstance(current, _CHANGING)
            todo.extend(current.active())
        return found, changing
