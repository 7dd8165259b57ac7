"""Several threads at one search, without locks: each owns a part of the visited states.

A round has three phases, and all workers finish one before the next begins. Each expands its share of the rows and
sorts the successors by who owns their part of the table; each takes what is its own from all the others and claims
the new ones; and with the number of new states known, each writes its own to their final rows.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.kernels.jit import Kernels
from cspcheck.checker.search.visited import Visited
from cspcheck.checker.search.worker import Wave, Worker

PARTITION_BITS = 6
"""The table is cut into this many partitions, to the power of two."""
DIVIDED_BITS = 16
"""The least size of a table that is cut, so that partitions are large enough to fill evenly."""
SHARED_CAPACITY = 1 << 17
"""Transitions that a worker's buffers hold at first: more between two meetings, and it still fits a cache."""
CLAIMED = 1 << 15
"""New states that an owner can take before they are settled."""
MOST_ROWS = 1 << 15
"""Rows that a worker expands in a round at most."""


class Owner:
    """One worker's part of the visited states: what it claims in a round."""

    __slots__ = ("claimed", "fresh", "places", "waiting")

    def __init__(self, stride: int) -> None:
        self.fresh: Int64Array = np.empty(CLAIMED * stride, dtype=np.int64)
        self.places: Int64Array = np.empty(CLAIMED, dtype=np.int64)
        self.claimed = 0
        # Outbox, and the rows in it that are still to be looked at.
        self.waiting: list[tuple[Int64Array, int, int]] = []

    def claim(self, kernels: Kernels, visited: Visited, quota: int) -> None:
        """Take in waiting rows until all are, or *quota* of them were new."""
        self.claimed = 0
        room = min(quota, CLAIMED)
        for i, (outbox, begin, end) in enumerate(self.waiting):
            begin, self.claimed = kernels.claim(
                outbox,
                begin,
                end,
                visited.stride,
                visited.rows,
                visited.known,
                self.fresh,
                self.claimed,
                room,
                self.places,
                visited.table,
                visited.bits,
                visited.entry_bits,
                visited.partition_bits,
            )
            if begin < end:
                self.waiting = [(outbox, begin, end), *self.waiting[i + 1 :]]
                return
        self.waiting = []

    def settle(self, kernels: Kernels, visited: Visited, first: int) -> None:
        """Number what was claimed from *first* on."""
        kernels.settle(
            self.fresh, self.claimed, visited.stride, visited.rows, first, self.places, visited.table, visited.bits
        )


class Crew:
    """Workers that search together.

    Attributes:
        workers: those who expand.
    """

    def __init__(self, workers: list[Worker], visited: Visited) -> None:
        self.workers = workers
        self._visited = visited
        self._owners = [Owner(visited.stride) for _ in workers]
        self._outboxes: list[Int64Array] = [np.empty(0, dtype=np.int64) for _ in workers]
        self._ends = [np.zeros(len(workers), dtype=np.int64) for _ in workers]
        self._rows = 1 << 10
        self._partition_bits = PARTITION_BITS
        self._pool = ThreadPoolExecutor(max(1, len(workers) - 1), thread_name_prefix="search")

    @property
    def rows_per_round(self) -> int:
        """How many rows are worth a round, by the experience of earlier rounds."""
        return self._rows * len(self.workers)

    @property
    def transitions(self) -> int:
        """How many transitions the workers have met."""
        return sum(worker.transitions for worker in self.workers)

    @property
    def nbytes(self) -> int:
        """The memory that the buffers take."""
        buffers = [*self._outboxes, *(a for owner in self._owners for a in (owner.fresh, owner.places))]
        return sum(a.nbytes for a in buffers) + sum(worker.expander.nbytes for worker in self.workers)

    def dismiss(self) -> None:
        """End the threads."""
        self._pool.shutdown(wait=True, cancel_futures=True)

    def together(self, jobs: Iterable[Callable[[], Any]]) -> list[Any]:
        """Run jobs at the same time; their results."""
        mine, *others = list(jobs)
        futures = [self._pool.submit(job) for job in others]
        result = mine()
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

    def round(self, kernels: Kernels, step: Wave, first: int, last: int, make_room: Callable[[], None]) -> None:
        """Expand the rows *first* to *last* and add their successors.

        Args:
            step: what is to be expanded.
            make_room: called when there is little room left for new states; makes more.
        """
        share = -(-(last - first) // len(self.workers))
        pending = deque((begin, min(last, begin + share)) for begin in range(first, last, share))
        short = False
        while pending:
            if not step.elsewhere:
                step.rows = self._visited.rows
            ranges = [pending.popleft() for _ in range(min(len(pending), len(self.workers)))]
            reached = self.together(
                self._producing(kernels, step, worker, begin, end) for worker, (begin, end) in enumerate(ranges)
            )
            left = [(begin, end) for begin, (_, end) in zip(reached, ranges, strict=True) if begin < end]
            pending.extend(left)
            short = short or bool(left)
            self._take_in(kernels, range(len(ranges)), make_room)
        if not self.divided:
            return
        fill = max(worker.expander.count / worker.expander.capacity for worker in self.workers)
        if short:
            self._rows = max(64, self._rows // 2)
        elif fill < 0.4:
            self._rows = min(MOST_ROWS, 2 * self._rows)

    def _producing(self, kernels: Kernels, step: Wave, number: int, first: int, last: int) -> Callable[[], int]:
        def produce() -> int:
            worker = self.workers[number]
            reached = worker.produce(kernels, step, first, last)
            made = worker.expander
            room = len(made.targets) * len(self.workers)
            if len(self._outboxes[number]) < room:
                self._outboxes[number] = np.empty(room, dtype=np.int64)
            kernels.sort_by_owner(
                made.targets,
                made.count,
                made.stride,
                self._visited.partition_bits,
                len(self.workers),
                made.capacity,
                self._ends[number],
                self._outboxes[number],
            )
            return reached

        return produce

    def _take_in(self, kernels: Kernels, producers: Iterable[int], make_room: Callable[[], None]) -> None:
        """Add what the outboxes of the given workers hold to the visited states."""
        visited, owners = self._visited, self._owners
        for o, owner in enumerate(owners):
            boxes = [
                (self._outboxes[p], o * self.workers[p].expander.capacity, int(self._ends[p][o])) for p in producers
            ]
            owner.waiting = [box for box in boxes if box[1] < box[2]]
        while any(owner.waiting for owner in owners):
            if visited.room - visited.known < 64 * len(owners):
                make_room()
            if not self.divided:
                self._take_in_alone(kernels, make_room)
                return
            quota = (visited.room - visited.known) // len(owners)
            self.together(_claiming(owner, kernels, visited, quota) for owner in owners)
            firsts = visited.known + np.cumsum([0, *(owner.claimed for owner in owners)])
            self.together(
                _settling(owner, kernels, visited, first) for owner, first in zip(owners, firsts.tolist(), strict=False)
            )
            visited.known = int(firsts[-1])
            if any(owner.waiting and owner.claimed < min(quota, CLAIMED) for owner in owners):
                self.relieve(kernels, make_room)

    def _take_in_alone(self, kernels: Kernels, make_room: Callable[[], None]) -> None:
        """Add what all owners are waiting for, in this thread."""
        for owner in self._owners:
            for outbox, begin, end in owner.waiting:
                while begin < end:
                    begin = self._visited.insert(kernels, outbox, begin, end)
                    if begin < end:
                        make_room()
            owner.waiting = []


def _claiming(owner: Owner, kernels: Kernels, visited: Visited, quota: int) -> Callable[[], None]:
    return lambda: owner.claim(kernels, visited, quota)


def _settling(owner: Owner, kernels: Kernels, visited: Visited, first: int) -> Callable[[], None]:
    return lambda: owner.settle(kernels, visited, first)
