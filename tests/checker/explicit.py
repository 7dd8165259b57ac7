"""Small explicit machines and what they mean, computed by plain sets straight from the definitions.

Shares no code with the checker. A machine is a list of rows; row ``s`` is the set of (label, target) pairs of state
``s``; state 0 is the root.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

from hypothesis import strategies as st

from cspcheck.checker.lts import Lts
from cspcheck.cspm.process.events import TAU, TICK

A, B, C = 2, 3, 4
Rows = list[set[tuple[int, int]]]
States = frozenset[int]
Acceptance = frozenset[int]


def reachable(rows: Rows) -> Rows:
    """The states that the root reaches, renumbered."""
    order = [0]
    for state in order:
        order += [t for t in dict.fromkeys(t for _, t in sorted(rows[state])) if t not in order]
    number = {state: i for i, state in enumerate(order)}
    return [{(label, number[t]) for label, t in rows[state]} for state in order]


@st.composite
def machines(draw: st.DrawFn, *, states: int = 6, events: int = 3, taus: bool = True, ticks: bool = True) -> Rows:
    """A machine of at most ``states`` states (and one after termination), all of them reachable."""
    size = draw(st.integers(1, states))
    labels = [TAU] * taus + [TICK] * ticks + list(range(A, A + events))
    moves = draw(
        st.lists(
            st.tuples(st.integers(0, size - 1), st.sampled_from(labels), st.integers(0, size - 1)), max_size=3 * size
        )
    )
    rows: Rows = [set() for _ in range(size + 1)]
    for source, label, target in moves:
        rows[source].add((label, size if label == TICK else target))
    return reachable(rows)


def lts(rows: Rows) -> Lts:
    return Lts.from_successors(rows)


def closure(rows: Rows, states: set[int]) -> States:
    """All states that taus lead to from *states*."""
    found = set(states)
    while True:
        more = {t for s in found for label, t in rows[s] if label == TAU} - found
        if not more:
            return frozenset(found)
        found |= more


def start(rows: Rows) -> States:
    return closure(rows, {0})


def step(rows: Rows, states: States, event: int) -> States:
    """Where *event* and taus lead from a closed set."""
    return closure(rows, {t for s in states for label, t in rows[s] if label == event})


def after(rows: Rows, trace: tuple[int, ...]) -> States:
    """All states that the machine can be in after a trace; empty if it cannot perform it."""
    states = start(rows)
    for event in trace:
        states = step(rows, states, event)
    return states


def events(rows: Rows, states: States) -> set[int]:
    """What the machine can perform next."""
    return {label for s in states for label, _ in rows[s] if label != TAU}


def acceptances(rows: Rows, states: States) -> set[Acceptance]:
    """What the machine can settle for: the offers of stable states; {tick} of any state that can tick."""
    found: set[Acceptance] = set()
    for s in states:
        offers = frozenset(label for label, _ in rows[s])
        if TICK in offers:
            found.add(frozenset({TICK}))
        elif TAU not in offers:
            found.add(offers)
    return found


def minimal(family: set[Acceptance]) -> set[Acceptance]:
    return {x for x in family if not any(y < x for y in family)}


def diverges(rows: Rows, states: States) -> bool:
    """Whether as many taus as there are states, and so infinitely many, are possible in a row."""
    current = set(states)
    for _ in rows:
        current = {t for s in current for label, t in rows[s] if label == TAU}
    return bool(current)


def traces(rows: Rows, length: int) -> Iterator[tuple[int, ...]]:
    """The traces of at most *length* events, shorter first, then in the order of events."""
    level: list[tuple[tuple[int, ...], States]] = [((), start(rows))]
    for _ in range(length + 1):
        yield from (trace for trace, _ in level)
        level = [
            ((*trace, event), step(rows, states, event))
            for trace, states in level
            for event in sorted(events(rows, states))
        ]


def refinement_violation(spec: Rows, impl: Rows, model: str) -> tuple[tuple[int, ...], set[str]] | None:
    """The first trace, shorter first and then in the order of events, after which *impl* does what *spec* may not.

    With the kinds of violation there. Sets of states on both sides; a divergent specification allows everything (FD).
    """
    first = (start(spec), start(impl))
    queue: deque[tuple[tuple[int, ...], States, States]] = deque([((), *first)])
    seen = {first}
    while queue:
        trace, allowed, actual = queue.popleft()
        if model == "FD" and diverges(spec, allowed):
            continue
        kinds = set()
        if events(impl, actual) - events(spec, allowed):
            kinds.add("trace")
        if model != "T":
            may = acceptances(spec, allowed)
            if any(not any(x <= offer for x in may) for offer in acceptances(impl, actual)):
                kinds.add("refusal")
        if model == "FD" and diverges(impl, actual):
            kinds.add("divergence")
        if kinds:
            return trace, kinds
        for event in sorted(events(impl, actual)):
            pair = (step(spec, allowed, event), step(impl, actual, event))
            if pair not in seen:
                seen.add(pair)
                queue.append(((*trace, event), *pair))
    return None


def sets_by_trace(rows: Rows) -> Iterator[tuple[tuple[int, ...], States]]:
    """Each set of states that some trace leads to, once, with the first such trace in the canonical order."""
    queue = deque([((), start(rows))])
    seen = {start(rows)}
    while queue:
        trace, states = queue.popleft()
        yield trace, states
        for event in sorted(events(rows, states)):
            target = step(rows, states, event)
            if target not in seen:
                seen.add(target)
                queue.append(((*trace, event), target))


def terminated(rows: Rows) -> set[int]:
    return {t for row in rows for label, t in row if label == TICK}


def first_deadlock(rows: Rows) -> tuple[int, ...] | None:
    """The first trace after which the machine can be in a state without any transition, termination apart."""
    dead = {s for s, row in enumerate(rows) if not row} - terminated(rows)
    return next((trace for trace, states in sets_by_trace(rows) if states & dead), None)


def first_divergence(rows: Rows) -> tuple[int, ...] | None:
    return next((trace for trace, states in sets_by_trace(rows) if diverges(rows, states)), None)


def first_nondeterminism(rows: Rows) -> tuple[tuple[int, ...], int] | None:
    """The first trace after which an event is both possible and refusable, and the first such event."""
    for trace, states in sets_by_trace(rows):
        refusable = {
            event
            for event in events(rows, states)
            if any(event not in acceptance for acceptance in acceptances(rows, states))
        }
        if refusable:
            return trace, min(refusable)
    return None


def has_trace(rows: Rows, trace: tuple[int, ...], model: str) -> bool:
    """Whether a trace is possible and, except in T, cannot be refused at any step; in FD not by divergence either."""
    for i, event in enumerate(trace):
        states = after(rows, trace[:i])
        if event not in events(rows, states):
            return False
        if model != "T" and any(event not in acceptance for acceptance in acceptances(rows, states)):
            return False
        if model == "FD" and diverges(rows, states):
            return False
    return True


def fewest_taus(rows: Rows, trace: tuple[int, ...], goals: set[int]) -> int | None:
    """The least number of taus on a path from the root to one of *goals* whose visible events are *trace*."""
    layer = {0: 0}
    for event in (*trace, None):
        pending = sorted(layer, key=layer.__getitem__)
        while pending:
            s = pending.pop(0)
            for label, t in rows[s]:
                if label == TAU and layer[s] + 1 < layer.get(t, len(rows) + layer[s] + 1):
                    layer[t] = layer[s] + 1
                    pending.append(t)
        if event is not None:
            after: dict[int, int] = {}
            for s, taus in layer.items():
                for label, t in rows[s]:
                    if label == event:
                        after[t] = min(taus, after.get(t, taus))
            layer = after
    return min((taus for s, taus in layer.items() if s in goals), default=None)
