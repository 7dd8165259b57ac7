"""A process while it runs, as terms: its state, the components it is made of, and what each does in a step.

The components are what hangs in the parallel operators of the state, at whatever depth (``(A ||| B) ; C`` has A and B,
and after they have ended C). Nothing is explored: every state is looked at when the process gets there, so a process
may have any number of states.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from cspcheck.checker.network.actions import Path
from cspcheck.checker.network.shapes import INTERRUPTS, JOINING, STATIC_UNARY, UNARY, template
from cspcheck.checker.semantics.derivation import Derivation, derive
from cspcheck.checker.semantics.steps import Row
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.cspm.process.events import TICK
from cspcheck.cspm.process.terms import Compressed, Fused, Prioritised, Process, Reference, Sequential, Throw
from cspcheck.cspm.recursion import deep_recursion
from cspcheck.cspm.source import Span


@dataclass(frozen=True, eq=False, slots=True)
class RunningComponent:
    """A part of a running composition.

    Attributes:
        name: what it is called in the script; several may be called the same.
        span: where it is defined, if it has a definition.
    """

    name: str
    span: Span | None


@dataclass(frozen=True, slots=True)
class InnermostDefinition:
    """The innermost definition around a term, and whether an operator with several operands is between."""

    text: str = ""
    span: Span | None = None
    is_part: bool = False


@dataclass(frozen=True, slots=True)
class RunningTree:
    """How components hang together: a component, or the operands of an operator of the state.

    ``place`` is where the component or operator was written.
    """

    component: RunningComponent | None
    place: InnermostDefinition
    children: tuple[RunningTree, ...] = ()


@dataclass(frozen=True, slots=True)
class Running:
    """A process at some point of a run: the term that it is now, and the components of that term."""

    state: Process
    tree: RunningTree

    def components(self) -> list[tuple[RunningComponent, Process]]:
        """The components and the terms that they are now, from left to right."""
        return list(_components(self.tree, self.state))


@dataclass(frozen=True, slots=True)
class Performed:
    """What happened in one step.

    Attributes:
        event: what the whole performed.
        cause: for a tau the event that was hidden or linked in it, if one was.
        parts: what each component that took part performed itself.
    """

    event: int
    cause: int | None
    parts: dict[RunningComponent, int]


def _components(tree: RunningTree, state: Process) -> Iterator[tuple[RunningComponent, Process]]:
    if tree.component is not None:
        yield tree.component, state
        return
    for child, operand in zip(tree.children, state.active(), strict=True):
        yield from _components(child, operand)


_DESCENDED = (*UNARY, *INTERRUPTS, Prioritised)


def is_composed(state: Process) -> bool:
    """Whether there is a parallel composition among the operators that decide what a state does next."""
    if isinstance(state, JOINING):
        return True
    return isinstance(state, _DESCENDED) and any(map(is_composed, state.active()))


class Runner:
    """Performs processes step by step.

    A component that comes again where it was before (``Loop = (A ||| B) ; Loop``) is the same component.
    """

    def __init__(self, semantics: Semantics | None = None) -> None:
        self.semantics = semantics or Semantics()
        self._known: dict[tuple[Path, InnermostDefinition], RunningComponent] = {}
        self._parts: Counter[InnermostDefinition] = Counter()

    def start(self, process: Process) -> Running:
        """A process before its first step.

        Raises:
            ScriptError: a definition calls itself before any event, or cannot be evaluated.
        """
        state = self.semantics.state(process)
        with deep_recursion():
            return Running(state, self._tree(process, state, InnermostDefinition(), ()))

    def steps(self, running: Running) -> Row:
        """The (event, state) pairs that the process can go on with, by event.

        Raises:
            ScriptError: a definition calls itself before any event, or cannot be evaluated.
        """
        return self.semantics.transitions(running.state)

    def perform(self, running: Running, event: int, after: Process) -> tuple[Running, Performed]:
        """The process after one of its steps, and what happened in it.

        Raises:
            NotDerivable: it has no such step.
            ScriptError: a definition calls itself before any event, or cannot be evaluated.
        """
        with deep_recursion():
            step = derive(self.semantics, running.state, event, after)
            parts: dict[RunningComponent, int] = {}
            tree = self._moved(running.tree, running.state, step, (), parts)
            return Running(after, tree), Performed(event, step.cause, parts)

    def performed(self, running: Running, event: int, after: Process) -> Performed:
        """What would happen in a step; see :meth:`perform`."""
        with deep_recursion():
            step = derive(self.semantics, running.state, event, after)
            parts: dict[RunningComponent, int] = {}
            _take_part(running.tree, step, parts)
            return Performed(event, step.cause, parts)

    def _tree(self, written: Process, state: Process, place: InnermostDefinition, path: Path) -> RunningTree:
        """The components of a term that has not run yet.

        Args:
            written: the term as it was written, with the names in it.
            state: its head normal form.
            place: where it was written.
            path: where it is in the whole.
        """
        written, place = _behind_names(written, place)
        if not is_composed(state) and not isinstance(state, STATIC_UNARY):
            return RunningTree(self._component(place, path), place)
        operands = state.active()
        inside = replace(place, is_part=True) if len(operands) > 1 else place
        known = type(written) is type(state) and written is not state
        names = written.active() if known else tuple(map(self._name, operands))
        return RunningTree(
            None,
            place,
            tuple(
                self._tree(name, operand, inside, (*path, i))
                for i, (name, operand) in enumerate(zip(names, operands, strict=True))
            ),
        )

    def _name(self, state: Process) -> Process:
        """A term in head normal form by the name that was first met for it."""
        return self.semantics.heads.name(state) or state

    def variables(self, state: Process, component: str) -> Mapping[str, str]:
        """The variables of a state of a class, by name; none of another process.

        The parts of a class, its equations and its data, may run as one.

        Args:
            state: the state.
            component: the name of the component whose state it is. A state that can do nothing is the same in all
                processes, and has data only where it is called like its class.
        """
        with deep_recursion():
            heads = self.semantics.heads
            found = heads.variables(state)
            if found:
                name = heads.name(state)
                called = name is not None and name.name == component
                return found if called or self.semantics.transitions(state) else {}
            if not is_composed(state):
                return {}
            parts = [variables for part in state.active() if (variables := self.variables(part, component))]
            return parts[0] if len(parts) == 1 else {}

    def _component(self, place: InnermostDefinition, path: Path) -> RunningComponent:
        known = self._known.get((path, place))
        if known is None:
            text = place.text or "the process"
            if place.is_part:
                self._parts[place] += 1
                text = f"part {self._parts[place]}" + (f" of {place.text}" if place.text else "")
            known = self._known[path, place] = RunningComponent(text, place.span)
        return known

    def _moved(
        self, tree: RunningTree, state: Process, step: Derivation, path: Path, parts: dict[RunningComponent, int]
    ) -> RunningTree:
        """The components after a step of *state*; *parts* is filled with what they perform in it."""
        after = step.after
        if tree.component is not None:
            parts[tree.component] = step.event
            if is_composed(after):
                return self._tree(self._name(after), after, tree.place, path)
            return tree
        operands = state.active()
        children = list(tree.children)
        for i, move in step.moves:
            children[i] = self._moved(children[i], operands[i], move, (*path, i), parts)
        if _stands(state, step):
            return RunningTree(None, tree.place, tuple(children))
        # The step has ended the operator.
        if not step.moves:
            return self._tree(self._name(after), after, tree.place, path)
        i, move = step.moves[-1]
        if isinstance(state, (Sequential, Throw)) and move.after is not after:
            return self._tree(state.right, after, tree.place, path)
        if move.after is after:
            # What is left over is one of the operands: the side that has interrupted, or what has ended.
            return children[i]
        return self._tree(self._name(after), after, tree.place, path)


def _stands(state: Process, step: Derivation) -> bool:
    """Whether the operator of a state is still there after a step, over operands of which some have moved."""
    if len(step.after.active()) != len(state.active()) or template(step.after) is not template(state):
        return False
    moved = dict(step.moves)
    for i, (before, after) in enumerate(zip(state.active(), step.after.active(), strict=True)):
        expected = before if i not in moved else moved[i].after
        if after is not expected and not (isinstance(state, JOINING) and i in moved and moved[i].event == TICK):
            return False
    return True


def _take_part(tree: RunningTree, step: Derivation, parts: dict[RunningComponent, int]) -> None:
    if tree.component is not None:
        parts[tree.component] = step.event
        return
    for i, move in step.moves:
        _take_part(tree.children[i], move, parts)


def _behind_names(process: Process, place: InnermostDefinition) -> tuple[Process, InnermostDefinition]:
    """What stands behind names and compressions, and the place that the first of the names is."""
    own: Reference | None = None
    while isinstance(process, (Reference, Compressed, Fused)):
        if isinstance(process, Reference):
            own = own or process
            process = process.body()
        else:
            process = process.process
    return process, place if own is None else InnermostDefinition(own.name, own.span)


def distinct_names(names: Iterable[str]) -> list[str]:
    """Names that tell equals apart: ``P``, ``U #1``, ``U #2``."""
    given = list(names)
    total = Counter(given)
    met: Counter[str] = Counter()
    found = []
    for name in given:
        met[name] += 1
        found.append(name if total[name] == 1 else f"{name} #{met[name]}")
    return found
