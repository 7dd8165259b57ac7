"""Skeletons as trees: where each component stands, and in which order the rules of the operators give its steps.

A network says what components do together, but not in which order the transitions of a state come in the rules of the
operators. ``chase`` follows the first tau, so it needs that order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from cspcheck.checker.network.skeleton import Component
from cspcheck.checker.semantics.parallel import sharing
from cspcheck.cspm.process.events import TAU, TICK, new_names
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

Moves = Sequence[tuple[int, int]]
"""(component, local label) of the components that take part in something, ascending."""
Key = tuple[Any, ...]
"""Compares as the transitions of a state are ordered."""
Steps = list[tuple[int, Key]]
"""The events that some local labels together can be, with their places in the order."""


@dataclass(frozen=True, slots=True)
class OperatorTree:
    """An operator of a skeleton over its operands, or a component.

    Attributes:
        operator: the operator; None for a component.
        children: its operands.
        first, end: the components below are numbered from *first* up to, but not including, *end*.
    """

    operator: Process | None
    children: tuple[OperatorTree, ...]
    first: int
    end: int

    def put_together(self, terms: Sequence[Process]) -> Process:
        """The term with these terms for the components, in head normal form if they are."""
        with deep_recursion():
            return _put_together(self, terms)

    def order(self, event: int, moves: Moves) -> Key | None:
        """Where a step of some components comes among those of a state; None if together they do not perform *event*.

        Steps are ordered by their events and then by the rules of the operators; see ``semantics.parallel``. Of
        several targets of a component, each earlier one gives an earlier step.
        """
        with deep_recursion():
            return min((key for result, key in _steps(self, moves) if result == event), default=None)


def tree_of(process: Process, components: Sequence[Component]) -> OperatorTree:
    """The tree of a skeleton whose components these are, in order."""
    with deep_recursion():
        return _tree(process, components, 0)


def _tree(process: Process, components: Sequence[Component], first: int) -> OperatorTree:
    while first < len(components) and components[first].process is not process:
        if isinstance(process, Reference):
            process = process.body()
        elif isinstance(process, Compressed):
            process = process.process
        else:
            children = []
            end = first
            operands = (process.process,) if isinstance(process, (Hide, Project, Rename)) else process.active()
            for operand in operands:
                child = _tree(operand, components, end)
                children.append(child)
                end = child.end
            return OperatorTree(process, tuple(children), first, end)
    return OperatorTree(None, (), first, first + 1)


def _put_together(tree: OperatorTree, terms: Sequence[Process]) -> Process:
    if tree.operator is None:
        return terms[tree.first]
    return tree.operator.with_active(tuple([_put_together(child, terms) for child in tree.children]))


def _steps(tree: OperatorTree, moves: Moves) -> Steps:
    if tree.operator is None:
        (move,) = moves
        return [(move[1], (move[1],))]
    parts: list[tuple[int, Steps]] = []
    place = 0
    for i, child in enumerate(tree.children):
        taken = place
        while place < len(moves) and moves[place][0] < child.end:
            place += 1
        if place > taken:
            parts.append((i, _steps(child, moves[taken:place])))
    operator = tree.operator
    match operator:
        case Hide():
            return [(TAU if e in operator.events else e, (e, k)) for e, k in parts[0][1]]
        case Project():
            return [(e if e == TICK or e in operator.events else TAU, (e, k)) for e, k in parts[0][1]]
        case Rename():
            new = new_names(operator.pairs)
            return [
                (name, (event, key, i)) for event, key in parts[0][1] for i, name in enumerate(new.get(event, (event,)))
            ]
        case Parallel() | AlphabetisedParallel():
            return _together(operator, len(tree.children), parts)
        case LinkedParallel():
            return _linked(operator, parts)
    raise AssertionError(f"{type(operator).__name__} is no operator of a skeleton")


def _together(operator: Parallel | AlphabetisedParallel, operands: int, parts: list[tuple[int, Steps]]) -> Steps:
    """What operands do alone comes before what they do together, each in the order of the operands."""

    def participants(event: int) -> Sequence[int]:
        if isinstance(operator, AlphabetisedParallel):
            return sharing(operator.alphabets, event)
        return range(operands) if event in operator.events else ()

    found: Steps = []
    if len(parts) == 1:
        i, steps = parts[0]
        free = isinstance(operator, Parallel)
        found = [(e, (0, i, key)) for e, key in steps if e == TAU or (free and not participants(e))]
    joined: Steps = [(event, (key,)) for event, key in parts[0][1] if event not in (TAU, TICK)]
    for _, steps in parts[1:]:
        joined = [(event, (*keys, key)) for event, keys in joined for other, key in steps if event == other]
    members = [i for i, _ in parts]
    found.extend((event, (1, *keys)) for event, keys in joined if list(participants(event)) == members)
    return found


def _linked(operator: LinkedParallel, parts: list[tuple[int, Steps]]) -> Steps:
    ends = ({a for a, _ in operator.links}, {b for _, b in operator.links})
    if len(parts) == 1:
        i, steps = parts[0]
        return [(e, (0, i, k)) for e, k in steps if e == TAU or e not in ends[i]]
    return [
        (TAU, (1, place, left, right))
        for place, (a, b) in enumerate(operator.links)
        for e, left in parts[0][1]
        if e == a
        for f, right in parts[1][1]
        if f == b
    ]
