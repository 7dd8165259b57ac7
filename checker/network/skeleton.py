"""The parallel skeleton of a process as rules of one format, over the components that hang in it.

The skeleton is what parallel composition, hiding and renaming make of the top of a term; it never changes its
shape, so it is worked into the rules once. A compressed process that runs as a machine is a component; any other is
looked through: it means what its operand means.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from cspcheck.checker.lts import Lts
from cspcheck.checker.network import endings
from cspcheck.checker.network.actions import Action, alphabetised, hidden, linked, parallel, projected, renamed
from cspcheck.checker.network.components import ALONE, Alone, Joined
from cspcheck.checker.network.endings import Endings
from cspcheck.checker.network.network import Network, Rule, Slot
from cspcheck.checker.network.shapes import JOINING, STATIC_UNARY
from cspcheck.checker.semantics.menus import unlike_menus
from cspcheck.checker.semantics.transitions import Explored
from cspcheck.cspm.process.events import TICK
from cspcheck.cspm.process.terms import (
    NO_EVENTS,
    AlphabetisedParallel,
    Compressed,
    Hide,
    LinkedParallel,
    Parallel,
    Process,
    Project,
    Reference,
    Rename,
)
from cspcheck.cspm.recursion import deep_recursion
from cspcheck.cspm.source import Span


class ScriptPlace(NamedTuple):
    """Where a component is in the script: in the last definition on the way to it.

    Attributes:
        text: the definition as it is called, or "" where there is none.
        span: where it is defined.
        is_part: whether the definition has a parallel operator between itself and the component.
    """

    text: str = ""
    span: Span | None = None
    is_part: bool = False


class Component(NamedTuple):
    """A term that the skeleton does not take apart."""

    process: Process
    role: Alone | Joined
    place: ScriptPlace


Explore = Callable[[Component], Explored]
"""The machine of a component."""
Told = Callable[[Process], bool]
"""Says something of a term."""


def never(_: Process) -> bool:
    """Says no."""
    return False


def compile_skeleton(
    process: Process,
    explore: Explore,
    is_machine: Told = never,
    has_machines: Told = never,
    *,
    takes_apart: bool = True,
) -> Network:
    """The network of one format for *process*; what *explore* raises ends the work.

    Args:
        process: the term.
        explore: explores a component.
        is_machine: tells which compressed processes run as a machine.
        has_machines: tells in which states of a component a machine takes part.
        takes_apart: if not, the process is the only component.

    Raises:
        TooManyActions: the components can act together in too many ways.
        ScriptError: a definition cannot be evaluated.
    """
    skeleton = _Skeleton(explore, is_machine, has_machines)
    if takes_apart:
        with deep_recursion():
            actions = skeleton.part(process, ALONE, ScriptPlace()).actions
    else:
        actions = skeleton.component(Component(process, ALONE, _named(process, ScriptPlace())[1])).actions
    return skeleton.network(actions)


def compile_parts(
    process: Process, explore: Explore, is_machine: Told = never, has_machines: Told = never
) -> tuple[Network, tuple[Component, ...]]:
    """The network of :func:`compile_skeleton`, and what stands in each of its slots."""
    skeleton = _Skeleton(explore, is_machine, has_machines)
    with deep_recursion():
        actions = skeleton.part(process, ALONE, ScriptPlace()).actions
    return skeleton.network(actions), tuple(skeleton.components)


def compile_single(process: Process, machine: Explored, has_machines: Told = never) -> Network:
    """The network whose only component is *process* as a whole."""
    return compile_skeleton(process, lambda _: machine, has_machines=has_machines, takes_apart=False)


def is_component(process: Process) -> bool:
    """Whether the skeleton of *process* is nothing but a component."""
    return not isinstance(_named(process, ScriptPlace())[0], _OPERATORS)


def rules(actions: Iterable[Action]) -> tuple[Rule, ...]:
    """The actions as rules of format 0, ordered, and one of each kind: the one with the least cause."""
    causes: dict[tuple[int, tuple[tuple[int, int], ...]], int] = {}
    for a in actions:
        key = (a.result, a.moves)
        cause = causes.get(key)
        if cause is None or a.cause < cause:
            causes[key] = a.cause
    return tuple([Rule(result, moves, causes[result, moves]) for result, moves in sorted(causes)])


_OPERATORS = (*JOINING, *STATIC_UNARY)


def _named(process: Process, place: ScriptPlace, stop: type[Process] = Process) -> tuple[Process, ScriptPlace]:
    """What stands behind names and compressions, and the place that the first of the names is.

    Ends at the first compression if *stop* is their class.
    """
    own: Reference | None = None
    while isinstance(process, (Reference, Compressed)):
        if isinstance(process, Reference):
            own = own or process
            process = process.body()
        elif stop is Compressed:
            break
        else:
            process = process.process
    return process, place if own is None else ScriptPlace(own.text, own.span)


class _Part(NamedTuple):
    """What a part of the skeleton can do, and, where it is an operand and there are clocks, how it can end."""

    actions: list[Action]
    endings: Endings


def _endings(lts: Lts, role: Alone | Joined) -> Endings:
    return endings.of_machine(lts, role.clocks) if isinstance(role, Joined) and role.clocks else frozenset()


def _composed(operator: Process, role: Alone | Joined, operands: Sequence[_Part]) -> _Part:
    actions = [operand.actions for operand in operands]
    ends: Endings = frozenset()
    if isinstance(role, Joined) and role.clocks:
        ends = endings.together(operator, [operand.endings for operand in operands])
    match operator:
        case Parallel():
            return _Part(parallel(operator.events, actions), ends)
        case AlphabetisedParallel():
            return _Part(alphabetised(operator.alphabets, actions), ends)
        case LinkedParallel():
            return _Part(linked(operator.links, *actions), ends)
    raise AssertionError(f"{type(operator).__name__} is no parallel operator")


class _Skeleton:
    def __init__(self, explore: Explore, is_machine: Told, has_machines: Told) -> None:
        self._explore = explore
        self._is_machine = is_machine
        self._has_machines = has_machines
        self.slots: list[Slot] = []
        self.components: list[Component] = []
        self._parts: dict[ScriptPlace, int] = {}

    def network(self, actions: Iterable[Action]) -> Network:
        """The network of one format with these actions."""
        actions = list(actions)
        return Network(
            slots=tuple(self.slots),
            rules=rules(actions),
            initial=tuple((slot, 0) for slot in range(len(self.slots))),
            terminated=any(a.result == TICK for a in actions),
        )

    def part(self, named: Process, role: Alone | Joined, outer: ScriptPlace) -> _Part:
        """A part of the term: taken apart, unless it may end by itself while it can do something else."""
        slots, parts = len(self.slots), dict(self._parts)
        found = self._taken_apart(named, role, outer)
        if endings.ends_alone(found.endings):
            del self.slots[slots:]
            del self.components[slots:]
            self._parts = parts
            return self.component(Component(named, role, _named(named, outer)[1]))
        return found

    def _taken_apart(self, named: Process, role: Alone | Joined, outer: ScriptPlace) -> _Part:
        process, place = _named(named, outer, stop=Compressed)
        while isinstance(process, Compressed):
            if self._is_machine(process):
                return self.component(Component(process, role, place))
            process, place = _named(process.process, place, stop=Compressed)
        if isinstance(process, JOINING):
            below, here = Joined(process.clocks), place._replace(is_part=True)
            return _composed(process, role, [self.part(operand, below, here) for operand in process.active()])
        if not isinstance(process, STATIC_UNARY):
            return self.component(Component(named, role, place))
        actions, ends = self.part(process.process, role, place)
        if isinstance(role, Joined) and ends and endings.touches(process, role.clocks):
            ends = frozenset((NO_EVENTS,))  # as a whole it may do otherwise than what is inside
        match process:
            case Hide():
                return _Part(hidden(actions, process.events), ends)
            case Project():
                return _Part(projected(actions, process.events), ends)
            case Rename():
                return _Part(renamed(actions, process.pairs), ends)
        raise AssertionError(f"{type(process).__name__} is no operator of the skeleton")

    def component(self, component: Component) -> _Part:
        slot = len(self.slots)
        self.components.append(component)
        machine = self._explore(component)
        place = component.place
        compressed = None
        if self._has_machines is not never and any(self._has_machines(term) for _, term in unlike_menus(machine.terms)):
            compressed = component.process
        self.slots.append(Slot(self._name(place), place.span, machine.lts, machine.terms, compressed))
        actions = [Action(label, label, ((slot, label),)) for label in machine.alphabet()]
        return _Part(actions, _endings(machine.lts, component.role))

    def _name(self, place: ScriptPlace) -> str:
        """What to call a component: components that have no definition of their own are numbered in the one around."""
        if not place.is_part:
            return place.text or "the process"
        number = self._parts[place] = self._parts.get(place, 0) + 1
        return f"part {number} of {place.text}" if place.text else f"part {number}"
