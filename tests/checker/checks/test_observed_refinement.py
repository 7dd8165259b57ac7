"""Revivals and refusal testing, held against what their definitions say of all observations up to some length."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import pytest
from hypothesis import assume, given, settings

from cspcheck.checker.check import Checker
from cspcheck.checker.specification import observations
from cspcheck.checker.verdict import Outcome, Verdict
from cspcheck.cspm.process.events import TAU, TICK
from cspcheck.cspm.process.terms import DIV, SKIP, STOP, Compressed, Process
from tests.checker.explicit import A, B, Rows, closure, diverges, terminated
from tests.checker.terms import compositions, processes, told
from tests.checker.textbook import a, b, c, checker, choose, forever, interleave, perhaps, rows_of, then, timeout
from tests.examples import examples

Step = tuple[frozenset[int] | None, int]
"""What is refused first, None if nobody looks, and the event then performed."""
Observation = tuple[tuple[Step, ...], frozenset[int] | None]
"""Steps, and what is refused at the end."""

ALPHABET = (TICK, A, B)
DEPTH = 3


def subsets(of: Iterable[int]) -> list[frozenset[int]]:
    found = [frozenset[int]()]
    for event in of:
        found += [subset | {event} for subset in found]
    return found


def signalling(rows: Rows) -> Rows:
    """The same machine, in which what can tick and do something else can by a tau be SKIP instead."""
    ends = terminated(rows)
    skip = len(rows)
    if not ends:
        return rows
    early = [any(label == TICK for label, _ in row) and len(row) > 1 for row in rows]
    changed: Rows = [
        {(label, t) for label, t in row if label != TICK} | {(TAU, skip)} if is_early else row
        for row, is_early in zip(rows, early, strict=True)
    ]
    return [*changed, {(TICK, min(ends))}]


class Observed:
    """Everything that can be seen of a machine within some steps.

    ``finite``: the observations; ``divergences``: the steps after which it can diverge.
    """

    def __init__(self, machine: Rows, depth: int = DEPTH) -> None:
        rows = signalling(machine)
        ended = terminated(rows)
        self.finite: set[Observation] = set()
        self.divergences: set[tuple[Step, ...]] = set()
        level: dict[tuple[Step, ...], set[int]] = {(): {0}}
        for length in range(depth + 1):
            following: dict[tuple[Step, ...], set[int]] = {}
            for steps, states in level.items():
                settled = closure(rows, states)
                self.finite.add((steps, None))
                if diverges(rows, settled):
                    self.divergences.add(steps)
                for s in settled:
                    for refused in refusals(rows, s, ended):
                        self.finite.add((steps, refused))
                    if length < depth:
                        for label, t in rows[s]:
                            if label != TAU:
                                for before in (None, *refusals(rows, s, ended)):
                                    following.setdefault((*steps, (before, label)), set()).add(t)
            level = following

    def revivals(self) -> set[object]:
        """The traces, deadlocks, and revivals among the observations."""
        found: set[object] = set()
        for steps, refused in self.finite:
            if all(before is None for before, _ in steps):
                found.add(("trace", plain(steps)))
                if refused == frozenset(ALPHABET):
                    found.add(("deadlock", plain(steps)))
            elif all(before is None for before, _ in steps[:-1]):
                before, event = steps[-1]
                found.add(("revival", plain(steps[:-1]), before, event))
        return found


def refusals(rows: Rows, state: int, ended: set[int]) -> list[frozenset[int]]:
    """What a state can be seen to refuse: nothing where it is not stable, or has terminated."""
    offers = {label for label, _ in rows[state]}
    return [] if TAU in offers or state in ended else subsets(set(ALPHABET) - offers)


def plain(steps: tuple[Step, ...]) -> tuple[int, ...]:
    return tuple(event for _, event in steps)


def prefixes(steps: tuple[Step, ...]) -> Iterator[tuple[Step, ...]]:
    return (steps[:i] for i in range(len(steps) + 1))


def violated(spec: Rows, impl: Rows, model: str) -> bool:
    """Whether the implementation has an observation of at most DEPTH steps that the specification lacks."""
    allowed, seen = Observed(spec), Observed(impl)
    if model == "R":
        return not seen.finite <= allowed.finite
    if model == "V":
        return not seen.revivals() <= allowed.revivals()
    if model == "RD":
        lost = allowed.divergences
        wrong = [o for o in seen.finite - allowed.finite if not any(p in lost for p in prefixes(o[0]))]
        return bool(wrong) or any(not any(p in lost for p in prefixes(d)) for d in seen.divergences)
    lost_traces = {plain(d) for d in allowed.divergences}

    def is_lost(trace: tuple[int, ...]) -> bool:
        return any(trace[:i] in lost_traces for i in range(len(trace) + 1))

    wrong_revivals = [o for o in seen.revivals() - allowed.revivals() if not is_lost(o[1])]  # type: ignore[index]
    return bool(wrong_revivals) or any(not is_lost(plain(d)) for d in seen.divergences)


def small_rows(process: Process) -> Rows:
    rows = rows_of(process)
    assume(len(rows) <= 12)
    return rows


def visible_length(outcome: Outcome) -> int:
    assert outcome.counterexample is not None
    return sum(event != "tau" for event in outcome.counterexample.trace)


@pytest.mark.parametrize("model", ["V", "VD", "R", "RD"])
@settings(max_examples=examples(120))
@given(p=processes(events=2, size=6), q=processes(events=2, size=6))
def test_the_verdict_is_what_the_observations_say(model: str, p: Process, q: Process) -> None:
    spec, impl = small_rows(p), small_rows(q)
    outcome = checker().check_refinement(p, model, q)  # type: ignore[arg-type]
    if outcome.verdict is Verdict.PASS:
        assert not violated(spec, impl, model), told(p) + told(q)
    elif visible_length(outcome) < DEPTH:
        assert violated(spec, impl, model), told(p) + told(q)


@pytest.mark.parametrize("model", ["V", "VD", "R", "RD"])
@settings(max_examples=examples(60))
@given(p=compositions(events=2, size=4, components=2, compressions=("diamond",)), q=processes(events=2, size=5))
def test_each_process_refines_what_it_may_be_chosen_from(model: str, p: Process, q: Process) -> None:
    for process in (p, q):
        outcome = checker().check_refinement(perhaps(p, q), model, process)  # type: ignore[arg-type]
        assert outcome.verdict is Verdict.PASS, told(p) + told(q)


@settings(max_examples=examples(100))
@given(processes(size=6), processes(size=6))
def test_richer_models_imply_poorer_ones(p: Process, q: Process) -> None:
    on = checker()
    for richer, poorer in (("R", "V"), ("V", "F"), ("F", "T"), ("RD", "VD"), ("VD", "FD"), ("FD", "T")):
        if on.check_refinement(p, richer, q).verdict is Verdict.PASS:  # type: ignore[arg-type]
            if poorer == "T" and richer == "FD" and on.check_property(p, "divergence free").verdict is Verdict.FAIL:
                continue
            assert on.check_refinement(p, poorer, q).verdict is Verdict.PASS, (richer, told(p), told(q))  # type: ignore[arg-type]


class TestExamples:
    """What tells the models apart (Roscoe 2010, chapters 11 and 12)."""

    def check(self, spec: Process, model: str, impl: Process, on: Checker | None = None) -> Outcome:
        return (on or checker()).check_refinement(spec, model, impl)  # type: ignore[arg-type]

    def test_a_revival_that_no_failure_shows(self) -> None:
        """(a [> STOP) |~| ... can refuse b and then do a only from a state that failures do not tell from STOP."""
        spec = timeout(then(a, STOP), STOP)
        impl = perhaps(then(a, STOP), STOP)
        assert self.check(spec, "F", impl).verdict is Verdict.PASS
        outcome = self.check(spec, "V", impl)
        assert outcome.verdict is Verdict.FAIL
        found = outcome.counterexample
        assert found is not None
        assert (found.kind, found.trace, found.event, found.offered) == ("refusal", ("tau",), "a", ("a",))

    def test_refusals_before_an_event_are_remembered_by_refusal_testing_alone(self) -> None:
        """Whether c comes after a depends on what was refused before a."""
        spec = perhaps(choose(then(a, b, STOP), then(c, STOP)), then(a, c, STOP))
        impl = perhaps(choose(then(a, c, STOP), then(c, STOP)), then(a, b, STOP))
        assert self.check(spec, "FD", impl).verdict is Verdict.PASS
        assert self.check(spec, "V", impl).verdict is Verdict.PASS
        found = self.check(spec, "R", impl).counterexample
        assert found is not None
        assert found.trace == ("tau", "a")
        assert found.event == "b"
        assert found.refusals == (None, ("b", "c"))

    def test_a_divergence_allows_everything_in_the_strict_models_only(self) -> None:
        for model in ("V", "R"):
            assert self.check(DIV, model, STOP).verdict is Verdict.FAIL
            assert self.check(STOP, model, DIV).verdict is Verdict.PASS
            assert self.check(DIV, model + "D", then(a, STOP)).verdict is Verdict.PASS
            outcome = self.check(STOP, model + "D", DIV)
            assert outcome.counterexample is not None
            assert outcome.counterexample.kind == "divergence"

    def test_termination_is_no_deadlock_and_a_deadlock_no_termination(self) -> None:
        for model in ("V", "VD", "R", "RD"):
            assert self.check(SKIP, model, SKIP).verdict is Verdict.PASS
            assert self.check(SKIP, model, STOP).verdict is Verdict.FAIL
            assert self.check(perhaps(SKIP, STOP), model, SKIP).verdict is Verdict.PASS

    def test_compressions_are_looked_through(self) -> None:
        spec = timeout(then(a, STOP), STOP)
        impl = interleave(Compressed("diamond", spec), STOP)
        for model in ("V", "R"):
            assert self.check(interleave(spec, STOP), model, impl).verdict is Verdict.PASS
            assert self.check(impl, model, interleave(spec, STOP)).verdict is Verdict.PASS

    def test_too_much_to_observe_is_unknown(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(observations, "MOST_OBSERVATIONS", 3)
        outcome = self.check(forever(a, b, c), "R", forever(a, b, c))
        assert outcome.verdict is Verdict.UNKNOWN
        assert outcome.reason == "more than 3 different observations of refusals would have to be compared"

    def test_properties_are_those_of_failures(self) -> None:
        for model, verdict in (("V", Verdict.PASS), ("R", Verdict.PASS), ("VD", Verdict.FAIL), ("RD", Verdict.FAIL)):
            assert checker().check_property(DIV, "deadlock free", model).verdict is verdict  # type: ignore[arg-type]
            assert checker().check_property(DIV, "deterministic", model).verdict is verdict  # type: ignore[arg-type]
