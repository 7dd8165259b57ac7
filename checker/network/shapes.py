"""Shapes: how a state is put together, apart from the states of its components.

A term whose running parts contain parallel compositions is taken apart into a *shape*, a tree of the operators that
stay while components move, and the terms in its holes. Operators that change what is there when something happens
(``;``, an interrupt, an exception) may be part of a shape; what they lead to is a shape of its own.

Which shape a term has depends on the term alone, and a hole is at the same place of the tree as long as the
operators above it stand. So equal terms are equal states, and no component ever moves from one place to another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from cspcheck.checker.network.actions import Path
from cspcheck.checker.network.components import ALONE, Interrupting, Joined, Role
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import (
    STOP,
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

JOINING = (Parallel, AlphabetisedParallel, LinkedParallel)
STATIC_UNARY = (Hide, Project, Rename)
UNARY = (*STATIC_UNARY, Sequential, Throw)
INTERRUPTS = (Interrupt, SynchronisingInterrupt)

DEEPEST = 100
"""Operators above a component; a recursion that leaves them behind goes on for ever."""


class Unsuited(Exception):
    """The process has no network of formats, or none that is worth having."""


class Ambiguous(Unsuited):
    """A term that is left whole because it is small may also be reached in parts."""


@dataclass(frozen=True, slots=True)
class Hole:
    """Where a component is."""

    role: Role


@dataclass(frozen=True, slots=True)
class ShapeNode:
    """An operator over shapes. ``template`` is the operator applied to STOPs."""

    template: Process
    children: tuple[Shape, ...]


Shape = Hole | ShapeNode
Fillings = tuple[tuple[Path, Process], ...]
"""The term in each hole, by the hole's position."""


class Parts:
    """Tells which terms have parallel composition among the operators that decide what they do next."""

    def __init__(self) -> None:
        self._known: dict[Process, bool] = {}

    def __call__(self, term: Process) -> bool:
        """Whether the term has parts."""
        known = self._known
        way: list[Process] = []
        while term not in known and isinstance(term, UNARY + INTERRUPTS):
            way.append(term)
            term = term.active()[0]
        result = known[term] if term in known else isinstance(term, JOINING)
        # What is nested deep was met before with an operator less, as a rule.
        for passed in way:
            known[passed] = result
        return result


def is_taken_apart(term: Process) -> bool:
    """Whether some shape other than a hole could be that of the term."""
    while isinstance(term, UNARY):
        term = term.active()[0]
    return isinstance(term, JOINING + INTERRUPTS)


class Shapes:
    """Takes terms apart.

    Args:
        is_small: whether a term is better left whole though it has parts.
    """

    def __init__(self, is_small: Callable[[Process], bool]) -> None:
        self.has_parts = Parts()
        self._is_small = is_small

    def of(self, term: Process, role: Role = ALONE, depth: int = 0) -> tuple[Shape, Fillings]:
        """The shape of a term in head normal form that runs in *role*, and what is in the shape's holes.

        Raises:
            Unsuited: operators are nested too deep.
        """
        if depth > DEEPEST:
            raise Unsuited("operators are nested too deep")
        whole = Hole(role), (((), term),)
        if isinstance(term, JOINING):
            below = Joined(term.clocks)
            return _node(term, [self.of(operand, below, depth + 1) for operand in term.active()])
        if not isinstance(term, UNARY + INTERRUPTS) or not self.has_parts(term):
            return whole
        if not isinstance(term, STATIC_UNARY) and self._is_small(term):
            return whole
        first = self.of(term.active()[0], role if isinstance(term, STATIC_UNARY) else ALONE, depth + 1)
        if isinstance(first[0], Hole):
            return whole
        if isinstance(term, INTERRUPTS):
            right = Interrupting(_synchronised(term)), term.right
            return _node(term, [first, (Hole(right[0]), (((), right[1]),))])
        return _node(term, [first])

    def replaced(self, shape: Shape, changes: Iterable[tuple[Path, Process]]) -> tuple[Shape, list[Path], Fillings]:
        """A shape with other terms at some positions.

        Args:
            shape: what was there.
            changes: terms in head normal form, by position; no position is above another.

        Returns:
            The new shape; the positions at which it differs, which may be above those of the changes; and the terms
            in its holes at and below these positions.
        """
        positions: list[Path] = []
        fillings: list[tuple[Path, Process]] = []
        for path, term in changes:
            part, filling = self.of(term, role_at(shape, path), len(path))
            # An operator over something without parts is itself without parts.
            while path and isinstance(part, Hole):
                above = at(shape, path[:-1])
                assert isinstance(above, ShapeNode)
                if not isinstance(above.template, UNARY):
                    break
                path = path[:-1]
                term = above.template.with_active((term,))
                part, filling = self.of(term, role_at(shape, path), len(path))
            shape = _put(shape, path, part)
            positions.append(path)
            fillings.extend([(path + hole, term) for hole, term in filling])
        return shape, positions, tuple(fillings)


def _synchronised(term: Process) -> EventSet:
    return term.events if isinstance(term, SynchronisingInterrupt) else EventSet()


def _node(term: Process, children: list[tuple[Shape, Fillings]]) -> tuple[Shape, Fillings]:
    return (
        ShapeNode(template(term), tuple([shape for shape, _ in children])),
        tuple([((i, *hole), part) for i, (_, fillings) in enumerate(children) for hole, part in fillings]),
    )


def template(term: Process) -> Process:
    """The operator of a term applied to STOPs."""
    return term.with_active((STOP,) * len(term.active()))


def at(shape: Shape, path: Path) -> Shape:
    """The part of a shape at a position."""
    for i in path:
        assert isinstance(shape, ShapeNode)
        shape = shape.children[i]
    return shape


def role_at(shape: Shape, path: Path) -> Role:
    """The role that a component at a position of a shape has."""
    role: Role = ALONE
    for i in path:
        assert isinstance(shape, ShapeNode)
        if isinstance(shape.template, JOINING):
            role = Joined(shape.template.clocks)
        elif isinstance(shape.template, INTERRUPTS) and i == 1:
            role = Interrupting(_synchronised(shape.template))
        elif not isinstance(shape.template, STATIC_UNARY):
            role = ALONE
        shape = shape.children[i]
    return role


def holes(shape: Shape, path: Path = ()) -> list[tuple[Path, Role]]:
    """The positions and roles of a shape's holes, from left to right."""
    if isinstance(shape, Hole):
        return [(path, shape.role)]
    return [hole for i, child in enumerate(shape.children) for hole in holes(child, (*path, i))]


def may_be(shape: Shape, term: Process) -> bool:
    """Whether a term could have been taken apart into a shape."""
    if isinstance(shape, Hole):
        return True
    return template(term) is shape.template and all(map(may_be, shape.children, term.active()))


def _put(shape: Shape, path: Path, part: Shape) -> Shape:
    if not path:
        return part
    assert isinstance(shape, ShapeNode)
    i = path[0]
    children = (*shape.children[:i], _put(shape.children[i], path[1:], part), *shape.children[i + 1 :])
    return ShapeNode(shape.template, children)


def slot_key(path: Path) -> Path:
    """Which slot a hole is in: positions that only differ in zeros at the end are never holes of one shape."""
    end = len(path)
    while end and path[end - 1] == 0:
        end -= 1
    return path[:end]
