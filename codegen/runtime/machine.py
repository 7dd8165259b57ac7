"""Machines: tasks whose states are the rows of a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple

from .channel import Offer
from .task import Task


class Move(NamedTuple):
    """What is offered in a state: on which attribute of the task, with which fields, and the state behind it.

    ``method`` is the method that does it where the task performs the event alone.
    """

    channel: str
    fields: tuple[Any, ...]
    target: int
    method: str | None = None


class Row(NamedTuple):
    """A state: the process that the task is there, and what it does.

    If there are ``ways``, the task goes one of them by itself. It may end where ``ends`` says so.
    """

    text: str
    moves: tuple[Move, ...] = ()
    ways: tuple[int, ...] = ()
    ends: bool = False


class MachineTask(Task):
    """A task that does what a table says.

    Args:
        start: the row in which it begins.
        clocked: the attributes of its channels that count time: an event of them happens every ``unit`` seconds, and
            never before everything else that can happen at that time.
    """

    ROWS: ClassVar[Sequence[Row]] = ()

    def __init__(
        self,
        name: str,
        start: int,
        *,
        clocked: tuple[str, ...] = (),
        unit: float = 1.0,
        timed: str | None = None,
        priority: int = 0,
        period: float | None = None,
        offset: float = 0.0,
    ) -> None:
        super().__init__(name, priority=priority, period=period, offset=offset)
        self.start = start
        self.clocked = frozenset(clocked)
        self.unit = unit
        self.timed = timed
        """The attribute of the channel that waits for the next release."""
        self.state = start

    async def run(self) -> None:
        """As the rows have it, from the start on."""
        state = self.start
        known: dict[int, tuple[Offer, ...]] = {}
        tocks = 0
        while True:
            row = self.ROWS[state]
            self.state = state
            if row.ways:
                state = row.ways[self.decide(len(row.ways)) if len(row.ways) > 1 else 0]
                continue
            if row.ends:
                return
            offers = known.get(state)
            if offers is None:
                offers = known[state] = tuple(self._offer(move) for move in row.moves)
            for i, move in enumerate(row.moves):
                if move.channel in self.clocked:
                    offers = (*offers[:i], offers[i].standing_from((tocks + 1) * self.unit), *offers[i + 1 :])
                elif move.channel == self.timed:
                    offers = (*offers[:i], offers[i].standing_from(self.release), *offers[i + 1 :])
            choice = await self.select(*offers)
            move = row.moves[choice.taken]
            state = move.target
            if move.channel in self.clocked:
                tocks += 1
            elif move.channel == self.timed:
                self.released()

    def _offer(self, move: Move) -> Offer:
        channel = getattr(self, move.channel)
        if move.method is None:
            return channel.offer(*move.fields)  # type: ignore[no-any-return]
        return channel.own(getattr(self.methods, move.method), *move.fields)  # type: ignore[no-any-return, attr-defined]
