"""Random process terms for property tests: every operator, finite state spaces, recursion by references.

A process is drawn as a tower of definitions. A body may refer to the definitions below it anywhere, and to itself
where the recursion is guarded and leaves nothing behind (after a prefix, to the right of ``;``, ...), never from
within a parallel, hiding, renaming or the left of ``;``. So every process has finitely many states, and none
recurses without a guard; both are what a generator must promise and no more than it needs to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields
from enum import IntEnum
from functools import cache
from itertools import combinations, count
from typing import Any

from hypothesis import strategies as st

from cspcheck.cspm.process.definitions import Definition
from cspcheck.cspm.process.events import FIRST_EVENT, EventSet, EventTable
from cspcheck.cspm.process.terms import (
    DIV,
    NO_EVENTS,
    SKIP,
    STOP,
    AlphabetisedParallel,
    Buffer,
    BufferKind,
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
    Prioritised,
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
from cspcheck.cspm.process.text import describe

Operators = frozenset[type[Process]]

BASIC: Operators = frozenset({Stop, Skip, Prefix})
"""Enough to build anything that the other operators combine; always allowed."""
CHOICE: Operators = frozenset({ExternalChoice, InternalChoice, SlidingChoice})
CONSTANTS: Operators = frozenset({Diverge, Run, Chaos, Buffer})
TERMINATING: Operators = frozenset({Sequential, Throw, Interrupt})
SYNCHRONISING: Operators = frozenset({SynchronisingChoice, SynchronisingInterrupt})
PARALLEL: Operators = frozenset({Parallel, AlphabetisedParallel, LinkedParallel})
STATIC: Operators = PARALLEL | {Hide, Project, Rename}
"""The operators that a network of one format is made of."""
SEQUENTIAL: Operators = BASIC | CHOICE | CONSTANTS | TERMINATING | SYNCHRONISING
CORE: Operators = BASIC | CHOICE | {Sequential, Parallel, AlphabetisedParallel, Hide, Rename}
"""The operators of the books' denotational models, without the derived ones."""
ALL: Operators = SEQUENTIAL | STATIC | {Compressed, Prioritised}

LETTERS = "abcdefgh"


def alphabet(events: int) -> EventTable:
    """An event table with the data-less channels a, b, c, ...: the identifiers that the strategies use."""
    table = EventTable()
    for letter in LETTERS[:events]:
        table.declare(letter)
    return table


def told(process: Process) -> str:
    """A process with all its definitions, for messages of failed tests."""
    table = alphabet(len(LETTERS))
    lines: list[str] = []
    pending, seen = [process], {process}
    for term in pending:
        body = term.body() if isinstance(term, Reference) else term
        name = term.text if isinstance(term, Reference) else "the process"
        lines.append(f"{name} = {describe(body, table, width=1_000)}")
        for call in _references(body):
            if call not in seen:
                seen.add(call)
                pending.append(call)
    return "\n".join(lines)


def _references(term: object) -> Iterator[Reference]:
    """The references in a term, wherever they are, but not what they stand for."""
    if isinstance(term, Reference):
        yield term
    elif isinstance(term, tuple):
        for part in term:
            yield from _references(part)
    elif isinstance(term, Process):
        for field in fields(term):
            yield from _references(getattr(term, field.name))


@cache
def event_sets(events: int, *, min_size: int = 0) -> st.SearchStrategy[EventSet]:
    """Sets of the first *events* identifiers."""
    return st.sampled_from([EventSet.of(subset) for subset in subsets(events) if len(subset) >= min_size])


def subsets(events: int) -> list[tuple[int, ...]]:
    """All sets of the first *events* identifiers, small ones first: drawn at one blow, not event by event."""
    identifiers = range(FIRST_EVENT, FIRST_EVENT + events)
    return [subset for size in range(events + 1) for subset in combinations(identifiers, size)]


@cache
def _one_or_two(events: int) -> st.SearchStrategy[tuple[int, ...]]:
    return st.sampled_from([subset for subset in subsets(events) if 1 <= len(subset) <= 2])


@cache
def _some_pairs(events: int) -> st.SearchStrategy[set[tuple[int, int]]]:
    return st.sets(st.tuples(_events(events), _events(events)), min_size=1, max_size=4)


@cache
def _events(events: int) -> st.SearchStrategy[int]:
    return st.integers(FIRST_EVENT, FIRST_EVENT + events - 1)


_serial = count()


def reference(text: str, body: Callable[[], Process]) -> Reference:
    """A new definition that is no other's, whatever its text."""
    return Reference((text, next(_serial)), Definition(text, None, body))


def timed_skip(tock: int) -> Process:
    """``TSKIP = tock -> TSKIP [] SKIP``."""
    skip: Process = Reference(
        ("TSKIP", tock), Definition("TSKIP", None, lambda: ExternalChoice((Prefix(((tock, skip),)), SKIP)))
    )
    return skip


class _Recursion(IntEnum):
    """Where the definition being drawn may refer to itself, seen from one position in its body."""

    NEVER = 0
    AFTER_A_VISIBLE_EVENT = 1
    AFTER_ANY_EVENT = 2
    HERE = 3

    def after_visible(self) -> _Recursion:
        return _Recursion.HERE if self else self

    def after_tau(self) -> _Recursion:
        return _Recursion.HERE if self >= _Recursion.AFTER_ANY_EVENT else self

    def unresolved(self) -> _Recursion:
        return min(self, _Recursion.AFTER_A_VISIBLE_EVENT)


NEVER = _Recursion.NEVER


class _Terms:
    """Draws the bodies of one tower of definitions."""

    def __init__(
        self,
        draw: Callable[[st.SearchStrategy[Any]], Any],
        operators: Operators,
        events: int,
        clocks: EventSet = NO_EVENTS,
    ) -> None:
        self.draw = draw
        self.events = events
        self.clocks = clocks
        leaves = [cls for cls in _LEAVES if cls in operators | BASIC]
        nodes = [cls for cls in _NODES if cls in operators | BASIC]
        self.leaf_kinds = st.sampled_from(leaves)
        # A prefix is half of what processes are made of, so it is drawn as often as the rest together.
        self.node_kinds = st.sampled_from(nodes + [Prefix] * max(1, len(nodes) // 2))
        self.below: list[Reference] = []
        self.itself: Reference | None = None

    def event(self) -> int:
        return int(self.draw(_events(self.events)))

    def event_set(self) -> EventSet:
        events: EventSet = self.draw(event_sets(self.events))
        return events

    def body(self, size: int, recursion: _Recursion) -> Process:
        if size <= 1:
            return self.leaf(recursion)
        return _NODES[self.draw(self.node_kinds)](self, size - 1, recursion)

    def leaf(self, recursion: _Recursion) -> Process:
        names = list(self.below)
        if recursion is _Recursion.HERE and self.itself is not None:
            names += [self.itself] * 3
        if names and self.draw(st.integers(0, 2)):
            chosen: Process = self.draw(st.sampled_from(names))
            return chosen
        if self.clocks and self.draw(st.booleans()):
            return timed_skip(min(self.clocks))
        return _LEAVES[self.draw(self.leaf_kinds)](self)

    def operands(self, size: int, number: int, *recursions: _Recursion) -> list[Process]:
        """*number* terms whose sizes add up to about *size*."""
        share = max(1, size // number)
        return [self.body(share, recursions[i] if i < len(recursions) else recursions[-1]) for i in range(number)]

    def some_operands(self, size: int, recursion: _Recursion) -> tuple[Process, ...]:
        return tuple(self.operands(size, self.draw(st.integers(2, 3)), recursion))

    def pairs(self) -> tuple[tuple[int, int], ...]:
        return tuple(sorted(self.draw(_some_pairs(self.events))))

    def links(self) -> tuple[tuple[int, int], ...]:
        """Pairs in which each event is at most once on either side, as the language demands."""
        by_left = dict(self.pairs())
        return tuple(sorted({b: (a, b) for a, b in by_left.items()}.values()))

    def prefix(self, size: int, recursion: _Recursion) -> Process:
        offered = self.draw(_one_or_two(self.events))
        return Prefix(tuple(zip(offered, self.operands(size, len(offered), recursion.after_visible()), strict=True)))

    def buffer(self) -> Process:
        kind: BufferKind = self.draw(st.sampled_from(("BUFFER", "WEAK_BUFFER", "SIGNAL_BUFFER")))
        capacity = self.draw(st.integers(1, 2))
        signals = tuple(self.event() for _ in range({"BUFFER": 0, "WEAK_BUFFER": 1, "SIGNAL_BUFFER": 2}[kind]))
        return Buffer(kind, capacity, signals, self.pairs()[:2], ())

    def sequential(self, size: int, recursion: _Recursion) -> Process:
        left, right = self.operands(size, 2, NEVER, recursion.after_tau())
        return Sequential(left, right)

    def sliding(self, size: int, recursion: _Recursion) -> Process:
        left, right = self.operands(size, 2, recursion.unresolved(), recursion.after_tau())
        return SlidingChoice(left, right)

    def interrupt(self, size: int, recursion: _Recursion) -> Process:
        left, right = self.operands(size, 2, NEVER, recursion.unresolved())
        return Interrupt(left, right)

    def synchronising_interrupt(self, size: int) -> Process:
        left, right = self.operands(size, 2, NEVER)
        return SynchronisingInterrupt(left, self.event_set(), right)

    def throw(self, size: int, recursion: _Recursion) -> Process:
        left, right = self.operands(size, 2, NEVER, recursion.after_visible())
        return Throw(left, self.event_set(), right)

    def alphabetised(self, size: int) -> Process:
        operands = self.some_operands(size, NEVER)
        return AlphabetisedParallel(tuple(self.event_set() for _ in operands), operands, self.clocks)

    def linked(self, size: int) -> Process:
        left, right = self.operands(size, 2, NEVER)
        return LinkedParallel(left, self.links(), right, self.clocks)

    def prioritised(self, size: int) -> Process:
        levels = tuple(self.event_set() for _ in range(self.draw(st.integers(1, 3))))
        return Prioritised(self.body(size, NEVER), levels)


_LEAVES: dict[type[Process], Callable[[_Terms], Process]] = {
    Skip: lambda _: SKIP,
    Stop: lambda _: STOP,
    Diverge: lambda _: DIV,
    Run: lambda t: Run(t.event_set()),
    Chaos: lambda t: Chaos(t.event_set()),
    Buffer: _Terms.buffer,
}

_NODES: dict[type[Process], Callable[[_Terms, int, _Recursion], Process]] = {
    Prefix: _Terms.prefix,
    ExternalChoice: lambda t, size, r: ExternalChoice(t.some_operands(size, r.unresolved())),
    InternalChoice: lambda t, size, r: InternalChoice(t.some_operands(size, r.after_tau())),
    SlidingChoice: _Terms.sliding,
    SynchronisingChoice: lambda t, size, _: SynchronisingChoice(t.event_set(), t.some_operands(size, NEVER)),
    Interrupt: _Terms.interrupt,
    SynchronisingInterrupt: lambda t, size, _: t.synchronising_interrupt(size),
    Throw: _Terms.throw,
    Sequential: _Terms.sequential,
    Parallel: lambda t, size, _: Parallel(t.event_set(), t.some_operands(size, NEVER), t.clocks),
    AlphabetisedParallel: lambda t, size, _: t.alphabetised(size),
    LinkedParallel: lambda t, size, _: t.linked(size),
    Hide: lambda t, size, _: Hide(t.body(size, NEVER), t.event_set()),
    Project: lambda t, size, _: Project(t.body(size, NEVER), t.event_set()),
    Rename: lambda t, size, _: Rename(t.body(size, NEVER), t.pairs()),
    Compressed: lambda t, size, r: Compressed("sbisim", t.body(size, r)),
    Prioritised: lambda t, size, _: t.prioritised(size),
}


@st.composite
def processes(
    draw: Callable[[st.SearchStrategy[Any]], Any],
    *,
    operators: Operators = ALL,
    events: int = 3,
    size: int = 8,
    definitions: int = 2,
    recursion: bool = True,
    clocks: EventSet = NO_EVENTS,
) -> Process:
    """A process over the identifiers of ``alphabet(events)``.

    Args:
        draw: given by Hypothesis.
        operators: the operators to use beside STOP, SKIP and prefix (see the sets above).
        events: how many events there are (at most 8).
        size: about how many operators each body has at most.
        definitions: how many named processes there are at most; the last one is what is drawn.
        recursion: whether bodies refer to themselves.
        clocks: those of the parallel operators.
    """
    terms = _Terms(draw, operators, events, clocks)
    bodies: dict[int, Process] = {}
    named: Reference | None = None
    # Left to itself Hypothesis prefers small numbers, and small processes are all alike.
    sizes = st.sampled_from([*range(1, size), *[size] * size])
    for level in range(draw(st.integers(1, max(1, definitions)))):
        named = reference(f"P{level}", lambda level=level: bodies[level])
        terms.itself = named if recursion else None
        bodies[level] = terms.body(draw(sizes), _Recursion.AFTER_ANY_EVENT)
        terms.below.append(named)
    assert named is not None
    return named


LAYERS: Sequence[Operators] = (BASIC | CHOICE, PARALLEL | {Hide}, TERMINATING | SYNCHRONISING | CHOICE)
"""Components, compositions of them, and what is done with compositions."""


@st.composite
def layered(
    draw: Callable[[st.SearchStrategy[Any]], Any],
    *,
    layers: Sequence[Operators] = LAYERS,
    definitions: int = 2,
    events: int = 3,
    size: int = 4,
    clocks: EventSet = NO_EVENTS,
) -> Process:
    """A process whose definitions stand in layers, each with its operators and made of the layer below.

    So operators meet in the order of the layers, which they seldom do by chance. A definition may refer to itself
    where ``processes`` lets it.
    """
    below: list[Reference] = []
    for level, operators in enumerate(layers):
        layer: list[Reference] = []
        for i in range(definitions):
            terms = _Terms(draw, operators, events, clocks)
            terms.below = below
            bodies: list[Process] = []
            named = reference(f"L{level}{LETTERS[i]}", lambda bodies=bodies: bodies[0])
            terms.itself = named
            bodies.append(terms.body(size, _Recursion.AFTER_ANY_EVENT))
            layer.append(named)
        below = layer
    return below[0]


@st.composite
def compositions(
    draw: Callable[[st.SearchStrategy[Any]], Any],
    *,
    operators: Operators = SEQUENTIAL,
    static: Operators = STATIC,
    events: int = 3,
    size: int = 5,
    components: int = 3,
    recursion: bool = True,
    compressions: Sequence[str] = (),
    clocks: EventSet = NO_EVENTS,
) -> Process:
    """Parallel, hiding and renaming over named components whose bodies use *operators* only.

    At most *components* components of about *size* operators each; the outermost operators are those of *static*.
    Some of the operands are compressed by functions among *compressions*.
    """
    number = draw(st.integers(1, components))
    named: list[Process] = [
        draw(
            processes(operators=operators, events=events, size=size, definitions=1, recursion=recursion, clocks=clocks)
        )
        for _ in range(number)
    ]
    terms = _Terms(draw, BASIC, events, clocks)
    kinds = sorted(static, key=lambda cls: cls.__name__)
    unary: Sequence[type[Process]] = [cls for cls in kinds if cls in {Hide, Project, Rename}]
    joining: Sequence[type[Process]] = [cls for cls in kinds if cls in PARALLEL]

    def wrap(process: Process) -> Process:
        process = wrapped(process)
        if not compressions or not draw(st.booleans()):
            return process
        return Compressed(draw(st.sampled_from(compressions)), process)

    def wrapped(process: Process) -> Process:
        if not unary or not draw(st.booleans()):
            return process
        cls = draw(st.sampled_from(unary))
        return Rename(process, terms.pairs()) if cls is Rename else cls(process, terms.event_set())  # type: ignore[call-arg]

    while len(named) > 1:
        cls = draw(st.sampled_from(joining))
        number = 2 if cls is LinkedParallel else draw(st.integers(2, len(named)))
        joined, named = [wrap(process) for process in named[:number]], named[number:]
        if cls is Parallel:
            whole: Process = Parallel(terms.event_set(), tuple(joined), clocks)
        elif cls is AlphabetisedParallel:
            whole = AlphabetisedParallel(tuple(terms.event_set() for _ in joined), tuple(joined), clocks)
        else:
            whole = LinkedParallel(joined[0], terms.links(), joined[1], clocks)
        named.insert(draw(st.integers(0, len(named))), whole)
    return wrap(named[0])
