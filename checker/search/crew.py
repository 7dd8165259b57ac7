"""Several threads at one search, without locks on what they find: each owns a part of the visited states.

A thread expands some rows, sorts the successors by who owns their part of the table, enters its own and leaves the
others to their owners, as letters. It reads its letters before it expands more. Nobody waits for anybody until the rows
are used up, and then only for what is in the post.

New states are written where they stay at once: each thread has a stretch of the rows for itself, and gets another when
that is full. What stays empty of the stretches is closed at the end with the last rows, so that rows without a gap are
all that anybody else sees. In which order the states of a level come depends on chance; which they are does not.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, wait
from threading import Lock
from typing import Any

import numpy as np

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.kernels.jit import Kernels
from cspcheck.checker.search.pace import TRIAL
from cspcheck.checker.search.visited import NO_NUMBERS, Visited
from cspcheck.checker.search.worker import Wave, Worker

PARTITION_BITS = 6
"""The table is cut into this many partitions, to the power of two."""
DIVIDED_BITS = 16
"""The least size of a table that is cut, so that partitions are large enough to fill evenly."""
SHARED_CAPACITY = 1 << 17
"""Transitions that a worker makes at a time: the more, the less is done between calls of kernels."""
STRETCH = 1 << 14
"""Rows of a stretch at most."""
LEAST_ROWS = 64
"""Rows that a worker takes at a time at least."""
ENVELOPES = 8
"""So many of a worker's may be in the post."""
RUN_TRANSITIONS = 1 << 22
"""About so many transitions are made at most before limits and the clock are looked at."""
FIRST_RUN_TRANSITIONS = 1 << 20
"""And so many at first, until it is seen whether threads gain anything."""
MOST_COUNTED = 64
"""Runs are counted up to here."""


class Envelope:
    """Successors sorted by owner, on their way to the owners.

    Attributes:
        sender: who made them.
        capacity: rows for each owner.
        rows: flat.
        readers: how many owners have not read theirs yet.
    """

    __slots__ = ("capacity", "readers", "rows", "sender")

    def __init__(self, sender: Member, capacity: int, stride: int) -> None:
        self.sender = sender
        self.capacity = capacity
        self.rows: Int64Array = np.empty(capacity * len(sender.ends) * stride, dtype=np.int64)
        self.readers = 0


class Member:
    """A worker, and what it owns.

    Attributes:
        letters: envelopes, each with the rows in it that are for this one and not yet looked at.
        left: rows that were taken to be expanded and are not yet.
        place, end: the rest of its stretch of the rows.
        ends: scratch.
        free, envelopes: its envelopes that are not in the post, and how many it has altogether.
    """

    __slots__ = ("end", "ends", "envelopes", "free", "left", "letters", "place", "worker")

    def __init__(self, worker: Worker, members: int) -> None:
        self.worker = worker
        self.letters: deque[tuple[Envelope, int, int]] = deque()
        self.left: tuple[int, int] = (0, 0)
        self.place = self.end = 0
        self.ends: Int64Array = np.zeros(members, dtype=np.int64)
        self.free: list[Envelope] = []
        self.envelopes = 0

    @property
    def is_busy(self) -> bool:
        """Whether it has something to do."""
        return bool(self.letters) or self.left[0] < self.left[1]

    @property
    def nbytes(self) -> int:
        """The memory that its buffers take, all envelopes being as large as the next one."""
        made = self.worker.expander
        return made.nbytes + self.envelopes * made.capacity * made.stride * 8 * len(self.ends)

    def envelope(self) -> Envelope | None:
        """One for what the worker makes next; None if too many have not been read."""
        made = self.worker.expander
        while self.free:
            envelope = self.free.pop()
            if envelope.capacity >= made.capacity:
                return envelope
            self.envelopes -= 1
        if self.envelopes >= ENVELOPES:
            return None
        self.envelopes += 1
        return Envelope(self, made.capacity, made.stride)

    def forget(self) -> None:
        """Leave what is to be done undone."""
        self.letters.clear()
        self.free.clear()
        self.envelopes = 0
        self.left = (0, 0)


class Crew:
    """Workers that search together.

    Attributes:
        workers: those who expand.
    """

    def __init__(self, workers: list[Worker], visited: Visited) -> None:
        self.workers = workers
        self._visited = visited
        self._members = [Member(worker, len(workers)) for worker in workers]
        self._partition_bits = PARTITION_BITS
        self._pool = ThreadPoolExecutor(max(1, len(workers) - 1), thread_name_prefix="search")
        self._taking = Lock()
        self._next = self._last = 0
        # Whether all are to stop, and whether because a partition is full.
        self._halted = self._blocked = False
        self._fan_out = 8.0
        self._runs = 0

    @property
    def rows_per_run(self) -> int:
        """How many rows are worth a run, by the experience of earlier ones."""
        transitions = min(RUN_TRANSITIONS, FIRST_RUN_TRANSITIONS << max(0, self._runs - TRIAL))
        return max(LEAST_ROWS * len(self.workers), int(transitions / self._fan_out))

    def begin_again(self) -> None:
        """Have small runs first: one thread went on alone meanwhile."""
        self._runs = 0

    @property
    def transitions(self) -> int:
        """How many transitions the workers have met."""
        return sum(worker.transitions for worker in self.workers)

    @property
    def nbytes(self) -> int:
        """The memory that the buffers take."""
        return sum(member.nbytes for member in self._members)

    def dismiss(self) -> None:
        """End the threads."""
        self._pool.shutdown(wait=True, cancel_futures=True)

    def together(self, jobs: Iterable[Callable[[], Any]]) -> list[Any]:
        """Run jobs at the same time; their results."""
        mine, *others = list(jobs)
        futures = [self._pool.submit(job) for job in others]
        try:
            result = mine()
        finally:
            wait(futures)  # whatever happens here, nobody is left at work on what others look at next
        return [result, *(future.result() for future in futures)]

    @property
    def divided(self) -> bool:
        """Whether the table is cut, which the workers need to share it."""
        return self._partition_bits > 0

    def divide(self, kernels: Kernels) -> None:
        """Cut the table into partitions."""
        self._rebuild(kernels, max(self._visited.bits, DIVIDED_BITS))

    def grow(self, kernels: Kernels) -> None:
        """Make room for twice as many states."""
        self._rebuild(kernels, self._visited.bits + 1)

    def relieve(self, kernels: Kernels, make_room: Callable[[], None]) -> None:
        """Do something about a full partition: a larger table, or an undivided one if that alone is not the reason."""
        if self._visited.known < self._visited.room >> 3:
            self._partition_bits = 0
            self._rebuild(kernels, self._visited.bits)
        else:
            make_room()

    def _rebuild(self, kernels: Kernels, bits: int) -> None:
        self._visited.rebuild(kernels, bits, self._partition_bits, self.together, len(self.workers))
        self._partition_bits = self._visited.partition_bits

    def run(self, kernels: Kernels, step: Wave, first: int, last: int, make_room: Callable[[], None]) -> None:
        """Expand the rows *first* to *last* and add their successors.

        Args:
            step: what is to be expanded.
            make_room: called when there is little room left for new states; makes more.
        """
        before = self.transitions
        self._next, self._last = first, last
        try:
            while self._next < self._last or any(member.is_busy for member in self._members):
                if not step.elsewhere:
                    step.rows = self._visited.rows
                if self.divided:
                    self._go_on(kernels, step, make_room)
                else:
                    self._go_on_alone(kernels, step, make_room)
        except BaseException:
            for member in self._members:
                member.forget()
            raise
        self._fan_out = max(1.0, (self.transitions - before) / (last - first))
        self._runs = min(self._runs + 1, MOST_COUNTED)

    def _go_on(self, kernels: Kernels, step: Wave, make_room: Callable[[], None]) -> None:
        """Have all work until there is nothing more to do or no room."""
        self._halted = self._blocked = False
        try:
            self.together(self._working(kernels, step, number) for number in range(len(self._members)))
        finally:
            self._close_gaps(kernels)
        if self._blocked:
            self.relieve(kernels, make_room)
        elif self._halted:
            make_room()

    def _working(self, kernels: Kernels, step: Wave, number: int) -> Callable[[], None]:
        def work() -> None:
            try:
                self._work(kernels, step, number)
            except BaseException:
                self._halted = True
                raise

        return work

    def _work(self, kernels: Kernels, step: Wave, number: int) -> None:
        """What each thread does."""
        member = self._members[number]
        while not self._halted:
            if member.letters:
                self._read(kernels, member)
                continue
            self._take_rows(member)
            first, last = member.left
            if first == last:
                return
            envelope = member.envelope()
            if envelope is None:
                return
            member.left = member.worker.produce(kernels, step, first, last), last
            self._send(kernels, number, envelope)

    def _take_rows(self, member: Member) -> None:
        """Let a worker that has no rows have some, if there are any."""
        if member.left[0] < member.left[1]:
            return
        with self._taking:
            left = self._last - self._next
            # Less at a time towards the end, where one waits for the other.
            share = min(int(0.9 * member.worker.expander.capacity / self._fan_out), left // (2 * len(self._members)))
            first = self._next
            self._next += min(left, max(LEAST_ROWS, share))
            member.left = first, self._next

    def _send(self, kernels: Kernels, number: int, envelope: Envelope) -> None:
        """Send what a worker has made to the owners."""
        member, made = self._members[number], self._members[number].worker.expander
        if made.capacity > envelope.capacity:  # it grew
            envelope = Envelope(member, made.capacity, made.stride)
        ends, capacity = member.ends, envelope.capacity
        kernels.sort_by_owner(
            made.targets,
            made.count,
            made.stride,
            self._visited.partition_bits,
            len(ends),
            capacity,
            ends,
            envelope.rows,
        )
        filled = [(o, o * capacity, end) for o, end in enumerate(ends.tolist()) if end > o * capacity]
        envelope.readers = len(filled)
        if not filled:
            member.free.append(envelope)
        for o, begin, end in filled:
            letters = self._members[o].letters
            if o == number:
                letters.appendleft((envelope, begin, end))  # read next, as long as it is in the cache
            else:
                letters.append((envelope, begin, end))

    def _read(self, kernels: Kernels, member: Member) -> None:
        """Add what is in a member's next letter to the visited states."""
        visited = self._visited
        envelope, begin, end = member.letters.popleft()
        while True:
            begin, member.place = kernels.insert(
                envelope.rows,
                begin,
                end,
                visited.stride,
                visited.rows,
                member.place,
                member.end,
                visited.table,
                visited.bits,
                visited.entry_bits,
                visited.partition_bits,
                NO_NUMBERS,
            )
            if begin == end:
                break
            if member.place < member.end:
                self._blocked = True
            if self._blocked or not self._take_stretch(member):
                self._halted = True
                member.letters.appendleft((envelope, begin, end))
                return
        with self._taking:
            envelope.readers -= 1
            if not envelope.readers:
                envelope.sender.free.append(envelope)

    def _take_stretch(self, member: Member) -> bool:
        """Let a member have a new stretch of the rows, if there are any."""
        visited = self._visited
        with self._taking:
            member.place = visited.known
            member.end = visited.known = min(visited.room, visited.known + max(1, min(STRETCH, visited.room >> 5)))
        return member.place < member.end

    def _close_gaps(self, kernels: Kernels) -> None:
        """Move the last rows to where stretches are empty."""
        visited = self._visited
        gaps = sorted(((member.place, member.end) for member in self._members), reverse=True)
        for place, end in gaps:
            moved = min(end - place, visited.known - end)
            kernels.move(
                visited.rows,
                visited.known - moved,
                place,
                moved,
                visited.stride,
                visited.table,
                visited.bits,
                visited.partition_bits,
            )
            visited.known -= end - place
        for member in self._members:
            member.place = member.end = 0

    def _go_on_alone(self, kernels: Kernels, step: Wave, make_room: Callable[[], None]) -> None:
        """Do all that is to be done in this thread: the table cannot be shared any more."""

        def insert(rows: Int64Array, begin: int, end: int) -> None:
            while begin < end:
                begin = self._visited.insert(kernels, rows, begin, end)
                if begin < end:
                    make_room()

        worker = self.workers[0]
        ranges = [member.left for member in self._members]
        for member in self._members:
            for envelope, begin, end in member.letters:
                insert(envelope.rows, begin, end)
            member.forget()
        for first, last in [*ranges, (self._next, self._last)]:
            while first < last:
                if not step.elsewhere:
                    step.rows = self._visited.rows
                first = worker.produce(kernels, step, first, last)
                insert(worker.expander.targets, 0, worker.expander.count)
        self._next = self._last
