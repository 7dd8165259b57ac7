"""Refinement and the properties by their definitions, on the trees of :mod:`tests.reference.denotations`.

Every answer is exact: the trees of finite-state processes have finitely many different expressions, and all of them
(for refinement: all pairs reached by the same trace) are looked at, breadth first and in the order of the events. So
what is found first is found after the shortest trace, and of several shortest ones after the first in that order.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from cspcheck.cspm.process.events import TICK
from tests.reference.denotations import TICK_BIT, Denotation, Root, events_of

Model = Literal["T", "F", "FD"]
MODELS: tuple[Model, ...] = ("T", "F", "FD")
Trace = tuple[int, ...]


@dataclass(frozen=True)
class Difference:
    """A behaviour that refutes: after ``trace``, an ``event`` not allowed, a ``refusal`` not allowed, or divergence."""

    trace: Trace
    event: int | None = None
    refusal: int | None = None
    diverges: bool = False


def refinement(spec: Denotation, impl: Denotation, model: Model) -> Difference | None:
    """A behaviour of ``impl`` that ``spec`` does not have, after a shortest trace; None if ``spec [model= impl``.

    T: traces. F: traces and stable failures. FD: failures and divergences, where after a divergence
    everything counts as possible: a specification that may diverge allows everything from there on.

    Of the shortest traces it is the first in the order of the events, and of several things that are wrong after
    it the first event that is not allowed (tick before the others), else a refusal, else the divergence.
    """
    seen = {(spec, impl)}
    queue: deque[tuple[Trace, Denotation, Denotation]] = deque([((), spec, impl)])
    while queue:
        trace, allowed, done = queue.popleft()
        if model == "FD" and allowed.root.diverges:
            continue
        difference = _difference(trace, allowed.root, done.root, model)
        if difference is not None:
            return difference
        for event, after in done.branches():
            pair = (allowed.after(event), after)
            if pair not in seen:
                seen.add(pair)
                queue.append(((*trace, event), *pair))
    return None


def _difference(trace: Trace, spec: Root, impl: Root, model: Model) -> Difference | None:
    if impl.ticks and not spec.ticks:
        return Difference(trace, event=TICK)
    for event in events_of(impl.initials & ~spec.initials):
        return Difference(trace, event=event)
    if model != "T":
        for refused in impl.refusals:
            if not any(refused & ~allowed == 0 for allowed in spec.refusals):
                return Difference(trace, refusal=refused)
    if model == "FD" and impl.diverges:
        return Difference(trace, diverges=True)
    return None


def reachable(process: Denotation) -> Iterator[tuple[Trace, Denotation]]:
    """All different trees below a process, each with a shortest trace to it, shortest first."""
    seen = {process}
    queue: deque[tuple[Trace, Denotation]] = deque([((), process)])
    while queue:
        trace, tree = queue.popleft()
        yield trace, tree
        for event, after in tree.branches():
            if after not in seen:
                seen.add(after)
                queue.append(((*trace, event), after))


def deadlock(process: Denotation, model: Model) -> Difference | None:
    """A trace after which everything, tick included, can be refused; in FD a divergence counts as well.

    A trace that ends in tick is none of those: termination is no deadlock. In T nothing is known of refusals, so
    there is no such check.
    """
    assert model != "T"
    for trace, tree in reachable(process):
        if model == "FD" and tree.root.diverges:
            return Difference(trace, diverges=True)
        everything = tree.root.initials | TICK_BIT  # what cannot be done is refused anyway
        for refused in tree.root.refusals:
            if refused & everything == everything:
                return Difference(trace, refusal=refused)
    return None


def divergence(process: Denotation) -> Difference | None:
    """A trace after which the process can diverge."""
    for trace, tree in reachable(process):
        if tree.root.diverges:
            return Difference(trace, diverges=True)
    return None


def nondeterminism(process: Denotation, model: Model) -> Difference | None:
    """A trace after which an event (or tick) is both possible and refusable; in FD a divergence counts as well."""
    assert model != "T"
    for trace, tree in reachable(process):
        root = tree.root
        if model == "FD" and root.diverges:
            return Difference(trace, diverges=True)
        possible = root.initials | (TICK_BIT if root.ticks else 0)
        for refused in root.refusals:
            for event in events_of(refused & possible):
                return Difference(trace, event=event)
    return None


def has_trace(process: Denotation, trace: Sequence[int], model: Model) -> bool:
    """Whether the trace is possible and, but in T, cannot be refused at any step (in FD: nor diverge before any)."""
    tree = process
    for event in trace:
        if model == "FD" and tree.root.diverges:
            return False
        if model != "T" and any(refused >> event & 1 for refused in tree.root.refusals):
            return False
        if not tree.root.initials >> event & 1:
            return False
        tree = tree.after(event)
    return True
