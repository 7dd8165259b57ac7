"""A search by partial order finds what the whole search finds: on random networks, whatever way it is run."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from random import Random

import pytest

from cspcheck.checker.network.network import Network, Rule, Slot, Switch
from cspcheck.checker.packing.packed import PackedNetwork, pack
from cspcheck.checker.packing.stubborn import Kept, narrowed
from cspcheck.checker.search import cluster, crew, runs, spill
from cspcheck.checker.search.checkpoint import Checkpoints
from cspcheck.checker.search.exploration import Exploration, explore
from cspcheck.checker.search.pair_search import explore_pairs
from cspcheck.checker.search.paths import shortest_path
from cspcheck.checker.search.spill import Spill
from cspcheck.checker.specification.normal_form import NormalForm, NormalModel
from cspcheck.checker.specification.normalisation import normalise
from cspcheck.cspm.process.events import FIRST_EVENT, TAU, TICK
from tests.checker.networks import slot, small_buffers
from tests.checker.search.test_checkpoint import belongs
from tests.checker.search.test_spill import paths, told
from tests.checker.search.threads import with_ranks
from tests.examples import examples

MODELS: tuple[NormalModel, ...] = ("T", "F", "FD")
EVENTS = range(FIRST_EVENT, FIRST_EVENT + 3)
KEPT: tuple[Kept, ...] = ("deadlocks", "behaviour")
SILENT = (0.3, 0.6, 0.8, 0.95)


def machine(random: Random, labels: list[int], *, ticking: bool) -> list[list[tuple[int, int]]]:
    states = random.randint(1, 4)
    rows: list[list[tuple[int, int]]] = [[] for _ in range(states)]
    for _ in range(random.randint(0, 2 * states)):
        rows[random.randrange(states)].append((random.choice(labels), random.randrange(states)))
    if ticking:
        for row in rows:
            if random.random() < 0.3:
                row.append((TICK, states))
        rows.append([])
    return rows


def network(random: Random, silent: float) -> Network:
    """Up to five components that act alone as often as together, so that there is something to leave out.

    Args:
        random: chooses.
        silent: how likely a rule has the result tau.
    """
    labels = list(range(FIRST_EVENT, FIRST_EVENT + 4))
    ticking = random.random() < 0.3
    slots: tuple[Slot, ...] = tuple(
        slot(f"P{i}", machine(random, labels, ticking=ticking)) for i in range(random.randint(2, 5))
    )
    formats = random.choice([1, 2])
    rules = []
    for place in range(len(slots)):
        for label in labels:
            if random.random() < (0.9 if label in labels[:2] else 0.2):
                for format in range(formats):
                    result = TAU if random.random() < silent else random.choice(EVENTS)
                    if format == 0 or random.random() < 0.5:
                        rules.append(Rule(result, ((place, label),), label, format))
    for _ in range(random.randint(0, 5)):
        places = sorted(random.sample(range(len(slots)), random.randint(2, min(3, len(slots)))))
        result = TAU if random.random() < silent else random.choice(EVENTS)
        moves = tuple((place, random.choice(labels[1:])) for place in places)
        rules.append(Rule(result, moves, FIRST_EVENT, random.randrange(formats)))
    if formats == 2:
        place = random.randrange(len(slots))
        cleared = tuple(sorted(random.sample(range(len(slots)), random.randint(0, 2))))
        started = tuple((other, random.randrange(slots[other].lts.states)) for other in cleared)
        rules.append(
            Rule(random.choice([TAU, *EVENTS]), ((place, random.choice(labels)),), TAU, 0, Switch(1, cleared, started))
        )
    elif ticking:
        rules.append(Rule(TICK, tuple((place, TICK) for place in range(len(slots))), TICK))
    start = tuple((place, random.randrange(slots[place].lts.states)) for place in range(len(slots)))
    ends = any(rule.result == TICK for rule in rules)
    return Network(slots, tuple(rules), formats, 0, start, ends)


def deadlocks(exploration: Exploration) -> set[tuple[int, ...]]:
    found = (exploration.deadlocked(level) for level in range(exploration.depth + 1))
    return {tuple(row) for indices in found for row in exploration.states_at(indices).tolist()}


def keeps_deadlocks(packed: PackedNetwork, reduced: PackedNetwork, *, compiled: bool, workers: int) -> int:
    """Hold a reduced search for deadlocks against the whole one; how many transitions it did without."""
    whole = explore(packed, compiled=compiled)
    found = explore(reduced, compiled=compiled, workers=workers, look_for_divergence=False)
    assert deadlocks(found) == deadlocks(whole)
    assert found.deadlock_level == whole.deadlock_level
    assert found.complete
    if found.deadlock_level is not None:
        early = explore(reduced, compiled=compiled, workers=workers, stop_at_deadlock=True)
        path = shortest_path(early, early.deadlocked(found.deadlock_level))
        assert sum(step.event != TAU for step in path) == whole.deadlock_level
        at = whole.index(packed.initial)
        for step in path:  # it is a run of the whole
            after = whole.successors(whole.indices(whole.states_at([at])))
            targets = {(int(e), tuple(row)) for e, row in zip(after.events, after.targets.tolist(), strict=True)}
            assert (step.event, step.state) in targets
            at = whole.index(step.state)
    return whole.transitions - found.transitions


def keeps_behaviour(
    packed: PackedNetwork,
    reduced: PackedNetwork,
    specification: NormalForm,
    model: NormalModel,
    *,
    compiled: bool,
    workers: int,
) -> int:
    """Hold a reduced search for behaviour against the whole one; how many transitions it did without."""
    whole = explore(packed, compiled=compiled)
    found = explore(reduced, compiled=compiled, workers=workers)
    assert found.divergence_level == whole.divergence_level
    same = normalise(whole.to_lts(), model), normalise(found.to_lts(), model)
    for form, other in zip(same, (reduced, packed), strict=True):
        assert explore_pairs(other, form, model, compiled=compiled, workers=workers).violation_level is None
    before = explore_pairs(packed, specification, model, compiled=compiled)
    after = explore_pairs(reduced, specification, model, compiled=compiled, workers=workers)
    assert after.violation_level == before.violation_level
    assert {(v.kind, v.event) for v in after.violations()} == {(v.kind, v.event) for v in before.violations()}
    return whole.transitions - found.transitions


@pytest.mark.parametrize(("compiled", "workers", "number"), [(True, 1, 800), (True, 2, 50), (False, 1, 50)])
def test_deadlocks_are_kept(monkeypatch: pytest.MonkeyPatch, compiled: bool, workers: int, number: int) -> None:
    if workers > 1:
        small_buffers(monkeypatch)
    spared = 0
    for seed in range(examples(number)):
        packed = pack(network(Random(seed), SILENT[seed % len(SILENT)]), instances_per_rule=seed % 2 * 4_096)
        reduced = narrowed(packed, "deadlocks")
        if reduced is not None:
            spared += keeps_deadlocks(packed, reduced, compiled=compiled, workers=workers) > 0
    assert spared > examples(number) // 12, spared


@pytest.mark.parametrize(("compiled", "workers", "number"), [(True, 1, 400), (True, 2, 50), (False, 1, 50)])
def test_behaviour_is_kept(monkeypatch: pytest.MonkeyPatch, compiled: bool, workers: int, number: int) -> None:
    if workers > 1:
        small_buffers(monkeypatch)
    spared = 0
    for seed in range(examples(number)):
        packed = pack(network(Random(seed), SILENT[seed % len(SILENT)]), instances_per_rule=seed % 2 * 4_096)
        reduced = narrowed(packed, "behaviour")
        if reduced is not None:
            other = explore(pack(network(Random(-1 - seed), 0.2)), compiled=compiled).to_lts()
            model = MODELS[seed % len(MODELS)]
            form = normalise(other, model)
            spared += keeps_behaviour(packed, reduced, form, model, compiled=compiled, workers=workers) > 0
    assert spared > examples(number) // 12, spared


def test_on_disk_and_with_others_the_same_is_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    small_buffers(monkeypatch)
    monkeypatch.setattr(runs, "BLOCK", 3)
    monkeypatch.setattr(crew, "DIVIDED_BITS", 7)
    monkeypatch.setattr(spill, "DIVIDED_BITS", 7)
    monkeypatch.setattr(spill, "ROWS", 7)
    monkeypatch.setattr(cluster, "BATCH", 5)
    for seed in range(examples(40)):
        reduced = narrowed(pack(network(Random(seed), SILENT[seed % len(SILENT)])), KEPT[seed // 2 % 2])
        if reduced is None:
            continue
        search = partial(explore, reduced, compiled=False, stop_at_deadlock=bool(seed % 2))
        expected = search()
        on_disk = search(beyond=Spill(tmp_path, seed % 7))
        others = with_ranks(2, lambda ranks, search=search: search(beyond=ranks))
        for found in (on_disk, others):
            assert (told(found), paths(found)) == (told(expected), paths(expected))


def test_a_checkpoint_of_one_search_is_none_of_the_other(tmp_path: Path) -> None:
    packed = pack(network(Random(9), 0.8))
    reduced = narrowed(packed, "deadlocks")
    assert reduced is not None
    whole, fewer = told(explore(packed, compiled=False)), told(explore(reduced, compiled=False))
    assert whole != fewer
    explore(packed, compiled=False, checkpoints=Checkpoints(tmp_path / "c", belongs(), resume=False, every=0.0))
    again = Checkpoints(tmp_path / "c", belongs(), resume=True, every=0.0)
    assert told(explore(reduced, compiled=False, checkpoints=again)) == fewer
    assert told(explore(reduced, compiled=False, checkpoints=again)) == fewer
    assert told(explore(packed, compiled=False, checkpoints=again)) == whole


def test_who_may_be_ended_by_others_does_not_keep_them_waiting() -> None:
    x, y, z = EVENTS
    cycle, steps = slot("Q", [[(x, 1)], [(x, 0)]]), slot("P", [[(y, 1)], [(z, 2)], []])
    rules = (
        Rule(x, ((0, x),), x),
        Rule(y, ((1, y),), y),
        Rule(z, ((1, z),), z, switch=Switch(1, (0, 1), ())),
    )
    packed = pack(Network((cycle, steps), rules, formats=2))
    reduced = narrowed(packed, "deadlocks")
    assert reduced is not None
    keeps_deadlocks(packed, reduced, compiled=False, workers=1)
    assert explore(reduced, compiled=False).deadlock_level == 2
