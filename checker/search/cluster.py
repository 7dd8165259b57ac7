"""Searches by several processes, on one machine or on many: each has its part of the states.

A state belongs to the process that its hash names (Stern and Dill, "Parallelizing the Murphi verifier", CAV 1997).
Successors travel in large batches, all to all, until a wave of taus or a level is done; what is asked of a level is
added up at its end. Levels and what they show do not depend on how many processes there are.

The first process runs the check; the others wait for searches that it hands out. Limits and the wish to stop travel
with the batches, so that all stop at the same place.
"""

from __future__ import annotations

import functools
import os
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cspcheck.checker.arrays import Int64Array, UInt8Array
from cspcheck.checker.kernels import jit
from cspcheck.checker.kernels.jit import Kernels
from cspcheck.checker.network.network import Network
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.checkpoint import Checkpoint, Checkpoints, Position, Tally
from cspcheck.checker.search.findings import Findings, StopReason
from cspcheck.checker.search.levels import PROGRESS_SECONDS, Progress
from cspcheck.checker.search.pairs import Pairs
from cspcheck.checker.search.part import Part, Rows, cyclic_rows
from cspcheck.checker.search.ranks import MpiRanks, Ranks
from cspcheck.checker.search.walk import Walk
from cspcheck.checker.search.worker import Wave, Worker, drop_at_divergent_nodes
from cspcheck.checker.verdict import Limits

BATCH = 1 << 17
"""Transitions that a process sends at a time, about."""

MORE, LATE, FULL, CANCELLED = 1, 2, 4, 8
"""What travels with a batch: there is more to come; the time, or the memory, is used up; the check was ended."""


@dataclass(frozen=True, slots=True)
class Job:
    """A search for all processes.

    Attributes:
        packed: what is searched, without what only explanations need.
        pairs: the specification beside it.
        limits: of each process; the states are those of all together.
        aims: whether to stop at a deadlock, at a divergence, at a violation, and whether to look for divergence; the
            last level to be looked at, if there is one.
        compiled: whether the kernels are compiled.
        checkpoint: the folder and the name of the search's checkpoint, if it has one.
    """

    packed: PackedNetwork
    pairs: Pairs | None
    limits: Limits
    aims: tuple[bool, bool, bool, bool, int | None]
    compiled: bool
    checkpoint: tuple[Path, str] | None = None


class Cluster:
    """The processes that search together; given to searches in the place of a folder on disk.

    Attributes:
        is_broken: whether this process has failed in the midst of a search, where the others still are.
    """

    def __init__(self, ranks: Ranks) -> None:
        self.ranks = ranks
        self.is_broken = False

    def serve(self) -> None:
        """Take part in all searches that the first process hands out, until there are no more."""
        while True:
            job = self.ranks.wait()
            if job is None:
                return
            search = SharedSearch(self.ranks, job)
            search.search()

    def dismiss(self) -> None:
        """Let the other processes end; where they cannot hear of it any more, end all, this one too."""
        if self.is_broken:
            self.ranks.abort()
            return
        self.ranks.hand_out(None)


@functools.cache
def world() -> Cluster:
    """The processes that ``mpiexec`` has started.

    Raises:
        ImportError, RuntimeError: there is no MPI.
    """
    return Cluster(MpiRanks())


class SharedSearch(Findings):
    """One process's part in a search. The attributes are those of ``LevelSearch``, the same in all processes."""

    def __init__(
        self,
        ranks: Ranks,
        job: Job,
        progress: Callable[[Progress], None] | None = None,
        checkpoint: Checkpoint | None = None,
    ) -> None:
        super().__init__(job.packed, job.pairs)
        self.branching = False
        self.known = 0
        self.cancelled = False
        self.is_explored = False
        self.starts = [0]
        self._ranks = ranks
        self._job = job
        self._limits = job.limits
        if checkpoint is None and job.checkpoint is not None:
            folder, name = job.checkpoint
            checkpoint = Checkpoint(Checkpoints.beside(folder), name)
        self._checkpoint = checkpoint
        self._written = 0
        self._kernels: Kernels = jit.kernels(job.compiled)
        self._progress = progress
        self._worker = Worker(job.packed, job.pairs, capacity=BATCH)
        self._earlier = Tally(0, [0], [], 0, 0, 0, False, False, None, None, None)
        self._outbox: Int64Array = np.zeros(0, dtype=np.int64)
        self._ends: Int64Array = np.zeros(ranks.size, dtype=np.int64)
        self._said = 0
        self._started = time.monotonic()
        self._told = self._started
        self._walk: Walk | None = None

    def search(self) -> None:
        """Search, and take out what is told of."""
        try:
            self._explore()
        except _Ended:
            pass
        finally:
            self.peak_memory_bytes = max(self.peak_memory_bytes, self._bytes())
            self.seconds = time.monotonic() - self._started
        self.is_explored = not self.cancelled
        if not self.cancelled:
            # What ended the search does not end this.
            self._said, self._limits = self._said & CANCELLED, Limits()
            try:
                self._walk = Part(self._kernels, self, _Spread(self)).ways()
            except _Ended:
                assert self.cancelled

    def walk(self) -> Walk:
        """The ways to what was found."""
        assert self._walk is not None
        return self._walk

    def _explore(self) -> None:
        if not self._resumed():
            if self._ranks.rank == 0:
                self._exchange(self.initial, self._take_in)
            else:
                self._exchange(self.initial[:0], self._take_in)
            self.known = self._total(self.visited.known)
        while not self.complete and self.stop is None:
            self._explore_level(self.starts[-1])

    def _explore_level(self, start: int) -> None:
        visited = self.visited
        before = self._transitions()
        moved: UInt8Array = np.zeros(0, dtype=np.uint8)
        first, divergence = start, False
        if len(self.packed.tau.items):
            while self._total(visited.known - first):
                end = visited.known
                moved = np.concatenate([moved, np.zeros(end - start - len(moved), dtype=np.uint8)])
                self._expand(Wave(self.packed.tau, False, visited.rows, start, moved), first, end)
                first = end
            taus = self._transitions() - before
            self.has_tau |= taus > 0
            if taus and self._job.aims[3]:
                divergence = self._total(len(self._left(start, visited.known))) > 0
        end = visited.known
        self._expand(Wave(self.packed.visible, True, visited.rows, start, moved), start, end)
        self._finish_level(end, divergence)

    def _finish_level(self, end: int, divergence: bool) -> None:
        worker, earlier = self._worker, self._earlier
        branching = int(worker.expander.scratch.branching[0] != 0)
        due_here = self._ranks.rank == 0 and self._checkpoint is not None and self._checkpoint.is_due()
        sums = self._ranks.total(
            np.array(
                [
                    end,
                    self.visited.known,
                    worker.deadlocks,
                    int(worker.violated != 0),
                    branching,
                    int(due_here),
                    int(self._said & FULL != 0),
                ],
                dtype=np.int64,
            )
        ).tolist()
        states, known, deadlocks, violated, branched, due, full = sums
        if full:
            # Somebody had no room for what came with the last batch.
            self._end("memory")
        self.known = known
        limit = self._limits.states
        if limit is not None and known > limit:
            self._end("states")
        level = len(self.levels) - 1
        self.levels.append(states)
        self.starts.append(end)
        self.transitions = self._transitions()
        self.transitions_at.append(self.transitions)
        self.branching = branched > 0 or earlier.branching
        if divergence and self.divergence_level is None:
            self.divergence_level = level
        if deadlocks + earlier.deadlocks and self.deadlock_level is None:
            self.deadlock_level = level
        if (violated or earlier.violated or (divergence and self.pairs is not None)) and self.violation_level is None:
            self.violation_level = level
        at_deadlock, at_divergence, at_violation, _, deepest = self._job.aims
        found = (
            (at_deadlock and self.deadlock_level is not None)
            or (at_divergence and self.divergence_level is not None)
            or (at_violation and self.violation_level is not None)
        )
        self.complete = states == known
        if found and not self.complete:
            self.stop = "found"
        elif level == deepest and not self.complete:
            self.stop = "depth"
        if due and not self.complete and self.stop is None:
            self._write_checkpoint(deadlocks + earlier.deadlocks, violated | earlier.violated)

    def _expand(self, step: Wave, first: int, last: int) -> None:
        """Expand rows of this process, and take in what all processes have found for it."""
        worker = self._worker
        while True:
            step.rows = self.visited.rows
            rows: Int64Array = np.zeros(0, dtype=np.int64)
            if first < last:
                until = min(last, first + BATCH)
                try:
                    first = worker.produce(self._kernels, step, first, until)
                    rows = worker.expander.targets[: worker.expander.count * self.visited.stride]
                except MemoryError:
                    self._said |= FULL
            if not self._exchange(rows, self._take_in, more=first < last):
                return

    def _exchange(self, rows: Int64Array, take: Callable[[Int64Array], None], *, more: bool = False) -> bool:
        """Send rows to those they belong to, and take what has come; whether anybody has more."""
        stride, size = self.visited.stride, self._ranks.size
        count = len(rows) // stride
        if len(self._outbox) < count * stride * size:
            try:
                self._outbox = np.empty(count * stride * size, dtype=np.int64)
            except MemoryError:
                # The others have to hear of it; what is not sent does not matter then.
                self._said |= FULL
                rows, count = rows[:0], 0
        self._kernels.sort_by_rank(rows, count, stride, size, count, self._ends, self._outbox)
        lengths = self._ends * stride - np.arange(size) * count * stride
        parts = [self._outbox[i * count * stride :][: lengths[i]] for i in range(size)]
        received, said = self._ranks.swap(np.concatenate(parts), lengths, self._words(more))
        if said & ~MORE:
            self.cancelled = bool(said & CANCELLED)
            self._end("memory" if said & FULL else "seconds")
        take(received)
        self._tell()
        return bool(said & MORE)

    def _words(self, more: bool) -> int:
        """What this process has to say with its batch."""
        limits = self._limits
        said = self._said | (MORE if more else 0)
        if limits.seconds is not None and time.monotonic() - self._started > limits.seconds:
            said |= LATE
        if limits.memory_bytes is not None and self._bytes() > limits.memory_bytes:
            said |= FULL
        return said

    def cancel(self) -> None:
        """Have all processes stop with the next batch."""
        self._said = CANCELLED

    def _bytes(self) -> int:
        return self.visited.bytes + self._worker.expander.nbytes + self._outbox.nbytes

    def _take_in(self, rows: Int64Array) -> None:
        count, place, visited = len(rows) // self.visited.stride, 0, self.visited
        limit = self._limits.memory_bytes
        while place < count:
            place = visited.insert(self._kernels, rows, place, count)
            if place < count:
                if limit is not None and visited.bytes_after_growth() > limit:
                    # The others have to hear of it; the level does not count.
                    self._said |= FULL
                    return
                try:
                    visited.grow(self._kernels)
                except MemoryError:
                    self._said |= FULL
                    return
        self.peak_memory_bytes = max(self.peak_memory_bytes, visited.peak_bytes, self._bytes())

    def _left(self, first: int, last: int) -> Int64Array:
        """The numbers of the rows of a level that stay when rows at which no tau arrives are taken away, and again.

        Kahn's topological sorting, as in ``peel``, a batch at a time.
        """
        arrivals: Int64Array = np.zeros(last - first, dtype=np.int64)

        def count(rows: Int64Array) -> None:
            np.add.at(arrivals, self._places(rows, first, last), 1)

        self._send_taus(np.arange(first, last), count)
        left = np.ones(last - first, dtype=np.bool_)
        taken: Int64Array = np.flatnonzero(arrivals == 0)
        while self._total(len(taken)):
            left[taken] = False

            def discount(rows: Int64Array) -> None:
                np.subtract.at(arrivals, self._places(rows, first, last), 1)

            self._send_taus(first + taken, discount)
            taken = np.flatnonzero((arrivals == 0) & left)
        return first + np.flatnonzero(left)

    def _places(self, rows: Int64Array, first: int, last: int) -> Int64Array:
        """Where in a level rows are that have come; those that are not in it are left out."""
        count = len(rows) // self.visited.stride
        numbers = np.full(count, -1, dtype=np.int64)
        self.visited.find(self._kernels, rows, count, numbers)
        return numbers[(numbers >= first) & (numbers < last)] - first

    def _send_taus(self, numbers: Int64Array, take: Callable[[Int64Array], None]) -> None:
        """Send what taus that might go round lead to from some rows to those they belong to."""
        made, stride, place = self._worker.expander, self.visited.stride, 0
        while True:
            rows: Int64Array = np.zeros(0, dtype=np.int64)
            if place < len(numbers):
                chosen = self.visited.states[numbers[place : place + BATCH]].reshape(-1)
                reached = made.run(self._kernels, self.packed.cycling, chosen, 0, len(chosen) // stride)
                if self.pairs is not None:
                    drop_at_divergent_nodes(self._kernels, made, self._worker.guide, chosen, 0)
                rows = made.targets[: made.count * stride]
                place += reached
            if not self._exchange(rows, take, more=place < len(numbers)):
                return

    def _total(self, number: int) -> int:
        return int(self._ranks.total(np.array([number], dtype=np.int64))[0])

    def _transitions(self) -> int:
        return self._earlier.transitions + self._total(self._worker.transitions)

    def _end(self, reason: StopReason) -> None:
        self.stop = reason
        raise _Ended

    def _tell(self) -> None:
        now = time.monotonic()
        if self._progress is not None and now - self._told >= PROGRESS_SECONDS:
            self._told = now
            states = self.visited.known * self._ranks.size
            transitions = self._worker.transitions * self._ranks.size
            frontier = states - self.levels[-1]
            depth = len(self.levels) - 1
            self._progress(Progress(states, transitions, depth, frontier, now - self._started, self._bytes()))

    def _resumed(self) -> bool:
        """Take up the search where it was written down, whoever has done that."""
        checkpoint = self._checkpoint
        found = None if checkpoint is None else checkpoint.load(self.visited.stride)
        sound, known, stride = False, 0, self.visited.stride
        if found is not None and checkpoint is not None:
            tally, at = found
            # A level that was begun begins anew: what its visible events have led to does not count yet.
            known = at.end if at.visible else tally.known
            sound = checkpoint.take_up(tally.known * stride, known * stride)
        if self._total(int(sound)) < self._ranks.size or found is None or checkpoint is None:
            return False
        tally, at = found
        ends = [*tally.levels[1:], known]
        for first, last in zip(tally.levels, ends, strict=True):
            for rows in checkpoint.rows(first * stride, last * stride):
                self._take_own(rows)
            self.starts.append(self.visited.known)
        del self.starts[-1]
        self._written = self.visited.known
        if known < tally.known:
            # What lies behind the rows that count will be written over.
            tally.known = known
            start = Position(done=tally.levels[-1], first=tally.levels[-1], end=known, before=at.before)
            checkpoint.settle(0, known * stride, tally, start, first=self._ranks.rank == 0)
            self._total(0)
        tally.transitions = at.before
        self._earlier, self.known = tally, self._total(self.visited.known)
        self.levels, self.transitions_at, self.has_tau = tally.levels, tally.transitions_at, tally.has_tau
        self.transitions = at.before
        self.deadlock_level, self.divergence_level = tally.deadlock_level, tally.divergence_level
        self.violation_level, self.branching = tally.violation_level, tally.branching
        return True

    def _take_own(self, rows: Int64Array) -> None:
        stride, size = self.visited.stride, self._ranks.size
        count = len(rows) // stride
        outbox: Int64Array = np.empty(len(rows) * size, dtype=np.int64)
        self._kernels.sort_by_rank(rows, count, stride, size, count, self._ends, outbox)
        rank = self._ranks.rank
        self._take_in(outbox[rank * count * stride : int(self._ends[rank]) * stride])

    def _write_checkpoint(self, deadlocks: int, violated: int) -> None:
        """Write down where the search is, between two levels: each process its own rows, level by level."""
        checkpoint, stride = self._checkpoint, self.visited.stride
        assert checkpoint is not None
        base = checkpoint.written
        tally = Tally(
            self.known,
            self.levels,
            self.transitions_at,
            self.transitions,
            deadlocks,
            violated,
            self.branching,
            self.has_tau,
            self.deadlock_level,
            self.divergence_level,
            self.violation_level,
        )
        ends = [*self.starts[1:], self.visited.known]
        pieces: list[tuple[int, Int64Array]] = []
        for first, last in zip(self.starts, ends, strict=True):
            rows = self.visited.rows[max(first, self._written) * stride : max(last, self._written) * stride]
            lengths = [int(part[0]) for part in self._ranks.together(np.array([len(rows)], dtype=np.int64))]
            pieces.append((base + sum(lengths[: self._ranks.rank]), rows))
            base += sum(lengths)
        answers = self._ranks.together(np.array(checkpoint.write_pieces(pieces), dtype=np.int64))
        failures = [int(answer[0]) for answer in answers if answer[0]]
        if failures:
            checkpoint.give_up(os.strerror(failures[0]))
            return
        total = sum(int(answer[1]) for answer in answers)
        position = Position(done=self.levels[-1], first=self.levels[-1], end=self.known, before=self.transitions)
        checkpoint.settle(total, base, tally, position, first=self._ranks.rank == 0)
        self._written = self.visited.known


class _Ended(Exception):
    """The search has come to an end before everything was looked at."""


class _Spread:
    """The rows of all processes, to take a part of."""

    def __init__(self, search: SharedSearch) -> None:
        self._search = search

    def blocks(self, level: int) -> Iterator[Int64Array]:
        """The rows of a level that are this process's own."""
        search = self._search
        stride = search.visited.stride
        yield search.visited.rows[search.starts[level] * stride : search.starts[level + 1] * stride]

    def all_of(self, rows: Int64Array) -> Int64Array:
        """The rows that all processes have found."""
        return np.concatenate(self._search._ranks.together(rows))

    def cyclic(self, level: int) -> Int64Array:
        """The rows of a level that lie on cycles of taus."""
        search = self._search
        numbers = search._left(search.starts[level], search.starts[level + 1])
        rows = Rows(search._kernels, search.visited.stride)
        rows.add(self.all_of(search.visited.states[numbers].reshape(-1)))
        return cyclic_rows(search.packed, search.pairs, rows.visited)


_NO_NETWORK = Network((), ())


class ClusterSearch(SharedSearch):
    """A search that the first process hands out, and takes part in."""

    def __init__(
        self,
        packed: PackedNetwork,
        pairs: Pairs | None,
        *,
        cluster: Cluster,
        limits: Limits,
        workers: int,
        stop_at_deadlock: bool = False,
        stop_at_divergence: bool = False,
        stop_at_violation: bool = False,
        look_for_divergence: bool = True,
        deepest: int | None = None,
        progress: Callable[[Progress], None] | None = None,
        notify: Callable[[str], None] | None = None,
        compiled: bool | None = None,
        checkpoints: Checkpoints | None = None,
    ) -> None:
        aims = (
            stop_at_deadlock,
            stop_at_divergence,
            stop_at_violation,
            look_for_divergence and len(packed.cycling.items) > 0,
            deepest,
        )
        if compiled is None:
            jit.kernels(True, notify)
        checkpoint = None if checkpoints is None else checkpoints.search(packed, pairs, aims)
        job = Job(
            replace(packed, network=_NO_NETWORK),
            pairs,
            limits,
            aims,
            compiled is None or compiled,
            None if checkpoint is None else (checkpoint.folder, checkpoint.name),
        )
        cluster.ranks.hand_out(job)
        self._latest: Progress | None = None
        super().__init__(cluster.ranks, job, None if progress is None else self._note, checkpoint)
        self._listener = progress
        self._cluster = cluster
        self._whole = packed
        self._begun, self._over = threading.Lock(), threading.Event()
        self._error: BaseException | None = None
        self._ended_by: BaseException | None = None

    def run(self) -> None:
        """Search; whoever ends the check meanwhile ends the search in all processes."""
        try:
            threading.Thread(target=self._run, name="search", daemon=True).start()
            # Not `join`: where that is interrupted, CPython up to 3.12 takes the thread for one that has ended.
            while not self._over.wait(PROGRESS_SECONDS):
                # Who is told may end the check by that, which must not end the search in this process only.
                latest, self._latest = self._latest, None
                if self._listener is not None and latest is not None:
                    self._listener(latest)
        except BaseException as error:
            self.cancel()
            self._run()  # if nobody does it yet
            self._over.wait()
            if not self.is_explored or not self.has_found:
                raise
            self._ended_by = error
        if self._error is not None:
            raise self._error

    def _note(self, progress: Progress) -> None:
        self._latest = progress

    def _run(self) -> None:
        if not self._begun.acquire(blocking=False):
            return
        try:
            self.search()
        except BaseException as error:
            # The others do not know of it, and wait.
            self._error, self._cluster.is_broken = error, True
        finally:
            self._over.set()

    def walk(self) -> Walk:
        """The ways to what was found.

        Raises:
            BaseException: whatever ended the check after something was found and before it was taken out.
        """
        if self._ended_by is not None:
            raise self._ended_by
        found = super().walk()
        return Walk(self._whole, self.pairs, found.visited, found.levels)
