"""Random processes for tests against the reference: small, finite-state, and likely to be interesting.

One generator, two drivers: it asks a *chooser* for numbers below n. :func:`processes` drives it from Hypothesis
(number 0 is the simplest choice, so that failures shrink), :func:`random_process` from ``random.Random``, for bulk.

What is promised: every process has finitely many states, and every recursion is guarded by a visible event. So
definitions are made in two floors. A body may refer to its own floor only behind an event and where nothing of the
body is left by then (not within parallel, hiding or renaming, nor to the left of ``;``, interrupt or exception),
and to the floor below anywhere.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from itertools import count

from hypothesis import strategies as st

from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.definitions import Definition
from cspcheck.cspm.process.events import EventSet, EventTable
from cspcheck.cspm.process.terms import (
    DIV,
    SKIP,
    STOP,
    AlphabetisedParallel,
    Buffer,
    Chaos,
    Compressed,
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
    SlidingChoice,
    SynchronisingChoice,
    SynchronisingInterrupt,
    Throw,
)

TABLE = EventTable()
EVENTS: tuple[int, ...] = tuple(TABLE.event(TABLE.declare(name)) for name in ("a", "b", "c"))
A, B, C = EVENTS
SIGMA = EventSet.of(EVENTS)

Chooser = Callable[[int], int]
"""``choose(n)`` is a number from 0 to n - 1."""

_serial = count()


def define(
    bodies: Callable[[tuple[Reference, ...]], Sequence[Process]], number: int, name: str = "X"
) -> list[Reference]:
    """Mutually recursive definitions: ``bodies`` gets the references and gives what each stands for."""
    serial = next(_serial)
    made: list[Process] = []

    def definition(i: int) -> Definition:
        return Definition(f"{name}{serial}_{i}", None, lambda: made[i])

    references = tuple(Reference((name, serial, i), definition(i)) for i in range(number))
    made.extend(bodies(references))
    return list(references)


def recursive(body: Callable[[Process], Process], name: str = "X") -> Reference:
    """``X = body(X)``."""
    return define(lambda xs: [body(xs[0])], 1, name)[0]


class Scope:
    """What a position in a term may refer to: ``anywhere`` closed names, ``here`` and, behind an event, ``later``."""

    __slots__ = ("anywhere", "here", "later")

    def __init__(
        self, anywhere: Sequence[Reference] = (), later: Sequence[Reference] = (), here: Sequence[Reference] = ()
    ) -> None:
        self.anywhere = tuple(anywhere)
        self.later = tuple(later)
        self.here = tuple(here)

    def guarded(self) -> Scope:
        return Scope(self.anywhere, self.later, self.later)

    def closed(self) -> Scope:
        return Scope(self.anywhere)


# How often each operator is chosen. The first is what a failing example shrinks to.
_OPERATORS = (
    ["prefix"] * 10
    + ["external"] * 5
    + ["internal"] * 5
    + ["parallel"] * 5
    + ["hide"] * 6
    + ["sequential"] * 4
    + ["rename"] * 3
    + ["sliding"] * 2
    + ["interleave"] * 2
    + ["alphabetised"] * 4
    + ["interrupt"] * 2
    + ["throw"] * 2
    + ["input"] * 2
    + ["linked", "project", "synchronising_choice", "synchronising_interrupt", "compressed"]
)
COMPRESSIONS = ("normal", "sbisim", "wbisim", "dbisim", "diamond", "tau_loop_factor", "model_compress")


class Generator:
    """Builds terms over the first ``letters`` events, choosing by ``choose``."""

    def __init__(self, choose: Chooser, letters: int = 3) -> None:
        self.choose = choose
        self.letters = letters

    def process(self, size: int) -> Process:
        """A process of about ``size`` operators, often recursive."""
        definitions: list[Reference] = []
        for _ in range(self.choose(3) if size > 2 else 0):
            definitions = definitions[-1:] + self.definitions(size, definitions)
        return self.term(size, Scope(definitions))

    def definitions(self, size: int, below: Sequence[Reference]) -> list[Reference]:
        if self.choose(2):
            return self.machine()
        number = 1 + self.choose(2)

        def bodies(itself: tuple[Reference, ...]) -> list[Process]:
            return [self.term(2 + self.choose(max(1, size)), Scope(below, itself)) for _ in itself]

        return define(bodies, number)

    def machine(self) -> list[Reference]:
        """Definitions that are the states of a small automaton: cycles, branching and silent steps in plenty."""
        number = 2 + self.choose(3)

        def bodies(states: tuple[Reference, ...]) -> list[Process]:
            return [self.state(states) for _ in states]

        return define(bodies, number)

    def state(self, states: Sequence[Reference]) -> Process:
        branches: list[Process] = [
            prefix(self.event(), states[self.choose(len(states))]) for _ in range(1 + self.choose(3))
        ]
        match self.choose(8):
            case 5:
                branches.append(SKIP)
            case 6:
                branches.append(STOP)
            case 7:
                branches.append(DIV)
        if len(branches) == 1:
            return branches[0]
        match self.choose(5):
            case 0 | 1:
                return ExternalChoice(tuple(branches))
            case 2 | 3:
                return InternalChoice(tuple(branches))
            case _:
                last = branches[-1]
                return SlidingChoice(ExternalChoice(tuple(branches[:-1])) if len(branches) > 2 else branches[0], last)

    def term(self, size: int, scope: Scope) -> Process:
        if size <= 1:
            return self.leaf(scope)
        operator = _OPERATORS[self.choose(len(_OPERATORS))]
        term: Process = getattr(self, operator)(size - 1, scope)
        return term

    def leaf(self, scope: Scope) -> Process:
        names = scope.here + scope.anywhere
        if names and self.choose(6):
            return names[self.choose(len(names))]
        match self.choose(17):
            case 0 | 1 | 2 | 3:
                return STOP
            case 4 | 5 | 6 | 7:
                return SKIP
            case 8 | 9 | 10:
                return prefix(self.event(), SKIP)
            case 11 | 12:
                return prefix(self.event(), STOP)
            case 13:
                return Run(self.events())
            case 14:
                return Chaos(self.events())
            case 15:
                return self.buffer()
            case _:
                return DIV

    def buffer(self) -> Process:
        """A buffer for one kind of value; a weak one needs a third event to explode."""
        if self.letters > 2 and self.choose(3) == 2:
            return Buffer("WEAK_BUFFER", 1 + self.choose(2), (C,), ((A, B),), ())
        entering, leaving = ((A, B), (B, A))[self.choose(2)]
        return Buffer("BUFFER", 1 + self.choose(2), (), ((entering, leaving),), ())

    def event(self) -> int:
        return EVENTS[self.choose(self.letters)]

    def events(self) -> EventSet:
        bits = self.choose(1 << self.letters)
        return EventSet.of(e for i, e in enumerate(EVENTS) if bits >> i & 1)

    def two(self, size: int, left: Scope, right: Scope) -> tuple[Process, Process]:
        share = 1 + self.choose(max(1, size - 1))
        return self.term(share, left), self.term(max(1, size - share), right)

    def operands(self, size: int, scope: Scope) -> tuple[Process, ...]:
        if size > 2 and self.choose(6) == 5:
            return tuple(self.term(max(1, size // 3), scope) for _ in range(3))
        return self.two(size, scope, scope)

    def prefix(self, size: int, scope: Scope) -> Process:
        return prefix(self.event(), self.term(size, scope.guarded()))

    def input(self, size: int, scope: Scope) -> Process:
        offered = list(self.events()) or [self.event()]
        following = [self.term(max(1, size // len(offered)), scope.guarded()) for _ in offered]
        return Prefix(tuple(zip(offered, following, strict=True)))

    def external(self, size: int, scope: Scope) -> Process:
        return ExternalChoice(self.operands(size, scope))

    def internal(self, size: int, scope: Scope) -> Process:
        return InternalChoice(self.operands(size, scope))

    def sliding(self, size: int, scope: Scope) -> Process:
        return SlidingChoice(*self.two(size, scope, scope))

    def interrupt(self, size: int, scope: Scope) -> Process:
        return Interrupt(*self.two(size, scope.closed(), scope))

    def throw(self, size: int, scope: Scope) -> Process:
        left, right = self.two(size, scope.closed(), scope.guarded())
        return Throw(left, self.events(), right)

    def sequential(self, size: int, scope: Scope) -> Process:
        if self.choose(3) == 2:
            first = prefix(self.event(), SKIP)
            return Sequential(first, self.term(size, scope.guarded()))
        return Sequential(*self.two(size, scope.closed(), scope))

    def parallel(self, size: int, scope: Scope) -> Process:
        return Parallel(self.events(), self.operands(size, scope.closed()))

    def interleave(self, size: int, scope: Scope) -> Process:
        return Parallel(EventSet(), self.operands(size, scope.closed()))

    def alphabetised(self, size: int, scope: Scope) -> Process:
        operands = self.operands(size, scope.closed())
        # Most events should be in an alphabet: those outside all are merely blocked.
        return AlphabetisedParallel(tuple(self.events() | self.events() for _ in operands), operands)

    def linked(self, size: int, scope: Scope) -> Process:
        left, right = self.two(size, scope.closed(), scope.closed())
        first, second = self.choose(self.letters), self.choose(self.letters)
        number = 1 + self.choose(self.letters)
        links = [(EVENTS[(first + i) % self.letters], EVENTS[(second + i) % self.letters]) for i in range(number)]
        return LinkedParallel(left, tuple(sorted(links)), right)

    def hide(self, size: int, scope: Scope) -> Process:
        return Hide(self.term(size, scope.closed()), self.events())

    def project(self, size: int, scope: Scope) -> Process:
        return Project(self.term(size, scope.closed()), self.events())

    def compressed(self, size: int, scope: Scope) -> Process:
        return Compressed(COMPRESSIONS[self.choose(len(COMPRESSIONS))], self.term(size, scope.closed()))

    def rename(self, size: int, scope: Scope) -> Process:
        pairs = {(self.event(), self.event()) for _ in range(1 + self.choose(3))}
        return Rename(self.term(size, scope.closed()), tuple(sorted(pairs)))

    def synchronising_choice(self, size: int, scope: Scope) -> Process:
        return SynchronisingChoice(self.events(), self.operands(size, scope.closed()))

    def synchronising_interrupt(self, size: int, scope: Scope) -> Process:
        left, right = self.two(size, scope.closed(), scope.closed())
        return SynchronisingInterrupt(left, self.events(), right)


def random_process(rng: random.Random, size: int = 6, letters: int = 3) -> Process:
    """A random process; the same for the same state of ``rng``."""
    return Generator(rng.randrange, letters).process(size)


def processes(max_size: int = 6, letters: int = 3) -> st.SearchStrategy[Process]:
    """Random processes with recursion."""
    return _chosen(lambda choose: Generator(choose, letters).process(1 + choose(max_size)))


def finite_processes(max_size: int = 6, letters: int = 3) -> st.SearchStrategy[Process]:
    """Random processes without names (RUN and CHAOS may occur)."""
    return _chosen(lambda choose: Generator(choose, letters).term(1 + choose(max_size), Scope()))


def event_sets(letters: int = 3) -> st.SearchStrategy[EventSet]:
    return st.sets(st.sampled_from(EVENTS[:letters])).map(EventSet.of)


def renamings(letters: int = 3) -> st.SearchStrategy[tuple[tuple[int, int], ...]]:
    """Non-empty relations on events, collisions and splits included."""
    events = st.sampled_from(EVENTS[:letters])
    return st.sets(st.tuples(events, events), min_size=1, max_size=4).map(lambda pairs: tuple(sorted(pairs)))


def _chosen(make: Callable[[Chooser], Process]) -> st.SearchStrategy[Process]:
    """What *make* builds by choices that Hypothesis controls.

    One draw of many bytes, each a choice, is many times faster than as many draws. When they are used up, every choice
    is the simplest.
    """

    def made(choices: bytes) -> Process:
        left = iter(choices)
        return make(lambda n: next(left, 0) % n)

    return st.binary(min_size=80, max_size=80).map(made)
