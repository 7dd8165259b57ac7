"""The search itself: level-synchronous, breadth first by visible distance, in chunks.

Each level is first closed under tau in waves, then its states' visible transitions make the next level. Machines
and pairs are searched alike; pairs take the specification along between expansion and insertion.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.guard import working_time
from cspcheck.checker.kernels import jit
from cspcheck.checker.kernels.arrays import Index
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.checkpoint import Checkpoints, Position, Tally
from cspcheck.checker.search.crew import SHARED_CAPACITY, Crew
from cspcheck.checker.search.expansion import CAPACITY, SMALL_CAPACITY, Expander
from cspcheck.checker.search.findings import Findings, StopReason
from cspcheck.checker.search.pace import Pace
from cspcheck.checker.search.pairs import Pairs
from cspcheck.checker.search.visited import Visited
from cspcheck.checker.search.walk import Walk
from cspcheck.checker.search.worker import Wave, Worker, drop_at_divergent_nodes
from cspcheck.checker.verdict import Limits

INTERPRETED_TRANSITIONS = 8_000
"""A search that has more transitions than this changes to the compiled kernels."""
INTERPRETED_SECONDS = 0.5
"""One that takes longer than this does, too."""
INTERPRETED_ROWS = 64
"""Rows that are expanded at a time by interpreted kernels."""
PARALLEL_ROWS = 4_096
"""Runs of fewer rows are expanded by one thread."""
PARALLEL_STATES = 250_000
"""Before so many states have been found threads are not tried: making a crew of them costs more than they gain."""
NO_LIMITS = Limits()
"""A search that ends only when everything is explored."""
PROGRESS_SECONDS = 0.2
"""How often progress is told."""


@dataclass(frozen=True, slots=True)
class Progress:
    """Where a search is. ``memory_bytes`` counts the engine's arrays, ``frontier`` the states not yet expanded."""

    states: int
    transitions: int
    depth: int
    frontier: int
    seconds: float
    memory_bytes: int


class SearchStopped(Exception):
    """A limit has been reached."""

    def __init__(self, reason: StopReason) -> None:
        super().__init__(reason)
        self.reason = reason


class LevelSearch(Findings):
    """One search. :meth:`run` it once; the attributes then are those of ``Exploration``."""

    def __init__(
        self,
        packed: PackedNetwork,
        pairs: Pairs | None = None,
        *,
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
        super().__init__(packed, pairs)
        self._limits = limits
        self._stop_at_deadlock = stop_at_deadlock
        self._stop_at_divergence = stop_at_divergence
        self._stop_at_violation = stop_at_violation
        self._deepest = deepest
        self._look_for_divergence = look_for_divergence and len(packed.cycling.items) > 0
        self._progress = progress
        self._notify = notify
        self._may_compile = compiled is None
        self._kernels = jit.kernels(jit.is_loaded() if compiled is None else compiled)
        self._worker = Worker(packed, pairs, capacity=SMALL_CAPACITY)
        self._workers = workers
        self._crew: Crew | None = None
        self._pace = Pace()
        self._level_bytes = 0
        self._started = working_time()
        self._told = self._started
        self._at = Position()
        self._earlier_deadlocks = 0
        self._earlier_violated = 0
        self._earlier_branching = False
        aims = (stop_at_deadlock, stop_at_divergence, stop_at_violation, self._look_for_divergence, deepest)
        self._checkpoint = None if checkpoints is None else checkpoints.search(packed, pairs, aims)

    @property
    def known(self) -> int:
        """How many states have been found."""
        return self.visited.known

    @property
    def branching(self) -> bool:
        """Whether some state was seen to have two targets for one visible event."""
        here = any(worker.expander.scratch.branching[0] != 0 for worker in self._all_workers())
        return here or self._earlier_branching

    def walk(self) -> Walk:
        """What the search has found, to be walked about in."""
        return Walk(self.packed, self.pairs, self.visited, tuple(self.levels))

    def run(self) -> None:
        """Search until everything is explored, what is looked for is found, or a limit is reached."""
        try:
            self._explore()
        except SearchStopped as stopped:
            self.stop = stopped.reason
        except MemoryError:
            self.stop = "memory"
        finally:
            if self._crew is not None:
                self._crew.dismiss()
            self._note_peak()
            self.seconds = working_time() - self._started

    def _explore(self) -> None:
        if not self._resumed():
            self._insert(self.initial.copy(), 1)
            self._at = Position(end=self.known)
        while not self.complete and self.stop is None:
            self._explore_level(self.levels[-1])

    def _explore_level(self, start: int) -> None:
        """Explore a level, from where the search is in it."""
        at = self._at
        if not at.visible:
            if len(self.packed.tau.items):
                self._close_under_tau(start)
                taus = self._all_transitions() - at.before
                self.has_tau |= taus > 0
                if taus and self._look_for_divergence:
                    at.divergence = self._has_tau_cycle(start)
            at.visible, at.first, at.end = True, start, self.known
        self._expand(self.packed.visible, visible=True, start=start)
        self._finish_level(at.end, at.divergence)
        self._at = Position(done=at.end, first=at.end, end=self.known, before=self._all_transitions())

    def _close_under_tau(self, start: int) -> None:
        """Add all states that taus lead to from the level, wave by wave, and note which rows have taus."""
        at = self._at
        while at.done < self.known:
            if len(at.moved) < at.end - start:
                grown = np.zeros(at.end - start, dtype=np.uint8)
                grown[: len(at.moved)] = at.moved
                at.moved = grown
            self._level_bytes = at.moved.nbytes
            self._expand(self.packed.tau, visible=False, start=start)
            at.done = at.first = at.end
            at.end = self.known

    def _resumed(self) -> bool:
        """Take up the search where it was written down, if it was."""
        found = None if self._checkpoint is None else self._checkpoint.load(self.visited.stride)
        if found is None:
            return False
        assert self._checkpoint is not None
        tally, at = found
        if not self._take_up(tally):
            return False
        self._at = at
        self._worker.transitions = tally.transitions
        self._earlier_deadlocks, self._earlier_violated = tally.deadlocks, tally.violated
        self._earlier_branching = tally.branching
        self.levels, self.has_tau = tally.levels, tally.has_tau
        self.transitions_at = tally.transitions_at
        self.transitions = self._at.before
        self.deadlock_level, self.divergence_level = tally.deadlock_level, tally.divergence_level
        self.violation_level = tally.violation_level
        self._note_peak()
        return True

    def _take_up(self, tally: Tally) -> bool:
        """Take up the states that were written down; whether they are those."""
        assert self._checkpoint is not None
        return self.visited.take(self._kernels, tally.known, self._checkpoint.fill)

    def _tally(self) -> Tally:
        """What counts where the search is."""
        workers = self._all_workers()
        return Tally(
            self.known,
            self.levels,
            self.transitions_at,
            self._all_transitions(),
            self._earlier_deadlocks + sum(worker.deadlocks for worker in workers),
            self._earlier_violated | functools.reduce(operator.or_, (int(worker.violated) for worker in workers)),
            self.branching,
            self.has_tau,
            self.deadlock_level,
            self.divergence_level,
            self.violation_level,
        )

    def _write_checkpoint(self) -> None:
        """Write down where the search is: between two runs of rows everything that was found is in place."""
        assert self._checkpoint is not None
        self._checkpoint.write(self.visited.rows, self.visited.stride, self._tally(), self._at)

    def _finish_level(self, end: int, divergence: bool) -> None:
        # Where in a level the limit is noticed depends on chance; that the level reaches it does not.
        self._check_states()
        level = len(self.levels) - 1
        workers = self._all_workers()
        deadlocks = self._earlier_deadlocks + sum(worker.deadlocks for worker in workers)
        violated = self._earlier_violated or any(worker.violated for worker in workers)
        violated = violated or (divergence and self.pairs is not None)
        self.levels.append(end)
        self.transitions = self._all_transitions()
        self.transitions_at.append(self.transitions)
        if divergence and self.divergence_level is None:
            self.divergence_level = level
        if deadlocks and self.deadlock_level is None:
            self.deadlock_level = level
        if violated and self.violation_level is None:
            self.violation_level = level
        found = (
            (self._stop_at_deadlock and self.deadlock_level is not None)
            or (self._stop_at_divergence and self.divergence_level is not None)
            or (self._stop_at_violation and self.violation_level is not None)
        )
        self.complete = end == self.known
        if found and not self.complete:
            self.stop = "found"
        elif level == self._deepest and not self.complete:
            self.stop = "depth"

    def _all_workers(self) -> list[Worker]:
        return [self._worker, *(self._crew.workers if self._crew else ())]

    def _all_transitions(self) -> int:
        return self._worker.transitions + (self._crew.transitions if self._crew else 0)

    def _expand(self, index: Index, *, visible: bool, start: int) -> None:
        """Expand the rows from where the search is to the end there, and add their successors to the visited states."""
        at, last = self._at, self._at.end
        step = Wave(index, visible, self.visited.rows, start, at.moved)
        while at.first < last:
            first = at.first
            self._before_rows()
            self._check(last - first)
            if self._checkpoint is not None and self._checkpoint.is_due():
                self._write_checkpoint()
            step.rows = self.visited.rows
            at.first = self._expand_some(step, first, last)

    def _before_rows(self) -> None:
        """Called before each run of rows is expanded."""

    def _expand_some(self, step: Wave, first: int, last: int) -> int:
        """Expand as many rows as is good at a time, in this thread or with all; the first row that was left."""
        shared = self._is_worth_sharing(last - first)
        if shared:
            self._gather_crew()
        before, begun = self._all_transitions(), self._pace.clock()
        if shared:
            reached = self._share(step, first, last)
        else:
            if self._crew is not None and not self._pace.is_for_all:
                self._crew.begin_again()
            most = CAPACITY if self._kernels.compiled else INTERPRETED_ROWS
            reached = self._expand_rows(step, first, min(last, first + most))
        if self._workers > 1:
            self._pace.note(self._all_transitions() - before, self._pace.clock() - begun, together=shared)
        return reached

    def _expand_rows(self, step: Wave, first: int, until: int) -> int:
        """Expand rows in this thread and add their successors; the first row that was left."""
        if self.pairs is not None:
            self.pairs.prepare(step.rows, first, until)
        reached = self._worker.produce(self._kernels, step, first, until)
        self._insert(self._worker.expander.targets, self._worker.expander.count)
        return reached

    def _is_worth_sharing(self, rows: int) -> bool:
        if self._workers < 2 or rows < PARALLEL_ROWS or self.known < PARALLEL_STATES:
            return False
        return (self._crew is None or self._crew.divided) and self._pace.is_for_all

    def _gather_crew(self) -> None:
        """Have the threads that share the work, and a table that they can share."""
        if self._crew is None:
            workers = [Worker(self.packed, self.pairs, capacity=SHARED_CAPACITY) for _ in range(self._workers)]
            self._crew = Crew(workers, self.visited)
            self._crew.divide(self._kernels)

    def _share(self, step: Wave, first: int, last: int) -> int:
        """Expand rows with all workers, who have been gathered; the first row that was left."""
        assert self._crew is not None
        until = min(last, first + self._crew.rows_per_run)
        if self.pairs is not None:
            self.pairs.prepare(step.rows, first, until)
        self._crew.run(self._kernels, step, first, until, self._make_room)
        return until

    def _insert(self, targets: Int64Array, count: int) -> None:
        position = 0
        while True:
            position = self.visited.insert(self._kernels, targets, position, count)
            if position == count:
                return
            if self._crew is not None and self.visited.known < self.visited.room:
                self._crew.relieve(self._kernels, self._make_room)
            else:
                self._make_room()

    def _make_room(self) -> None:
        """Grow the visited states, as far as the limits allow."""
        self._check_states()
        needed = self._other_bytes() + self.visited.bytes_after_growth()
        if self._limits.memory_bytes is not None and needed > self._limits.memory_bytes:
            self._memory_reached()
        self._note_peak()
        if self._crew is not None:
            self._crew.grow(self._kernels)
        else:
            self.visited.grow(self._kernels)
        self._note_peak()

    def _memory_reached(self) -> None:
        """Do what is to be done when there is no memory left: give up."""
        raise SearchStopped("memory")

    def _check_states(self) -> None:
        if self._limits.states is not None and self.known > self._limits.states:
            raise SearchStopped("states")

    def _write_last_checkpoint(self) -> None:
        if self._checkpoint is not None:
            self._write_checkpoint()

    def _other_bytes(self) -> int:
        """The memory of everything but the visited states."""
        crew = self._crew.nbytes if self._crew else 0
        return self._worker.expander.nbytes + crew + self._level_bytes

    def _note_peak(self) -> None:
        self.visited.note_peak()
        self.peak_memory_bytes = max(self.peak_memory_bytes, self.visited.peak_bytes + self._other_bytes())

    def _check(self, frontier: int) -> None:
        """Hold the search against its limits, tell of its progress, and change to compiled kernels when it is big."""
        limits, now = self._limits, working_time()
        self._check_states()
        if limits.seconds is not None and now - self._started > limits.seconds:
            self._write_last_checkpoint()
            raise SearchStopped("seconds")
        if limits.memory_bytes is not None and self._other_bytes() + self.visited.bytes > limits.memory_bytes:
            self._write_last_checkpoint()
            self._memory_reached()
        if self._progress is not None and now - self._told >= PROGRESS_SECONDS:
            self._told = now
            self._progress(
                Progress(
                    self.known,
                    self._all_transitions(),
                    len(self.levels) - 1,
                    frontier,
                    now - self._started,
                    self._other_bytes() + self.visited.bytes,
                )
            )
        # Where a state has thousands of rules to be looked at, a few of them are much work.
        took = self._may_compile and not self._kernels.compiled and now - self._started > INTERPRETED_SECONDS
        big = jit.is_loaded() or took or self._all_transitions() > INTERPRETED_TRANSITIONS
        if self._may_compile and big and not self._kernels.compiled:
            self._kernels = jit.kernels(True, self._notify)
        if self._kernels.compiled and self._worker.transitions > SMALL_CAPACITY:
            self._worker.expander.reserve(CAPACITY)

    def _has_tau_cycle(self, start: int) -> bool:
        """Whether taus go round among the rows of the level that starts at *start*."""
        return self._goes_round(self.visited, start)

    def _goes_round(self, visited: Visited, start: int) -> bool:
        """Whether taus go round among some rows from *start* on."""
        kernels = self._kernels
        size = visited.known - start
        made = Expander.for_rows(self.packed, visited.stride, size)
        arrivals = np.zeros(size, dtype=np.int32)
        numbers = np.zeros(made.capacity, dtype=np.int64)
        most = CAPACITY if kernels.compiled else INTERPRETED_ROWS
        taus = 0
        first = start
        while first < visited.known:
            self._check(visited.known - first)
            reached = made.run(kernels, self.packed.cycling, visited.rows, first, min(visited.known, first + most))
            if self.pairs is not None:
                drop_at_divergent_nodes(kernels, made, self._worker.guide, visited.rows, first)
            if made.capacity > len(numbers):
                numbers = np.zeros(made.capacity, dtype=np.int64)
            visited.find(kernels, made.targets, made.count, numbers)
            taus += kernels.count_arrivals(numbers, made.count, start, visited.known, arrivals)
            first = reached
        if not taus:
            return False
        queue = np.zeros(size, dtype=np.int32)
        ready = np.flatnonzero(arrivals == 0)
        queue[: len(ready)] = ready
        self._level_bytes += arrivals.nbytes + queue.nbytes
        self._note_peak()
        head, tail = 0, len(ready)
        while head < tail:
            self._check(size - head)
            before = head
            head, tail = kernels.peel(
                self.packed.rules,
                self.packed.cycling,
                self._worker.guide,
                self.packed.words,
                made.stride,
                visited.rows,
                start,
                visited.known,
                arrivals,
                queue,
                head,
                tail,
                most,
                made.capacity,
                made.offsets,
                made.targets,
                made.events,
                made.fired,
                made.scratch,
                visited.table,
                visited.bits,
                visited.entry_bits,
                visited.partition_bits,
                numbers,
            )
            if head == before:
                made.enlarge()
                numbers = np.zeros(made.capacity, dtype=np.int64)
        self._level_bytes -= arrivals.nbytes + queue.nbytes
        return tail < size
