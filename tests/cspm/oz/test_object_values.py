"""Objects as values, in sets and as parameters: textbook examples, in words of our own, beside processes by hand."""

from __future__ import annotations

import pytest

from cspcheck.cspm.oz.typing.elaboration import elaborate
from cspcheck.cspm.oz.writing.printer import print_paragraph
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.source import Source
from tests.checker.proof.classes import findings, told
from tests.cspm.oz.asking import outcome, refusal

CARD = """
reading Card = 2
class Card
  visible INIT, limit, balance, withdraw, deposit, withdrawAvail
  const limit : nat where limit = 1
  state
    balance : -1..1
  where
    -limit <= balance
  init
    balance = 0
  op withdraw = [Delta(balance); amount? : 1..2 | amount? <= balance + limit; balance' = balance - amount?]
  op deposit = [Delta(balance); amount? : 1..2 | balance' = balance + amount?]
  op withdrawAvail = [Delta(balance); amount! : 0..2 | amount! = balance + limit; balance' = -limit]
end
"""
BANK = """
class Bank
  visible INIT, add, delete, spend, transfer, empty, bonus
  state
    cards : power Card
    Delta
    total : -2..2
  where
    forall c : cards @ c.balance + c.limit >= 0
    total = #{c : cards | c.balance = 1} - #{c : cards | c.balance = -1}
  init
    cards = {}
    forall c : Card @ c.INIT
  op add = [Delta(cards); card? : Card | card? notin cards; cards' = cards union {card?}]
  op delete = [Delta(cards); card? : Card | card? in cards; cards' = cards \\ {card?}]
  op spend = [card? : Card | card? in cards] @ card?.withdraw
  op transfer = [from?, to? : Card | {from?, to?} subseteq cards and from? != to?] @ (from?.withdraw || to?.deposit)
  op empty = [card? : Card | card? in cards] @ card?.withdrawAvail
  op bonus = and c : cards @ c.deposit
end
"""
HAND = """
Hand(cs, b) =
     ([] c : diff({Card_1, Card_2}, cs) @ add.c -> Hand(union(cs, {c}), b))
  [] ([] c : cs @ delete.c -> Hand(diff(cs, {c}), b))
  [] ([] c : cs, a : {1, 2} @ a <= mapLookup(b, c) + 1 & spend.c.a -> Hand(cs, mapUpdate(b, c, mapLookup(b, c) - a)))
  [] ([] f : cs, t : cs, a : {1, 2} @
       f != t and a <= mapLookup(b, f) + 1 and mapLookup(b, t) + a <= 1 &
         transfer.f.t.a ->
           Hand(cs, mapUpdate(mapUpdate(b, f, mapLookup(b, f) - a), t, mapLookup(b, t) + a)))
  [] ([] c : cs @ empty.c.(mapLookup(b, c) + 1) -> Hand(cs, mapUpdate(b, c, -1)))
  [] ([] a : {1, 2} @ {c | c <- cs, mapLookup(b, c) + a > 1} == {} &
       bonus.a -> Hand(cs, mapFromList(<(c, mapLookup(b, c) + extra(c, cs, a)) | c <- <Card_1, Card_2>>)))
extra(c, cs, a) = if member(c, cs) then a else 0
Start = Hand({}, mapFromList(<(Card_1, 0), (Card_2, 0)>))
"""


@pytest.mark.parametrize("assertion", ["Start [FD= Bank", "Bank [FD= Start"])
def test_a_bank_with_a_set_of_cards_is_the_process_written_by_hand(assertion: str) -> None:
    assert outcome(f"{CARD}{BANK}{HAND}assert {assertion}", assertion)[0] == "pass"


def test_what_holds_of_each_object_is_proved_of_all() -> None:
    bank = """
class Bank
  state
    cards : power Card
  init
    cards = {}
  op spend = [card? : Card | card? in cards] @ card?.withdraw
  op bonus = and c : cards @ c.withdrawAvail
end
"""
    found = told(findings(f"{CARD}{bank}", "invariant preserved"))
    limit = "`forall i : Card @ -Card.limit <= Card.balance(i)`"
    assert {f"invariant preserved spend {limit}: proved", f"invariant preserved bonus {limit}: proved"} <= set(found)


TWO_CARDS = """
class Cards
  visible INIT, one, transfer, swap, balance
  state
    a, b : Card
  where
    a != b
  init
    a.INIT and b.INIT
  op one = a.deposit
  op transfer = a.withdraw and b.deposit
"""


@pytest.mark.parametrize(
    ("trace", "verdict"),
    [
        ("one.1, transfer.1, balance.0.1", "pass"),
        ("one.1, swap, balance.0.1", "pass"),
        ("one.1, swap, transfer.1, balance.-1.1", "fail"),
        ("one.1, swap, transfer.1", "fail"),
    ],
)
def test_names_of_objects_are_exchanged(trace: str, verdict: str) -> None:
    more = """  op swap = [Delta(a, b) | a' = b; b' = a]
  op balance = [x!, y! : -1..1 | x! = a.balance; y! = b.balance]
end
"""
    assertion = f"Cards :[has trace]: <{trace}>"
    assert outcome(f"{CARD}{TWO_CARDS}{more}assert {assertion}", assertion)[0] == verdict


def test_two_names_that_stay_are_two_objects() -> None:
    for claim, verdict in (("a != b", "pass"), ("a = b", "fail"), ("not a = b", "pass")):
        text = f"{CARD}{TWO_CARDS}  op swap = [{claim}]\n  op balance = [a.balance = 0]\nend\n"
        assert outcome(f"{text}assert Cards :[has trace]: <swap>", "Cards :[has trace]: <swap>")[0] == verdict


KEYS = """
reading Key = 2
reading Room = 2
class Key
  visible INIT, rooms, extend
  state
    rooms : power Room
  init
    rooms = {}
  op extend = [Delta(rooms); room? : Room | room? notin rooms; rooms' = rooms union {room?}]
end
class Room
  visible INIT, locked, unlock, lock
  state
    locked : bool
  init
    locked = true
  op unlock = [Delta(locked) | locked = true; locked' = false]
  op lock = [Delta(locked) | locked = false; locked' = true]
end
class KeySystem
  visible INIT, make, allow, insert, close
  state
    keys : power Key
  init
    keys = {}
    (forall k : Key @ k.INIT) and (forall r : Room @ r.INIT)
  op make = [Delta(keys); key? : Key | key? notin keys; keys' = keys union {key?}]
  op allow = [key? : keys] @ key?.extend
  op insert = [key? : keys; room? : Room | room? in key?.rooms] @ room?.unlock
  op close = [room? : Room] @ room?.lock
end
"""
KEYS_HAND = """
Keys(made, may, open) =
     ([] k : diff({Key_1, Key_2}, made) @ make.k -> Keys(union(made, {k}), may, open))
  [] ([] k : made, r : {Room_1, Room_2} @ not member((k, r), may) &
       allow.k.r -> Keys(made, union(may, {(k, r)}), open))
  [] ([] k : made, r : {Room_1, Room_2} @ member((k, r), may) and not member(r, open) &
       insert.k.r -> Keys(made, may, union(open, {r})))
  [] ([] r : open @ close.r -> Keys(made, may, diff(open, {r})))
System = Keys({}, {}, {})
"""


@pytest.mark.parametrize("assertion", ["System [FD= KeySystem", "KeySystem [FD= System"])
def test_keys_and_rooms_that_know_each_other(assertion: str) -> None:
    assert outcome(f"{KEYS}{KEYS_HAND}assert {assertion}", assertion)[0] == "pass"


PAY_TV = """
reading Viewer = 2
class Viewer
  visible INIT, credit, watching, pay, start, stop
  state
    credit : 0..2
    watching : bool
  where
    watching = true => credit > 0
  init
    credit = 0 and watching = false
  op pay = [Delta(credit) | credit' = credit + 1]
  op start = [Delta(watching) | watching = false; watching' = true]
  op stop = [Delta(credit, watching) | watching = true; watching' = false; credit' = credit - 1]
end
class Station
  visible INIT, join, pay, start, stop, all_stop, count
  state
    viewers : seq Viewer
  where
    #viewers <= 2
    forall i, j : dom viewers | i != j @ viewers(i) != viewers(j)
  init
    viewers = <>
    forall v : Viewer @ v.INIT
  op join = [Delta(viewers); v? : Viewer | viewers' = viewers ^ <v?>]
  op pay = [v? : ran viewers] @ v?.pay
  op start = [] v : ran viewers @ v.start
  op stop = [i? : dom viewers] @ viewers(i?).stop
  op all_stop = and v : {w : ran viewers | w.watching = true} @ v.stop
  op count = [n! : 0..2 | n! = #{v : ran viewers | v.watching = true}]
end
"""


@pytest.mark.parametrize(
    ("trace", "verdict"),
    [
        ("join.Viewer_1, Station::pay.Viewer_1, start, count.1, Station::stop.1, count.0", "pass"),
        ("join.Viewer_1, start", "fail"),
        ("join.Viewer_1, join.Viewer_1", "fail"),
        ("join.Viewer_2, join.Viewer_1, Station::pay.Viewer_1, start, Station::stop.1", "fail"),
        ("join.Viewer_2, join.Viewer_1, Station::pay.Viewer_1, start, Station::stop.2", "pass"),
        (
            "join.Viewer_2, join.Viewer_1, Station::pay.Viewer_1, Station::pay.Viewer_2, start, start, "
            "count.2, all_stop, count.0",
            "pass",
        ),
    ],
)
def test_a_sequence_of_viewers(trace: str, verdict: str) -> None:
    assertion = f"Station :[has trace]: <{trace}>"
    assert outcome(f"{PAY_TV}reading seq Viewer = 2\nassert {assertion}", assertion)[0] == verdict


MULTIPLEXER = """
class Queue[T]
  visible INIT, Join, Leave
  state
    items : seq T
  where
    #items <= 1
  init
    items = <>
  op Join = [Delta(items); item? : T | items' = items ^ <item?>]
  op Leave = [Delta(items); item! : T | items = <item!> ^ items']
end
class Multiplexer
  visible INIT, left, right, move, out
  state
    first_, second_, output : Queue[0..1]
  init
    first_.INIT and second_.INIT and output.INIT
  op left = first_.Join
  op right = second_.Join
  op move = (first_.Leave || output.Join) [] (second_.Leave || output.Join)
  op out = output.Leave
end
Mux(l, r, o) =
     (null(l) & left?x -> Mux(<x>, r, o))
  [] (null(r) & right?x -> Mux(l, <x>, o))
  [] ((not null(l) or not null(r)) and null(o) & move -> (|~| s : {s | s <- {l, r}, not null(s)} @ Chosen(l, r, s)))
  [] (not null(o) & out!head(o) -> Mux(l, r, <>))
Chosen(l, r, s) = if l == r then Mux(<>, r, s) |~| Mux(l, <>, s) else if s == l then Mux(<>, r, s) else Mux(l, <>, s)
By_hand = Mux(<>, <>, <>)
reading seq (0..1) = 1
"""


@pytest.mark.parametrize("assertion", ["By_hand [FD= Multiplexer", "Multiplexer [FD= By_hand"])
def test_a_multiplexer_of_generic_queues(assertion: str) -> None:
    assert outcome(f"{MULTIPLEXER}assert {assertion}", assertion)[0] == "pass"


def test_a_pool_is_one_for_all_that_share_it() -> None:
    text = """
class Safe
  visible INIT, put, use
  state
    held : power Card
  init
    held = {}
  op put = [Delta(held); c? : Card | held' = held union {c?}]
  op use = [c? : Card | c? in held] @ c?.deposit
end
class House
  visible INIT, left, right, both
  state
    a, b : Safe
  init
    a.INIT and b.INIT and (forall c : Card @ c.INIT)
  op left = a.put || a.use
  op right = b.put
  op both = (a.use[x?/c?] and b.use[y?/c?])
end
"""
    for trace, verdict in (
        ("left.Card_1.1", "fail"),
        ("right.Card_1, right.Card_2", "pass"),
    ):
        assertion = f"House :[has trace]: <{trace}>"
        assert outcome(f"{CARD}{text}assert {assertion}", assertion)[0] == verdict, trace


def test_objects_that_are_values_have_objects() -> None:
    text = """
reading Door = 2
class Lock
  visible INIT, open, turn
  state
    open : bool
  init
    open = false
  op turn = [Delta(open) | open' = true and open = false]
end
class Door
  visible INIT, lock, turn
  state
    lock : Lock
  init
    lock.INIT
  op turn = lock.turn
end
class House
  visible turn, unlock, both, count
  state
    doors : power Door
  where
    forall d : Door @ d in doors
  init
    forall d : Door @ d.INIT
  op turn = [d? : Door] @ d?.turn
  op unlock = [d? : Door] @ d?.lock.turn
  op both = [d?, e? : Door] @ d?.turn and e?.lock.turn
  op count = [n! : 0..2 | n! = #{d : doors | d.lock.open = true}]
end
"""
    for trace, verdict in (
        ("House::turn.Door_1, unlock.Door_2, count.2", "pass"),
        ("House::turn.Door_1, unlock.Door_1", "fail"),
        ("both.Door_1.Door_2, count.2", "pass"),
        ("both.Door_1.Door_1, count.1", "pass"),  # what both ask of the one object agrees
    ):
        assertion = f"House :[has trace]: <{trace}>"
        assert outcome(f"{text}assert {assertion}", assertion)[0] == verdict, trace


def test_the_same_in_markup() -> None:
    tex = r"""
\begin{class}{Card}
\begin{state} balance : \nat \end{state}
\begin{op}{pay} \Delta(balance) \where balance' = balance + 1 \end{op}
\end{class}
\begin{class}{Bank}
\begin{state} cards : \power Card \end{state}
\begin{init} cards = \emptyset \end{init}
pay \sdef [card? : cards] @ card?.pay
\end{class}
"""
    bank = parse(Source("bank.tex", tex)).declarations[-1]
    assert "op pay = [card? : cards] @ card?.pay" in print_paragraph(bank)
    assert elaborate(parse(Source("bank.tex", tex))).specification.classes["Bank"].operations["pay"].delta == (
        "Card.balance",
    )


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("op x = [c? : cards] @ c?.close", "`Card` has no visible operation `close`"),
        ("op x = [c? : cards | c?.colour = 1]", "`Card` has no field `colour`"),
        ("op x = [c? : cards | c? = 1]", "`Card`"),
        ("op x = [d? : C | d? notin cards]", "a value of type `C` is no element of a set of `Card`"),
        ("op y = [n : nat | n = 1]\n  op x = and n : {1, 2} @ y", "`n` is declared twice"),
    ],
)
def test_what_cannot_be_is_refused_for_its_own_reason(body: str, message: str) -> None:
    text = f"{CARD}class C\n  state\n    cards : power Card\n  {body}\nend"
    assert message in refusal(text).message


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("op x = (([c? : cards] @ c?.deposit) [] [true]) and ([d? : cards] @ d?.withdraw)", "both operands change"),
        ("op x = [d? : C | d? = self]", "within itself"),
    ],
)
def test_what_is_typed_and_cannot_be_run_is_told(body: str, message: str) -> None:
    text = f"{CARD}class C\n  state\n    cards : power Card\n  {body}\nend\n"
    found = elaborate(parse(Source("cards.csp", text)))
    assert [(w.code, message in w.message) for w in found.warnings] == [("CSP673", True)]
    assert message in refusal(f"{text}assert C :[deadlock free]\n").message


@pytest.mark.parametrize(
    "body",
    [
        "state\n    x : nat\n  op x = [true]",
        "state\n    C : nat",
        "const C : nat where C = 1",
        "const x : nat\n  op x = [true]",
    ],
)
def test_a_name_is_one_thing_in_a_class(body: str) -> None:
    assert refusal(f"class C\n  {body}\nend").code == "CSP638"


def test_a_class_without_a_state_may_use_objects() -> None:
    text = f"{CARD}class User\n  op use = [c? : Card | c?.balance = 0 and c?.limit = 1] @ c?.deposit\nend\n"
    assertion = "User :[has trace]: <use.Card_1.1>"
    assert outcome(f"{text}assert {assertion}", assertion)[0] == "pass"
