"""Networks of several formats: compositions that change their shape, still explored as integers.

Each shape (``cspcheck.checker.network.shapes``) is a format. A component whose step leads to a term with parallel
parts has a private label for that step, and its rule switches to the format of the new shape. Formats, and what can
be in their holes, are found together: whatever can be in a hole when a format is left can be in the hole at the same
place of the next. ``cspcheck.checker.network.placement`` makes a network of them.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from cspcheck.checker.network import endings
from cspcheck.checker.network.actions import (
    MOST_ACTIONS,
    Action,
    Path,
    TooManyActions,
    alphabetised,
    hidden,
    linked,
    parallel,
    projected,
    renamed,
    together,
)
from cspcheck.checker.network.bounded_machines import FIRST_PRIVATE_LABEL, BoundedMachines, Entry
from cspcheck.checker.network.components import ComponentMachines, Interrupting, Joined
from cspcheck.checker.network.endings import Endings
from cspcheck.checker.network.shapes import (
    INTERRUPTS,
    JOINING,
    Ambiguous,
    Fillings,
    Hole,
    Shape,
    ShapeNode,
    Unsuited,
    holes,
    is_taken_apart,
    may_be,
    role_at,
)
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.cspm.process.events import TAU, TICK, EventSet
from cspcheck.cspm.process.terms import (
    NO_EVENTS,
    AlphabetisedParallel,
    Hide,
    Interrupt,
    LinkedParallel,
    Parallel,
    Process,
    Project,
    Rename,
    Sequential,
    SynchronisingInterrupt,
    Throw,
)

MOST_FORMATS = 2_000
MOST_INSIDE = 500
"""A term with parts but no more states than this is left whole where it runs inside a component."""

Changes = tuple[tuple[Path, Process], ...]
Started = tuple[tuple[Path, Entry], ...]


@dataclass(eq=False, slots=True)
class Format:
    """A shape, the components that can be in its holes, and what they can do in it.

    Attributes:
        number: formats are numbered in the order in which they are found.
        shape: what tells the format from others.
        places: a number for each hole that no other hole of any format has.
        entries: the components that can be in each hole.
        actions: what they can do; moves are (place, local label).
        nexts: what the changes of each action lead to.
    """

    number: int
    shape: Shape
    places: Mapping[Path, int]
    entries: dict[Path, dict[Entry, None]]
    actions: list[Action] = field(default_factory=list)
    nexts: dict[Changes, FormatSuccessor] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, slots=True)
class FormatSuccessor:
    """What a change leads to.

    Attributes:
        format: the format afterwards.
        cleared: holes of the format before that are left behind; what is in the others stays where it is.
        started: holes of the format afterwards that are filled anew.
    """

    format: Format
    cleared: tuple[Path, ...]
    started: Started


class Formats:
    """The formats that a process can be in.

    Args:
        process: any term.
        semantics: the transitions of terms.
        machines: components explored before.
        small: a term inside a component that has parts but no more states than this is left whole.
        most: how many states a component may have.

    Attributes:
        all: the formats; the first is the one of the process itself.
        started: what is in the holes of the first format initially.
        machines: the machines of the components.

    Raises:
        Ambiguous: a term left whole because it is small may also be reached in parts; with *small* 0 it may work.
        Unsuited: the process has no such formats, or too many of them, or a component is too large.
        ScriptError: a definition cannot be evaluated.
    """

    def __init__(
        self, process: Process, semantics: Semantics, machines: ComponentMachines, small: int, most: int
    ) -> None:
        self.all: list[Format] = []
        self.machines = BoundedMachines(semantics, machines, min(small, MOST_INSIDE), most)
        self._semantics = semantics
        self._by_shape: dict[Shape, Format] = {}
        self._places = 0
        shape, fillings = self.machines.shapes.of(semantics.state(process))
        initial = self._format(shape)
        self.started = _started(shape, fillings)
        for path, entry in self.started:
            initial.entries[path][entry] = None
        self._find_all(initial)
        self._require_unique_states()

    def _find_all(self, initial: Format) -> None:
        pending = deque([initial])
        try:
            while pending:
                for changed in self._extend(pending.popleft()):
                    if changed not in pending:
                        pending.append(changed)
        except TooManyActions:
            raise Unsuited("components can act together in too many ways") from None

    def _format(self, shape: Shape) -> Format:
        found = self._by_shape.get(shape)
        if found is None:
            if len(self.all) == MOST_FORMATS:
                raise Unsuited("there are too many shapes")
            paths = [path for path, _ in holes(shape)]
            places = {path: self._places + i for i, path in enumerate(paths)}
            self._places += len(paths)
            found = self._by_shape[shape] = Format(len(self.all), shape, places, {path: {} for path in paths})
            self.all.append(found)
        return found

    def _extend(self, format: Format) -> list[Format]:
        """Work out what a format can do; the formats in whose holes more can be now."""
        self.machines.poll()
        format.actions = self._actions(format, format.shape, ())
        if sum(len(other.actions) for other in self.all) > MOST_ACTIONS:
            raise TooManyActions
        for action in format.actions:
            if action.changes and action.changes not in format.nexts:
                format.nexts[action.changes] = self._next(format, action.changes)
        changed: dict[Format, None] = {}
        for after in format.nexts.values():
            staying = [(path, entry) for path in kept(format, after) for entry in format.entries[path]]
            for path, entry in (*after.started, *staying):
                entries = after.format.entries[path]
                if entry not in entries:
                    entries[entry] = None
                    changed[after.format] = None
        return list(changed)

    def _next(self, format: Format, changes: Changes) -> FormatSuccessor:
        shape, positions, fillings = self.machines.shapes.replaced(format.shape, changes)
        cleared = [path for path in format.entries if any(path[: len(p)] == p for p in positions)]
        return FormatSuccessor(self._format(shape), tuple(cleared), _started(shape, fillings))

    def _actions(self, format: Format, shape: Shape, path: Path) -> list[Action]:
        """What the part of a format at *path* can do."""
        if isinstance(shape, Hole):
            return self._steps(format, path, shape)
        operator = shape.template
        operands = [self._actions(format, child, (*path, i)) for i, child in enumerate(shape.children)]
        match operator:
            case Parallel():
                self._require_distributed_termination(format, shape, path, operands)
                return parallel(operator.events, operands)
            case AlphabetisedParallel():
                self._require_distributed_termination(format, shape, path, operands)
                return alphabetised(operator.alphabets, operands)
            case LinkedParallel():
                self._require_distributed_termination(format, shape, path, operands)
                return linked(operator.links, *operands)
            case Hide():
                return hidden(operands[0], operator.events)
            case Project():
                return projected(operands[0], operator.events)
            case Rename():
                return renamed(operands[0], operator.pairs)
            case Sequential():
                after = ((path, self._semantics.state(operator.right)),)
                return [Action(TAU, TAU, a.moves, after) if a.result == TICK else a for a in operands[0]]
            case Throw():
                after = ((path, self._semantics.state(operator.right)),)
                return [a._replace(changes=after) if a.result in operator.events else a for a in operands[0]]
            case Interrupt():
                return [*operands[0], *operands[1]]
            case SynchronisingInterrupt():
                return _synchronised_interrupt(operator, *operands)
        raise AssertionError(f"{type(operator).__name__} is no operator of shapes")

    def _steps(self, format: Format, path: Path, hole: Hole) -> list[Action]:
        """What the component in a hole can do."""
        place = format.places[path]
        # What the right of an interrupt leads to is instead of the whole interrupt.
        replaced = path[:-1] if isinstance(hole.role, Interrupting) else path
        labels = {label for entry in format.entries[path] for label in self.machines.alphabet(entry)}
        steps = []
        for label in sorted(labels):
            if label < FIRST_PRIVATE_LABEL:
                steps.append(Action(label, label, ((place, label),)))
            else:
                event, after = self.machines.meaning(label)
                steps.append(Action(event, event, ((place, label),), ((replaced, after),)))
        return steps

    def _require_distributed_termination(
        self, format: Format, node: ShapeNode, path: Path, operands: Sequence[Sequence[Action]]
    ) -> None:
        """Make sure that the operands of a parallel operator tick only where they can do nothing else, or wait.

        Raises:
            Unsuited: one may not.
        """
        assert isinstance(node.template, JOINING)
        clocks = node.template.clocks
        for i, (child, actions) in enumerate(zip(node.children, operands, strict=True)):
            if not any(a.result == TICK for a in actions):
                continue
            if not _ticks_at_the_end(child):
                raise Unsuited("an interrupt under a parallel operator can terminate")
            if clocks and endings.ends_alone(self._endings(format, child, (*path, i), clocks)):
                raise Unsuited("a composition under a parallel operator can terminate before the others")

    def _endings(self, format: Format, shape: Shape, path: Path, clocks: EventSet) -> Endings:
        """How the part of a format at *path*, which ticks at its end, can end under an operator with clocks."""
        if isinstance(shape, Hole):
            machines = self.machines
            return endings.union(
                endings.of_machine(machines.of(entry).lts, clocks, machines.private_labels, FIRST_PRIVATE_LABEL)
                for entry in format.entries[path]
            )
        operator = shape.template
        if isinstance(operator, (Sequential, *INTERRUPTS)):
            return frozenset()  # interrupts that can tick are not taken apart here
        operands = [self._endings(format, child, (*path, i), clocks) for i, child in enumerate(shape.children)]
        if isinstance(operator, JOINING):
            return endings.together(operator, operands)
        return frozenset((NO_EVENTS,)) if operands[0] and endings.touches(operator, clocks) else operands[0]

    def _require_unique_states(self) -> None:
        """Make sure that no term is a state of two formats.

        A term with parts that was left whole because it is small could also be reached in parts.

        Raises:
            Ambiguous: that may be so.
        """
        whole = {
            (format, path): terms
            for format in self.all
            for path, entries in format.entries.items()
            if (terms := [t for entry in entries for t in self.machines.of(entry).terms if is_taken_apart(t)])
        }
        for format in {format for format, _ in whole}:
            for other in self.all:
                if other is not format and _overlap(format, format.shape, other, other.shape, (), whole):
                    raise Ambiguous("a small component could also be reached in parts")


def kept(format: Format, after: FormatSuccessor) -> list[Path]:
    """The holes of a format in which the components stay when it is followed by another."""
    return [path for path in format.entries if path not in after.cleared]


def _started(shape: Shape, fillings: Fillings) -> Started:
    return tuple([(path, (role_at(shape, path), term)) for path, term in fillings])


def _ticks_at_the_end(shape: Shape) -> bool:
    if isinstance(shape, Hole):
        return isinstance(shape.role, Joined)
    if isinstance(shape.template, (*JOINING, Sequential)):
        return True
    return not isinstance(shape.template, INTERRUPTS) and _ticks_at_the_end(shape.children[0])


def _synchronised_interrupt(
    operator: SynchronisingInterrupt, left: Sequence[Action], right: Sequence[Action]
) -> list[Action]:
    both = operator.events
    actions = [a for a in (*left, *right) if a.result not in both]
    partners: dict[int, list[Action]] = {}
    for b in right:
        partners.setdefault(b.result, []).append(b)
    for a in left:
        if a.result in both:
            actions.extend([together(a.result, (a, b)) for b in partners.get(a.result, ())])
    return actions


def _overlap(
    one: Format,
    one_part: Shape,
    other: Format,
    other_part: Shape,
    path: Path,
    whole: dict[tuple[Format, Path], list[Process]],
) -> bool:
    """Whether a term could be a state of both formats, as far as the parts at *path* tell."""
    match one_part, other_part:
        case Hole(), Hole():
            return True
        case Hole(), ShapeNode():
            return any(may_be(other_part, term) for term in whole.get((one, path), ()))
        case ShapeNode(), Hole():
            return any(may_be(one_part, term) for term in whole.get((other, path), ()))
        case ShapeNode(), ShapeNode():
            return one_part.template is other_part.template and all(
                _overlap(one, a, other, b, (*path, i), whole)
                for i, (a, b) in enumerate(zip(one_part.children, other_part.children, strict=True))
            )
    raise AssertionError
