"""Classes: tasks with data, whose events are operations on it.

An operation says for a state and the values that come in which outcomes it has: what goes out, and the variables
afterwards. An event is offered when there is an outcome within the types and the invariant; what leads outside
blocks. Inputs are the environment's to choose; of several outputs and after-states the program's policy chooses, or
a method that was written by hand.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from types import SimpleNamespace
from typing import Any

from . import contracts
from .alternation import Choice
from .channel import ANY, Channel, Offer, OneOf, Undecided, Values
from .data import Variables
from .task import Task


@dataclass(frozen=True)
class Outcome:
    """One way in which an operation can end: its outputs in order, and the variables that change."""

    outputs: Values = ()
    after: Mapping[str, Any] = field(default_factory=dict)


Outcomes = Iterator[Outcome]


class CannotList(Exception):
    """The values that a predicate leaves open cannot be tried one by one: a method must give them."""


class Data(Variables):
    """The variables of a class, with its invariant, its initial states and the outcomes of its operations."""

    def invariant(self) -> bool:
        """What holds in every state, beside the types."""
        return True

    def initial(self) -> Outcomes:
        """The states to begin with."""
        return self.anything()

    def allows(self, after: Mapping[str, Any]) -> bool:
        """Whether the state with these changes is within types and invariant."""
        if not all(self.TYPES[name].contains(value) for name, value in after.items()):
            return False
        before = self.snapshot()
        self.restore(dict(after))
        try:
            return self.invariant()
        finally:
            self.restore(before)

    def assignments(self, *names: str) -> Iterator[Any]:
        """All values of some variables, as objects with these attributes.

        Raises:
            CannotList: there are too many to list.
        """
        columns = []
        for name in names:
            values = self.TYPES[name].values()
            if values is None:
                raise CannotList(f"{self.OWNER}: the values of {name} cannot be listed, {self.TYPES[name].describe()}")
            columns.append(list(values))
        for row in product(*columns):
            yield SimpleNamespace(**dict(zip(names, row, strict=True)))

    def anything(self) -> Outcomes:
        """Any values of all variables."""
        for after in self.assignments(*self.TYPES):
            yield Outcome(after=vars(after))


class Operation:
    """An operation of a class on one of its channels.

    Args:
        channel: where its events are.
        kinds: for each field ``?`` (input), ``!`` (output) or ``.`` (simple).
        outcomes: of the class's data: from the values of input and simple fields to the outcomes, not yet held against
            types and invariant. None: the data does not restrict the events.
        guard: of an operation with a guard of its own; where it holds and there is no outcome, the operation breaks.
        reads: of an operation without outputs that the task performs alone: is called when it is to happen, and gives
            the values of its inputs: what the world outside says.
        body: is called when the operation has happened, with its values: a method.
        gives: the variables whose values the method gives; () if it only acts.
        post: of an operation whose method gives values: whether the predicate holds with them.
    """

    def __init__(
        self,
        channel: Channel,
        kinds: str = "",
        outcomes: Callable[..., Outcomes] | None = None,
        *,
        guard: Callable[..., bool] | None = None,
        reads: Callable[..., Any] | None = None,
        body: Callable[..., Any] | None = None,
        gives: tuple[str, ...] = (),
        post: Callable[..., bool] | None = None,
    ) -> None:
        self.channel = channel
        self.kinds = kinds
        self.reads = reads
        self.body = body
        self.gives = gives
        self._outcomes = outcomes
        self._guard = guard
        self._post = post

    def on(self, *fields: Any, after: float | None = None) -> Wanted:
        """Only the events of the operation that have these fields, from some time on."""
        return Wanted(self, fields, after)

    def possible(self, data: Data, inputs: Values) -> list[Outcome]:
        """The outcomes within types and invariant."""
        if self._outcomes is None:
            return [Outcome()]
        return [outcome for outcome in self._outcomes(*inputs) if data.allows(outcome.after)]

    def open_for(self, inputs: Values) -> bool:
        """Whether the guard holds; true where there is none."""
        return self._guard is None or self._guard(*inputs)

    def split(self, values: Values) -> tuple[Values, Values]:
        """The values of input and simple fields, and those of output fields."""
        inputs = tuple(value for kind, value in zip(self.kinds, values, strict=True) if kind != "!")
        return inputs, tuple(value for kind, value in zip(self.kinds, values, strict=True) if kind == "!")

    def accepts(self, data: Data, values: Values) -> bool:
        """Whether the event with these values is offered."""
        inputs, outputs = self.split(values)
        if not self.open_for(inputs):
            return False
        try:
            possible = self.possible(data, inputs)
        except CannotList:
            if not self.gives:
                raise
            return True  # a method gives what cannot be found by trying
        if not possible and self._guard is not None:
            return True  # it will break
        return self._outcomes is None or any(outcome.outputs == outputs for outcome in possible)

    def offer(self, task: ClassTask, fields: Values) -> Offer | None:
        """What a task offers for the operation in its present state; None if nothing."""
        data = task.data
        if self._outcomes is None:
            return self.channel.offer(*fields)
        if any(kind != "!" for kind in self.kinds):
            offer = self.channel.offer(*fields, accept=lambda *values: self.accepts(data, values))
            reads = self.reads
            if reads is not None and all(field is ANY for field in fields):
                offer.body = lambda: reads(data)
            return offer
        if not self.open_for(()):
            return None
        try:
            possible = [outcome.outputs for outcome in self.possible(data, ()) if _fits(outcome.outputs, fields)]
        except CannotList:
            if not self.gives or self.kinds:
                raise
            return self.channel.offer(*fields)
        if not possible:
            contracts.require(self._guard is None, task.name, f"the effect of {self.channel.name}", **data.snapshot())
            return None
        outputs = list(dict.fromkeys(possible))
        return self.channel.put(*outputs[task.decide(len(outputs)) if len(outputs) > 1 else 0])

    def happened(self, task: ClassTask, values: Values) -> None:
        """Bring about what the operation does to the data of a task.

        Raises:
            Broken: the guard held and there is no outcome, or a method gave values that the predicate excludes.
            OutOfRange: a method gave values outside the types.
        """
        data = task.data
        inputs, outputs = self.split(values)
        given: Any = None
        if self.body is not None:
            given = self.body(data, *values)
        if self._outcomes is None:
            return
        if self.gives and not isinstance(given, Undecided):
            row = given if len(self.gives) > 1 else (given,)
            after = dict(zip(self.gives, row, strict=True))
            if contracts.checked():
                namespace = SimpleNamespace(**after)
                holds = self._post is None or self._post(*inputs, *outputs, namespace)
                shown = {**data.snapshot(), **{f"{name}_after": value for name, value in after.items()}}
                contracts.ensure(holds, task.name, self.channel.name, **shown)
            task.change(after)
            contracts.ensure(data.invariant(), task.name, f"the invariant after {self.channel.name}", **data.snapshot())
            return
        try:
            possible = [outcome for outcome in self.possible(data, inputs) if outcome.outputs == outputs]
        except CannotList as error:
            if self.body is None:
                raise
            raise CannotList(f"{error}; the method of {self.channel.name} has to give them") from None
        if not possible:
            raise contracts.Broken("precondition", task.name, f"the effect of {self.channel.name}", data.snapshot())
        task.change(possible[task.decide(len(possible)) if len(possible) > 1 else 0].after)


@dataclass(frozen=True)
class Wanted:
    """Some of the events of an operation."""

    operation: Operation
    fields: Values
    after: float | None = None


class ClassTask(Task):
    """A task with data.

    Args:
        data: its variables, new.
    """

    def __init__(
        self, name: str, data: Data, *, priority: int = 0, period: float | None = None, offset: float = 0.0
    ) -> None:
        super().__init__(name, priority=priority, period=period, offset=offset)
        self.data = data

    def begin_data(self) -> None:
        """Choose an initial state.

        Raises:
            Broken: there is none.
        """
        possible = [outcome for outcome in self.data.initial() if self.data.allows(outcome.after)]
        if not possible:
            raise contracts.Broken("initial predicate", self.name, "INIT", {})
        self.change(possible[self.decide(len(possible)) if len(possible) > 1 else 0].after)

    def change(self, after: Mapping[str, Any]) -> None:
        """Give variables new values, each checked against its type."""
        for name, value in after.items():
            setattr(self.data, name, value)

    async def act(self, *wanted: Operation | Wanted | None) -> Choice:
        """Wait until one of some operations happens, and bring about what it does to the data.

        None stands for one whose guard in the process is false.
        """
        rows = [one.on(*([ANY] * len(one.channel.types))) if isinstance(one, Operation) else one for one in wanted]
        offers: list[Offer | None] = []
        for one in rows:
            offer = None if one is None else one.operation.offer(self, one.fields)
            if one is not None and offer is not None and one.after is not None:
                offer = offer.standing_from(one.after)
            offers.append(offer)
        choice = await self.select(*offers)
        taken = rows[choice.taken]
        assert taken is not None
        taken.operation.happened(self, choice.values)
        return choice

    async def do(self, wanted: Operation | Wanted) -> Values:
        """Wait until an operation happens, and bring about what it does; the values of its event."""
        return (await self.act(wanted)).values


def _fits(outputs: Values, fields: Values) -> bool:
    """Whether the values of an event without inputs are among those that are wanted."""
    return all(
        field is ANY or (value in field.values if isinstance(field, OneOf) else value == field)
        for value, field in zip(outputs, fields, strict=True)
    )
