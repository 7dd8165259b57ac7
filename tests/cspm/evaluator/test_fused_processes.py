"""Definitions that are fused, and explored by their menus, are held against the closures, explored by terms."""

from __future__ import annotations

import random
import re
from typing import Any

import pytest

from cspcheck.checker.lts import Lts
from cspcheck.checker.network.components import ALONE, ComponentMachines
from cspcheck.checker.semantics.menus import States
from cspcheck.checker.semantics.transitions import MoreStates, Semantics, breadth_first
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.evaluator import routines
from cspcheck.cspm.process.text import describe
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from tests.examples import examples

DECLARATIONS = r"""
N = 3
datatype D = A | B.{0..2} | C.Bool.{0..1}
channel a, b
channel n : {0..3}
channel d : D
channel p : {0..2}.{0..2}
channel q : {0..1}.Bool.D
half(x) = x / 2
swap(B.x) = B.((x + 1) % 3)
swap(A) = C.true.1
swap(y) = A
"""
MOST = 400

Found = tuple[list[int], list[int], list[int], list[str], list[str]] | str


def found(text: str, monkeypatch: pytest.MonkeyPatch, *, fused: bool) -> tuple[Found, bool]:
    """The machine of P with what its states are and are called, or the failure; and whether menus were used."""
    monkeypatch.setattr(routines, "HOT", 0 if fused else 10**9)
    script = load(Source("fused.csp", text))
    semantics = Semantics()
    try:
        initial = semantics.state(script.process("P"))
        if fused:
            explored = ComponentMachines(semantics).of(initial, ALONE, MOST)
        else:
            explored = breadth_first(initial, semantics.transitions, MOST)
    except ScriptError as error:
        return "\n".join(f"{found.code} {found.message} {found.span}" for found in error.diagnostics), fused
    except MoreStates as more:
        return f"more: {[name(state, semantics) for state in more.terms]}", fused
    lts: Lts = explored.lts
    terms = list(explored.terms)
    shown = [describe(term, script.events) for term in terms]
    menus = isinstance(explored.terms, States) and len(explored.terms.others) < len(terms)
    arrays = lts.offsets.tolist(), lts.labels.tolist(), lts.targets.tolist()
    return (*arrays, shown, [name(term, semantics) for term in terms]), menus


def name(state: object, semantics: Semantics) -> str:
    reference = semantics.heads.name(state)  # type: ignore[arg-type]
    return "" if reference is None else reference.text


SCRIPTS = {
    "inputs": "P = Q(<>)\nQ(s) = #s < 3 & n?x -> Q(s^<x>) [] #s > 0 & p.0!head(s) % 3 -> Q(tail(s))",
    "patterns": "P = Q(<>)\nQ(<>) = n?x:{1..2} -> Q(<x>)\nQ(<x>^s) = n!x -> Q(s) [] #s < 2 & n?y -> Q(<x>^s^<y>)",
    "sets": "P = S({})\nS(v) = n?x:diff({0..3}, v) -> S(union(v, {x})) [] n?x:inter(v, {0, 1}) -> S(diff(v, {x}))",
    "maps": "P = M(mapFromList(<(k, 0) | k <- <0..2>>))\n"
    "M(m) = p?k?v:{(mapLookup(m, k) + 1) % 3} -> M(mapUpdate(m, k, v)) [] ([] k:{0..2} @ p.k!mapLookup(m, k) -> M(m))",
    "datatypes": "P = T(A, true)\n"
    "T(x, y) = d!x -> T(swap(x), not y) [] y & d?B.z -> T(B.z, y) [] q?i?c!x -> T(C.c.i, c)",
    "equal bodies": "P = Q(0, 0)\n"
    "Q(i, j) = i < 3 & a -> Q(i + 1, j + 2) [] i < 3 & b -> Q(i + 1, j) [] i == 3 & n?x -> P",
    "names at the head": "P = Q(0)\nQ(i) = i < 3 & R(i + 1, false) [] i > 0 & b -> Q(i - 1)\n"
    "R(i, z) = (a -> Q(i) [] b -> R(i, true)) [] z & R(i, false)",
    "taus": "P = Q(0)\nQ(i) = if i < 3 then a -> Q(i + 1) else (b -> P |~| n!i -> Q(0))",
    "terms in place": "P = Q(0)\nQ(i) = a -> b -> Q((i + 1) % 3) [] n!i -> (a -> SKIP [] b -> Q(i))",
    "local": "P = Q(0)\nQ(i) = let R(j) = n!j -> R((j + i) % 4) [] a -> Q((i + 1) % 3) within R(i)",
    "a mistake": "P = Q(0)\nQ(i) = a -> Q(i + 1) [] n!i -> Q(i)",
    "a mistake that nobody sees": "P = Q(0, 1)\nQ(i, j) = i < 3 & a -> Q(i + 1, 1 / (i - 1))",
    "an endless argument": "P = Q(0, <0..>)\nQ(i, s) = n!i -> Q((i + 1) % 3, s)",
    "itself": "P = Q(0)\nQ(i) = i < 3 & a -> Q(i + 1) [] i == 3 & Q(i)",
    "no end": "P = Q(0)\nQ(i) = a -> Q(i + 1)",
    "nothing": "P = Q(0)\nQ(i) = i < 3 & a -> Q(i + 1)",
}


@pytest.mark.parametrize("text", SCRIPTS.values(), ids=SCRIPTS)
def test_fused_definitions_are_what_the_closures_are(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    plain, _ = found(DECLARATIONS + text, monkeypatch, fused=False)
    fused, menus = found(DECLARATIONS + text, monkeypatch, fused=True)
    assert fused == plain
    assert menus


class Writer:
    """Writes definitions of four parameters at random: a number, a sequence, a set and a value of a datatype."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.depth = 0

    def one_of(self, *texts: str) -> str:
        return self.random.choice(texts)

    def number(self, names: list[str]) -> str:
        x = self.random.choice([*names, str(self.random.randrange(4))])
        y = self.random.choice([*names, "2"])
        return self.one_of(
            x, x, x, f"({x} + {y}) % 4", f"half({x})", "card(v)", "#s", f"3 / {x}", f"({x} - 1) % 3", f"({x} * {y}) % 4"
        )

    def condition(self, names: list[str]) -> str:
        x, y = self.number(names), self.number(names)
        return self.one_of(
            f"{x} < {y}",
            f"{x} == {y}",
            f"#s > {x}",
            f"member({x}, v)",
            "t == A",
            f"t != (B.{self.random.randrange(3)})",
            "empty(v)",
            f"not ({x} <= {y} or null(s))",
            f"elem({x}, s) and true",
        )

    def mention(self, names: list[str]) -> str:
        x = self.number(names)
        sequence = self.one_of("s", "s", "<>", "tail(s)", f"<{x}>", f"if #s < 2 then s^<{x}> else s")
        members = self.one_of("v", "v", "{}", f"diff(v, {{{x}}})", f"if card(v) < 2 then union(v, {{{x}}}) else v")
        value = self.one_of("t", "t", "A", f"B.({x} % 3)", "swap(t)", f"C.({self.condition(names)}).({x} % 2)")
        return f"{self.one_of('Q', 'R')}({self.number(names)}, {sequence}, {members}, {value})"

    def process(self, names: list[str]) -> str:
        self.depth += 1
        try:
            if self.depth > 4 or self.random.random() < 0.25:
                return self.one_of(self.mention(names), self.mention(names), self.mention(names), "STOP", "SKIP")
            new = f"x{self.depth}"
            within = [*names, new]
            way = self.random.randrange(14)
            if way == 0:
                return f"({self.condition(names)} & {self.process(names)})"
            if way == 1:
                return f"(if {self.condition(names)} then {self.process(names)} else {self.process(names)})"
            if way in (2, 3, 4):
                return f"({self.guarded(names)} [] {self.guarded(names)})"
            if way == 5:
                return f"({self.process(names)} |~| {self.process(names)})"
            if way == 6:
                return f"([] {new}:v @ {self.process(within)})"
            if way == 7:
                return f"(n?{new} -> {self.process(within)})"
            if way == 8:
                return f"(n?{new}:{self.one_of('v', '{1, 3}', 'diff({0..3}, v)')} -> {self.process(within)})"
            if way == 9:
                return f"(p?{new}!{self.number(names)} % 3 -> {self.process(within)})"
            if way == 10:
                return f"(p?{new}?y:{{{self.number(within)} % 3}} -> {self.process(within)})"
            if way == 11:
                return f"(d!t -> {self.process(names)})"
            if way == 12:
                return f"(n!{self.number(names)} -> {self.process(names)})"
            return f"({self.one_of('a', 'b')} -> {self.process(names)})"
        finally:
            self.depth -= 1

    def guarded(self, names: list[str]) -> str:
        event = self.one_of("a", "b", f"n!{self.number(names)} % 4", "d?_")
        return f"({self.condition(names)} & {event} -> {self.process(names)})"

    def script(self) -> str:
        q, r = self.process(["i"]), self.process(["i"])
        return f"{DECLARATIONS}P = Q(1, <>, {{}}, A)\nQ(i, s, v, t) = a -> {r} [] {q}\nR(i, s, v, t) = {r}\n"


def test_random_definitions_fused_are_what_the_closures_are(monkeypatch: pytest.MonkeyPatch) -> None:
    used = machines = 0
    for seed in range(150):
        text = Writer(seed).script()
        plain, _ = found(text, monkeypatch, fused=False)
        fused, menus = found(text, monkeypatch, fused=True)
        assert fused == plain, text
        machines += not isinstance(plain, str)
        used += menus
    assert used > 60
    assert machines > 30


class CollectionWriter(Writer):
    """Definitions by clauses, of a number, a sequence, a set, a map and a pair: what stands in keys otherwise."""

    HEADS = (
        "Q(i, <>, v, m, w)",
        "Q(0, s, v, m, (i, y))",
        "Q(i, <x0>^s, v, m, w)",
        "Q(i, s^<x0>, v, m, w)",
        "Q(i, <x0, _>^s^<1>, v, m, w)",
        "Q(i, <x0, 2>, v, _, w)",
        "Q(_, <x0>^_, v, m, w)",
    )

    def number(self, names: list[str]) -> str:
        x = self.random.choice([*names, str(self.random.randrange(3))])
        return self.one_of(
            *(x, x, x, f"({x} + 1) % 3", "length(s)", "card(v)", f"mapLookup(m, {x} % 3)", "head(s)", "card(set(s))"),
            *(f"(if {x} < 2 then head(s^<{x}>) else 0)", "#(s^s)", f"mapLookup(mapUpdate(m, 1, {x}), 1)"),
        )

    def condition(self, names: list[str]) -> str:
        x = self.number(names)
        return self.one_of(
            *(f"mapMember(m, {x})", f"m == mapUpdate(m, 0, {x})", f"v == {{{x}}}", f"s == <{x}>", "s != <>"),
            *(f"v <= {{0, {x}}}", f"w == ({x}, true)", f"elem({x}, s)", "#s > 1", f"member({x}, union(v, {{2}}))"),
            *("null(s)", "empty(diff(v, {0..1}))", f"set(s) == {{0..{x} % 3}}", f"not member({x}, {{0, 2}})"),
        )

    def mention(self, names: list[str]) -> str:
        x, y = self.number(names), self.number(names)
        sequence = self.one_of(
            *("s", "s", "<>", "<2, 0>", "tail(s)", f"<{x}>^(if #s < 2 then s else <>)", f"<{x}, {y}>"),
            *(f"if #s < 2 then s^<{x}> else tail(s)", "<j | j <- s, (j > 0)>", f"if null(s) then <{x}>^s^<1> else s"),
        )
        members = self.one_of(
            *("v", "v", "{}", "{0..2}", f"diff(v, {{{x}}})", f"union(v, {{{x}}})", "set(s)", "inter(v, {0..1})"),
            *("{j | j <- v, j > 0}", f"{{{x}, {y}}}", f"if empty(v) then {{{x}}} else v"),
        )
        mapping = self.one_of(
            *(
                "m",
                "m",
                f"mapUpdate(m, {x} % 3, {y})",
                f"mapUpdate(mapUpdate(m, 0, {x}), 1, {y})",
                "(| 0 => 1, 1 => 0 |)",
            ),
            *(f"mapDelete(m, {x})", f"if mapMember(m, 2) then m else mapUpdate(m, 2, {x})"),
        )
        pair = self.one_of("w", "w", f"({x}, {self.condition(names)})", f"({y}, true)")
        return f"{self.one_of('Q', 'R')}({self.number(names)}, {sequence}, {members}, {mapping}, {pair})"

    def guarded(self, names: list[str]) -> str:
        event = self.one_of("a", "b", f"n!{self.number(names)} % 4", "n?_", "p?_!0")
        return f"({self.condition(names)} & {event} -> {self.process(names)})"

    def process(self, names: list[str]) -> str:
        return super().process(names).replace("d!t", "a")

    def script(self) -> str:
        clauses = ""
        for head in self.random.sample(self.HEADS, 2):
            names = [name for name in ("i", "x0") if name in head]
            clauses += f"{head} = {self._of(head, names or ['1'])}\n"
        general = self.process(["i"])
        start = "P = Q(1, <2>, {0}, mapFromList(<(0, 1), (1, 2), (2, 0)>), (1, true))"
        other = f"R(i, s, v, m, w) = a -> {self.process(['i'])} [] {self.guarded(['i'])}\n"
        more = f"n?x -> {self.mention(['i', 'x'])}"
        return f"{DECLARATIONS}{start}\n{clauses}Q(i, s, v, m, w) = {general} [] {more}\n{other}"

    def _of(self, head: str, names: list[str]) -> str:
        """A body that mentions nothing that the head does not bind."""
        body = f"({self.guarded(names)} [] b -> {self.mention(names)})"
        for name, instead in (("s", "<1>"), ("m", "mapFromList(<(0, 0)>)"), ("w", "(2, false)")):
            if not re.search(rf"\b{name}\b", head):
                body = re.sub(rf"\b{name}\b", instead, body)
        return body


def alike(one: Found, other: Found) -> bool:
    """Whether two machines are the same.

    Of several mistakes either may be met first; and what is called by an argument with a mistake has several names.
    """
    if isinstance(one, str) or isinstance(other, str):
        return one == other or (str(one)[:3] == str(other)[:3] == "CSP")
    return one[:4] == other[:4] and all(a == b or "..." in a for a, b in zip(one[4], other[4], strict=True))


def test_random_definitions_of_collections_are_what_the_closures_are(monkeypatch: pytest.MonkeyPatch) -> None:
    used = machines = natives = 0
    native = routines.Routine.refer_later

    def counted(*given: Any) -> Any:
        nonlocal natives
        natives += 1
        return native(*given)

    monkeypatch.setattr(routines.Routine, "refer_later", counted)
    for seed in range(examples(60)):
        text = CollectionWriter(seed).script()
        plain, _ = found(text, monkeypatch, fused=False)
        fused, menus = found(text, monkeypatch, fused=True)
        assert alike(plain, fused), text
        machines += not isinstance(plain, str)
        used += menus
    assert used > examples(60) / 4
    assert machines > examples(60) / 5
    assert natives > examples(60)
