"""Packing a network: nothing overlaps, nothing is lost, and a state looks only at what concerns it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.checker.kernels.arrays import MAY_BRANCH, MAY_REPEAT, WORD_BITS, Index
from cspcheck.checker.lts import Lts
from cspcheck.checker.network.network import Network, Rule, Slot, Switch
from cspcheck.checker.packing.layout import lay_out
from cspcheck.checker.packing.packed import PackedNetwork, pack
from cspcheck.checker.search.exploration import explore, successors
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.process.events import FIRST_EVENT, TAU, TICK
from tests.checker.networks import Explorer, networks, slot, wide_slot
from tests.checker.vehicle import cycle, synchronised, vehicle
from tests.examples import examples

A, B, C = FIRST_EVENT, FIRST_EVENT + 1, FIRST_EVENT + 2

checked = settings(max_examples=examples(100), deadline=None)


def with_states(*sizes: int, formats: int = 1) -> Network:
    """A network of slots with so many states, and no rules."""
    return Network(tuple(wide_slot(f"W{i}", size, A, set()) for i, size in enumerate(sizes)), (), formats)


class TestLayout:
    @checked
    @given(sizes=st.lists(st.integers(1, 1 << 40), max_size=12), formats=st.integers(1, 50))
    def test_fields_are_apart_and_within_words(self, sizes: list[int], formats: int) -> None:
        layout = lay_out(_narrow(sizes, formats))
        used = [0] * layout.words
        for field, size in zip((layout.format, *layout.slots), (formats, *sizes), strict=True):
            assert (1 << field.width) >= size > (1 << field.width) >> 1
            assert field.shift + field.width <= WORD_BITS
            assert not used[field.word] & field.mask
            used[field.word] |= field.mask
        assert all(used[1:])

    @pytest.mark.parametrize(
        ("bits", "words"), [([], 1), ([63], 1), ([32, 32], 2), ([21] * 3, 1), ([20, 43, 20, 43, 20, 43], 3)]
    )
    def test_words_are_few(self, bits: list[int], words: int) -> None:
        assert lay_out(_narrow([1 << b for b in bits], 1)).words == words

    @checked
    @given(
        data=st.data(), sizes=st.lists(st.sampled_from([1, 2, 3, 200, 70_000]), max_size=8), formats=st.integers(1, 5)
    )
    def test_states_are_read_as_they_were_written(self, data: st.DataObject, sizes: list[int], formats: int) -> None:
        packed = pack(with_states(*sizes, formats=formats))
        format = data.draw(st.integers(0, formats - 1))
        local = tuple(data.draw(st.integers(0, size - 1)) for size in sizes)
        state = packed.pack(format, local)
        assert (packed.format(state), packed.local_states(state)) == (format, local)
        assert (state >= 0).all()


class _Sized(Lts):
    """A machine that only knows how many states it would have."""

    __slots__ = ("size",)
    size: int

    @property
    def states(self) -> int:
        return self.size


def _narrow(sizes: list[int], formats: int) -> Network:
    """A network whose slots are as large as is said, without transitions."""
    slots = []
    for i, size in enumerate(sizes):
        none = np.zeros(0, dtype=np.int64)
        lts = _Sized(np.zeros(2, dtype=np.int64), none, none)
        object.__setattr__(lts, "size", size)
        slots.append(Slot(f"S{i}", None, lts, ()))
    return Network(tuple(slots), (), formats)


def looked_at(index: Index, state: np.ndarray) -> list[int]:
    """The items that the lists of a state's homes name."""
    items: list[int] = []
    for home in range(len(index.word)):
        bits = int(state[index.word[home]]) >> int(index.shift[home]) & int(index.mask[home])
        row = int(index.base[home]) + bits
        items += index.items[index.offsets[row] : index.offsets[row + 1]].tolist()
    return items


class TestIndex:
    @checked
    @given(network=st.one_of(networks(), networks(most_formats=3)), limit=st.sampled_from([0, 2, 4096]))
    def test_a_state_looks_at_each_candidate_once(self, network: Network, limit: int) -> None:
        packed = pack(network, instances_per_rule=limit)
        for state in Explorer(network).moves:
            for index in (packed.tau, packed.visible):
                items = looked_at(index, packed.pack(*state))
                assert len(set(items)) == len(items)

    def test_a_state_looks_at_little_more_than_fires(self) -> None:
        packed = pack(vehicle())
        some = explore(pack(vehicle()), limits=_some()).states
        looked = sum(len(looked_at(packed.visible, state)) for state in some)
        assert looked <= 1.35 * successors(packed, some).offsets[-1]

    def test_homes_are_of_single_fields_where_shared_ones_would_list_too_much(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        packed = pack(vehicle())
        monkeypatch.setattr("cspcheck.checker.packing.packed.LISTED", 100)
        apart = pack(vehicle())
        assert len(packed.visible.word) == 4
        assert len(apart.visible.word) > 8
        assert explore(apart, limits=_some()).levels == explore(packed, limits=_some()).levels


def _some() -> Limits:
    return Limits(states=3_000)


class TestProducts:
    def rows(self, states: int, event: int) -> list[list[tuple[int, int]]]:
        """Every state can go to every state."""
        return [[(event, target) for target in range(states)] for _ in range(states)]

    def network(self, participants: int, states: int) -> Network:
        slots = tuple(slot(f"P{i}", self.rows(states, A)) for i in range(participants))
        return Network(slots, (Rule(A, tuple((i, A) for i in range(participants)), A),))

    def test_rules_with_many_instances_are_not_multiplied_out(self) -> None:
        packed = pack(self.network(5, 4))
        assert len(packed.rules.event) == 0
        assert len(packed.rules.product_event) == 1
        assert packed.participants == 5
        # Every participant has 16 transitions; 16 ** 5 instances would be a million.
        exploration = explore(packed)
        assert exploration.levels == (0, 1, 4**5)
        assert exploration.transitions == 4**5 * 4**5

    def test_rules_with_few_are(self) -> None:
        packed = pack(self.network(2, 4))
        assert len(packed.rules.event) == 4**4
        assert len(packed.rules.product_event) == 0

    def test_the_largest_stay_products_when_all_together_are_too_many(self) -> None:
        machines = (slot("P", [[(A, 0), (B, 1), (B, 0)], [(B, 0), (B, 1)]]),) * 2
        rules = (Rule(A, ((0, A), (1, A)), A), Rule(B, ((0, B), (1, B)), B))
        packed = pack(Network(machines, rules), instances=10)
        assert packed.rules.rule.tolist() == [0]
        assert packed.rules.product_rule.tolist() == [1]

    def test_rules_of_one_participant_never_are(self) -> None:
        network = Network((slot("P", self.rows(70, A)),), (Rule(A, ((0, A),), A),))
        packed = pack(network)
        assert len(packed.rules.event) == 4900
        assert explore(packed).transitions == 4900

    def test_a_cleared_participant_contributes_one_target(self) -> None:
        slots = (slot("P", self.rows(3, A)), slot("Q", self.rows(2, A)))
        rule = Rule(A, ((0, A), (1, A)), A, 0, Switch(1, (0,), ()))
        for limit in (0, 4096):
            packed = pack(Network(slots, (rule,), 2), instances_per_rule=limit)
            assert explore(packed).transitions == 2


class TestForesight:
    """What can be said of all states beforehand costs nothing in the search."""

    def care(self, network: Network) -> dict[int, int]:
        packed = pack(network)
        return {int(event): int(care) for event, care in zip(packed.events, packed.rules.care, strict=True) if care}

    def test_deterministic_components_in_parallel_need_no_care(self) -> None:
        assert self.care(vehicle()) == {}

    def test_two_choices_of_one_event_may_branch(self) -> None:
        network = Network((slot("P", [[(A, 0), (A, 1)], []]),), (Rule(A, ((0, A),), A),))
        assert self.care(network) == {A: MAY_BRANCH}

    def test_two_events_renamed_to_one_may_branch_but_not_repeat(self) -> None:
        """The equal instances of rules with the same participants have been dropped."""
        machine = slot("P", [[(A, 1), (B, 1)], []])
        network = Network((machine,), (Rule(C, ((0, A),), A), Rule(C, ((0, B),), B)))
        assert self.care(network) == {C: MAY_BRANCH}
        assert explore(pack(network)).transitions == 1
        assert not explore(pack(network)).branching

    def test_events_that_are_never_possible_together_need_no_care(self) -> None:
        machine = slot("P", [[(A, 1)], [(B, 0)]])
        network = Network((machine,), (Rule(C, ((0, A),), A), Rule(C, ((0, B),), B)))
        assert self.care(network) == {}

    def test_idle_steps_of_different_components_may_repeat(self) -> None:
        machine = slot("P", [[(A, 0)]])
        network = Network((machine, machine), (Rule(A, ((0, A),), A), Rule(A, ((1, A),), A)))
        assert self.care(network) == {A: MAY_REPEAT | MAY_BRANCH}
        assert explore(pack(network)).transitions == 1

    def test_taus_that_pass_through_a_component_once_cannot_go_round(self) -> None:
        """Two cyclic buffers: what they hand over is silent, and each needs its environment before the next."""
        packed = pack(synchronised({"P": cycle("in", "mid"), "Q": cycle("mid", "out")}, silent={"mid"}))
        assert len(packed.tau.items) > 0
        assert len(packed.cycling.items) == 0

    def test_taus_that_need_a_finished_component_cannot_go_round_either(self) -> None:
        """Q could go round, but only together with P, which cannot."""
        packed = pack(synchronised({"P": [(0, "a", 1)], "Q": cycle("a")}, silent={"a"}))
        assert len(packed.cycling.items) == 0

    def test_taus_of_a_silent_cycle_can(self) -> None:
        packed = pack(synchronised({"P": cycle("a", "b"), "Q": cycle("b", "c")}, silent={"a", "b", "c"}))
        assert len(packed.cycling.items) == len(packed.tau.items)

    @checked
    @given(network=networks(most_formats=3))
    def test_no_cycle_of_taus_is_overlooked(self, network: Network) -> None:
        expected = Explorer(network)
        if expected.tau_cyclic(expected.moves):
            assert len(pack(network).cycling.items) > 0


class TestTermination:
    def test_the_state_after_tick_is_known(self) -> None:
        ticking = slot("P", [[(A, 0), (TICK, 1)], []])
        network = Network((ticking, ticking), (Rule(TICK, ((0, TICK), (1, TICK)), TICK),), terminated=True)
        packed: PackedNetwork = pack(network)
        assert packed.is_terminated(packed.pack(0, (1, 1)))
        assert not packed.is_terminated(packed.pack(0, (1, 0)))
        exploration = explore(packed)
        assert exploration.levels[-1] == 2
        assert exploration.deadlock_level is None

    def test_with_several_formats_it_is_the_empty_last_one(self) -> None:
        machine = slot("P", [[(A, 1)], [(TICK, 1)]])
        rules = (Rule(A, ((0, A),), A), Rule(TICK, ((0, TICK),), TICK, 0, Switch(1, (0,), ())))
        packed = pack(Network((machine,), rules, 2, terminated=True))
        assert packed.is_terminated(packed.pack(1, (0,)))
        assert not packed.is_terminated(packed.pack(0, (0,)))
        assert explore(packed).deadlock_level is None

    def test_events_are_numbered_from_tau_and_tick(self) -> None:
        network = Network((slot("P", [[(C, 0), (A, 0)]]),), (Rule(C, ((0, C),), C), Rule(A, ((0, A),), A)))
        assert pack(network).events.tolist() == [TAU, TICK, A, C]
