r"""The denotational definitions of CSP, letter by letter: sets of traces, of failures and of divergences.

Slow and obvious; for processes of a few events and behaviours of a few steps. The faster trees of
:mod:`tests.reference.denotations`, against which the engine is held in bulk, are themselves held against this file.

Source: Roscoe, *The Theory and Practice of Concurrency* (1997): traces in chapters 1 to 6, divergences in 8.3, stable
failures in 8.4; operators that the book lacks (exception, the general interrupt, linked parallel) as in *Understanding
Concurrent Systems* (2010), and the synchronising choice and interrupt thought out in the same style.

What the three functions mean, for a process P and a depth n:

* ``traces(P, n)``: all s such that P can do s; tick occurs at the end of s or nowhere; at most n other events.
* ``failures(P, n)``: all (s, X) such that P can do s and then refuse X in a stable state. X ranges over *all* sets of
  visible events and tick. Tick is signalled and needs no stable state: if P can do s and then tick, it can refuse
  everything but tick after s (axiom F4); and after tick it refuses everything.
* ``divergences(P, n)``: all s that P can do and then perform internal actions for ever. These are the divergences that
  really happen; the model FD adds all their extensions, with every failure, when processes are compared
  (1997, 8.4: the failures of FD are the stable ones and all (s, X) such that s extends a divergence).

All three are exact for behaviours of at most n visible events. Recursion is unfolded until the depth is used up, which
ends for guarded recursion: up to depth n that is the unique fixed point.

Hiding needs behaviours of the hidden process that are longer than n. A process without recursion has a longest
trace, and that is long enough. For the others ``patience`` must be at least the number of states of a deterministic
automaton of the hidden process's traces. Then ``patience`` hidden events in succession visit one state twice, so
they can go on for ever; and whatever can be reached at all can be reached with fewer of them in any one place (the
pumping lemma), so that n + (n + 1) * patience events of the hidden process show everything up to depth n.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import product
from math import inf
from typing import TypeVar

from cspcheck.cspm.process.events import TICK, EventSet
from cspcheck.cspm.process.terms import (
    AlphabetisedParallel,
    Buffer,
    Chaos,
    Compressed,
    Diverge,
    ExternalChoice,
    Hide,
    InternalChoice,
    Interrupt,
    LinkedParallel,
    Parallel,
    Prefix,
    Process,
    Project,
    Reference,
    Rename,
    Run,
    Sequential,
    Skip,
    SlidingChoice,
    Stop,
    SynchronisingChoice,
    SynchronisingInterrupt,
    Throw,
)
from tests.reference.behaviours import (
    EMPTY,
    Failure,
    Pairs,
    Refusal,
    Trace,
    buffer_choice,
    disjoint,
    images,
    merges,
    renamed,
    subsets,
    ticked,
    union,
    visible,
    within,
    without,
)

Behaviour = TypeVar("Behaviour", Trace, Failure)


class TooMany(Exception):
    """More traces or failures than the caller wants to wait for."""


class Definitions:
    """The semantic functions over an alphabet.

    ``patience``: see the head of the file. ``limit``: a larger set of behaviours raises :class:`TooMany`.
    """

    depth_limit = 40  # Python recurses about ten calls a step

    def __init__(self, alphabet: Iterable[int], patience: int | None = None, limit: int = 1_000_000) -> None:
        self.alphabet = frozenset(alphabet)
        self.patience = patience
        self.limit = limit
        self.all_but_tick = subsets(self.alphabet)
        self.all_refusals = subsets(self.alphabet | {TICK})
        self._traces: dict[tuple[Process, int], frozenset[Trace]] = {}
        self._failures: dict[tuple[Process, int], frozenset[Failure]] = {}
        self._divergences: dict[tuple[Process, int], frozenset[Trace]] = {}

    def traces(self, process: Process, n: int) -> frozenset[Trace]:
        key = (process, n)
        if key not in self._traces:
            self._traces[key] = self._collected(s for s in self._each_trace(process, n) if visible(s) <= n)
        return self._traces[key]

    def failures(self, process: Process, n: int) -> frozenset[Failure]:
        key = (process, n)
        if key not in self._failures:
            self._failures[key] = self._collected((s, x) for s, x in self._each_failure(process, n) if visible(s) <= n)
        return self._failures[key]

    def divergences(self, process: Process, n: int) -> frozenset[Trace]:
        key = (process, n)
        if key not in self._divergences:
            self._divergences[key] = self._collected(s for s in self._each_divergence(process, n) if visible(s) <= n)
        return self._divergences[key]

    def _collected(self, behaviours: Iterator[Behaviour]) -> frozenset[Behaviour]:
        found: set[Behaviour] = set()
        for behaviour in behaviours:
            found.add(behaviour)
            if len(found) > self.limit:
                raise TooMany(self.limit)
        return frozenset(found)

    def running(self, process: Process, n: int) -> list[Trace]:
        """The traces without tick."""
        return [s for s in self.traces(process, n) if not ticked(s)]

    def terminating(self, process: Process, n: int) -> list[Trace]:
        """The s such that s and then tick is a trace."""
        return [s[:-1] for s in self.traces(process, n) if ticked(s)]

    def refusals(self, process: Process, n: int) -> dict[Trace, set[Refusal]]:
        """The failures, by trace."""
        found: dict[Trace, set[Refusal]] = {}
        for s, x in self.failures(process, n):
            found.setdefault(s, set()).add(x)
        return found

    # -- traces

    def _each_trace(self, process: Process, n: int) -> Iterator[Trace]:
        match process:
            case Stop() | Diverge():
                yield EMPTY
            case Skip():
                yield from (EMPTY, (TICK,))
            case Run(events) | Chaos(events):
                yield from (s for length in range(n + 1) for s in product(events, repeat=length))
            case Prefix(branches):
                yield EMPTY
                if n:
                    yield from ((a, *s) for a, then in branches for s in self.traces(then, n - 1))
            case ExternalChoice(operands) | InternalChoice(operands):
                for p in operands:
                    yield from self.traces(p, n)
            case SlidingChoice(p, q):
                yield from self.traces(p, n)
                yield from self.traces(q, n)
            case Interrupt(p, q):
                yield from self.traces(p, n)
                yield from (s + t for s in self.running(p, n) for t in self.traces(q, n - len(s)))
            case Throw(p, events, q):
                yield from (s for s in self.traces(p, n) if disjoint(s, events))
                yield from (s + t for s in self._throwing(p, events, n) for t in self.traces(q, n - len(s)))
            case Sequential(p, q):
                yield from self.running(p, n)
                yield from (s + t for s in self.terminating(p, n) for t in self.traces(q, n - len(s)))
            case Parallel(_, (p,)):
                yield from self.traces(p, n)
            case Parallel(events, (p, *others)):
                q = Parallel(events, tuple(others))
                yield from (u for s in self.traces(p, n) for t in self.traces(q, n) for u in merges(s, t, events))
            case AlphabetisedParallel(alphabets, operands):
                yield from self._alphabetised_traces(alphabets, operands, n)
            case LinkedParallel():
                inner, p = self._linked(process)
                yield from inner.traces(p, n)
            case Hide(p, events):
                yield from (without(s, events) for s in self.traces(p, self._depth_below(p, n)))
            case Project(p, events):
                yield from self.traces(Hide(p, self._outside(events)), n)
            case Rename(p, pairs):
                yield from (t for s in self.traces(p, n) for t in images(s, pairs))
            case SynchronisingChoice(_, operands):
                yield from self._unresolved(process, n)
                yield from (s for p in operands for s in self.traces(p, n) if self._resolves(s, process, n))
            case SynchronisingInterrupt(p, _, q):
                yield from self._uninterrupted(process, n)
                for s in self._uninterrupted(process, n):
                    yield from (s + t for t in self._interruptions(s, self.traces(q, n), process))
                yield from (s for s in self.traces(p, n) if ticked(s) and s[:-1] in self._uninterrupted(process, n))
            case Reference():
                yield from self.traces(process.body(), n)
            case Compressed(_, p):
                yield from self.traces(p, n)
            case Buffer():
                yield from self.traces(buffer_choice(process), n)
            case _:
                raise NotImplementedError(type(process).__name__)

    def _alphabetised_traces(
        self, alphabets: tuple[EventSet, ...], operands: tuple[Process, ...], n: int
    ) -> Iterator[Trace]:
        """All s of which every operand performs the part in its alphabet (found by prolonging shorter ones)."""
        events = sorted({e for alphabet in alphabets for e in alphabet})
        possible = [(alphabet, self.traces(p, n)) for alphabet, p in zip(alphabets, operands, strict=True)]

        def agreed(s: Trace) -> bool:
            return all(within(s, alphabet) in traces for alphabet, traces in possible)

        level = [EMPTY]
        while level:
            yield from level
            yield from ((*s, TICK) for s in level if agreed((*s, TICK)))
            level = [(*s, e) for s in level if len(s) < n for e in events if agreed((*s, e))]

    # -- stable failures

    def _each_failure(self, process: Process, n: int) -> Iterator[Failure]:
        match process:
            case Stop():
                yield from ((EMPTY, x) for x in self.all_refusals)
            case Diverge():
                return
            case Skip():
                yield from ((EMPTY, x) for x in self.all_but_tick)
                yield from (((TICK,), x) for x in self.all_refusals)
            case Run(events):
                yield from ((s, x) for s in self.traces(process, n) for x in self.all_refusals if disjoint(x, events))
            case Chaos():
                yield from ((s, x) for s in self.traces(process, n) for x in self.all_refusals)
            case Prefix(branches):
                offered = {a for a, _ in branches}
                yield from ((EMPTY, x) for x in self.all_refusals if disjoint(x, offered))
                if n:
                    yield from (((a, *s), x) for a, then in branches for s, x in self.failures(then, n - 1))
            case ExternalChoice(operands):
                at_once = [self.refusals(p, n).get(EMPTY, set()) for p in operands]
                yield from ((EMPTY, x) for x in set.intersection(*at_once))
                yield from ((s, x) for p in operands for s, x in self.failures(p, n) if s)
                yield from self._signalled([EMPTY], process, n)
            case InternalChoice(operands):
                for p in operands:
                    yield from self.failures(p, n)
            case SlidingChoice(p, q):  # (P |~| STOP) [] Q
                yield from ((s, x) for s, x in self.failures(p, n) if s)
                yield from self.failures(q, n)
                yield from self._signalled([EMPTY], process, n)
            case Interrupt(p, q):
                uninterrupted = self.refusals(q, n).get(EMPTY, set())
                yield from ((s, x) for s, x in self.failures(p, n) if ticked(s) or x in uninterrupted)
                yield from ((s + t, x) for s in self.running(p, n) for t, x in self.failures(q, n - len(s)) if t)
                yield from self._signalled(self.running(p, n), process, n)
            case Throw(p, events, q):
                yield from ((s, x) for s, x in self.failures(p, n) if disjoint(s, events))
                yield from ((s + t, x) for s in self._throwing(p, events, n) for t, x in self.failures(q, n - len(s)))
            case Sequential(p, q):
                waiting = self.failures(p, n)
                yield from ((s, x) for s, x in waiting if not ticked(s) and (s, x | {TICK}) in waiting)
                yield from ((s + t, x) for s in self.terminating(p, n) for t, x in self.failures(q, n - len(s)))
            case Parallel(_, (p,)):
                yield from self.failures(p, n)
            case Parallel(events, (p, *others)):
                yield from self._parallel_failures(p, events, Parallel(events, tuple(others)), n)
            case AlphabetisedParallel():
                yield from self._alphabetised_failures(process, n)
            case LinkedParallel():
                inner, p = self._linked(process)
                yield from ((s, x) for s, x in inner.failures(p, n) if x <= self.alphabet | {TICK})
            case Hide(p, events):
                below = self.failures(p, self._depth_below(p, n))
                yield from ((without(s, events), x) for s, x in below if (s, x | {*events}) in below)
            case Project(p, events):
                yield from self.failures(Hide(p, self._outside(events)), n)
            case Rename(p, pairs):
                below = self.failures(p, n)
                before = {x: self._preimage(x, pairs) for x in self.all_refusals}
                for s in self.traces(p, n):
                    yield from ((t, x) for x in before if (s, before[x]) in below for t in images(s, pairs))
            case SynchronisingChoice():
                yield from self._synchronising_choice_failures(process, n)
            case SynchronisingInterrupt():
                yield from self._synchronising_interrupt_failures(process, n)
            case Reference():
                yield from self.failures(process.body(), n)
            case Compressed(_, p):
                yield from self.failures(p, n)
            case Buffer():
                yield from self.failures(buffer_choice(process), n)
            case _:
                raise NotImplementedError(type(process).__name__)

    def _signalled(self, after: Iterable[Trace], process: Process, n: int) -> Iterator[Failure]:
        """F4 for these traces: where tick is possible, all but tick can be refused."""
        possible = self.traces(process, n)
        return ((s, x) for s in after if (*s, TICK) in possible for x in self.all_but_tick)

    def _parallel_failures(self, p: Process, events: EventSet, q: Process, n: int) -> Iterator[Failure]:
        """Either can refuse a shared event or tick; both must refuse another one."""
        shared = {*events, TICK}
        right = self.refusals(q, n)
        for s, ys in self.refusals(p, n).items():
            for t, zs in right.items():
                both = {y | z for y in ys for z in zs if y - shared == z - shared}
                yield from ((u, x) for u in merges(s, t, events) for x in both)

    def _alphabetised_failures(self, process: AlphabetisedParallel, n: int) -> Iterator[Failure]:
        """Each can refuse what is in its own alphabet; what is in none is refused."""
        parts = [(a, self.refusals(p, n)) for a, p in zip(process.alphabets, process.operands, strict=True)]
        foreign = subsets(self.alphabet - {e for alphabet in process.alphabets for e in alphabet})
        for s in self.traces(process, n):
            local = [{x & {*a, TICK} for x in refusals.get(within(s, a), ())} for a, refusals in parts]
            yield from ((s, union(xs) | w) for xs in product(*local) for w in foreign)
            if ticked(s):
                yield from ((s, x) for x in self.all_refusals)

    def _synchronising_choice_failures(self, process: SynchronisingChoice, n: int) -> Iterator[Failure]:
        """While it is open, one operand can refuse a shared event, and all together another one."""
        shared = frozenset(process.events)
        parts = [self.refusals(p, n) for p in process.operands]
        open_still = self._unresolved(process, n)
        for s in open_still:
            for xs in product(*(refusals.get(s, ()) for refusals in parts)):
                yield s, (union(xs) & shared) | (frozenset.intersection(*xs) - shared)
        for refusals in parts:
            yield from ((s, x) for s in refusals if self._resolves(s, process, n) for x in refusals[s])
        yield from self._signalled(open_still, process, n)

    def _synchronising_interrupt_failures(self, process: SynchronisingInterrupt, n: int) -> Iterator[Failure]:
        """Before the interrupt, one of the two can refuse a shared event, and both together another one."""
        shared = frozenset(process.events)
        left, right = self.refusals(process.left, n), self.refusals(process.right, n)
        alone = self._uninterrupted(process, n)
        for s in alone:
            seen = within(s, process.events)
            both = product(left.get(s, ()), right.get(seen, ()))
            yield from ((s, ((y | z) & shared) | ((y & z) - shared)) for y, z in both)
            for t in right:
                yield from ((s + u, x) for u in self._interruptions(s, [t], process) for x in right[t])
        yield from ((s, x) for s in left if ticked(s) and s[:-1] in alone for x in left[s])
        yield from self._signalled(alone, process, n)

    # -- divergences

    def _each_divergence(self, process: Process, n: int) -> Iterator[Trace]:
        match process:
            case Stop() | Skip() | Run() | Chaos() | Buffer():
                return
            case Diverge():
                yield EMPTY
            case Prefix(branches):
                if n:
                    yield from ((a, *s) for a, then in branches for s in self.divergences(then, n - 1))
            case ExternalChoice(operands) | InternalChoice(operands):
                for p in operands:
                    yield from self.divergences(p, n)
            case SlidingChoice(p, q):
                yield from self.divergences(p, n)
                yield from self.divergences(q, n)
            case Interrupt(p, q):
                yield from self.divergences(p, n)
                yield from (s + t for s in self.running(p, n) for t in self.divergences(q, n - len(s)))
            case Throw(p, events, q):
                yield from (s for s in self.divergences(p, n) if disjoint(s, events))
                yield from (s + t for s in self._throwing(p, events, n) for t in self.divergences(q, n - len(s)))
            case Sequential(p, q):
                yield from self.divergences(p, n)
                yield from (s + t for s in self.terminating(p, n) for t in self.divergences(q, n - len(s)))
            case Parallel(_, (p,)):
                yield from self.divergences(p, n)
            case Parallel(events, (p, *others)):
                q = Parallel(events, tuple(others))
                for s, t in product(self.divergences(p, n), self.running(q, n)):
                    yield from merges(s, t, events)
                for s, t in product(self.running(p, n), self.divergences(q, n)):
                    yield from merges(s, t, events)
            case AlphabetisedParallel(alphabets, operands):
                for alphabet, p in zip(alphabets, operands, strict=True):
                    yield from (s for s in self.running(process, n) if within(s, alphabet) in self.divergences(p, n))
            case LinkedParallel():
                inner, p = self._linked(process)
                yield from inner.divergences(p, n)
            case Hide(p, events):
                yield from (without(s, events) for s in self.divergences(p, self._depth_below(p, n)))
                yield from self._chatter(p, events, n)
            case Project(p, events):
                yield from self.divergences(Hide(p, self._outside(events)), n)
            case Rename(p, pairs):
                yield from (t for s in self.divergences(p, n) for t in images(s, pairs))
            case SynchronisingChoice(_, operands):
                for p in operands:
                    possible = [s for s in self.traces(process, n) if s in self.divergences(p, n)]
                    open_still = self._unresolved(process, n)
                    yield from (s for s in possible if s in open_still or self._resolves(s, process, n))
            case SynchronisingInterrupt(p, events, q):
                for s in self._uninterrupted(process, n):
                    if s in self.divergences(p, n) or within(s, events) in self.divergences(q, n):
                        yield s
                    yield from (s + t for t in self._interruptions(s, self.divergences(q, n), process))
            case Reference():
                yield from self.divergences(process.body(), n)
            case Compressed(_, p):
                yield from self.divergences(p, n)
            case _:
                raise NotImplementedError(type(process).__name__)

    def _chatter(self, process: Process, events: EventSet, n: int) -> Iterator[Trace]:
        """What is left of a trace that ends in so many hidden events that they can go on for ever."""
        if self.longest(process) == inf:
            assert self.patience is not None
            for s in self.running(process, self._depth_below(process, n)):
                if len(s) >= self.patience and all(e in events for e in s[len(s) - self.patience :]):
                    yield without(s, events)

    # -- what the clauses share

    def _throwing(self, process: Process, events: EventSet, n: int) -> list[Trace]:
        """The traces of which the last event, and no other, is one of *events*."""
        return [s for s in self.running(process, n) if s and s[-1] in events and disjoint(s[:-1], events)]

    def _unresolved(self, choice: SynchronisingChoice, n: int) -> set[Trace]:
        """The traces after which a synchronising choice is still open: synchronised events of all operands."""
        together = set.intersection(*(set(self.running(p, n)) for p in choice.operands))
        return {s for s in together if all(e in choice.events for e in s)}

    def _resolves(self, s: Trace, choice: SynchronisingChoice, n: int) -> bool:
        """Whether s has an event that is not synchronised, and the first such one was reached by all together."""
        first = next((i for i, e in enumerate(s) if e not in choice.events), None)
        return first is not None and s[:first] in self._unresolved(choice, n)

    def _uninterrupted(self, process: SynchronisingInterrupt, n: int) -> set[Trace]:
        """The traces without tick of the left operand whose synchronised events the right one performs as well."""
        followed = self.traces(process.right, n)
        return {s for s in self.running(process.left, n) if within(s, process.events) in followed}

    def _interruptions(self, s: Trace, behaviours: Iterable[Trace], process: SynchronisingInterrupt) -> Iterator[Trace]:
        """What follows s when the right operand, having seen s, goes on with an event that is not synchronised."""
        seen = within(s, process.events)
        for t in behaviours:
            rest = t[len(seen) :]
            if t[: len(seen)] == seen and rest and rest[0] not in process.events:
                yield rest

    def _preimage(self, refusal: Refusal, pairs: Pairs) -> Refusal:
        return frozenset(e for e in self.alphabet | {TICK} if not disjoint(renamed(e, pairs), refusal))

    def _outside(self, events: EventSet) -> EventSet:
        return EventSet.of(self.alphabet) - events

    def _linked(self, process: LinkedParallel) -> tuple[Definitions, Process]:
        """Linking renames each pair to an event of its own, synchronises on those, and hides them (2010, 5.5)."""
        new = range(max(self.alphabet) + 1, max(self.alphabet) + 1 + len(process.links))
        left = Rename(process.left, tuple((a, m) for (a, _), m in zip(process.links, new, strict=True)))
        right = Rename(process.right, tuple((b, m) for (_, b), m in zip(process.links, new, strict=True)))
        links = EventSet.of(new)
        return Definitions({*self.alphabet, *new}, self.patience, self.limit), Hide(
            Parallel(links, (left, right)), links
        )

    def _depth_below(self, process: Process, n: int) -> int:
        """To which depth a process must be known for its hiding to be known to depth n."""
        longest = self.longest(process)
        if longest < inf:
            return int(longest)
        if self.patience is None:
            raise ValueError("hiding over recursion needs a bound on the states")
        depth = n + (n + 1) * self.patience
        if depth > self.depth_limit:
            raise TooMany(depth)
        return depth

    def longest(self, process: Process) -> float:
        """An upper bound on the length of the traces, tick not counted; infinite for every kind of recursion."""
        match process:
            case Stop() | Skip() | Diverge():
                return 0
            case Run(events) | Chaos(events):
                return inf if events else 0
            case Prefix(branches):
                return max((1 + self.longest(p) for _, p in branches), default=0)
            case ExternalChoice(operands) | InternalChoice(operands):
                return max(self.longest(p) for p in operands)
            case SlidingChoice(p, q):
                return max(self.longest(p), self.longest(q))
            case Parallel(_, operands) | AlphabetisedParallel(_, operands) | SynchronisingChoice(_, operands):
                return sum(self.longest(p) for p in operands)
            case Interrupt(p, q) | Sequential(p, q):
                return self.longest(p) + self.longest(q)
            case Throw(p, _, q) | LinkedParallel(p, _, q) | SynchronisingInterrupt(p, _, q):
                return self.longest(p) + self.longest(q)
            case Hide(p, _) | Project(p, _) | Rename(p, _) | Compressed(_, p):
                return self.longest(p)
            case _:
                return inf
