"""Operations made of operations: what is unfolded to predicates is held against relations that are gone through."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

import pytest
from hypothesis import event, given, settings, strategies as st

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.objects.document import mistakes, signatures
from cspcheck.cspm.oz.typing.elaboration import elaborate
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.source import Source
from tests.cspm.oz.naive import interpret
from tests.cspm.oz.test_meaning import outcome
from tests.examples import examples

VALUES = range(3)
STATE = ("x", "y")
CLASS = """
class C
  visible op
  state
    x, y : 0..2
  where
    x + y <= 3
  op in_x = [Delta(x); k? : 0..2 | x' = k?]
  op out_x = [k! : 0..1 | k! = x]
  op out_y = [Delta(y); k! : 0..2 | k! = y; y' = 0]
  op up = [Delta(x) | x' = x + 1]
  op swap = [Delta(x, y) | x' = y; y' = x]
  op low = [x < y]
  op in_m = [Delta(y); m? : 0..2 | y' = m?]
  op op = {body}
end
"""


@dataclass(frozen=True)
class Relation:
    """An operation as what it allows: the variables that it may change, its parameters, and a test."""

    delta: frozenset[str]
    parameters: Mapping[str, frozenset[int]]
    holds: Callable[[Mapping[str, int], Mapping[str, int], Mapping[str, int]], bool]
    """Of the state before, the parameters by their decorated names, and the state after."""


def base(delta: str, parameters: dict[str, int], holds: Callable[..., bool]) -> Relation:
    sets = {name: frozenset(range(most + 1)) for name, most in parameters.items()}
    return Relation(frozenset(delta), sets, lambda b, p, a: all(p[n] in s for n, s in sets.items()) and holds(b, p, a))


BASES = {
    "in_x": base("x", {"k?": 2}, lambda b, p, a: a["x"] == p["k?"]),
    "out_x": base("", {"k!": 1}, lambda b, p, a: p["k!"] == b["x"]),
    "out_y": base("y", {"k!": 2}, lambda b, p, a: p["k!"] == b["y"] and a["y"] == 0),
    "up": base("x", {}, lambda b, p, a: a["x"] == b["x"] + 1),
    "swap": base("xy", {}, lambda b, p, a: a["x"] == b["y"] and a["y"] == b["x"]),
    "low": base("", {}, lambda b, p, a: b["x"] < b["y"]),
    "in_m": base("y", {"m?": 2}, lambda b, p, a: a["y"] == p["m?"]),
}


def states() -> list[dict[str, int]]:
    return [dict(zip(STATE, values, strict=True)) for values in product(VALUES, repeat=2)]


def kept(names: frozenset[str], b: Mapping[str, int], a: Mapping[str, int]) -> bool:
    return all(b[name] == a[name] for name in names)


def merged(left: Relation, right: Relation) -> dict[str, frozenset[int]]:
    both = dict(left.parameters)
    for name, values in right.parameters.items():
        both[name] = both.get(name, values) | values
    return both


def conjunction(left: Relation, right: Relation) -> Relation:
    return Relation(
        left.delta | right.delta,
        merged(left, right),
        lambda b, p, a: left.holds(b, p, a) and right.holds(b, p, a),
    )


def alternative(left: Relation, right: Relation) -> Relation:
    delta = left.delta | right.delta
    sets = merged(left, right)

    def holds(b: Mapping[str, int], p: Mapping[str, int], a: Mapping[str, int]) -> bool:
        # An alternative leaves open what only the other declares, but for the set that it is in.
        return all(p[name] in values for name, values in sets.items()) and any(
            one.holds(b, p, a) and kept(delta - one.delta, b, a) for one in (left, right)
        )

    return Relation(delta, sets, holds)


def hiding(one: Relation, names: frozenset[str]) -> Relation:
    def holds(b: Mapping[str, int], p: Mapping[str, int], a: Mapping[str, int]) -> bool:
        values = product(*[one.parameters[name] for name in sorted(names)])
        return any(one.holds(b, {**p, **dict(zip(sorted(names), v, strict=True))}, a) for v in values)

    return Relation(one.delta, {n: v for n, v in one.parameters.items() if n not in names}, holds)


def renaming(one: Relation, names: Mapping[str, str]) -> Relation:
    """*names* has the new name of each old one."""
    parameters: dict[str, frozenset[int]] = {}
    for name, values in one.parameters.items():
        new = names.get(name, name)
        parameters[new] = parameters.get(new, values) | values
    return Relation(
        one.delta,
        parameters,
        lambda b, p, a: one.holds(b, {name: p[names.get(name, name)] for name in one.parameters}, a),
    )


def connected(left: Relation, right: Relation) -> tuple[Relation, Relation, frozenset[str]]:
    """Outputs of the left and inputs of the right of one name, as one parameter."""
    names = {n[:-1] for n in left.parameters if n[-1] == "!"} & {n[:-1] for n in right.parameters if n[-1] == "?"}
    left = renaming(left, {f"{name}!": f"{name}>" for name in names})
    right = renaming(right, {f"{name}?": f"{name}>" for name in names})
    return left, right, frozenset(f"{name}>" for name in names)


def parallel(left: Relation, right: Relation) -> Relation:
    left, right, there = connected(left, right)
    right, left, back = connected(right, left)
    # What was told from left to right and what from right to left are different values.
    return hiding(conjunction(left, right), there | back)


def sequence(left: Relation, right: Relation) -> Relation:
    left, right, there = connected(left, right)
    delta = left.delta | right.delta

    def holds(b: Mapping[str, int], p: Mapping[str, int], a: Mapping[str, int]) -> bool:
        for middle in states():
            if sum(middle.values()) > 3 or not kept(frozenset(STATE) - left.delta, b, middle):
                continue
            if left.holds(b, p, middle) and right.holds(middle, p, a) and kept(delta - right.delta, middle, a):
                return True
        return False

    return hiding(Relation(delta, merged(left, right), holds), there)


JOINED = {"and": conjunction, "or": alternative, "[]": alternative, ";": sequence, "||": parallel}


@st.composite
def expressions(draw: st.DrawFn, depth: int = 2) -> tuple[str, Relation]:
    """The text of an expression with the relation that it stands for."""
    if depth == 0 or draw(st.integers(0, 5)) == 0:
        name = draw(st.sampled_from(sorted(BASES)))
        return name, BASES[name]
    text, relation = draw(expressions(depth - 1))
    kind = draw(st.integers(0, 8))
    names = sorted(relation.parameters)
    if kind == 0 and names:
        hidden = draw(st.lists(st.sampled_from(names), min_size=1, unique=True))
        return f"({text}) \\ ({', '.join(hidden)})", hiding(relation, frozenset(hidden))
    if kind == 1 and names:
        old = draw(st.sampled_from(names))
        new = draw(st.sampled_from(["k", "m", "j"])) + draw(st.sampled_from("?!"))
        return f"({text})[{new}/{old}]", renaming(relation, {old: new})
    if kind == 2:
        i = f"i{depth}"
        chosen = draw(st.sampled_from([("[]", any), ("and", all)]))
        guard = f"[x < {i} or y = {i}]"

        def holds(b: Mapping[str, int], p: Mapping[str, int], a: Mapping[str, int]) -> bool:
            return chosen[1](relation.holds(b, p, a) and (b["x"] < v or b["y"] == v) for v in (1, 2))

        made = Relation(relation.delta, relation.parameters, holds)
        return f"({chosen[0]} {i} : 0..2 | {i} > 0 @ {guard} and ({text}))", made
    other, second = draw(expressions(depth - 1))
    sign = draw(st.sampled_from(sorted(JOINED)))
    return f"({text}) {sign} ({other})", JOINED[sign](relation, second)


def operation(body: str) -> tuple[core.ClassModel, core.Operation]:
    script = parse(Source("calculus.csp", CLASS.format(body=body)))
    model = elaborate(script).specification.classes["C"]
    return model, model.operations["op"]


@settings(max_examples=examples(40), deadline=None)
@given(expressions())
def test_an_expression_allows_what_its_relation_allows(found: tuple[str, Relation]) -> None:
    text, relation = found
    _, made = operation(text)
    names = {p.name + {"input": "?", "output": "!"}[p.kind]: (p.name, p.kind) for p in made.parameters}
    assert set(names) == set(relation.parameters)
    assert set(made.delta) == relation.delta
    event(f"{len(names)} parameters")

    values = [dict(zip(names, v, strict=True)) for v in product(VALUES, repeat=len(names))]
    for before, parameters, after in product(states(), values, states()):
        if not kept(frozenset(STATE) - relation.delta, before, after):
            continue
        env: dict[Any, Any] = {(n, "before"): v for n, v in before.items()}
        env |= {(n, "after"): v for n, v in after.items()} | {names[n]: v for n, v in parameters.items()}
        carried = all(
            interpret(
                core.Apply(
                    type=core.BOOL,
                    operator="in",
                    operands=(core.Variable(type=p.type, name=p.name, role=p.kind), p.carrier),
                ),
                env,
            )
            for p in made.parameters
        )
        allowed = carried and all(interpret(term, env) is True for term in made.effect)
        assert allowed == relation.holds(before, parameters, after), (text, before, parameters, after)


@settings(max_examples=examples(60), deadline=None)
@given(expressions())
def test_its_parameters_are_those_that_are_found_with_objects_as_references(found: tuple[str, Relation]) -> None:
    text, relation = found
    script = parse(Source("calculus.csp", CLASS.format(body=text)))
    assert mistakes(script.declarations) == []
    assert set(signatures(script.declarations, "C")["op"]) == set(relation.parameters)


def refused(body: str) -> str:
    with pytest.raises(ScriptError) as error:
        operation(body)
    return error.value.diagnostics[0].message


def test_enrichment_puts_what_the_first_declares_in_reach_of_the_second() -> None:
    _, made = operation("[n? : 1..2 | n? > x] @ [Delta(y) | y' = n?]")
    assert [(p.name, p.kind) for p in made.parameters] == [("n", "input")]
    assert made.delta == ("y",)


def test_what_the_open_parallel_operator_tells_stays_an_output() -> None:
    _, made = operation("out_y ||! in_x")
    assert [(p.name, p.kind) for p in made.parameters] == [("k", "output")]


def test_a_sequence_is_distributed_over_elements_that_are_written_out() -> None:
    _, made = operation("; i : <1, 2> @ [Delta(x) | x' = x + i]")
    env = {("x", "before"): 0, ("y", "before"): 0, ("y", "after"): 0}
    assert [v for v in range(6) if all(interpret(e, {**env, ("x", "after"): v}) for e in made.effect)] == [3]


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("up ; sideways", "`sideways` is no operation of the class"),
        ("in_x \\ (k!)", "`k!` is no parameter of this operation"),
        ("[] i : 0..2 @ [i = true]", "the types `int` and `bool` differ"),
    ],
)
def test_what_has_no_meaning_is_refused_for_its_own_reason(body: str, message: str) -> None:
    assert message in refused(body)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("up ; op", "`op` is defined by itself"),
        ("; i : 0..2 @ up", "how many operations these are is not known"),
    ],
)
def test_what_has_no_finite_unfolding_is_typed_and_not_run(body: str, message: str) -> None:
    text = CLASS.format(body=body)
    found = elaborate(parse(Source("calculus.csp", text)))
    assert "C" not in found.specification.classes
    assert [(w.code, message in w.message) for w in found.warnings] == [("CSP673", True)]
    with pytest.raises(ScriptError) as error:
        elaborate(parse(Source("calculus.csp", f"{text}\nassert C :[deadlock free]\n")))
    assert message in error.value.diagnostics[0].message


def test_a_renaming_of_what_is_not_there_changes_nothing_and_is_told() -> None:
    found = elaborate(parse(Source("calculus.csp", CLASS.format(body="in_x[j?/m?]"))))
    assert [p.name for p in found.specification.classes["C"].operations["op"].parameters] == ["k"]
    assert [w.message for w in found.warnings] == ["`m?` is no parameter of this operation"]


def test_names_are_exchanged_by_one_renaming() -> None:
    _, made = operation("[k? : 1..2; m? : 3..4 | k? < x][m?/k?, k?/m?]")
    assert {p.name: str(p.carrier.operands[0].value) for p in made.parameters} == {"m": "1", "k": "3"}


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("in_x[j?/k?, m?/k?]", "`k?` is renamed twice"),
        ("[z' : nat] ; [z : power nat]", "`z'` is of type `int`, and `z` in the next operation `power int`"),
        ("[k? : nat] and [k? : power nat]", "`k?` is of type `int` in one operand and `power int` in the other"),
    ],
)
def test_what_does_not_go_together_is_told(body: str, message: str) -> None:
    assert message in refused(body)


def test_what_both_operands_tell_and_hear_is_not_passed_on() -> None:
    _, made = operation("[k? : 1..2; k! : 1..2] || [k? : 1..2; k! : 1..2]")
    assert sorted(p.kind for p in made.parameters) == ["input", "output"]


def test_a_schema_in_brackets_is_renamed() -> None:
    text = """class A
  op q = [x? : 0..1; y : 0..2 | y = x? + 1][a?/x?, b!/y]
  op r = [x? : 0..1] and [y? : 0..1][z?/y?]
end
"""
    for trace, verdict in (("q.1.2, r.0.1", "pass"), ("q.1.1", "fail")):
        assertion = f"A :[has trace]: <{trace}>"
        assert outcome(f"{text}assert {assertion}", assertion)[0] == verdict
