"""The composition: which processes run side by side, and who takes part in which event.

A composition is a tree of parallel operators, hiding and renaming over named processes, the leaves. What it says of an
event is which groups of leaves can perform it together: the product of the groups of all operands where the operator
synchronises it, the union where not. That is all a program needs to know of the tree.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from cspcheck.codegen import messages
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.process.events import Channel, EventSet, EventTable
from cspcheck.cspm.process.terms import (
    AlphabetisedParallel,
    Buffer,
    Chaos,
    Compressed,
    Diverge,
    External,
    ExternalChoice,
    Hide,
    InternalChoice,
    Interrupt,
    LinkedParallel,
    Parallel,
    Prefix,
    Prioritised,
    Process,
    Project,
    Reference,
    Rename,
    Run,
    Sequential,
    SlidingChoice,
    Stop,
    SynchronisingChoice,
    SynchronisingInterrupt,
    Throw,
)
from cspcheck.cspm.process.text import describe

Group = frozenset[int]
"""Leaves, by position, that perform an event together."""
Pieces = list[tuple[EventSet, frozenset[Group]]]
"""Disjoint sets of events, each with the groups that can perform its events."""

LARGEST_LEAF = 20_000
"""A leaf with more terms than this is not searched for the events that it performs; its channels are taken whole."""
MOST_EVENTS = 4_096
"""A channel whose events have different groups is listed event by event, up to so many."""
MOST_LISTED = 64
"""A channel whose events have different groups is listed in any case if it has so few events: that says more."""
MOST_GROUPS = 64
"""A channel with more groups than this is listed event by event, where most groups fall away."""

_COMPOSED = (Parallel, AlphabetisedParallel, LinkedParallel, Hide, Project, Rename, Compressed)
_OPERATORS: dict[type[Process], str] = {
    Parallel: "a parallel operator",
    AlphabetisedParallel: "an alphabetised parallel",
    LinkedParallel: "a linked parallel",
    Hide: "hiding",
    Project: "projection",
    Rename: "renaming",
    Compressed: "a compression",
}


@dataclass(eq=False)
class Wire:
    """A channel of the program.

    ``groups`` holds for all of its events, unless ``by_event`` gives the groups for each. ``tasks`` are the leaves
    that offer some of its events, those among them that never find all of their partners. ``inner`` tells what is
    hidden by a part of the composition from what the whole of it hides. ``name`` is unique.
    """

    channel: Channel
    hidden: bool
    pieces: Pieces
    inner: bool = False
    name: str = ""
    tasks: tuple[int, ...] = ()
    groups: frozenset[Group] = frozenset()
    by_event: dict[int, frozenset[Group]] | None = None
    rank: int | None = None
    """Where priorities put the channel: its events happen only when none of a lower rank is possible."""

    def all_groups(self) -> frozenset[Group]:
        """Every group that can perform some event of the channel."""
        return frozenset(group for _, groups in self.pieces for group in groups)


@dataclass(eq=False)
class Leaf:
    """A process that becomes a task.

    ``ports`` says which wire the task has for each channel that its process mentions, by the channel's own name.
    """

    reference: Reference
    name: str
    events: EventSet
    ports: dict[str, Wire] = field(default_factory=dict)


@dataclass
class Network:
    """The leaves of a composition and the channels between them, in the order of declaration."""

    leaves: list[Leaf]
    wires: list[Wire]
    tables: set[int] = field(default_factory=set)
    """The leaves whose events only their machine tells: they apply something that no task does as it is written."""


class TaskAlphabets:
    """The events that sequential processes perform."""

    def __init__(self, table: EventTable) -> None:
        self.table = table

    def of(self, reference: Reference, name: str) -> EventSet:
        """All events that occur in the terms that *reference* can become; at most too many.

        Raises:
            ScriptError: the process becomes a composition later, or applies something that no task can do.
        """
        seen: set[Process] = {reference}
        todo: list[tuple[Process, Any]] = [(reference, reference.span)]
        events: set[int] = set()
        while todo:
            term, span = todo.pop()
            if isinstance(term, (Prioritised, External)):
                function = "prioritise" if isinstance(term, Prioritised) else term.function
                raise ScriptError(messages.not_generated(f"`{function}` in `{name}`", span))
            kind = _OPERATORS.get(type(term))
            if kind is not None:
                raise ScriptError(messages.dynamic(name, kind, span))
            if isinstance(term, (Interrupt, SynchronisingInterrupt, Throw, SynchronisingChoice, SlidingChoice)):
                operator = {Interrupt: "interrupt", Throw: "an exception", SlidingChoice: "the sliding choice `[>`"}
                what = operator.get(type(term), "a synchronising choice or interrupt")
                raise ScriptError(messages.not_generated(f"{what} in `{name}`", span))
            if isinstance(term, (Run, Chaos, Buffer, Diverge)):
                what = f"`{describe(term, self.table)}` in `{name}`"
                raise ScriptError(messages.not_generated(what, span, "write it as a process with prefixes"))
            if isinstance(term, Prefix):
                events.update(event for event, _ in term.branches)
            for part in _parts(term):
                if part not in seen:
                    seen.add(part)
                    todo.append((part, part.span if isinstance(part, Reference) and part.span else span))
            if len(seen) > LARGEST_LEAF:
                return _whole_channels(events, self.table)
        return _from_numbers(events)


def _parts(term: Process) -> Iterator[Process]:
    match term:
        case Reference():
            yield term.body()
        case Prefix():
            yield from (after for _, after in term.branches)
        case ExternalChoice() | InternalChoice():
            yield from term.operands
        case Sequential():
            yield term.left
            yield term.right


def _whole_channels(events: Iterable[int], table: EventTable) -> EventSet:
    channels = {table.parts(event)[0] for event in events}
    return EventSet((channel.base, channel.base + channel.size) for channel in channels if channel.size)


def _from_numbers(numbers: Iterable[int]) -> EventSet:
    return EventSet((number, number + 1) for number in sorted(numbers))


@dataclass
class _Part:
    """A part of the composition: its leaves, and for the channels that are still open its pieces.

    ``bound`` says for each leaf under which channel an open port is known at this level.
    """

    leaves: list[int]
    pieces: Pieces
    bound: dict[tuple[int, str], Channel]


class CompositionDesigner:
    """Takes a composition apart. Use :func:`network`."""

    def __init__(
        self,
        table: EventTable,
        classes: Callable[[str], Iterable[str] | None],
        alphabet: Callable[[Reference], Iterable[int]] | None = None,
    ) -> None:
        self.table = table
        self._classes = classes
        self._alphabet = alphabet
        self._levels: tuple[EventSet, ...] = ()
        self._ranking = False
        self.tables: set[int] = set()
        self.leaves: list[Leaf] = []
        self.wires: list[Wire] = []
        self._alphabets = TaskAlphabets(table)
        self._whole = {
            channel.name: EventSet([(channel.base, channel.base + channel.size)])
            for channel in table.channels
            if channel.size
        }
        self._known: dict[Process, EventSet] = {}
        self._by_table: set[Process] = set()
        self._names: dict[str, int] = {}

    def part(self, term: Process, outer: bool = False) -> _Part:
        """What a term contributes; *outer*: it is the whole composition, or that without its outermost hiding.

        Raises:
            ScriptError: it is no composition of named processes.
        """
        match term:
            case Reference():
                body = term.body()
                composed = isinstance(body, _COMPOSED) or (isinstance(body, Prioritised) and self._may_rank(outer))
                # Behind the name of its class stands the class as a whole, one component of the program.
                whole = composed and not ("::" in term.text and self._classes(term.text) is not None)
                return self.part(body, outer) if whole else self._leaf(term)
            case Prioritised() if self._may_rank(outer):
                self._levels = term.levels
                self._ranking = True
                inside = self.part(term.process, outer)
                self._ranking = False
                return inside
            case Stop():
                return _Part([], [], {})
            case Compressed():
                return self.part(term.process)
            case Parallel():
                return self._fold(term.operands, lambda i: term.events, lambda i: None)
            case AlphabetisedParallel():
                return self._alphabetised(term)
            case Hide():
                return self._hide(self.part(term.process, outer), term.events, outer)
            case Project():
                part = self.part(term.process)
                everything = EventSet([r for piece, _ in part.pieces for r in piece.ranges])
                return self._hide(part, everything - term.events, False)
            case Rename():
                return self._rename(self.part(term.process), term.pairs, "renames")
            case LinkedParallel():
                return self._link(term)
        raise ScriptError(messages.unnamed_task(describe(term, self.table), None))

    def _may_rank(self, outer: bool) -> bool:
        """Whether priorities met here are those of the whole: then events have ranks when the program runs."""
        return outer and not self._levels and self._alphabet is not None

    def _leaf(self, reference: Reference) -> _Part:
        channels_of_class = self._classes(reference.text)
        text = reference.text.removesuffix("::visible") if channels_of_class is not None else reference.text
        count = self._names[text] = self._names.get(text, 0) + 1
        name = text if count == 1 else f"{text}#{count}"
        events = self._known.get(reference)
        if events is None:
            if channels_of_class is None:
                try:
                    events = self._alphabets.of(reference, text)
                except ScriptError:
                    if self._alphabet is None:
                        raise
                    events = _from_numbers(self._alphabet(reference))
                    self._by_table.add(reference)
            else:
                events = self._of_channels(channels_of_class, reference)
            self._known[reference] = events
        number = len(self.leaves)
        if reference in self._by_table:
            self.tables.add(number)
        self.leaves.append(Leaf(reference, name, events))
        channels = {channel for channel in self.table.channels if self._overlaps(events, channel)}
        pieces: Pieces = [(events, frozenset([frozenset([number])]))] if events else []
        return _Part([number], pieces, {(number, channel.name): channel for channel in channels})

    def _of_channels(self, names: Iterable[str], reference: Reference) -> EventSet:
        events = EventSet()
        for name in names:
            if name not in self._whole:
                what = f"the channel `{name}`, which has infinitely many events"
                help = "give the types of its fields finite readings: `reading nat = 0..3`"
                raise ScriptError(messages.not_generated(what, reference.span, help))
            events = events | self._whole[name]
        return events

    def _overlaps(self, events: EventSet, channel: Channel) -> bool:
        return not events.isdisjoint(self._whole.get(channel.name, EventSet()))

    def _fold(
        self, operands: tuple[Process, ...], shared: Callable[[int], EventSet], only: Callable[[int], EventSet | None]
    ) -> _Part:
        """Operands from left to right, each sharing some events with those before it."""
        whole = self._restricted(self.part(operands[0]), only(0))
        for i, operand in enumerate(operands[1:], 1):
            part = self._restricted(self.part(operand), only(i))
            pieces = joined(whole.pieces, part.pieces, shared(i))
            whole = _Part(whole.leaves + part.leaves, pieces, whole.bound | part.bound)
        return whole

    def _alphabetised(self, term: AlphabetisedParallel) -> _Part:
        before: list[EventSet] = [EventSet()]
        for alphabet in term.alphabets:
            before.append(before[-1] | alphabet)
        return self._fold(term.operands, lambda i: before[i] & term.alphabets[i], lambda i: term.alphabets[i])

    def _restricted(self, part: _Part, alphabet: EventSet | None) -> _Part:
        if alphabet is None:
            return part
        pieces = [(piece & alphabet, groups) for piece, groups in part.pieces]
        return _Part(part.leaves, [(piece, groups) for piece, groups in pieces if piece], part.bound)

    def _hide(self, part: _Part, events: EventSet, outer: bool) -> _Part:
        """Finish the channels that are hidden: nothing outside takes part in them."""
        pieces = part.pieces
        bound = dict(part.bound)
        for channel in self.table.channels:
            whole = self._whole.get(channel.name)
            if whole is None or events.isdisjoint(whole):
                continue
            used = EventSet([r for piece, _ in pieces for r in (piece & whole).ranges])
            if not used:
                continue
            if not used <= events:
                raise ScriptError(messages.part_of_channel("hides", channel.name))
            self._finish(channel, True, pieces, bound, inner=not outer and "::" not in channel.name)
            pieces = _outside(pieces, whole)
        return _Part(part.leaves, pieces, bound)

    def _finish(
        self,
        channel: Channel,
        hidden: bool,
        pieces: Pieces,
        bound: dict[tuple[int, str], Channel],
        *,
        inner: bool = False,
    ) -> None:
        """Make the wire of a channel, and plug it into the ports of all leaves that have the channel."""
        wire = Wire(channel, hidden, _inside(pieces, self._whole[channel.name]), inner)
        if hidden and self._ranking:
            wire.rank = 0  # what is hidden ranks with the first
        self.wires.append(wire)
        self._plug(wire, channel, bound)

    def _plug(self, wire: Wire, channel: Channel, bound: dict[tuple[int, str], Channel]) -> None:
        for (leaf, port), outer in list(bound.items()):
            if outer is channel:
                self.leaves[leaf].ports[port] = wire
                del bound[leaf, port]

    def _rename(self, part: _Part, pairs: Iterable[tuple[int, int]], what: str) -> _Part:
        """Rename whole channels, field by field."""
        targets: dict[str, Channel] = {}
        moved: dict[int, int] = {}
        for old, new in pairs:
            (source, fields), (target, others) = self.table.parts(old), self.table.parts(new)
            if fields != others or targets.setdefault(source.name, target) is not target or old in moved:
                raise ScriptError(messages.part_of_channel(what, source.name))
            moved[old] = new
        before = {channel.name: channel for channel in part.bound.values()}
        after = [targets.get(name, channel) for name, channel in before.items()]
        for channel in after:
            if after.count(channel) > 1:
                raise ScriptError(messages.merged(channel.name))
        pieces: Pieces = []
        for piece, groups in part.pieces:
            kept = piece
            for name in targets:
                inside = piece & self._whole[name]
                if any(event not in moved for event in inside):
                    raise ScriptError(messages.part_of_channel(what, name))
                kept = kept - inside
                if inside:
                    pieces = joined(pieces, [(_from_numbers(moved[event] for event in inside), groups)], EventSet())
            if kept:
                pieces = joined(pieces, [(kept, groups)], EventSet())
        bound = {port: targets.get(channel.name, channel) for port, channel in part.bound.items()}
        return _Part(part.leaves, pieces, bound)

    def _link(self, term: LinkedParallel) -> _Part:
        """Left's a and right's b become one hidden channel, called like a."""
        left, right = self.part(term.left), self.part(term.right)
        partners: dict[str, tuple[Channel, Channel]] = {}
        linked: dict[str, list[int]] = {}
        for a, b in term.links:
            (mine, fields), (theirs, others) = self.table.parts(a), self.table.parts(b)
            if fields != others or partners.setdefault(mine.name, (mine, theirs))[1] is not theirs:
                raise ScriptError(messages.part_of_channel("links", mine.name))
            linked.setdefault(mine.name, []).append(a)
        for name, (mine, theirs) in partners.items():
            events = _from_numbers(linked[name])
            of_left = _inside(left.pieces, self._whole[mine.name])
            of_right = [
                (EventSet((x + mine.base - theirs.base, y + mine.base - theirs.base) for x, y in piece.ranges), groups)
                for piece, groups in _inside(right.pieces, self._whole[theirs.name])
            ]
            for pieces in (of_left, of_right):
                if any(not piece <= events for piece, _ in pieces):
                    raise ScriptError(messages.part_of_channel("links", name))
            wire = Wire(mine, True, joined(of_left, of_right, events), inner=True, rank=0 if self._ranking else None)
            self.wires.append(wire)
            for part, channel in ((left, mine), (right, theirs)):
                part.pieces = _outside(part.pieces, self._whole[channel.name])
                self._plug(wire, channel, part.bound)
        return _Part(
            left.leaves + right.leaves, joined(left.pieces, right.pieces, EventSet()), left.bound | right.bound
        )

    def finish(self, part: _Part) -> Network:
        """The network, with all channels that are still open visible."""
        bound = dict(part.bound)
        for channel in self.table.channels:
            whole = self._whole.get(channel.name)
            if whole is not None and any(outer is channel for outer in bound.values()):
                self._finish(channel, False, part.pieces, bound)
        used: dict[str, int] = {}
        order = {channel.name: i for i, channel in enumerate(self.table.channels)}
        self.wires.sort(key=lambda wire: order[wire.channel.name])
        for wire in self.wires:
            count = used[wire.channel.name] = used.get(wire.channel.name, 0) + 1
            wire.name = wire.channel.name if count == 1 else f"{wire.channel.name}_{count}"
            self._settle(wire)
            if wire.rank is None:
                wire.rank = self._rank(wire.channel)
        return Network(self.leaves, self.wires, self.tables)

    def _rank(self, channel: Channel) -> int | None:
        """The rank of a channel: 0 is the highest; None: priorities do not speak of it."""
        whole = self._whole[channel.name]
        for rank, events in enumerate(self._levels):
            if whole <= events:
                return rank
            if not whole.isdisjoint(events):
                raise ScriptError(messages.part_of_channel("gives a priority to", channel.name))
        return None

    def _settle(self, wire: Wire) -> None:
        """Say who takes part: for the whole channel if that is the same for all events that could come about."""
        channel, size = wire.channel, wire.channel.size
        offered: dict[int, EventSet] = {}
        for number, leaf in enumerate(self.leaves):
            for port, plugged in leaf.ports.items():
                if plugged is wire:
                    source = next(c for c in self.table.channels if c.name == port)
                    shift = channel.base - source.base
                    events = leaf.events & self._whole[port]
                    moved = EventSet((x + shift, y + shift) for x, y in events.ranges)
                    offered[number] = offered.get(number, EventSet()) | moved
        groups = wire.all_groups()
        events_in_all = sum(len(events) for events, _ in wire.pieces)
        listed = len(wire.pieces) > 1 and events_in_all <= MOST_LISTED
        allowed = {
            group: EventSet([r for e, some in wire.pieces if group in some for r in e.ranges]) for group in groups
        }
        wire.tasks = tuple(offered)
        wire.groups = groups
        for group in groups:
            possible = None
            for member in group:
                possible = offered[member] if possible is None else possible & offered[member]
            if possible is not None and not possible <= allowed[group]:
                break
        else:
            if not listed and all(self._agreeing(group, offered) for group in groups) and len(groups) <= MOST_GROUPS:
                return
        if size is None or size > MOST_EVENTS:
            raise ScriptError(messages.part_of_channel("joins different tasks for", channel.name))
        wire.by_event = {event: some for events, some in wire.pieces for event in events}

    def _agreeing(self, group: Group, offered: dict[int, EventSet]) -> bool:
        """Whether the tasks of a group have any event in common; a table of events leaves such groups out."""
        events = [offered[leaf] for leaf in group]
        common = events[0]
        for other in events[1:]:
            common = common & other
        return bool(common)


def joined(left: Pieces, right: Pieces, shared: EventSet) -> Pieces:
    """The pieces of two parts side by side that synchronise on the events of *shared*."""
    result: Pieces = []

    def add(events: EventSet, groups: frozenset[Group]) -> None:
        if events and groups:
            result.append((events, groups))

    in_left = EventSet([r for piece, _ in left for r in piece.ranges])
    in_right = EventSet([r for piece, _ in right for r in piece.ranges])
    for piece, groups in left:
        add(piece - in_right - shared, groups)
    for piece, groups in right:
        add(piece - in_left - shared, groups)
    for mine, groups in left:
        for theirs, others in right:
            both = mine & theirs
            if both:
                add(both & shared, frozenset(one | other for one in groups for other in others))
                add(both - shared, groups | others)
    merged: dict[frozenset[Group], EventSet] = {}
    for events, groups in result:
        merged[groups] = merged.get(groups, EventSet()) | events
    return [(events, groups) for groups, events in merged.items()]


def _inside(pieces: Pieces, events: EventSet) -> Pieces:
    return [(piece & events, groups) for piece, groups in pieces if piece & events]


def _outside(pieces: Pieces, events: EventSet) -> Pieces:
    return [(piece - events, groups) for piece, groups in pieces if piece - events]


def network(
    term: Process,
    table: EventTable,
    classes: Callable[[str], Iterable[str] | None] = lambda text: None,
    alphabet: Callable[[Reference], Iterable[int]] | None = None,
) -> Network:
    """The tasks and channels of a composition.

    Args:
        term: the composition.
        table: the events of the script.
        classes: the channels of a class by what its process is called; None for what is no class.
        alphabet: the events of a process that no task does as it is written, if such processes are wanted.

    Raises:
        ScriptError: it is no composition of named sequential processes.
    """
    composition = CompositionDesigner(table, classes, alphabet)
    return composition.finish(composition.part(term, outer=True))
