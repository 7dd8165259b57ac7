"""A program as machines and numbers: what targets that run tables are made of, whatever their language.

Every process of the composition is a machine, every event that can happen has a number, and for each event there are
the groups of tasks that can perform it. Nothing here knows of a language.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field

from cspcheck.codegen import messages
from cspcheck.codegen.design.machine import Machine, OperationalSemantics, machine
from cspcheck.codegen.design.network import Leaf, Network, Wire, network
from cspcheck.codegen.design.pieces import InternalChoice
from cspcheck.codegen.design.timing import TaskTiming, timings, tock
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.naming.symbols import SymbolKind
from cspcheck.cspm.oz.processes.classes import context_of
from cspcheck.cspm.process.events import Channel
from cspcheck.cspm.script import Script
from cspcheck.cspm.values.text import show

TOCK = "tock"
MOST_EVENTS = 60_000
"""Events are numbered in sixteen bits."""


@dataclass(frozen=True)
class SystemEvent:
    """An event that can happen: its name, its values by field, the groups of tasks that can perform it, and its number
    in the script."""

    name: str
    channel: int
    values: tuple[Hashable, ...]
    groups: tuple[frozenset[int], ...]
    identifier: int


@dataclass(frozen=True)
class SystemChannel:
    """A channel: its events are numbered from ``first``; ``domains`` has the values of each field, in order."""

    name: str
    label: str
    first: int
    count: int
    domains: tuple[tuple[Hashable, ...], ...]
    hidden: bool
    inner: bool
    rank: int
    clocked: bool


@dataclass(frozen=True)
class SystemState:
    """A state of a machine, with events by their numbers in the program."""

    text: str
    moves: tuple[tuple[int, int], ...]
    ways: tuple[int, ...]
    ends: bool


@dataclass(frozen=True)
class SystemMachine:
    """The states of a task, or of several of one definition: their events differ where they are plugged differently."""

    label: str
    text: str
    states: tuple[SystemState, ...]


@dataclass(frozen=True)
class SystemMethod:
    """What a task does when it performs the events of a channel alone.

    ``given`` are the positions of the fields that it is told, ``returned`` of those that it decides.
    """

    channel: int
    given: tuple[int, ...]
    returned: tuple[int, ...]


@dataclass(frozen=True)
class SystemTask:
    """A task: the machine that it runs, where it begins, and when."""

    name: str
    definition: str
    machine: int
    start: int
    timing: TaskTiming
    timed: int | None
    methods: tuple[SystemMethod, ...]


@dataclass
class System:
    """A program."""

    script: str
    process: str
    channels: list[SystemChannel]
    events: list[SystemEvent]
    machines: list[SystemMachine]
    tasks: list[SystemTask]
    tock: float = 1.0
    channel_of: list[int] = field(default_factory=list)


def system(
    script: Script, process: str, semantics: OperationalSemantics, internal_choice: InternalChoice = "refuse"
) -> System:
    """The machines of a process of a script.

    Raises:
        ScriptError: it is no composition of named processes, or one of them is no machine of a reasonable size.
    """
    return _Builder(script, process, semantics, internal_choice).build()


class _Builder:
    def __init__(
        self, script: Script, process: str, semantics: OperationalSemantics, internal_choice: InternalChoice
    ) -> None:
        self.script = script
        self.process = process
        self.semantics = semantics
        self.internal_choice = internal_choice
        self.channels: list[SystemChannel] = []
        self.events: list[SystemEvent] = []
        self.numbers: dict[tuple[int, int], int] = {}
        """The number of an event by its wire (by position) and its number in the script."""

    def build(self) -> System:
        """The whole."""
        script = self.script

        context = None if script.classes is None else context_of(script)

        def channels_of(text: str) -> list[str] | None:
            model = None if context is None else context.class_of(text)
            if model is None:
                return None
            return [c.name if c.kind == "chan" else f"{model.name}::{c.name}" for c in model.channels.values()]

        def alphabet(reference: object) -> tuple[int, ...]:
            return machine([reference], self.semantics, script.events).events()  # type: ignore[list-item]

        found = network(script.process(self.process), script.events, channels_of, alphabet)
        for position, wire in enumerate(found.wires):
            self._channel(position, wire)
        if len(self.events) > MOST_EVENTS:
            raise ScriptError(messages.too_large(self.process, "events", MOST_EVENTS, None))
        settings = timings(script.tree)
        machines: list[SystemMachine] = []
        tasks: list[SystemTask] = []
        known: dict[tuple[object, ...], int] = {}
        for number, leaf in enumerate(found.leaves):
            definition = leaf.reference.text.partition("(")[0]
            owner = None if context is None else context.class_of(definition)
            definition = definition if owner is None else owner.name
            made = machine([leaf.reference], self.semantics, script.events)
            symbol = script.names.top_level.get(definition)
            of_class = symbol is not None and channels_of(definition) is not None
            if made.chooses() and self.internal_choice == "refuse" and not of_class:
                span = leaf.reference.span
                if span is not None:
                    raise ScriptError(messages.internal_choice(span))
            states = self._states(leaf, made, found)
            key = (definition, states)
            place = known.get(key)
            if place is None:
                place = known[key] = len(machines)
                declared = symbol.declaration if symbol is not None and symbol.kind is not SymbolKind.BUILTIN else None
                text = declared.span.text if declared is not None else leaf.reference.text
                machines.append(SystemMachine(definition, text, states))
            timing = settings.get(definition, TaskTiming())
            timed = None
            if timing.at is not None:
                at = leaf.ports.get(timing.at) or leaf.ports.get(f"{definition}::{timing.at}")
                if at is None:
                    what = f"a period of `{definition}` at `{timing.at}`, which is no event of it"
                    raise ScriptError(messages.not_generated(what, leaf.reference.span))
                timed = found.wires.index(at)
            tasks.append(
                SystemTask(leaf.name, definition, place, made.starts[0], timing, timed, self._methods(number, states))
            )
        return System(
            script.source.name,
            self.process,
            self.channels,
            self.events,
            machines,
            tasks,
            tock(script.tree) if any(channel.clocked for channel in self.channels) else 1.0,
            [event.channel for event in self.events],
        )

    def _channel(self, position: int, wire: Wire) -> None:
        """Number the events of a channel that can happen: those that somebody performs, alone or with others."""
        channel: Channel = wire.channel
        first = len(self.events)
        groups: dict[int, set[frozenset[int]]] = {}
        for pieces, some in wire.pieces:
            for event in pieces:
                groups.setdefault(event, set()).update(some)
        for event in sorted(groups):
            self.numbers[position, event] = len(self.events)
            values = self.script.events.parts(event)[1]
            order = tuple(sorted(groups[event], key=sorted))
            self.events.append(SystemEvent(self.script.events.name(event), position, values, order, event))
        self.channels.append(
            SystemChannel(
                channel.name,
                wire.name,
                first,
                len(self.events) - first,
                tuple(() if domain is None else tuple(domain.values) for domain in channel.domains),
                wire.hidden,
                wire.inner,
                wire.rank or 0,
                channel.name == TOCK,
            )
        )

    def _states(self, leaf: Leaf, made: Machine, found: Network) -> tuple[SystemState, ...]:
        """The states of a task with the events as they are numbered in the program; what never happens is left out."""
        places = {name: found.wires.index(wire) for name, wire in leaf.ports.items()}
        rows = []
        for state in made.states:
            moves = []
            for event, target in state.moves:
                channel = self.script.events.parts(event)[0]
                place = places.get(channel.name)
                if place is None:
                    continue
                moved = event - channel.base + found.wires[place].channel.base
                number = self.numbers.get((place, moved))
                if number is not None:
                    moves.append((number, target))
            rows.append(SystemState(state.text, tuple(sorted(moves)), state.ways, state.ends))
        return tuple(rows)

    def _methods(self, task: int, states: tuple[SystemState, ...]) -> tuple[SystemMethod, ...]:
        """The channels whose events a task performs alone, where one way to call a method fits all states."""
        found: dict[int, SystemMethod | None] = {}
        for state in states:
            offered: dict[int, list[SystemEvent]] = {}
            for number, _ in state.moves:
                event = self.events[number]
                offered.setdefault(event.channel, []).append(event)
            for channel, events in offered.items():
                if self.channels[channel].clocked or any(event.groups != (frozenset([task]),) for event in events):
                    found[channel] = None
                    continue
                columns = list(zip(*[event.values for event in events], strict=True))
                fixed = [len(set(column)) == 1 for column in columns]
                given = tuple(i for i, is_fixed in enumerate(fixed) if is_fixed)
                returned = tuple(i for i, is_fixed in enumerate(fixed) if not is_fixed)
                method = SystemMethod(channel, given, returned)
                if found.setdefault(channel, method) != method:
                    found[channel] = None
        return tuple(method for _, method in sorted(found.items()) if method is not None)


def value_name(value: Hashable) -> str:
    """A value as the script writes it."""
    return show(value)
