"""Termination where time passes: who can terminate and offers a clock waits for the others.

The rule is asked of terms, and then networks of one format, networks of formats and compressed components are held
against the terms on random compositions with clocks.
"""

from __future__ import annotations

import pytest
from hypothesis import assume, event, given, settings, strategies as st

from cspcheck.checker.network import endings
from cspcheck.checker.network.compiler import Compiler, compile_network
from cspcheck.checker.network.components import ComponentMachines, Joined, joined_machine
from cspcheck.checker.network.formats import Formats
from cspcheck.checker.network.network import Network
from cspcheck.checker.network.placement import network_of
from cspcheck.checker.network.shapes import Unsuited
from cspcheck.checker.semantics.transitions import LimitReached, Semantics, explore, transitions
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.events import FIRST_EVENT, TAU, TICK, EventSet
from cspcheck.cspm.process.terms import (
    NO_EVENTS,
    SKIP,
    STOP,
    AlphabetisedParallel,
    ExternalChoice,
    Hide,
    LinkedParallel,
    Parallel,
    Process,
    Rename,
    Sequential,
)
from tests.checker.exploring import rows_of, strongly_bisimilar
from tests.checker.network.test_composition import assert_same_machine
from tests.checker.terms import compositions, layered, processes, timed_skip
from tests.examples import examples

tock, a, b = FIRST_EVENT, FIRST_EVENT + 1, FIRST_EVENT + 2
CLOCK = EventSet.of([tock])
TSKIP = timed_skip(tock)
LATER = prefix(tock, TSKIP)


def in_step(*operands: Process) -> Process:
    """``P ||| Q`` in a Timed section."""
    return Parallel(CLOCK, operands, CLOCK)


def offered(process: Process) -> list[int]:
    return [event for event, _ in transitions(process)]


class TestRule:
    def test_who_waits_does_not_terminate_alone(self) -> None:
        """Without the rule there is a tau, by which the left ends and can no longer let time pass."""
        assert offered(in_step(TSKIP, LATER)) == [tock]
        assert offered(Parallel(CLOCK, (TSKIP, LATER))) == [TAU, tock]

    def test_all_that_wait_end_together(self) -> None:
        assert offered(in_step(TSKIP, TSKIP)) == [TICK, tock]

    def test_one_that_has_terminated_and_one_that_waits(self) -> None:
        assert offered(Parallel(CLOCK, (SKIP, TSKIP), CLOCK)) == [TICK]
        assert offered(Parallel(NO_EVENTS, (SKIP, TSKIP), CLOCK)) == [TICK, tock]

    def test_who_waits_keeps_what_it_can_do(self) -> None:
        busy = ExternalChoice((TSKIP, prefix(a, STOP)))
        assert offered(in_step(busy, LATER)) == [tock, a]

    def test_a_deadline_that_has_come_ends_alone(self) -> None:
        """Who can tick and refuses to let time pass stops time, as anywhere."""
        urgent = ExternalChoice((SKIP, prefix(a, STOP)))
        assert offered(in_step(urgent, LATER)) == [TAU, a]

    @pytest.mark.parametrize(
        "composition",
        [
            AlphabetisedParallel((CLOCK, CLOCK), (TSKIP, LATER), CLOCK),
            Parallel(NO_EVENTS, (TSKIP, LATER), CLOCK),
            LinkedParallel(TSKIP, ((a, b),), LATER, CLOCK),
        ],
        ids=["alphabetised", "interleaved", "linked"],
    )
    def test_under_every_parallel_operator(self, composition: Process) -> None:
        assert TAU not in offered(composition)
        assert TICK not in offered(composition)

    def test_a_composition_waits_like_any_other_process(self) -> None:
        both = in_step(TSKIP, TSKIP)
        assert offered(in_step(both, LATER)) == [tock]
        assert offered(in_step(Hide(both, CLOCK), LATER)) == [TAU, TAU]  # the hidden tock, and its end
        assert offered(in_step(Rename(ExternalChoice((SKIP, prefix(a, STOP))), ((a, tock),)), LATER)) == [tock]

    def test_what_follows_starts_when_all_can_end(self) -> None:
        assert offered(Sequential(in_step(TSKIP, TSKIP), prefix(a, STOP))) == [TAU, tock]

    def test_left_out_clocks_are_none(self) -> None:
        assert Parallel(CLOCK, (TSKIP, LATER)) is Parallel(CLOCK, (TSKIP, LATER), NO_EVENTS)


class TestSameMachine:
    @settings(max_examples=examples(150), deadline=None)
    @given(compositions(size=5, components=4, clocks=CLOCK))
    def test_of_one_format(self, process: Process) -> None:
        assert_same_machine(process)

    @settings(max_examples=examples(100), deadline=None)
    @given(st.one_of(compositions(size=5, components=4, clocks=CLOCK), layered(size=5, clocks=CLOCK)))
    def test_of_small_components(self, process: Process) -> None:
        """Components of more than a few states are taken apart if they can be."""
        assert_same_machine(process, lambda term: Compiler(slot_states=3).network(term, Limits(states=5_000)))

    @settings(max_examples=examples(150), deadline=None)
    @given(st.one_of(layered(size=6, clocks=CLOCK), processes(size=10, clocks=CLOCK)), st.sampled_from([0, 0, 2, 8]))
    def test_of_formats(self, process: Process, small: int) -> None:
        def compile_it(term: Process) -> Network:
            semantics = Semantics()
            try:
                return network_of(Formats(term, semantics, ComponentMachines(semantics), small, 5_000), semantics.heads)
            except Unsuited as reason:
                event(f"unsuited: {reason}")
                assume(False)
                raise

        assert_same_machine(process, compile_it)

    @settings(max_examples=examples(100), deadline=None)
    @given(processes(size=8, clocks=CLOCK))
    def test_of_a_machine_under_a_parallel_operator(self, process: Process) -> None:
        try:
            alone = explore(process, Limits(states=300)).lts
        except LimitReached:
            assume(False)
        semantics = Semantics()
        joined = ComponentMachines(semantics).of(semantics.state(process), Joined(CLOCK), 1_000).lts
        assert strongly_bisimilar(rows_of(joined), rows_of(joined_machine(alone, CLOCK)))


class TestTakenApart:
    """A composition under another is taken apart only where none of its states can end before the others."""

    def test_if_all_of_it_waits(self) -> None:
        assert len(compile_network(in_step(in_step(TSKIP, LATER), prefix(a, LATER))).slots) == 3

    def test_not_if_one_has_terminated_and_another_waits(self) -> None:
        mixed = Parallel(CLOCK, (prefix(a, SKIP), ExternalChoice((TSKIP, prefix(b, STOP)))), CLOCK)
        assert len(compile_network(in_step(mixed, LATER)).slots) == 2
        assert len(compile_network(mixed).slots) == 2

    def test_not_if_its_clock_is_hidden_or_made(self) -> None:
        both = in_step(TSKIP, LATER)
        assert len(compile_network(in_step(Hide(both, CLOCK), LATER)).slots) == 2
        assert len(compile_network(in_step(Hide(both, EventSet.of([a])), LATER)).slots) == 3

    def test_endings_of_operators(self) -> None:
        waiting, over = frozenset({CLOCK}), frozenset({None})
        assert endings.together(in_step(STOP, SKIP), [waiting, waiting]) == waiting
        assert endings.together(in_step(STOP, SKIP), [over, over]) == over
        assert endings.together(in_step(STOP, SKIP), [over, waiting]) == {NO_EVENTS}
        assert endings.together(Parallel(NO_EVENTS, (STOP, SKIP), CLOCK), [over, waiting]) == waiting
        assert endings.together(in_step(STOP, SKIP), [frozenset(), waiting]) == frozenset()

    def test_nor_in_formats(self) -> None:
        mixed = Parallel(CLOCK, (prefix(a, SKIP), ExternalChoice((TSKIP, prefix(b, STOP)))), CLOCK)
        semantics = Semantics()
        with pytest.raises(Unsuited, match="before the others"):
            Formats(Sequential(in_step(mixed, LATER), STOP), semantics, ComponentMachines(semantics), 0, 5_000)
