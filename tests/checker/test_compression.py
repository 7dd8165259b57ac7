"""Every compression means what its operand means, and a quotient is as small as an obvious fixpoint says."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from checker.bisimulation import coarsest_partition, tau_components
from checker.compression import COMPRESSIONS
from checker.lts import Lts
from cspm.events import TAU, TICK
from tests.checker.explicit import A, B, Rows, diverges, lts, machines, refinement_violation

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


def size(classes: Iterable[int]) -> int:
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
    assert COMPRESSIONS["sbisim"](lts(rows)).states == size(obvious_classes(rows, [0] * len(rows)))


@pytest.mark.parametrize(("name", "after"), [("wbisim", True), ("dbisim", False)])
@given(rows=machines(states=8, events=2))
def test_the_weak_quotients_are_as_small_as_the_fixpoint(name: str, after: bool, rows: Rows) -> None:
    divergent = [int(diverges(rows, frozenset({state}))) for state in range(len(rows))]
    classes = obvious_classes(abstract_moves(rows, after=after), divergent)

    assert COMPRESSIONS[name](lts(rows)).states == size(classes)


@given(rows=machines(states=8, events=2), initial=st.lists(st.integers(0, 2), min_size=9, max_size=9))
def test_a_partition_refines_its_initial_one_and_equals_the_fixpoint(rows: Rows, initial: list[int]) -> None:
    initial = initial[: len(rows)]

    found = coarsest_partition(rows, initial)

    expected = obvious_classes(rows, initial)
    assert found == [list(dict.fromkeys(expected)).index(c) for c in expected]


@given(rows=machines(states=8, events=1))
def test_components_of_taus_are_mutually_reachable_states_in_reverse_order(rows: Rows) -> None:
    components, diverging = tau_components(lts(rows))

    reach = [taus_from(rows, state) for state in range(len(rows))]
    for s in range(len(rows)):
        assert diverging[s] == diverges(rows, frozenset({s}))
        for t in range(len(rows)):
            assert (components[s] == components[t]) == (t in reach[s] and s in reach[t])
            assert t not in reach[s] or components[t] <= components[s]


def test_a_long_chain_is_partitioned_without_looking_at_all_of_it_in_every_round() -> None:
    length = 20_000
    rows: Rows = [{(A, state + 1)} for state in range(length)] + [set()]

    assert size(coarsest_partition(rows, [0] * len(rows))) == length + 1


def test_states_that_only_taus_lead_to_disappear_from_a_diamond() -> None:
    """tau; a and a; tau around the same square leave one a."""
    square: Rows = [{(TAU, 1), (A, 2)}, {(A, 3)}, {(TAU, 3)}, {(B, 0)}]

    compressed: Callable[[Lts], Lts] = COMPRESSIONS["diamond"]

    assert compressed(lts(square)).states == 2


def test_an_unstable_state_that_can_tick_does_not_come_to_diverge() -> None:
    rows: Rows = [{(TAU, 1), (TICK, 2)}, {(A, 1)}, set()]

    assert not any(tau_components(COMPRESSIONS["diamond"](lts(rows)))[1])
