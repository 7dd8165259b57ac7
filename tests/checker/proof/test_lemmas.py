"""Lemmas: proved themselves, then of help; by induction; never of help where they are false."""

from __future__ import annotations

import random
from collections.abc import Callable
from itertools import product

import pytest

from cspcheck.checker.proof.finding import Finding
from cspcheck.checker.proof.induction import opened
from cspcheck.checker.proof.obligations import discharge
from cspcheck.checker.proof.question import Found, Help, Impossible
from cspcheck.checker.proof.simulation import Simulation, projection
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.typing.elaboration import elaborate
from cspcheck.cspm.oz.writing.core_text import written
from cspcheck.cspm.oz.writing.latex_writer import write_latex
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.printing.formatter import format_source
from cspcheck.cspm.source import Source
from tests.checker.proof.classes import findings, prover, specification

SUM = """
const sum : seq nat -> nat
where
  sum(<>) = 0
  forall s : seq nat; x : nat @ sum(s ^ <x>) = sum(s) + x
end
"""
LEDGER = (
    SUM
    + """
lemma sum_of_two : forall s, t : seq nat @ sum(s ^ t) = {claim} by induction on t
class Ledger
  chan join : [x? : seq nat]
  main = join -> main
  state
    log : seq nat
    total : nat
  where
    total = sum(log)
  init
    log = <>
  op join
    Delta(log, total)
    x? : seq nat
  where
    log' = log ^ x?
    total' = total + sum(x?)
  using sum_of_two
end
"""
)


def statuses(found: list[Finding]) -> set[str]:
    return {f.status for f in found}


class TestHelp:
    def test_a_lemma_brings_a_claim_home_and_is_told(self) -> None:
        (found,) = findings(LEDGER.format(claim="sum(s) + sum(t)"), "invariant preserved")

        assert (found.status, found.hypotheses, found.missing) == ("proved", ("sum_of_two",), ())

    def test_there_are_states_where_a_recursive_function_says_what_they_are(self) -> None:
        names = ("axioms consistent", "state inhabited", "initialisation", "feasible")

        assert statuses(findings(LEDGER.format(claim="sum(s) + sum(t)"), *names)) == {"proved"}

    def test_a_false_lemma_is_refuted_and_helps_nobody(self) -> None:
        asked = prover(LEDGER.format(claim="sum(s) + sum(t) + #s * #t"), seconds=1.0)
        claim = asked.claim("sum_of_two")
        assert claim is not None

        found = asked.lemma(claim)

        assert isinstance(found, Found)
        assert {v.name for v in found.values} == {"s", "t"}
        (kept,) = discharge(asked, ["invariant preserved"])
        assert (kept.status != "proved", kept.missing) == (True, ("sum_of_two",))

    def test_a_lemma_about_states_holds_of_those_of_the_invariant(self) -> None:
        text = """
class C
  chan up
  main = up -> main
  state
    n, m : nat
  where
    m = n * n
  lemma square : n > 1 => m > n
  lemma wrong : n > 0 => m > n
  init
    n = 0
  op up
    Delta(n, m)
  where
    n' = n + 1 and m' = (n + 1) * (n + 1)
end
"""
        found = {f.detail: f.status for f in findings(text, "lemma")}

        assert found == {"`square`": "proved", "`wrong`": "refuted"}

    @pytest.mark.parametrize(
        "text",
        [
            "lemma one : 1 < 2 using two\nlemma two : 2 < 3 using one",
            "class C\n lemma one : 1 < 2 using one\nend",
            "lemma one : 1 < 2 using two",
            "lemma one : forall n : nat @ n >= 0 by induction on m",
        ],
    )
    def test_circles_and_names_of_nothing_are_refused(self, text: str) -> None:
        from cspcheck.cspm.diagnostics import ScriptError

        with pytest.raises(ScriptError, match=r"CSP66[123]"):
            prover(text + "\nclass D\n state n : nat\nend")

    def test_a_lemma_says_nothing_of_what_has_no_value(self) -> None:
        text = """
class C
  lemma small : forall x : nat @ x >= 0
  lemma heads : forall s : seq nat @ head s >= 0 using small
end
"""
        found = {f.detail: f.status for f in findings(text, "lemma")}

        assert found == {"`small`": "proved", "`heads`": "refuted"}


class TestInduction:
    @pytest.mark.parametrize(
        ("declarations", "claim", "on"),
        [
            (
                "const tri : nat -> nat\nwhere\n  tri(0) = 0\n  forall n : nat @ tri(n + 1) = tri(n) + n + 1\nend\n",
                "forall n : nat @ 2 * tri(n) = n * (n + 1)",
                "n",
            ),
            (SUM, "forall s : seq nat @ (forall i : 1..#s @ s(i) = 0) => sum(s) = 0", "s"),
            (
                "const len : seq nat -> nat\nwhere\n  len(<>) = 0\n"
                "  forall s : seq nat; x : nat @ len(<x> ^ s) = 1 + len(s)\nend\n",
                "forall s : seq nat @ len(s) = #s",
                "s",
            ),
            ("", "forall a : finset nat @ a != {} => (exists m : a @ (forall n : a @ n <= m))", "a"),
            (
                "TREE ::= leaf | node<<TREE cross TREE>>\nconst size : TREE -> nat\nwhere\n  size(leaf) = 1\n"
                "  forall l, r : TREE @ size(node(l, r)) = size(l) + size(r)\nend\n",
                "forall t : TREE @ size(t) >= 1",
                "t",
            ),
        ],
    )
    def test_what_is_true_is_proved(self, declarations: str, claim: str, on: str) -> None:
        asked = prover(f"{declarations}lemma claim : {claim} by induction on {on}\nclass C\nend")
        found = asked.claim("claim")
        assert found is not None

        assert isinstance(asked.lemma(found), Impossible)

    def test_a_step_that_forgets_the_least_value_proves_nothing(self) -> None:
        text = "lemma none : forall n : nat @ n > n + 1 by induction on n\nclass C\nend"
        asked = prover(text)
        claim = asked.claim("none")
        assert claim is not None

        assert isinstance(asked.lemma(claim), Found)

    def test_an_assertion_may_ask_for_it(self) -> None:
        asked = prover(
            SUM + "class C\n state s : seq nat\n where sum(s) >= 0\n init s = <>\n lemma l : sum(s ^ <1>) > sum(s)\nend"
        )
        asked.help = Help(induction="s")

        assert isinstance(asked.refutes(asked.situation.state(), asked.situation.invariant()[0].term), Impossible)

    @pytest.mark.parametrize(
        ("effect", "proved"),
        [
            ("#(owner |> {r?}) < 3; owner' = owner (+) {b? |-> r?}", True),
            ("#(owner |> {r?}) <= 3; owner' = owner (+) {b? |-> r?}", False),
            ("if #(owner |> {r?}) < 3 then owner' = owner (+) {b? |-> r?} else owner' = owner", True),
        ],
    )
    def test_no_reader_has_more_than_three(self, effect: str, proved: bool) -> None:
        lines = "\n".join(f"    {line.strip()}" for line in effect.split(";"))
        text = f"""
given BOOK, READER
class Library
  chan lend : [b? : BOOK; r? : READER]
  state owner : BOOK -||-> READER
  where forall r : READER @ #(owner |> {{r}}) <= 3
  init owner = {{}}
  op lend
    Delta(owner)
    b? : BOOK
    r? : READER
  where
    b? notin dom owner
{lines}
end
"""
        (found,) = findings(text, "invariant preserved")

        assert (found.status == "proved") == proved


class TestRecursion:
    @pytest.mark.parametrize(
        ("range_", "step", "consistent"),
        [
            ("nat", "f(s) + x", True),
            ("0..3", "f(s) + x", False),
            ("nat", "f(s) - x", False),
            ("0..3", "if f(s) < 3 then f(s) + 1 else 0", True),
        ],
    )
    def test_it_is_consistent_where_values_stay_in_the_range(self, range_: str, step: str, consistent: bool) -> None:
        text = f"""
const f : seq nat -> {range_}
where
  f(<>) = 0
  forall s : seq nat; x : nat @ f(s ^ <x>) = {step}
end
class C
  state s : seq nat
end
"""
        (found,) = discharge(prover(text, seconds=2.0), ["axioms consistent"])

        assert (found.status == "proved") == consistent


# --- against all small values ----------------------------------------------------------------------------------------

Meaning = Callable[[dict[str, tuple[int, ...]]], tuple[int, ...]]
_SMALL = [s for size in range(4) for s in product((0, 1), repeat=size)]


def _sequence(rng: random.Random, depth: int) -> tuple[str, Meaning]:
    """A sequence expression of ``s`` and ``t`` with what it means."""
    if depth == 0 or rng.random() < 0.3:
        name = rng.choice("st")
        return rng.choice([(name, lambda v: v[name]), (name, lambda v: v[name]), ("<1>", lambda v: (1,))])
    left, one = _sequence(rng, depth - 1)
    right, other = _sequence(rng, depth - 1)
    return rng.choice(
        [
            (f"({left} ^ {right})", lambda v: one(v) + other(v)),
            (f"(rev ({left}))", lambda v: one(v)[::-1]),
            (f"(({left}) filter {{1}})", lambda v: tuple(x for x in one(v) if x == 1)),
        ]
    )


def _predicate(rng: random.Random) -> tuple[str, Callable[[dict[str, tuple[int, ...]]], bool]]:
    left, one = _sequence(rng, 2)
    right, other = _sequence(rng, 2)
    return rng.choice(
        [
            (f"{left} = {right}", lambda v: one(v) == other(v)),
            (f"#{left} <= #{right}", lambda v: len(one(v)) <= len(other(v))),
            (f"sum({left}) = sum({right})", lambda v: sum(one(v)) == sum(other(v))),
            (f"sum({left}) <= #{right}", lambda v: sum(one(v)) <= len(other(v))),
            (f"sum({left}) + sum(t) = sum({right} ^ t)", lambda v: sum(one(v)) + sum(v["t"]) == sum(other(v) + v["t"])),
        ]
    )


@pytest.mark.parametrize("seed", range(3))
def test_what_is_proved_holds_of_all_small_values(seed: int) -> None:
    rng = random.Random(seed)
    lemmas, meanings = [], {}
    for number in range(6):
        said, meaning = _predicate(rng)
        using = rng.sample(sorted(meanings), min(len(meanings), rng.randrange(3)))
        helps = (f" using {', '.join(using)}" if using else "") + rng.choice(
            ["", " by induction on s", " by induction on t"]
        )
        lemmas.append(f"lemma l{number} : forall s, t : seq (0..1) @ {said}{helps}")
        meanings[f"l{number}"] = meaning
    asked = prover(SUM + "\n".join(lemmas) + "\nclass C\nend", seconds=1.0)
    decided = 0
    for name, meaning in meanings.items():
        claim = asked.claim(name)
        assert claim is not None
        answer = asked.lemma(claim)
        holds = all(meaning({"s": s, "t": t}) for s in _SMALL for t in _SMALL)
        if isinstance(answer, Impossible):
            assert holds, lemmas
        if isinstance(answer, Found):
            assert not holds, lemmas
        decided += isinstance(answer, Impossible | Found)
    assert decided > 2


Values = dict[str, int]


def _number(rng: random.Random, names: list[str]) -> tuple[str, Callable[[Values], int]]:
    name = rng.choice(names)
    return rng.choice([(name, lambda v: v[name]), (f"{name} + 1", lambda v: v[name] + 1), ("1", lambda v: 1)])


def _formula(rng: random.Random, depth: int, names: list[str]) -> tuple[str, Callable[[Values], bool]]:
    """A predicate over numbers from 0 to 2 with quantifiers, choices and conditionals, and what it means."""
    if depth == 0:
        (left, one), (right, other) = _number(rng, names), _number(rng, names)
        return rng.choice(
            [
                (f"{left} = {right}", lambda v: one(v) == other(v)),
                (f"{left} <= {right}", lambda v: one(v) <= other(v)),
            ]
        )
    if rng.random() < 0.5:
        bound = f"q{len(names)}"
        inner, meaning = _formula(rng, depth - 1, [*names, bound])
        return rng.choice(
            [
                (f"(exists {bound} : 0..2 @ {inner})", lambda v: any(meaning({**v, bound: x}) for x in range(3))),
                (f"(forall {bound} : 0..2 @ {inner})", lambda v: all(meaning({**v, bound: x}) for x in range(3))),
            ]
        )
    (left_, yes), (right_, no) = _formula(rng, depth - 1, names), _formula(rng, depth - 1, names)
    (test, holds) = _formula(rng, 0, names)
    return rng.choice(
        [
            (f"({left_} or {right_})", lambda v: yes(v) or no(v)),
            (f"({left_} and {right_})", lambda v: yes(v) and no(v)),
            (f"({left_} => {right_})", lambda v: not yes(v) or no(v)),
            (f"(not {left_})", lambda v: not yes(v)),
            (f"(if {test} then {left_} else {right_})", lambda v: yes(v) if holds(v) else no(v)),
        ]
    )


def test_that_some_value_is_like_all_is_no_extreme() -> None:
    asked = prover("lemma l : forall n : 0..2 @ exists x : 0..2 @ forall y : 0..2 @ n + 1 = y + 1\nclass C\nend")
    claim = asked.claim("l")
    assert claim is not None

    assert isinstance(asked.lemma(claim), Found)


@pytest.mark.parametrize("seed", [7])
def test_a_question_in_plain_words_is_the_same_question(seed: int) -> None:
    rng = random.Random(seed)
    formulas = [_formula(rng, 3, ["n", "m"]) for _ in range(60)]
    lemmas = [f"lemma l{i} : forall n, m : 0..2 @ {said}" for i, (said, _) in enumerate(formulas)]
    asked = prover("\n".join(lemmas) + "\nclass C\nend", seconds=2.0)
    proved = 0
    for i, (said, meaning) in enumerate(formulas):
        claim = asked.claim(f"l{i}")
        assert claim is not None
        assumed, body, _ = opened(claim.lemma.term)
        answer = asked._in_plain_words((*assumed, asked.fails(body)))
        holds = all(meaning({"n": n, "m": m}) for n in range(3) for m in range(3))
        assert isinstance(answer, Impossible) == holds, said
        proved += holds
    assert 5 < proved < 55


USED = """
lemma grows : forall a, b : nat | a <= b @ a * a <= b * b
class Squares
  chan up : [k? : nat]
  main = up -> main
  state
    n, m : nat
  where
    n * n <= m * m
  init
    n = 0 and m = 0
  op up
    Delta(n, m)
    k? : nat
  where
    n <= k?
    n' = n and m' = k?
  using {used}
end
"""


class TestArguments:
    """Lemmas with the values that they are used for."""

    @pytest.mark.parametrize("used", ["grows(n, k?)", "grows(n', m')", "grows(0, 1), grows(n + 0, m')"])
    def test_a_lemma_helps_with_what_it_says_of_them(self, used: str) -> None:
        (found,) = findings(USED.format(used=used), "invariant preserved")

        assert (found.status, found.hypotheses) == ("proved", ("grows",))

    def test_it_says_nothing_else(self) -> None:
        """A law that is of help for other values than these."""
        text = "lemma two : forall s, t : seq nat @ #(s ^ t) = 2 * #s using {}"
        told = {
            used: findings(text.format(used) + "\nclass C\nend", "lemma")[0].status
            for used in ("length_of_filter(s, {1})", "length_of_filter")
        }

        assert set(told.values()) == {"refuted"}

    def test_a_lemma_uses_another_for_its_own_variables_and_by_induction(self) -> None:
        text = (
            SUM
            + """
lemma two : forall s, t : seq nat @ sum(s ^ t) = sum(s) + sum(t) by induction on t
lemma three : forall s, t, u : seq nat @ sum(s ^ t ^ u) = sum(s) + sum(t) + sum(u) using two(s, t ^ u), two(t, u)
lemma twice : forall s : seq nat; n : nat @ sum(<n> ^ s ^ <n>) = n + n + sum(s)
  using two(<n>, s ^ <n>), two(s, <n>), two(<>, <n>)
class C
end
"""
        )
        found = {f.detail: (f.status, f.hypotheses) for f in findings(text, "lemma")}

        assert found["`three`"] == found["`twice`"] == ("proved", ("two",))

    def test_where_a_value_is_undefined_nothing_is_said(self) -> None:
        text = """
lemma one : forall n : nat @ n >= 0
lemma wrong : forall s : seq int @ s = <> or head s >= 0 using one(head s)
lemma none : forall s : seq int @ head(tail(<1>)) >= 0 using one(head(tail(<1>)))
class C
end
"""
        assert not [f for f in findings(text, "lemma") if f.status == "proved" and f.detail != "`one`"]

    def test_a_false_lemma_helps_with_no_values(self) -> None:
        (found,) = findings(USED.replace("a * a <= b * b", "a > b").format(used="grows(n, k?)"), "invariant preserved")

        assert (found.hypotheses, found.missing) == ((), ("grows",))

    def test_generic_parameters_are_what_the_values_say(self) -> None:
        text = """
lemma both : forall a, b : finset (nat cross nat) | a inter b = {} @ #(a union b) = #a + #b using card_of_union(a, b)
class C
end
"""
        (found,) = findings(text, "lemma")

        assert (found.status, found.hypotheses) == ("proved", ("card_of_union",))

    def test_children_and_refinements_have_the_values_of_their_parents(self) -> None:
        text = (
            USED.format(used="grows(n, k?)")
            + """
class Child
  inherit Squares
  chan up : [k? : nat]
  state
    z : nat
end
assert Squares [OZ= Child
"""
        )
        spec = specification(text)
        use = spec.classes["Child"].operations["up"].using
        assert [(u.name, [written(v) for v in u.arguments if isinstance(v, core.Variable)]) for u in use] == [
            ("grows", ["n", "k?"])
        ]
        assert statuses(findings(text, "invariant preserved")) == {"proved"}
        simulation = Simulation(spec, projection(spec, "Squares", "Child"))
        correct = [f for f in simulation.downward() if f.obligation == "correctness"]
        assert statuses(correct) == {"proved"}

    @pytest.mark.parametrize(
        ("used", "told"),
        [
            ("grows(n)", "`grows` is used for 2 values, here is one"),
            ("grows(n, n, n)", "`grows` is used for 2 values, here are 3"),
            ("grows(n, {n})", "`b` of the lemma `grows` is of type int, and this is of type power int"),
            ("grows(n, k!)", "`k!` is no parameter of this operation"),
            ("grows(n, o)", "`o` is not known here"),
            ("card_of_union({}, {})", "what this empty collection could hold is not said"),
        ],
    )
    def test_values_that_do_not_fit_are_told(self, used: str, told: str) -> None:
        with pytest.raises(ScriptError) as error:
            specification(USED.format(used=used))

        assert told in str(error.value)

    @pytest.mark.parametrize(
        "used", ["grows(n, k?)", "grows(n, k?), grows", "grows((n + 1) * 2, if n > 1 then n' else 0)"]
    )
    def test_what_is_read_is_printed_in_both_notations(self, used: str) -> None:
        tree = parse(Source("test.csp", USED.format(used=used)))

        printed = [format_source(tree.span.source), write_latex(tree)]

        again = [parse(Source(name, text)) for name, text in zip(("a.csp", "a.tex"), printed, strict=True)]
        for other in again:
            uses = elaborate(other).specification.classes["Squares"].operations["up"].using
            assert uses == elaborate(tree).specification.classes["Squares"].operations["up"].using
