"""What each operator does: exact transitions, by the rules of Roscoe, *Understanding Concurrent Systems* (2010)."""

from __future__ import annotations

import pytest

from cspcheck.checker.semantics.transitions import explore, transitions
from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.events import TAU, TICK, EventSet
from cspcheck.cspm.process.terms import (
    DIV,
    SKIP,
    STOP,
    TERMINATED,
    Buffer,
    Chaos,
    Compressed,
    ExternalChoice,
    Hide,
    InternalChoice,
    Interrupt,
    Prefix,
    Prioritised,
    Process,
    Project,
    Rename,
    Run,
    Sequential,
    SlidingChoice,
    Throw,
)
from tests.checker.terms import reference

a, b, c, d = 2, 3, 4, 5
P = prefix(a, STOP)
Q = prefix(b, SKIP)
INSIDE = prefix(c, STOP)
TAU_TO_P = InternalChoice((P,))


def events(*members: int) -> EventSet:
    return EventSet.of(members)


class TestConstants:
    def test_stop_and_what_has_terminated_do_nothing(self) -> None:
        assert transitions(STOP) == ()
        assert transitions(TERMINATED) == ()

    def test_skip_ticks_and_has_terminated(self) -> None:
        assert transitions(SKIP) == ((TICK, TERMINATED),)

    def test_div_does_nothing_but_tau(self) -> None:
        assert transitions(DIV) == ((TAU, DIV),)

    def test_run_offers_all_of_its_set_for_ever(self) -> None:
        run = Run(events(b, a))
        assert transitions(run) == ((a, run), (b, run))
        assert transitions(Run(EventSet())) == ()

    def test_chaos_may_stop_at_any_time(self) -> None:
        chaos = Chaos(events(a, b))
        offering = Prefix(((a, chaos), (b, chaos)))
        assert transitions(chaos) == ((TAU, STOP), (TAU, offering))
        assert explore(chaos).lts.states == 3
        assert transitions(Chaos(EventSet())) == ((TAU, STOP),)


class TestPrefix:
    def test_each_branch_leads_to_what_follows_it(self) -> None:
        assert transitions(Prefix(((a, P), (b, Q)))) == ((a, P), (b, Q))

    def test_a_prefix_without_branches_is_stuck(self) -> None:
        assert transitions(Prefix(())) == ()

    def test_what_follows_is_unfolded(self) -> None:
        assert transitions(prefix(b, reference("P", lambda: P))) == ((b, P),)


class TestExternalChoice:
    def test_a_visible_event_resolves_the_choice(self) -> None:
        assert transitions(ExternalChoice((P, prefix(b, P)))) == ((a, STOP), (b, P))

    def test_a_tau_does_not(self) -> None:
        choice = ExternalChoice((TAU_TO_P, INSIDE))
        assert transitions(choice) == ((TAU, ExternalChoice((P, INSIDE))), (c, STOP))

    def test_a_tick_does(self) -> None:
        assert transitions(ExternalChoice((SKIP, P))) == ((TICK, TERMINATED), (a, STOP))

    def test_equal_events_leave_it_open_which_operand_goes_on(self) -> None:
        assert transitions(ExternalChoice((prefix(a, P), prefix(a, Q)))) == ((a, P), (a, Q))

    def test_one_transition_for_equal_outcomes(self) -> None:
        assert transitions(ExternalChoice((prefix(a, P), Prefix(((a, P), (b, P)))))) == ((a, P), (b, P))


class TestInternalChoice:
    def test_a_tau_to_each_operand(self) -> None:
        assert transitions(InternalChoice((P, Q, STOP))) == ((TAU, P), (TAU, Q), (TAU, STOP))

    def test_of_one_is_a_tau_before_it(self) -> None:
        assert transitions(InternalChoice((P,))) == ((TAU, P),)


class TestSlidingChoice:
    def test_a_tau_to_the_right(self) -> None:
        assert transitions(SlidingChoice(P, Q)) == ((TAU, Q), (a, STOP))

    def test_a_tau_of_the_left_keeps_the_choice(self) -> None:
        sliding = SlidingChoice(TAU_TO_P, Q)
        assert transitions(sliding) == ((TAU, SlidingChoice(P, Q)), (TAU, Q))

    def test_a_tick_of_the_left_ends_it(self) -> None:
        assert transitions(SlidingChoice(SKIP, Q)) == ((TAU, Q), (TICK, TERMINATED))


class TestInterrupt:
    def test_the_left_goes_on_under_the_interrupt(self) -> None:
        assert transitions(Interrupt(prefix(a, P), INSIDE)) == ((a, Interrupt(P, INSIDE)), (c, STOP))

    def test_the_first_event_of_the_right_takes_over(self) -> None:
        assert transitions(Interrupt(P, prefix(c, Q))) == ((a, Interrupt(STOP, prefix(c, Q))), (c, Q))

    def test_a_tau_of_the_right_does_not_take_over(self) -> None:
        assert transitions(Interrupt(STOP, TAU_TO_P)) == ((TAU, Interrupt(STOP, P)),)

    def test_a_tick_of_either_side_ends_it(self) -> None:
        assert transitions(Interrupt(SKIP, P)) == ((TICK, TERMINATED), (a, STOP))
        assert transitions(Interrupt(P, SKIP)) == ((TICK, TERMINATED), (a, Interrupt(STOP, SKIP)))


class TestThrow:
    def test_an_event_of_the_set_hands_over(self) -> None:
        assert transitions(Throw(P, events(a), Q)) == ((a, Q),)

    def test_other_events_do_not(self) -> None:
        assert transitions(Throw(prefix(b, P), events(a), Q)) == ((b, Throw(P, events(a), Q)),)

    def test_a_tau_does_not(self) -> None:
        assert transitions(Throw(TAU_TO_P, events(a), Q)) == ((TAU, Throw(P, events(a), Q)),)

    def test_termination_is_no_exception(self) -> None:
        assert transitions(Throw(SKIP, events(a), Q)) == ((TICK, TERMINATED),)


class TestSequential:
    def test_the_left_runs_first(self) -> None:
        assert transitions(Sequential(prefix(a, SKIP), P)) == ((a, Sequential(SKIP, P)),)

    def test_its_tick_is_a_tau_to_the_right(self) -> None:
        assert transitions(Sequential(SKIP, P)) == ((TAU, P),)

    def test_a_left_that_has_stopped_never_hands_over(self) -> None:
        assert transitions(Sequential(STOP, P)) == ()

    def test_a_tick_beside_other_events(self) -> None:
        left = ExternalChoice((SKIP, prefix(a, P)))
        assert transitions(Sequential(left, Q)) == ((TAU, Q), (a, Sequential(P, Q)))


class TestHidingAndRenaming:
    def test_hidden_events_are_taus(self) -> None:
        process = Prefix(((a, P), (b, P)))
        assert transitions(Hide(process, events(a))) == ((TAU, Hide(P, events(a))), (b, Hide(P, events(a))))

    def test_projection_hides_the_others(self) -> None:
        process = Prefix(((a, P), (b, P)))
        assert transitions(Project(process, events(a))) == ((TAU, Project(P, events(a))), (a, Project(P, events(a))))

    def test_renaming_is_relational(self) -> None:
        pairs = ((a, c), (a, d), (b, c))
        process = Prefix(((a, P), (b, Q)))
        renamed = Rename(P, pairs)
        assert transitions(Rename(process, pairs)) == ((c, renamed), (c, Rename(Q, pairs)), (d, renamed))

    def test_events_without_a_new_name_stay(self) -> None:
        pairs = ((a, c),)
        assert transitions(Rename(prefix(b, P), pairs)) == ((b, Rename(P, pairs)),)

    def test_an_event_renamed_to_itself_and_another(self) -> None:
        pairs = ((a, a), (a, b))
        assert transitions(Rename(P, pairs)) == ((a, Rename(STOP, pairs)), (b, Rename(STOP, pairs)))

    @pytest.mark.parametrize(
        "process", [Hide(SKIP, events(a)), Project(SKIP, events()), Rename(SKIP, ((a, b),)), Prioritised(SKIP, ())]
    )
    def test_tick_is_neither_hidden_nor_renamed(self, process: Process) -> None:
        assert transitions(process) == ((TICK, TERMINATED),)

    def test_what_is_left_of_a_hidden_skip_is_skip(self) -> None:
        assert transitions(Hide(prefix(b, SKIP), events(a))) == ((b, SKIP),)

    def test_a_tau_stays_a_tau(self) -> None:
        assert transitions(Rename(DIV, ((a, b),))) == ((TAU, Rename(DIV, ((a, b),))),)
        assert transitions(Project(DIV, events(a))) == ((TAU, Project(DIV, events(a))),)


class TestPriority:
    LEVELS = (events(a), events(b, c))

    def prioritised(self, process: Process) -> Process:
        return Prioritised(process, self.LEVELS)

    def test_a_higher_event_blocks_a_lower_one(self) -> None:
        process = Prefix(((a, P), (b, P), (c, P)))
        assert transitions(self.prioritised(process)) == ((a, self.prioritised(P)),)

    def test_events_of_one_level_live_together(self) -> None:
        process = Prefix(((b, P), (c, P)))
        assert transitions(self.prioritised(process)) == ((b, self.prioritised(P)), (c, self.prioritised(P)))

    def test_events_of_no_level_neither_block_nor_are_blocked(self) -> None:
        process = Prefix(((a, P), (b, P), (d, P)))
        assert transitions(self.prioritised(process)) == ((a, self.prioritised(P)), (d, self.prioritised(P)))
        assert transitions(self.prioritised(Prefix(((b, P), (d, P))))) == (
            (b, self.prioritised(P)),
            (d, self.prioritised(P)),
        )

    def test_tau_and_tick_rank_with_the_first_level(self) -> None:
        lower = prefix(b, STOP)
        with_tau = ExternalChoice((TAU_TO_P, lower))
        assert transitions(self.prioritised(with_tau)) == ((TAU, self.prioritised(ExternalChoice((P, lower)))),)
        assert transitions(self.prioritised(ExternalChoice((SKIP, lower)))) == ((TICK, TERMINATED),)
        assert transitions(self.prioritised(ExternalChoice((SKIP, P)))) == (
            (TICK, TERMINATED),
            (a, self.prioritised(STOP)),
        )

    def test_the_first_level_that_names_an_event_counts(self) -> None:
        levels = (events(), events(a), events(a, b))
        assert transitions(Prioritised(Prefix(((a, P), (b, P))), levels)) == ((a, Prioritised(P, levels)),)


class TestBuffers:
    PAIRS = ((a, c), (b, d))

    def buffer(self, *contents: int, kind: str = "BUFFER", signals: tuple[int, ...] = ()) -> Process:
        return Buffer(kind, 2, signals, self.PAIRS, contents)

    def test_an_empty_buffer_only_receives(self) -> None:
        assert transitions(self.buffer()) == ((a, self.buffer(0)), (b, self.buffer(1)))

    def test_the_oldest_comes_out_first(self) -> None:
        assert transitions(self.buffer(0)) == ((a, self.buffer(0, 0)), (b, self.buffer(0, 1)), (c, self.buffer()))
        assert transitions(self.buffer(1, 0)) == ((d, self.buffer(0)),)

    def test_a_full_buffer_accepts_no_input(self) -> None:
        assert transitions(self.buffer(0, 1)) == ((c, self.buffer(1)),)

    def test_the_states_are_the_contents(self) -> None:
        """1 + 2 + 4 contents of at most two out of two."""
        assert explore(self.buffer()).lts.states == 7

    def test_a_weak_buffer_takes_one_more_and_explodes(self) -> None:
        explode = 9
        full = self.buffer(0, 1, kind="WEAK_BUFFER", signals=(explode,))
        after = self.buffer(1, kind="WEAK_BUFFER", signals=(explode,))
        exploding = prefix(explode, STOP)
        assert transitions(full) == ((a, exploding), (b, exploding), (c, after))
        assert transitions(exploding) == ((explode, STOP),)

    def test_a_signal_buffer_tells_when_it_is_full_and_when_empty(self) -> None:
        full, empty = 8, 9

        def buffer(*contents: int) -> Process:
            return self.buffer(*contents, kind="SIGNAL_BUFFER", signals=(full, empty))

        assert transitions(buffer()) == ((a, buffer(0)), (b, buffer(1)), (empty, buffer()))
        assert transitions(buffer(0)) == ((a, buffer(0, 0)), (b, buffer(0, 1)), (c, buffer()))
        assert transitions(buffer(0, 1)) == ((c, buffer(1)), (full, buffer(0, 1)))


class TestFunctions:
    def test_a_compression_means_its_operand(self) -> None:
        assert transitions(prefix(b, Compressed("normal", Compressed("sbisim", P)))) == ((b, P),)


class TestOrder:
    def test_by_event_and_then_by_first_occurrence(self) -> None:
        process = ExternalChoice((prefix(b, Q), prefix(a, Q), prefix(b, P), prefix(a, P), InternalChoice((Q,))))
        row = transitions(process)
        assert [event for event, _ in row] == [TAU, a, a, b, b]
        assert [state for _, state in row][1:] == [Q, P, Q, P]
