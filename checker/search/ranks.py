"""Processes that search together by messages: the few things that they do together.

Each is done by all of them, in the same order. MPI does them between machines (MPI Forum, "MPI: A Message-Passing
Interface Standard"); threads do for tests.
"""

from __future__ import annotations

import sys
import time
from typing import Any, Protocol

import numpy as np

from cspcheck.checker.arrays import Int64Array

PATIENCE = 0.01
"""Seconds between two looks for work of a process that has none: it is not to take a processor's time meanwhile."""


class Ranks(Protocol):
    """Processes numbered from 0, the first of which knows what is to be done."""

    rank: int
    size: int
    bytes_sent: int

    def swap(self, rows: Int64Array, lengths: Int64Array, said: int) -> tuple[Int64Array, int]:
        """Send each process its part of *rows*, in words and in order; what came, and what all have *said*, or-ed."""

    def total(self, numbers: Int64Array) -> Int64Array:
        """The sums over all processes."""

    def together(self, rows: Int64Array) -> list[Int64Array]:
        """The rows of each process, for every process."""

    def hand_out(self, job: Any) -> None:
        """Give the others something to do (the first process only)."""

    def wait(self) -> Any:
        """The next thing to do (the others only)."""

    def abort(self) -> None:
        """End all processes at once."""


class SingleRank:
    """One process by itself."""

    rank = 0
    size = 1
    bytes_sent = 0

    def swap(self, rows: Int64Array, lengths: Int64Array, said: int) -> tuple[Int64Array, int]:
        """The same rows."""
        return rows[: int(lengths[0])], said

    def total(self, numbers: Int64Array) -> Int64Array:
        """The same numbers."""
        return numbers

    def together(self, rows: Int64Array) -> list[Int64Array]:
        """The same rows."""
        return [rows]

    def hand_out(self, job: Any) -> None:
        """There is nobody to give it to."""

    def wait(self) -> Any:
        """There is nobody to wait for."""

    def abort(self) -> None:
        """There is nobody to end."""


class MpiRanks:
    """The processes that ``mpiexec`` has started.

    Raises:
        ImportError: ``mpi4py`` is not installed, or no MPI library that it finds.
    """

    def __init__(self) -> None:
        from mpi4py import MPI

        self._mpi = MPI
        self._world = MPI.COMM_WORLD
        self.rank: int = self._world.Get_rank()
        self.size: int = self._world.Get_size()
        self.bytes_sent = 0

    def swap(self, rows: Int64Array, lengths: Int64Array, said: int) -> tuple[Int64Array, int]:
        """``Alltoall`` of the lengths, then ``Alltoallv`` of the rows."""
        header: Int64Array = np.empty((self.size, 2), dtype=np.int64)
        header[:, 0], header[:, 1] = lengths, said
        arrived = np.empty_like(header)
        self._world.Alltoall(header, arrived)
        counts = arrived[:, 0].copy()
        received: Int64Array = np.empty(int(counts.sum()), dtype=np.int64)
        self._world.Alltoallv(
            [rows, (lengths, _starts(lengths)), self._mpi.INT64_T],
            [received, (counts, _starts(counts)), self._mpi.INT64_T],
        )
        self.bytes_sent += 8 * int(lengths.sum() - lengths[self.rank])
        return received, int(np.bitwise_or.reduce(arrived[:, 1]))

    def total(self, numbers: Int64Array) -> Int64Array:
        """``Allreduce``."""
        sums = np.empty_like(numbers)
        self._world.Allreduce(numbers, sums, op=self._mpi.SUM)
        return sums

    def together(self, rows: Int64Array) -> list[Int64Array]:
        """``Allgatherv``."""
        lengths: Int64Array = np.empty(self.size, dtype=np.int64)
        self._world.Allgather(np.array([len(rows)], dtype=np.int64), lengths)
        everything: Int64Array = np.empty(int(lengths.sum()), dtype=np.int64)
        rows = np.ascontiguousarray(rows)
        self._world.Allgatherv(rows, [everything, (lengths, _starts(lengths)), self._mpi.INT64_T])
        return np.split(everything, np.cumsum(lengths)[:-1])

    def hand_out(self, job: Any) -> None:
        """One message to each."""
        for rank in range(1, self.size):
            self._world.send(job, dest=rank)

    def wait(self) -> Any:
        """The next message."""
        while not self._world.iprobe(source=0):
            time.sleep(PATIENCE)
        return self._world.recv(source=0)

    def abort(self) -> None:
        """End all processes at once, with the exit code of a mistake."""
        sys.stdout.flush()
        sys.stderr.flush()
        self._world.Abort(4)


def _starts(lengths: Int64Array) -> Int64Array:
    starts: Int64Array = np.cumsum(lengths) - lengths
    return starts
