"""The operators whose operands step together: exact transitions, and distributed termination."""

from __future__ import annotations

import pytest
from hypothesis import assume, given, settings

from cspcheck.checker.semantics.transitions import LimitReached, explore, transitions
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.events import TAU, TICK, EventSet
from cspcheck.cspm.process.terms import (
    SKIP,
    STOP,
    TERMINATED,
    AlphabetisedParallel,
    ExternalChoice,
    Hide,
    InternalChoice,
    LinkedParallel,
    Parallel,
    Prefix,
    Process,
    Rename,
    SynchronisingChoice,
    SynchronisingInterrupt,
)
from tests.checker.exploring import rows_of, strongly_bisimilar
from tests.checker.terms import processes, reference

a, b, c, d = 2, 3, 4, 5
P = prefix(a, STOP)
Q = prefix(b, STOP)
R = prefix(c, STOP)
TICK_OR_A = ExternalChoice((SKIP, P))


def events(*members: int) -> EventSet:
    return EventSet.of(members)


class TestParallel:
    def par(self, *operands: Process, on: EventSet) -> Process:
        return Parallel(on, operands)

    def test_events_outside_the_set_interleave(self) -> None:
        def par(*operands: Process) -> Process:
            return self.par(*operands, on=events(d))

        assert transitions(par(P, Q)) == ((a, par(STOP, Q)), (b, par(P, STOP)))

    def test_events_of_the_set_need_everyone(self) -> None:
        def par(*operands: Process) -> Process:
            return self.par(*operands, on=events(a))

        assert transitions(par(P, P, P)) == ((a, par(STOP, STOP, STOP)),)
        assert transitions(par(P, P, Q)) == ((b, par(P, P, STOP)),)

    def test_all_combinations_of_outcomes(self) -> None:
        either = ExternalChoice((prefix(a, Q), prefix(a, R)))
        on = events(a)
        assert {state for _, state in transitions(self.par(either, either, on=on))} == {
            self.par(left, right, on=on) for left in (Q, R) for right in (Q, R)
        }

    def test_the_same_event_of_two_operands_that_do_not_synchronise(self) -> None:
        on = events()
        assert transitions(self.par(P, P, on=on)) == ((a, self.par(STOP, P, on=on)), (a, self.par(P, STOP, on=on)))

    def test_taus_interleave_whatever_the_set(self) -> None:
        on = events(a, b, c, d)
        choice = InternalChoice((P,))
        assert transitions(self.par(choice, Q, on=on)) == ((TAU, self.par(P, Q, on=on)),)


class TestDistributedTermination:
    """An operand that can tick, and can do something else, moves to SKIP by a tau."""

    def test_all_terminated(self) -> None:
        assert transitions(Parallel(events(a), (SKIP, SKIP, SKIP))) == ((TICK, TERMINATED),)

    def test_one_terminated_operand_waits_for_the_others(self) -> None:
        assert transitions(Parallel(events(), (SKIP, P))) == ((a, Parallel(events(), (SKIP, STOP))),)

    def test_an_operand_that_can_do_something_else_too(self) -> None:
        process = Parallel(events(), (TICK_OR_A, Q))
        assert transitions(process) == (
            (TAU, Parallel(events(), (SKIP, Q))),
            (a, Parallel(events(), (STOP, Q))),
            (b, Parallel(events(), (TICK_OR_A, STOP))),
        )

    def test_it_must_decide_before_the_whole_can_tick(self) -> None:
        assert [event for event, _ in transitions(Parallel(events(a), (TICK_OR_A, SKIP)))] == [TAU]

    @pytest.mark.parametrize(
        "terminated", [SKIP, Hide(SKIP, events(a)), Rename(SKIP, ((a, b),)), Parallel(events(), (SKIP, SKIP))]
    )
    def test_whoever_can_only_tick_has_terminated(self, terminated: Process) -> None:
        assert transitions(Parallel(events(), (terminated, SKIP))) == ((TICK, TERMINATED),)

    @pytest.mark.parametrize(
        "compose",
        [
            lambda p, q: AlphabetisedParallel((events(a), events(b)), (p, q)),
            lambda p, q: LinkedParallel(p, ((c, c),), q),
        ],
    )
    def test_every_parallel_operator_does_it(self, compose: object) -> None:
        assert callable(compose)
        assert transitions(compose(SKIP, SKIP)) == ((TICK, TERMINATED),)
        assert transitions(compose(TICK_OR_A, Q)) == (
            (TAU, compose(SKIP, Q)),
            (a, compose(STOP, Q)),
            (b, compose(TICK_OR_A, STOP)),
        )

    @settings(deadline=None)
    @given(processes())
    def test_interleaving_with_skip_adds_no_state_to_what_does_not_tick(self, process: Process) -> None:
        try:
            alone = explore(process, Limits(states=500)).lts
        except LimitReached:
            assume(False)
        rows = rows_of(alone)
        assume(all(TICK not in labels or len(labels) == 1 for labels in ({e for e, _ in row} for row in rows)))
        both = explore(Parallel(events(), (SKIP, process))).lts
        assert (both.states, both.transitions) == (alone.states, alone.transitions)
        assert strongly_bisimilar(rows_of(both), rows)


class TestAlphabetisedParallel:
    def test_an_event_needs_exactly_those_in_whose_alphabets_it_is(self) -> None:
        alphabets = (events(a, c), events(b, c), events(a))
        process = Prefix(((a, STOP), (b, STOP), (c, STOP)))

        def par(*operands: Process) -> Process:
            return AlphabetisedParallel(alphabets, operands)

        p = process
        assert transitions(par(p, p, p)) == (
            (a, par(STOP, p, STOP)),
            (b, par(p, STOP, p)),
            (c, par(STOP, STOP, p)),
        )

    def test_nobody_leaves_its_alphabet(self) -> None:
        assert transitions(AlphabetisedParallel((events(b), events(c)), (P, P))) == ()


class TestLinkedParallel:
    def test_linked_events_happen_together_and_inside(self) -> None:
        links = ((a, b),)
        assert transitions(LinkedParallel(P, links, Q)) == ((TAU, LinkedParallel(STOP, links, STOP)),)

    def test_neither_happens_alone(self) -> None:
        assert transitions(LinkedParallel(P, ((a, b),), STOP)) == ()
        assert transitions(LinkedParallel(STOP, ((a, b),), Q)) == ()

    def test_a_side_keeps_what_is_linked_on_the_other_only(self) -> None:
        links = ((a, b),)
        assert transitions(LinkedParallel(Q, links, P)) == (
            (a, LinkedParallel(Q, links, STOP)),
            (b, LinkedParallel(STOP, links, P)),
        )


class TestSynchronisingChoice:
    ON = events(a)

    def choice(self, *operands: Process) -> Process:
        return SynchronisingChoice(self.ON, operands)

    def test_events_of_the_set_do_not_resolve_it(self) -> None:
        assert transitions(self.choice(prefix(a, Q), prefix(a, R))) == ((a, self.choice(Q, R)),)

    def test_and_need_everyone(self) -> None:
        assert transitions(self.choice(P, Q)) == ((b, STOP),)

    def test_other_events_resolve_it(self) -> None:
        assert transitions(self.choice(Q, prefix(c, R))) == ((b, STOP), (c, R))

    def test_taus_do_not(self) -> None:
        assert transitions(self.choice(InternalChoice((Q,)), R)) == ((TAU, self.choice(Q, R)), (c, STOP))

    def test_a_tick_does(self) -> None:
        assert transitions(self.choice(SKIP, Q)) == ((TICK, TERMINATED), (b, STOP))


class TestSynchronisingInterrupt:
    ON = events(a)

    def interrupt(self, left: Process, right: Process) -> Process:
        return SynchronisingInterrupt(left, self.ON, right)

    def test_events_of_the_set_happen_together(self) -> None:
        assert transitions(self.interrupt(prefix(a, Q), prefix(a, R))) == ((a, self.interrupt(Q, R)),)

    def test_other_events_of_the_right_interrupt(self) -> None:
        assert transitions(self.interrupt(Q, prefix(c, P))) == ((b, self.interrupt(STOP, prefix(c, P))), (c, P))

    def test_taus_of_either_side_do_not(self) -> None:
        silent = InternalChoice((P,))
        assert transitions(self.interrupt(silent, Q)) == ((TAU, self.interrupt(P, Q)), (b, STOP))
        assert transitions(self.interrupt(STOP, silent)) == ((TAU, self.interrupt(STOP, P)),)

    def test_a_tick_of_either_side_ends_it(self) -> None:
        assert transitions(self.interrupt(SKIP, P)) == ((TICK, TERMINATED),)
        assert transitions(self.interrupt(P, SKIP)) == ((TICK, TERMINATED),)


def test_a_state_is_the_same_however_its_operands_are_named() -> None:
    """``P ||| Q`` and the bodies of both interleaved are one state; what has not started stays a name."""
    named = reference("P", lambda: prefix(a, named))
    other = reference("Q", lambda: prefix(b, other))
    row = transitions(prefix(c, Parallel(events(), (named, other))))
    assert row == ((c, Parallel(events(), (prefix(a, named), prefix(b, other)))),)
    assert explore(Parallel(events(), (named, other))).lts.states == 1
