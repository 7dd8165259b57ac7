"""Events as integers, and sets of events as ranges of integers.

Each channel owns a contiguous range of identifiers in the order of declaration; within it the events are
ordered by their fields, the first field slowest (mixed radix). So ``{| c |}`` is one range however many events
it has, and comparing identifiers is comparing events in the order of declaration.

That order is what makes a counterexample canonical, so it must not depend on what was met before. A field of an
infinite type has no positions that could be counted; its values get places in the order of their values instead
(:mod:`cspcheck.cspm.process.places`). Only where there is no room left between two of them is an event numbered as it
is met.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from cspcheck.cspm.process.places import Places

TAU = 0
"""The internal action."""
TICK = 1
"""Successful termination."""
FIRST_EVENT = 2
"""The first identifier that a channel can own."""
UNBOUNDED = 1 << 62
"""Identifiers from here on are given out as events are met: those for which there is no place in the order."""
ROOM = 1 << 55
"""Identifiers that a channel owns whose events cannot be counted, one of the first :data:`ROOMY` of them."""
ROOMY = 64
"""After so many channels of that kind each gets a thousandth of the room."""
LEAST_PLACES = 1 << 16
"""A field whose values cannot be counted gets at least so many places."""


class FieldDomain:
    """The finite, ordered set of values that one field of a channel can carry."""

    __slots__ = ("_index", "values")

    def __init__(self, values: Sequence[Hashable]) -> None:
        self.values: Sequence[Hashable] = tuple(values)
        self._index = {value: i for i, value in enumerate(self.values)}

    def __len__(self) -> int:
        return len(self.values)

    def __contains__(self, value: Hashable) -> bool:
        return value in self._index

    def index(self, value: Hashable) -> int:
        """Position of *value*. Raises KeyError if it is not of the domain."""
        return self._index[value]

    def value(self, position: int) -> Hashable:
        """The value at a position."""
        return self.values[position]


class RangeDomain(FieldDomain):
    """A field that carries consecutive integers, not written out."""

    __slots__ = ()

    def __init__(self, numbers: range) -> None:
        self.values: Sequence[Hashable] = numbers

    def __contains__(self, value: Hashable) -> bool:
        return type(value) is int and value in self.values

    def index(self, value: Hashable) -> int:
        """Position of *value*. Raises KeyError if it is not of the domain."""
        numbers = self.values
        assert isinstance(numbers, range)
        if type(value) is int and value in numbers:
            return value - numbers.start
        raise KeyError(value)


@dataclass(frozen=True, slots=True, eq=False)
class Channel:
    """A declared channel: its name, the domains of its fields (None: infinite) and its range of identifiers.

    ``size`` is None if a field is infinite or the events are more than there are identifiers. Then ``fields`` say
    where the values of each field lie; it is empty where no identifiers were left for the channel.
    """

    name: str
    order: int
    domains: tuple[FieldDomain | None, ...]
    base: int
    size: int | None
    fields: tuple[FieldDomain | Places, ...] = ()

    @property
    def arity(self) -> int:
        """How many fields an event of this channel has."""
        return len(self.domains)


class EventTable:
    """All events of one script.

    Args:
        show: prints a field's value the way the language writes it.
        order: a key that compares as the values of an infinite field are ordered.
    """

    def __init__(
        self, show: Callable[[Hashable], str] = str, order: Callable[[Any], Any] = lambda value: value
    ) -> None:
        self._show = show
        self._order = order
        self._channels: list[Channel] = []
        self._bases: list[int] = []
        self._owners: list[Channel] = []
        self._next = FIRST_EVENT
        self.clocks = EventSet()
        """The events by which time passes: what an operand that can terminate waits with for the others."""
        self._late: dict[tuple[Channel, tuple[Hashable, ...]], int] = {}
        self._late_events: list[tuple[Channel, tuple[Hashable, ...]]] = []
        self.tau = "tau"
        """How the internal action is written: a word, or the sign where a channel of the script has this name."""
        self.tick = "tick"
        """How successful termination is written: a word, or the sign where a channel of the script has this name."""

    @property
    def channels(self) -> tuple[Channel, ...]:
        """The channels in the order of declaration."""
        return tuple(self._channels)

    def declare(self, name: str, domains: Sequence[FieldDomain | None] = ()) -> Channel:
        """Add a channel; a domain of None is an infinite field."""
        finite = all(d is not None for d in domains)
        size: int | None = None
        if finite:
            size = 1
            for domain in domains:
                assert domain is not None
                size *= len(domain)
        if size is not None and self._next + size > UNBOUNDED:
            size = None
        fields: tuple[FieldDomain | Places, ...] = ()
        room = ROOM if sum(bool(known.fields) for known in self._channels) < ROOMY else ROOM >> 10
        if size is None and self._next + room <= UNBOUNDED:
            fields = self._placed(domains, room)
        channel = Channel(name, len(self._channels), tuple(domains), self._next, size, fields)
        self._channels.append(channel)
        if owned := room if fields else size:
            self._bases.append(self._next)
            self._owners.append(channel)
            self._next += owned
        if name == "tau":
            self.tau = "\N{GREEK SMALL LETTER TAU}"
        elif name == "tick":
            self.tick = "\N{CHECK MARK}"
        return channel

    def _placed(self, domains: Sequence[FieldDomain | None], room: int) -> tuple[FieldDomain | Places, ...]:
        """Where the values of each field lie when not all events can be counted: positions, or places in an order."""
        places = sum(domain is None for domain in domains)
        counted = 1
        found: list[FieldDomain | None] = []
        for domain in domains:
            if domain is not None and counted * len(domain) * LEAST_PLACES ** max(places, 1) <= room:
                counted *= len(domain)
            elif domain is not None:
                places, domain = places + 1, None
            found.append(domain)
        if not places:
            return tuple([domain for domain in found if domain is not None])
        width = 1 << ((room // counted).bit_length() - 1) // places
        return tuple([Places(width, self._order) if domain is None else domain for domain in found])

    def event(self, channel: Channel, fields: Sequence[Hashable] = ()) -> int:
        """Identifier of a complete event. Raises KeyError if a value is outside its field's domain."""
        if len(fields) != channel.arity:
            raise ValueError(f"{channel.name} has {channel.arity} fields, not {len(fields)}")
        if channel.size is None:
            for domain, value in zip(channel.domains, fields, strict=True):
                if domain is not None:
                    domain.index(value)
            key = (channel, tuple(fields))
            number = self._late.get(key)
            if number is None:
                number = self._place(channel, fields)
            if number is None:
                number = self._late[key] = UNBOUNDED + len(self._late_events)
                self._late_events.append(key)
            return number
        rank = 0
        for domain, value in zip(channel.domains, fields, strict=True):
            assert domain is not None
            rank = rank * len(domain) + domain.index(value)
        return channel.base + rank

    def _place(self, channel: Channel, fields: Sequence[Hashable]) -> int | None:
        """The identifier of an event that cannot be counted; None if it has no place in the order."""
        rank = 0
        for where, value in zip(channel.fields, fields, strict=False):
            position = where.index(value) if isinstance(where, FieldDomain) else where.place(value)
            if position is None:
                return None
            rank = rank * len(where) + position
        return channel.base + rank if channel.fields else None

    def completions(self, channel: Channel, fields: Sequence[Hashable] = ()) -> range:
        """Identifiers of all events of *channel* that start with *fields*.

        Raises:
            KeyError: a value is outside its field's domain.
            OverflowError: the missing fields cannot be counted, or one of *fields* has no place in the order.
        """
        if channel.size is None and not channel.fields:
            raise OverflowError(channel.name)
        rank, width = 0, 1
        for i, domain in enumerate(channel.fields or channel.domains):
            assert domain is not None
            if i < len(fields):
                position = domain.place(fields[i]) if isinstance(domain, Places) else domain.index(fields[i])
                if position is None:
                    raise OverflowError(channel.name)
                rank = rank * len(domain) + position
            elif isinstance(domain, Places):
                raise OverflowError(channel.name)
            else:
                width *= len(domain)
        start = channel.base + rank * width
        return range(start, start + width)

    def parts(self, event: int) -> tuple[Channel, tuple[Hashable, ...]]:
        """Channel and field values of a visible event."""
        if event >= UNBOUNDED:
            return self._late_events[event - UNBOUNDED]
        channel = self._owners[bisect_right(self._bases, event) - 1]
        rank = event - channel.base
        fields: list[Hashable] = []
        for domain in reversed(channel.fields or channel.domains):
            assert domain is not None
            rank, position = divmod(rank, len(domain))
            fields.append(domain.value(position))
        return channel, tuple(reversed(fields))

    def name(self, event: int) -> str:
        """The event as the language writes it; ``tau`` and ``tick`` are those words, see :attr:`tau`."""
        if event == TAU:
            return self.tau
        if event == TICK:
            return self.tick
        channel, fields = self.parts(event)
        return ".".join([channel.name, *map(self._show, fields)])

    def all_events(self) -> EventSet:
        """``Events`` of a script in which every channel has finitely many events."""
        return EventSet([(channel.base, channel.base + (channel.size or 0)) for channel in self._channels])


class EventSet:
    """An immutable set of event identifiers, kept as sorted, disjoint, non-adjacent half-open ranges."""

    __slots__ = ("_hash", "_starts", "ranges")

    def __init__(self, ranges: Iterable[tuple[int, int]] = ()) -> None:
        merged: list[tuple[int, int]] = []
        for start, end in sorted(ranges):
            if start >= end:
                continue
            if merged and start <= merged[-1][1]:
                if end > merged[-1][1]:
                    merged[-1] = (merged[-1][0], end)
            else:
                merged.append((start, end))
        self.ranges = tuple(merged)
        self._starts = [start for start, _ in merged]
        self._hash = hash(self.ranges)

    @classmethod
    def _of_sorted(cls, ranges: list[tuple[int, int]]) -> EventSet:
        """The set with these ranges, which are as they are kept."""
        made = cls.__new__(cls)
        made.ranges = tuple(ranges)
        made._starts = [start for start, _ in ranges]
        made._hash = hash(made.ranges)
        return made

    @classmethod
    def of(cls, events: Iterable[int]) -> EventSet:
        """The set of the given identifiers."""
        return cls((e, e + 1) for e in events)

    def __contains__(self, event: int) -> bool:
        i = bisect_right(self._starts, event) - 1
        return i >= 0 and event < self.ranges[i][1]

    def __iter__(self) -> Iterator[int]:
        for start, end in self.ranges:
            yield from range(start, end)

    def __len__(self) -> int:
        return sum(end - start for start, end in self.ranges)

    def __bool__(self) -> bool:
        return bool(self.ranges)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, EventSet) and self.ranges == other.ranges

    def __hash__(self) -> int:
        return self._hash

    def __or__(self, other: EventSet) -> EventSet:
        return EventSet(self.ranges + other.ranges)

    def __and__(self, other: EventSet) -> EventSet:
        result: list[tuple[int, int]] = []
        i = j = 0
        while i < len(self.ranges) and j < len(other.ranges):
            start = max(self.ranges[i][0], other.ranges[j][0])
            end = min(self.ranges[i][1], other.ranges[j][1])
            if start < end:
                result.append((start, end))
            if self.ranges[i][1] < other.ranges[j][1]:
                i += 1
            else:
                j += 1
        return EventSet._of_sorted(result)

    def __sub__(self, other: EventSet) -> EventSet:
        result: list[tuple[int, int]] = []
        j = 0
        for start, end in self.ranges:
            while j < len(other.ranges) and other.ranges[j][1] <= start:
                j += 1
            k = j
            while k < len(other.ranges) and other.ranges[k][0] < end:
                if other.ranges[k][0] > start:
                    result.append((start, other.ranges[k][0]))
                start = max(start, other.ranges[k][1])
                k += 1
            if start < end:
                result.append((start, end))
        return EventSet._of_sorted(result)

    def __le__(self, other: EventSet) -> bool:
        return all(other.has_range(start, end) for start, end in self.ranges)

    def has_range(self, start: int, end: int) -> bool:
        """Whether all identifiers from *start* to below *end*, of which there are some, are in the set."""
        i = bisect_right(self._starts, start) - 1
        return i >= 0 and end <= self.ranges[i][1]

    def isdisjoint(self, other: EventSet) -> bool:
        """Whether the two sets have no event in common."""
        i = j = 0
        mine, theirs = self.ranges, other.ranges
        while i < len(mine) and j < len(theirs):
            if mine[i][1] <= theirs[j][0]:
                i += 1
            elif theirs[j][1] <= mine[i][0]:
                j += 1
            else:
                return False
        return True

    def __repr__(self) -> str:
        return f"EventSet({list(self.ranges)})"


def new_names(pairs: Iterable[tuple[int, int]]) -> dict[int, list[int]]:
    """The names of each event that a renaming with these (old, new) pairs renames, in their order."""
    names: dict[int, list[int]] = {}
    for old, name in pairs:
        names.setdefault(old, []).append(name)
    return names
