"""Printing: the same tree when parsed again, brackets where they are needed, and tidy lines."""

from __future__ import annotations

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.cspm.parsing.reading import parse, parse_assertion, parse_expression
from cspcheck.cspm.printing.printer import print_assertion, print_expression, print_script
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as s
from tests.cspm.syntax.strategies_syntax import assertions, expressions, patterns, types, without_brackets
from tests.examples import examples


def tidy(text: str) -> str:
    return print_script(parse(Source("", text)))


@settings(max_examples=examples(150), deadline=None)
@given(expressions(3))
def test_expressions_come_back(expression: s.Expr) -> None:
    again = parse_expression(print_expression(expression))
    assert without_brackets(again) == without_brackets(expression)
    assert parse_expression(print_expression(again)) == again
    assert parse_expression(print_expression(again, width=10)) == again


@settings(max_examples=examples(100), deadline=None)
@given(assertions(1))
def test_assertions_come_back(assertion: s.Assertion) -> None:
    again = parse_assertion(print_assertion(assertion))
    assert without_brackets(again) == without_brackets(assertion)
    assert parse_assertion(print_assertion(again)) == again


@settings(max_examples=examples(100), deadline=None)
@given(patterns(3))
def test_patterns_come_back(pattern: s.Pattern) -> None:
    again = parse_expression(f"\\ {print_expression(pattern)} @ 0")
    assert isinstance(again, s.Lambda)
    assert without_brackets(again.parameters) == without_brackets((pattern,))


@settings(max_examples=examples(100), deadline=None)
@given(types(4))
def test_types_come_back(written: s.TypeExpr) -> None:
    annotation = parse(Source("", f"x :: {print_expression(written)}\nx = 1")).declarations[0]
    assert isinstance(annotation, s.AnnotationDeclaration)
    assert annotation.scheme.type == written


# A tree without brackets, by the text that has them; and what is printed for it.
NEEDED = {
    "(1 + 2) * 3": "(1 + 2) * 3",
    "1 + (2 * 3)": "1 + 2 * 3",
    "1 - (2 - 3)": "1 - (2 - 3)",
    "(1 - 2) - 3": "1 - 2 - 3",
    "(a < b) == c": "(a < b) == c",
    "2 * (-3)": "2 * -3",
    "(2 * (-3)) * 4": "2 * (-3) * 4",
    "(-3) ^ s": "(-3)^s",
    "-(-3)": "- -3",
    "-(a + b)": "-(a + b)",
    "-(a * b)": "-a * b",
    "not (a and b)": "not (a and b)",
    "(not a) == b": "(not a) == b",
    "a == (not b)": "a == not b",
    "#(s ^ t)": "#s^t",
    "(#s) ^ t": "(#s)^t",
    "(a.b).c": "(a.b).c",
    "a.(b.c)": "a.b.c",
    "a.(b + 1)": "a.b+1",
    "(a.b) + 1": "(a.b) + 1",
    "(\\ x @ x)(1)": "(\\ x @ x)(1)",
    "(if a then b else c) + 1": "(if a then b else c) + 1",
    "1 + (if a then b else c)": "1 + if a then b else c",
    "1 + (if a then b else c) + 2": "1 + (if a then b else c) + 2",
    "(a -> P) [] Q": "a -> P [] Q",
    "a -> (P [] Q)": "a -> (P [] Q)",
    "(P [] Q) ; R": "(P [] Q) ; R",
    "P ; (Q ; R)": "P ; (Q ; R)",
    "(P [| A |] Q) [| B |] R": "(P [| A |] Q) [| B |] R",
    "(P \\ A) ||| Q": "P \\ A ||| Q",
    "P ||| (Q \\ A)": "P ||| (Q \\ A)",
    "(P ||| Q) \\ A": "P ||| Q \\ A",
    "(P ||| (Q \\ A)) [] R": "(P ||| (Q \\ A)) [] R",
    "((P \\ A) [] Q) ||| R": "P \\ A [] Q ||| R",
    "R ||| ((P \\ A) [] Q)": "R ||| (P \\ A) [] Q",
    "a -> (P \\ A)": "a -> (P \\ A)",
    "(P \\ A)[[a <- b]]": "(P \\ A)[[ a <- b ]]",
    "([] x : S @ P) [] Q": "([] x : S @ P) [] Q",
    "P [] ([] x : S @ Q)": "P [] [] x : S @ Q",
    "c!(if a then 1 else 2) -> P": "c!(if a then 1 else 2) -> P",
    "<(x > 1)>": "<(x > 1)>",
    "<f(x > 1)>": "<f(x > 1)>",
    "<x < 1>": "<x < 1>",
    "<a.(x > 1)>": "<a.(x > 1)>",
    "<let y = (2 > 1) within y>": "<let y = 2 > 1 within y>",
    "{-1}": "{ -1}",
    "{(-1)..1}": "{ -1..1}",
    "<-1>": "< -1>",
    "{||| x : S @ P}": "{ ||| x : S @ P}",
    "\\ (x @@ y) @ x": "\\ x @@ y @ x",
    "c?(x @@ y) -> P": "c?(x @@ y) -> P",
    "\\ (<x>^xs).y @ x": "\\ <x>^xs.y @ x",
}


@pytest.mark.parametrize("text", NEEDED)
def test_brackets_stand_where_the_tree_needs_them(text: str) -> None:
    source = text.replace("{-", "{ -").replace("{|||", "{ |||")
    bare = without_brackets(parse_expression(source))
    assert print_expression(bare) == NEEDED[text]
    assert without_brackets(parse_expression(NEEDED[text])) == bare


def test_the_brackets_of_the_source_are_kept() -> None:
    assert print_expression(parse_expression("((a)) + (b * (c))")) == "((a)) + (b * (c))"


@pytest.mark.parametrize(
    ("kind", "value", "text"),
    [
        ("char", "a", "'a'"),
        ("char", "'", "'\\''"),
        ("char", '"', "'\"'"),
        ("char", "\\", "'\\\\'"),
        ("char", "\n", "'\\n'"),
        ("string", 'say "no"', '"say \\"no\\""'),
        ("string", "it's\t\\", '"it\'s\\t\\\\"'),
        ("bool", True, "true"),
        ("int", 7, "7"),
    ],
)
def test_literals(kind: str, value: object, text: str) -> None:
    literal = parse_expression(text)
    assert isinstance(literal, s.LiteralExpr)
    assert (literal.kind, literal.value) == (kind, value)
    assert print_expression(literal) == text


@given(st.text(st.characters(exclude_categories=["Cs"]), max_size=20))
def test_strings_of_all_characters(text: str) -> None:
    literal = s.LiteralExpr(span=Source("", "").span(0, 0), kind="string", value=text)
    assert parse_expression(print_expression(literal)) == literal


class TestNegatedAssertions:
    def test_not_before_a_refinement(self) -> None:
        assert print_assertion(parse_assertion("not not P [T= Q")) == "not not P [T= Q"

    def test_not_in_the_specification(self) -> None:
        assert print_assertion(parse_assertion("(not a) [T= Q")) == "(not a) [T= Q"
        assert print_assertion(without_brackets(parse_assertion("(not a) [T= Q"))) == "(not a) [T= Q"


class TestLines:
    def test_what_fits_stands_on_one_line(self) -> None:
        assert tidy("P =\n  a ->\n b -> STOP\n []\nc -> STOP") == "P = a -> b -> STOP [] c -> STOP\n"

    def test_operands_of_a_long_row_stand_under_each_other(self) -> None:
        long = "Name_of_a_process_that_is_long"
        assert tidy(f"P = a -> {long} [] b -> {long} [] c -> {long}") == (
            f"P =\n  a -> {long}\n  [] b -> {long}\n  [] c -> {long}\n"
        )

    def test_long_lists_are_filled_if_simple(self) -> None:
        numbers = ", ".join(str(number) for number in range(100, 140))
        lines = tidy(f"s = {{{numbers}}}").split("\n")
        assert lines[0] == "s = {"
        assert lines[1].startswith("  100, 101, 102")
        assert lines[-2] == "}"
        assert max(map(len, lines)) <= 100

    def test_long_lists_of_others_stand_one_to_a_line(self) -> None:
        call = "some_function(with_an_argument, and_another)"
        assert tidy(f"x = f({call}, {call}, {call})") == f"x = f(\n  {call},\n  {call},\n  {call}\n)\n"

    def test_bracketed_processes_hang_on_their_prefix(self) -> None:
        long = "Name_of_a_process_that_is_long_enough_for_this"
        assert tidy(f"P = a -> (b -> {long} [] c -> {long})") == (
            f"P =\n  a -> (\n    b -> {long}\n    [] c -> {long}\n  )\n"
        )

    def test_conditionals(self) -> None:
        long = "name_of_a_value_that_is_quite_long"
        assert tidy(f"f(x) = if x == 1 then {long} else if x == 2 then {long} else {long}") == (
            f"f(x) =\n  if x == 1 then\n    {long}\n  else if x == 2 then\n    {long}\n  else\n    {long}\n"
        )

    def test_lets(self) -> None:
        assert tidy("x = let y = 1 within y") == "x = let y = 1 within y\n"
        assert tidy("x = let y = 1\nz = 2\nwithin y") == "x =\n  let\n    y = 1\n    z = 2\n  within y\n"

    def test_modules_and_sections(self) -> None:
        assert tidy("module M(x)\ny=1\nexports\nz=2\nendmodule\nTimed(f){P=STOP}\nTimed{}") == (
            "module M(x)\n  y = 1\nexports\n  z = 2\nendmodule\n\nTimed(f) {\n  P = STOP\n}\n\nTimed {\n}\n"
        )

    def test_declarations_of_one_kind_stand_together(self) -> None:
        assert tidy("channel a\nchannel b\nx = 1\ny = 2\nf :: (Int) -> Int\nf(x) = x\nassert true") == (
            "channel a\nchannel b\n\nx = 1\ny = 2\n\nf :: (Int) -> Int\nf(x) = x\n\nassert true\n"
        )

    def test_an_empty_script_is_an_empty_text(self) -> None:
        assert tidy("-- nothing\n") == ""

    @given(st.integers(1, 200))
    def test_every_width_gives_the_same_tree(self, width: int) -> None:
        text = (
            "P(x) = a -> b?y:{1..x} -> (if x > 1 then P(x - 1) else STOP)\n"
            "  [] (let z = x * 2 within c.z -> Q \\ {| a |})\n"
            "s = <(y, z) | y <- <1, 2, 3>, z <- f(y)(1), (y > 2)>^<4> == <> and not true or { -1} == {}\n"
            "assert not P(1) [FD= Q [| {| a, b |} |] (R ||| STOP) :[tau priority]: {a}"
        )
        script = parse(Source("", text))
        assert parse(Source("", print_script(script, width=width))) == script
