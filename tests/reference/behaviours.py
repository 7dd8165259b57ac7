"""Traces, refusals and failures as plain values, and the functions on them that the definitions of CSP use."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import product

from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.events import TICK, EventSet
from cspcheck.cspm.process.terms import STOP, Buffer, ExternalChoice, Process

Trace = tuple[int, ...]
"""Events; tick at the end or nowhere."""
Refusal = frozenset[int]
Failure = tuple[Trace, Refusal]
Pairs = tuple[tuple[int, int], ...]

EMPTY: Trace = ()


def subsets(events: Iterable[int]) -> list[Refusal]:
    result: list[Refusal] = [frozenset()]
    for event in sorted(events):
        result += [subset | {event} for subset in result]
    return result


def union(sets: Iterable[Refusal]) -> Refusal:
    return frozenset().union(*sets)


def disjoint(first: Iterable[int], second: Iterable[int]) -> bool:
    return set(first).isdisjoint(second)


def ticked(trace: Trace) -> bool:
    return bool(trace) and trace[-1] == TICK


def visible(trace: Trace) -> int:
    """How many events a trace has, tick not counted."""
    return len(trace) - ticked(trace)


def within(trace: Trace, events: EventSet) -> Trace:
    """The events of a trace that are in the set; tick stays."""
    return tuple(e for e in trace if e in events or e == TICK)


def without(trace: Trace, events: EventSet) -> Trace:
    r"""``s \\ X``: the events of a trace that are not in the set."""
    return tuple(e for e in trace if e not in events)


@lru_cache(maxsize=50_000)
def merges(s: Trace, t: Trace, events: EventSet) -> frozenset[Trace]:
    """``s [|X|] t`` (1997, 2.4 and 6.2): shared events and tick in step, all others interleaved."""
    if not s and not t:
        return frozenset({EMPTY})
    shared = {*events, TICK}
    result: set[Trace] = set()
    if s and s[0] not in shared:
        result |= {(s[0], *u) for u in merges(s[1:], t, events)}
    if t and t[0] not in shared:
        result |= {(t[0], *u) for u in merges(s, t[1:], events)}
    if s and t and s[0] == t[0] and s[0] in shared:
        result |= {(s[0], *u) for u in merges(s[1:], t[1:], events)}
    return frozenset(result)


def renamed(event: int, pairs: Pairs) -> list[int]:
    """What an event becomes; one that is not mentioned stays."""
    return [new for old, new in pairs if old == event] or [event]


def images(trace: Trace, pairs: Pairs) -> Iterator[Trace]:
    """All that a trace becomes by a renaming."""
    return product(*(renamed(e, pairs) for e in trace))


def buffer_choice(buffer: Buffer) -> Process:
    """A buffer as the choice between what it can do next; see :class:`cspcheck.cspm.process.terms.Buffer` for the
    three kinds.

    A full BUFFER takes no input; a full WEAK_BUFFER does, and can then only explode; a SIGNAL_BUFFER also says, as
    often as it is asked, that it is full or that it is empty.
    """
    kind, capacity, pairs, contents = buffer.kind, buffer.capacity, buffer.pairs, buffer.contents
    full, empty = len(contents) == capacity, not contents

    def holding(new: tuple[int, ...]) -> Process:
        return Buffer(kind, capacity, buffer.signals, pairs, new)

    choices = []
    for i, (entering, _) in enumerate(pairs):
        if not full:
            choices.append(prefix(entering, holding((*contents, i))))
        elif kind == "WEAK_BUFFER":
            choices.append(prefix(entering, prefix(buffer.signals[0], STOP)))
    if not empty:
        choices.append(prefix(pairs[contents[0]][1], holding(contents[1:])))
    if kind == "SIGNAL_BUFFER":
        choices += [prefix(buffer.signals[0], buffer)] * full + [prefix(buffer.signals[1], buffer)] * empty
    return ExternalChoice((STOP, *choices))
