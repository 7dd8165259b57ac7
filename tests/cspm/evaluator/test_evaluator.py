"""Expressions have the values that the same expressions have in Python, evaluated with and without types.

The expressions are made together with a Python function that computes what they should give. They stand in the body
of a function that is called many times, so that every way in which the evaluator runs a function is seen.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from unittest import mock

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.evaluator import comprehensions, routines
from cspcheck.cspm.script import Script, load
from cspcheck.cspm.source import Source

EXAMPLES = int(os.environ.get("CSPCHECK_FUZZ", "150"))
Meaning = Callable[[dict[str, Any]], Any]


@dataclass(frozen=True)
class Made:
    """An expression of the language and what it means in Python, given the values of its variables."""

    text: str
    meaning: Meaning

    def __repr__(self) -> str:
        return self.text


class Nothing(Exception):
    """There is no value: division by zero, or the head of nothing."""


def divided(a: int, b: int) -> int:
    if b == 0:
        raise Nothing
    return a // b


def modulo(a: int, b: int) -> int:
    if b == 0:
        raise Nothing
    return a % b


def first(xs: tuple[Any, ...]) -> Any:
    if not xs:
        raise Nothing
    return xs[0]


def rest(xs: tuple[Any, ...]) -> Any:
    if not xs:
        raise Nothing
    return xs[1:]


def constant(text: str, value: Any) -> Made:
    return Made(text, lambda env: value)


def variable(name: str) -> Made:
    return Made(name, lambda env: env[name])


def two(text: str, operation: Callable[[Any, Any], Any]) -> Callable[[Made, Made], Made]:
    def make(a: Made, b: Made) -> Made:
        return Made(text.format(f"({a.text})", f"({b.text})"), lambda env: operation(a.meaning(env), b.meaning(env)))

    return make


def one(text: str, operation: Callable[[Any], Any]) -> Callable[[Made], Made]:
    return lambda a: Made(text.format(f"({a.text})"), lambda env: operation(a.meaning(env)))


def choice(b: Made, x: Made, y: Made) -> Made:
    return Made(
        f"(if {b.text} then {x.text} else {y.text})",
        lambda env: x.meaning(env) if b.meaning(env) else y.meaning(env),
    )


def both(a: Made, b: Made) -> Made:
    return Made(f"({a.text}) and ({b.text})", lambda env: a.meaning(env) and b.meaning(env))


def either(a: Made, b: Made) -> Made:
    return Made(f"({a.text}) or ({b.text})", lambda env: a.meaning(env) or b.meaning(env))


def defined(name: str, value: Made, body: Made) -> Made:
    return Made(
        f"(let {name} = {value.text} within {body.text})",
        lambda env: body.meaning(env | {name: Later(value, env)}),
    )


class Later:
    """A value of a `let`, worked out if and when it is asked for."""

    def __init__(self, made: Made, env: dict[str, Any]) -> None:
        self.made = made
        self.env = env

    def __call__(self) -> Any:
        return self.made.meaning(self.env)


def local(name: str) -> Made:
    def meaning(env: dict[str, Any]) -> Any:
        found = env[name]
        return found() if isinstance(found, Later) else found

    return Made(name, meaning)


def comprehension(opening: str, item: Made, source: Made, test: Made) -> Made:
    closing = {"<": ">", "{": "}"}[opening]

    def meaning(env: dict[str, Any]) -> Any:
        found = source.meaning(env)
        inside = [env | {"i": x} for x in (sorted(found) if opening == "{" else found)]
        items = [item.meaning(e) for e in inside if test.meaning(e)]
        return frozenset(items) if opening == "{" else tuple(items)

    return Made(f"{opening}{item.text} | i <- {source.text}, {test.text}{closing}", meaning)


def numbers(depth: int, names: tuple[str, ...]) -> st.SearchStrategy[Made]:
    leaves = st.one_of(
        st.integers(0, 5).map(lambda n: constant(str(n), n)),
        st.sampled_from(names).map(local),
    )
    if depth == 0:
        return leaves
    n, b, s, e = (make(depth - 1, names) for make in (numbers, truths, sequences, sets))
    return st.one_of(
        leaves,
        st.builds(two("({} + {})", lambda a, b: a + b), n, n),
        st.builds(two("({} - {})", lambda a, b: a - b), n, n),
        st.builds(two("({} * {})", lambda a, b: a * b), n, n),
        st.builds(two("({} / {})", divided), n, n),
        st.builds(two("({} % {})", modulo), n, n),
        st.builds(one("(-{})", lambda a: -a), n),
        st.builds(choice, b, n, n),
        st.builds(one("#{}", len), s),
        st.builds(one("head({})", first), s),
        st.builds(one("card({})", len), e),
        st.builds(lambda value, body: defined(f"k{depth}", value, body), n, numbers(depth - 1, (*names, f"k{depth}"))),
    )


def truths(depth: int, names: tuple[str, ...]) -> st.SearchStrategy[Made]:
    if depth == 0:
        return st.sampled_from([constant("true", True), constant("false", False)])
    n, b, s, e = (make(depth - 1, names) for make in (numbers, truths, sequences, sets))
    return st.one_of(
        st.builds(two("({} == {})", lambda a, b: a == b), n, n),
        st.builds(two("({} != {})", lambda a, b: a != b), s, s),
        st.builds(two("({} == {})", lambda a, b: a == b), e, e),
        st.builds(two("({} < {})", lambda a, b: a < b), n, n),
        st.builds(two("({} >= {})", lambda a, b: a >= b), n, n),
        st.builds(two("({} <= {})", lambda a, b: a <= b), e, e),
        st.builds(two("({} <= {})", lambda a, b: b[: len(a)] == a), s, s),
        st.builds(two("member({}, {})", lambda a, b: a in b), n, e),
        st.builds(two("elem({}, {})", lambda a, b: a in b), n, s),
        st.builds(one("(not {})", lambda a: not a), b),
        st.builds(one("null({})", lambda a: not a), s),
        st.builds(both, b, b),
        st.builds(either, b, b),
        st.builds(choice, b, b, b),
    )


def sequences(depth: int, names: tuple[str, ...]) -> st.SearchStrategy[Made]:
    leaves = st.sampled_from([constant("<>", ()), constant("<3, 1>", (3, 1)), constant("<1..4>", (1, 2, 3, 4))])
    if depth == 0:
        return leaves
    n, b, s, e = (make(depth - 1, names) for make in (numbers, truths, sequences, sets))
    inside = (*names, "i")
    return st.one_of(
        leaves,
        st.builds(two("<{}, {}>", lambda a, b: (a, b)), n, n),
        st.builds(two("({}^{})", lambda a, b: a + b), s, s),
        st.builds(two("(<{}>^{})", lambda a, b: (a, *b)), n, s),
        st.builds(one("tail({})", rest), s),
        st.builds(choice, b, s, s),
        st.builds(one("seq({})", lambda a: tuple(sorted(a))), e),
        st.builds(
            lambda item, source, test: comprehension("<", item, source, test),
            numbers(depth - 1, inside),
            s,
            truths(depth - 1, inside),
        ),
    )


def sets(depth: int, names: tuple[str, ...]) -> st.SearchStrategy[Made]:
    leaves = st.sampled_from([constant("{}", frozenset()), constant("{2, 4}", frozenset({2, 4}))])
    if depth == 0:
        return leaves
    n, b, s, e = (make(depth - 1, names) for make in (numbers, truths, sequences, sets))
    inside = (*names, "i")
    return st.one_of(
        leaves,
        st.builds(two("{{{}, {}}}", lambda a, b: frozenset((a, b))), n, n),
        st.builds(two("union({}, {})", lambda a, b: a | b), e, e),
        st.builds(two("inter({}, {})", lambda a, b: a & b), e, e),
        st.builds(two("diff({}, {})", lambda a, b: a - b), e, e),
        st.builds(one("set({})", frozenset), s),
        st.builds(choice, b, e, e),
        st.builds(
            lambda item, source, test: comprehension("{", item, source, test),
            numbers(depth - 1, inside),
            e,
            truths(depth - 1, inside),
        ),
    )


PARAMETERS = ("x", "y")
expressions = st.one_of(*[make(3, PARAMETERS) for make in (numbers, truths, sequences, sets)])


@settings(max_examples=EXAMPLES, deadline=None)
@given(expressions, st.sampled_from(["untyped", "typed", "hot"]))
def test_expressions_mean_what_they_mean_in_python(made: Made, way: str) -> None:
    text = f"f(x, y) = {made.text}\ng(x, y) = f(x + 0, y + 0)"
    script = load(Source("test.csp", text), typecheck=way != "untyped")
    hot = 1 if way == "hot" else 1_000_000
    with mock.patch.object(routines, "HOT", hot), mock.patch.object(comprehensions, "HOT", hot):
        compare(script, made)


def compare(script: Script, made: Made) -> None:
    for x, y in [(0, 0), (1, 2), (3, 1), (2, 5)] * 3:
        try:
            expected = made.meaning({"x": x, "y": y})
        except Nothing:
            # Laziness may leave out what goes wrong, as in the length of <1 / 0>; Python works everything out.
            ends_in_a_diagnostic_or_a_value(script, f"g({x}, {y})")
        else:
            found = script.evaluate(f"g({x}, {y})")
            assert found == expected
            assert type(found) is type(expected)


def ends_in_a_diagnostic_or_a_value(script: Any, text: str) -> None:
    found: tuple[Diagnostic, ...] = ()
    try:
        script.evaluate(text)
    except ScriptError as error:
        found = error.diagnostics
    assert {d.code for d in found} <= {"CSP401", "CSP402"}
    assert all(d.span is not None for d in found)


# --- particular functions ---------------------------------------------------------------------------------------

FUNCTIONS = r"""
map(f, <>) = <>
map(f, <x>^xs) = <f(x)>^map(f, xs)
filter(p, xs) = <x | x <- xs, p(x)>
foldl(f, e, <>) = e
foldl(f, e, <x>^xs) = foldl(f, f(e, x), xs)
reverse(xs) = let go(<>, ys) = ys
                  go(<z>^zs, ys) = go(zs, <z>^ys)
              within go(xs, <>)
sort(<>) = <>
sort(<p>^xs) = sort(<x | x <- xs, x < p>)^<p>^sort(<x | x <- xs, x >= p>)
zip(<>, _) = <>
zip(_, <>) = <>
zip(<x>^xs, <y>^ys) = <(x, y)>^zip(xs, ys)
power({}) = {{}}
power(s) = let x = head(seq(s))
               p = power(diff(s, {x}))
           within union(p, {union(t, {x}) | t <- p})
close(r) = let t = union(r, {(x, z) | (x, y) <- r, (w, z) <- r, y == w}) within if t == r then r else close(t)
evens = <0>^<n + 2 | n <- evens>
take(0, _) = <>
take(n, <x>^xs) = <x>^take(n - 1, xs)
primes = let sieve(<p>^xs) = <p>^sieve(<x | x <- xs, x % p != 0>) within sieve(<2..>)
"""
LIBRARY = load(Source("library.csp", FUNCTIONS))
lists = st.lists(st.integers(0, 9), max_size=8)


def literal(items: list[int]) -> str:
    return f"<{', '.join(map(str, items))}>"


@given(lists, lists)
def test_functions_on_sequences(xs: list[int], ys: list[int]) -> None:
    a, b = literal(xs), literal(ys)
    assert LIBRARY.evaluate(f"map(\\ x @ x * x, {a})") == tuple(x * x for x in xs)
    assert LIBRARY.evaluate(f"filter(\\ x @ x % 2 == 0, {a})") == tuple(x for x in xs if x % 2 == 0)
    assert LIBRARY.evaluate(f"foldl(\\ e, x @ 2 * e + x, 1, {a})") == _fold(xs)
    assert LIBRARY.evaluate(f"reverse({a})") == tuple(reversed(xs))
    assert LIBRARY.evaluate(f"sort({a})") == tuple(sorted(xs))
    assert LIBRARY.evaluate(f"zip({a}, {b})") == tuple(zip(xs, ys, strict=False))
    assert LIBRARY.evaluate(f"concat(<{a}, {b}, {a}>)") == tuple(xs + ys + xs)


def _fold(xs: list[int]) -> int:
    result = 1
    for x in xs:
        result = 2 * result + x
    return result


@given(st.frozensets(st.integers(0, 5), max_size=4))
def test_a_power_set_written_out(items: frozenset[int]) -> None:
    text = f"{{{', '.join(map(str, items))}}}"
    assert LIBRARY.boolean(f"power({text}) == Set({text})")


@given(st.frozensets(st.tuples(st.integers(0, 4), st.integers(0, 4)), max_size=6))
def test_a_transitive_closure(pairs: frozenset[tuple[int, int]]) -> None:
    expected = set(pairs)
    while True:
        more = {(a, d) for a, b in expected for c, d in expected if b == c} - expected
        if not more:
            break
        expected |= more
    text = f"{{{', '.join(f'({a}, {b})' for a, b in pairs)}}}"
    assert LIBRARY.evaluate(f"close({text})") == frozenset(expected)


def test_sequences_that_are_defined_by_themselves() -> None:
    assert LIBRARY.evaluate("take(5, evens)") == (0, 2, 4, 6, 8)
    assert LIBRARY.evaluate("take(10, primes)") == (2, 3, 5, 7, 11, 13, 17, 19, 23, 29)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("head(tail(<1>))", "`head` of an empty sequence"),
        ("mapLookup(emptyMap, 1)", "the key `1` is not in the map `(| |)`"),
        ("7 % (3 - 3)", "division by zero: `7 % 0`"),
        ("foldl(\\ e, x @ x / e, 0, <1, 2>)", "division by zero: `1 / 0`"),
        ("take(2, <1>)", "no clause of `take` matches `(1, <>)`"),
        ("(\\ <x> @ x)(<1, 2>)", "no clause of `(\\ <x> @ ...)` matches `(<1, 2>)`"),
        ("let (1, x) = (2, 3) within x", "`(2, 3)` does not match the pattern `(1, x)`"),
        ('error("no "^show({1}))', "the script says: no {1}"),
        ("card(union({0..}, { -5}))", "the set `union({ -5}, {0..})` is infinite"),
    ],
)
def test_messages_say_what_the_values_were(text: str, message: str) -> None:
    with pytest.raises(ScriptError) as raised:
        LIBRARY.evaluate(text)
    assert raised.value.diagnostics[0].message == message


def test_the_call_stack_tells_where_each_call_had_come_to() -> None:
    text = "f(x) =\n  1 / x\ng(y) = let h(z) =\n  f(z) + 1\n within h(y - 1)\nv = g(1)\nw = v + 1"
    script = load(Source("s.csp", text))
    with pytest.raises(ScriptError) as raised:
        script.evaluate("w")
    (diagnostic,) = raised.value.diagnostics
    assert diagnostic.span is not None
    assert diagnostic.span.line == 2
    assert diagnostic.notes == ("in f(0), line 2", "in h(0), line 4", "in g(1), line 5", "in v, line 6", "in w, line 7")


def test_a_long_call_stack_is_cut_in_the_middle() -> None:
    script = load(Source("s.csp", "f(x) = if x == 0 then 1 / x else 1 + f(x - 1)"))
    with pytest.raises(ScriptError) as raised:
        script.evaluate("f(1000)")
    notes = raised.value.diagnostics[0].notes
    assert len(notes) == 12
    assert notes[0] == "in f(0), line 1"
    assert notes[8] == "... 990 more calls"
    assert notes[-1] == "in f(1000), line 1"
