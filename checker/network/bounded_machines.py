"""Machines of components up to where a component becomes something with parts of its own.

The steps that lead beyond have private labels, one for each event and term that follows; where they lead is told by
the network's rules (``cspcheck.checker.network.formats``), so in the component's own machine they lead nowhere new.
"""

from __future__ import annotations

from collections.abc import Callable

from cspcheck.checker.network.components import ComponentMachines, Interrupting, Joined, Role, joined
from cspcheck.checker.network.shapes import Hole, Shapes, Unsuited
from cspcheck.checker.semantics.steps import Row, Step
from cspcheck.checker.semantics.transitions import Explored, MoreStates, Semantics, breadth_first
from cspcheck.cspm.process.events import TAU, TICK
from cspcheck.cspm.process.terms import Process

FIRST_PRIVATE_LABEL = 3 << 61
"""Above every event and within 63 bits."""

Entry = tuple[Role, Process]
"""A component as it starts: its role and its term."""


class BoundedMachines:
    """The machines of components in a network of formats.

    Args:
        semantics: the transitions of terms.
        machines: tells which terms are small.
        small: a term with parts but no more states than this is a component's state like any other.
        most: how many states a component may have.
    """

    def __init__(self, semantics: Semantics, machines: ComponentMachines, small: int, most: int) -> None:
        self.shapes = Shapes(self.is_small)
        self._semantics = semantics
        self._machines = machines
        self._small = small
        self._most = most
        self._known: dict[Entry, Explored] = {}
        self._alphabets: dict[Entry, tuple[int, ...]] = {}
        self._inside: dict[Process, bool] = {}
        self._private: dict[Step, int] = {}
        self._meanings: list[Step] = []

    def is_small(self, term: Process) -> bool:
        """Whether a term is left whole though it has parts."""
        return self._machines.has_at_most(term, self._small)

    def of(self, entry: Entry) -> Explored:
        """The machine of a component from its start.

        Raises:
            Unsuited: it has too many states.
        """
        found = self._known.get(entry)
        if found is None:
            role, term = entry
            try:
                found = breadth_first(term, self._successors(role), self._most, self._machines.poll)
            except MoreStates:
                raise Unsuited("a component has too many states") from None
            self._known[entry] = found
            self._alphabets[entry] = found.alphabet()
        return found

    def alphabet(self, entry: Entry) -> tuple[int, ...]:
        """The labels of a component's machine, ascending."""
        self.of(entry)
        return self._alphabets[entry]

    def meaning(self, label: int) -> Step:
        """The event and the term after it that a private label stands for."""
        return self._meanings[label - FIRST_PRIVATE_LABEL]

    def poll(self) -> None:
        """Give whoever watches the time a chance to end the work."""
        if self._machines.poll is not None:
            self._machines.poll(sum(len(machine.terms) for machine in self._known.values()))

    @property
    def private_labels(self) -> tuple[int, ...]:
        """The event of each private label."""
        return tuple(event for event, _ in self._meanings)

    def _successors(self, role: Role) -> Callable[[Process], list[Step]]:
        transitions = self._semantics.transitions

        def successors(term: Process) -> list[Step]:
            row: Row | list[Step] = transitions(term)
            if isinstance(role, Joined):
                row = joined(transitions(term), role.clocks)
            steps = []
            for event, after in row:
                if event == TICK:
                    steps.append((TICK, term))
                elif self._stays(role, event, after):
                    steps.append((event, after))
                else:
                    steps.append((self._label(event, after), term))
            return steps

        return successors

    def _stays(self, role: Role, event: int, after: Process) -> bool:
        """Whether the component goes on as one of its own states."""
        if isinstance(role, Interrupting):
            return event == TAU or event in role.events
        inside = self._inside.get(after)
        if inside is None:
            inside = (
                not self.shapes.has_parts(after) or isinstance(self.shapes.of(after)[0], Hole) or self.is_small(after)
            )
            self._inside[after] = inside
        return inside

    def _label(self, event: int, after: Process) -> int:
        step = (event, after)
        label = self._private.get(step)
        if label is None:
            label = self._private[step] = FIRST_PRIVATE_LABEL + len(self._meanings)
            self._meanings.append(step)
        return label
