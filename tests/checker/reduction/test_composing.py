"""Networks composed two by two and minimised in between: nothing is lost, and little is left."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from hypothesis import event, given, settings, strategies as st

from cspcheck.checker.check import Checker
from cspcheck.checker.checks import properties, reducing, refinement, store
from cspcheck.checker.network.compiler import compile_network
from cspcheck.checker.packing.packed import pack
from cspcheck.checker.reduction.composing import NotComposable, composed
from cspcheck.checker.search.exploration import explore
from cspcheck.checker.verdict import Outcome, Verdict
from cspcheck.cspm import script
from cspcheck.cspm.process.terms import Prioritised, Process
from cspcheck.cspm.source import Source
from tests.checker.explicit import refinement_violation
from tests.checker.philosophers import philosophers
from tests.checker.terms import ALL, compositions, processes, told
from tests.checker.test_check import questions
from tests.checker.textbook import a, b, c, checker, events, rows_of
from tests.examples import examples


def visible(outcome: Outcome) -> list[str]:
    """What is told of a failure, taus apart."""
    assert outcome.counterexample is not None
    return [event for event in outcome.counterexample.trace if event != "tau"]


@pytest.fixture
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Everything is reduced, however small it is."""
    for module in (store, refinement, properties):
        monkeypatch.setattr(module, "FIRST_LOOK", 1)
    monkeypatch.setattr(reducing, "WORTH_WHILE", -1_000)


@pytest.mark.usefixtures("at_once")
class TestNothingIsLost:
    @settings(max_examples=examples(25))
    @given(compositions(size=4, components=4), st.one_of(compositions(size=4), processes(size=5)))
    def test_verdicts_are_those_of_the_full_search(self, p: Process, q: Process) -> None:
        full, reducing = checker(full=True), checker()
        for question in questions(p, q):
            found, expected = question(reducing), question(full)
            assert found.verdict == expected.verdict, told(p) + "\n" + told(q)
            if expected.counterexample is not None:
                assert found.counterexample is not None

    @settings(max_examples=examples(20))
    @given(compositions(size=4, components=4), st.one_of(compositions(size=4), processes(size=5)))
    def test_what_is_told_of_a_failure_does_not_depend_on_it(self, p: Process, q: Process) -> None:
        plain, reducing = checker(as_written=True), checker()
        for question in questions(p, q):
            expected, found = question(plain).counterexample, question(reducing).counterexample
            assert found == expected, told(p) + "\n" + told(q)

    @settings(max_examples=examples(40))
    @given(compositions(size=4, components=4), st.lists(st.sampled_from([a, b, c]), max_size=4))
    def test_traces_are_those_of_the_full_search(self, process: Process, trace: list[int]) -> None:
        full, reducing = checker(full=True), checker()
        for model in ("T", "F", "FD"):
            expected, found = (each.check_property(process, "has trace", model, trace) for each in (full, reducing))
            assert found.verdict == expected.verdict, told(process)
            assert (found.counterexample is None) == (expected.counterexample is None)
            if found.counterexample is not None:
                assert found.counterexample.kind == expected.counterexample.kind
                assert visible(found) == visible(expected)

    @settings(max_examples=examples(25))
    @given(compositions(size=4, components=4), st.one_of(compositions(size=4), processes(size=5)))
    def test_what_is_unfolded_is_a_run_of_the_whole(self, p: Process, q: Process) -> None:
        """Replaying it says so, with nothing else at hand to explain a failure by but the search of the whole."""
        told_by_runs = 0

        def unfolding(*arguments: object) -> object:
            nonlocal told_by_runs
            run = unfold(*arguments)  # type: ignore[arg-type]
            told_by_runs += run is not None
            return run

        unfold = refinement._unfolded
        full, reducing = checker(full=True), checker()
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(refinement, "_unfolded", unfolding)
            patch.setattr(refinement, "_without_compression", lambda *_, **__: None)
            for question in questions(p, q):
                found, expected = question(reducing), question(full)
                assert found.verdict == expected.verdict, told(p) + "\n" + told(q)
                if expected.counterexample is not None:
                    assert found.counterexample is not None
                    visible = [event for event in found.counterexample.trace if event != "tau"]
                    assert visible == [event for event in expected.counterexample.trace if event != "tau"]
        event(f"unfolded: {told_by_runs > 0}")

    @settings(max_examples=examples(40))
    @given(compositions(size=4, components=4), st.booleans())
    def test_what_is_left_has_the_failures_and_divergences_of_the_whole(self, process: Process, ties: bool) -> None:
        original = rows_of(process)
        for model in ("F", "FD"):
            try:
                left = composed(compile_network(process), model, lambda event: event, by_ties=ties).network
            except NotComposable:
                continue
            lts = explore(pack(left)).to_lts()
            small = [set(lts.successors(state)) for state in range(lts.states)]
            for kept in ("T", "F", "FD") if model == "FD" else ("T", "F"):
                assert refinement_violation(original, small, kept) is None, told(process)
                assert refinement_violation(small, original, kept) is None, told(process)

    @settings(max_examples=examples(15))
    @given(compositions(size=4, components=3), processes(size=5), st.permutations([a, b, c]))
    def test_a_priority_over_a_composition_is_kept(self, p: Process, q: Process, order: list[int]) -> None:
        first, second, third = map(events, order)
        p = Prioritised(p, (first, second, third))
        full, reducing = checker(full=True), checker()
        for question in questions(p, q):
            assert question(reducing).verdict == question(full).verdict, told(p) + "\n" + told(q)

    def test_what_a_priority_takes_away_is_missed_where_it_is_reached_late(self) -> None:
        assert self.verdict("P") is Verdict.PASS
        assert self.verdict("prioritise(P, <{b}, {a}>)") is Verdict.FAIL

    def verdict(self, process: str) -> Verdict:
        text = r"""external prioritise
channel a, b, fin
channel s : {1..4}
M(i) = s.i -> fin -> STOP
U = a -> U [] b -> U
P = (([| {fin} |] i : {1..4} @ M(i)) [| {fin} |] fin -> U) \ {| s |}
assert fin -> U [F= """
        (outcome,) = answers(text + process + "\n")
        return outcome.verdict


class TestMachinesInsideTerms:
    @settings(max_examples=examples(25))
    @given(processes(operators=ALL, size=8), processes(operators=ALL, size=5))
    def test_verdicts_are_those_without_machines(self, p: Process, q: Process) -> None:
        full, as_written = checker(full=True), checker(as_written=True)
        for question in questions(p, q):
            assert question(as_written).verdict == question(full).verdict, told(p) + "\n" + told(q)


def answers(text: str) -> Iterator[Outcome]:
    loaded = script.load(Source("test.csp", text))
    checks = Checker(loaded, workers=1)
    for assertion in loaded.assertions:
        yield checks.check(assertion.node)


RING = """
N = {n}
ID = {{0..N-1}}
channel a, b, c : ID
Rest(i) = b.i -> c.(i+1)%N -> Cell(i) [] c.(i+1)%N -> b.i -> Cell(i)
Cell(i) = c.i -> a.i -> Rest(i)
System = (|| i:ID @ [{{a.i, b.i, c.i, c.(i+1)%N}}] (if i == 0 then a.0 -> Rest(0) else Cell(i))) \\ {{| c |}}
Order(i) = a.i -> Order((i+1)%N)
assert System :[deadlock free]
assert System :[divergence free]
assert Order(0) [FD= System \\ {{| b |}}
"""

BUFFERS = """
N = {n}
channel c : {{0..N}}
Cell(i) = c.i -> c.(i+1) -> Cell(i)
Chain = (|| i:{{0..N-1}} @ [{{c.i, c.(i+1)}}] Cell(i)) \\ {{c.i | i <- {{1..N-1}}}}
Count(k) = k < N & c.0 -> Count(k+1) [] k > 0 & c.N -> Count(k-1)
assert Count(0) [FD= Chain
assert Chain :[deterministic]
"""


SIDE_BY_SIDE = r"""
N = {n}
ID = {{1..N}}
channel get, put, s1, s2, s3 : ID
channel go, x, y, done
Cell(i) = get.i -> s1.i -> (s2.i -> s3.i -> put.i -> Cell(i) [] s3.i -> s2.i -> put.i -> Cell(i))
Inside = ||| i:ID @ Cell(i) \ {{s1.i, s2.i, s3.i}}
Outside = (||| i:ID @ Cell(i)) \ {{| s1, s2, s3 |}}
Box(i) = get.i -> put.i -> Box(i)
assert Inside :[deadlock free [F]]
assert Outside :[deadlock free [FD]]
assert Outside :[divergence free]
assert ||| i:ID @ Box(i) [FD= Inside
assert Outside :[deterministic]
"""

ALIKE = r"""
N = {n}
channel go, x, y, done
Loop = go -> x -> y -> done -> Loop
Many = ||| i:{{1..N}} @ Loop \ {{x, y}}
Count(k) = k < N & go -> Count(k+1) [] k > 0 & done -> Count(k-1)
assert Count(0) [FD= Many
assert Many :[deterministic]
assert Many :[has trace [FD]]: <go, go, done, go>
Stuck = go -> x -> (y -> done -> Stuck |~| STOP)
Stopping = ||| i:{{1..N}} @ Stuck \ {{x, y}}
assert Stopping :[deadlock free [F]]
assert Count(0) [F= Stopping
"""


class TestLargeSystems:
    """Without any compression in the script."""

    def test_components_side_by_side_with_hidden_events_of_their_own(self) -> None:
        """Five states each become two, wherever the hiding stands; where no event matters, one."""
        outcomes = list(answers(SIDE_BY_SIDE.format(n=10)))
        assert [outcome.verdict for outcome in outcomes] == [Verdict.PASS] * 5
        assert [outcome.states for outcome in outcomes[:2]] == [1, 1]
        assert [outcome.states for outcome in outcomes[3:]] == [2**10, 2**10]

    def test_equal_components_side_by_side_are_counted(self) -> None:
        outcomes = list(answers(ALIKE.format(n=40)))
        assert [outcome.verdict for outcome in outcomes] == [Verdict.PASS] * 3 + [Verdict.FAIL] * 2
        assert all(outcome.states < 2_500 for outcome in outcomes)
        deadlock, refusal = (outcome.counterexample for outcome in outcomes[3:])
        assert deadlock is not None
        assert refusal is not None
        assert deadlock.kind == "deadlock"
        assert sorted(event for event in visible(outcomes[3])) == ["go"] * 40
        assert refusal.kind == "refusal"

    def test_a_scheduler_of_forty_cells(self) -> None:
        outcomes = list(answers(RING.format(n=40)))
        assert [outcome.verdict for outcome in outcomes] == [Verdict.PASS] * 3
        assert all(outcome.states < 20_000 for outcome in outcomes)

    def test_a_chain_of_thirty_buffers(self) -> None:
        outcomes = list(answers(BUFFERS.format(n=30)))
        assert [outcome.verdict for outcome in outcomes] == [Verdict.PASS] * 2
        assert all(outcome.states < 2_000 for outcome in outcomes)

    def test_a_deadlock_is_told_by_the_components_of_the_script(self) -> None:
        """Each of twelve philosophers has his left fork; the run to it is replayed on the whole."""
        outcome = checker().check_property(philosophers(12), "deadlock free", "F")
        assert outcome.verdict is Verdict.FAIL
        assert outcome.counterexample is not None
        assert outcome.counterexample.kind == "deadlock"
        assert len(outcome.counterexample.components) == 24
        assert outcome.states < 2_000
