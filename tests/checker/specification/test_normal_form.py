"""A normal form says after each trace what its machine allows, accepts and risks."""

from __future__ import annotations

from unittest import mock

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.checker.lts import Lts
from cspcheck.checker.specification import normaliser
from cspcheck.checker.specification.acceptances import divergent_states
from cspcheck.checker.specification.normal_form import NormalForm
from cspcheck.checker.specification.normalisation import is_deterministic, minimised, normalise
from cspcheck.checker.specification.normaliser import Normaliser
from cspcheck.cspm.process.events import TAU, TICK
from tests.checker import explicit
from tests.checker.explicit import A, B, C, Rows, lts, machines

MODELS = ("T", "F", "FD")


def says(normal_form: NormalForm, node: int) -> tuple[object, ...]:
    return (
        bool(normal_form.divergent[node]),
        set(normal_form.allowed(node)),
        {frozenset(acceptance) for acceptance in normal_form.acceptances(node)},
    )


def should_say(rows: Rows, states: explicit.States, model: str) -> tuple[object, ...]:
    if model == "FD" and explicit.diverges(rows, states):
        return True, set(), set()
    accepts = {frozenset[int]()} if model == "T" else explicit.minimal(explicit.acceptances(rows, states))
    return False, explicit.events(rows, states), accepts


@settings(deadline=None)
@given(machines(), st.sampled_from(MODELS), st.booleans(), st.sampled_from((0, 20, 10_000)))
def test_each_node_says_what_its_traces_say(rows: Rows, model: str, minimise: bool, interpreted: int) -> None:
    """Whether compiled kernels are taken from the start, after a while, or not; and whatever the slices."""
    with (
        mock.patch.object(normaliser, "INTERPRETED", interpreted),
        mock.patch.object(normaliser, "SLICE", interpreted or 1),
        mock.patch.object(normaliser, "tau_kernels_are_loaded", return_value=False),
    ):
        normal_form = normalise(lts(rows), model, minimise=minimise)
    for trace in explicit.traces(rows, 4):
        node = normal_form.along(trace)
        assert node is not None
        if model == "FD" and any(explicit.diverges(rows, explicit.after(rows, trace[:i])) for i in range(len(trace))):
            assert normal_form.divergent[node]
        else:
            assert says(normal_form, node) == should_say(rows, explicit.after(rows, trace), model)


@settings(deadline=None)
@given(machines(), st.sampled_from(MODELS))
def test_a_trace_that_the_machine_cannot_perform_leads_nowhere(rows: Rows, model: str) -> None:
    normal_form = normalise(lts(rows), model)
    for trace in explicit.traces(rows, 3):
        if model == "FD" and explicit.first_divergence(rows) is not None:
            continue
        for event in {TICK, A, B, C} - explicit.events(rows, explicit.after(rows, trace)):
            assert normal_form.along((*trace, event)) is None


@settings(deadline=None)
@given(machines(), st.sampled_from(MODELS))
def test_minimised_normal_forms_have_one_node_for_each_residual_behaviour(rows: Rows, model: str) -> None:
    """Counted by the naive fixpoint: nodes differ when they say different things, or lead to nodes that differ."""
    large = normalise(lts(rows), model, minimise=False)
    nodes = range(large.nodes)
    same = {(m, n) for m in nodes for n in nodes if says(large, m) == says(large, n)}
    while True:
        kept = {
            (m, n)
            for m, n in same
            if all((large.after(m, event), large.after(n, event)) in same for event in large.allowed(m))
        }
        if kept == same:
            break
        same = kept
    classes = {frozenset(n for n in nodes if (m, n) in same) for m in nodes}
    assert normalise(lts(rows), model).nodes == len(classes)


@settings(deadline=None)
@given(machines())
def test_divergent_states_are_those_with_endless_taus(rows: Rows) -> None:
    expected = [explicit.diverges(rows, frozenset({s})) for s in range(len(rows))]
    assert divergent_states(lts(rows)).tolist() == expected


@settings(deadline=None)
@given(machines())
def test_determinism_of_machines_is_about_labels_and_taus(rows: Rows) -> None:
    expected = all(
        TAU not in labels and len(labels) == len(set(labels))
        for labels in ([label for label, _ in row] for row in rows)
    )
    assert is_deterministic(lts(rows)) == expected


@settings(deadline=None)
@given(machines(taus=False), st.sampled_from(MODELS))
def test_the_fast_path_and_the_subset_construction_agree(rows: Rows, model: str) -> None:
    machine = lts(rows)
    if is_deterministic(machine):
        quick = normalise(machine, model, minimise=False)
        assert quick.nodes == len(rows)
        slow = Normaliser(machine, model).all_nodes()
        for trace in explicit.traces(rows, 4):
            m, n = quick.along(trace), slow.along(trace)
            assert m is not None
            assert n is not None
            assert says(quick, m) == says(slow, n)


class TestWhatNodesSay:
    """Textbook processes, one node at a time."""

    def test_internal_choice_has_two_acceptances_where_external_choice_has_one(self) -> None:
        internal = normalise(lts([{(TAU, 1), (TAU, 2)}, {(A, 3)}, {(B, 3)}, set()]), "F")
        external = normalise(lts([{(A, 1), (B, 1)}, set()]), "F")
        assert internal.allowed(0) == external.allowed(0) == (A, B)
        assert internal.acceptances(0) == ((A,), (B,))
        assert external.acceptances(0) == ((A, B),)

    def test_acceptances_that_contain_another_are_dropped(self) -> None:
        """a -> STOP |~| (a -> STOP [] b -> STOP)."""
        choice = normalise(lts([{(TAU, 1), (TAU, 2)}, {(A, 3)}, {(A, 3), (B, 3)}, set()]), "FD")
        assert choice.acceptances(0) == ((A,),)

    def test_a_state_that_can_tick_accepts_tick_alone(self) -> None:
        """SKIP [] a -> STOP."""
        choice = normalise(lts([{(TICK, 1), (A, 2)}, set(), set()]), "F")
        assert choice.allowed(0) == (TICK, A)
        assert choice.acceptances(0) == ((TICK,),)

    def test_a_tick_beside_a_tau_can_still_happen(self) -> None:
        """SKIP [> a -> STOP: the specification may terminate instead of offering a."""
        timeout = normalise(lts([{(TICK, 1), (TAU, 2)}, set(), {(A, 3)}, set()]), "F")
        assert timeout.acceptances(0) == ((TICK,), (A,))

    def test_chaos_can_settle_for_nothing(self) -> None:
        chaos = normalise(lts([{(TAU, 1), (A, 0)}, set()]), "FD")
        assert chaos.allowed(0) == (A,)
        assert chaos.acceptances(0) == ((),)

    def test_divergence_has_no_failures_in_f_and_allows_everything_in_fd(self) -> None:
        div = lts([{(TAU, 0)}])
        assert normalise(div, "F").acceptances(0) == ()
        assert not normalise(div, "F").divergent[0]
        assert normalise(div, "FD").divergent.tolist() == [True]

    def test_nothing_is_kept_behind_a_divergence(self) -> None:
        """a -> (DIV [] b -> STOP), and c -> DIV: both divergences are one node."""
        rows: Rows = [{(A, 1), (C, 3)}, {(TAU, 1), (B, 2)}, set(), {(TAU, 3)}]
        normal_form = normalise(lts(rows), "FD", minimise=False)
        assert normal_form.nodes == 2
        assert normal_form.along((A, B, B)) == normal_form.along((C,))

    def test_states_with_taus_alone_do_not_split_nodes(self) -> None:
        """a -> tau^n -> b -> ... for different n after a and after b is one node."""
        rows: Rows = [{(A, 1), (B, 3)}, {(TAU, 2)}, {(C, 0)}, {(TAU, 1)}]
        assert normalise(lts(rows), "F", minimise=False).nodes == 2


def test_a_large_deterministic_machine_is_its_own_normal_form() -> None:
    """Two million states, in arrays: no set of states is ever built."""
    size = 2_000_000
    states = np.arange(size)
    labels = np.tile([A, B], size)
    targets = np.stack([(states + 1) % size, (states * 7) % size], axis=1).ravel()
    machine = Lts(np.arange(0, 2 * size + 1, 2), labels.astype(np.int64), targets.astype(np.int64))
    normal_form = normalise(machine, "FD", minimise=False)
    assert normal_form.nodes == size
    assert normal_form.acceptance_sets == (((0, 1),),)


def test_fifty_thousand_nodes_by_subset_construction() -> None:
    """One of two rings of 200 and 251 steps: a node is a place in each."""
    short = [{(A, 1 + (s + 1) % 200)} for s in range(200)]
    long = [{(A, 201 + (s + 1) % 251)} for s in range(251)]
    rows: Rows = [{(TAU, 1), (TAU, 201)}, *short, *long]
    normal_form = normalise(Lts.from_successors(rows), "F", minimise=False)
    assert normal_form.nodes == 200 * 251
    assert normalise(Lts.from_successors(rows), "F").nodes == 1


def test_nodes_of_many_states() -> None:
    """A ladder of taus: after n steps of a the machine can be in any state from the n-th on."""
    size = 400
    rows: Rows = [{(TAU, min(s + 1, size)), (A, min(s + 1, size))} for s in range(size)] + [{(B, 0)}]
    for model in MODELS:
        whole = normalise(lts(rows), model, minimise=False)
        assert whole.nodes == size + 1
        assert says(whole, 0) == should_say(rows, explicit.start(rows), model)
        with (
            mock.patch.object(normaliser, "INTERPRETED", 1 << 60),
            mock.patch.object(normaliser, "tau_kernels_are_loaded", return_value=False),
        ):
            assert normalise(lts(rows), model, minimise=False).targets.tolist() == whole.targets.tolist()


def test_minimisation_is_given_up_when_it_takes_too_long() -> None:
    """A chain distinguishes its states one round at a time."""
    chain = normalise(lts([{(A, s + 1)} for s in range(50)] + [{(A, 50), (B, 50)}]), "T", minimise=False)
    assert minimised(chain).nodes == 51
    doubled = lts([{(A, 1), (B, 2)}, {(A, 0)}, {(A, 0)}])
    assert minimised(normalise(doubled, "T", minimise=False)).nodes == 2
    assert minimised(normalise(doubled, "T", minimise=False), work=3).nodes == 3


def test_what_the_poll_raises_ends_the_construction() -> None:
    def enough(nodes: int) -> None:
        raise TimeoutError(nodes)

    with pytest.raises(TimeoutError):
        normalise(lts([{(TAU, 0), (A, 0)}]), "T", poll=enough)
