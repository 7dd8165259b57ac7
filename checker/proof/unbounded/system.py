"""Classes side by side as one machine: finitely many control states, and data of which predicates speak.

A *configuration* is the control state of each component. A move performs an event of a channel, in which some
components take part, or an internal step of one component's control. What the data do is never gone through: it is
predicates over the variables before and after, and the parameters of the event.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

from cspcheck.checker.proof.definedness import Definedness
from cspcheck.checker.proof.one_point import eliminated
from cspcheck.checker.proof.question import Constraint
from cspcheck.checker.proof.situation import Situation, parameter_variable
from cspcheck.checker.proof.terms import (
    TRUE,
    Key,
    Unknown,
    all_of,
    bound_by,
    implication,
    member,
    quantified,
    substitute,
    universe,
)
from cspcheck.checker.proof.unbounded.control import Control, UnreadableProcess, control
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Term, Variable

if TYPE_CHECKING:
    from cspcheck.cspm.oz.processes.context import ClassContext

Configuration: TypeAlias = tuple[int, ...]


@dataclass(frozen=True)
class ClassComponent:
    """A class as a component.

    Attributes:
        name: of the class.
        situation: its predicates; in a composition by qualified names.
        machine: its control.
        labels: of each of its channels, what the channel is called outside; None: hidden.
        angelic: whether the environment chooses outputs.
    """

    name: str
    situation: Situation
    machine: Control
    labels: Mapping[str, str | None]
    angelic: bool = False

    @property
    def model(self) -> core.ClassModel:
        """The class."""
        return self.situation.model

    @cached_property
    def free(self) -> tuple[str, ...]:
        """The operations that control says nothing of: they can happen at any time."""
        return tuple(name for name in self.model.operations if name not in self.machine.mentioned)

    def channel(self, label: str) -> str | None:
        """The channel that is called so outside."""
        return next((name for name, known in self.labels.items() if known == label), None)

    def has_outputs(self, channel: str) -> bool:
        """Whether the class chooses values of the channel's events."""
        operation = self.model.operations.get(channel)
        return not self.angelic and operation is not None and any(p.kind == "output" for p in operation.parameters)

    # --- predicates --------------------------------------------------------------------------------------------------

    def parameters(self, channel: str) -> list[Variable]:
        """The parameters of a channel's events as the operation names them."""
        operation = self.model.operations.get(channel)
        own = {} if operation is None else {p.name: p for p in operation.parameters}
        return [parameter_variable(own.get(p.name, p)) for p in self.model.channels[channel].parameters]

    def renaming(self, channel: str, values: tuple[Variable, ...]) -> dict[Key, Term]:
        """What the operation's parameters are called in the events of a move."""
        return {(v.name, v.role): new for v, new in zip(self.parameters(channel), values, strict=True)}

    def carried(self, channel: str) -> list[Constraint]:
        """That the values are what the channel and the operation declare."""
        parts = []
        for variable, declared in zip(self.parameters(channel), self.model.channels[channel].parameters, strict=True):
            parts.append(Constraint(member(variable, declared.carrier), f"carrier of `{declared.name}`", declared.span))
        operation = self.model.operations.get(channel)
        if operation is not None:
            parts += [*self.situation.inputs(operation), *self.situation.outputs(operation)]
        return parts

    def step(self, channel: str, values: tuple[Variable, ...]) -> list[Constraint]:
        """That an event of the channel happens, from a state before to one after."""
        operation = self.model.operations.get(channel)
        parts = self.carried(channel)
        if operation is not None:
            situation = self.situation
            parts += [*situation.guard(operation), *situation.effect(operation), *situation.frame(operation)]
            parts += situation.state("after")
        table = self.renaming(channel, values)
        return [replace(part, term=substitute(part.term, table)) for part in parts]

    def possible(self, channel: str, values: tuple[Variable, ...]) -> Term:
        """That an event with these values can happen in the state before; defined everywhere."""
        operation = self.model.operations.get(channel)
        parts = [part.term for part in self.carried(channel)]
        unknowns: tuple[Unknown, ...] = ()
        if operation is not None:
            unknowns, effect = self.situation.existential(operation, outputs=False)
            parts += [*operation.guard, *(part.term for part in effect)]
        return substitute(_exists(unknowns, self.definedness.holding(parts)), self.renaming(channel, values))

    @cached_property
    def definedness(self) -> Definedness:
        """Makes predicates defined everywhere: what has no truth value does not hold."""
        return Definedness(self.situation.specification.frees)

    def unchanged(self, channel: str | None) -> dict[Key, Term]:
        """The variables that keep their values, by what they are afterwards."""
        operation = None if channel is None else self.model.operations.get(channel)
        if operation is not None:
            return self.situation.unchanged(operation)
        before, after = self.situation.state_variables(), self.situation.state_variables("after")
        return {(a.name, a.role): b for a, b in zip(after, before, strict=True)}

    def initial(self) -> list[Constraint]:
        """That the state before is one to begin with."""
        return [*self.situation.state(), *self.situation.initial()]


@dataclass(frozen=True)
class SystemMove:
    """What can happen in a configuration.

    Attributes:
        label: what the channel is called outside; None: hidden, or an internal step of control.
        parts: the components that take part, by number, with the channel as each calls it; none: an internal step.
        target: the configuration behind it.
    """

    label: str | None
    parts: tuple[tuple[int, str], ...]
    target: Configuration


@dataclass(frozen=True)
class SystemLeaf:
    """One component of a composition, by its number."""

    number: int


@dataclass(frozen=True)
class Together:
    """Two compositions that meet on some channels."""

    channels: frozenset[str]
    left: Composition
    right: Composition


@dataclass(frozen=True)
class Hidden:
    """A composition with some channels hidden."""

    channels: frozenset[str]
    inner: Composition


Composition: TypeAlias = SystemLeaf | Together | Hidden


class ClassSystem:
    """A composition of classes.

    Args:
        components: with variables whose names do not meet.
        composition: how they stand together.
    """

    def __init__(self, components: tuple[ClassComponent, ...], composition: Composition) -> None:
        self.components = components
        self._composition = composition
        self.start: Configuration = tuple(0 for _ in components)
        self._moves: dict[Configuration, tuple[SystemMove, ...]] = {}

    def moves(self, at: Configuration) -> tuple[SystemMove, ...]:
        """What can happen as far as control is concerned."""
        if at not in self._moves:
            self._moves[at] = tuple(dict.fromkeys(self._of(self._composition, at)))
        return self._moves[at]

    def settled(self, at: Configuration) -> bool:
        """Whether control can do nothing by itself: neither an internal step nor terminate."""
        return all(c.machine.settled(s) for c, s in zip(self.components, at, strict=True))

    def _of(self, node: Composition, at: Configuration) -> Iterator[SystemMove]:
        match node:
            case SystemLeaf(number=number):
                component, state = self.components[number], at[number]
                for channel, to in component.machine.moves[state]:
                    target = (*at[:number], to, *at[number + 1 :])
                    if channel is None:
                        yield SystemMove(None, (), target)
                    else:
                        yield SystemMove(component.labels[channel], ((number, channel),), target)
                for channel in component.free:
                    yield SystemMove(component.labels[channel], ((number, channel),), at)
            case Hidden(channels=channels, inner=inner):
                for move in self._of(inner, at):
                    yield replace(move, label=None) if move.label in channels else move
            case Together(channels=channels, left=left, right=right):
                ones, others = list(self._of(left, at)), list(self._of(right, at))
                for move in (*ones, *others):
                    if move.label not in channels:
                        yield move
                for one in ones:
                    for other in others:
                        if one.label is not None and one.label in channels and one.label == other.label:
                            yield SystemMove(
                                one.label, (*one.parts, *other.parts), _joined(at, one.target, other.target)
                            )

    def configurations(self, most: int) -> list[Configuration]:
        """All configurations that control leads to, breadth first.

        Raises:
            Unreadable: there are too many.
        """
        found = {self.start: None}
        for at in (todo := [self.start]):
            for move in self.moves(at):
                if move.target not in found:
                    found[move.target] = None
                    todo.append(move.target)
            if len(found) > most:
                raise UnreadableProcess(f"there are more than {most} configurations of control")
        return todo

    # --- predicates --------------------------------------------------------------------------------------------------

    def values(self, move: SystemMove) -> tuple[Variable, ...]:
        """The values of a move's event; as outputs where a component chooses them."""
        if not move.parts:
            return ()
        lists = [self.components[number].parameters(channel) for number, channel in move.parts]
        found = []
        for position, variable in enumerate(lists[0]):
            chosen = next(
                (
                    names[position].role
                    for names, (number, channel) in zip(lists, move.parts, strict=True)
                    if names[position].role == "output" and self.components[number].has_outputs(channel)
                ),
                "input" if variable.role == "output" else variable.role,
            )
            found.append(replace(variable, name=f"{move.label or move.parts[0][1]}.{position + 1}", role=chosen))
        return tuple(found)

    def state(self) -> list[Constraint]:
        """That the states before are states of the classes."""
        return [part for component in self.components for part in component.situation.state()]

    def step(self, move: SystemMove) -> list[Constraint]:
        """That the move happens, as far as the components in it are concerned: from a state before to one after."""
        values = self.values(move)
        return [part for number, channel in move.parts for part in self.components[number].step(channel, values)]

    def unchanged(self, move: SystemMove) -> dict[Key, Term]:
        """What keeps its value in a move, by what it is afterwards."""
        table: dict[Key, Term] = {}
        taking = dict(move.parts)
        for number, component in enumerate(self.components):
            table |= component.unchanged(taking.get(number))
        return table

    def alive(self, move: SystemMove) -> Term:
        """That an event of the move happens whatever the classes choose.

        Raises:
            Unreadable: several components choose values of the event.
        """
        values = self.values(move)
        possible = {n: self.components[n].possible(channel, values) for n, channel in move.parts}
        choosing = [n for n, channel in move.parts if self.components[n].has_outputs(channel)]
        if len(choosing) > 1:
            raise UnreadableProcess(f"several classes choose values of `{move.label}`")
        chosen = [v for v in values if v.role == "output"]
        given = [v for v in values if v.role != "output"]
        if not choosing or len(move.parts) == 1:
            return some(values, all_of(possible.values()))
        others = all_of(term for n, term in possible.items() if n not in choosing)
        mine = possible[choosing[0]]
        return some(given, all_of([some(chosen, mine), every(chosen, mine, others)]))


def _joined(at: Configuration, one: Configuration, other: Configuration) -> Configuration:
    """Where two moves of different components lead to together."""
    return tuple(o if o != here else t for here, t, o in zip(at, one, other, strict=True))


def some(values: Iterable[Variable], body: Term) -> Term:
    """That there are such values."""
    return _exists([Unknown(v, universe(v.type)) for v in values], [body])


def _exists(unknowns: Iterable[Unknown], parts: Iterable[Term]) -> Term:
    """That there are values of some unknowns, without those that an equation gives."""
    left, rest = eliminated(unknowns, parts)
    binders, table = bound_by(left)
    return quantified("exists", binders, TRUE, substitute(all_of(rest), table))


def every(values: Iterable[Variable], premise: Term, conclusion: Term) -> Term:
    """That all values of which one thing holds have the other."""
    binders, table = bound_by(Unknown(v, universe(v.type)) for v in values)
    return quantified("forall", binders, TRUE, substitute(implication(premise, conclusion), table))


def component(context: ClassContext, model: core.ClassModel, *, qualified: bool, visible: bool) -> ClassComponent:
    """A class as a component.

    Raises:
        Unreadable: what its control does depends on values, or which events it has is not up to classes alone.
    """
    from cspcheck.checker.proof.simulation import qualified as with_qualified_names

    specification = context.specification
    constructors = {name for free in specification.frees.values() for name, _ in free.branches}
    machine = control(model, context.declared | constructors)
    labels: dict[str, str | None] = {}
    for channel in model.channels.values():
        match channel.kind:
            case "chan" if (model.name, channel.name) not in context.unshared:
                if channel.parameters and channel.name in context.declared:
                    raise UnreadableProcess(f"the script declares what `{channel.name}` carries")
                labels[channel.name] = channel.name
            case "method":
                labels[channel.name] = f"{model.name}::{channel.name}" if visible else None
            case "chan" | "operation":
                labels[channel.name] = f"{model.name}::{channel.name}"
            case _:
                labels[channel.name] = None
    named = with_qualified_names(model, True) if qualified else model
    return ClassComponent(model.name, Situation(specification, named), machine, labels, context.angelic)
