"""Scripts with the verdicts that they must have, checked as a user would have them checked."""

from __future__ import annotations

import pytest

from cspcheck.checker.check import Checker
from cspcheck.checker.verdict import Limits, Outcome, Verdict
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.script import Script, load
from cspcheck.cspm.source import Source


def script(text: str) -> Script:
    return load(Source("test.csp", text))


def outcomes(text: str, **limits: int) -> list[Outcome]:
    loaded = script(text)
    one = Checker(loaded, limits=Limits(**limits), workers=1)
    return [one.check(assertion.node) for assertion in loaded.assertions]


TEXTBOOK = r"""
channel a, b, c
channel coin, tea, coffee
channel left, mid, right : {0..1}

-- Hoare's vending machines
Polite  = coin -> (tea -> Polite [] coffee -> Polite)
Moody   = coin -> tea -> Moody [] coin -> coffee -> Moody
assert Polite [T= Moody
assert Moody [T= Polite
assert Polite [F= Moody                                      -- expect: fail
assert Moody [FD= Polite
assert Polite :[deterministic]
assert Moody :[deterministic]                                -- expect: fail
assert Moody :[deadlock free]
assert Moody :[has trace]: <coin, tea, coin, coffee>
assert Moody :[has trace [F]]: <coin, tea>                   -- expect: fail
assert not Polite [F= Moody

-- two cells make a buffer of two
Cell(i, o)  = i?x -> o!x -> Cell(i, o)
Pair        = (Cell(left, mid) [| {| mid |} |] Cell(mid, right)) \ {| mid |}
Buff(s)     = (#s < 2 & left?x -> Buff(s^<x>)) [] (#s > 0 & right!head(s) -> Buff(tail(s)))
assert Buff(<>) [FD= Pair
assert Pair [FD= Buff(<>)
assert Pair :[divergence free]
assert Pair :[deterministic]
assert Cell(left, right) [T= Pair                            -- expect: fail

-- choice and termination
assert STOP [F= STOP |~| a -> STOP                           -- expect: fail
assert STOP |~| a -> STOP [F= STOP
assert SKIP [] a -> STOP [FD= SKIP
assert SKIP [FD= SKIP [] a -> STOP                           -- expect: fail
assert a -> SKIP ; b -> SKIP [FD= a -> b -> SKIP
assert a -> SKIP ||| b -> SKIP :[deadlock free]
assert SKIP :[deadlock free]
assert STOP :[deadlock free]                                 -- expect: fail

-- divergence
Ticker = a -> Ticker
assert Ticker \ {a} :[divergence free]                       -- expect: fail
assert Ticker \ {a} :[livelock free]                         -- expect: fail
assert Ticker \ {a} :[deadlock free [F]]
assert Ticker \ {a} :[deadlock free]                         -- expect: fail
assert CHAOS({a, b}) [F= Ticker \ {a}
assert CHAOS({a, b}) [FD= Ticker \ {a}                       -- expect: fail
assert DIV [FD= RUN({a, b, c})

-- options and models
assert (a -> STOP) [> (b -> STOP) :[deterministic]           -- expect: fail
assert (a -> STOP) [> (b -> STOP) :[deterministic] :[tau priority]: {a}
assert Pair :[deadlock free] :[partial order reduce]
assert STOP [R= STOP
assert STOP [V= STOP
assert 1 + 1 == 2
assert not (2 < 1)
"""


def test_textbook() -> None:
    loaded = script(TEXTBOOK)
    one = Checker(loaded, workers=1)
    found = {assertion.text: one.check(assertion.node).verdict.value for assertion in loaded.assertions}
    assert found == {assertion.text: assertion.expected or "pass" for assertion in loaded.assertions}


def test_not_shows_the_behaviour_that_makes_it_pass() -> None:
    (outcome,) = outcomes("channel a, b\nassert not a -> STOP [T= a -> b -> STOP")
    assert outcome.verdict is Verdict.PASS
    assert outcome.counterexample is not None
    assert (outcome.counterexample.trace, outcome.counterexample.event) == (("a",), "b")


def test_not_of_unknown_is_unknown() -> None:
    (outcome,) = outcomes("channel a\nP(n) = a -> P(n+1)\nassert not P(0) :[deadlock free]", states=1000)
    assert outcome.verdict is Verdict.UNKNOWN


def test_an_endless_recursion_ends_at_the_limit() -> None:
    (outcome,) = outcomes("channel a\nP(n) = a -> P(n+1)\nassert P(0) :[deadlock free]", states=1000)
    assert outcome.verdict is Verdict.UNKNOWN
    assert outcome.reason == (
        "more than 1,000 states: `P` is called with 1,000 different arguments: `P(0)`, `P(1)`, `P(2)`, ...; "
        "`--max-states` raises the limit"
    )


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("channel a\nP = P [] a -> STOP\nassert P :[deadlock free]", "CSP501"),
        ("channel a : {0..1}\nassert a.2 -> STOP :[deadlock free]", "CSP4"),
        ("channel a\nassert STOP [T= a -> (if head(<>) == 1 then STOP else SKIP)", "CSP4"),
    ],
)
def test_what_cannot_be_evaluated_is_a_mistake_of_the_script(text: str, code: str) -> None:
    with pytest.raises(ScriptError) as caught:
        outcomes(text)
    assert caught.value.diagnostics[0].code.startswith(code)


PHILOSOPHERS = r"""
N = 3
Ids = {0..N-1}
channel picks, puts : Ids.Ids
channel sits, gets : Ids
Next(i)  = (i + 1) % N
Phil(i)  = sits.i -> picks.i.i -> picks.i.Next(i) -> puts.i.Next(i) -> puts.i.i -> gets.i -> Phil(i)
Fork(i)  = picks?j!i -> puts.j.i -> Fork(i)
Phils    = ||| i : Ids @ Phil(i)
Forks    = ||| i : Ids @ Fork(i)
System   = Phils [| {| picks, puts |} |] Forks
assert System :[deadlock free]
"""


class TestPhilosophers:
    """The counterexample that every course shows."""

    @pytest.fixture
    def outcome(self) -> Outcome:
        return outcomes(PHILOSOPHERS)[0]

    def test_the_shortest_and_first(self, outcome: Outcome) -> None:
        assert outcome.verdict is Verdict.FAIL
        assert outcome.counterexample is not None
        assert outcome.counterexample.trace == (
            "sits.0",
            "picks.0.0",
            "sits.1",
            "picks.1.1",
            "sits.2",
            "picks.2.2",
        )

    def test_everyone_waits_in_a_ring(self, outcome: Outcome) -> None:
        assert outcome.counterexample is not None
        assert outcome.counterexample.waiting_cycle == (
            "Phil(0)",
            "Fork(1)",
            "Phil(1)",
            "Fork(2)",
            "Phil(2)",
            "Fork(0)",
        )

    def test_each_component(self, outcome: Outcome) -> None:
        assert outcome.counterexample is not None
        first = outcome.counterexample.components[0]
        assert (first.name, first.line, first.offers, first.waiting_for) == (
            "Phil(0)",
            7,
            ("picks.0.1",),
            ("Fork(1)",),
        )
        assert [event for event in first.trace if event] == ["sits.0", "picks.0.0"]
        assert first.state == "picks.0.1 -> puts.0.1 -> puts.0.0 -> gets.0 -> Phil(0)"
