"""Random networks, and what they mean by an obvious exploration of tuples of local states."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from itertools import product

import numpy as np
import pytest
from hypothesis import strategies as st

from cspcheck.checker.lts import Lts
from cspcheck.checker.network.network import Network, Rule, Slot, Switch
from cspcheck.cspm.process.events import FIRST_EVENT, TAU, TICK
from cspcheck.cspm.process.terms import Stop

State = tuple[int, tuple[int, ...]]
"""The format and the local states."""
Move = tuple[int, State]
"""The event and the state afterwards."""


def slot(name: str, rows: list[list[tuple[int, int]]]) -> Slot:
    return Slot(name, None, Lts.from_successors(rows), (Stop(),) * len(rows))


def wide_slot(name: str, size: int, event: int, edges: set[tuple[int, int]]) -> Slot:
    """A machine of many states and few transitions."""
    sources, targets = (np.array([edge[i] for edge in sorted(edges)], dtype=np.int64) for i in (0, 1))
    offsets = np.searchsorted(sources, np.arange(size + 1)).astype(np.int64)
    return Slot(name, None, Lts(offsets, np.full(len(edges), event, dtype=np.int64), targets), ())


@st.composite
def machines(draw: st.DrawFn, most_states: int, labels: list[int], ticking: bool) -> list[list[tuple[int, int]]]:
    """The rows of a local machine; with *ticking* its last state is the terminated one."""
    states = draw(st.integers(1, most_states))
    moves = draw(
        st.lists(
            st.tuples(st.integers(0, states - 1), st.sampled_from(labels), st.integers(0, states - 1)),
            max_size=3 * states,
        )
    )
    rows: list[list[tuple[int, int]]] = [[] for _ in range(states)]
    for source, label, target in moves:
        rows[source].append((label, target))
    if ticking:
        for source in draw(st.sets(st.integers(0, states - 1))):
            rows[source].append((TICK, states))
        rows.append([])
    return rows


@st.composite
def networks(
    draw: st.DrawFn,
    *,
    most_slots: int = 4,
    most_states: int = 4,
    most_formats: int = 1,
    taus: bool = True,
    padding: int = 0,
) -> Network:
    """A network with rules of any number of participants; *padding* slots of many states make states wide."""
    labels = [TAU, *range(FIRST_EVENT, FIRST_EVENT + 3)]
    results = [*([TAU] * taus), *range(FIRST_EVENT, FIRST_EVENT + 3)]
    ticking = draw(st.booleans())
    count = draw(st.integers(1, most_slots))
    slots = [slot(f"P{i}", draw(machines(most_states, labels, ticking))) for i in range(count)]
    for i in range(padding):
        size = draw(st.sampled_from([1, 200, 70_000]))
        edges = draw(st.sets(st.tuples(*[st.integers(0, size - 1)] * 2), max_size=4))
        slots.insert(draw(st.integers(0, len(slots))), wide_slot(f"W{i}", size, FIRST_EVENT + i % 3, edges))
    formats = draw(st.integers(1, most_formats))
    everything = range(len(slots))

    def moves() -> tuple[tuple[int, int], ...]:
        chosen = sorted(draw(st.sets(st.sampled_from(everything), max_size=min(4, len(slots)))))
        return tuple((place, draw(st.sampled_from(labels))) for place in chosen)

    def switch() -> Switch | None:
        if formats == 1 or draw(st.booleans()):
            return None
        cleared = draw(st.sets(st.sampled_from(everything)))
        started = draw(st.sets(st.sampled_from(everything)))
        return Switch(
            draw(st.integers(0, formats - 1)),
            tuple(sorted(cleared)),
            tuple((place, draw(st.integers(0, slots[place].lts.states - 1))) for place in sorted(started)),
        )

    rules = []
    for _ in range(draw(st.integers(0, 8))):
        result = draw(st.sampled_from(results))
        cause = draw(st.sampled_from(labels))
        rules.append(Rule(result, moves(), cause, draw(st.integers(0, formats - 1)), switch()))
    if ticking and formats == 1:
        rules.append(Rule(TICK, tuple((place, TICK) for place in range(len(slots)) if not padded(slots[place])), TICK))
    elif ticking:
        end = Switch(formats - 1, tuple(everything), ())
        rules.append(Rule(TICK, moves(), TICK, draw(st.integers(0, formats - 1)), end))
    initial = tuple((place, draw(st.integers(0, slots[place].lts.states - 1))) for place in everything)
    return Network(
        tuple(slots),
        tuple(rules),
        formats,
        draw(st.integers(0, formats - 1)),
        initial,
        any(rule.result == TICK for rule in rules),
    )


def padded(place: Slot) -> bool:
    return place.name.startswith("W")


class Explorer:
    """A network's reachable states and everything that is asked of them, by definition."""

    def __init__(self, network: Network) -> None:
        self.network = network
        local = [0] * len(network.slots)
        for place, state in network.initial:
            local[place] = state
        self.initial: State = (network.initial_format, tuple(local))
        self.moves: dict[State, set[Move]] = {}
        self.level: dict[State, int] = {self.initial: 0}
        self._search()

    def fired(self, state: State) -> Iterable[tuple[int, int, State]]:
        """Every (event, rule, successor), with repetitions."""
        format, local = state
        for number, rule in enumerate(self.network.rules):
            if rule.format != format:
                continue
            choices = [
                [target for label, target in self.network.slots[place].lts.successors(local[place]) if label == wanted]
                for place, wanted in rule.moves
            ]
            for targets in product(*choices):
                after = list(local)
                for (place, _), target in zip(rule.moves, targets, strict=True):
                    after[place] = target
                new_format = format
                if rule.switch is not None:
                    new_format = rule.switch.format
                    for place in rule.switch.cleared:
                        after[place] = 0
                    for place, start in rule.switch.started:
                        after[place] = start
                yield rule.result, number, (new_format, tuple(after))

    def _search(self) -> None:
        queue = deque([self.initial])
        while queue:
            state = queue.popleft()
            if state in self.moves:
                continue
            self.moves[state] = {(event, after) for event, _, after in self.fired(state)}
            for event, after in self.moves[state]:
                distance = self.level[state] + (event != TAU)
                if distance < self.level.get(after, distance + 1):
                    self.level[after] = distance
                    if event == TAU:
                        queue.appendleft(after)
                    else:
                        queue.append(after)

    def levels(self) -> list[set[State]]:
        levels: list[set[State]] = [set() for _ in range(max(self.level.values()) + 1)]
        for state, level in self.level.items():
            levels[level].add(state)
        return levels

    def transitions(self, states: Iterable[State]) -> int:
        return sum(len(self.moves[state]) for state in states)

    def terminated(self, state: State) -> bool:
        network = self.network
        ticks = [rule for rule in network.rules if rule.result == TICK]
        if network.formats > 1:
            return bool(ticks) and state == (network.formats - 1, (0,) * len(network.slots))
        return any(
            all(
                state[1][place] in network.slots[place].lts.targets[network.slots[place].lts.labels == wanted]
                for place, wanted in rule.moves
            )
            for rule in ticks
        )

    def deadlocked(self, states: Iterable[State]) -> set[State]:
        return {state for state in states if not self.moves[state] and not self.terminated(state)}

    def after_tau(self, state: State) -> set[State]:
        return {after for event, after in self.moves[state] if event == TAU}

    def reachable_by_tau(self, states: Iterable[State]) -> set[State]:
        found, stack = set(states), list(states)
        while stack:
            for after in self.after_tau(stack.pop()) - found:
                found.add(after)
                stack.append(after)
        return found

    def tau_cyclic(self, states: Iterable[State]) -> set[State]:
        return {state for state in states if state in self.reachable_by_tau(self.after_tau(state))}

    def divergent(self, states: Iterable[State]) -> set[State]:
        cyclic = self.tau_cyclic(self.moves)
        return {state for state in states if self.reachable_by_tau([state]) & cyclic}

    def branching(self, states: Iterable[State]) -> bool:
        for state in states:
            events = [event for event, _ in self.moves[state] if event != TAU]
            if len(events) != len(set(events)):
                return True
        return False


def small_buffers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have the search do with small networks what it does with large ones."""
    monkeypatch.setattr("cspcheck.checker.search.levels.PARALLEL_ROWS", 1)
    monkeypatch.setattr("cspcheck.checker.search.levels.PARALLEL_STATES", 0)
    monkeypatch.setattr("cspcheck.checker.search.pace.Pace.is_for_all", True)
    monkeypatch.setattr("cspcheck.checker.search.levels.CAPACITY", 8)
    monkeypatch.setattr("cspcheck.checker.search.levels.SMALL_CAPACITY", 2)
    monkeypatch.setattr("cspcheck.checker.search.levels.SHARED_CAPACITY", 2)
    monkeypatch.setattr("cspcheck.checker.search.expansion.CAPACITY", 4)
    monkeypatch.setattr("cspcheck.checker.search.expansion.SMALL_CAPACITY", 1)
    monkeypatch.setattr("cspcheck.checker.search.crew.STRETCH", 3)
    monkeypatch.setattr("cspcheck.checker.search.crew.LEAST_ROWS", 1)
    monkeypatch.setattr("cspcheck.checker.search.crew.ENVELOPES", 2)
