"""Specifications without end: only what the implementation follows of them is looked at."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.checker.budget import Incomplete
from cspcheck.checker.checks import store
from cspcheck.checker.specification.lazy import FOREIGN, LazySpecification
from cspcheck.checker.verdict import Verdict
from cspcheck.cspm.process.terms import DIV, STOP, Buffer, Prefix, Process, Reference
from tests.checker import explicit
from tests.checker.terms import compositions, processes, reference
from tests.checker.textbook import a, b, c, checker, choose, d, forever, identifiers, perhaps, rows_of, then
from tests.examples import examples

terms = st.one_of(processes(size=6), compositions(size=4, components=2))


def growing(name: str, at: object) -> Process:
    """``P(n)`` for every n, made as it is met; *at* tells the body from the number and the others."""
    made: dict[int, Reference] = {}

    def number(n: int) -> Process:
        if n not in made:
            made[n] = reference(f"{name}({n})", lambda: at(n, number))  # type: ignore[operator]
        return made[n]

    return number(0)


endless_buffer = growing(
    "Bag",
    lambda n, at: Prefix(((a, at(n + 1)), (b, at(n - 1)))) if n else Prefix(((a, at(1)),)),
)
"""Any number of a, and as many b at most; always ready for both where they are allowed."""

timid_buffer = growing(
    "Timid",
    lambda n, at: perhaps(Prefix(((a, at(n + 1)),)), then(b, at(n - 1))) if n else Prefix(((a, at(1)),)),
)
"""The same traces, but it chooses which of the two it offers."""


def lazy(process: Process, model: str, most: int = 1000) -> LazySpecification:
    return LazySpecification(process, model, np.array([1, a, b, c], dtype=np.int64), most, Incomplete("too many"))


class TestNodes:
    @settings(deadline=None)
    @given(terms, st.sampled_from(("T", "F", "FD")))
    def test_each_node_says_what_its_traces_say(self, process: Process, model: str) -> None:
        specification = lazy(process, model)
        rows = rows_of(process)
        nodes = {(): 0}
        for trace in explicit.traces(rows, 3):
            if trace not in nodes:
                continue
            node = nodes[trace]
            states = explicit.after(rows, trace)
            assert specification.is_divergent(node) == (model == "FD" and explicit.diverges(rows, states))
            if specification.is_divergent(node):
                continue
            assert set(specification.allowed(node)) == explicit.events(rows, states)
            if model != "T":
                expected = explicit.minimal(explicit.acceptances(rows, states))
                assert {frozenset(x) for x in specification.acceptances(node)} == expected
                columns = specification.acceptance_sets[specification.acceptance_set(node)]
                assert {frozenset(specification.events[list(x)].tolist()) for x in columns} == expected
            for column, target in specification.extend(node):
                nodes[(*trace, int(specification.events[column]))] = target

    def test_events_that_the_implementation_lacks_are_one_column(self) -> None:
        specification = lazy(choose(then(a, STOP), then(d, STOP)), "F")
        assert specification.events.tolist() == [1, a, b, c, FOREIGN]
        assert [column for column, _ in specification.extend(0)] == [1]
        assert specification.acceptance_sets[specification.acceptance_set(0)] == ((1, 4),)
        assert specification.acceptances(0) == ((a, d),)
        assert specification.allowed(0) == (a, d)

    def test_more_states_than_may_be_looked_at(self) -> None:
        specification = lazy(endless_buffer, "T", most=3)
        assert specification.extend(0) == [(1, 1)]
        assert specification.extend(1) == [(1, 2), (2, 0)]
        with pytest.raises(Incomplete, match="too many"):
            specification.extend(2)

    def test_divergence(self) -> None:
        assert lazy(DIV, "FD").is_divergent(0)
        assert not lazy(DIV, "F").is_divergent(0)

    def test_events_of_infinite_channels_have_large_identifiers(self) -> None:
        large = 2**62
        specification = lazy(choose(then(large, STOP), then(a, STOP)), "F")
        assert specification.allowed(0) == (a, large)
        assert specification.acceptances(0) == ((a, large),)


class TestRefinement:
    def bounded(self, capacity: int) -> Process:
        return Buffer("BUFFER", capacity, (), ((a, b),), ())

    @pytest.mark.parametrize("model", ["T", "F", "FD"])
    def test_a_bounded_buffer_of_an_endless_one(self, model: str) -> None:
        outcome = checker(states=100).check_refinement(timid_buffer, model, self.bounded(3))
        assert (outcome.verdict, outcome.states) == (Verdict.PASS, 4)

    def test_what_it_refuses_is_found(self) -> None:
        outcome = checker(states=100).check_refinement(endless_buffer, "F", self.bounded(2))
        found = outcome.counterexample
        assert outcome.verdict is Verdict.FAIL
        assert found is not None
        assert (found.trace, found.kind, found.refusal, found.allowed) == (("a", "a"), "refusal", ("a",), (("a", "b"),))

    def test_what_is_not_allowed_is_found(self) -> None:
        outcome = checker(states=100).check_refinement(endless_buffer, "T", then(a, b, b, STOP))
        found = outcome.counterexample
        assert found is not None
        assert (found.trace, found.event, found.allowed) == (("a", "b"), "b", (("a",),))

    def test_an_implementation_that_follows_without_end_is_not_decided(self) -> None:
        outcome = checker(states=100).check_refinement(endless_buffer, "T", forever(a))
        assert outcome.verdict is Verdict.UNKNOWN
        assert outcome.reason is not None
        assert outcome.reason.startswith("more than 100 states: `Bag` is called with 100 different arguments")

    @settings(max_examples=examples(30), deadline=None)
    @given(terms, st.sampled_from(("T", "F", "FD")), terms, st.sampled_from((10, store.FOLLOWED_EFFORT)))
    def test_the_verdict_and_counterexample_are_those_of_the_whole_normal_form(
        self, spec: Process, model: str, impl: Process, effort: int
    ) -> None:
        """The specification can also go on without end after an event that the implementation lacks."""
        endless = growing("Rest", lambda n, at: then(8, at(n + 1)))
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(
                store, "LISTED_FIRST", 100
            )  # it is known to be without end: no need to find that out each time
            found = checker(states=200).check_refinement(choose(spec, then(9, endless)), model, impl)
        whole = checker().check_refinement(choose(spec, then(9, STOP)), model, impl)
        assert found.verdict is whole.verdict
        if found.counterexample is not None and whole.counterexample is not None:
            assert found.counterexample.kind == whole.counterexample.kind
            assert identifiers(found.counterexample.trace) == identifiers(whole.counterexample.trace)

    @pytest.mark.parametrize("model", ["T", "F", "FD"])
    def test_it_is_followed_before_it_is_explored(self, model: str) -> None:
        """With no limit at all nobody waits for a specification without end."""
        outcome = checker().check_refinement(timid_buffer, model, self.bounded(3))  # type: ignore[arg-type]
        assert (outcome.verdict, outcome.states) == (Verdict.PASS, 4)
        found = checker().check_refinement(endless_buffer, model, then(a, b, b, STOP)).counterexample  # type: ignore[arg-type]
        assert found is not None
        assert found.trace == (("a", "b") if model == "T" else ("a",))

    def test_what_was_asked_before_makes_no_difference(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(store, "LISTED_FIRST", 3)
        # Two states of each that are equal: a normal form that is there as a whole has fewer.
        twice = forever(a, b, a, b)
        fresh = checker().check_refinement(twice, "FD", forever(a, b))
        engine = checker()
        assert engine.check_property(twice, "deterministic").verdict is Verdict.PASS
        assert engine.check_refinement(twice, "FD", twice).verdict is Verdict.PASS
        later = engine.check_refinement(twice, "FD", forever(a, b))
        assert (later.verdict, later.states, later.transitions) == (fresh.verdict, fresh.states, fresh.transitions)
