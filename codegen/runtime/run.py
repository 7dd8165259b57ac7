"""A run of a program: the one place where events happen.

Every task that waits has told the run what it offers; under one lock the run finds the possible events, lets exactly
one happen, records it, and wakes the tasks that took part. Who carries the tasks (threads, an event loop, a plain
loop) is of no concern here: a :class:`Party` is woken through its gate.

There are two ways to go on. *Free*: tasks run at the same time, and an event happens as soon as the last task that it
needs offers it. *Serial*: one task runs at a time, the most urgent first; when none is left that can run, one of the
possible events is chosen. A serial run is the same every time (clock and policy permitting), whoever carries it.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from heapq import heappop, heappush
from typing import Protocol

from .alternation import Board, Choice, Commit, Policy, Turn, agreed
from .channel import ANY, Offer, OneOf, Values, WrongOffer
from .clock import Clock, MonotonicClock
from .recorder import Nothing, Record, Recorder
from .task import Stopped, Task
from .waiting import deadlock

Outcome = Choice | Stopped
"""What a task that waited is told."""


class Gate(Protocol):
    """How a waiting task is woken."""

    def open(self) -> None:
        """Let the task go on, now or when it comes to wait."""


class Party:
    """A task in a run; ``outcome`` is what it will be told when it is woken."""

    __slots__ = ("gate", "looked", "outcome", "task")

    def __init__(self, task: Task, gate: Gate) -> None:
        self.task = task
        self.gate = gate
        self.outcome: Outcome | None = None
        self.looked = 0.0
        """When it was last looked at what is possible for it."""


class Run:
    """The events of one run of some tasks.

    Args:
        clock: what time it is.
        policy: decides between events that are possible at the same time.
        recorder: is told every event; what it raises stops the run.
        serial: whether one task runs at a time.
        most: so many events at most are let happen; None: any number.
        until: the run ends at this time of the clock; None: never.
    """

    def __init__(
        self,
        clock: Clock,
        policy: Policy,
        recorder: Recorder,
        *,
        serial: bool,
        most: int | None = None,
        until: float | None = None,
    ) -> None:
        self.clock = clock
        self.serial = serial
        self.events = 0
        """How many events have happened."""
        self.failure: BaseException | None = None
        """What stopped the run, if it was not meant to end."""
        self.terminated = False
        """Whether all tasks have ended of themselves."""
        self._policy = policy
        self._recorder = recorder
        self._most = most
        self._until = until
        self._lock = threading.Lock()
        self._board = Board(keeps=serial)
        self._recording = type(recorder) is not Nothing
        self.timed = until is not None
        """Whether what is possible may change with the time."""
        self._parties: dict[str, Party] = {}
        self._priorities: dict[str, int] = {}
        self._running = 0
        self._ended: dict[str, None] = {}
        self._closed = False
        self.over = threading.Event()
        """Set when nothing will happen any more."""
        self.alarm: Callable[[], object] | None = None
        """Wakes the one who carries all tasks, when another thread has opened gates."""
        self.current: str | None = None
        """The task that runs, or ran last, where one thread carries them all."""
        self._level = True
        """Whether no task is more urgent than another."""
        self._ready: deque[Party] = deque()
        """Serial: the tasks that can run, where none is more urgent; otherwise a heap."""
        self._urgent: list[tuple[int, int, Party]] = []
        self._queued = 0

    @property
    def closed(self) -> bool:
        """Whether nothing will happen any more."""
        return self._closed

    def begin(self, parties: Sequence[Party]) -> None:
        """Take in the tasks. A serial run opens the gate of the first; otherwise all may start at once."""
        with self._lock:
            for party in parties:
                name = party.task.name
                if name in self._parties:
                    raise WrongOffer(f"two tasks are called {name}")
                self._parties[name] = party
                self._priorities[name] = party.task.priority
                party.task.begin(self)
            self._level = len(set(self._priorities.values())) <= 1
            self._running = len(parties)
            self.clock.start()
            if self.serial:
                self._running = 0
                for party in parties:
                    self._wake(party)
                self._pass_on()

    # --- what tasks do ---------------------------------------------------------------------------------------

    def submit(self, party: Party, offers: tuple[Offer | None, ...]) -> Outcome | None:
        """A task waits for one of *offers*.

        Returns:
            What came of it, if that is known at once; otherwise None, and the gate opens when it is known.

        Raises:
            OutOfRange, WrongOffer: an offer is wrong. The task goes on running.
        """
        name = party.task.name
        board = self._board
        plan = board.plan(name, offers)
        if plan.later:
            self.timed = True
        with self._lock:
            if self.timed:
                party.looked = self.clock.now()
                if not self._closed and self._until is not None and party.looked >= self._until:
                    self._close(None)
            if self._closed:
                return Stopped()
            self._running -= 1
            try:
                if not self.serial:
                    # Most often the others wait already: then this task need not be put on the board.
                    commits = board.commits_of(plan, party.looked)
                    if commits:
                        self._choose(commits, party)
                        outcome, party.outcome = party.outcome, None
                        return outcome
                board.add(plan, party.looked)
            except Exception as error:
                waits = name in board
                self._close(error)
                if not waits:
                    self._running += 1
                    return Stopped()
            if self.serial:
                self._pass_on()
            elif self._running == 0:
                self._look_for_the_end()
            return None

    def retry(self, party: Party) -> None:
        """Time has passed that a waiting task waited for: look again at what is possible for it."""
        with self._lock:
            name = party.task.name
            if self._closed or name not in self._board:
                return
            if self._until is not None and self.clock.now() >= self._until:
                self._close(None)
                return
            try:
                party.looked = self.clock.now()
                commits = self._board.commits_of(self._board.planned(name), party.looked)
                if commits:
                    self._choose(commits, None)
                else:
                    self._look_for_the_end()
            except Exception as error:
                self._close(error)

    def patience(self, party: Party, offers: Sequence[Offer | None]) -> float | None:
        """How many seconds a task that waits for *offers* may sleep before it must look again; None: for ever."""
        if not self.timed or self.serial:
            return None
        looked = party.looked
        times = [o.after for o in offers if o is not None and o.after is not None and o.after > looked]
        if self._until is not None:
            times.append(self._until)
        return max(0.0, min(times) - self.clock.now()) if times else None

    def done(self, task: str, offer: Offer, values: Values) -> None:
        """The body of an offer has run: its event has happened.

        Raises:
            OutOfRange: the body gave a value that the channel cannot carry.
            Stopped: the run has ended meanwhile; the event is not recorded.
        """
        for i, (declared, field, value) in enumerate(zip(offer.channel.types, offer.fields, values, strict=True)):
            if field is ANY or isinstance(field, OneOf):
                declared.check(value, task, offer.channel.field_name(i))
            if isinstance(field, OneOf) and value not in field.values:
                raise WrongOffer(f"{task}: the method {offer.channel.name} gave {value!r}, outside {offer.text()}")
        by_event = offer.channel.by_event
        if offer.accept is not None and not offer.accept(*values):
            raise WrongOffer(f"{task}: the method {offer.channel.name} gave {values!r}, which is not accepted now")
        if by_event is not None and frozenset((task,)) not in by_event.get(values, ()):
            raise WrongOffer(f"{task}: the method {offer.channel.name} gave {values!r}, which cannot happen")
        with self._lock:
            if self._closed:
                raise Stopped
            try:
                self._record(Commit(offer.channel, ((task, 0),), (values,), Turn()), values)
                if self.events == self._most:
                    self._close(None)
            except Exception as error:
                self._close(error)
                raise Stopped from None

    def leave(self, party: Party, error: BaseException | None = None) -> None:
        """A task has ended, with *error* if it failed: then the run is over."""
        with self._lock:
            self._ended[party.task.name] = None
            self._running -= 1
            if error is not None and not isinstance(error, Stopped):
                note = f"in the task {party.task.name}"
                if note not in getattr(error, "__notes__", ()):  # the same error may be raised run after run
                    error.add_note(note)
                self._close(error)
            if self.serial:
                self._pass_on()
            else:
                self._look_for_the_end()

    def decided(self, task: str, offer: Offer) -> Values:
        """The values of the open fields of an offer, as the policy has them."""
        plain = Offer(offer.channel, offer.fields, offer.accept)
        with self._lock:
            candidates = agreed(offer.channel, frozenset((task,)), (plain,))
            if not candidates:
                raise WrongOffer(f"{task}: no value is possible for {offer.text()}")
            values = self._policy.value(Commit(offer.channel, ((task, 0),), candidates, Turn()))
        return tuple(
            value for field, value in zip(offer.fields, values, strict=True) if field is ANY or isinstance(field, OneOf)
        )

    def decide(self, task: str, ways: int) -> int:
        """An internal choice."""
        with self._lock:
            return self._policy.decide(task, ways)

    def wait(self) -> None:
        """Wait until nothing will happen any more; a task that never comes back does not keep that from being so."""
        if self._until is None or not isinstance(self.clock, MonotonicClock):
            self.over.wait()
            return
        while not self.over.wait(max(0.0, self._until - self.clock.now())):
            if self.clock.now() >= self._until:
                self.stop()

    def stop(self, failure: BaseException | None = None) -> None:
        """End the run: every task gets :class:`Stopped` where it waits or next comes to wait."""
        with self._lock:
            self._close(failure)
            if self.serial and self._running == 0:
                self._pass_on()
        if self.alarm is not None:
            self.alarm()

    # --- under the lock --------------------------------------------------------------------------------------

    def _choose(self, commits: Sequence[Commit], asks: Party | None) -> None:
        """Let one of some possible events happen. The party that *asks* has no need of its gate."""
        if self._board.ranked and len(commits) > 1:
            commits = _first_ranks(commits)
        commit = self._policy.choose(commits, self._priorities)
        parts = commit.parts
        values: Values = ()
        if not commit.own:
            values = commit.candidates[0] if len(commit.candidates) == 1 else self._policy.value(commit)
            self._record(commit, values)
        board, parties = self._board, self._parties
        board.remove(commit.tasks if asks is None else tuple([name for name in commit.tasks if name != asks.task.name]))
        for name, position in parts:
            party = parties[name]
            party.outcome = Choice(position, values)
            if self.serial:
                self._wake(party)
            else:
                self._running += 1
                if party is not asks:
                    party.gate.open()
        if self.events == self._most:
            self._close(None)

    def _record(self, commit: Commit, values: Values) -> None:
        if self._recording:
            channel = commit.channel
            self._recorder.record(
                Record(
                    self.events,
                    self.clock.now(),
                    channel.text(values),
                    channel.name,
                    values,
                    commit.tasks,
                    channel.hidden,
                    channel.inner,
                )
            )
        self.events += 1

    def _wake(self, party: Party) -> None:
        """Serial: put a task among those that can run."""
        if self._level:
            self._ready.append(party)
        else:
            self._queued += 1
            heappush(self._urgent, (-party.task.priority, self._queued, party))

    def _pass_on(self) -> None:
        """Serial: let the next task run; if there is none, let the next event happen."""
        while True:
            if self._ready or self._urgent:
                party = self._ready.popleft() if self._ready else heappop(self._urgent)[2]
                self._running += 1
                party.gate.open()
                return
            if self._closed or len(self._board) == 0:
                self._look_for_the_end()
                if not self._ready and not self._urgent:
                    return
                continue
            try:
                now = self.clock.now() if self.timed else 0.0
                if self._until is not None and now >= self._until:
                    self._close(None)
                    continue
                commits = self._board.possible(now)
                if commits:
                    self._choose(commits, None)
                elif not self._sleep():
                    self._close(deadlock(self._board, self._ended))
            except Exception as error:
                self._close(error)

    def _sleep(self) -> bool:
        """Serial: pass the time until something may be possible again; whether there is such a time."""
        now = self.clock.now()
        next_time = self._board.next_time(now)
        if next_time is None:
            return False
        if self._until is not None:
            next_time = min(next_time, self._until)
        if isinstance(self.clock, MonotonicClock):
            time.sleep(max(0.0, next_time - now))
        else:
            self.clock.advance(next_time)
        return True

    def _look_for_the_end(self) -> None:
        """See whether all tasks have ended, or all that have not wait for ever."""
        if self._running > 0 or self._closed:
            return
        if len(self._board) == 0:
            self.terminated = True
            end = Record(self.events, self.clock.now(), "tick", "tick", (), (), hidden=False, terminated=True)
            try:
                self._recorder.record(end)
            except Exception as error:
                self.failure = error
            self._closed = True
            self.over.set()
        elif not self.serial and self._board.next_time(self.clock.now()) is None:
            self._close(deadlock(self._board, self._ended))

    def _close(self, failure: BaseException | None) -> None:
        """Let nothing happen any more, and send everybody who waits home."""
        if self._closed:
            return
        self._closed = True
        self.failure = failure
        self.over.set()
        for name in list(self._board.waiting):
            self._board.remove((name,))
            party = self._parties[name]
            party.outcome = Stopped()
            if self.serial:
                self._wake(party)
            else:
                self._running += 1
                party.gate.open()


def _first_ranks(commits: Sequence[Commit]) -> Sequence[Commit]:
    """The events that no possible event of a lower rank comes before."""
    ranks = [commit.channel.rank for commit in commits if commit.channel.rank is not None]
    if not ranks:
        return commits
    first = min(ranks)
    return [commit for commit in commits if commit.channel.rank is None or commit.channel.rank <= first]
