r"""What a process can do, computed from the denotational definitions of CSP and never from transitions.

The traces, stable failures and divergences of a process (see :mod:`tests.reference.definitions`, where they
are spelt out as sets) form a tree: its root holds what is possible after the empty trace, and below each event a
that is possible at once hangs the tree of the process after a. The root is

* ``ticks``: whether tick is a trace;
* ``initials``: the events a such that <a> is a trace;
* ``refusals``: the maximal sets X such that (<>, X) is a stable failure. Refusals are closed under subsets, so the
  maximal ones say all. Tick is signalled: if tick is possible, everything but tick can be refused (F4).
* ``diverges``: whether <> is a divergence.

Each operator is defined twice here: the root of the result from the roots of the operands, and the result after a from
the operands after their events. The second follows from the trace definitions by taking <a>^s for s; for instance
``<a>^s in (P [|X|] Q)`` for a not in X says that s is a trace of (P after a) [|X|] Q or of P [|X|] (Q after a).
Nondeterminism is union everywhere: there are no internal steps.

Trees are infinite, so they are written as expressions and unrolled on demand. Equal expressions are one object, a
union is the set of its parts, and a process of finitely many states has finitely many expressions below it (as with
Brzozowski's derivatives). What is said of such a tree is therefore exact, with no bound on the length of traces:

* a difference between two trees shows within the finitely many pairs of expressions;
* ``P \ A`` diverges by chattering exactly if the expressions reached from P by events of A alone contain a cycle: the
  tree after each event exists exactly if the trace does, so a cycle is a trace that can be prolonged for ever, and
  without a cycle the finitely many expressions bound the number of successive hidden events. (By Koenig's lemma
  unboundedly many is infinitely many, because no process here has infinitely many choices in one step.)

Sets of events are bit masks: bit e for the event e, bit 1 for tick.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from typing import NamedTuple

from cspcheck.cspm.process.events import TICK
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
from tests.reference.behaviours import buffer_choice

TICK_BIT = 1 << TICK
SPARE_LINKS = 8
"""How many links one linked parallel may have."""


class Unguarded(Exception):
    """A recursion that does nothing before it comes back to itself, so that its equation does not define it."""


class TooLarge(Exception):
    """More expressions than the caller wants to wait for."""


class Root(NamedTuple):
    ticks: bool
    initials: int
    refusals: frozenset[int]
    diverges: bool


class Denotation:
    """An expression for a tree. ``key`` is the expression; equal keys are one object."""

    __slots__ = ("_after", "_compute_after", "_compute_root", "_root", "key", "parts")

    def __init__(
        self,
        key: Hashable,
        compute_root: Callable[[], Root],
        compute_after: Callable[[int], Denotation],
        parts: frozenset[Denotation] | None = None,
    ) -> None:
        self.key = key
        self.parts = parts or frozenset({self})
        self._compute_root = compute_root
        self._compute_after = compute_after
        self._root: Root | None = None
        self._after: dict[int, Denotation] = {}

    @property
    def root(self) -> Root:
        if self._root is None:
            try:
                self._root = self._compute_root()
            except RecursionError:
                raise Unguarded(self.key) from None
        return self._root

    def after(self, event: int) -> Denotation:
        """The tree below an event, which must be initial."""
        tree = self._after.get(event)
        if tree is None:
            tree = self._after[event] = self._compute_after(event)
        return tree

    def branches(self) -> Iterable[tuple[int, Denotation]]:
        return ((event, self.after(event)) for event in events_of(self.root.initials))


def mask(events: Iterable[int]) -> int:
    result = 0
    for event in events:
        result |= 1 << event
    return result


def events_of(bits: int) -> list[int]:
    result = []
    while bits:
        low = bits & -bits
        result.append(low.bit_length() - 1)
        bits ^= low
    return result


def maximal(refusals: Iterable[int]) -> frozenset[int]:
    """The refusals that are not part of another one."""
    distinct = set(refusals)
    if len(distinct) < 2:
        return frozenset(distinct)
    return frozenset(x for x in distinct if not any(x != y and x & y == x for y in distinct))


class Semantics:
    """The denotations of process terms over an alphabet.

    ``limit``: how many expressions there may be; where more are needed, :class:`TooLarge` is raised, also when trees
    are unrolled later.
    """

    def __init__(self, alphabet: Iterable[int], limit: int = 1_000_000) -> None:
        self.limit = limit
        events = sorted(alphabet)
        self.visible = mask(events)
        first_spare = events[-1] + 1
        self.spare = tuple(range(first_spare, first_spare + SPARE_LINKS))
        self.all_but_tick = self.visible | mask(self.spare)
        self.everything = self.all_but_tick | TICK_BIT
        self._expressions: dict[Hashable, Denotation] = {}
        self._terms: dict[Process, Denotation] = {}
        self.stop = self._constant("STOP", Root(False, 0, frozenset({self.everything}), False))
        self.skip = self._constant("SKIP", Root(True, 0, frozenset({self.all_but_tick}), False))
        self.div = self._constant("DIV", Root(False, 0, frozenset(), True))

    def of(self, process: Process) -> Denotation:
        """The denotation of a term."""
        known = self._terms.get(process)
        if known is None:
            known = self._terms[process] = self._of(process)
        return known

    def hidden(self) -> list[Denotation]:
        """The trees within which events have been hidden so far."""
        return [key[1] for key in self._expressions if isinstance(key, tuple) and key[0] == "\\"]

    def _of(self, process: Process) -> Denotation:
        match process:
            case Stop():
                return self.stop
            case Skip():
                return self.skip
            case Diverge():
                return self.div
            case Run(events):
                return self._always("RUN", mask(events), self.everything & ~mask(events))
            case Chaos(events):
                return self._always("CHAOS", mask(events), self.everything)
            case Prefix(branches):
                return self._prefix(branches)
            case ExternalChoice(operands):
                return self.synchronising_choice(0, [self.of(p) for p in operands])
            case InternalChoice(operands):
                return self.union(self.of(p) for p in operands)
            case SlidingChoice(left, right):  # Roscoe 1997, p. 80: P [> Q = (P |~| STOP) [] Q
                return self.synchronising_choice(0, [self.union([self.of(left), self.stop]), self.of(right)])
            case SynchronisingChoice(events, operands):
                return self.synchronising_choice(mask(events), [self.of(p) for p in operands])
            case Interrupt(left, right):
                return self.synchronising_interrupt(self.of(left), 0, self.of(right))
            case SynchronisingInterrupt(left, events, right):
                return self.synchronising_interrupt(self.of(left), mask(events), self.of(right))
            case Throw(left, events, right):
                return self.throw(self.of(left), mask(events), self.of(right))
            case Sequential(left, right):
                return self.sequential(self.of(left), self.of(right))
            case Parallel(events, operands):
                first, *others = [self.of(p) for p in operands]
                for other in others:
                    first = self.parallel(first, mask(events), other)
                return first
            case AlphabetisedParallel(alphabets, operands):
                return self.alphabetised([mask(a) for a in alphabets], [self.of(p) for p in operands])
            case LinkedParallel(left, links, right):
                return self.linked(self.of(left), links, self.of(right))
            case Hide(hidden, events):
                return self.hide(self.of(hidden), mask(events))
            case Project(hidden, events):
                return self.hide(self.of(hidden), self.visible & ~mask(events))
            case Rename(renamed, pairs):
                return self.rename(self.of(renamed), pairs)
            case Reference():
                return self._reference(process)
            case Compressed(_, compressed):
                return self.of(compressed)
            case Buffer():
                return self.of(buffer_choice(process))
            case _:
                raise NotImplementedError(type(process).__name__)

    # -- basic processes

    def _expression(
        self, key: tuple[Hashable, ...], root: Callable[[], Root], after: Callable[[int], Denotation]
    ) -> Denotation:
        known = self._expressions.get(key)
        return known if known is not None else self._new(Denotation(key, root, after))

    def _new(self, denotation: Denotation) -> Denotation:
        if len(self._expressions) >= self.limit:
            raise TooLarge(self.limit)
        self._expressions[denotation.key] = denotation
        return denotation

    def _constant(self, name: str, root: Root) -> Denotation:
        def after(event: int) -> Denotation:
            raise AssertionError(f"{name} does not perform {event}")

        return self._expression((name,), lambda: root, after)

    def _always(self, name: str, events: int, refusal: int) -> Denotation:
        root = Root(False, events, frozenset({refusal}), False)
        return self._expression((name, events), lambda: root, lambda _: self._always(name, events, refusal))

    def _prefix(self, branches: tuple[tuple[int, Process], ...]) -> Denotation:
        offered = mask(event for event, _ in branches)
        root = Root(False, offered, frozenset({self.everything & ~offered}), False)
        following = dict(branches)
        return self._expression(("prefix", branches), lambda: root, lambda event: self.of(following[event]))

    def _reference(self, reference: Reference) -> Denotation:
        def unfolded() -> Denotation:
            return self.of(reference.body())

        return self._expression(("name", reference), lambda: unfolded().root, lambda event: unfolded().after(event))

    # -- nondeterminism

    def union(self, alternatives: Iterable[Denotation]) -> Denotation:
        """``P |~| Q |~| ...``: whatever one of them can do or refuse."""
        parts = frozenset(part for alternative in alternatives for part in alternative.parts)
        if len(parts) == 1:
            return next(iter(parts))
        known = self._expressions.get(parts)
        if known is not None:
            return known

        def root() -> Root:
            roots = [part.root for part in parts]
            return Root(
                any(r.ticks for r in roots),
                _any(r.initials for r in roots),
                maximal(x for r in roots for x in r.refusals),
                any(r.diverges for r in roots),
            )

        def after(event: int) -> Denotation:
            return self.union(part.after(event) for part in parts if part.root.initials >> event & 1)

        return self._new(Denotation(parts, root, after, parts))

    # -- choices

    def synchronising_choice(self, shared: int, operands: list[Denotation]) -> Denotation:
        """``P [+ shared +] Q``; with nothing shared it is ``P [] Q``.

        All take part in a shared event and the choice stays open; any other event, and tick, resolves it. A shared
        event is refused if some operand refuses it, another one if all do.
        """

        def root() -> Root:
            roots = [operand.root for operand in operands]
            initials = _any(r.initials for r in roots) & ~shared | _all(r.initials for r in roots) & shared
            refusals = roots[0].refusals
            for r in roots[1:]:
                refusals = frozenset((x | y) & shared | x & y & ~shared for x in refusals for y in r.refusals)
            return self._signalled(any(r.ticks for r in roots), initials, refusals, any(r.diverges for r in roots))

        def after(event: int) -> Denotation:
            if shared >> event & 1:
                return self.synchronising_choice(shared, [operand.after(event) for operand in operands])
            return self.union(operand.after(event) for operand in operands if operand.root.initials >> event & 1)

        return self._expression(("[]", shared, *operands), root, after)

    def synchronising_interrupt(self, left: Denotation, shared: int, right: Denotation) -> Denotation:
        r"""``P /+ shared +\ Q``; with nothing shared it is ``P /\ Q``.

        Both take part in a shared event; another event of Q, and its tick, ends P for good.
        """

        def root() -> Root:
            p, q = left.root, right.root
            initials = (p.initials | q.initials) & ~shared | p.initials & q.initials & shared
            refusals = ((x | y) & shared | x & y & ~shared for x in p.refusals for y in q.refusals)
            return self._signalled(p.ticks or q.ticks, initials, refusals, p.diverges or q.diverges)

        def after(event: int) -> Denotation:
            if shared >> event & 1:
                return self.synchronising_interrupt(left.after(event), shared, right.after(event))
            results = []
            if left.root.initials >> event & 1:
                results.append(self.synchronising_interrupt(left.after(event), shared, right))
            if right.root.initials >> event & 1:
                results.append(right.after(event))
            return self.union(results)

        return self._expression(("/\\", left, shared, right), root, after)

    def _signalled(self, ticks: bool, initials: int, refusals: Iterable[int], diverges: bool) -> Root:
        """The root, with F4: where tick is possible, all but tick can be refused."""
        signalled = [self.all_but_tick] if ticks else []
        return Root(ticks, initials, maximal([*refusals, *signalled]), diverges)

    # -- one after the other

    def throw(self, left: Denotation, events: int, right: Denotation) -> Denotation:
        """``P [| events |> Q``."""

        def after(event: int) -> Denotation:
            return right if events >> event & 1 else self.throw(left.after(event), events, right)

        return self._expression(("throw", left, events, right), lambda: left.root, after)

    def sequential(self, left: Denotation, right: Denotation) -> Denotation:
        """``P ; Q``: P's tick is not seen, so P can be left waiting only where it refuses tick too."""

        def root() -> Root:
            p = left.root
            waiting = [x for x in p.refusals if x & TICK_BIT]
            if not p.ticks:
                return Root(False, p.initials, frozenset(waiting), p.diverges)
            q = right.root
            return Root(q.ticks, p.initials | q.initials, maximal([*waiting, *q.refusals]), p.diverges or q.diverges)

        def after(event: int) -> Denotation:
            results = []
            if left.root.initials >> event & 1:
                results.append(self.sequential(left.after(event), right))
            if left.root.ticks and right.root.initials >> event & 1:
                results.append(right.after(event))
            return self.union(results)

        return self._expression((";", left, right), root, after)

    # -- side by side

    def parallel(self, left: Denotation, shared: int, right: Denotation) -> Denotation:
        """``P [| shared |] Q``: shared events and tick need both, and one that refuses them is enough."""
        common = shared | TICK_BIT

        def root() -> Root:
            p, q = left.root, right.root
            return Root(
                p.ticks and q.ticks,
                (p.initials | q.initials) & ~shared | p.initials & q.initials,
                maximal((x | y) & common | x & y for x in p.refusals for y in q.refusals),
                p.diverges or q.diverges,
            )

        def after(event: int) -> Denotation:
            if shared >> event & 1:
                return self.parallel(left.after(event), shared, right.after(event))
            results = []
            if left.root.initials >> event & 1:
                results.append(self.parallel(left.after(event), shared, right))
            if right.root.initials >> event & 1:
                results.append(self.parallel(left, shared, right.after(event)))
            return self.union(results)

        return self._expression(("[||]", left, shared, right), root, after)

    def alphabetised(self, alphabets: list[int], operands: list[Denotation]) -> Denotation:
        """``|| i @ [A(i)] P(i)``: an event needs every operand whose alphabet has it, and at least one."""
        known = _any(alphabets)
        foreign = self.all_but_tick & ~known

        def root() -> Root:
            roots = [operand.root for operand in operands]
            initials = known
            refusals = {foreign}
            for alphabet, r in zip(alphabets, roots, strict=True):
                initials &= r.initials | ~alphabet
                refusals = {x | y & (alphabet | TICK_BIT) for x in refusals for y in r.refusals}
            return Root(all(r.ticks for r in roots), initials, maximal(refusals), any(r.diverges for r in roots))

        def after(event: int) -> Denotation:
            moved = [
                operand.after(event) if alphabet >> event & 1 else operand
                for alphabet, operand in zip(alphabets, operands, strict=True)
            ]
            return self.alphabetised(alphabets, moved)

        return self._expression(("||", *alphabets, *operands), root, after)

    def linked(self, left: Denotation, links: tuple[tuple[int, int], ...], right: Denotation) -> Denotation:
        """``P [a <-> b, ...] Q``: rename each pair to an event of its own, synchronise on those, hide them."""
        spare = self.spare[: len(links)]
        assert len(spare) == len(links)
        p = self.rename(left, tuple((a, m) for (a, _), m in zip(links, spare, strict=True)))
        q = self.rename(right, tuple((b, m) for (_, b), m in zip(links, spare, strict=True)))
        return self.hide(self.parallel(p, mask(spare), q), mask(spare))

    # -- hiding and renaming

    def hide(self, process: Denotation, hidden: int) -> Denotation:
        r"""``P \ hidden``: what P can do and refuse after any hidden events, hidden ones being refused too."""
        if not hidden:
            return process

        def root() -> Root:
            reached, chatter = _within(process, hidden)
            roots = [tree.root for tree in reached]
            return Root(
                any(r.ticks for r in roots),
                _any(r.initials for r in roots) & ~hidden,
                maximal(x for r in roots for x in r.refusals if x & hidden == hidden),
                chatter or any(r.diverges for r in roots),
            )

        def after(event: int) -> Denotation:
            reached, _ = _within(process, hidden)
            return self.hide(
                self.union(tree.after(event) for tree in reached if tree.root.initials >> event & 1), hidden
            )

        return self._expression(("\\", process, hidden), root, after)

    def rename(self, process: Denotation, pairs: tuple[tuple[int, int], ...]) -> Denotation:
        """``P [[a <- b, ...]]``: b is refused if P refuses every event that becomes b."""
        sources: dict[int, int] = {event: 1 << event for event in (TICK, *events_of(self.all_but_tick))}
        for old, _ in pairs:
            sources[old] = 0
        for old, new in pairs:
            sources[new] |= 1 << old

        def image(refusal: int) -> int:
            return mask(new for new, olds in sources.items() if refusal & olds == olds)

        def root() -> Root:
            p = process.root
            initials = mask(new for new, olds in sources.items() if p.initials & olds)
            return Root(p.ticks, initials, maximal(image(x) for x in p.refusals), p.diverges)

        def after(event: int) -> Denotation:
            olds = events_of(sources[event] & process.root.initials)
            return self.rename(self.union(process.after(old) for old in olds), pairs)

        return self._expression(("[[]]", process, pairs), root, after)


def _any(masks: Iterable[int]) -> int:
    result = 0
    for bits in masks:
        result |= bits
    return result


def _all(masks: Iterable[int]) -> int:
    result = -1
    for bits in masks:
        result &= bits
    return result


def _within(process: Denotation, hidden: int) -> tuple[list[Denotation], bool]:
    """The trees reached by hidden events alone, and whether such events can go on for ever."""
    reached: dict[Denotation, bool] = {}  # whether all below it has been seen
    chatter = False
    path: list[tuple[Denotation, list[int]]] = [(process, events_of(process.root.initials & hidden))]
    reached[process] = False
    while path:
        tree, todo = path[-1]
        if not todo:
            reached[tree] = True
            path.pop()
            continue
        below = tree.after(todo.pop())
        if below not in reached:
            reached[below] = False
            path.append((below, events_of(below.root.initials & hidden)))
        elif not reached[below]:
            chatter = True
    return list(reached), chatter
