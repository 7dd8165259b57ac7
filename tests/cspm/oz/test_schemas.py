"""The schema calculus: schemas that expressions make are held against sets of bindings that are gone through."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.reading.latex_reader import LatexDocument
from cspcheck.cspm.oz.typing.elaboration import elaborate
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.source import Source
from tests.cspm.oz import naive
from tests.cspm.oz.test_meaning import outcome
from tests.examples import examples

WINDOW = range(-1, 4)
"""Integers beyond those that the schemas tell apart, one on either side."""

TEXT = """
schema State
  x : 0..2
  y : 0..2
where
  x <= y
end
schema Step
  Delta State
  k? : 0..2
where
  x' = x + k?
end
Back == [State; State' | x' = 0; y' = y]
Read == [Xi State; k! : 0..2 | k! = y]
Low == [x : 0..2 | x < 2]
S == {body}
"""


@dataclass(frozen=True)
class Bindings:
    """A schema as the names of its components and a test of their values."""

    names: frozenset[str]
    holds: Callable[[Mapping[str, int]], bool]


def small(*names: str) -> Callable[[Mapping[str, int]], bool]:
    return lambda b: all(0 <= b[name] <= 2 for name in names)


def state(b: Mapping[str, int], prime: str = "") -> bool:
    return small(f"x{prime}", f"y{prime}")(b) and b[f"x{prime}"] <= b[f"y{prime}"]


def both(b: Mapping[str, int]) -> bool:
    return state(b) and state(b, "'")


FOUR = frozenset(["x", "y", "x'", "y'"])
BASES = {
    "State": Bindings(frozenset("xy"), state),
    "Step": Bindings(FOUR | {"k?"}, lambda b: both(b) and small("k?")(b) and b["x'"] == b["x"] + b["k?"]),
    "Back": Bindings(FOUR, lambda b: both(b) and b["x'"] == 0 and b["y'"] == b["y"]),
    "Read": Bindings(
        FOUR | {"k!"},
        lambda b: both(b) and small("k!")(b) and (b["x'"], b["y'"], b["k!"]) == (b["x"], b["y"], b["y"]),
    ),
    "Low": Bindings(frozenset("x"), lambda b: 0 <= b["x"] < 2),
}


def without(one: Bindings, gone: frozenset[str]) -> Bindings:
    names = sorted(gone)

    def holds(b: Mapping[str, int]) -> bool:
        return any(one.holds({**b, **dict(zip(names, v, strict=True))}) for v in product(WINDOW, repeat=len(names)))

    return Bindings(one.names - gone, holds)


def called(one: Bindings, names: Mapping[str, str]) -> Bindings:
    return Bindings(
        frozenset(names.get(n, n) for n in one.names),
        lambda b: one.holds({n: b[names.get(n, n)] for n in one.names}),
    )


def through(left: Bindings, right: Bindings, ends: tuple[str, str]) -> Bindings:
    joint = {n[:-1] for n in left.names if n.endswith(ends[0])} & {
        n.removesuffix("?") for n in right.names if n.endswith(ends[1]) and not n.endswith(("'", "!"))
    }
    first = called(left, {n + ends[0]: n + ">" for n in joint})
    second = called(right, {n + ends[1]: n + ">" for n in joint})
    made = Bindings(first.names | second.names, lambda b: first.holds(b) and second.holds(b))
    return without(made, frozenset(n + ">" for n in joint))


LOGIC: dict[str, Callable[[bool, bool], bool]] = {
    "and": lambda p, q: p and q,
    "or": lambda p, q: p or q,
    "=>": lambda p, q: not p or q,
    "<=>": lambda p, q: p == q,
}


@st.composite
def expressions(draw: st.DrawFn, depth: int = 2) -> tuple[str, Bindings]:
    """The text of an expression with the schema that it stands for."""
    if depth == 0 or draw(st.integers(0, 5)) == 0:
        name = draw(st.sampled_from(sorted(BASES)))
        return name, BASES[name]
    text, one = draw(expressions(depth - 1))
    if not one.names:
        return text, one
    kind = draw(st.integers(0, 10))
    if kind == 0:
        gone = draw(st.sampled_from(sorted(one.names)))
        return f"({text}) \\ ({gone})", without(one, frozenset([gone]))
    if kind == 1:
        old = draw(st.sampled_from(sorted(one.names)))
        new = draw(st.sampled_from(["x", "k?", "z'"]))
        return f"({text})[{new}/{old}]", called(one, {old: new})
    if kind == 2:
        return f"(pre ({text}))", without(one, frozenset(n for n in one.names if n.endswith(("'", "!"))))
    if kind == 3:
        return f"(not ({text}))", Bindings(one.names, lambda b: not one.holds(b))
    if kind == 4:
        quantifier, which = draw(st.sampled_from([("exists", any), ("forall", all)]))

        def holds(b: Mapping[str, int]) -> bool:
            return which(one.holds({**b, "x": v}) for v in (0, 1))

        return f"({quantifier} x : 0..1 @ ({text}))", Bindings(one.names - {"x"}, holds)
    other, second = draw(expressions(depth - 1))
    if kind == 5:
        return f"(({text}) comp ({other}))", through(one, second, ("'", ""))
    if kind == 6:
        joined = Bindings(one.names | second.names, lambda b: one.holds(b) and second.holds(b))
        return f"(({text}) filter ({other}))", without(joined, joined.names - second.names)
    sign = draw(st.sampled_from(sorted(LOGIC)))
    made = Bindings(one.names | second.names, lambda b: LOGIC[sign](one.holds(b), second.holds(b)))
    return f"(({text}) {sign} ({other}))", made


def specification(text: str) -> core.Specification:
    return elaborate(parse(Source("schemas.csp", text))).specification


@settings(max_examples=examples(30), deadline=None)
@given(expressions())
def test_an_expression_has_the_bindings_of_its_definition(found: tuple[str, Bindings]) -> None:
    text, bindings = found
    record = specification(TEXT.format(body=f"[{text}]")).records["S"]
    assert {field.name for field in record.fields} == bindings.names

    names = sorted(bindings.names)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(naive._STRICT, "Int", lambda: frozenset(WINDOW))
        values = list(product(WINDOW, repeat=len(names)))
        for chosen in values[:: max(1, len(values) // 60)]:
            env: dict[Any, Any] = dict(zip(names, chosen, strict=True))
            inside = all(env[f.name] in naive.interpret(f.carrier, env) for f in record.fields)
            holds = inside and all(naive.interpret(p, env) is True for p in record.predicates)
            assert holds == bindings.holds(env), (text, env)


BOOK = """
given NAME, DATE
reading NAME = 2
reading DATE = 2
REPORT ::= ok | known_already
schema Book
  known : power NAME
  birthday : NAME -|-> DATE
where
  known = dom birthday
end
schema Enter
  Delta Book
  name? : NAME
  date? : DATE
where
  name? notin known
  birthday' = birthday union {name? |-> date?}
end
Success == [result! : REPORT | result! = ok]
Known == [Xi Book; name? : NAME; result! : REPORT | name? in known; result! = known_already]
Robust == (Enter and Success) or Known

class Birthdays
  visible Add, Remind
  state
    Book
  init
    known = {}
  op Add
    Delta(known, birthday)
    Robust
  op Remind
    Xi Book
    today? : DATE
    cards! : power NAME
  where
    cards! = {n : known | birthday(n) = today?}
end
"""


@pytest.mark.parametrize(
    ("assertion", "verdict"),
    [
        ("Birthdays :[deadlock free]", "pass"),
        ("Birthdays :[has trace]: <Add.NAME_1.DATE_2.ok, Remind.DATE_2.{NAME_1}, Remind.DATE_1.{}>", "pass"),
        ("Birthdays :[has trace]: <Add.NAME_1.DATE_2.ok, Add.NAME_1.DATE_1.known_already>", "pass"),
        ("Birthdays :[has trace]: <Add.NAME_1.DATE_2.ok, Add.NAME_1.DATE_1.ok>", "fail"),
    ],
)
def test_a_birthday_book_of_schemas_runs_as_a_class(assertion: str, verdict: str) -> None:
    assert outcome(f"{BOOK}assert {assertion}", assertion)[0] == verdict


def test_the_same_book_in_markup() -> None:
    markup = r"""
\begin{zed} [NAME, DATE] \end{zed}
\begin{schema}{Book}
known : \power NAME \\ birthday : NAME \pfun DATE
\where known = \dom birthday
\end{schema}
\begin{schema}{Enter}
\Delta Book \\ name? : NAME \\ date? : DATE
\where name? \notin known \\ birthday' = birthday \cup \{ name? \mapsto date? \}
\end{schema}
\begin{zed}
Again \defs Enter \semi Enter
\also
CanEnter \defs \pre Enter
\also
Quiet \defs Enter \hide (date?)
\also
Other \defs Enter[who?/name?] \lor \lnot Enter
\end{zed}
"""
    document = LatexDocument(Source("book.tex", markup), lambda path, place: ())
    assert document.errors == []
    records = elaborate(document.script()).specification.records
    four = ["known", "birthday", "known'", "birthday'"]
    assert [f.name for f in records["Enter"].fields] == [*four, "name?", "date?"]
    assert {f.name for f in records["Again"].fields} == {*four, "name?", "date?"}
    assert [f.name for f in records["CanEnter"].fields] == ["known", "birthday", "name?", "date?"]
    assert [f.name for f in records["Quiet"].fields] == [*four, "name?"]
    assert {f.name for f in records["Other"].fields} == {*four, "name?", "date?", "who?"}


def test_schemas_are_predicates_types_and_bindings() -> None:
    text = """
schema Point
  x : 0..2
  y : 0..2
where
  x <= y
end
Pair[X] == [first_ : X; second_ : X]
const origin : Point
where
  origin.x = 0 and origin.y = 0
end
class C
  visible go, at, both
  state
    x, y : 0..2
  where
    Point
  init
    theta Point = origin
  op go = [Delta(x, y) | x' = x and y' = y + 1]
  op at = [p! : Point | p! = theta Point]
  op both = [p? : Pair[0..1] | p?.first_ < p?.second_ and (exists Point @ x > 1)]
end
"""
    assert list(specification(text).records) == ["Point", "Pair[0..1]"]
    script = f"{text}assert C :[has trace]: <at.(0,0), go, at.(0,1), both.(0,1)>"
    assert outcome(script, "C :[has trace]: <at.(0,0), go, at.(0,1), both.(0,1)>")[0] == "pass"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("S == [x : nat]\nT == [S; x : bool]", "the types `int` and `bool` differ"),
        ("N == 1..2\nS == [N; x : nat]", "this is no schema"),
        ("N == 1..2\nS == [Delta N; x : nat]", "this is no schema"),
        ("N == 1..2\nS == [x : nat | pre N = {}]", "this is no schema"),
        ("N == 1..2\nS == N[z/y]", "this is no schema"),
        ("S == [x : nat] \\ (y)", "`y` is no component of this schema"),
        ("S == [x : nat]\nT == S[z/y]", "`y` is no component of this schema"),
        ("S == [x : nat]\nT == [y : nat | S]", "`x` is not known here"),
    ],
)
def test_what_has_no_meaning_is_refused_for_its_own_reason(text: str, message: str) -> None:
    with pytest.raises(ScriptError) as error:
        specification(f"given A\n{text}")
    assert message in error.value.diagnostics[0].message, error.value.diagnostics[0].message
