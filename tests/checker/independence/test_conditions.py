"""Which processes count as data independent, and how many values are said to be enough."""

from __future__ import annotations

import pytest

from cspcheck.checker.independence.answering import for_every_size
from cspcheck.checker.verdict import EverySize, Outcome, Verdict
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source

HEAD = """
channel a, b : T
channel ab : T.T
Copy = a?x -> b!x -> Copy
"""


def claims(text: str, values: int = 2) -> list[EverySize | None]:
    """What is said of ``T``, a datatype if the text has none, by assertion."""
    if "T = " not in text:
        text = f"datatype T = {' | '.join(f't{i}' for i in range(values))}\n{HEAD}{text}"
    return found_in(text)


def found_in(text: str) -> list[EverySize | None]:
    """What is said of the sizes of a type where an assertion passes, by assertion; nothing is searched."""
    script = load(Source("sizes.csp", text))
    outcome = Outcome(Verdict.PASS, None, 0, 0, 0, 0)
    found = [for_every_size(assertion.node, script, outcome) for assertion in script.assertions]
    return [next(iter(sizes), None) for sizes in found]


def claim(text: str, values: int = 2) -> EverySize | None:
    """What is said of ``T`` for the only assertion."""
    (found,) = claims(text, values)
    return found


@pytest.mark.parametrize(
    ("text", "enough"),
    [
        ("assert Copy :[deadlock free]", 1),
        ("assert Copy :[divergence free]", 1),
        ("assert Copy :[deterministic]", 3),  # since some event of the script has two values
        ("assert Copy [FD= Copy", 2),
        ("B(s) = #s < 2 & a?x -> B(s^<x>) [] s != <> & b!head(s) -> B(tail(s))\nassert B(<>) [F= Copy", 2),
        (
            "channel c : T\nC = Copy [[ b <- c ]] [|{|c|}|] Copy [[ a <- c ]]\nassert C \\ {|c|} :[deadlock free]",
            1,
        ),
        ("C = Copy [ b <-> a ] Copy\nassert C :[deadlock free]", 1),
        ("assert [ b <-> a ] i : <1..3> @ Copy :[deadlock free]", 1),
        ("P = |~| x : T @ b!x -> P\nassert P [T= Copy", 2),
        ("assert Copy ||| Copy :[deadlock free]", 1),
        ("assert RUN({| a |}) [T= Copy \\ {| b |}", 2),
    ],
)
def test_what_is_only_passed_on(text: str, enough: int) -> None:
    found = claim(text)
    assert found is not None
    assert (found.tests, found.sufficient, found.tells) == (False, enough, enough <= 2)


@pytest.mark.parametrize(
    ("text", "held", "new"),
    [
        ("channel s\nP = a?x -> a?y -> if x == y then s -> P else P\nassert P :[deadlock free]", 2, 2),
        ("P = a?x -> Q(x, x)\nQ(x, y) = a?z -> (x != z & Q(z, x) [] b!y -> Q(y, z))\nassert P :[deadlock free]", 3, 2),
        ("P = a?x -> b!x -> P\nassert P [| {| a, b |} |] P :[deterministic]", 4, 2),
        ("P = a?x -> a?y:{x} -> P\nassert P :[deadlock free]", 1, 2),
        ("P = a?x -> ((ab.x.x -> STOP) ||| Copy)\nassert P [| {| ab |} |] P :[deadlock free]", 4, 2),
    ],
)
def test_what_is_compared(text: str, held: int, new: int) -> None:
    found = claim(text)
    assert found is not None
    assert found.tests
    assert (found.held, found.new, found.sufficient) == (held, new, held + new)
    more = claim(text, held + new)
    assert more is not None
    assert more.tells
    assert more.least == held + new


@pytest.mark.parametrize(
    "text",
    [
        "P = a?x -> if x == t0 then STOP else P\nassert P :[deadlock free]",
        "P = a.t0 -> P\nassert P :[deadlock free]",
        "P = a?t0 -> P\nassert P :[deadlock free]",
        "P = if card(T) == 2 then STOP else Copy\nassert P :[deadlock free]",
        "P = a?x -> P\nassert ||| x : T @ P :[deadlock free]",
        "assert || x : T @ [{a.x}] a.x -> STOP :[deadlock free]",
        "P(s) = a?x -> P(union(s, {x})) [] card(s) == 2 & STOP\nassert P({}) :[deadlock free]",
        "P = a?x -> (P ||| b!x -> STOP)\nassert P [T= Copy",
        "P = [] x : set(seq(T)) @ a!x -> P\nassert P :[deadlock free]",
        "P = [] x : T @ (a!x -> P |~| b!x -> P)\nassert P :[deadlock free]",
        "P = card({| a |}) == 2 & Copy\nassert P :[deadlock free]",
        "P = {| a |} == {a.x | x <- T} & Copy\nassert P :[deadlock free]",
        "P(s) = a?x -> P(diff(T, {x}))\nassert P(T) :[deadlock free]",
        "S = a?x -> (b?y -> STOP |~| b!x -> STOP)\nassert S [F= Copy",
        "S = (a?x -> b!x -> STOP) \\ {| a |}\nassert S [T= Copy",
        "assert Copy :[has trace]: <a.t0>",
        "assert Copy [V= Copy",
        "P = STOP\nassert P :[deadlock free]",
        "channel c : {t0}\nP = c?x -> P\nassert P :[deadlock free]",
        "subtype U = t0\nchannel c : U\nP = c?x -> Copy\nassert P :[deadlock free]",
    ],
)
def test_nothing_is_said_where_a_condition_fails(text: str) -> None:
    assert claim(text) is None


def test_a_range_of_numbers_is_a_type_of_its_own_where_nobody_calculates() -> None:
    text = "N = 3\nT = {0..N-1}\nchannel a, b : T\nCopy = a?x -> b!x -> Copy\nassert Copy :[deterministic]"
    found = claim(text)
    assert found is not None
    assert (found.type, found.size, found.sufficient, found.tells) == ("T", 3, 2, True)
    assert claim(text.replace("b!x", "b!(x+1)%3")) is None
    assert claim(text.replace("b!x", "b!0")) is None
    assert claim(text.replace("b!x", "x < 2 & b!x")) is None


@pytest.mark.parametrize(
    ("operations", "enough"),
    [
        ("op com_put Delta(s) x? : T where s' = s ^ <x?>\nop com_get Delta(s) y! : T where s = <y!> ^ s'", 2),
        ("op com_put Delta(s) x? : T where s' = <x?> \nop com_get Delta(s) y! : T where s /= <> and y! = last s", 2),
        ("op com_put Delta(s) x? : T where s' in seq T\nop com_get y! : T where s /= <> and y! = s(1)", 2),
        ("op com_put Delta(s) x? : T where x? notin ran s and s' = <x?>\nop com_get y! : T where y! = head s", 7),
        ("op com_put Delta(s) x? : T where s' = <x?>\nop com_get y! : T where y! = head s or y! = last s", 2),
        ("op com_put Delta(s) x? : T where #s < #T and s' = <x?>\nop com_get y! : T where y! = head s", None),
        ("op com_put Delta(s) x? : T where (forall z : T @ z /= x?) and s' = <x?>\nop com_get y! : T", None),
    ],
)
def test_classes(operations: str, enough: int | None) -> None:
    text = f"""given T
reading T = 2
reading seq T = 3
class C
chan put : [x? : T]
chan get : [y! : T]
state s : seq T where #s <= 3
init s = <>
{operations}
end
assert C :[deterministic]
"""
    (found,) = found_in(text.replace("#T", "#{z : T}"))
    assert (None if found is None else found.sufficient) == enough
