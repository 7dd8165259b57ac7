"""Data parts written as processes with parameters: the same behaviour as the class, state by state."""

from __future__ import annotations

import re

import pytest
from hypothesis import event, given, settings, strategies as st

from cspcheck.checker.semantics.transitions import explore
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.notation import ClassReading
from cspcheck.cspm.script import Script, load
from cspcheck.cspm.source import Source
from cspcheck.exporting import plain_text
from tests.cspm.oz.test_meaning import classes
from tests.examples import examples

Machine = list[set[tuple[str, int]]]


def machine(script: Script, name: str) -> tuple[Machine, int]:
    """The transitions of each state of a process, by what their events are called outside of classes."""
    lts = explore(script.process(name)).lts
    names = {
        label: script.events.name(label).replace("::", "_") for s in range(lts.states) for label, _ in lts.successors(s)
    }
    return [{(names[label], target) for label, target in lts.successors(s)} for s in range(lts.states)], lts.root


def bisimilar(one: tuple[Machine, int], other: tuple[Machine, int]) -> bool:
    """Whether two machines are strongly bisimilar, by splitting until nothing splits."""
    shift = len(one[0])
    states = [*one[0], *[{(label, target + shift) for label, target in state} for state in other[0]]]
    block = [0] * len(states)
    while True:
        seen: dict[object, int] = {}
        new = [
            seen.setdefault((block[s], frozenset((label, block[t]) for label, t in state)), len(seen))
            for s, state in enumerate(states)
        ]
        if len(seen) == len(set(block)):
            return block[one[1]] == block[other[1] + shift]
        block = new


def written(text: str, **semantics: str) -> tuple[Script, Script, str]:
    chosen = ClassReading(**semantics)  # type: ignore[arg-type]
    plain = plain_text(load(Source("classes.csp", text), semantics=chosen)).text
    return load(Source("classes.csp", text), semantics=chosen), load(Source("plain.csp", plain)), plain


def same(text: str, **semantics: str) -> str:
    """The script without classes, whose process C is that of the class."""
    script, plain, result = written(text, **semantics)
    assert plain.classes is None
    assert bisimilar(machine(script, "C"), machine(plain, "C")), result
    return result


@settings(max_examples=examples(5))
@given(classes(), st.sampled_from(["angelic", "demonic"]))
def test_random_classes_keep_their_behaviour(text: str, outputs: str) -> None:
    try:
        explore(load(Source("c.csp", text)).process("C"))
    except ScriptError:
        return  # no initial state
    result = same(text, outputs=outputs)
    event("with parameters" if re.search(r"^C_data\(n, m, s\) =", result, re.MULTILINE) else "a process a state")
    assert "C_data(n, m, s) =" in result


PREDICATES = [
    "n < 2 and n' = n + 1 and s' = s and f' = f and t' = t",
    "n' = (n * 2 + 1) mod 3 and s' = s and f' = f and t' = t",
    "n' = abs (n - 2) and s' = <n> ^ <n'> and f' = f and t' = t",
    "n' = n and #s < 2 and s' = s ^ <n> and f' = f and t' = t",
    "n' = n and s /= <> and s' = tail s and f' = f and t' = t",
    "s = <n'> ^ s' and f' = f and t' = t",
    "s = s' ^ <n'> and f' = f and t' = t",
    "#s < 2 and n' = #s and s' = rev s ^ <n> and f' = f and t' = t",
    "s /= <> and n' = last s and s' = front s and f' = f and t' = t",
    "s /= <> and n' = s(1) and s' = <> and f' = f and t' = t",
    "n' = (n + 1) mod 3 and s' = <n, 1> filter t and f' = f and t' = t union {n}",
    "n' = n and s' = s and f' = f (+) {n mod 2 |-> true} and t' = t",
    "f(n mod 2) = false and n' = n and s' = s and f' = f (+) {0 |-> true, 1 |-> true} and t' = t",
    "n' = #t and s' = s and f' = f and t' = t \\ {n}",
    "n' = n and s' = s and f' = f and (t' = {} or t' = {n, 2})",
    "n notin t and n' = n and s' = s and f' = f and t' = {k : 0..2 | k <= n @ k}",
    "n' = max (t union {0}) and s' = s and f' = f and t' = t symdiff {n, 1}",
    "(exists k : t @ k > n) and n' = min t and s' = s and f' = f and t' = t",
    "(forall k : t @ k <= n) and (exists1 k : 0..2 @ k = n') and n' > n and s' = s and f' = f and t' = t union {n'}",
    "n' = n and s' = s and f' = (lambda k : 0..1 @ k in t) and t' = t union {n}",
    "n' = n and s' = s and f' = f and t' = dom (f |> {true})",
    "n' = n and s' = s and f' = f and t' = ran s",
    "((n, 1) = (1, 1) => n' = 2) and s' = s and f' = f and t' = t and (n = n' <=> n = 2)",
    "n' in {n, 0} and n' /= n and s' = s and f' = f and t' subset t",
    "n' = n and (s prefix <0, 1, 2>) and s' = <0> ^ s and #s < 2 and f' = f and t' = t",
]


@pytest.mark.parametrize("predicate", PREDICATES)
def test_predicates_are_written_as_expressions(predicate: str) -> None:
    text = f"""class C
  chan op1, grow, pick
  state n : 0..2; s : seq (0..2); f : 0..1 --> bool; t : power (0..2)
  where #s <= 2
  init n = 0 and s = <> and t = {{1}} and f = {{0 |-> false, 1 |-> true}}
  op op1 Delta(n, s, f, t) where {predicate}
  op grow Delta(n, t) where n' = (n + 1) mod 3 and t' = t union {{n'}}
  op pick Delta(s) where s' = s ^ <n>
end
"""
    assert "C_data(n, s, f, t) =" in same(text)


RECORDS = """
LIGHT ::= off | on<<0..2>>
given USER
reading USER = 2
const most : nat where most = 2 end
schema Pair
  x : 0..2
  y : bool
end
class C
  chan put : [p? : Pair]
  chan get : [x! : 0..2]
  chan light : [l! : LIGHT; by : USER]
  state p : Pair; q : (0..2) cross bool; l : LIGHT; users : power USER
  init p.x = 0 and p.y = true and q = (1, false) and l = off and users = {}
  op put Delta(p, l) p? : Pair where p' = p? and (if p?.y = true then l' = on(p?.x) else l' = off)
  op get Delta(q) x! : 0..2 where x! = p.x and q' = (p.x, p.y)
  op light Delta(users) l! : LIGHT; by : USER where l! = l and users' = users union {by} and #users < most
end
"""


def test_records_tuples_and_free_types_are_written() -> None:
    result = same(RECORDS)

    assert "C_data(p, q, l, users) =" in result


PAIRS = [
    "r' = r comp r and b' = b and n' = n",
    "r' = r~ and b' = b and n' = n",
    "r' = r^+ and b' = b and n' = n",
    "r' = r^* and b' = b and n' = n",
    "r' = id (0..1) and b' = b and n' = n",
    "n' in r(|{n}|) and r' = r and b' = b",
    "r' = r (+) {(n, 1)} and b' = b and n' = n",
    "r' = {n} <| r and b' = b and n' = n",
    "r' subset r and b' = b and n' = n",
    "n' in dom r and n' in ran r and r' = r and b' = b",
    "r' = r and b' = b and n' = n and (n, 1) in r and #r = 1",
    "r' = r and b' = [[n]] and n' = 1 - n",
    "r' = r and n inbag b and b' = [[n, n]] and n' = n",
    "r' = r and b' = b and n' = count(b, n) and n' <= 1",
    "r' = r and b' = items(<n, 1>) and n' = n",
    "r' = r and b' = [[0]] bag_union [[n]] and n' = n",
    "r' = r and dom b = {n} and b' = b and n' = 1 - n",
    "<n> suffix <0, 1> and n' = 0 and r' = r and b' = b",
    "<n, 0> infix <0, 1, 0> and n' = 0 and r' = r and b' = b",
    "<0> = {n} extract <0, 1> and n' = 0 and r' = r and b' = b",
    "<n> = squash (lambda k : 2..2 @ 1) and n' = 0 and r' = r and b' = b",
]


@pytest.mark.parametrize("predicate", PAIRS)
def test_relations_and_bags_are_written_as_pairs_and_maps(predicate: str) -> None:
    text = f"""class C
  chan op1, grow, fill
  state r : (0..1) <-> (0..1); b : bag (0..1); n : 0..1
  where forall i : 0..1 @ count(b, i) <= 2
  init r = {{(0, 1)}} and b = [[]] and n = 0
  op op1 Delta(r, b, n) where {predicate}
  op grow Delta(r) where r' = r union {{(1, n)}}
  op fill Delta(b) where b' = [[1]]
end
"""
    assert "C_data(r, b, n) =" in same(text)


def test_what_has_no_form_becomes_a_process_a_state() -> None:
    text = """class C
  chan step
  state x : real
  init x = 0.5
  op step Delta(x) where x < 2.0 and x' = x * 2.0
end
"""
    result = same(text)

    assert "C_0 = step -> C_1" in result


def test_names_of_the_script_are_kept_apart_from_those_that_are_made() -> None:
    text = """channel C_data, x_
datatype T = n | C_done
class C
  chan step : [k? : 0..1]
  main = step -> main [] step -> SKIP
  state n : 0..1
  init n = 0
  op step Delta(n) k? : 0..1 where n' = k?
end
P = C_data -> C
"""
    result = same(text)

    assert "C_data_(n__) =" in result
    assert bisimilar(machine(load(Source("c.csp", text)), "P"), machine(load(Source("p.csp", result)), "P"))


def test_a_stack_is_as_long_as_its_class() -> None:
    text = """class C
  chan push : [v? : 0..3]
  chan pop : [v! : 0..3]
  state s : seq (0..3)
  where #s <= 4
  init s = <>
  op push Delta(s) v? : 0..3 where s' = <v?> ^ s
  op pop Delta(s) v! : 0..3 where s = <v!> ^ s'
end
"""
    result = same(text)

    assert "  ([] v : {v | v <- {0..3}, #(<v>^s) <= 4} @ push.v -> C_data(<v>^s))" in result.splitlines()
    assert "  [] (1 <= #s and #tail(s) <= 4 & pop.head(s) -> C_data(tail(s)))" in result.splitlines()
