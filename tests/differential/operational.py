"""Traces, stable failures and divergences read off a machine, in the most obvious way.

What a machine means (Roscoe 1997, 7.4.1): after a trace it is in one of a set of states, closed under tau. It can
refuse X after the trace if one of them is stable and offers nothing of X, or can tick and X is without tick. It can
diverge there if taus need never end.
"""

from __future__ import annotations

from collections import deque

from cspcheck.checker.lts import Lts
from cspcheck.cspm.process.events import TAU, TICK
from tests.reference.denotations import Denotation, Root, Semantics, maximal
from tests.reference.verdicts import Trace

States = frozenset[int]


class Machine:
    """A machine as rows of (label, target), one for each state."""

    def __init__(self, lts: Lts) -> None:
        self.rows = [list(lts.successors(state)) for state in range(lts.states)]
        self.start = self.closed({lts.root})

    def closed(self, states: set[int]) -> States:
        found = set(states)
        todo = list(states)
        while todo:
            for label, target in self.rows[todo.pop()]:
                if label == TAU and target not in found:
                    found.add(target)
                    todo.append(target)
        return frozenset(found)

    def after(self, states: States, event: int) -> States:
        return self.closed({target for s in states for label, target in self.rows[s] if label == event})

    def root(self, states: States, semantics: Semantics) -> Root:
        """What is possible at once in one of the states."""
        initials, ticks, refusals = 0, False, set()
        for state in states:
            offered = 0
            for label, _ in self.rows[state]:
                offered |= 1 << label
            if offered >> TICK & 1:
                ticks = True
                refusals.add(semantics.all_but_tick)
            elif not offered >> TAU & 1:
                refusals.add(semantics.everything & ~offered)
            initials |= offered & semantics.all_but_tick
        return Root(ticks, initials, maximal(refusals), self.tau_cycle(states))

    def tau_cycle(self, states: States) -> bool:
        """Whether taus from one of the states need never end."""
        lively = set(states)  # in the end: those from which a tau leads to another one of them
        while True:
            still = {s for s in lively if any(label == TAU and target in lively for label, target in self.rows[s])}
            if still == lively:
                return bool(lively)
            lively = still


def difference(lts: Lts, tree: Denotation, semantics: Semantics) -> tuple[Trace, Root, Root] | None:
    """The shortest trace after which machine and denotation say different things, and what they say; None if equal."""
    machine = Machine(lts)
    first = (machine.start, tree)
    seen = {first}
    queue: deque[tuple[Trace, States, Denotation]] = deque([((), *first)])
    while queue:
        trace, states, expected = queue.popleft()
        found = machine.root(states, semantics)
        if found != expected.root:
            return trace, found, expected.root
        for event, below in expected.branches():
            pair = (machine.after(states, event), below)
            if pair not in seen:
                seen.add(pair)
                queue.append(((*trace, event), *pair))
    return None
