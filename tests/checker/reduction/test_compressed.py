"""Compressed components: fewer states, the same verdicts and the same counterexamples."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.checker.check import Checker
from cspcheck.checker.checks import trace_runs
from cspcheck.checker.reduction.compression import COMPRESSIONS
from cspcheck.checker.verdict import Outcome, Verdict
from cspcheck.cspm.process.terms import SKIP, STOP, Compressed, Hide, Process, Rename
from tests.checker.explicit import refinement_violation
from tests.checker.terms import compositions, processes, told
from tests.checker.test_check import questions
from tests.checker.textbook import (
    a,
    b,
    c,
    checker,
    choose,
    d,
    events,
    forever,
    hidden,
    interleave,
    perhaps,
    rows_of,
    share,
    then,
    timeout,
)
from tests.examples import examples

NAMES = sorted(COMPRESSIONS)
compressed = compositions(size=5, components=3, compressions=NAMES)


def comparable(outcome: Outcome) -> Outcome:
    """What must not depend on compression: all but what the search took."""
    return replace(outcome, states=0, transitions=0, seconds=0.0, peak_memory_bytes=0)


class TestNothingIsLost:
    @settings(max_examples=examples(60))
    @given(compressed, st.one_of(compressed, processes(size=6)))
    def test_verdicts_and_counterexamples_are_those_of_the_full_search(self, p: Process, q: Process) -> None:
        full, reducing = checker(full=True), checker()
        for question in questions(p, q):
            assert comparable(question(reducing)) == comparable(question(full)), told(p) + told(q)

    @settings(max_examples=examples(60))
    @given(compressed, processes(size=6))
    def test_verdicts_stay_right_where_the_components_that_the_script_has_are_not_looked_at(
        self, p: Process, q: Process
    ) -> None:
        full, reducing = checker(full=True), checker()
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(trace_runs, "EXPLAINED_STATES", 1)
            for question in questions(p, q):
                found, expected = question(reducing), question(full)
                assert found.verdict == expected.verdict, told(p) + told(q)
                if expected.counterexample is not None and found.counterexample is not None:
                    assert found.counterexample.kind == expected.counterexample.kind
                    assert visible(found) == visible(expected)

    @pytest.mark.parametrize("name", NAMES)
    @settings(max_examples=examples(25))
    @given(p=compositions(size=5, components=2), q=processes(size=5), around=st.integers(0, 3))
    def test_a_compressed_component_has_the_failures_and_divergences_of_its_operand(
        self, name: str, p: Process, q: Process, around: int
    ) -> None:
        def context(process: Process) -> Process:
            return (
                process,
                share(events(a), process, q),
                Hide(process, events(a, b)),
                Rename(share(events(b), process, q), ((a, c),)),
            )[around]

        machine = checker()
        kept = explicit_rows(machine, context(Compressed(name, p)))
        original = rows_of(context(p))
        for model in ("T", "F", "FD"):
            assert refinement_violation(original, kept, model) is None
            assert refinement_violation(kept, original, model) is None


def visible(outcome: Outcome) -> list[str]:
    assert outcome.counterexample is not None
    return [event for event in outcome.counterexample.trace if event != "tau"]


def explicit_rows(on: Checker, process: Process) -> list[set[tuple[int, int]]]:
    """The machine of a process as the engine searches it."""
    from cspcheck.checker.budget import Budget
    from cspcheck.checker.verdict import Limits

    lts = on._machines.lts(process, Budget(Limits()))
    assert lts.root == 0
    return [set(lts.successors(state)) for state in range(lts.states)]


def chain(length: int) -> Process:
    """A row of cells in each of which what enters by one channel leaves by the next; the inner channels are hidden."""
    return interleave(*(forever(a, b, name=f"Cell{i}") for i in range(length)))


class TestFewerStates:
    @pytest.mark.parametrize(
        ("name", "states"),
        [
            ("sbisim", 5),
            ("wbisim", 5),
            ("dbisim", 5),
            ("diamond", 5),
            ("normal", 5),
            ("lazynorm", 5),
            ("model_compress", 5),
            ("tau_loop_factor", 16),
        ],
    )
    def test_equal_cells_in_any_order_become_one_counter(self, name: str, states: int) -> None:
        process = Compressed(name, chain(4))
        assert checker().check_property(process, "deadlock free").states == states
        assert checker(full=True).check_property(process, "deadlock free").states == 16

    def test_compressions_within_a_composition_are_found_behind_names(self) -> None:
        inner = Compressed("sbisim", chain(4))
        whole = share(events(b), hidden(inner, a), forever(b, c, name="Partner"))
        assert checker().check_property(whole, "deadlock free").states == 5 * 2
        assert checker(full=True).check_property(whole, "deadlock free").states == 16 * 2

    def test_compressions_of_compressions_are_compressed_from_the_inside(self) -> None:
        inner = Compressed("sbisim", chain(4))
        outer = Compressed("sbisim", interleave(inner, inner))
        assert checker().check_property(outer, "deadlock free").states == 9

    def test_a_component_without_end_is_looked_through(self) -> None:
        """The compressed counter has no end by itself; its partner keeps it in bounds."""
        from tests.checker.terms import reference

        def counter(n: int) -> Process:
            up = then(a, reference_to(n + 1))
            return choose(up, then(b, reference_to(n - 1))) if n else up

        known: dict[int, Process] = {}

        def reference_to(n: int) -> Process:
            if n not in known:
                known[n] = reference(f"Counter({n})", lambda: counter(n))
            return known[n]

        bounded = share(events(a, b), Compressed("sbisim", reference_to(0)), forever(a, b, name="Partner"))
        assert checker(states=1_000).check_property(bounded, "deadlock free").verdict is Verdict.PASS


class TestExplanation:
    def test_components_are_those_of_the_script(self) -> None:
        """A tick-free deadlock inside what is compressed names the parts of it."""
        inside = share(events(b), then(a, b, STOP), forever(b, c, name="Right"))
        system = interleave(Compressed("sbisim", inside), forever(d, name="Other"))
        outcome = checker().check_refinement(forever(d), "T", system)
        assert outcome.counterexample is not None
        assert [part.name for part in outcome.counterexample.components] == ["part 1", "Right", "Other"]

    def test_where_that_would_take_too_long_the_compressed_component_is_named(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(trace_runs, "EXPLAINED_STATES", 1)
        system = interleave(Compressed("sbisim", timeout(then(a, SKIP), perhaps(STOP, then(b, STOP)))), forever(d))
        outcome = checker().check_refinement(forever(d), "T", system)
        assert outcome.counterexample is not None
        assert [part.name for part in outcome.counterexample.components] == ["part 1", "P"]
        assert outcome.counterexample.event == "a"
