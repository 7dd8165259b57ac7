"""Compositions that change their shape: networks of several formats have the states of the terms."""

from __future__ import annotations

import pytest
from hypothesis import assume, event, given, settings, strategies as st

from cspcheck.checker.network import placement
from cspcheck.checker.network.compiler import compile_network
from cspcheck.checker.network.components import ComponentMachines
from cspcheck.checker.network.formats import Formats
from cspcheck.checker.network.network import Network, Rule, Switch
from cspcheck.checker.network.placement import network_of
from cspcheck.checker.network.shapes import Ambiguous, Unsuited
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.events import TAU, TICK, EventSet
from cspcheck.cspm.process.terms import (
    SKIP,
    STOP,
    ExternalChoice,
    Hide,
    Interrupt,
    Parallel,
    Prefix,
    Process,
    Sequential,
    SlidingChoice,
    SynchronisingChoice,
    SynchronisingInterrupt,
    Throw,
)
from tests.checker.exploring import interpreted, transitions_in
from tests.checker.network.test_composition import assert_same_machine, loop
from tests.checker.terms import BASIC, CHOICE, compositions, layered, processes, reference
from tests.examples import examples

a, b, c, d, e = 2, 3, 4, 5, 6
NOTHING = EventSet()


def events(*members: int) -> EventSet:
    return EventSet.of(members)


def interleaved(*operands: Process) -> Process:
    return Parallel(NOTHING, operands)


def of_formats(process: Process, small: int = 0) -> Network:
    """The network of formats of a process however small it is; terms of at most *small* states are left whole."""
    semantics = Semantics()
    return network_of(Formats(process, semantics, ComponentMachines(semantics), small, 5_000), semantics.heads)


CHANGING = layered(size=6)
ABOVE_COMPOSITIONS = [
    Sequential,
    Throw,
    Interrupt,
    SynchronisingInterrupt,
    ExternalChoice,
    SlidingChoice,
    SynchronisingChoice,
    Hide,
]


class TestSameMachine:
    @settings(max_examples=examples(200), deadline=None)
    @given(
        st.one_of(CHANGING, CHANGING, processes(size=10), compositions(size=6)), st.sampled_from([0, 1, 2, 4, 8, 30])
    )
    def test_in_formats(self, process: Process, small: int) -> None:
        def compile_it(process: Process) -> Network:
            try:
                network = of_formats(process, small)
            except Unsuited as reason:
                event(f"unsuited: {reason}")
                assume(False)
            event(f"{min(network.formats, 5)} formats")
            return network

        assert_same_machine(process, compile_it)

    @pytest.mark.parametrize(
        "operator",
        [
            Sequential,
            Throw,
            Interrupt,
            SynchronisingInterrupt,
            ExternalChoice,
            SlidingChoice,
            SynchronisingChoice,
            Hide,
        ],
        ids=lambda operator: operator.__name__,
    )
    @settings(max_examples=examples(40), deadline=None)
    @given(data=st.data())
    def test_of_each_operator_over_compositions(self, operator: type[Process], data: st.DataObject) -> None:
        layers = (BASIC | CHOICE, frozenset({Parallel}), frozenset({operator}))
        assert_same_machine(data.draw(layered(layers=layers, size=5)), self.in_formats)

    @staticmethod
    def in_formats(process: Process) -> Network:
        try:
            return of_formats(process)
        except Unsuited:
            assume(False)
            raise

    @settings(max_examples=examples(100), deadline=None)
    @given(CHANGING)
    def test_where_holes_of_different_formats_share_slots(self, process: Process) -> None:
        def compile_it(process: Process) -> Network:
            semantics = Semantics()
            try:
                formats = Formats(process, semantics, ComponentMachines(semantics), 0, 5_000)
            except Unsuited:
                assume(False)
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(placement, "WORD_BITS", 1)
                return network_of(formats, semantics.heads)

        assert_same_machine(process, compile_it)

    @settings(max_examples=examples(100), deadline=None)
    @given(CHANGING)
    def test_whatever_way_is_taken(self, process: Process) -> None:
        assert_same_machine(process, lambda p: compile_network(p, slot_states=2))


A, B = loop(a, 2, "A"), loop(c, 2, "B")
AB = interleaved(A, B)
"""Two loops of two events side by side: 4 states, 8 transitions."""


class TestShapes:
    def test_sequential_composition_of_parallels(self) -> None:
        """2 x 2 states until both have ended, then the same again, joined; its end is one more state."""
        first = interleaved(prefix(a, SKIP), prefix(b, SKIP))
        second = Parallel(events(a), (prefix(a, prefix(b, SKIP)), prefix(a, prefix(c, SKIP))))
        process = Sequential(first, second)
        network = of_formats(process)
        rows = interpreted(network)
        assert (network.formats, len(network.slots)) == (3, 4)
        assert (len(rows), transitions_in(rows)) == (4 + 5 + 1, 4 + 1 + 5 + 1)
        assert_same_machine(process, of_formats)

    def test_a_prefix_before_a_parallel(self) -> None:
        process = prefix(e, AB)
        network = of_formats(process)
        assert network.formats == 2
        assert len(interpreted(network)) == 1 + 4
        switching = [rule for rule in network.rules if rule.switch is not None]
        assert switching == [
            Rule(
                result=e,
                moves=((0, network.first_private_label),),
                cause=e,
                format=0,
                switch=Switch(1, cleared=(0,), started=((1, 0), (2, 0))),
            )
        ]
        assert network.private_labels == (e,)

    def test_hidden_events_are_told_in_every_format(self) -> None:
        both = Parallel(events(a), (loop(a, 2, "A"), loop(a, 2, "A'")))
        process = Hide(Sequential(interleaved(prefix(e, SKIP), prefix(d, SKIP)), both), events(a, e))
        network = of_formats(process)
        assert [sorted((rule.result, rule.cause) for rule in network.rules if rule.format == i) for i in (0, 1)] == [
            [(TAU, TAU), (TAU, e), (d, d)],
            [(TAU, a), (b, b), (b, b)],
        ]

    def test_a_choice_between_parallels(self) -> None:
        process = ExternalChoice((AB, interleaved(loop(e, 3, "C"), STOP)))
        network = of_formats(process)
        assert network.formats == 2, "both operands are two components side by side"
        rows = interpreted(network)
        assert len(rows) == 1 + 4 + 3
        assert_same_machine(process, of_formats)

    def test_an_interrupt_that_starts_anew(self) -> None:
        system = reference("System", lambda: Interrupt(AB, prefix(e, system)))
        network = of_formats(system)
        assert network.formats == 1
        assert [slot.name for slot in network.slots] == ["A", "B", "part 3"]
        rows = interpreted(network)
        assert (len(rows), transitions_in(rows)) == (4, 8 + 4)

    def test_an_interrupt_with_steps_in_between(self) -> None:
        system = reference("System", lambda: Interrupt(AB, prefix(e, prefix(e + 1, system))))
        rows = interpreted(of_formats(system))
        assert (len(rows), transitions_in(rows)) == (5, 8 + 4 + 1)

    def test_a_synchronising_interrupt(self) -> None:
        tock = 9
        ticking = reference("Ticking", lambda: Prefix(((a, ticking), (tock, ticking))))
        timer = prefix(tock, prefix(tock, prefix(e, AB)))
        system = SynchronisingInterrupt(Parallel(events(tock), (ticking, ticking)), events(tock), timer)
        network = of_formats(system)
        rows = interpreted(network)
        assert (network.formats, len(rows), transitions_in(rows)) == (2, 3 + 4, 3 + 2 + 1 + 8)
        assert_same_machine(system, of_formats)

    def test_an_exception_leaves_everything_behind(self) -> None:
        system = Throw(AB, events(d), prefix(e, STOP))
        network = of_formats(system)
        assert network.formats == 2
        assert {rule.result for rule in network.rules if rule.switch is not None} == {d}
        rows = interpreted(network)
        assert (len(rows), transitions_in(rows)) == (4 + 2, 8 + 1)
        assert_same_machine(system, of_formats)

    def test_a_round_that_comes_back_to_the_same_format(self) -> None:
        round_ = reference("Round", lambda: Sequential(interleaved(prefix(a, SKIP), prefix(b, SKIP)), round_))
        network = of_formats(round_)
        assert network.formats == 1
        (again,) = [rule for rule in network.rules if rule.switch is not None]
        assert again.result == TAU
        assert again.switch == Switch(0, cleared=(0, 1), started=((0, 0), (1, 0)))
        rows = interpreted(network)
        assert (len(rows), transitions_in(rows)) == (4, 5)

    def test_partners_stay_where_they_are_when_one_changes(self) -> None:
        process = interleaved(Parallel(events(e), (prefix(e, AB), loop(e, 2, "C"))), prefix(9, STOP))
        network = of_formats(process)
        assert network.formats == 2
        (switch,) = {rule.switch for rule in network.rules} - {None}
        assert switch is not None
        assert (switch.cleared, len(switch.started)) == ((0,), 2)
        assert_same_machine(process, of_formats)

    def test_two_that_change_together(self) -> None:
        process = Parallel(events(e), (prefix(e, AB), prefix(e, interleaved(loop(7, 2), STOP))))
        network = of_formats(process)
        assert network.formats == 2
        assert len(interpreted(network)) == 1 + 4 * 2

    def test_an_operator_over_what_has_no_parts_any_more_is_part_of_the_component(self) -> None:
        """The hidden rest of the first way is the second way, and one state with it."""
        ending = Sequential(interleaved(prefix(a, SKIP), SKIP), prefix(b, STOP))
        hidden = events(c)
        process = Prefix(((d, Hide(ending, hidden)), (e, Hide(prefix(b, STOP), hidden))))
        network = of_formats(process)
        assert network.formats == 2
        assert len(interpreted(network)) == 1 + 2 + 2
        assert_same_machine(process, of_formats)

    def test_termination_in_some_format_is_the_last_format(self) -> None:
        process = prefix(e, interleaved(prefix(a, SKIP), SKIP))
        network = of_formats(process)
        assert network.terminated
        assert network.formats == 3
        assert {rule.switch for rule in network.rules if rule.result == TICK} == {Switch(2, (1, 2), ())}

    def test_components_left_small_are_states_of_their_component(self) -> None:
        process = interleaved(prefix(e, interleaved(prefix(a, STOP), prefix(b, STOP))), prefix(c, AB))
        assert of_formats(process, small=0).formats == 4
        assert of_formats(process, small=4).formats == 1
        for small in (0, 4):
            assert_same_machine(process, lambda p, small=small: of_formats(p, small))

    def test_operators_over_small_compositions_are_components(self) -> None:
        process = interleaved(Sequential(interleaved(prefix(a, SKIP), SKIP), STOP), prefix(c, AB))
        assert of_formats(process, small=0).formats == 4
        assert of_formats(process, small=3).formats == 2
        for small in (0, 3):
            assert_same_machine(process, lambda p, small=small: of_formats(p, small))

    def test_a_term_reached_whole_and_in_parts_would_be_two_states(self) -> None:
        parts = interleaved(prefix(a, STOP), prefix(b, STOP))
        process = Prefix(((c, interleaved(prefix(e, parts), AB)), (d, interleaved(parts, AB))))
        with pytest.raises(Ambiguous):
            of_formats(process, small=4)
        assert_same_machine(process, of_formats)
        assert_same_machine(process)

    def test_an_interrupt_that_may_terminate_in_company_has_no_formats(self) -> None:
        process = interleaved(Interrupt(interleaved(SKIP, SKIP), prefix(a, STOP)), STOP)
        with pytest.raises(Unsuited):
            of_formats(process)
        assert_same_machine(process)


class TestLarge:
    """What is large is found to need formats, and names its components."""

    SYSTEM = interleaved(*[loop(10 + 3 * i, 3, f"L{i}") for i in range(8)])
    STATES = 3**8

    @pytest.mark.parametrize(
        ("around", "states"),
        [
            (lambda s: prefix(a, s), STATES + 1),
            (lambda s: Interrupt(s, prefix(a, STOP)), STATES + 1),
            (lambda s: Throw(s, events(10), prefix(a, STOP)), STATES // 3 + 2),
            (lambda s: ExternalChoice((prefix(a, s), prefix(b, s))), STATES + 1),
            (lambda s: Sequential(interleaved(prefix(a, SKIP), prefix(b, SKIP)), s), STATES + 4),
        ],
    )
    def test_systems_inside_something(self, around: object, states: int) -> None:
        assert callable(around)
        network = compile_network(around(self.SYSTEM))
        assert {f"L{i}" for i in range(8)} <= {slot.name for slot in network.slots}
        assert max(slot.lts.states for slot in network.slots) <= 5
        assert len(interpreted(network)) == states
