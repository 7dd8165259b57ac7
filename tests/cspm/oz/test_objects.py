"""Objects by flattening: textbook examples, in words of our own, are typed, run as processes and proved."""

from __future__ import annotations

import pytest

from cspcheck.cspm.oz.typing.elaboration import elaborate
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.source import Source
from tests.checker.proof.classes import findings, told
from tests.cspm.oz.asking import outcome, refusal

CARD = """
given ID
reading ID = 2
class Card
  visible INIT, limit, balance, withdraw, deposit
  const limit : nat where limit = 1
  state
    balance : -1..2
  where
    -limit <= balance
  init
    balance = 0
  op withdraw = [Delta(balance); amount? : 1..2 | amount? <= balance + limit; balance' = balance - amount?]
  op deposit = [Delta(balance); amount? : 1..2 | balance' = balance + amount?]
  op close = [Delta(balance) | balance' = 0]
end
"""
TWO_CARDS = """
class Cards
  visible first_, transfer, total
  state
    a, b : Card
    Delta
    sum : -2..4
  where
    sum = a.balance + b.balance
  init
    a.INIT and b.INIT
  op first_ = a.deposit
  op transfer = a.withdraw and b.deposit
  op total = [n! : -2..4 | n! = sum and a.limit = 1]
end
"""
BANK = """
class Bank
  visible open, take, give, some, all
  state
    card : ID -> Card
    users : power ID
  init
    users = {} and (forall i : ID @ card(i).INIT)
  op open = [Delta(users); who? : ID | who? notin users; users' = users union {who?}]
  op take = [who? : ID | who? in users] @ card(who?).withdraw
  op give = [from?, to? : ID | from? != to?; {from?, to?} subseteq users] @
    (card(from?).withdraw ; card(to?).deposit)
  op some = [] i : users @ card(i).deposit
  op all = [n! : power (0..2) | n! = {i : users | card(i).balance >= 0 @ card(i).balance}]
end
"""


@pytest.mark.parametrize(
    ("trace", "verdict"),
    [
        ("first_.2, transfer.1, total.2", "pass"),
        ("first_.2, transfer.2, transfer.1, total.2", "fail"),  # the second card cannot have 3
        ("transfer.1, total.0", "pass"),
        ("transfer.1, transfer.1", "fail"),  # the first card is at its limit
    ],
)
def test_two_cards_are_two_objects(trace: str, verdict: str) -> None:
    assertion = f"Cards :[has trace]: <{trace}>"
    assert outcome(f"{CARD}{TWO_CARDS}assert {assertion}", assertion)[0] == verdict


@pytest.mark.parametrize(
    ("trace", "verdict"),
    [
        ("open.ID_1, Bank::take.ID_1.1, Bank::take.ID_1.1", "fail"),
        ("open.ID_1, open.ID_2, Bank::take.ID_1.1, Bank::take.ID_2.1, all.{}", "pass"),
        ("open.ID_1, some.2, all.{2}, open.ID_2, all.{0, 2}, give.ID_1.ID_2.2, all.{0, 2}", "pass"),
        ("open.ID_1, some.2, some.1", "fail"),
        ("some.1", "fail"),
    ],
)
def test_a_family_of_cards_changes_at_one_place(trace: str, verdict: str) -> None:
    trace = trace.replace("Bank::", "")
    assertion = f"Bank :[has trace]: <{trace}>"
    assert outcome(f"{CARD}{BANK}assert {assertion}", assertion)[0] == verdict


def test_the_class_has_the_obligations_of_its_objects() -> None:
    found = findings(f"{CARD}{TWO_CARDS}", "invariant preserved")
    limits = ["first_ `-a.limit <= a.balance`", "transfer `-a.limit <= a.balance`", "transfer `-b.limit <= b.balance`"]
    assert {f"invariant preserved {limit}: proved" for limit in limits} <= set(told(found))
    assert {f.status for f in found} == {"proved"}


def test_objects_have_objects() -> None:
    text = """
class Lock
  visible INIT, open, turn
  state
    open : bool
  init
    open = false
  op turn = [Delta(open) | open' = true and open = false]
end
class Door
  visible INIT, lock, turn, pass
  state
    lock : Lock
    passed : 0..1
  init
    lock.INIT and passed = 0
  op turn = lock.turn
  op pass = [Delta(passed) | lock.open = true; passed' = 1 - passed]
end
class House
  visible go, through
  state
    front, back : Door
  init
    front.INIT and back.INIT
  op go = front.turn
  op through = front.pass and [back.lock.open = false]
end
"""
    for trace, verdict in (("go, through, through", "pass"), ("through", "fail"), ("go, go", "fail")):
        assertion = f"House :[has trace]: <{trace}>"
        assert outcome(f"{text}assert {assertion}", assertion)[0] == verdict, trace


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("op x = a.close", "`Card` has no visible operation `close`"),
        ("op x = [a.colour = 1]", "`Card` has no field `colour`"),
        ("op x = f.withdraw", "`f` is no object"),
        ("op x = a(1).withdraw", "`a(1)` is no object"),
    ],
)
def test_what_needs_a_heap_or_is_not_there_is_refused_in_words(body: str, message: str) -> None:
    text = f"{CARD}class C\n  state\n    a, b : Card\n    f : 0..1 -> Card\n  {body}\nend"
    assert message in refusal(text).message


def test_an_object_within_itself_is_refused() -> None:
    node = "class Node\n  state\n    next : Node\nend\n"
    (warning,) = elaborate(parse(Source("objects.csp", node))).warnings
    assert warning.code == "CSP673"
    assert "would need a heap" in warning.message
    assert "would need a heap" in refusal(f"{node}assert Node :[deadlock free]").message


def test_a_process_is_no_attribute() -> None:
    text = "class P\n  chan c\n  main = c -> main\nend\nclass C\n  state\n    p : P\nend"
    assert refusal(text).code == "CSP637"


def test_a_constant_of_a_generic_class_is_an_object_for_ever() -> None:
    text = (
        "class Cell[X]\n  state held : X\n  op put = [Delta(held); x? : X | held' = x?]\nend\n"
        "class User\n  const c : Cell[0..2]; most : 0..2 where most = 1; c.held <= most\n"
        "  state k : 0..1\n  init k = 0 and c.held = 0\n  op put = c.put\nend\n"
    )
    for trace, verdict in (("put.1, put.0", "pass"), ("put.2", "fail")):
        claim = f"User :[has trace]: <{trace}>"
        assert outcome(f"{text}assert {claim}\n", claim)[0] == verdict


PAIR = """class Cell
  state n : 0..2
  init n = 0
  op up = [Delta(n) | n' = n + 1]
end
class Pair
  state a, b : Cell
  init a.INIT and b.INIT
  op both = a.up and [a'.n <= 1] and b.up
  op one = a.up and [a'.n > b.n]
end
"""


@pytest.mark.parametrize(("trace", "verdict"), [("both", "pass"), ("both, both", "fail"), ("both, one", "pass")])
def test_an_attribute_after_is_that_of_the_object_after(trace: str, verdict: str) -> None:
    claim = f"Pair :[has trace]: <{trace}>"
    assert outcome(f"{PAIR}assert {claim}\n", claim)[0] == verdict
