"""Several processes find, count and tell what one would have; here they are threads."""

from __future__ import annotations

import errno
import os
import random
import signal
import threading
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from cspcheck.checker.budget import Budget
from cspcheck.checker.check import Checker
from cspcheck.checker.checks.store import Machines
from cspcheck.checker.network.network import Network
from cspcheck.checker.packing.packed import pack
from cspcheck.checker.search import cluster, visited
from cspcheck.checker.search.checkpoint import Checkpoint, Checkpoints
from cspcheck.checker.search.cluster import Cluster, SharedSearch
from cspcheck.checker.search.exploration import Progress, explore
from cspcheck.checker.search.pair_search import explore_pairs
from cspcheck.checker.search.paths import shortest_path
from cspcheck.checker.search.visited import Visited
from cspcheck.checker.specification.normal_form import NormalModel
from cspcheck.checker.verdict import Limits, Outcome, Verdict
from cspcheck.cli.interrupt import Interrupts
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from tests.checker import explicit
from tests.checker.networks import networks, small_buffers
from tests.checker.search.test_checkpoint import belongs
from tests.checker.search.test_search_pairs import MODELS, implementations, specification
from tests.checker.search.test_spill import SCRIPT, paths, told
from tests.checker.search.threads import with_ranks
from tests.checker.vehicle import cycle, synchronised
from tests.examples import examples

ANY = st.one_of(networks(), networks(most_formats=3), networks(padding=4, most_slots=2), networks(taus=False))

checked = settings(
    max_examples=examples(25),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


@pytest.fixture(autouse=True)
def everything_small(monkeypatch: pytest.MonkeyPatch) -> None:
    small_buffers(monkeypatch)
    monkeypatch.setattr(cluster, "BATCH", 5)


@checked
@given(network=ANY, ranks=st.integers(1, 4), deadlock=st.booleans(), divergence=st.booleans())
def test_a_machine(network: Network, ranks: int, deadlock: bool, divergence: bool) -> None:
    packed = pack(network)
    aims = {"stop_at_deadlock": deadlock, "stop_at_divergence": divergence, "compiled": False}
    expected = explore(packed, **aims)
    found = with_ranks(ranks, lambda all_ranks: explore(packed, beyond=all_ranks, **aims))
    assert told(found) == told(expected)
    assert paths(found) == paths(expected)


@checked
@given(
    network=implementations,
    rows=explicit.machines(states=4),
    model=st.sampled_from(MODELS),
    own=st.booleans(),
    ranks=st.integers(1, 3),
)
def test_pairs(network: Network, rows: explicit.Rows, model: NormalModel, own: bool, ranks: int) -> None:
    packed, normal_form = pack(network), specification(network, rows, model, own)
    expected = explore_pairs(packed, normal_form, model, compiled=False)
    found = with_ranks(ranks, lambda others: explore_pairs(packed, normal_form, model, compiled=False, beyond=others))
    assert told(found) == told(expected)
    assert found.violation_level == expected.violation_level
    if expected.violation_level is not None:
        shown = [shortest_path(e, np.unique([v.index for v in e.violations()])) for e in (found, expected)]
        assert shown[0] == shown[1]


@checked
@given(network=ANY, limit=st.integers(0, 40), ranks=st.integers(1, 3))
def test_past_a_limit_of_states_the_same_levels_count(network: Network, limit: int, ranks: int) -> None:
    packed, limits = pack(network), Limits(states=limit)
    expected = explore(packed, limits=limits, compiled=False)
    found = with_ranks(ranks, lambda all_ranks: explore(packed, limits=limits, compiled=False, beyond=all_ranks))
    assert told(found) == told(expected)


@pytest.mark.parametrize("ranks", [1, 3])
def test_verdicts_counts_and_counterexamples_are_those_of_one_process(ranks: int) -> None:
    script = load(Source("s.csp", SCRIPT))

    def answers(others: Cluster | None) -> list[Outcome]:
        checker = Checker(script, as_written=True, workers=1, beyond=others)
        return [replace(checker.check(a.node), seconds=0.0, peak_memory_bytes=0) for a in script.assertions]

    expected = answers(None)
    assert with_ranks(ranks, answers) == expected
    assert {answer.verdict for answer in expected} == {Verdict.PASS, Verdict.FAIL}


def test_a_search_that_is_ended_is_ended_in_all_processes() -> None:
    packed = pack(synchronised({f"P{i}": cycle(f"a{i}", f"b{i}", f"c{i}") for i in range(6)}))

    def ended(others: Cluster) -> int:
        for _ in range(3):
            found = explore(packed, compiled=False, limits=Limits(seconds=0.0), beyond=others)
            assert (found.stop, found.complete) == ("seconds", False)
        return explore(packed, compiled=False, beyond=others).levels[-1]

    assert with_ranks(3, ended) == 3**6


@pytest.mark.parametrize("by_listener", [False, True])
def test_an_interrupt_in_the_first_process_ends_the_search_in_all(
    by_listener: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    packed = pack(synchronised({f"P{i}": cycle(f"a{i}", f"b{i}", f"c{i}") for i in range(6)}))
    expand, expanded = SharedSearch._expand, 0

    def pressed(search: SharedSearch, *rest: Any) -> None:
        nonlocal expanded
        if search._ranks.rank == 0:
            expanded += 1
            if expanded == 3 and not by_listener:
                os.kill(os.getpid(), signal.SIGINT)
        expand(search, *rest)

    def stop(progress: Progress) -> None:
        raise KeyboardInterrupt

    def ended(others: Cluster) -> int:
        with Interrupts(), pytest.raises(KeyboardInterrupt):
            explore(packed, compiled=False, beyond=others, progress=stop if by_listener else None)
        assert not others.is_broken
        return explore(packed, compiled=False, beyond=others).levels[-1]

    monkeypatch.setattr(SharedSearch, "_expand", pressed)
    monkeypatch.setattr(cluster, "PROGRESS_SECONDS", 0.001)
    assert with_ranks(2, ended) == 3**6


def test_too_little_memory_is_no_wrong_answer() -> None:
    packed = pack(synchronised({f"P{i}": cycle(f"a{i}", f"b{i}", f"c{i}") for i in range(7)}))
    limits = Limits(memory_bytes=20_000)
    found = with_ranks(2, lambda others: explore(packed, compiled=False, limits=limits, beyond=others))
    assert (found.stop, found.complete) == ("memory", False)


def test_what_was_found_before_a_limit_is_told_behind_it() -> None:
    """The ways to a divergence on the first levels are taken out by messages, when there is no memory left."""
    loops = synchronised(
        {f"P{i}": cycle(f"a{i}", f"b{i}", f"c{i}") for i in range(7)} | {"T": cycle("t", "u")}, {"t", "u"}
    )
    limits = Limits(memory_bytes=20_000)
    found = with_ranks(2, lambda others: explore(pack(loops), compiled=False, limits=limits, beyond=others))
    assert (found.stop, found.complete, found.divergence_level) == ("memory", False, 0)
    assert len(shortest_path(found, found.tau_cyclic(0))) == 0


LOOPS = {f"P{i}": cycle(f"a{i}", f"b{i}", f"c{i}") for i in range(6)}


@pytest.mark.parametrize("rank", ["search", "rank 1"])
def test_a_process_that_the_system_gives_no_more_memory(rank: str, monkeypatch: pytest.MonkeyPatch) -> None:
    grow = Visited.grow

    def refused(self: Visited, *rest: Any) -> None:
        if threading.current_thread().name == rank:
            raise MemoryError
        grow(self, *rest)

    monkeypatch.setattr(Visited, "grow", refused)
    monkeypatch.setattr(visited, "LOAD", (1, 16))
    found = with_ranks(3, lambda others: explore(pack(synchronised(LOOPS)), compiled=False, beyond=others))
    assert (found.stop, found.complete) == ("memory", False)


def test_when_the_first_process_fails_it_goes_on_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    packed = pack(synchronised(LOOPS))
    finish = SharedSearch._finish_level

    def failing(self: SharedSearch, *rest: Any) -> None:
        if threading.current_thread().name == "search" and len(self.levels) > 3:
            raise IndexError("nobody expected this")
        finish(self, *rest)

    monkeypatch.setattr(SharedSearch, "_finish_level", failing)

    def searches(others: Cluster) -> int:
        with pytest.raises(IndexError):
            explore(packed, compiled=False, beyond=others)
        return explore(packed, compiled=False, beyond=others).levels[-1]

    assert with_ranks(3, searches) == 3**6


def test_a_disk_that_is_full_for_one_process_ends_the_writing_for_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    packed = pack(synchronised(LOOPS))
    write = Checkpoint.write_pieces
    tries = {"search": 0, "rank 1": 0}

    def full(self: Checkpoint, pieces: Any) -> tuple[int, int]:
        tries[threading.current_thread().name] += 1
        if threading.current_thread().name == "rank 1" and tries["rank 1"] == 3:
            write(self, pieces[:1])
            return errno.ENOSPC, 0
        return write(self, pieces)

    monkeypatch.setattr(Checkpoint, "write_pieces", full)
    told_lines: list[str] = []
    places = Checkpoints(tmp_path / "c", belongs(), resume=False, every=0.0, tell=told_lines.append)
    search = partial(explore, packed, compiled=False)
    whole = with_ranks(2, lambda others: search(beyond=others, checkpoints=places))
    assert told(whole) == told(search())
    assert told_lines == [f"no more checkpoints: {os.strerror(errno.ENOSPC)} ({tmp_path / 'c'})"]
    assert tries == {"search": 3, "rank 1": 3}

    monkeypatch.undo()
    small_buffers(monkeypatch)
    monkeypatch.setattr(cluster, "BATCH", 5)
    again = Checkpoints(tmp_path / "c", belongs(), resume=True, every=0.0)
    assert told(with_ranks(3, lambda others: search(beyond=others, checkpoints=again))) == told(whole)


@pytest.mark.parametrize("stops", [1, 2, 3, 4])
def test_what_some_wrote_down_others_take_up(stops: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = load(Source("s.csp", SCRIPT))
    packed = Machines().packed(script.process("ALL [| {| b |} |] LOOP(6)"), Budget(Limits()))
    whole = explore(packed, compiled=False)
    expected, shown = told(whole), paths(whole)
    chance = random.Random(stops)
    runs = 0
    while True:
        folder = Checkpoints(tmp_path / "c", belongs(), resume=runs > 0, every=0.0)
        limits = Limits(states=chance.randrange(1 + 12 * runs, 30 + 30 * runs))
        ranks = chance.randrange(5)
        runs += 1
        search = partial(explore, packed, compiled=False, limits=limits, checkpoints=folder)
        found = search() if ranks == 0 else with_ranks(ranks, lambda others, search=search: search(beyond=others))
        if found.complete:
            break
    assert runs > 2
    assert (told(found), paths(found)) == (expected, shown)
