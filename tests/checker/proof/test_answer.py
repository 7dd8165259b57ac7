"""Assertions about the data of classes, answered by the checker."""

from __future__ import annotations

import pytest

import cspcheck.checker.proof.messages  # noqa: F401 -- registers its mistakes
from cspcheck.checker.check import Checker
from cspcheck.checker.proof.answer import answer
from cspcheck.checker.proof.client import SolverClient
from cspcheck.checker.verdict import Outcome, Verdict
from cspcheck.cspm.diagnostics import MISTAKES, ScriptError
from cspcheck.cspm.oz.syntax import DataRefinement
from cspcheck.cspm.oz.typing.elaboration import elaborate
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax.tree import AssertDeclaration
from tests.benchmarks.bench_proof import with_fault
from tests.checker.proof.classes import cell

CODES = sorted(code for code in MISTAKES if code.startswith("CSP7"))


def outcomes(text: str) -> list[Outcome]:
    script = load(Source("test.csp", text))
    checker = Checker(script)
    return [checker.check(assertion.node) for assertion in script.assertions]


@pytest.mark.parametrize("code", CODES)
def test_the_example_makes_the_mistake_and_the_repair_does_not(code: str) -> None:
    mistake = MISTAKES[code]
    with pytest.raises(ScriptError) as error:
        outcomes(mistake.example)

    assert [diagnostic.code for diagnostic in error.value.diagnostics] == [code]
    assert outcomes(mistake.repair)


@pytest.mark.parametrize("code", CODES)
def test_titles_and_explanations_are_sentences(code: str) -> None:
    mistake = MISTAKES[code]
    assert mistake.title == mistake.title.strip(". ")
    assert mistake.explanation.strip().endswith(".")
    assert len(mistake.title) < 80


def test_all_obligations_fail_for_an_error_only() -> None:
    """A warning is a remark; asked for by its name, the same obligation fails."""
    text = cell(state="n : 0..9", effect="n' = n + 1")
    whole, single = outcomes(text + "assert Cell :[obligations]\nassert Cell :[carrier kept]\n")

    assert whole.verdict is Verdict.PASS
    assert whole.remarks == ("`carrier kept` of `go`: `n'` leaves the carrier `0..9`: there the operation is blocked",)
    assert single.verdict is Verdict.FAIL


def test_a_failure_has_the_values_and_the_predicate() -> None:
    (outcome,) = outcomes(cell(invariant="n <= 9", effect="n' = n + 2") + "assert Cell :[obligations]\n")

    assert outcome.verdict is Verdict.FAIL
    assert outcome.counterexample is not None
    assert outcome.counterexample.kind == "obligation"
    assert outcome.counterexample.values == {"n": "8", "n'": "10"}
    broken = outcome.counterexample.obligation
    assert broken is not None
    assert (broken.name, broken.operation, broken.failing) == ("invariant preserved", "go", "n' <= 9")


def test_not_turns_the_verdict_round() -> None:
    (outcome,) = outcomes(cell(invariant="n <= 9", effect="n' = n + 2") + "assert not Cell :[invariant preserved]\n")

    assert outcome.verdict is Verdict.PASS


def test_one_operation_by_name() -> None:
    (outcome,) = outcomes(cell(effect="n' = n + 1") + "assert Cell :[deterministic operation]: go\n")

    assert outcome.verdict is Verdict.PASS


def test_no_time_is_unknown() -> None:
    from cspcheck.checker.proof.answer import answer
    from tests.checker.proof.classes import specification

    text = cell(effect="n' = n + 1") + "assert Cell :[feasible]\n"
    script = load(Source("test.csp", text))
    outcome = answer(script.assertions[0].node, specification(text), seconds=0.0)  # type: ignore[arg-type]

    assert outcome.verdict is Verdict.UNKNOWN
    assert outcome.reason == "`feasible` of `go`: the time limit was reached"


def test_a_proof_depends_on_no_reading_and_no_view() -> None:
    (outcome,) = outcomes(cell(effect="n' = n") + "reading nat = 0..1\nview control\nassert Cell :[obligations]\n")
    assert (outcome.readings, outcome.control) == ((), False)


@pytest.mark.parametrize("place", range(2, 9))
def test_the_names_of_a_formula_are_none_of_the_specification(place: int) -> None:
    """A set that several fields share is opened for each of them by itself, whatever its variable is called."""
    sets = "".join(f"S{i} == {{x : real | -1 <= x <= 1}}\n" for i in range(1, place + 1))
    schema = f"schema Speeds\n  a, b, c, d : S{place}\ninit\n  a = 0\nend\n"
    text = "class C\n  chan c : [s? : Speeds]\n  main = c -> main\n  state\n    old : Speeds\n  init\n    old.INIT\n"
    operation = "  op c\n    Delta(old)\n    s? : Speeds\n  where\n    old' = s?\nend\n"
    (outcome,) = outcomes(sets + schema + text + operation + "assert C :[obligations]\n")
    assert outcome.verdict is Verdict.PASS


def test_a_refinement_that_few_values_refute_is_refuted_before_the_solver_is_asked(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    text = with_fault("Ring", "(first + n) mod MAX |-> x?", "(first + n + 1) mod MAX |-> x?")
    tree = parse(Source("ring.csp", text.partition("class Semaphore")[0]))
    (node,) = [d.assertion for d in tree.declarations if isinstance(d, AssertDeclaration)]
    assert isinstance(node, DataRefinement)
    monkeypatch.setattr(SolverClient, "ask", lambda *_: pytest.fail("the solver is asked"))

    found = answer(node, elaborate(tree).specification)

    assert found.verdict is Verdict.FAIL
    assert found.counterexample is not None
    assert found.counterexample.obligation is not None
    assert (found.counterexample.obligation.name, found.counterexample.obligation.operation) == ("correctness", "put")
