"""The checker answers assertions, shares what they have in common, and says honestly where it had to stop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.checker.budget import Budget, Incomplete
from cspcheck.checker.check import Checker
from cspcheck.checker.checks import store as machines
from cspcheck.checker.verdict import Limits, Outcome, Verdict
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.process.terms import DIV, STOP, Chaos, Prefix, Process, Reference, Run
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from tests.checker.terms import compositions, processes, reference
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
    identifiers,
    interleave,
    perhaps,
    then,
)
from tests.examples import examples

Question = Callable[[Checker], Outcome]


def timeless(outcome: Outcome) -> Outcome:
    return replace(outcome, seconds=0.0, peak_memory_bytes=0)


def questions(p: Process, q: Process) -> list[Question]:
    """Everything that can be asked about two processes."""
    asked: list[Question] = []
    for process in (p, q):
        for model in ("F", "FD"):
            asked.append(lambda on, p=process, m=model: on.check_property(p, "deadlock free", m))
            asked.append(lambda on, p=process, m=model: on.check_property(p, "deterministic", m))
        asked.append(lambda on, p=process: on.check_property(p, "divergence free"))
        asked.append(lambda on, p=process: on.check_property(p, "has trace", "F", (a, b)))
    for model in ("T", "F", "FD"):
        asked.append(lambda on, m=model: on.check_refinement(p, m, q))
        asked.append(lambda on, m=model: on.check_refinement(q, m, p))
    return asked


terms = st.one_of(processes(size=6), compositions(size=4, components=2))


class TestSharing:
    """What was asked before makes no difference."""

    @settings(max_examples=examples(25), deadline=None)
    @given(terms, terms, st.randoms(use_true_random=False), st.booleans(), st.sampled_from((None, 4, 12)))
    def test_shuffled_questions_have_the_same_answers(
        self, p: Process, q: Process, random: object, full: bool, limit: int | None
    ) -> None:
        asked = questions(p, q)
        alone = [timeless(question(checker(full=full, states=limit))) for question in asked]
        order = list(range(len(asked)))
        random.shuffle(order)  # type: ignore[attr-defined]
        together = checker(full=full, states=limit)
        answers = {i: timeless(asked[i](together)) for i in order}
        assert [answers[i] for i in range(len(asked))] == alone

    def test_a_machine_is_explored_once(self, monkeypatch: pytest.MonkeyPatch) -> None:
        explored = []
        explore = machines.explore

        def counted(packed: object, **options: object) -> object:
            explored.append(packed)
            return explore(packed, **options)

        monkeypatch.setattr(machines, "explore", counted)
        one = checker()
        process = forever(a, b)
        for kind in ("deadlock free", "divergence free", "deterministic"):
            assert one.check_property(process, kind).verdict is Verdict.PASS
        assert one.check_refinement(process, "FD", process).verdict is Verdict.PASS
        assert len(explored) == 1

    def test_old_machines_make_room(self) -> None:
        kept = machines.Machines(kept_bytes=1)
        first, second = forever(a), forever(b)
        whole = kept.exploration(first, "everything", Budget(Limits()))
        assert kept.exploration(first, "everything", Budget(Limits())) is whole
        kept.exploration(second, "everything", Budget(Limits()))
        assert kept.exploration(first, "everything", Budget(Limits())) is not whole


def counter(top: int, name: str = "Counter") -> Process:
    """Counts up to *top* by a and down by b."""
    made: dict[int, Reference] = {}

    def at(n: int) -> Process:
        if n not in made:
            made[n] = reference(
                f"{name}({n})",
                lambda: Prefix(tuple((event, at(m)) for event, m in ((a, n + 1), (b, n - 1)) if 0 <= m <= top)),
            )
        return made[n]

    return at(0)


class TestLimits:
    """A limit ends in unknown and says what was covered, unless the answer was there already."""

    cube = interleave(forever(a, a, a, a, name="A"), forever(b, b, b, b, name="B"), forever(c, c, c, c, name="C"))

    def test_states(self) -> None:
        outcome = checker(as_written=True, states=20).check_property(self.cube, "deadlock free")
        assert outcome.verdict is Verdict.UNKNOWN
        assert outcome.reason == (
            "state limit of 20 (`--max-states`) reached: 10 states explored to depth 2, "
            "no deadlock or divergence among them"
        )
        assert (outcome.states, outcome.transitions) == (10, 30)

    def test_states_of_a_component(self) -> None:
        outcome = checker(as_written=True, states=100).check_property(counter(10_000), "deadlock free")
        assert outcome.verdict is Verdict.UNKNOWN
        assert outcome.reason == (
            "more than 100 states: `Counter` is called with 100 different arguments: "
            "`Counter(0)`, `Counter(1)`, `Counter(2)`, ...; `--max-states` raises the limit"
        )

    def test_states_of_the_specification(self) -> None:
        outcome = checker(as_written=True, states=20).check_refinement(hidden(self.cube, a, b, c), "T", STOP)
        assert outcome.verdict is Verdict.UNKNOWN
        assert (
            outcome.reason
            == "state limit of 20 (`--max-states`) reached in the specification: not even depth 0 was completed"
        )

    def test_a_specification_need_not_be_explored_where_the_implementation_does_not_go(self) -> None:
        assert checker(as_written=True, states=20).check_refinement(self.cube, "T", STOP).verdict is Verdict.PASS

    def test_states_of_the_implementation(self) -> None:
        outcome = checker(as_written=True, states=20).check_refinement(Run(events(a, b, c)), "T", self.cube)
        assert outcome.verdict is Verdict.UNKNOWN
        assert (
            outcome.reason
            == "state limit of 20 (`--max-states`) reached: 10 states explored to depth 2, no violation among them"
        )

    def test_a_single_state_is_one_state(self) -> None:
        outcome = checker(as_written=True, states=4).check_property(self.cube, "divergence free")
        assert (
            outcome.reason
            == "state limit of 4 (`--max-states`) reached: 1 state explored to depth 0, no divergence among them"
        )

    def test_time(self) -> None:
        outcome = checker(seconds=0.0).check_property(self.cube, "deadlock free")
        assert outcome.verdict is Verdict.UNKNOWN
        assert outcome.reason is not None
        assert outcome.reason.startswith("time limit of 0 s (`--timeout`) reached")

    def test_memory(self) -> None:
        outcome = checker(memory_bytes=1).check_property(self.cube, "deadlock free")
        assert outcome.verdict is Verdict.UNKNOWN
        assert outcome.reason is not None
        assert outcome.reason.startswith("memory limit of 1 bytes (`--max-memory`) reached")

    @pytest.mark.parametrize("states", [12, 30, 60])
    def test_what_was_found_in_time_stands(self, states: int) -> None:
        """The deadlock after d is at depth 1, whatever lies beyond."""
        process = choose(then(d, STOP), self.cube)
        outcome = checker(as_written=True, states=states).check_property(process, "deadlock free")
        assert outcome.verdict is Verdict.FAIL
        assert outcome.counterexample is not None
        assert outcome.counterexample.trace == ("d",)
        assert (
            checker(as_written=True, states=states).check_property(process, "divergence free").verdict
            is Verdict.UNKNOWN
        )

    def test_nondeterminism_found_in_time_stands(self) -> None:
        process = choose(then(d, a, STOP), then(d, b, STOP), self.cube)
        found = checker(as_written=True, states=30).check_property(process, "deterministic").counterexample
        assert found is not None
        assert (found.trace, found.event) == (("d",), "a")

    def test_no_nondeterminism_in_what_was_explored_is_no_proof(self) -> None:
        for model, nothing in (("F", "nondeterminism"), ("FD", "divergence or nondeterminism")):
            outcome = checker(as_written=True, states=40).check_property(self.cube, "deterministic", model)
            assert outcome.verdict is Verdict.UNKNOWN
            assert outcome.reason == (
                f"state limit of 40 (`--max-states`) reached: 20 states explored to depth 3, no {nothing} among them"
            )

    @settings(max_examples=examples(20), deadline=None)
    @given(terms, terms, st.integers(1, 30))
    def test_a_limit_never_turns_a_verdict(self, p: Process, q: Process, states: int) -> None:
        for question in questions(p, q):
            free, limited = question(checker()), question(checker(as_written=True, states=states))
            assert limited.verdict in (free.verdict, Verdict.UNKNOWN)
            assert (limited.reason is not None) == (limited.verdict is Verdict.UNKNOWN)
            if limited.counterexample is not None and free.counterexample is not None:
                assert limited.counterexample.kind == free.counterexample.kind
                assert identifiers(limited.counterexample.trace) == identifiers(free.counterexample.trace)


class TestWorkers:
    @settings(max_examples=examples(15), deadline=None)
    @given(terms, terms)
    def test_their_number_makes_no_difference(self, p: Process, q: Process) -> None:
        for question in questions(p, q):
            assert timeless(question(checker(workers=2))) == timeless(question(checker(workers=1)))


class TestCounts:
    """States and transitions are those of the composed machine, or of what had to be looked at."""

    def test_a_property_that_holds_counts_the_whole_machine(self) -> None:
        outcome = checker().check_property(TestLimits.cube, "deadlock free")
        assert (outcome.states, outcome.transitions) == (64, 192)

    def test_a_failure_counts_the_levels_up_to_it(self) -> None:
        """The deadlock is at depth 2; the last of the five states is at depth 3."""
        process = then(a, choose(then(a, STOP), then(b, c, d, STOP)))
        early = checker().check_property(process, "deadlock free")
        assert (early.states, early.transitions) == (4, 4)
        whole = checker(full=True).check_property(process, "deadlock free")
        assert (whole.states, whole.transitions) == (5, 5)

    def test_a_failure_counts_the_same_after_another_assertion_had_everything_explored(self) -> None:
        process = then(a, choose(then(a, STOP), then(b, c, d, STOP)))
        one = checker()
        assert one.check_property(process, "divergence free").states == 5
        late = one.check_property(process, "deadlock free")
        assert (late.states, late.transitions) == (4, 4)

    def test_a_refinement_counts_pairs(self) -> None:
        outcome = checker().check_refinement(forever(a), "T", forever(a, a))
        assert (outcome.states, outcome.transitions) == (2, 2)
        assert checker(full=True).check_refinement(forever(a, a, a), "T", forever(a, a)).states == 6


class TestProcessesWithoutEnd:
    """What is wrong early on is found although the process cannot be explored."""

    @pytest.fixture(autouse=True)
    def few(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(machines, "BEGINNING", 50)

    def counter(self, n: int = 0) -> Process:
        """``a`` as often as one likes, and ``b`` at most as often; after three more ``a`` than ``b`` also ``c``."""
        down = [then(b, self.counter_at(n - 1))] if n else []
        late = [then(c, STOP)] if n == 3 else []
        return choose(then(a, self.counter_at(n + 1)), *down, *late) if n else then(a, self.counter_at(1))

    def counter_at(self, n: int) -> Process:
        return known(n, self)

    @pytest.mark.parametrize("full", [False, True])
    def test_a_shallow_failure_is_found(self, full: bool) -> None:
        process = self.counter_at(0)
        on = checker(states=300, full=full)
        deadlock = on.check_property(process, "deadlock free").counterexample
        assert deadlock is not None
        assert deadlock.trace == ("a", "a", "a", "c")
        trace = on.check_refinement(Run(events(a, b)), "T", process).counterexample
        assert trace is not None
        assert (trace.trace, trace.event) == (("a", "a", "a"), "c")
        refused = on.check_refinement(Run(events(a, b, c)), "F", process).counterexample
        assert refused is not None
        assert (refused.kind, refused.trace) == ("refusal", ())
        assert on.check_property(process, "has trace", "F", (a, b, a)).verdict is Verdict.PASS
        assert on.check_property(process, "has trace", "F", (a, b, b)).verdict is Verdict.FAIL

    def test_a_trace_is_found(self) -> None:
        on = checker(states=300)
        assert on.check_property(self.counter_at(0), "has trace", "T", (a, b, a, a)).verdict is Verdict.PASS
        assert on.check_property(self.counter_at(0), "has trace", "T", (a, b, b)).verdict is Verdict.FAIL

    def test_what_is_not_found_at_the_beginning_is_unknown(self) -> None:
        on = checker(states=300)
        outcome = on.check_refinement(Run(events(a, b, c)), "T", self.counter_at(0))
        assert outcome.verdict is Verdict.UNKNOWN
        assert on.check_property(self.counter_at(0), "divergence free").verdict is Verdict.UNKNOWN
        assert on.check_property(self.counter_at(0), "has trace", "T", (a,) * 200).verdict is Verdict.UNKNOWN

    def test_where_the_beginning_ends_there_is_no_deadlock(self) -> None:
        numbers: dict[int, Process] = {}

        def ahead(n: int) -> Process:
            if n not in numbers:
                numbers[n] = reference(f"Ahead({n})", lambda: then(a, ahead(n + 1)))
            return numbers[n]

        on = checker(states=300)
        for kind in ("deadlock free", "deterministic"):
            assert on.check_property(ahead(0), kind).verdict is Verdict.UNKNOWN  # type: ignore[arg-type]

    @settings(max_examples=examples(60))
    @given(terms, terms, st.integers(1, 12))
    def test_the_beginning_tells_nothing_but_the_truth(self, p: Process, q: Process, most: int) -> None:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(machines, "BEGINNING", most)
            whole = checker()
            for question in questions(p, q):
                expected = question(whole)
                cut = checker()
                patch.setattr(cut._machines, "packed", never)
                found = question(cut)
                assert found.verdict in (Verdict.UNKNOWN, expected.verdict)
                if found.counterexample is not None and expected.counterexample is not None:
                    assert visible(found) == visible(expected)


def never(*_: object, **__: object) -> object:
    raise Incomplete("no", endless=True)


def visible(outcome: Outcome) -> list[str]:
    assert outcome.counterexample is not None
    return [event for event in outcome.counterexample.trace if event != "tau"]


_counters: dict[int, Process] = {}


def known(n: int, test: TestProcessesWithoutEnd) -> Process:
    if n not in _counters:
        _counters[n] = reference(f"Counter({n})", lambda: test.counter(n))
    return _counters[n]


def test_determinism_in_traces_is_that_in_failures() -> None:
    outcome = checker().check_property(STOP, "deterministic", "T")
    assert outcome.verdict is Verdict.PASS
    assert "checked in F" in outcome.remarks[0]


def test_the_explicit_machine_of_a_process() -> None:
    machine = checker().lts(hidden(forever(a, b), a))
    assert (machine.states, machine.transitions, machine.alphabet()) == (2, 2, (0, b))


def test_time_and_memory_are_reported() -> None:
    outcome = checker().check_property(perhaps(Chaos(events(a)), DIV), "divergence free")
    assert outcome.seconds > 0
    assert outcome.peak_memory_bytes > 0


@pytest.mark.parametrize(
    "definition",
    [
        "P = P",
        "P = P \\ {a}",
        "P = P [[ a <- a ]]",
        "P = P [| {a} |] STOP",
        "P = prioritise(P, <{a}>)",
        "P = prioritise(P \\ {a}, <{a}>) \\ {a}",
        "P = chase(P)",
        "P = sbisim(P) \\ {a}",
        "P = Q \\ {a}\nQ = chase(P)",
    ],
)
def test_what_calls_itself_before_any_event_is_told(definition: str) -> None:
    text = f"channel a\nexternal prioritise, chase\ntransparent sbisim\n{definition}\n"
    loaded = load(Source("itself.csp", text + "assert P :[deadlock free]\nassert STOP [T= P\n"))
    for assertion in loaded.assertions:
        with pytest.raises(ScriptError, match=r"CSP422|CSP501"):
            Checker(loaded).check(assertion.node)
