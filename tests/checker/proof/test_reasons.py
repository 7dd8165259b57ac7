"""Which lines of a class a proof needed: what is told suffices, nothing of it can be spared, and verdicts stay."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import given, settings

from cspcheck.checker.proof.answer import without_times
from cspcheck.checker.proof.finding import Finding
from cspcheck.checker.proof.obligations import discharge
from cspcheck.checker.proof.prover import Prover
from cspcheck.checker.proof.question import Answer, Constraint, Impossible, Question, SolverSettings
from cspcheck.checker.proof.solver import Solver
from cspcheck.cspm.oz import core
from tests.checker.proof.classes import cell, specification
from tests.checker.proof.small_classes import Small, small_classes
from tests.checker.proof.test_lemmas import LEDGER
from tests.examples import examples


def reasons(text: str, name: str) -> list[Finding]:
    spec = specification(text)
    asked = Prover(spec, list(spec.classes.values())[-1], SolverSettings(reasons=True))
    return list(discharge(asked, [name]))


def used(finding: Finding) -> set[str]:
    assert finding.used is not None
    return {f"{one.what}: {one.text}" for one in finding.used}


def test_the_lines_that_a_proof_needed_are_told_and_no_others() -> None:
    text = cell(
        state="n : nat;k : nat;j : nat",
        invariant="n <= k;j <= 7",
        init="n = 0;k = 9;j = 0",
        delta="n, j",
        effect="n < 9;n > 3;n' = n - 1;j' = 0",
    )

    first, second = reasons(text, "invariant preserved")

    assert used(first) == {
        "invariant: n <= k",
        "effect: n' = n - 1",
        "`k` not in Delta: `k` not in Delta",
    }
    assert used(second) == {"effect: j' = 0"}


def test_a_claim_that_needs_no_line_says_so_and_values_need_none() -> None:
    text = cell(invariant="n >= 0;n <= 5", init="n = 0", effect="n < 5;n' = n + 1")

    first, second = reasons(text, "invariant preserved")
    (feasible,) = reasons(text, "feasible")

    assert used(first) == {"carrier: n' in nat"} or used(first) == {"carrier: n in nat", "effect: n' = n + 1"}
    assert used(second) == {"effect: n < 5", "effect: n' = n + 1"}
    assert feasible.used is None


def test_axioms_and_lemmas_are_among_them() -> None:
    (found,) = reasons(LEDGER.format(claim="sum(s) + sum(t)"), "invariant preserved")

    assert {
        "lemma: lemma `sum_of_two`",
        "effect: log' = log ^ x?",
        "effect: total' = total + sum(x?)",
        "invariant: total = sum(log)",
    } <= used(found)


def test_each_case_tells_what_it_needs() -> None:
    """A proof case by case needs what any of the cases needs."""
    text = cell(
        state="s : seq nat;k : nat",
        invariant="#s <= 3",
        init="s = <>;k = 0",
        delta="s",
        parameters="x? : nat",
        effect="k > 2 or k < 9;if #s < 3 then s' = s ^ <x?> else s' = s",
    )

    (found,) = reasons(text, "invariant preserved")

    assert "effect: if #s < 3 then s' = s ^ <x?> else s' = s" in used(found)
    assert not any("k" in one.split(": ")[1] for one in used(found))


class Recorded(Prover):
    """A prover that keeps what it found out about its proofs."""

    def __init__(self, specification_: core.Specification, model: core.ClassModel, settings_: SolverSettings) -> None:
        super().__init__(specification_, model, settings_)
        self.kept: list[tuple[Constraint, ...]] = []
        needed = self.solver.needed

        def recorded(question: Question) -> tuple[Constraint, ...] | None:
            found = needed(question)
            assert found is not None
            self.kept.append(found)
            return found

        self.solver.needed = recorded  # type: ignore[method-assign]


@settings(max_examples=examples(8))
@given(small_classes())
def test_what_is_told_suffices_alone_and_changes_no_verdict(drawn: Small) -> None:
    spec = specification(drawn.text())
    model = spec.classes["A"]
    asked = Recorded(spec, model, SolverSettings(reasons=True))

    found = without_times(discharge(asked))

    plain = without_times(discharge(Prover(spec, model)))
    assert [replace(finding, used=None) for finding in found] == plain
    alone = Solver(spec, model)
    for parts in asked.kept:
        assert _impossible(alone, parts)
        for part in parts:
            assert not _impossible(alone, tuple(other for other in parts if other is not part)), (part, drawn.text())


def _impossible(solver: Solver, parts: tuple[Constraint, ...]) -> bool:
    answer: Answer = solver.ask(Question(parts))
    return isinstance(answer, Impossible)
