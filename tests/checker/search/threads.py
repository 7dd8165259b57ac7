"""Threads that search together as processes do by messages."""

from __future__ import annotations

import contextlib
import queue
import threading
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.search.cluster import Cluster

T = TypeVar("T")


class Shared:
    """What the threads have in common."""

    def __init__(self, size: int) -> None:
        self.barrier = threading.Barrier(size)
        self.table: list[Any] = [None] * size
        self.jobs: list[queue.Queue[Any]] = [queue.Queue() for _ in range(size)]


class ThreadRanks:
    """One of the threads."""

    def __init__(self, shared: Shared, rank: int) -> None:
        self.rank = rank
        self.size = len(shared.table)
        self.bytes_sent = 0
        self._shared = shared

    def _all(self, mine: Any) -> list[Any]:
        self._shared.table[self.rank] = mine
        self._shared.barrier.wait(120)
        found = list(self._shared.table)
        self._shared.barrier.wait(120)
        return found

    def swap(self, rows: Int64Array, lengths: Int64Array, said: int) -> tuple[Int64Array, int]:
        """What is for this thread."""
        parts = np.split(rows.copy(), np.cumsum(lengths)[:-1])
        found = self._all((parts, said))
        self.bytes_sent += 8 * int(lengths.sum() - lengths[self.rank])
        return np.concatenate([parts[self.rank] for parts, _ in found]), int(
            np.bitwise_or.reduce([s for _, s in found])
        )

    def total(self, numbers: Int64Array) -> Int64Array:
        """The sums."""
        return np.sum(self._all(numbers.copy()), axis=0)

    def together(self, rows: Int64Array) -> list[Int64Array]:
        """All rows."""
        return self._all(rows.copy())

    def hand_out(self, job: Any) -> None:
        """A job for each."""
        for jobs in self._shared.jobs[1:]:
            jobs.put(job)

    def wait(self) -> Any:
        """The next job."""
        return self._shared.jobs[self.rank].get(timeout=120)

    def abort(self) -> None:
        """End the others."""
        self._shared.barrier.abort()


def with_ranks(size: int, work: Callable[[Cluster], T]) -> T:
    """Do something in the first of so many threads while the others serve."""
    shared = Shared(size)

    def serve(rank: int) -> None:
        with contextlib.suppress(threading.BrokenBarrierError):  # the first one has failed
            Cluster(ThreadRanks(shared, rank)).serve()

    threads = [threading.Thread(target=serve, args=(rank,), name=f"rank {rank}") for rank in range(1, size)]
    for thread in threads:
        thread.start()
    first = Cluster(ThreadRanks(shared, 0))
    try:
        return work(first)
    finally:
        first.dismiss()
        for thread in threads:
            thread.join(120)
