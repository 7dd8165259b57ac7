"""Alternation: which events are possible between what the tasks offer, and the choice of exactly one.

A task that waits has made a selection: some offers, of which one will be taken. An event is possible when all tasks of
one group of its channel have an offer for it, with agreeing values. That is looked at in one place with everything
in view, so input and output guards are alike, any number of tasks can meet, and no offer is ever taken half: a
receive that was begun and then cancelled would have lost its message.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice, product
from random import Random
from typing import Any, NamedTuple, Protocol

from .channel import ANY, Channel, Group, Offer, OneOf, Values
from .data import LARGEST


class Choice(NamedTuple):
    """The offer that was taken, by its position in the selection, and the values that came."""

    taken: int
    values: Values


class Commit(NamedTuple):
    """A possible event: the tasks that perform it, each with the position of its offer, and the possible values.

    ``candidates`` has more than one entry only where no offer gives a value: then somebody has to choose.
    """

    channel: Channel
    parts: tuple[tuple[str, int], ...]
    candidates: Sequence[Values]


class NobodyDecides(Exception):
    """All offers take any value of a field, and its values cannot be listed."""


class _Met(NamedTuple):
    """The events in which two offers meet, each by its position in its selection."""

    first: Offer
    second: Offer
    positions: tuple[int, int]
    commits: Sequence[Commit]
    """With the first task of the channel first."""
    other_way: Sequence[Commit]
    """With the second one first."""


class Board:
    """What the waiting tasks offer. Not safe for concurrent use: the caller has the lock."""

    def __init__(self) -> None:
        self.waiting: dict[str, Sequence[Offer | None]] = {}
        self._plans: dict[str, tuple[Sequence[Offer | None], list[tuple[Channel, list[int]]]]] = {}
        """The last selection of each task, and where its offers are in it: most tasks make the same again and again."""
        self._met: dict[Channel, _Met] = {}
        """What was found on channels of two tasks: it holds whenever both make the same offers again."""
        self._on: dict[Channel, dict[str, list[int]]] = {}
        self._known: dict[Channel, list[Commit]] = {}
        """The possible events of channels on which nothing has changed since they were looked for."""

    def add(self, task: str, offers: Sequence[Offer | None]) -> None:
        """A task waits for one of its *offers*; None among them stands for one whose guard is false."""
        self.waiting[task] = offers
        on, known = self._on, self._known
        for channel, positions in self._plan(task, offers):
            known.pop(channel, None)
            if channel in on:
                on[channel][task] = positions
            else:
                on[channel] = {task: positions}

    def remove(self, task: str) -> None:
        """A task waits no longer."""
        on, known = self._on, self._known
        for channel, _ in self._plan(task, self.waiting.pop(task)):
            known.pop(channel, None)
            on[channel].pop(task, None)

    def _plan(self, task: str, offers: Sequence[Offer | None]) -> list[tuple[Channel, list[int]]]:
        """The channels of a selection, each with the positions of its offers."""
        last = self._plans.get(task)
        if last is not None and last[0] == offers:  # offers are the same if they are one object
            return last[1]
        positions: dict[Channel, list[int]] = {}
        for i, offer in enumerate(offers):
            if offer is not None:
                positions.setdefault(offer.channel, []).append(i)
        found = list(positions.items())
        self._plans[task] = offers, found
        return found

    def commits_of(self, task: str, now: float) -> list[Commit]:
        """The events that are possible at time *now* with this task taking part, in the order of its offers."""
        found: list[Commit] = []
        for i, offer in enumerate(self.waiting[task]):
            if offer is None or (offer.after is not None and offer.after > now):
                continue
            channel = offer.channel
            on = self._on[channel]
            if channel.two is not None and len(on) == 2 and task in channel.two:
                found += self._between_two(channel, on, task, i, now)
                continue
            for group, others in channel.partners[task]:
                if all(other in on for other in others):
                    found.extend(self._meetings(channel, group, task, i, others, now))
        return found

    def commits(self, now: float) -> list[Commit]:
        """All events that are possible at time *now*."""
        found: list[Commit] = []
        for channel, on in self._on.items():
            if channel.two is not None and len(on) == 2:
                met = self._meeting_again(channel, on)
                if met is not None:
                    found += met.commits
                    continue
            if on:
                known = self._known.get(channel)
                if known is None:
                    known = self._on_channel(channel, on, now)
                    if not self._awaited(channel, on, now):
                        self._known[channel] = known
                found += known
        return found

    def _on_channel(self, channel: Channel, on: Mapping[str, Sequence[int]], now: float) -> list[Commit]:
        """The possible events of one channel."""
        found: list[Commit] = []
        for group in channel.groups:
            if all(task in on for task in group):
                first, *others = sorted(group)
                for i in on[first]:
                    offer = self.waiting[first][i]
                    assert offer is not None
                    if offer.after is None or offer.after <= now:
                        found.extend(self._meetings(channel, group, first, i, others, now))
        return found

    def _between_two(
        self, channel: Channel, on: Mapping[str, Sequence[int]], task: str, index: int, now: float
    ) -> Sequence[Commit]:
        """The possible events of a channel of two tasks, both of which offer some, with one offer of one of them."""
        assert channel.two is not None
        met = self._meeting_again(channel, on)
        first, second = channel.two
        if met is not None:
            return met.commits if task == first else met.other_way
        return list(self._meetings(channel, channel.groups[0], task, index, (second if task == first else first,), now))

    def _meeting_again(self, channel: Channel, on: Mapping[str, Sequence[int]]) -> _Met | None:
        """The possible events of a channel of two tasks, if each has one offer on it and both stand always."""
        assert channel.two is not None
        first, second = channel.two
        if first not in on or second not in on:
            return None
        ours, theirs = on[first], on[second]
        if len(ours) != 1 or len(theirs) != 1:
            return None
        mine, other = self.waiting[first][ours[0]], self.waiting[second][theirs[0]]
        assert mine is not None
        assert other is not None
        if mine.after is not None or other.after is not None:
            return None
        met = self._met.get(channel)
        if met is not None and met.first is mine and met.second is other and met.positions == (ours[0], theirs[0]):
            return met
        if mine.accept is not None or mine.body is not None or other.accept is not None or other.body is not None:
            return None
        candidates = agreed(channel, channel.groups[0], (mine, other))
        one, two = (first, ours[0]), (second, theirs[0])
        commits = (Commit(channel, (one, two), candidates),) if candidates else ()
        other_way = (Commit(channel, (two, one), candidates),) if candidates else ()
        met = self._met[channel] = _Met(mine, other, (ours[0], theirs[0]), commits, other_way)
        return met

    def _awaited(self, channel: Channel, on: Mapping[str, Sequence[int]], now: float) -> bool:
        """Whether an offer on a channel does not stand yet."""
        for task, indices in on.items():
            for i in indices:
                offer = self.waiting[task][i]
                if offer is not None and offer.after is not None and offer.after > now:
                    return True
        return False

    def next_time(self, now: float) -> float | None:
        """When the next offer begins to stand that does not stand yet; None if there is none."""
        times = [
            offer.after
            for offers in self.waiting.values()
            for offer in offers
            if offer is not None and offer.after is not None and offer.after > now
        ]
        return min(times, default=None)

    def waits_on(self, task: str, channel: Channel) -> bool:
        """Whether *task* has an offer on *channel*, whatever its values."""
        return task in self._on.get(channel, ())

    def _meetings(
        self, channel: Channel, group: Group, task: str, index: int, others: Sequence[str], now: float
    ) -> Iterator[Commit]:
        """The possible events of one group in which *task* takes part with one of its offers."""
        on, waiting = self._on[channel], self.waiting
        mine = waiting[task][index]
        assert mine is not None
        for indices in product(*[on[other] for other in others]):
            offers = [mine]
            for other, i in zip(others, indices, strict=True):
                offer = waiting[other][i]
                assert offer is not None
                offers.append(offer)
            if any(offer.after is not None and offer.after > now for offer in offers):
                continue
            candidates = agreed(channel, group, offers)
            if candidates:
                yield Commit(channel, ((task, index), *zip(others, indices, strict=True)), candidates)


def agreed(channel: Channel, group: Group, offers: Sequence[Offer]) -> Sequence[Values]:
    """The values on which some offers, one of each task of a group, agree; at most :data:`LARGEST`.

    An offer with a body that is to give values stands if there is a value that it can give.

    Raises:
        NobodyDecides: no offer gives the value of a field, and its type cannot list its values.
    """
    if offers[0].body is not None:
        fields = offers[0].fields
        accept = offers[0].accept
        if channel.by_event is None and accept is None and not any(type(field) is OneOf for field in fields):
            return (fields,)
        try:
            return (fields,) if agreed(channel, group, (Offer(channel, fields, accept),)) else ()
        except NobodyDecides:
            return (fields,)
    if len(offers) == 2 and offers[0].accept is None and offers[1].accept is None and channel.by_event is None:
        # Nearly always one of two offers gives all values, and the other takes any.
        for row, open_ in ((offers[0].fields, offers[1]), (offers[1].fields, offers[0])):
            if open_ is channel.open and not any(field is ANY or type(field) is OneOf for field in row):
                return (row,)
    columns: list[Sequence[Any]] = []
    for i, declared in enumerate(channel.types):
        given: list[Any] = []
        allowed: frozenset[Any] | None = None
        for offer in offers:
            field = offer.fields[i]
            if field is ANY:
                continue
            if type(field) is OneOf:
                allowed = field.values if allowed is None else allowed & field.values
            elif not given:
                given.append(field)
            elif given[0] != field:
                return ()
        if given:
            if allowed is not None and given[0] not in allowed:
                return ()
            columns.append(given)
            continue
        listed = declared.values()
        if listed is not None:
            columns.append([value for value in islice(listed, LARGEST) if allowed is None or value in allowed])
        elif allowed is not None:
            columns.append(sorted((value for value in allowed if declared.contains(value)), key=repr))
        else:
            raise NobodyDecides(
                f"no task gives the value of field {i + 1} of {channel.name}, "
                f"and {declared.describe()} cannot be listed"
            )
    rows: Sequence[Values] = list(islice(product(*columns), LARGEST))
    for offer in offers:
        if offer.accept is not None:
            accept = offer.accept
            rows = [row for row in rows if accept(*row)]
    if channel.by_event is not None:
        by_event = channel.by_event
        rows = [row for row in rows if group in by_event.get(row, ())]
    return rows


class Policy(Protocol):
    """Decides what the specification leaves open."""

    def choose(self, commits: Sequence[Commit], priorities: dict[str, int]) -> Commit:
        """One of several possible events."""

    def value(self, commit: Commit) -> Values:
        """One of the possible values of an event."""

    def decide(self, task: str, ways: int) -> int:
        """An internal choice of *task*: a number below *ways*."""


class Fair:
    """The event of the most urgent task; among equals the one whose channel has been idle the longest.

    Values and internal choices are taken in turn. Nothing in it is random.
    """

    def __init__(self) -> None:
        self._turn = 0
        self._used: dict[Channel, int] = {}
        self._turns: dict[object, int] = {}

    def choose(self, commits: Sequence[Commit], priorities: dict[str, int]) -> Commit:
        """By priority, then by how long ago the channel was used, then in the order given."""
        used = self._used
        if len(commits) == 1:
            best = commits[0]
        else:
            best, urgency, turn = commits[0], -(sys.maxsize), 0
            for commit in commits:  # min() with a key takes three times as long
                own = used.get(commit.channel, -1)
                first, *others = commit.parts
                urgent = priorities[first[0]]
                for task, _ in others:
                    if priorities[task] > urgent:
                        urgent = priorities[task]
                if urgent > urgency or (urgent == urgency and own < turn):
                    best, urgency, turn = commit, urgent, own
        self._turn += 1
        used[best.channel] = self._turn
        return best

    def value(self, commit: Commit) -> Values:
        """The next of the possible values."""
        return commit.candidates[self._next(commit.channel) % len(commit.candidates)]

    def decide(self, task: str, ways: int) -> int:
        """The next way."""
        return self._next(task) % ways

    def _next(self, key: object) -> int:
        turn = self._turns.get(key, 0)
        self._turns[key] = turn + 1
        return turn


class InOrder(Fair):
    """The event of the most urgent task; among equals the one that is offered first: a priority choice."""

    def choose(self, commits: Sequence[Commit], priorities: dict[str, int]) -> Commit:
        """By priority, then in the order given."""
        return min(commits, key=lambda c: -max(priorities[task] for task, _ in c.parts))


class Randomly:
    """Anything, with equal chances: the same seed gives the same decisions."""

    def __init__(self, seed: int = 0) -> None:
        self._random = Random(seed)

    def choose(self, commits: Sequence[Commit], priorities: dict[str, int]) -> Commit:
        """Any of them; priorities do not matter."""
        return commits[0] if len(commits) == 1 else self._random.choice(commits)

    def value(self, commit: Commit) -> Values:
        """Any of them."""
        return self._random.choice(commit.candidates)

    def decide(self, task: str, ways: int) -> int:
        """Any of them."""
        return self._random.randrange(ways)
