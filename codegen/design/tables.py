"""Machines as tables of a program: for each state what is offered on each channel, and the state behind it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from cspcheck.codegen.design.data import DataDesigner
from cspcheck.codegen.design.machine import Machine, MachineState
from cspcheck.codegen.design.pieces import Method
from cspcheck.codegen.quoting import literal
from cspcheck.cspm.process.events import Channel, EventTable

Column = frozenset[Any] | None
"""The values of one field of an offer; None stands for all that it can have."""


@dataclass(frozen=True)
class Offered:
    """The events of one channel that lead from a state to another, as the product of the values of their fields."""

    channel: Channel
    columns: tuple[Column, ...]
    target: int


def offers(state: MachineState, table: EventTable) -> list[Offered]:
    """What a state offers, channel by channel, in as few offers as products of fields allow."""
    rows: dict[tuple[str, int], tuple[Channel, list[tuple[Any, ...]]]] = {}
    for event, target in state.moves:
        channel, values = table.parts(event)
        rows.setdefault((channel.name, target), (channel, []))[1].append(values)
    found: list[Offered] = []
    for (_, target), (channel, events) in rows.items():
        columns = _products(events, [None if domain is None else len(domain) for domain in channel.domains])
        found += [Offered(channel, one, target) for one in columns]
    return found


def _products(rows: Sequence[tuple[Any, ...]], sizes: Sequence[int | None]) -> list[tuple[Column, ...]]:
    """Rows of values as products of columns: those with the same rest are one product."""
    if not sizes:
        return [()]
    rests: dict[Any, list[tuple[Any, ...]]] = {}
    for first, *rest in rows:
        rests.setdefault(first, []).append(tuple(rest))
    firsts: dict[frozenset[tuple[Any, ...]], list[Any]] = {}
    for first, others in rests.items():
        firsts.setdefault(frozenset(others), []).append(first)
    found: list[tuple[Column, ...]] = []
    for values in firsts.values():
        column = None if len(values) == sizes[0] and len(values) > 1 else frozenset(values)
        found += [(column, *columns) for columns in _products(rests[values[0]], sizes[1:])]
    return found


class TableWriter:
    """Writes the rows of one task.

    Args:
        data: for the values.
        events: of the script.
        port: the attribute of the task for a channel, by its name.
        own: whether the task performs the events of a channel alone.
        name: what the method of a channel is called.
    """

    def __init__(
        self,
        data: DataDesigner,
        events: EventTable,
        port: Callable[[str], str],
        own: Callable[[str], bool],
        name: Callable[[str], str],
    ) -> None:
        self.data = data
        self.events = events
        self.methods: dict[str, Method] = {}
        self._port = port
        self._own = own
        self._name = name

    def rows(self, machine: Machine) -> list[str]:
        """The rows, a line of Python each or some; fills in ``methods``."""
        rows = [offers(state, self.events) for state in machine.states]
        self._find_methods(one for row in rows for one in row)
        lines: list[str] = []
        for number, (state, row) in enumerate(zip(machine.states, rows, strict=True)):
            lines.append(f"# {number}")
            arguments = [str(literal(state.text))]
            moves = [self._move(one) for one in row]
            if moves:
                arguments.append(f"({', '.join(moves)},)")
            if state.ways:
                arguments.append(f"ways=({', '.join(map(str, state.ways))},)")
            if state.ends:
                arguments.append("ends=True")
            line = f"Row({', '.join(arguments)}),"
            if len(line) <= 104:
                lines.append(line)
            else:
                lines += ["Row(", f"    {arguments[0]},"]
                if moves:
                    lines += ["    (", *[f"        {move}," for move in moves], "    ),"]
                lines += [f"    {argument}," for argument in arguments[1 + bool(moves) :]]
                lines.append("),")
        return lines

    def _find_methods(self, found: Iterable[Offered]) -> None:
        """The methods of the channels whose events the task performs alone, where one signature fits all states."""
        plain: set[str] = set()
        for one in found:
            channel = one.channel.name
            if not self._own(channel):
                continue
            fixed = [column is not None and len(column) == 1 for column in one.columns]
            given = tuple(i for i, is_fixed in enumerate(fixed) if is_fixed)
            returned = tuple(i for i, is_fixed in enumerate(fixed) if not is_fixed)
            method = Method(channel, self._name(channel), given, returned)
            if self.methods.setdefault(channel, method) != method:
                plain.add(channel)
        for channel in plain:
            del self.methods[channel]

    def _move(self, offered: Offered) -> str:
        """One offer: the attribute of the channel, the fields, the state behind it, and the method if there is one."""
        where = f"the events of `{offered.channel.name}`"
        fields = []
        for column, domain in zip(offered.columns, offered.channel.domains, strict=True):
            if column is None:
                fields.append("ANY")
                continue
            order = list(column) if domain is None else [value for value in domain.values if value in column]
            texts = [self.data.literal(value, where) for value in order]
            fields.append(texts[0] if len(texts) == 1 else f"one_of(({', '.join(texts)}))")
        inside = f"({', '.join(fields)}{',' if len(fields) == 1 else ''})"
        method = self.methods.get(offered.channel.name)
        last = "" if method is None else f", {literal(method.name)}"
        return f"Move({literal(self._port(offered.channel.name))}, {inside}, {offered.target}{last})"
