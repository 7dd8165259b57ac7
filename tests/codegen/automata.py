"""Small random programs whose runs can be judged without the runtime: every task is a table of what it offers."""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import strategies as st

from cspcheck.codegen.runtime import ANY, Channel, Integers, Record, Task, one_of

VALUES = range(3)
Move = tuple[int, int | frozenset[int] | None, int]
"""A channel by number, what is offered on it (a value, anything, some values), and the state behind it."""


@dataclass(frozen=True)
class Automaton:
    """For each state the moves that are offered in it."""

    states: tuple[tuple[Move, ...], ...]

    def after(self, state: int, channel: int, value: int) -> set[int]:
        """The states in which the automaton can be after an event."""
        return {
            target
            for on, offered, target in self.states[state]
            if on == channel
            and (offered is None or offered == value or (isinstance(offered, frozenset) and value in offered))
        }


@dataclass(frozen=True)
class Design:
    """Automata and the groups that each channel joins."""

    automata: tuple[Automaton, ...]
    groups: tuple[tuple[frozenset[int], ...], ...]

    def program(self) -> tuple[list[Channel], list[Task]]:
        """Channels and tasks that do this."""
        channels = [
            Channel(f"c{i}", [Integers(0, VALUES[-1])], parties=[[f"T{j}" for j in group] for group in groups])
            for i, groups in enumerate(self.groups)
        ]
        return channels, [Walker(f"T{j}", automaton, channels) for j, automaton in enumerate(self.automata)]

    def judge(self, records: list[Record]) -> list[set[int]]:
        """The states in which each automaton can be after a run; fails if it is no run of the design."""
        where: list[set[int]] = [{0} for _ in self.automata]
        for record in records:
            if record.channel == "tick":
                continue
            channel, (value,) = int(record.channel[1:]), record.values
            tasks = frozenset(int(name[1:]) for name in record.tasks)
            assert tasks in self.groups[channel], record
            for j in tasks:
                where[j] = {t for state in where[j] for t in self.automata[j].after(state, channel, value)}
                assert where[j], record
        return where

    def possible(self, where: tuple[int, ...]) -> bool:
        """Whether any event is possible with the automata in these states."""
        return any(
            all(self.automata[j].after(where[j], channel, value) for j in group)
            for channel, groups in enumerate(self.groups)
            for group in groups
            for value in VALUES
        )


class Walker(Task):
    """A task that does what an automaton says, and counts what it did."""

    def __init__(self, name: str, automaton: Automaton, channels: list[Channel]) -> None:
        super().__init__(name)
        self.automaton = automaton
        self.channels = channels
        self.log: list[tuple[str, int]] = []
        self.state = 0

    async def run(self) -> None:
        self.state = 0
        while True:
            moves = [move for move in self.automaton.states[self.state] if move[0] < len(self.channels)]
            moves = [move for move in moves if self.name in self.channels[move[0]].tasks]
            fields = [
                ANY if offered is None else one_of(offered) if isinstance(offered, frozenset) else offered
                for _, offered, _ in moves
            ]
            offers = [self.channels[on].offer(field) for (on, _, _), field in zip(moves, fields, strict=True)]
            choice = await self.select(*offers)
            on, _, self.state = moves[choice.taken]
            self.log.append((self.channels[on].name, choice.values[0]))


@st.composite
def designs(draw: st.DrawFn, *, most_tasks: int = 4, most_channels: int = 4) -> Design:
    """Automata of up to three states on channels of up to three groups."""
    tasks = draw(st.integers(1, most_tasks))
    channels = draw(st.integers(1, most_channels))
    group = st.frozensets(st.integers(0, tasks - 1), min_size=1, max_size=3)
    groups = tuple(tuple(draw(st.lists(group, min_size=1, max_size=3, unique=True))) for _ in range(channels))
    offered = st.one_of(
        st.sampled_from(VALUES), st.none(), st.frozensets(st.sampled_from(VALUES), min_size=1).map(frozenset)
    )
    automata = []
    for j in range(tasks):
        mine = [i for i, some in enumerate(groups) if any(j in group for group in some)]
        size = draw(st.integers(1, 3))
        move = st.tuples(st.sampled_from(mine or [channels]), offered, st.integers(0, size - 1))
        rows = tuple(tuple(draw(st.lists(move, max_size=3))) for _ in range(size))
        automata.append(Automaton(rows if mine else ((),)))
    return Design(tuple(automata), groups)
