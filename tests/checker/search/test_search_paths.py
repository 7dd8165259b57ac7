"""Paths to goals are shortest and canonical: the same however the search was run."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings, strategies as st

from cspcheck.checker.network.network import Network
from cspcheck.checker.packing.packed import PackedNetwork, pack
from cspcheck.checker.search import paths
from cspcheck.checker.search.exploration import Exploration, explore
from cspcheck.checker.search.paths import PathStep, shortest_path, tau_loop
from cspcheck.cspm.process.events import TAU
from tests.checker.networks import Explorer, State, networks, small_buffers
from tests.checker.vehicle import cycle, synchronised
from tests.examples import examples

Key = tuple[int, int, tuple[int, ...], int]
"""What steps are compared by: event, cause, packed state afterwards, rule."""


class Paths:
    """Canonical paths by brute force, from their definition."""

    def __init__(self, network: Network, packed: PackedNetwork) -> None:
        self.states = Explorer(network)
        self.network = network
        self.packed = packed

    def options(self, state: State) -> Iterator[tuple[Key, State]]:
        for event, rule, after in self.states.fired(state):
            words = tuple(self.packed.pack(*after).tolist())
            yield (event, self.network.rules[rule].cause, words, rule), after

    def least_trace(self, goals: set[State]) -> tuple[int, ...]:
        """The shortest and then least sequence of visible events after which a goal can be reached."""
        traces: list[tuple[tuple[int, ...], frozenset[State]]] = [
            ((), frozenset(self.states.reachable_by_tau([self.states.initial])))
        ]
        while True:
            for trace, states in traces:
                if states & goals:
                    return trace
            longer = []
            for trace, states in traces:
                moves = {move for state in states for move in self.states.moves[state] if move[0] != TAU}
                for event in sorted({event for event, _ in moves}):
                    after = self.states.reachable_by_tau({target for e, target in moves if e == event})
                    longer.append(((*trace, event), frozenset(after)))
            # Of traces that lead to the same states the least, which comes first, is enough.
            least: dict[frozenset[State], tuple[int, ...]] = {}
            for trace, states in longer:
                least.setdefault(states, trace)
            traces = [(trace, states) for states, trace in least.items()]

    def shortest(self, ranked: dict[State, int]) -> list[Key]:
        trace = self.least_trace(set(ranked))
        ends = {self.states.initial}
        ends = self.states.reachable_by_tau(ends)
        for event in trace:
            ends = self.states.reachable_by_tau({t for s in ends for e, t in self.states.moves[s] if e == event})
        best = min(rank for state, rank in ranked.items() if state in ends)
        goals = {state for state, rank in ranked.items() if state in ends and rank == best}
        ahead = self.taus_ahead(trace, goals)
        path: list[Key] = []
        here, position = self.states.initial, 0
        while not (position == len(trace) and here in goals):
            left = ahead[position, here]
            candidates = []
            for key, after in self.options(here):
                if key[0] == TAU and ahead.get((position, after)) == left - 1:
                    candidates.append((key, after, position))
                onward = position < len(trace) and key[0] == trace[position]
                if onward and ahead.get((position + 1, after)) == left:
                    candidates.append((key, after, position + 1))
            key, here, position = min(candidates)
            path.append(key)
        return path

    def taus_ahead(self, trace: tuple[int, ...], goals: set[State]) -> dict[tuple[int, State], int]:
        """The fewest taus on a way to a goal from each (position in the trace, state)."""
        ahead = {(len(trace), goal): 0 for goal in goals}
        queue = deque(ahead)
        while queue:
            position, state = place = queue.popleft()
            for before, moves in self.states.moves.items():
                for event, after in moves:
                    if after != state:
                        continue
                    if event == TAU:
                        earlier, cost = (position, before), 1
                    elif position and event == trace[position - 1]:
                        earlier, cost = (position - 1, before), 0
                    else:
                        continue
                    if ahead[place] + cost < ahead.get(earlier, 10**9):
                        ahead[earlier] = ahead[place] + cost
                        (queue.append if cost else queue.appendleft)(earlier)
        return ahead


def keys(network: Network, path: tuple[PathStep, ...]) -> list[Key]:
    return [(step.event, network.rules[step.rule].cause, step.state, step.rule) for step in path]


@pytest.fixture(autouse=True)
def everything_small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let several workers share even the smallest levels, and let all buffers be too small at first."""
    small_buffers(monkeypatch)


ways = pytest.mark.parametrize(("workers", "compiled"), [(1, False), (2, False), (3, True)])
checked = settings(
    max_examples=examples(60),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
some_networks = st.one_of(
    networks(most_slots=3, most_states=4),
    networks(most_slots=3, most_formats=2),
    networks(padding=3, most_slots=2),
)


def index_of(exploration: Exploration, state: State) -> int:
    return exploration.index(exploration.packed.pack(*state))


@ways
@checked
@given(network=some_networks, data=st.data(), together=st.sampled_from((0, 4, paths.CHUNK)))
def test_the_path_is_the_shortest_then_the_least(
    workers: int, compiled: bool, network: Network, data: st.DataObject, together: int
) -> None:
    packed = pack(network)
    expected = Paths(network, packed)
    ranked = data.draw(
        st.dictionaries(st.sampled_from(sorted(expected.states.moves)), st.integers(0, 2), min_size=1, max_size=5)
    )
    exploration = explore(packed, workers=workers, compiled=compiled)
    goals = np.array([index_of(exploration, state) for state in ranked])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(paths, "CHUNK", together)
        path = shortest_path(exploration, goals, np.array(list(ranked.values())))
    assert keys(network, path) == expected.shortest(ranked)


@ways
@checked
@given(network=some_networks)
def test_a_loop_of_taus_is_the_shortest_then_the_least(workers: int, compiled: bool, network: Network) -> None:
    packed = pack(network)
    paths = Paths(network, packed)
    cyclic = sorted(paths.states.tau_cyclic(paths.states.moves))
    assume(cyclic)
    exploration = explore(packed, workers=workers, compiled=compiled)
    for start in cyclic:
        distance = {start: 0}
        queue = deque([start])
        while queue:
            state = queue.popleft()
            for before in paths.states.moves:
                if state in paths.states.after_tau(before) and before not in distance:
                    distance[before] = distance[state] + 1
                    queue.append(before)
        taus = [(key, after) for key, after in paths.options(start) if key[0] == TAU and after in distance]
        left = min(distance[after] for _, after in taus)
        expected = []
        while True:
            key, here = min((key, after) for key, after in taus if distance[after] == left)
            expected.append(key)
            if left == 0:
                break
            left -= 1
            taus = [(key, after) for key, after in paths.options(here) if key[0] == TAU and after in distance]
        assert keys(network, tau_loop(exploration, index_of(exploration, start))) == expected


def test_a_state_on_no_loop_of_taus_has_none() -> None:
    exploration = explore(pack(synchronised({"P": cycle("a", "b")})), compiled=False)
    with pytest.raises(ValueError, match="no cycle of taus leads through the state"):
        tau_loop(exploration, 0)
