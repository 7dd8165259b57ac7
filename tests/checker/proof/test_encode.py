"""Formulas mean what the terms mean: the solver is held against the obvious interpreter, on random predicates."""

from __future__ import annotations

from typing import Any

from hypothesis import event, given, settings, strategies as st

from cspcheck.checker.proof.question import Constraint, Found, Impossible, Question, SolverSettings
from cspcheck.checker.proof.solver import Solver
from cspcheck.checker.proof.terms import equal
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import BOOL, INT, Apply, Constant, Term, Variable
from cspcheck.cspm.oz.values.values import Graph
from tests.cspm.oz.naive import NAMES, PAIR, environments, interpret, terms
from tests.examples import examples

SPECIFICATION = core.Specification()
WIDE = frozenset(["Int", "Nat", "Nat1"])
"""Operators that are sets without end."""


def mentions(term: Term, operators: frozenset[str]) -> bool:
    """Whether one of some operators occurs in a term."""
    own = isinstance(term, Apply) and term.operator in operators
    return own or any(mentions(part, operators) for part in core.parts(term))


def ground(value: Any, type_: core.Type) -> Term:
    """A value as a term."""
    match type_:
        case core.SetType(element=element):
            return Apply(type=type_, operator="set", operands=tuple(ground(v, element) for v in sorted(value)))
        case core.SequenceType(element=element):
            return Apply(type=type_, operator="sequence", operands=tuple(ground(v, element) for v in value))
        case core.TupleType(items=items):
            return Apply(
                type=type_, operator="tuple", operands=tuple(ground(v, t) for v, t in zip(value, items, strict=True))
            )
        case core.FunctionType():
            assert isinstance(value, Graph)
            return Apply(
                type=type_, operator="function", operands=tuple(ground(pair, PAIR) for pair in sorted(value.items()))
            )
    return Constant(type=type_, value=value)


def asked(predicate: Term, env: dict[str, Any], scopes: tuple[int, ...]) -> Question:
    """Whether a predicate holds in an environment, as a question to the solver."""
    known = [Constraint(equal(v, ground(env[v.name], v.type)), "value") for v in variables()]
    return Question((*known, Constraint(predicate, "claim")), tuple(variables()))


def variables() -> list[Variable]:
    return [Variable(type=type_, name=name, role="before") for name, type_ in NAMES.items()]


@settings(max_examples=examples(25))
@given(st.data(), environments, st.sampled_from([None, 3]))
def test_a_predicate_is_impossible_exactly_where_it_is_false_or_undefined(
    data: st.DataObject, env: dict[str, Any], scope: int | None
) -> None:
    predicate = data.draw(terms(BOOL))
    holds = interpret(predicate, env) is True
    solver = Solver(SPECIFICATION, settings=SolverSettings(seconds=0.5))
    question = asked(predicate, env, ())
    attempt = solver._attempt(question, list(question.parts), scope, 0.3)
    event(f"{attempt.result}, holds: {holds}")

    if attempt.result == "unsat":
        assert not holds
    if attempt.found is not None:
        assert holds


@settings(max_examples=examples(25))
@given(st.data(), environments)
def test_what_is_impossible_is_false_whatever_the_values(data: st.DataObject, env: dict[str, Any]) -> None:
    """Nothing but the predicate: a proof must hold for the values that Hypothesis draws."""
    predicate = data.draw(terms(BOOL, depth=2))
    answer = Solver(SPECIFICATION, settings=SolverSettings(seconds=0.5)).ask(
        Question((Constraint(predicate, "claim"),))
    )
    event(type(answer).__name__)

    if isinstance(answer, Impossible):
        assert interpret(predicate, env) is not True
    if isinstance(answer, Found):
        # A set that is not finite is no value for the interpreter; the evaluator has vouched for some of those.
        finite = {v.name: value for v, value in answer.values.items() if not mentions(value, WIDE)}
        event(f"finite: {len(finite) == len(answer.values)}")
        if len(finite) == len(answer.values):
            values = {name: interpret(value, {}) for name, value in finite.items()}
            assert answer.vouched or interpret(predicate, {**env, **values}) is True


def test_the_traps_of_cardinality() -> None:
    """What the solver's own theory of finite sets answers wrongly."""
    from tests.checker.proof.classes import cell, findings

    two = "a, b : finset int"
    for claim in ("#a = 0; a != {}", "a subseteq b; #a = #b; a != b", "#a = 1; #b = 1; a subseteq b; a != b"):
        found = findings(cell(state=f"n : int; {two}", init="true", effect=f"{claim}; n' = 1"), "feasible")
        assert [f.status for f in found] == ["refuted"], claim


def test_extensional_equality_of_sequences() -> None:
    """Two sequences with the same items are the same, however they came about."""
    from tests.checker.proof.classes import cell, findings

    claims = "tail (<1> ^ s) = s; front (s ^ <1>) = s; rev(rev(s)) = s; <> ^ s = s; (s ^ <1>) ^ <2> = s ^ <1, 2>"
    for claim in claims.split(";"):
        text = cell(state="s : seq int", init="s = <>", delta="s", invariant=claim, effect="s' = s ^ <1>")
        assert [f.status for f in findings(text, "invariant preserved")] == ["proved"], claim


def test_integer_division_has_no_value_for_zero() -> None:
    zero = Constant(type=INT, value=0)
    quotient = Apply(type=INT, operator="div", operands=(zero, zero))
    answer = Solver(SPECIFICATION).ask(Question((Constraint(equal(quotient, zero), "claim"),)))

    assert isinstance(answer, Impossible)
