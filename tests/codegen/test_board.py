"""The board finds exactly the events that are possible: held against a search through everything."""

from __future__ import annotations

from itertools import product
from typing import Any

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.codegen.runtime import ANY, Channel, Fair, Integers, Offer, OutOfRange, Program, Task, one_of
from cspcheck.codegen.runtime.alternation import Board, Commit
from tests.examples import examples

TASKS = "ABC"
VALUES = range(2)
Seen = tuple[str, tuple[tuple[str, int], ...], tuple[int, ...]]


def _body(*values: int) -> int:
    return values[0] if values else 0


@st.composite
def channels(draw: st.DrawFn) -> list[Channel]:
    """Some channels: with groups, or with groups that depend on the value."""
    found = []
    for i in range(draw(st.integers(1, 3))):
        pairs = draw(st.booleans())
        group = st.frozensets(st.sampled_from(TASKS), min_size=2 if pairs else 1, max_size=2 if pairs else 3)
        groups = draw(st.lists(group, min_size=1, max_size=4, unique=True))
        parties: Any = groups
        if draw(st.integers(0, 3)) == 0:
            parties = {(v,): draw(st.lists(st.sampled_from(groups), max_size=2)) for v in VALUES}
        found.append(Channel(f"c{i}", [Integers(0, VALUES[-1])], parties=parties, never=TASKS))
    return found


@st.composite
def offer(draw: st.DrawFn, some: list[Channel]) -> Offer | None:
    """An offer of any kind on one of some channels, or none."""
    channel = draw(st.sampled_from(some))
    field = draw(st.sampled_from([*VALUES, ANY, one_of([0]), one_of([0, 1])]))
    kind = draw(st.sampled_from(["none", "put", "put", "get", "get", "accept", "after", "own"]))
    if kind == "put":
        return channel.offer(field)
    if kind == "get":
        return channel.get()
    if kind == "accept":
        return channel.offer(field, accept=lambda x: x == 1)
    if kind == "after":
        return channel.offer(field, after=draw(st.integers(1, 3)))
    return channel.own(_body, field) if kind == "own" else None


def every(waiting: dict[str, tuple[Offer | None, ...]], some: list[Channel], now: float) -> set[Seen]:
    """All events with all their values: each group, each way in which its tasks offer something, each value."""
    found = set()
    for channel in some:
        groups = channel.groups if channel.by_event is None else {g for gs in channel.by_event.values() for g in gs}
        for group in groups:
            if not all(task in waiting for task in group):
                continue
            names = sorted(group)
            for row in product(*[[(i, o) for i, o in enumerate(waiting[n]) if o is not None] for n in names]):
                offers = [o for _, o in row]
                if any(o.channel is not channel or (o.after or 0) > now for o in offers):
                    continue
                if len(group) > 1 and any(o.body is not None for o in offers):
                    continue
                for v in VALUES:
                    if channel.by_event is not None and group not in channel.by_event.get((v,), ()):
                        continue
                    if all(_takes(o, v) for o in offers):
                        parts = tuple((n, i) for n, (i, _) in zip(names, row, strict=True))
                        found.add((channel.name, parts, (v,)))
    return found


def _takes(one: Offer, value: int) -> bool:
    (field,) = one.fields
    allowed = field is ANY or value == field or (hasattr(field, "values") and value in field.values)
    return allowed and (one.accept is None or one.accept(value))


def listed(commits: list[Commit]) -> set[Seen]:
    """The same of what the board says; a method may give any value that it may."""
    assert len(commits) == len({commit.parts for commit in commits}), "an event twice"
    found = set()
    for commit in commits:
        if commit.own:
            (row,) = commit.candidates
            given = VALUES if row[0] is ANY else row[0].values if hasattr(row[0], "values") else row
            by_event, group = commit.channel.by_event, frozenset(commit.tasks)
            values = [(v,) for v in given if by_event is None or group in by_event.get((v,), ())]
        else:
            values = list(commit.candidates)
        found |= {(commit.channel.name, commit.parts, value) for value in values}
    return found


@settings(max_examples=examples(300))
@given(st.data())
def test_what_the_board_says_is_what_there_is(data: st.DataObject) -> None:
    some = data.draw(channels())
    of_some = offer(some)
    selections = {task: [tuple(data.draw(st.lists(of_some, max_size=3))) for _ in range(2)] for task in TASKS}
    kept, asked = Board(keeps=True), Board()
    waiting: dict[str, tuple[Offer | None, ...]] = {}
    now = 0
    for _ in range(data.draw(st.integers(1, 16))):
        now += data.draw(st.integers(0, 1))
        task = data.draw(st.sampled_from(TASKS))
        if task in waiting:
            del waiting[task]
            kept.remove((task,))
            asked.remove((task,))
        offers = data.draw(st.sampled_from(selections[task]))
        commits = asked.commits_of(asked.plan(task, offers), now)
        waiting[task] = offers
        assert listed(commits) == {e for e in every(waiting, some, now) if task in [name for name, _ in e[1]]}
        asked.add(asked.plan(task, offers), now)
        kept.add(kept.plan(task, offers), now)
        assert listed(kept.possible(now)) == every(waiting, some, now)
    now = 5
    assert listed(kept.possible(now)) == every(waiting, some, now)
    names = tuple(sorted(waiting))
    kept.remove(names)
    assert kept.possible(now) == []


def test_an_offer_that_is_made_again_is_the_same_and_equal_values_are_not() -> None:
    c = Channel("c", [Integers(0, 9)], parties=["P"])
    assert c.put(1) is c.put(1)
    assert c.put(True) is not c.put(1)
    board = Board()
    board.plan("P", (c.put(1),))
    with pytest.raises(OutOfRange):
        board.plan("P", (c.put(True),))


@pytest.mark.parametrize("runner", ["loop", "asyncio"])
def test_senders_of_one_channel_are_taken_in_turn(runner: Any) -> None:
    c = Channel("c", [Integers(0, 3), Integers(0, 9)], parties=[(f"P{i}", "C") for i in range(4)])
    taken: list[int] = []

    class Sends(Task):
        async def run(self) -> None:
            while True:
                await self.perform(c.put(int(self.name[1:]), 0))

    class Takes(Task):
        async def run(self) -> None:
            while True:
                taken.append((await self.perform(c.get()))[0])

    Program([Takes("C"), *[Sends(f"P{i}") for i in range(4)]]).run(runner, policy=Fair(), events=40)
    assert all(sorted(taken[i : i + 4]) == [0, 1, 2, 3] for i in range(8, 36, 4))
