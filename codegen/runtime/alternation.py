"""Alternation: which events are possible between what the tasks offer, and the choice of exactly one.

A task that waits has made a selection: some offers, of which one will be taken. An event is possible when all tasks of
one group of its channel have an offer for it, with agreeing values. That is looked at in one place with everything
in view, so input and output guards are alike, any number of tasks can meet, and no offer is ever taken half: a
receive that was begun and then cancelled would have lost its message.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice, product
from operator import attrgetter
from random import Random
from typing import Any, NamedTuple, Protocol

from .channel import ANY, Channel, Group, Offer, OneOf, Values
from .data import LARGEST

Parts = tuple[tuple[str, int], ...]
"""The tasks that perform an event, each with the position of its offer."""


class Choice(NamedTuple):
    """The offer that was taken, by its position in the selection, and the values that came."""

    taken: int
    values: Values


class Turn:
    """When some tasks performed some event together last; what policies may go by. It is theirs to write."""

    __slots__ = ("last",)

    def __init__(self) -> None:
        self.last = 0


class Commit:
    """A possible event: the tasks that perform it in the order of their names, each with the position of its offer, and
    the possible values.

    ``candidates`` has more than one entry only where no offer gives a value: then somebody has to choose. ``own`` says
    whether it is a method of the only task, which gives the values when it has been called.
    """

    __slots__ = ("candidates", "channel", "own", "parts", "tasks", "turn")

    def __init__(
        self, channel: Channel, parts: Parts, candidates: Sequence[Values], turn: Turn, own: bool = False
    ) -> None:
        self.channel = channel
        self.parts = parts
        self.candidates = candidates
        self.turn = turn
        self.own = own
        self.tasks: tuple[str, ...] = tuple([task for task, _ in parts])


class NobodyDecides(Exception):
    """All offers take any value of a field, and its values cannot be listed."""


class _Entry:
    """An offer on the board, and the events in which it met offers of other tasks that are made again and again."""

    __slots__ = ("index", "met", "offer")

    def __init__(self, index: int, offer: Offer) -> None:
        self.index = index
        self.offer = offer
        self.met: dict[tuple[str, int, Offer], Commit | None] = {}


PLANS = 256
"""So many selections of a task, and meetings of an offer, are kept."""
_Entries = dict[str, list[_Entry]]


class Plan:
    """A selection of a task, with what has to be known of it again and again."""

    __slots__ = ("entries", "later", "offers", "rows", "task")

    def __init__(self, task: str, offers: Sequence[Offer | None], on: dict[Channel, _Entries]) -> None:
        self.task = task
        self.offers = offers
        self.rows: list[tuple[int, Offer, _Entries, tuple[str, ...] | None, tuple[str, int, Offer]]] = []
        """Of each offer its position, who waits on its channel, and whom the task meets there one at a time."""
        found: dict[Channel, list[_Entry]] = {}
        for i, offer in enumerate(offers):
            if offer is not None:
                found.setdefault(offer.channel, []).append(_Entry(i, offer))
                others = None if offer.body is not None else offer.channel.pairs.get(task)
                self.rows.append((i, offer, on.setdefault(offer.channel, {}), others, (task, i, offer)))
        self.entries = [(on[channel], entries) for channel, entries in found.items()]
        self.later = [offer.after for offer in offers if offer is not None and offer.after is not None]
        """The times from which some of the offers stand."""


class Board:
    """What the waiting tasks offer. Not safe for concurrent use: the caller has the lock, but for :meth:`plan`.

    Args:
        keeps: whether the possible events are kept as tasks come and go, for :meth:`possible`; otherwise they are
            only looked for with :meth:`commits_of`.
    """

    def __init__(self, *, keeps: bool = False) -> None:
        self._keeps = keeps
        self._waiting: dict[str, Plan] = {}
        self._plans: dict[str, dict[Sequence[Offer | None], Plan]] = {}
        """The selections that a task makes again and again."""
        self._on: dict[Channel, _Entries] = {}
        self._possible: dict[Commit, None] = {}
        self._turns: dict[Parts, Turn] = {}
        self.ranked = False
        """Whether a channel has been seen whose events come after others."""
        self._later: dict[str, float] = {}
        """For each task with offers that do not stand yet when the next of them does."""

    @property
    def waiting(self) -> dict[str, Sequence[Offer | None]]:
        """The tasks that wait, each with its selection."""
        return {task: plan.offers for task, plan in self._waiting.items()}

    def __contains__(self, task: str) -> bool:
        return task in self._waiting

    def __len__(self) -> int:
        return len(self._waiting)

    def plan(self, task: str, offers: tuple[Offer | None, ...]) -> Plan:
        """What a task is to wait for, or to ask for. Called by one thread at a time for each task.

        Raises:
            OutOfRange, WrongOffer: an offer is wrong.
        """
        plans = self._plans.get(task)
        if plans is None:
            plans = self._plans[task] = {}
        plan = plans.get(offers)
        if plan is not None:
            return plan
        for offer in offers:
            if offer is not None:
                offer.check(task)
                if offer.channel.rank is not None:
                    self.ranked = True
        plan = Plan(task, offers, self._on)
        if len(plans) < PLANS and all(offer is None or offer.kept for offer in offers):
            plans[offers] = plan
        return plan

    def planned(self, task: str) -> Plan:
        """What a task waits for."""
        return self._waiting[task]

    def add(self, plan: Plan, now: float) -> None:
        """A task waits from *now* on."""
        task = plan.task
        self._waiting[task] = plan
        for on, entries in plan.entries:
            on[task] = entries
        if self._keeps:
            self._keep(plan, now)

    def remove(self, tasks: Sequence[str]) -> None:
        """Some tasks wait no longer."""
        for task in tasks:
            for on, _ in self._waiting.pop(task).entries:
                del on[task]
        if self._keeps:
            self._forget(tasks)
            if self._later:
                for task in tasks:
                    self._later.pop(task, None)

    def _forget(self, tasks: Sequence[str]) -> None:
        """What was possible with some tasks is not known any more."""
        if len(self._possible) == 1:
            (only,) = self._possible
            if only.tasks == tasks:
                self._possible.clear()
                return
        gone = frozenset(tasks)
        self._possible = {commit: None for commit in self._possible if gone.isdisjoint(commit.tasks)}

    def commits_of(self, plan: Plan, now: float) -> list[Commit]:
        """The events that are possible at time *now* with a task and one of its offers, in the order of its offers.

        It need not have been added.
        """
        found: list[Commit] = []
        for i, offer, on, others, key in plan.rows:
            if offer.after is not None and offer.after > now:
                continue
            if others is None:
                found += self._alone_or_with_several(plan.task, i, offer, now)
                continue
            for other in others:
                if other in on:
                    for entry in on[other]:
                        if key in entry.met:
                            commit = entry.met[key]
                        else:
                            commit = self._meeting(plan.task, i, offer, other, entry, now)
                        if commit is not None:
                            found.append(commit)
        return found

    def _alone_or_with_several(self, task: str, index: int, offer: Offer, now: float) -> Iterator[Commit]:
        on = self._on[offer.channel]
        for group, others in offer.channel.partners[task]:
            if others and offer.body is not None:
                continue  # a method is performed alone
            if all(other in on for other in others):
                yield from self._meetings(group, task, index, offer, others, now)

    def possible(self, now: float) -> list[Commit]:
        """All events that are possible at time *now*, those first that have been possible the longest."""
        if self._later:
            for task, when in list(self._later.items()):
                if when <= now:
                    self._forget((task,))
                    self._keep(self._waiting[task], now)
        return list(self._possible)

    def _keep(self, plan: Plan, now: float) -> None:
        """Look at what is possible now with a task that waits."""
        for commit in self.commits_of(plan, now):
            self._possible[commit] = None
        if plan.later:
            later = [time for time in plan.later if time > now]
            if later:
                self._later[plan.task] = min(later)
            else:
                self._later.pop(plan.task, None)

    def next_time(self, now: float) -> float | None:
        """When the next offer begins to stand that does not stand yet; None if there is none."""
        return min([time for plan in self._waiting.values() for time in plan.later if time > now], default=None)

    def waits_on(self, task: str, channel: Channel) -> bool:
        """Whether *task* has an offer on *channel*, whatever its values."""
        return task in self._on.get(channel, ())

    def _meeting(self, task: str, index: int, mine: Offer, other: str, entry: _Entry, now: float) -> Commit | None:
        """The possible event of an offer of a task and one on the board, if there is one."""
        theirs = entry.offer
        if theirs.body is not None or (theirs.after is not None and theirs.after > now):
            return None
        candidates = agreed(mine.channel, frozenset((task, other)), (mine, theirs))
        commit: Commit | None = None
        if candidates:
            commit = self._commit(mine.channel, [(task, index), (other, entry.index)], candidates)
        if mine.kept and theirs.kept and len(entry.met) < PLANS:
            entry.met[task, index, mine] = commit
        return commit

    def _meetings(
        self, group: Group, task: str, index: int, mine: Offer, others: Sequence[str], now: float
    ) -> Iterator[Commit]:
        """The possible events of an offer of a task and of the offers that others have on the board."""
        on = self._on[mine.channel]
        for entries in product(*[on[other] for other in others]):
            offers = [mine, *[entry.offer for entry in entries]]
            if any(o.after is not None and o.after > now for o in offers) or any(
                o.body is not None for o in offers[1:]
            ):
                continue
            candidates = agreed(mine.channel, group, offers)
            if candidates:
                parts = [(task, index), *[(o, entry.index) for o, entry in zip(others, entries, strict=True)]]
                yield self._commit(mine.channel, parts, candidates, mine.body is not None)

    def _commit(
        self, channel: Channel, parts: list[tuple[str, int]], candidates: Sequence[Values], own: bool = False
    ) -> Commit:
        parts.sort()
        key = tuple(parts)
        if key not in self._turns:
            self._turns[key] = Turn()
        return Commit(channel, key, candidates, self._turns[key], own)


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
    if len(offers) == 1 and offers[0].plain and offers[0].accept is None and channel.by_event is None:
        return (offers[0].fields,)
    if len(offers) == 2 and offers[0].accept is None and offers[1].accept is None and channel.by_event is None:
        # Nearly always one of two offers gives the value of each field, and the other takes any or gives the same.
        one, two = offers
        if two is channel.open and one.plain:
            return (one.fields,)
        if one is channel.open and two.plain:
            return (two.fields,)
        row: list[Any] = []
        for mine, other in zip(one.fields, two.fields, strict=True):
            value, wanted = (other, mine) if mine is ANY else (mine, other)
            if value is ANY or type(value) is OneOf or type(wanted) is OneOf:
                break
            if wanted is not ANY and value != wanted:
                return ()
            row.append(value)
        else:
            return (tuple(row),)
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


_last_turn = attrgetter("turn.last")


class Fair:
    """The event of the most urgent task; among equals the one that its tasks have performed least lately.

    What two tasks do on two channels of one family, or with one another and with a third, are events of their own: none
    of them starves. Values and internal choices are taken in turn. Nothing in it is random.
    """

    def __init__(self) -> None:
        self._turn = 0
        self._turns: dict[object, int] = {}
        self._level: dict[str, int] | None = None
        """Priorities that are all the same."""

    def choose(self, commits: Sequence[Commit], priorities: dict[str, int]) -> Commit:
        """By priority, then by how long ago these tasks did it, then in the order given."""
        best = commits[0]
        if len(commits) > 1:
            if priorities is not self._level:
                if len(set(priorities.values())) == 1:
                    self._level = priorities
                else:
                    commits = _most_urgent(commits, priorities)
            best = min(commits, key=_last_turn)
        self._turn += 1
        best.turn.last = self._turn
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


def _most_urgent(commits: Sequence[Commit], priorities: dict[str, int]) -> list[Commit]:
    """Those of the most urgent task."""
    urgencies = [max([priorities[task] for task in commit.tasks]) for commit in commits]
    most = max(urgencies)
    return [commit for commit, urgency in zip(commits, urgencies, strict=True) if urgency == most]


class InOrder(Fair):
    """The event of the most urgent task; among equals the one that is offered first: a priority choice."""

    def choose(self, commits: Sequence[Commit], priorities: dict[str, int]) -> Commit:
        """By priority, then in the order given."""
        return _most_urgent(commits, priorities)[0]


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
