"""A search that goes on on disk finds, counts and tells what it would have found in memory."""

from __future__ import annotations

import errno
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from cspcheck.checker.budget import NO_ROOM
from cspcheck.checker.check import Checker
from cspcheck.checker.network.network import Network
from cspcheck.checker.packing.packed import pack
from cspcheck.checker.search import crew, runs, spill
from cspcheck.checker.search.exploration import Exploration, explore
from cspcheck.checker.search.pair_search import explore_pairs
from cspcheck.checker.search.paths import shortest_path, tau_loop
from cspcheck.checker.search.spill import Spill
from cspcheck.checker.specification.normal_form import NormalModel
from cspcheck.checker.verdict import Limits, Outcome, Verdict
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from tests.checker import explicit
from tests.checker.networks import networks, small_buffers
from tests.checker.search.test_search_pairs import MODELS, implementations, specification
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
    monkeypatch.setattr(runs, "BLOCK", 3)
    monkeypatch.setattr(crew, "DIVIDED_BITS", 7)
    monkeypatch.setattr(spill, "DIVIDED_BITS", 7)
    monkeypatch.setattr(spill, "ROWS", 7)
    monkeypatch.setattr(spill, "SORTED", 5)


def told(found: Exploration) -> tuple[object, ...]:
    return (
        found.levels,
        found.transitions,
        found.transitions_at,
        found.complete,
        found.stop,
        found.deadlock_level,
        found.divergence_level,
        found.has_tau,
        found.branching,
    )


def paths(found: Exploration) -> list[object]:
    """The counterexamples that an exploration gives."""
    shown: list[object] = []
    if found.deadlock_level is not None:
        shown.append(shortest_path(found, found.deadlocked(found.deadlock_level)))
    if found.divergence_level is not None:
        goals = found.tau_cyclic(found.divergence_level)
        shown += [sorted(map(tuple, found.states_at(goals).tolist())), shortest_path(found, goals)]
        shown += sorted(str(tau_loop(found, goal)) for goal in goals.tolist())
    return shown


@checked
@given(
    network=ANY,
    rows=st.integers(0, 12),
    workers=st.sampled_from([1, 3]),
    deadlock=st.booleans(),
    divergence=st.booleans(),
)
def test_of_a_machine(
    tmp_path: Path, network: Network, rows: int, workers: int, deadlock: bool, divergence: bool
) -> None:
    packed = pack(network)
    aims = {"stop_at_deadlock": deadlock, "stop_at_divergence": divergence, "workers": workers, "compiled": False}
    expected = explore(packed, **aims)
    found = explore(packed, beyond=Spill(tmp_path, rows), **aims)
    assert told(found) == told(expected)
    assert paths(found) == paths(expected)
    assert os.listdir(tmp_path) == []


@checked
@given(
    network=implementations,
    rows=explicit.machines(states=4),
    model=st.sampled_from(MODELS),
    own=st.booleans(),
    most=st.integers(0, 8),
    full=st.booleans(),
)
def test_of_pairs(
    tmp_path: Path, network: Network, rows: explicit.Rows, model: NormalModel, own: bool, most: int, full: bool
) -> None:
    packed, normal_form = pack(network), specification(network, rows, model, own)
    expected = explore_pairs(packed, normal_form, model, full=full, compiled=False)
    found = explore_pairs(packed, normal_form, model, full=full, compiled=False, beyond=Spill(tmp_path, most))
    assert told(found) == told(expected)
    assert found.violation_level == expected.violation_level
    if expected.violation_level is None:
        return

    def shown(pairs: Exploration) -> list[object]:
        violations = [
            (*pairs.states_at(np.array([v.index])).tolist(), int(pairs.nodes[v.index]), v.kind, v.event)
            for v in pairs.violations()
        ]
        return [sorted(violations), shortest_path(pairs, np.unique([v.index for v in pairs.violations()]))]

    assert shown(found) == shown(expected)


@checked
@given(network=ANY, limit=st.integers(0, 40), rows=st.integers(0, 10))
def test_past_a_limit_of_states_the_same_levels_count(tmp_path: Path, network: Network, limit: int, rows: int) -> None:
    packed, limits = pack(network), Limits(states=limit)
    expected = explore(packed, limits=limits, compiled=False)
    found = explore(packed, limits=limits, compiled=False, beyond=Spill(tmp_path, rows))
    assert told(found) == told(expected)


def test_several_threads_gather_more_than_fits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    packed = pack(synchronised({f"P{i}": cycle(f"a{i}", f"b{i}", "c" if i < 2 else f"c{i}") for i in range(6)}))
    expected = explore(packed, compiled=False)
    asides = 0
    put_aside = spill.Store.put_aside

    def counted(store: spill.Store, rows: np.ndarray) -> None:
        nonlocal asides
        asides += 1
        put_aside(store, rows)

    monkeypatch.setattr(spill.Store, "put_aside", counted)
    monkeypatch.setattr(spill, "ROWS", 400)
    found = explore(packed, compiled=False, workers=3, beyond=Spill(tmp_path, 10))
    assert told(found) == told(expected)
    assert asides > 3
    assert found.is_partial


def test_a_full_disk_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(runs.RunWriter, "add", full)
    packed = pack(synchronised({f"P{i}": cycle(f"a{i}", f"b{i}") for i in range(5)}))
    found = explore(packed, compiled=False, beyond=Spill(tmp_path, 10))
    assert (found.complete, found.stop) == (False, "disk")
    assert os.listdir(tmp_path) == []


SCRIPT = """
channel a, b, c : {0..2}
P(i) = a.i -> b.i -> P(i)
LATE(n) = if n == 0 then STOP else a?x -> LATE(n - 1)
LOOP(n) = if n == 0 then (let D = c.0 -> D within D \\ {| c |}) else b?x -> LOOP(n - 1)
ALL = ||| i : {0..2} @ P(i)
COUNT(k) = k < 4 & a?x -> COUNT(k + 1) [] k > 0 & b?x -> COUNT(k - 1)
LESS(k) = k < 2 & a?x -> LESS(k + 1) [] k > 0 & b?x -> LESS(k - 1)
assert ALL :[deadlock free]
assert ALL [| {| a |} |] LATE(5) :[deadlock free]
assert ALL [| {| b |} |] LOOP(2) :[divergence free]
assert ALL [| {| b |} |] LOOP(2) :[deadlock free [FD]]
assert ALL :[deterministic]
assert COUNT(0) [T= ALL
assert LESS(0) [T= ALL
assert ALL [F= ALL [| {| a |} |] LATE(4)
assert ALL [FD= ALL [| {| b |} |] LOOP(1)
assert ALL \\ {| b |} :[deterministic]
assert (ALL ||| a.0 -> a.1 -> b.0 -> STOP) \\ {| b |} :[deterministic]
assert ALL ||| P(0) :[deterministic [F]]
assert (ALL ||| SKIP) ; ALL :[deterministic]
assert ALL [| {| b |} |] LOOP(2) :[deterministic]
assert ALL [| {| b |} |] LOOP(2) :[deterministic [F]]
assert ALL ||| (b.0 -> LOOP(1)) :[deterministic]
assert ALL ||| (b.0 -> LOOP(1)) :[deterministic [F]]
assert ALL ||| (c.1 -> (LOOP(1) [] c.2 -> c.1 -> STOP)) :[deterministic [F]]
assert (ALL ||| LOOP(2) ||| (a.0 -> c.1 -> STOP)) \\ {| a |} :[deterministic]
"""


def test_verdicts_counts_and_counterexamples_are_those_in_memory(tmp_path: Path) -> None:
    script = load(Source("s.csp", SCRIPT))

    def answers(place: Spill | None) -> list[Outcome]:
        checker = Checker(script, as_written=True, workers=1, beyond=place)
        return [replace(checker.check(a.node), seconds=0.0, peak_memory_bytes=0) for a in script.assertions]

    expected = answers(None)
    assert answers(Spill(tmp_path, 10)) == expected
    assert {answer.verdict for answer in expected} == {Verdict.PASS, Verdict.FAIL}


def test_a_disk_that_is_full_when_a_counterexample_is_taken_from_it_leaves_the_verdict(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = load(Source("s.csp", SCRIPT))
    expected = [Checker(script, as_written=True, workers=1).check(a.node) for a in script.assertions]
    taken = []

    def full(self: spill.Part) -> object:
        taken.append(self)
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(spill.Part, "ways", full)
    checker = Checker(script, as_written=True, workers=1, beyond=Spill(tmp_path, 10))
    for assertion, right in zip(script.assertions, expected, strict=True):
        taken.clear()
        found = checker.check(assertion.node)
        # Whether a process is deterministic is not known before the places where it has a choice are looked at.
        if ":[deterministic" not in assertion.text or found.verdict is not Verdict.UNKNOWN:
            assert found.verdict is right.verdict
        said = " ".join((found.reason or "", *found.remarks))
        assert (NO_ROOM in said) == bool(taken)
        if right.counterexample is None or not taken:
            continue
        assert found.counterexample is None or found.counterexample.kind == right.counterexample.kind


@pytest.mark.parametrize("states", [140, 400])
def test_what_was_found_before_a_limit_is_told_behind_it(tmp_path: Path, states: int) -> None:
    """All 27 states of the first level lie on cycles of taus, more than fit; the limit is reached on later levels."""
    silent = {f"T{i}": cycle(f"t{i}", f"u{i}", f"v{i}") for i in range(3)}
    slow = {f"P{i}": cycle(f"a{i}", f"b{i}", f"c{i}") for i in range(4)}
    hidden = {event for i in range(3) for event in (f"t{i}", f"u{i}", f"v{i}")}
    packed = pack(synchronised(silent | slow, hidden))
    limits = Limits(states=states)
    expected = explore(packed, limits=limits, compiled=False)
    found = explore(packed, limits=limits, compiled=False, beyond=Spill(tmp_path, 2))
    assert (found.stop, found.divergence_level) == ("states", 0)
    assert told(found) == told(expected)
    assert paths(found) == paths(expected)
