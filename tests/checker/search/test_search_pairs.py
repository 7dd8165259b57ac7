"""The search over pairs finds the violations that an obvious search over pairs finds."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from cspcheck.checker.network.network import Network
from cspcheck.checker.packing.packed import pack
from cspcheck.checker.search.exploration import explore
from cspcheck.checker.search.pair_search import PairExploration, explore_pairs
from cspcheck.checker.specification.normal_form import NormalForm, NormalModel
from cspcheck.checker.specification.normalisation import Normaliser, normalise
from cspcheck.cspm.process.events import TAU, TICK
from tests.checker import explicit
from tests.checker.networks import Explorer, State, networks, small_buffers
from tests.examples import examples

Pair = tuple[int, State]
Found = tuple[Pair, str, int]

MODELS: list[NormalModel] = ["T", "F", "FD"]


class PairExplorer:
    """The reachable pairs of a node and a state, their transitions and what they violate, by definition."""

    def __init__(self, network: Network, normal_form: NormalForm, model: NormalModel) -> None:
        self.states = Explorer(network)
        self.normal_form = normal_form
        self.model = model
        self.moves: dict[Pair, set[tuple[int, Pair]]] = {}
        self.level: dict[Pair, int] = {(normal_form.root, self.states.initial): 0}
        queue = deque(self.level)
        while queue:
            pair = queue.popleft()
            if pair in self.moves:
                continue
            self.moves[pair] = set(self._successors(pair))
            for event, after in self.moves[pair]:
                distance = self.level[pair] + (event != TAU)
                if distance < self.level.get(after, distance + 1):
                    self.level[after] = distance
                    if event == TAU:
                        queue.appendleft(after)
                    else:
                        queue.append(after)

    def _successors(self, pair: Pair) -> Iterator[tuple[int, Pair]]:
        node, state = pair
        if self.normal_form.divergent[node]:
            return
        for event, after in self.states.moves[state]:
            behind = node if event == TAU else self.normal_form.after(node, event)
            if behind is not None:
                yield event, (behind, after)

    def violations(self, pair: Pair) -> Iterator[Found]:
        node, state = pair
        if self.normal_form.divergent[node]:
            return
        events = {event for event, _ in self.states.moves[state]}
        for event in sorted(events - {TAU}):
            if self.normal_form.after(node, event) is None:
                yield pair, "trace", event
        offered = {TICK} if TICK in events else events
        enough = any(offered >= set(acceptance) for acceptance in self.normal_form.acceptances(node))
        if (TICK in events or TAU not in events) and not enough:
            yield pair, "refusal", -1
        if self.model == "FD" and self.states.tau_cyclic([state]):
            yield pair, "divergence", -1

    def first_level(self) -> int | None:
        return min((k for pair, k in self.level.items() if any(self.violations(pair))), default=None)


def pairs_of(exploration: PairExploration, first: int = 0, last: int | None = None) -> list[Pair]:
    packed = exploration.packed
    part = slice(first, exploration.levels[-1] if last is None else last)
    states = [(packed.format(row), packed.local_states(row)) for row in exploration.states_at(part)]
    return list(zip(exploration.nodes[part].tolist(), states, strict=True))


@pytest.fixture(autouse=True)
def everything_small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let several workers share even the smallest levels, and let all buffers be too small at first."""
    small_buffers(monkeypatch)


ways = pytest.mark.parametrize(("workers", "compiled"), [(1, False), (2, False), (1, True), (3, True)])
checked = settings(
    max_examples=examples(40),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
implementations = st.one_of(
    networks(most_slots=3, most_states=3), networks(most_slots=3, most_formats=2), networks(padding=4, most_slots=2)
)
questions = given(
    network=implementations,
    rows=explicit.machines(states=4),
    model=st.sampled_from(MODELS),
    own=st.booleans(),
)


def specification(network: Network, rows: explicit.Rows, model: NormalModel, own: bool) -> NormalForm:
    """A normal form that has something to do with the network: of a random machine, or of the network itself."""
    if own:
        return normalise(explore(pack(network), compiled=False).to_lts(), model)
    return normalise(explicit.lts(rows), model)


@ways
@checked
@questions
def test_it_finds_the_first_level_with_violations_and_all_of_those(
    workers: int, compiled: bool, network: Network, rows: explicit.Rows, model: NormalModel, own: bool
) -> None:
    normal_form = specification(network, rows, model, own)
    expected = PairExplorer(network, normal_form, model)
    found = explore_pairs(pack(network), normal_form, model, workers=workers, compiled=compiled)
    level = expected.first_level()
    assert found.violation_level == level
    assert own <= (level is None)
    last = max(expected.level.values()) if level is None else level
    reached = [pair for pair, k in expected.level.items() if k <= last]
    assert sorted(pairs_of(found)) == sorted(reached)
    assert found.transitions == sum(len(expected.moves[pair]) for pair in reached)
    if level is not None:
        pairs = pairs_of(found)
        violations = {
            found_at for pair, k in expected.level.items() if k == level for found_at in expected.violations(pair)
        }
        listed = [(pairs[v.index], v.kind, v.event) for v in found.violations()]
        assert len(set(listed)) == len(listed)
        assert set(listed) == violations


@ways
@checked
@questions
def test_a_full_search_explores_everything_that_is_allowed(
    workers: int, compiled: bool, network: Network, rows: explicit.Rows, model: NormalModel, own: bool
) -> None:
    normal_form = specification(network, rows, model, own)
    expected = PairExplorer(network, normal_form, model)
    found = explore_pairs(pack(network), normal_form, model, full=True, workers=workers, compiled=compiled)
    assert found.complete
    assert found.violation_level == expected.first_level()
    assert sorted(pairs_of(found)) == sorted(expected.moves)
    assert found.transitions == sum(map(len, expected.moves.values()))
    for level in range(found.depth + 1):
        pairs = pairs_of(found)
        listed = {(pairs[v.index], v.kind, v.event) for v in found.violations(level)}
        assert listed == {v for pair, k in expected.level.items() if k == level for v in expected.violations(pair)}


@checked
@given(network=implementations, rows=explicit.machines(states=4), model=st.sampled_from(MODELS))
def test_a_lazy_normal_form_gives_what_the_complete_one_gives(
    network: Network, rows: explicit.Rows, model: NormalModel
) -> None:
    packed = pack(network)
    complete = explore_pairs(packed, normalise(explicit.lts(rows), model, minimise=False), model, compiled=False)
    lazy = explore_pairs(packed, Normaliser(explicit.lts(rows), model), model, compiled=False)
    assert lazy.levels == complete.levels
    assert lazy.transitions == complete.transitions
    assert lazy.violation_level == complete.violation_level
    assert [(v.kind, v.event) for v in lazy.violations()] == [(v.kind, v.event) for v in complete.violations()]


@checked
@given(network=implementations, rows=explicit.machines(states=4), model=st.sampled_from(MODELS))
def test_successors_of_a_pair_say_what_the_specification_does(
    network: Network, rows: explicit.Rows, model: NormalModel
) -> None:
    normal_form = normalise(explicit.lts(rows), model)
    found = explore_pairs(pack(network), normal_form, model, full=True, compiled=False)
    states = Explorer(network)
    packed = found.packed
    after = found.successors(np.arange(found.levels[-1]))
    for i, (node, state) in enumerate(pairs_of(found)):
        part = slice(after.offsets[i], after.offsets[i + 1])
        listed = {
            (int(event), int(behind), (packed.format(row), packed.local_states(row)))
            for event, behind, row in zip(after.events[part], after.nodes[part], after.targets[part], strict=True)
        }
        expected = set()
        for event, target in states.moves[state]:
            stays = event == TAU or normal_form.divergent[node]
            behind = node if stays else normal_form.after(node, event)
            expected.add((event, -1 if behind is None else behind, target))
        assert listed == expected
