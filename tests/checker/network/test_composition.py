"""A network has the states and transitions of the term that it was compiled from."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import assume, currently_in_test_context, given, note, settings, strategies as st

from cspcheck.checker.network.compiler import Compiler, compile_network
from cspcheck.checker.network.network import Network, Rule
from cspcheck.checker.semantics.transitions import LimitReached, explore
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.definitions import Definition
from cspcheck.cspm.process.events import TAU, TICK, EventSet
from cspcheck.cspm.process.terms import (
    SKIP,
    STOP,
    AlphabetisedParallel,
    Compressed,
    ExternalChoice,
    Hide,
    LinkedParallel,
    Parallel,
    Prefix,
    Process,
    Project,
    Reference,
    Rename,
)
from tests.checker.exploring import interpreted, rows_of, strongly_bisimilar, transitions_in
from tests.checker.philosophers import machine_of_philosophers, philosophers
from tests.checker.terms import compositions, processes, reference, told
from tests.examples import examples

a, b, c, d = 2, 3, 4, 5
MOST = 600


def events(*members: int) -> EventSet:
    return EventSet.of(members)


def assert_same_machine(process: Process, compile_it: Callable[[Process], Network] = compile_network) -> None:
    """The network's states and transitions are as many as the term's, and behave alike."""
    try:
        expected = rows_of(explore(process, Limits(states=MOST)).lts)
    except LimitReached:
        assume(False)
    if currently_in_test_context():
        note(told(process))
    found = interpreted(compile_it(process))
    assert (len(found), transitions_in(found)) == (len(expected), transitions_in(expected))
    assert strongly_bisimilar(found, expected)


def loop(first: int, length: int = 3, name: str = "Loop") -> Process:
    """``Loop = first -> first + 1 -> ... -> Loop``."""

    def body() -> Process:
        process: Process = named
        for event in reversed(range(first, first + length)):
            process = prefix(event, process)
        return process

    named = reference(name, body)
    return named


class TestSameMachine:
    @settings(max_examples=examples(200), deadline=None)
    @given(compositions(size=4, components=4))
    def test_of_parallel_hiding_and_renaming_over_anything(self, process: Process) -> None:
        assert_same_machine(process)

    @settings(max_examples=examples(200), deadline=None)
    @given(processes(size=10))
    def test_of_any_process(self, process: Process) -> None:
        assert_same_machine(process)

    @settings(max_examples=examples(50), deadline=None)
    @given(st.lists(compositions(size=3), min_size=2, max_size=3))
    def test_whatever_was_compiled_before(self, several: list[Process]) -> None:
        compiler = Compiler()
        for process in several:
            again, fresh = compiler.network(process), compile_network(process)
            assert again.rules == fresh.rules
            assert [slot.terms for slot in again.slots] == [slot.terms for slot in fresh.slots]


class TestCounts:
    @pytest.mark.parametrize("n", [1, 2, 5])
    def test_independent_loops(self, n: int) -> None:
        """n loops of three events have 3^n states, in each of which n events are possible."""
        rows = interpreted(compile_network(Parallel(events(), tuple(loop(2 + 3 * i) for i in range(n + 1)))))
        assert len(rows) == 3 ** (n + 1)
        assert transitions_in(rows) == (n + 1) * 3 ** (n + 1)

    def test_two_loops_in_step(self) -> None:
        """Joined on all three events they are one loop; joined on the first they meet at every third event."""
        everything = EventSet([(2, 5)])
        assert len(interpreted(compile_network(Parallel(everything, (loop(2), loop(2, name="Other")))))) == 3
        apart = Parallel(events(2), (loop(2), Rename(loop(2, name="Other"), ((3, 5), (4, 6)))))
        rows = interpreted(compile_network(apart))
        assert (len(rows), transitions_in(rows)) == (9, 13)

    @pytest.mark.parametrize("n", [2, 3])
    def test_dining_philosophers(self, n: int) -> None:
        """Against the same table written down as states and moves, with no process in sight."""
        states, moves, stuck = machine_of_philosophers(n)
        rows = interpreted(compile_network(philosophers(n)))
        assert (len(rows), transitions_in(rows)) == (states, moves)
        assert sum(not row for row in rows) == stuck == 1

    def test_a_terminated_partner_adds_no_state(self) -> None:
        rows = interpreted(compile_network(Parallel(events(), (SKIP, loop(2)))))
        assert (len(rows), transitions_in(rows)) == (3, 3)

    def test_termination_is_one_state_at_the_end(self) -> None:
        """Two times (event, then done), both orders, and the end: 4 states and one more."""
        both = Parallel(events(), (prefix(a, SKIP), prefix(b, SKIP)))
        rows = interpreted(compile_network(both))
        assert (len(rows), transitions_in(rows)) == (5, 5)
        assert compile_network(both).terminated


class TestRules:
    def test_one_for_each_event_that_the_participants_have_in_common(self) -> None:
        together = Parallel(events(a, b, c), (Prefix(((a, STOP), (b, STOP))), Prefix(((b, STOP), (c, STOP)))))
        assert compile_network(together).rules == (Rule(b, ((0, b), (1, b)), b),)

    def test_one_rule_with_all_participants(self) -> None:
        crowd = Parallel(events(a), tuple(prefix(a, prefix(b + i, STOP)) for i in range(4)))
        assert compile_network(crowd).rules == (
            Rule(a, ((0, a), (1, a), (2, a), (3, a)), a),
            *(Rule(b + i, ((i, b + i),), b + i) for i in range(4)),
        )

    def test_an_event_outside_all_alphabets_has_none(self) -> None:
        assert (
            compile_network(AlphabetisedParallel((events(a), events(b)), (prefix(c, STOP), prefix(c, STOP)))).rules
            == ()
        )

    def test_a_hidden_event_is_a_tau_with_its_cause(self) -> None:
        inside = Parallel(events(a), (prefix(a, STOP), prefix(a, STOP)))
        assert compile_network(Hide(inside, events(a))).rules == (Rule(TAU, ((0, a), (1, a)), a),)
        assert compile_network(Project(inside, events(b))).rules == (Rule(TAU, ((0, a), (1, a)), a),)

    def test_the_cause_is_what_was_hidden_not_what_was_renamed(self) -> None:
        renamed = Rename(prefix(a, STOP), ((a, b),))
        assert compile_network(renamed).rules == (Rule(b, ((0, a),), b),)
        assert compile_network(Hide(renamed, events(b))).rules == (Rule(TAU, ((0, a),), b),)

    def test_renaming_to_several_events_multiplies(self) -> None:
        renamed = Rename(prefix(a, STOP), ((a, b), (a, c)))
        assert compile_network(renamed).rules == (Rule(b, ((0, a),), b), Rule(c, ((0, a),), c))
        twice = Parallel(events(c), (renamed, prefix(c, STOP)))
        assert compile_network(twice).rules == (Rule(b, ((0, a),), b), Rule(c, ((0, a), (1, c)), c))

    def test_of_two_causes_for_one_rule_the_least_is_told(self) -> None:
        renamed = Rename(prefix(a, STOP), ((a, b), (a, c)))
        assert compile_network(Hide(renamed, events(b, c))).rules == (Rule(TAU, ((0, a),), b),)

    def test_linked_events(self) -> None:
        linked = LinkedParallel(prefix(a, STOP), ((a, b),), prefix(b, STOP))
        assert compile_network(linked).rules == (Rule(TAU, ((0, a), (1, b)), a),)

    def test_own_taus_of_components_have_no_cause(self) -> None:
        silent = Compressed("sbisim", ExternalChoice((Hide(prefix(a, STOP), events(a)), prefix(b, STOP))))
        assert compile_network(Parallel(events(), (silent, STOP))).rules == (
            Rule(TAU, ((0, TAU),), TAU),
            Rule(b, ((0, b),), b),
        )

    def test_the_tick_of_all(self) -> None:
        all_of_them = Parallel(events(), (Parallel(events(), (SKIP, SKIP)), Hide(SKIP, events(a))))
        network = compile_network(all_of_them)
        assert network.rules == (Rule(TICK, ((0, TICK), (1, TICK), (2, TICK)), TICK),)
        assert network.terminated

    def test_no_tick_unless_everyone_can(self) -> None:
        assert compile_network(Parallel(events(), (SKIP, STOP))).rules == ()
        assert not compile_network(Parallel(events(), (SKIP, STOP))).terminated


class TestComponents:
    def test_stay_apart_however_small(self) -> None:
        nested = Parallel(
            events(), (Parallel(events(), (STOP, SKIP)), Hide(Rename(prefix(a, STOP), ((a, b),)), events(b)))
        )
        network = compile_network(nested)
        assert [slot.terms[0] for slot in network.slots] == [STOP, SKIP, prefix(a, STOP)]

    def test_hiding_and_renaming_are_not_part_of_them(self) -> None:
        network = compile_network(Hide(loop(2), events(2, 3)))
        (slot,) = network.slots
        assert slot.lts.alphabet() == (2, 3, 4)

    def test_of_a_parallel_operator_move_to_skip_by_a_tau_before_they_tick(self) -> None:
        ticking = ExternalChoice((SKIP, prefix(a, STOP)))
        (slot, _) = compile_network(Parallel(events(), (Hide(ticking, events(b)), STOP))).slots
        assert [list(slot.lts.successors(s)) for s in range(slot.lts.states)] == [
            [(TAU, slot.terms.index(SKIP)), (a, slot.terms.index(STOP))],
            *[[(TICK, 3)] if term is SKIP else [] for term in slot.terms[1:]],
        ]

    def test_alone_tick_as_they_are(self) -> None:
        ticking = ExternalChoice((SKIP, prefix(a, STOP)))
        (slot,) = compile_network(Hide(ticking, events(b))).slots
        assert sorted(label for label, _ in slot.lts.successors(0)) == [TICK, a]

    def test_are_named_after_their_definitions(self) -> None:
        def fork(i: int) -> Process:
            return Reference(("Fork", i, "names"), Definition(f"Fork({i})", None, lambda: prefix(a, fork(i))))

        pair = reference("Pair", lambda: Parallel(events(), (fork(1), prefix(b, STOP), prefix(c, STOP))))
        system = reference("System", lambda: Hide(Parallel(events(), (fork(0), pair, prefix(d, STOP))), events(d)))
        alone = reference("Alone", lambda: Hide(prefix(a, STOP), events(a)))
        assert [slot.name for slot in compile_network(system).slots] == [
            "Fork(0)",
            "Fork(1)",
            "part 1 of Pair",
            "part 2 of Pair",
            "part 1 of System",
        ]
        assert [slot.name for slot in compile_network(alone).slots] == ["Alone"]
        assert [slot.name for slot in compile_network(Parallel(events(), (STOP, alone))).slots] == ["part 1", "Alone"]
        assert [slot.name for slot in compile_network(STOP).slots] == ["the process"]

    def test_a_channel_of_ten_thousand_events(self) -> None:
        n = 10_000
        channel = EventSet([(a, a + n)])
        sender = reference("Send", lambda: Prefix(tuple((event, sender) for event in channel)))
        receiver = reference("Receive", lambda: Prefix(tuple((event, receiver) for event in channel)))
        network = compile_network(Hide(Parallel(channel, (sender, receiver)), channel))
        assert len(network.rules) == n
        assert {rule.result for rule in network.rules} == {TAU}
        assert [rule.cause for rule in network.rules] == list(channel)

    def test_a_chain_of_a_thousand_operators(self) -> None:
        chain: Process = prefix(a, STOP)
        for i in range(1, 1000):
            chain = Parallel(events(), (chain, prefix(a + i, STOP)))
        network = compile_network(chain)
        assert (len(network.slots), len(network.rules)) == (1000, 1000)
