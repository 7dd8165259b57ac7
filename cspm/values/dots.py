"""Dotted values: channels, datatype constructors, events, and the dot that joins them.

``x.y`` puts y behind x. If x ends in a channel or constructor that is still missing fields, y becomes its next field
(or part of it: what is innermost and incomplete takes first); otherwise the two stand side by side. A complete
datatype value is one field; a complete channel is an event.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Any

from cspcheck.cspm.process import events
from cspcheck.cspm.source import Span
from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.values import ATOMS, deep

if TYPE_CHECKING:
    from cspcheck.cspm.values.sets import Set


class Head:
    """What fields are dotted onto: a constructor or a channel. The sets of its fields are evaluated when needed."""

    __slots__ = ("_domains", "_evaluate", "_value", "known", "name", "span")

    def __init__(self, name: str, span: Span | None, evaluate: Callable[[], tuple[Set, ...]] | None) -> None:
        self.name = name
        self.span = span
        self._evaluate = evaluate
        self._domains: tuple[Set, ...] | None = None if evaluate else ()
        self.known: dict[tuple[Any, ...], Any] = {}
        """The complete values made so far, by their fields."""
        self._value: Any = None

    @property
    def domains(self) -> tuple[Set, ...]:
        """The set that each field is of.

        Raises:
            Failure: the sets cannot be evaluated, or depend on this very declaration.
        """
        if self._domains is None:
            evaluate = self._evaluate
            if evaluate is None:
                raise Failure(messages.declaration_needs_itself(self.name, self.span))
            self._evaluate = None
            try:
                self._domains = evaluate()
            finally:
                self._evaluate = evaluate
        return self._domains

    @property
    def arity(self) -> int:
        """How many fields a complete value has."""
        return len(self.domains)

    @property
    def value(self) -> Any:
        """The value of the bare name."""
        if self._value is None:
            self._value = self.complete(()) if self.arity == 0 else Dotted(self, (), False)
        return self._value

    def complete(self, fields: tuple[Any, ...]) -> Any:
        """The value with all its *fields*: always the same object for the same fields."""
        value = self.known.get(fields)
        if value is None:
            value = self.known[fields] = Dotted(self, fields, True)
        return value

    def outside(self, position: int, value: Any) -> Failure:
        """The failure for a *value* that its field (counted from 0) cannot hold."""
        return Failure(messages.outside_field(self.name, self.is_channel, position, value, self.domains[position]))

    @property
    def is_channel(self) -> bool:
        """Whether complete values are events."""
        return False


class Constructor(Head):
    """A constructor of a datatype; ``rank`` is the number of its datatype in the script and its own in there."""

    __slots__ = ("rank",)

    def __init__(
        self,
        name: str,
        span: Span | None,
        evaluate: Callable[[], tuple[Set, ...]] | None,
        rank: tuple[int, int],
    ) -> None:
        super().__init__(name, span, evaluate)
        self.rank = rank


class ChannelHead(Head):
    """A channel; declared in the event table when first needed, at the latest in its turn."""

    __slots__ = ("_declared", "channels", "numbers")

    def __init__(
        self, name: str, span: Span | None, evaluate: Callable[[], tuple[Set, ...]] | None, channels: Channels
    ) -> None:
        super().__init__(name, span, evaluate)
        self.channels = channels
        self._declared: events.Channel | None = None
        self.numbers: dict[tuple[Any, ...], int] = {}
        """Of events made so far from plain fields, by these."""

    @property
    def declared(self) -> events.Channel:
        """The channel in the event table."""
        if self._declared is None:
            domains = tuple([domain.field_domain() for domain in self.domains])
            self._declared = self.channels.table.declare(self.name, domains)
            self.channels.heads[self._declared] = self
        return self._declared

    def complete(self, fields: tuple[Any, ...]) -> Event:
        """The event with these *fields*.

        Raises:
            Failure: a field is outside its set.
        """
        event: Event | None = self.known.get(fields)
        if event is not None:
            return event
        declared = self.declared
        for i, counted in enumerate(declared.domains):
            # What the table cannot count, it takes as it comes.
            if counted is None and not self.domains[i].contains(fields[i]):
                raise self.outside(i, fields[i])
        try:
            number = self.channels.table.event(declared, fields)
        except KeyError:
            for i, (domain, field) in enumerate(zip(self.domains, fields, strict=True)):
                if not domain.contains(field):
                    raise self.outside(i, field) from None
            raise
        event = self.known[fields] = self.channels.event(number)
        return event

    @property
    def is_channel(self) -> bool:
        """True: complete values are events."""
        return True


class Channels:
    """The channels of one script with their events as values: one object for each event."""

    __slots__ = ("_events", "broken", "heads", "table")

    def __init__(self, table: events.EventTable) -> None:
        self.table = table
        self.broken: list[Failure] = []
        """Why some channels have no events, in the order of the script."""
        self.heads: dict[events.Channel, ChannelHead] = {}
        self._events: dict[int, Event] = {}

    def event(self, number: int) -> Event:
        """The event of this number in the table."""
        event = self._events.get(number)
        if event is None:
            event = self._events[number] = Event(number, self)
        return event


class Event:
    """A complete event."""

    __slots__ = ("channels", "number")

    def __init__(self, number: int, channels: Channels) -> None:
        self.number = number
        self.channels = channels

    @property
    def parts(self) -> tuple[ChannelHead, tuple[Any, ...]]:
        """Its channel and its fields."""
        channel, fields = self.channels.table.parts(self.number)
        return self.channels.heads[channel], fields

    def is_same(self, other: Any) -> bool:
        """``==`` of the language."""
        return self is other

    def __repr__(self) -> str:
        return self.channels.table.name(self.number)


class Dotted:
    """A constructor or channel with some of its fields, the last of which may be incomplete itself.

    Complete ones (of a constructor: a complete channel is an :class:`Event`) are made by ``Head.complete`` only
    and so compare by identity.
    """

    __slots__ = ("_hash", "complete", "fields", "head", "order")

    def __init__(self, head: Head, fields: tuple[Any, ...], complete: bool) -> None:
        self.head = head
        self.order: tuple[Any, ...] | None = None
        self.fields = fields
        self.complete = complete
        self._hash = hash((head, fields))

    def is_same(self, other: Any) -> bool:
        """``==`` of the language."""
        return bool(self == other)

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if self.complete or not isinstance(other, Dotted) or other.complete:
            return False
        return self.head is other.head and self.fields == other.fields

    def __hash__(self) -> int:
        return self._hash

    def __repr__(self) -> str:
        from cspcheck.cspm.values.text import show

        return show(self)


class DotList:
    """At least two values side by side, ``1.true.A``, none of which (the last apart) is missing fields."""

    __slots__ = ("parts",)

    def __init__(self, parts: tuple[Any, ...]) -> None:
        self.parts = parts

    def is_same(self, other: Any) -> bool:
        """``==`` of the language."""
        return bool(self == other)

    def canonical(self) -> DotList:
        """The same value with all parts evaluated through and through."""
        return DotList(tuple([deep(part) for part in self.parts]))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, DotList) and self.parts == other.parts

    def __hash__(self) -> int:
        return hash((DotList, self.parts))

    def __repr__(self) -> str:
        from cspcheck.cspm.values.text import show

        return show(self)


def parts(value: Any) -> tuple[Any, ...]:
    """The values that stand side by side in *value*."""
    return value.parts if type(value) is DotList else (value,)


def is_incomplete(value: Any) -> bool:
    """Whether *value* is a channel or constructor that is missing fields."""
    return type(value) is Dotted and not value.complete


def dot(left: Any, right: Any) -> Any:
    """``left.right``.

    Raises:
        Failure: a field's value is outside its set.
    """
    if type(left) is Dotted and not left.complete and type(right) is not DotList:
        return absorb(left, right)
    joined = list(parts(left))
    for part in parts(right):
        if is_incomplete(joined[-1]):
            joined[-1] = absorb(joined[-1], part)
        else:
            joined.append(part)
    return joined[0] if len(joined) == 1 else DotList(tuple(joined))


def absorb(value: Dotted, part: Any) -> Any:
    """The incomplete *value* with *part* as its next field, or inside its last field if that is incomplete.

    Raises:
        Failure: the part is outside the field's set.
    """
    fields = value.fields
    if fields and is_incomplete(fields[-1]):
        fields = (*fields[:-1], absorb(fields[-1], part))
    elif type(part) in ATOMS:
        fields = (*fields, part)
        found = value.head.known.get(fields)
        if found is not None:
            return found
    else:
        fields = (*fields, deep(part))
    return _with_fields(value.head, fields)


def _with_fields(head: Head, fields: tuple[Any, ...]) -> Any:
    last = fields[-1]
    if is_incomplete(last):
        _check_head(head, len(fields) - 1, last)
        return Dotted(head, fields, False)
    complete = len(fields) == head.arity
    if not (complete and head.is_channel) and not head.domains[len(fields) - 1].contains(last):
        raise head.outside(len(fields) - 1, last)
    return head.complete(fields) if complete else Dotted(head, fields, False)


def _check_head(head: Head, position: int, partial: Dotted) -> None:
    """Refuse at once an incomplete field that no completion can repair."""
    domain = head.domains[position]
    if not domain.may_contain_head(partial.head):
        raise head.outside(position, partial)


def missing(value: Dotted) -> tuple[Set, ...]:
    """The sets of the fields that *value*, which must not end in an incomplete field, is still missing."""
    return value.head.domains[len(value.fields) :]


def next_field(value: Dotted) -> Set:
    """The set of the next single field."""
    while value.fields and is_incomplete(value.fields[-1]):
        value = value.fields[-1]
    return value.head.domains[len(value.fields)]


def single_extensions(value: Dotted) -> list[Any]:
    """What the next single field of an incomplete *value* can be, in order, inside all that it is a part of."""
    candidates = next_field(value).elements()
    outer: list[tuple[Set, Dotted]] = []
    while value.fields and is_incomplete(value.fields[-1]):
        domain = value.head.domains[len(value.fields) - 1]
        value = value.fields[-1]
        outer.append((domain, value))
    if not outer:
        return candidates
    return [part for part in candidates if _fits(outer, part)]


def _fits(outer: list[tuple[Set, Dotted]], part: Any) -> bool:
    """Whether *part* may come next in the innermost of the values in *outer*, each of which a set must contain."""
    for domain, value in reversed(outer):
        part = absorb(value, part) if value is outer[-1][1] else _with_fields(value.head, (*value.fields[:-1], part))
        if is_incomplete(part):
            return True
        if not domain.contains(part):
            return False
    return True


def extension_parts(value: Dotted) -> Iterator[tuple[Any, ...]]:
    """What can be dotted onto an incomplete *value* to complete it, as the parts side by side, in order.

    Raises:
        Failure: a missing field has infinitely many values, or all together have too many.
    """
    from cspcheck.cspm.values.sets import LARGEST

    rest: list[list[Any]] = [domain.elements() for domain in missing(value)]
    if prod(map(len, rest)) > LARGEST:
        raise Failure(messages.too_many_completions(value, LARGEST), is_limit=True)
    if value.fields and is_incomplete(value.fields[-1]):
        position = len(value.fields) - 1
        domain = value.head.domains[position]
        for inner in extension_parts(value.fields[-1]):
            if domain.contains(_joined(value.fields[-1], inner)):
                for outer in product(*rest):
                    yield (*inner, *outer)
    else:
        yield from product(*rest)


def _joined(value: Any, more: tuple[Any, ...]) -> Any:
    for part in more:
        value = absorb(value, part)
    return value


def joined(value: Any, more: tuple[Any, ...]) -> Any:
    """*value* with *more* dotted onto it, one after the other."""
    for part in more:
        value = dot(value, part)
    return value


def as_one(side_by_side: tuple[Any, ...]) -> Any:
    """One value of *side_by_side* parts."""
    return side_by_side[0] if len(side_by_side) == 1 else DotList(side_by_side)


def completions(value: Any) -> Set:
    """``productions(value)``: all complete values that start with *value*.

    Raises:
        Failure: there are infinitely many, or *value* is neither a channel nor of a datatype.
    """
    from cspcheck.cspm.values.sets import EventsSet, set_of

    if type(value) is Event:
        return EventsSet.of_numbers((value.number,), value.channels)
    if type(value) is not Dotted:
        if type(value) is DotList and is_incomplete(value.parts[-1]):
            return set_of([DotList((*value.parts[:-1], c)) for c in completions(value.parts[-1]).elements()])
        if type(value) is DotList:
            return set_of([deep(value)])
        raise Failure(messages.no_productions(value))
    if value.complete:
        return set_of([value])
    head = value.head
    if isinstance(head, ChannelHead):
        return EventsSet.of_ranges(_completion_ranges(value, head), head.channels)
    return set_of([_joined(value, more) for more in extension_parts(value)])


def _completion_ranges(value: Dotted, head: ChannelHead) -> list[tuple[int, int]]:
    table = head.channels.table
    fields = value.fields
    if head.declared.size is None:
        for position in range(len(fields), head.arity):
            if not head.domains[position].is_finite():
                raise Failure(messages.infinite_channel(head.name, position, head.domains[position]))
        # Their numbers are given as they are met, so they need not be side by side.
        met = (_joined(value, more).number for more in extension_parts(value))
        return [(number, number + 1) for number in met]
    if fields and is_incomplete(fields[-1]):
        inner: list[tuple[Any, ...]] = [
            (*fields[:-1], whole)
            for whole in completions(fields[-1]).elements()
            if head.domains[len(fields) - 1].contains(whole)
        ]
    else:
        inner = [fields]
    found = (table.completions(head.declared, known) for known in inner)
    return [(numbers.start, numbers.stop) for numbers in found]


def extensions(value: Any) -> Set:
    """``extensions(value)``: everything that completes the incomplete *value*.

    Raises:
        Failure: there is infinitely much, or *value* is not missing anything.
    """
    from cspcheck.cspm.values.sets import set_of

    if type(value) is DotList and is_incomplete(value.parts[-1]):
        value = value.parts[-1]
    if not is_incomplete(value):
        raise Failure(messages.no_extensions(value))
    return set_of([as_one(found) for found in extension_parts(value)])
