"""The parallel skeleton of a process as rules of one format, over the components that hang in it.

The skeleton is what parallel composition, hiding and renaming make of the top of a term; it never changes its
shape, so it is worked into the rules once. A compressed process is a component with a smaller machine, or is looked
through: it means what its operand means.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

from cspcheck.checker.lts import Lts
from cspcheck.checker.network.actions import Action, alphabetised, hidden, linked, parallel, projected, renamed
from cspcheck.checker.network.components import ALONE, JOINED, Alone, Joined
from cspcheck.checker.network.network import Network, Rule, Slot
from cspcheck.checker.semantics.transitions import Explored
from cspcheck.cspm.process.events import TICK
from cspcheck.cspm.process.terms import (
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


class Place(NamedTuple):
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
    place: Place


Explore = Callable[[Component], Explored]
"""The machine of a component."""
Compress = Callable[[Compressed, Alone | Joined], Lts | None]
"""The machine of a compressed process in a role, whose root is 0; None where it is better to look through it."""


def look_through(_: Compressed, __: Alone | Joined) -> None:
    """Compress nothing."""
    return


def compile_skeleton(
    process: Process, explore: Explore, compress: Compress = look_through, *, takes_apart: bool = True
) -> Network:
    """The network of one format for *process*; what *explore* raises ends the work.

    Args:
        process: the term.
        explore: explores a component.
        compress: gives the machine of a compressed component.
        takes_apart: if not, the process is the only component.

    Raises:
        TooManyActions: the components can act together in too many ways.
        ScriptError: a definition cannot be evaluated.
    """
    skeleton = _Skeleton(explore, compress)
    if takes_apart:
        with deep_recursion():
            actions = skeleton.actions(process, ALONE, Place())
    else:
        actions = skeleton.component(Component(process, ALONE, _named(process, Place())[1]))
    return Network(
        slots=tuple(skeleton.slots),
        rules=rules(actions),
        initial=tuple((slot, 0) for slot in range(len(skeleton.slots))),
        terminated=any(a.result == TICK for a in actions),
    )


def compile_single(process: Process, machine: Explored) -> Network:
    """The network whose only component is *process* as a whole."""
    return compile_skeleton(process, lambda _: machine, takes_apart=False)


def is_component(process: Process) -> bool:
    """Whether the skeleton of *process* is nothing but a component."""
    return not isinstance(_named(process, Place())[0], _OPERATORS)


def rules(actions: Iterable[Action]) -> tuple[Rule, ...]:
    """The actions as rules of format 0, ordered, and one of each kind: the one with the least cause."""
    causes: dict[tuple[int, tuple[tuple[int, int], ...]], int] = {}
    for a in actions:
        key = (a.result, a.moves)
        cause = causes.get(key)
        if cause is None or a.cause < cause:
            causes[key] = a.cause
    return tuple([Rule(result, moves, causes[result, moves]) for result, moves in sorted(causes)])


_OPERATORS = (Parallel, AlphabetisedParallel, LinkedParallel, Hide, Project, Rename)


def _named(process: Process, place: Place, stop: type[Process] = Process) -> tuple[Process, Place]:
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
    return process, place if own is None else Place(own.text, own.span)


class _Skeleton:
    def __init__(self, explore: Explore, compress: Compress) -> None:
        self._explore = explore
        self._compress = compress
        self.slots: list[Slot] = []
        self._parts: dict[Place, int] = {}

    def actions(self, named: Process, role: Alone | Joined, outer: Place) -> list[Action]:
        process, place = _named(named, outer, stop=Compressed)
        if isinstance(process, Compressed):
            machine = self._compress(process, role)
            if machine is not None:
                return self._compressed(process, machine, place)
            process, place = _named(named, outer)
        match process:
            case Parallel():
                return parallel(process.events, self._operands(process.operands, place))
            case AlphabetisedParallel():
                return alphabetised(process.alphabets, self._operands(process.operands, place))
            case LinkedParallel():
                left, right = self._operands((process.left, process.right), place)
                return linked(process.links, left, right)
            case Hide():
                return hidden(self.actions(process.process, role, place), process.events)
            case Project():
                return projected(self.actions(process.process, role, place), process.events)
            case Rename():
                return renamed(self.actions(process.process, role, place), process.pairs)
        return self.component(Component(named, role, place))

    def _operands(self, operands: Iterable[Process], place: Place) -> list[list[Action]]:
        return [self.actions(operand, JOINED, place._replace(is_part=True)) for operand in operands]

    def component(self, component: Component) -> list[Action]:
        slot = len(self.slots)
        machine = self._explore(component)
        self.slots.append(Slot(self._name(component.place), component.place.span, machine.lts, machine.terms))
        return [Action(label, label, ((slot, label),)) for label in machine.alphabet()]

    def _compressed(self, process: Compressed, lts: Lts, place: Place) -> list[Action]:
        slot = len(self.slots)
        terms = (process,) * lts.states
        self.slots.append(Slot(self._name(place), place.span, lts, terms, process))
        return [Action(label, label, ((slot, label),)) for label in lts.alphabet()]

    def _name(self, place: Place) -> str:
        """What to call a component: components that have no definition of their own are numbered in the one around."""
        if not place.is_part:
            return place.text or "the process"
        number = self._parts[place] = self._parts.get(place, 0) + 1
        return f"part {number} of {place.text}" if place.text else f"part {number}"
