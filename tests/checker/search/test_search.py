"""The search finds what an obvious exploration finds, in whatever way it is run."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from cspcheck.checker.network.network import Network
from cspcheck.checker.packing.packed import PackedNetwork, pack
from cspcheck.checker.search.exploration import Exploration, enabled, explore, successors
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.process.events import TAU
from tests.checker.networks import Explorer, State, networks, small_buffers
from tests.examples import examples

ANY = st.one_of(networks(), networks(most_formats=3), networks(padding=4, most_slots=2), networks(taus=False))


@dataclass(frozen=True)
class Way:
    """A way to run a search."""

    workers: int
    compiled: bool
    products: bool

    def pack(self, network: Network) -> PackedNetwork:
        return pack(network, instances_per_rule=0) if self.products else pack(network)


WAYS = [
    Way(workers, compiled, products)
    for workers, compiled, products in [
        (1, False, False),
        (1, False, True),
        (2, False, False),
        (3, False, True),
        (1, True, False),
        (1, True, True),
        (2, True, False),
        (3, True, True),
    ]
]


@pytest.fixture(autouse=True)
def everything_small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let several workers share even the smallest levels, and let all buffers be too small at first."""
    small_buffers(monkeypatch)


def tuples(exploration: Exploration, indices: np.ndarray | slice) -> list[State]:
    packed = exploration.packed
    return [(packed.format(row), packed.local_states(row)) for row in exploration.states_at(indices)]


def by_level(exploration: Exploration) -> list[list[State]]:
    levels = exploration.levels
    return [tuples(exploration, slice(first, end)) for first, end in pairwise(levels)]


way = pytest.mark.parametrize("way", WAYS, ids=str)
some_ways = pytest.mark.parametrize("way", [WAYS[1], WAYS[6]], ids=str)
checked = settings(
    max_examples=examples(30),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


@way
@checked
@given(network=ANY)
def test_it_finds_the_states_of_each_level_and_their_transitions(way: Way, network: Network) -> None:
    expected = Explorer(network)
    exploration = explore(way.pack(network), workers=way.workers, compiled=way.compiled)
    assert [sorted(level) for level in by_level(exploration)] == [sorted(level) for level in expected.levels()]
    assert exploration.complete
    assert exploration.stop is None
    assert exploration.found == len(expected.moves)
    assert exploration.transitions == expected.transitions(expected.moves)
    assert exploration.has_tau == any(event == TAU for moves in expected.moves.values() for event, _ in moves)
    assert exploration.branching == expected.branching(expected.moves)


@way
@checked
@given(network=ANY)
def test_it_finds_deadlocks_and_cycles_of_taus(way: Way, network: Network) -> None:
    expected = Explorer(network)
    exploration = explore(way.pack(network), workers=way.workers, compiled=way.compiled)
    deadlocks = [expected.deadlocked(level) for level in expected.levels()]
    cycles = [expected.tau_cyclic(level) for level in expected.levels()]
    assert exploration.deadlock_level == next((k for k, states in enumerate(deadlocks) if states), None)
    assert exploration.divergence_level == next((k for k, states in enumerate(cycles) if states), None)
    for k, level in enumerate(expected.levels()):
        assert set(tuples(exploration, exploration.deadlocked(k))) == deadlocks[k]
        assert set(tuples(exploration, exploration.tau_cyclic(k))) == cycles[k]
        assert set(tuples(exploration, exploration.divergent(k))) == expected.divergent(level)


@some_ways
@checked
@given(network=ANY)
def test_it_stops_after_the_first_level_with_what_is_looked_for(way: Way, network: Network) -> None:
    expected = Explorer(network)
    levels = expected.levels()
    for options, found in (
        ({"stop_at_deadlock": True}, expected.deadlocked),
        ({"stop_at_divergence": True}, expected.tau_cyclic),
    ):
        exploration = explore(way.pack(network), workers=way.workers, compiled=way.compiled, **options)
        last = next((k for k, level in enumerate(levels) if found(level)), len(levels) - 1)
        assert exploration.depth == last
        assert exploration.complete == (last == len(levels) - 1)
        assert exploration.stop == (None if exploration.complete else "found")
        assert exploration.transitions == expected.transitions(s for level in levels[: last + 1] for s in level)


@some_ways
@checked
@given(network=ANY, limit=st.integers(0, 40))
def test_past_a_limit_of_states_only_whole_levels_count(way: Way, network: Network, limit: int) -> None:
    expected = Explorer(network)
    levels = expected.levels()
    exploration = explore(way.pack(network), limits=Limits(states=limit), workers=way.workers, compiled=way.compiled)
    # A level is complete when its successors are known, taus of the next level apart.
    known, whole = 0, 0
    for k, level in enumerate(levels):
        known += len(level)
        seeds = {after for state in level for event, after in expected.moves[state] if event != TAU}
        new = {state for state in seeds if expected.level[state] == k + 1}
        if known + len(new) > limit:
            break
        whole = k + 1
    assert exploration.depth == whole - 1
    assert exploration.complete == (whole == len(levels))
    assert exploration.stop == (None if exploration.complete else "states")
    assert exploration.transitions == expected.transitions(s for level in levels[:whole] for s in level)
    assert len(exploration.states) == sum(len(level) for level in levels[:whole])


@some_ways
@checked
@given(network=ANY)
def test_the_explicit_machine_has_the_same_transitions(way: Way, network: Network) -> None:
    expected = Explorer(network)
    exploration = explore(way.pack(network), workers=way.workers, compiled=way.compiled)
    lts = exploration.to_lts()
    states = tuples(exploration, slice(0, lts.states))
    assert lts.root == 0
    assert states[0] == expected.initial
    for number, state in enumerate(states):
        row = list(lts.successors(number))
        assert row == sorted(set(row))
        assert {(event, states[target]) for event, target in row} == expected.moves[state]


@checked
@given(network=ANY, products=st.booleans())
def test_successors_are_in_order_with_the_least_cause(network: Network, products: bool) -> None:
    expected = Explorer(network)
    packed = Way(1, False, products).pack(network)
    states = sorted(expected.moves)
    rows = np.array([packed.pack(*state) for state in states]).reshape(len(states), packed.words)
    found = successors(packed, rows)
    for i, state in enumerate(states):
        part = slice(found.offsets[i], found.offsets[i + 1])
        targets = found.targets[part]
        keys = [(int(e), *t.tolist()) for e, t in zip(found.events[part], targets, strict=True)]
        assert keys == sorted(set(keys))
        least: dict[tuple[int, State], tuple[int, int]] = {}
        for event, number, after in expected.fired(state):
            key = (network.rules[number].cause, number)
            least[event, after] = min(key, least.get((event, after), key))
        rules = found.rules[part].tolist()
        assert {
            (int(event), (packed.format(row), packed.local_states(row))): (network.rules[rule].cause, rule)
            for event, row, rule in zip(found.events[part], targets, rules, strict=True)
        } == least
        assert enabled(packed, rows[i]) == tuple(sorted({event for event, _ in expected.moves[state]}))


@checked
@given(network=ANY)
def test_states_are_found_by_value(network: Network) -> None:
    packed = pack(network)
    exploration = explore(packed, compiled=False)
    for number, row in enumerate(exploration.states):
        assert exploration.index(row) == number
    absent = {(f, local) for f in range(network.formats) for local in {s[1] for s in Explorer(network).moves}}
    for state in absent - set(Explorer(network).moves):
        assert exploration.index(packed.pack(*state)) == -1
