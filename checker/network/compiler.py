"""From a process term to a network: parallel composition becomes rules, what is composed becomes components.

A priority at the top is said of the rules (``cspcheck.checker.network.priority``). For the rest there are three ways,
from fast to slow, all with the same states and transitions:

1. Parallel, hiding and renaming at the top of the term become the rules of a network of one format, whose
   components are explored by themselves (``cspcheck.checker.network.skeleton``).
2. Where a component is large because there are parallel compositions further inside (``(A ||| B) ; C``,
   ``init -> SYSTEM``), the network has formats (``cspcheck.checker.network.formats``).
3. What fits neither is explored as terms and becomes a network of a single component.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence

from cspcheck.checker.network.actions import TooManyActions
from cspcheck.checker.network.chased import MOST_LOCAL, Chases, NotChasable as NotChased
from cspcheck.checker.network.components import ALONE, ComponentMachines
from cspcheck.checker.network.formats import Formats
from cspcheck.checker.network.lazily import LazyComposition, is_chased
from cspcheck.checker.network.network import Network
from cspcheck.checker.network.placement import network_of
from cspcheck.checker.network.priority import at_the_top
from cspcheck.checker.network.shapes import Ambiguous, Parts, Unsuited
from cspcheck.checker.network.skeleton import (
    Component,
    Explore,
    compile_single,
    compile_skeleton,
    is_component,
)
from cspcheck.checker.semantics.growth import beyond, too_many
from cspcheck.checker.semantics.machine_states import MachineParts
from cspcheck.checker.semantics.menus import unlike_menus
from cspcheck.checker.semantics.transitions import Explored, LimitReached, MoreStates, Poll, Semantics
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.process.terms import MachineState, Process

__all__ = ["MOST_TERMS", "SLOT_STATES", "Compiler", "LimitReached", "compile_network"]

FEW = (24, 256)
"""A component with more states than this by itself is left, to see whether the whole has as many."""
SMALL = 2_000
"""A component with parallel parts and more states than this is taken apart if it can be."""
LISTED_IN_COMPANY = 2_000
"""A composition in which something is chased is listed up to so many states; of a larger one no more is worked out than
what the whole gets to see of what is chased."""
SLOT_STATES = 20_000
"""A component of a network with parts is explored so far before other ways are tried."""
MOST_TERMS = 500_000
"""So many states are explored as terms where no limit is given: less than a gigabyte and about fifteen seconds."""
BYTES_PER_TERM = 1_500
"""What a state explored as a term takes, all told."""


Company = Callable[[LazyComposition, Limits, Poll | None], Network]
"""The network of a composition with what the whole gets to see of what is chased; raises ``LimitReached``."""


class Compiler:
    """Compiles the processes of one script; a component is explored once whoever uses it.

    Args:
        slot_states: how far a component is explored before other ways are tried.
        semantics: the transitions of terms; by default as the operators say.
        chases: what is chased; by default that is worked out for this compiler.
        company: gives the network of a composition in which something is chased, where that is large; by default its
            states are listed here.
    """

    def __init__(
        self,
        *,
        slot_states: int = SLOT_STATES,
        semantics: Semantics | None = None,
        chases: Chases | None = None,
        company: Company | None = None,
    ) -> None:
        self._company = company
        self._limits = Limits()
        self.chases = chases or Chases(self._inside_chase, lambda: self.semantics)
        self.semantics = semantics or Semantics(ahead=self.chases.row)
        self._slot_states = slot_states
        self._machines = ComponentMachines(self.semantics, self.chases.explorer)
        self._has_machines = MachineParts()
        self._has_parts = Parts()

    def network(
        self,
        process: Process,
        limits: Limits = Limits(),  # noqa: B008
        poll: Poll | None = None,
    ) -> Network:
        """The network that has the states and transitions of *process*.

        Args:
            process: any term.
            limits: ``states`` and ``memory_bytes`` also bound what is explored as terms; if ``states`` is None,
                no more than ``MOST_TERMS`` are.
            poll: called now and then with a number of states explored as terms; what it raises ends the work.

        Raises:
            LimitReached: a component, or what fits no network, has more states than the limit.
            ScriptError: a definition calls itself before any event, or cannot be evaluated.
        """
        most = min(MOST_TERMS if limits.states is None else limits.states, _terms_in(limits.memory_bytes))
        # Machines of parts are compiled in the middle of the compilation of the whole.
        outer, limited = self._machines.poll, self._limits
        self._machines.poll, self._limits = poll, limits
        self.semantics.state(process)
        try:
            return self._prioritised(process, most) or self._network(process, most)
        except TooManyActions:
            return self._single(process, most)
        finally:
            self._machines.poll, self._limits = outer, limited

    def _prioritised(self, process: Process, most: int) -> Network | None:
        """The network of a priority over a composition, with the rules of the composition; None if it is no such thing.

        Compressions inside are looked through: most of them change what a priority sees.
        """
        priority = at_the_top(process)
        if priority is None or isinstance(self.semantics.state(process), MachineState):
            return None
        plain = Compiler(slot_states=self._slot_states)
        if not self._has_parts(plain.semantics.state(priority.operand)):
            return None
        try:
            for few in (*FEW, SMALL, 10 * SMALL):
                few = min(few, self._slot_states, most)
                try:
                    return priority.over(plain._composed(priority.operand, few))
                except _TooLarge:
                    pass
                try:
                    # A priority may leave next to nothing of components that have nearly no end.
                    return self._single(process, few)
                except LimitReached:
                    pass
            return priority.over(plain._network(priority.operand, most))
        except (TooManyActions, LimitReached):
            # Without the priority there may be no end to it.
            return None

    def _inside_chase(self, component: Component) -> Explored:
        """A component of what is chased."""
        return self._machines.of(self.semantics.state(component.process), component.role, MOST_LOCAL)

    def _chased(self, process: Process, most: int) -> Network | None:
        """The network of a composition in which something is chased; None if it is no such thing."""
        if not is_chased(process):
            return None
        slot_states = min(self._slot_states, most)
        try:
            composition = LazyComposition(
                process,
                self.chases,
                self.semantics,
                lambda component: self._explored(component, slot_states),
                self._is_machine,
                self._has_machines,
            )
        except (NotChased, _TooLarge):
            return None
        compressed = any(slot.compressed is not None for slot in composition.network.slots)
        try:
            few = most if self._company is None else min(most, LISTED_IN_COMPANY)
            machine = composition.explored(few, self._machines.poll)
        except MoreStates as more:
            if self._company is not None and most > few:
                return self._company(composition, self._limits, self._machines.poll)
            try:
                return self._composed(process, slot_states)
            except _TooLarge:
                raise beyond(process, len(more.terms)) from None
        return compile_single(process, machine, lambda _: True) if compressed else compile_single(process, machine)

    def _network(self, process: Process, most: int) -> Network:
        chased = self._chased(process, most)
        if chased is not None:
            return chased
        slot_states = min(self._slot_states, most)
        small = min(SMALL, slot_states)
        # The whole and its parts in turns: a part that has no end, or nearly none, may get nowhere in company.
        for few in FEW:
            try:
                return self._composed(process, min(few, small))
            except _TooLarge:
                if not is_component(process):
                    try:
                        return self._single(process, min(few, small))
                    except LimitReached:
                        pass
        try:
            return self._skeleton(process, lambda component: self._without_parts(component, small, slot_states))
        except _TooLarge as large:
            has_parts = large.has_parts
        if has_parts:
            try:
                return self._of_formats(process, small)
            except Unsuited:
                pass
            try:
                return self._composed(process, slot_states)
            except _TooLarge:
                pass
        # A component may be endless by itself and not in company: a counter that the others keep in bounds.
        if not is_component(process):
            try:
                return self._single(process, slot_states)
            except LimitReached:
                pass
        try:
            return self._composed(process, most)
        except _TooLarge as large:
            raise too_many(large.component.process, large.terms, self.semantics.heads) from None

    def _composed(self, process: Process, most: int) -> Network:
        """The network of one format, whose components have at most so many states."""
        return self._skeleton(process, lambda component: self._explored(component, most))

    def _skeleton(self, process: Process, explore: Explore) -> Network:
        return compile_skeleton(process, explore, self._is_machine, self._has_machines)

    def _is_machine(self, process: Process) -> bool:
        """Whether a compressed process runs as a machine."""
        return isinstance(self.semantics.state(process), MachineState)

    def _of_formats(self, process: Process, small: int) -> Network:
        """The network of formats."""
        try:
            formats = Formats(process, self.semantics, self._machines, small, SLOT_STATES)
        except Ambiguous:
            formats = Formats(process, self.semantics, self._machines, 0, SLOT_STATES)
        return network_of(formats, self.semantics.heads, self._has_machines)

    def _without_parts(self, component: Component, small: int, most: int) -> Explored:
        """The machine of a component, which may have *most* states; with parallel parts inside only *small*."""
        try:
            return self._explored(component, small)
        except _TooLarge as large:
            if large.has_parts:
                raise
        return self._explored(component, most)

    def _explored(self, component: Component, most: int) -> Explored:
        try:
            return self._machines.of(self.semantics.state(component.process), component.role, most)
        except MoreStates as more:
            raise _TooLarge(component, more.terms) from None

    def _single(self, process: Process, most: int) -> Network:
        """The network of one component that is the whole."""
        try:
            machine = self._machines.of(self.semantics.state(process), ALONE, most)
        except MoreStates as more:
            raise too_many(process, more.terms, self.semantics.heads) from None
        return compile_single(process, machine, self._has_machines)


def _terms_in(memory_bytes: int | None) -> int:
    """How many terms a memory limit has room for; without one, half of the machine's memory."""
    if memory_bytes is None:
        try:
            memory_bytes = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2
        except (AttributeError, ValueError, OSError):  # the system does not tell
            memory_bytes = 1 << 32
    return max(1, memory_bytes // BYTES_PER_TERM)


class _TooLarge(Exception):
    """A component has more states than it may; ``terms`` are those up to there."""

    def __init__(self, component: Component, terms: Sequence[Process]) -> None:
        super().__init__(component.place.text)
        self.component = component
        self.terms = terms

    @property
    def has_parts(self) -> bool:
        """Whether parallel compositions were met inside the component."""
        has_parts = Parts()
        return any(has_parts(term) for _, term in unlike_menus(self.terms))


def compile_network(
    process: Process,
    limits: Limits = Limits(),  # noqa: B008  (immutable)
    *,
    slot_states: int = SLOT_STATES,
    poll: Poll | None = None,
) -> Network:
    """The network that has the states and transitions of *process*. See :meth:`Compiler.network`."""
    return Compiler(slot_states=slot_states).network(process, limits, poll)
