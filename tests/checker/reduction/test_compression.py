"""Every compression means what its operand means, and a quotient is as small as an obvious fixpoint says."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import pytest
from hypothesis import given, strategies as st

from cspcheck.checker import guard
from cspcheck.checker.kernels.jit import kernels, tau_kernels
from cspcheck.checker.lts import Lts, machine
from cspcheck.checker.reduction import bisimulation, compression, partition
from cspcheck.checker.reduction.bisimulation import (
    branching_bisimulation,
    strong_bisimulation,
    tau_abstracting_partition,
    tau_components,
)
from cspcheck.checker.reduction.compression import COMPRESSIONS
from cspcheck.checker.reduction.partition import coarsest_partition
from cspcheck.cspm.interruption import Stopped
from cspcheck.cspm.process.events import TAU, TICK
from tests.checker.explicit import A, B, Rows, diverges, first_deadlock, lts, machines, refinement_violation

Moves = list[set[tuple[int, int]]]


def rows_of(machine: Lts) -> Rows:
    rows = [set(machine.successors(state)) for state in range(machine.states)]
    assert machine.root == 0
    return rows


def obvious_classes(moves: Moves, initial: list[int]) -> list[int]:
    """Split every class by signature until nothing changes."""
    classes = initial
    while True:
        signatures = [(classes[s], frozenset((a, classes[t]) for a, t in row)) for s, row in enumerate(moves)]
        numbers = {signature: i for i, signature in enumerate(dict.fromkeys(signatures))}
        refined = [numbers[signature] for signature in signatures]
        if len(set(refined)) == len(set(classes)):
            return refined
        classes = refined


def taus_from(rows: Rows, state: int) -> set[int]:
    found = {state}
    while True:
        more = {t for s in found for a, t in rows[s] if a == TAU} - found
        if not more:
            return found
        found |= more


def abstract_moves(rows: Rows, *, after: bool) -> Moves:
    """tau* and tau* a (tau*) as one move each."""
    moves: Moves = []
    for state in range(len(rows)):
        reach = taus_from(rows, state)
        visible = {(a, t) for s in reach for a, t in rows[s] if a != TAU}
        if after:
            visible = {(a, u) for a, t in visible for u in taus_from(rows, t)}
        moves.append(visible | {(TAU, t) for t in reach})
    return moves


def ended(rows: Rows) -> list[int]:
    """1 for states that tick leads to."""
    after = {t for row in rows for label, t in row if label == TICK}
    return [int(state in after) for state in range(len(rows))]


def size_of(classes: Iterable[int]) -> int:
    return len(set(classes))


@pytest.mark.parametrize("name", sorted(COMPRESSIONS))
@given(rows=machines(states=7, events=2))
def test_a_compression_changes_no_behaviour_in_any_model(name: str, rows: Rows) -> None:
    compressed = rows_of(COMPRESSIONS[name](lts(rows)))

    for model in ("T", "F", "FD"):
        assert refinement_violation(rows, compressed, model) is None
        assert refinement_violation(compressed, rows, model) is None


@pytest.mark.parametrize("name", sorted(COMPRESSIONS))
@given(rows=machines(states=7, events=2))
def test_a_compression_never_hides_or_invents_a_divergence(name: str, rows: Rows) -> None:
    compressed = rows_of(COMPRESSIONS[name](lts(rows)))

    assert any(diverges(rows, frozenset({s})) for s in range(len(rows))) == any(
        diverges(compressed, frozenset({s})) for s in range(len(compressed))
    )


@given(rows=machines(states=8, events=2))
def test_the_strong_quotient_is_as_small_as_the_fixpoint(rows: Rows) -> None:
    assert COMPRESSIONS["sbisim"](lts(rows)).states == size_of(obvious_classes(rows, ended(rows)))


@pytest.mark.parametrize(("name", "after"), [("wbisim", True), ("dbisim", False)])
@given(rows=machines(states=8, events=2))
def test_the_weak_quotients_are_as_small_as_the_fixpoint(name: str, after: bool, rows: Rows) -> None:
    divergent = [int(diverges(rows, frozenset({state}))) for state in range(len(rows))]
    apart = [2 * d + e for d, e in zip(divergent, ended(rows), strict=True)]
    classes = obvious_classes(abstract_moves(rows, after=after), apart)

    assert COMPRESSIONS[name](lts(rows)).states == size_of(classes)


@pytest.mark.parametrize("name", sorted(COMPRESSIONS))
@given(rows=machines(states=7, events=2))
def test_to_have_terminated_and_to_be_deadlocked_stay_apart(name: str, rows: Rows) -> None:
    compressed = rows_of(COMPRESSIONS[name](lts(rows)))

    assert (first_deadlock(rows) is None) == (first_deadlock(compressed) is None)


@given(rows=machines(states=8, events=2), initial=st.lists(st.integers(0, 2), min_size=9, max_size=9))
def test_a_partition_refines_its_initial_one_and_equals_the_fixpoint(rows: Rows, initial: list[int]) -> None:
    initial = initial[: len(rows)]

    found = coarsest_partition(lts(rows), np.array(initial))

    expected = obvious_classes(rows, initial)
    assert found.tolist() == [list(dict.fromkeys(expected)).index(c) for c in expected]


@given(
    rows=machines(states=8, events=2),
    initial=st.lists(st.integers(0, 2), min_size=9, max_size=9),
    most=st.integers(0, 6),
)
def test_a_partition_that_is_made_in_pieces_is_the_same(rows: Rows, initial: list[int], most: int) -> None:
    given_classes = np.array(initial[: len(rows)])
    expected = coarsest_partition(lts(rows), given_classes).tolist()

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(partition, "MOST", most)
        assert coarsest_partition(lts(rows), given_classes).tolist() == expected


@given(rows=machines(states=8, events=1))
def test_components_of_taus_are_mutually_reachable_states_in_reverse_order(rows: Rows) -> None:
    components, diverging = tau_components(lts(rows))

    reach = [taus_from(rows, state) for state in range(len(rows))]
    for s in range(len(rows)):
        assert diverging[s] == diverges(rows, frozenset({s}))
        for t in range(len(rows)):
            assert (components[s] == components[t]) == (t in reach[s] and s in reach[t])
            assert t not in reach[s] or components[t] <= components[s]


@given(
    rows=machines(states=8, events=2),
    after=st.booleans(),
    most=st.sampled_from((0, 20, 1 << 20)),
    slice_=st.sampled_from((0, 3, 30, 1 << 20)),
    slices=st.sampled_from((1, 1 << 20)),
    few=st.sampled_from((0, 1 << 20)),
)
def test_classes_of_targets_give_the_same_partition_as_all_moves_written_down(
    rows: Rows, after: bool, most: int, slice_: int, slices: int, few: int
) -> None:
    """However much room there is for moves, however often the kernels come back, and whether they sift first."""
    acyclic = [{(a, t) for a, t in row if a != TAU or t < s} for s, row in enumerate(rows)]
    divergent = np.array([s % 3 == 0 for s in range(len(rows))])
    apart = [2 * int(d) + e for d, e in zip(divergent, ended(acyclic), strict=True)]
    expected = obvious_classes(abstract_moves(acyclic, after=after), apart)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bisimulation, "SLICE", slice_)
        patch.setattr(bisimulation, "SLICES", slices)
        patch.setattr(bisimulation, "FEW", few)
        found = tau_abstracting_partition(lts(acyclic), divergent, taus_after=after, most=most)
    assert found.tolist() == [list(dict.fromkeys(expected)).index(c) for c in expected]


def obviously_branching_bisimilar(rows: Rows) -> set[tuple[int, int]]:
    """The greatest relation: what one does at once the other does after taus that leave it related."""
    states = range(len(rows))
    apart = [(diverges(rows, frozenset({s})), e) for s, e in zip(states, ended(rows), strict=True)]
    related = {(s, t) for s in states for t in states if apart[s] == apart[t]}

    def can_follow(s: int, label: int, target: int, t: int) -> bool:
        if label == TAU and (target, t) in related:
            return True
        return any((s, u) in related and a == label and (target, v) in related for u in reach[t] for a, v in rows[u])

    reach = [taus_from(rows, s) for s in states]
    while True:
        kept = {
            (s, t)
            for s, t in related
            if all(can_follow(s, a, u, t) for a, u in rows[s]) and all(can_follow(t, a, u, s) for a, u in rows[t])
        }
        if kept == related:
            return related
        related = kept


@given(rows=machines(states=7, events=2))
def test_the_branching_quotient_is_as_small_as_the_fixpoint(rows: Rows) -> None:
    related = obviously_branching_bisimilar(rows)
    classes = {min(t for t in range(len(rows)) if (s, t) in related) for s in range(len(rows))}
    found = branching_bisimulation(strong_bisimulation(lts(rows)))

    assert found.states == len(classes)
    assert refinement_violation(rows, rows_of(found), "FD") is None
    assert refinement_violation(rows_of(found), rows, "FD") is None


@given(rows=machines(states=8, events=2), name=st.sampled_from(("wbisim", "dbisim")))
def test_what_is_branching_bisimilar_may_be_put_together_first(rows: Rows, name: str) -> None:
    expected = rows_of(COMPRESSIONS[name](lts(rows)))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bisimulation, "FEW", 0)
        assert rows_of(COMPRESSIONS[name](lts(rows))) == expected


@given(rows=machines(states=8, events=3))
def test_diamonds_may_be_removed_a_state_at_a_time(rows: Rows) -> None:
    expected = rows_of(COMPRESSIONS["diamond"](lts(rows)))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compression, "MOST", 0)
        assert rows_of(COMPRESSIONS["diamond"](lts(rows))) == expected


def sparse(states: int, seed: int) -> Lts:
    """A machine of so many states, all of them reachable, with taus that lead on and back."""
    numbers = np.random.default_rng(seed)
    starts = np.concatenate([np.arange(states), numbers.integers(0, states, states)])
    targets = np.concatenate([(np.arange(states) + 1) % states, numbers.integers(0, states, states)])
    targets[states:] = np.where(numbers.random(states) < 0.5, targets[states:], starts[states:] // 2)
    labels = np.concatenate([np.arange(states) % 3 + 2, numbers.choice([TAU, A, B], states)])
    return machine(states, starts, labels, targets)


@pytest.mark.parametrize("name", sorted(set(COMPRESSIONS) - {"normal", "lazynorm"}))
def test_machine_code_does_what_interpreted_kernels_do(name: str) -> None:
    found = []
    for compiled in (False, True):
        with pytest.MonkeyPatch.context() as patch:
            for module in (bisimulation, partition):
                patch.setattr(module, "kernels_for", lambda rows, compiled=compiled: kernels(compiled))
            for module in (bisimulation, compression):
                patch.setattr(module, "tau_kernels_for", lambda rows, compiled=compiled: tau_kernels(compiled))
            patch.setattr(bisimulation, "SATURATED", 1000)
            patch.setattr(bisimulation, "SLICE", 1000)
            patch.setattr(compression, "MOST", 100)
            found.append(COMPRESSIONS[name](sparse(400, 1)))
    assert rows_of(found[0]) == rows_of(found[1])


@pytest.mark.parametrize("name", sorted(COMPRESSIONS))
def test_what_would_take_too_much_memory_is_not_begun(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A memory limit is asked before each array that a machine of some size would have; nothing is left behind."""
    lts = sparse(60, 2)
    expected = rows_of(COMPRESSIONS[name](lts))
    left = 0

    def asked(more: int) -> None:
        nonlocal left
        left -= 1
        if left == 0:
            raise Stopped

    monkeypatch.setattr(guard, "LARGE", 0)
    monkeypatch.setattr(guard._watcher, "afford", asked)
    COMPRESSIONS[name](lts)
    times = -left
    assert times >= 2  # for what a machine is partitioned with, and for the machine that comes out

    for number in range(1, times + 1, max(1, times // 10)):
        left = number
        with pytest.raises(Stopped):
            COMPRESSIONS[name](lts)
    left = 0
    assert rows_of(COMPRESSIONS[name](lts)) == expected


def test_a_long_chain_is_partitioned_without_looking_at_all_of_it_in_every_round() -> None:
    length = 200_000
    states = np.arange(length)
    chain = machine(length + 1, states, np.full(length, A), states + 1)

    assert coarsest_partition(chain, np.zeros(length + 1)).max() == length


def test_many_states_are_told_apart_as_the_obvious_rounds_do() -> None:
    rng = np.random.default_rng(1)
    size, moves = 20_000, 30_000
    large = machine(size, rng.integers(0, size, moves), rng.integers(A, B + 1, moves), rng.integers(0, size, moves))
    rows = [set(large.successors(state)) for state in range(size)]

    found = coarsest_partition(large, np.zeros(size))

    assert found.max() + 1 == size_of(obvious_classes(rows, [0] * size))


def test_a_long_row_of_taus_becomes_one_state() -> None:
    length = 4_000
    states = np.arange(length)
    row = machine(length + 1, states, np.full(length, TAU), states + 1)

    for name in ("wbisim", "dbisim", "diamond", "normal", "model_compress"):
        assert COMPRESSIONS[name](row).states == 1


def test_states_that_only_taus_lead_to_disappear_from_a_diamond() -> None:
    """tau; a and a; tau around the same square leave one a."""
    square: Rows = [{(TAU, 1), (A, 2)}, {(A, 3)}, {(TAU, 3)}, {(B, 0)}]

    compressed: Callable[[Lts], Lts] = COMPRESSIONS["diamond"]

    assert compressed(lts(square)).states == 2


def test_an_unstable_state_that_can_tick_does_not_come_to_diverge() -> None:
    rows: Rows = [{(TAU, 1), (TICK, 2)}, {(A, 1)}, set()]

    assert not any(tau_components(COMPRESSIONS["diamond"](lts(rows)))[1])
