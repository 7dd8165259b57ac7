"""The binding powers of all operators, against a slow and obvious reading of the operator table."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given, strategies as st

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.parsing.reading import parse_expression
from cspcheck.cspm.syntax import tree as s
from tests.cspm.syntax.strategies_syntax import without_brackets

# The operator table, tightest first: (operators, associativity).
VALUES: list[tuple[list[str], str]] = [
    (["^"], "left"),
    (["#"], "sign"),
    (["*", "/", "%"], "left"),
    (["+", "-"], "left"),
    (["==", "!=", "<", "<=", ">", ">="], "none"),
    (["not"], "sign"),
    (["and"], "left"),
    (["or"], "left"),
    (["."], "right"),
]
PROCESSES: list[tuple[list[str], str]] = [
    (["->", "&"], "right"),
    ([";"], "left"),
    (["[>"], "left"),
    (["/\\", "/+ A +\\"], "left"),
    (["[]", "[+ A +]"], "left"),
    (["|~|"], "left"),
    (["[| A |]", "[ A || B ]", "[| A |>", "[ a <-> b ]"], "none"),
    (["|||"], "left"),
]
TABLE = [(level, operator, side) for level, (row, side) in enumerate(VALUES + PROCESSES) for operator in row]
LEVEL = {operator: level for level, operator, _ in TABLE}
SIDE = {operator: side for _, operator, side in TABLE}
BINARY = [operator for operator in LEVEL if SIDE[operator] != "sign"]
PREFIXES = ("->", "&")


def same(written: str, meant: str) -> bool:
    """Whether two texts have the same tree, brackets apart."""
    return bool(without_brackets(parse_expression(written)) == without_brackets(parse_expression(meant)))


@pytest.mark.parametrize("first", BINARY)
def test_two_operators_in_a_row(first: str) -> None:
    for second in BINARY:
        check_two_operators(first, second)


def check_two_operators(first: str, second: str) -> None:
    written = f"x {first} y {second} z"
    left, right = f"(x {first} y) {second} z", f"x {first} (y {second} z)"
    if LEVEL[first] < LEVEL[second]:
        assert same(written, left)
    elif LEVEL[first] > LEVEL[second]:
        assert same(written, right)
    elif SIDE[first] == "none":
        with pytest.raises(ScriptError) as caught:
            parse_expression(written)
        assert [d.code for d in caught.value.diagnostics] == ["CSP106" if LEVEL[first] == LEVEL["=="] else "CSP105"]
    else:
        assert same(written, left if SIDE[first] == "left" else right)


@pytest.mark.parametrize("sign", ["-", "not", "#"])
@pytest.mark.parametrize("operator", BINARY)
def test_a_sign_before_an_operator(sign: str, operator: str) -> None:
    tighter = LEVEL[operator] < LEVEL["-" if sign == "-" else sign]
    assert same(f"{sign} x {operator} y", f"{sign} (x {operator} y)" if tighter else f"({sign} x) {operator} y")


@pytest.mark.parametrize("sign", ["-", "not", "#"])
@pytest.mark.parametrize("operator", [operator for operator in BINARY if operator in LEVEL and LEVEL[operator] < 9])
def test_a_sign_behind_an_operator(sign: str, operator: str) -> None:
    assert same(f"x {operator} {sign} y", f"x {operator} ({sign} y)")


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("#s^t", "#(s^t)"),
        ("-3/2", "-(3/2)"),
        ("c.x+1", "c.(x+1)"),
        ("a.b == c.d", "a.((b == c).d)"),
        ("f(x)^s", "(f(x))^s"),
        ("-f(x)", "-(f(x))"),
        ("P ; Q[[a <- b]]", "P ; (Q[[a <- b]])"),
        ("a -> P[[a <- b]]", "a -> (P[[a <- b]])"),
        ("f(x)(y)", "(f(x))(y)"),
        ("M::f(x)", "(M::f)(x)"),
        ("2 * -3 + 4", "(2 * (-3)) + 4"),
        ("2 ^ -3 * 4", "2 ^ (-(3 * 4))"),
        ("a == not b and c", "(a == (not b)) and c"),
        ("x == 1 & a -> b -> P", "(x == 1) & (a -> (b -> P))"),
        ("a -> P ; b -> Q", "(a -> P) ; (b -> Q)"),
        ("c!x+1?y -> P", "c!(x+1)?y -> P"),
        ("c?x:S.T!y -> P", "c?x:(S.T)!y -> P"),
        ("c.x.y!z -> P", "(c.(x.y))!z -> P"),
        ("x.y : T", None),
    ],
)
def test_rows_of_the_table(written: str, meant: str | None) -> None:
    if meant is not None:
        assert same(written, meant)
    else:
        generator = parse_expression(f"{{1 | {written}}}")
        assert isinstance(generator, s.SetExpr)
        assert generator.statements is not None
        statement = generator.statements[0]
        assert isinstance(statement, s.Generator)
        assert isinstance(statement.pattern, s.DotPattern)


@pytest.mark.parametrize("operator", [operator for operator in BINARY if LEVEL[operator] > LEVEL["->"]])
@pytest.mark.parametrize("hide", ["\\", "|\\"])
class TestHiding:
    def test_behind_a_row_it_hides_in_the_whole_row(self, operator: str, hide: str) -> None:
        assert same(f"P {operator} Q {hide} S", f"(P {operator} Q) {hide} S")

    def test_before_a_row_it_hides_in_what_stands_before_it(self, operator: str, hide: str) -> None:
        assert same(f"P {hide} S {operator} Q", f"(P {hide} S) {operator} Q")

    def test_in_a_row_it_hides_in_all_that_stands_before_it(self, operator: str, hide: str) -> None:
        assert same(f"P {operator} Q {hide} S {operator} R", f"((P {operator} Q) {hide} S) {operator} R")

    def test_twice(self, operator: str, hide: str) -> None:
        assert same(f"P {hide} S {operator} Q \\ T", f"((P {hide} S) {operator} Q) \\ T")


def test_hiding_hides_in_a_whole_prefix() -> None:
    assert same("a -> P \\ A", "(a -> P) \\ A")
    assert same("b & P \\ A", "(b & P) \\ A")


@pytest.mark.parametrize(
    "opening",
    [
        *("if b then P else", "let y = 1 within", "\\ x @", "[] x : S @", "|~| x : S @", "||| x : S @", "; x : s @"),
        *("[| A |] x : S @", "[+ A +] x : S @", "[a <-> b] x : s @"),
    ],
)
class TestToTheRight:
    def test_extends_over_every_operator_behind_it(self, opening: str) -> None:
        for operator in [*BINARY, "\\", "|\\"]:
            assert same(f"{opening} P {operator} Q", f"{opening} (P {operator} Q)")

    def test_can_be_the_last_operand_of_every_operator(self, opening: str) -> None:
        for operator in [*BINARY, "\\", "|\\"]:
            assert same(f"P {operator} {opening} Q", f"P {operator} ({opening} Q)")


class TestReplicatedAlphabets:
    """``|| x : S @ [A] P`` binds like ``[A || B]``."""

    @pytest.mark.parametrize("operator", [o for o in BINARY if LEVEL["->"] < LEVEL[o] < LEVEL["[| A |]"]])
    @pytest.mark.parametrize("before", ["", "a -> ", "b & ", "P [] ", "P [| X |] ", "P ||| ", "a -> || y : T @ [B] "])
    def test_takes_in_what_binds_more_tightly(self, before: str, operator: str) -> None:
        assert same(f"{before}|| x : S @ [A] P {operator} Q", f"{before}(|| x : S @ [A] (P {operator} Q))")

    @pytest.mark.parametrize("operator", ["|||", "\\", "|\\"])
    @pytest.mark.parametrize("before", ["", "a -> ", "b & ", "P [] ", "P [| X |] ", "a -> || y : T @ [B] "])
    def test_is_the_left_operand_of_what_binds_less_tightly(self, before: str, operator: str) -> None:
        assert same(f"{before}|| x : S @ [A] P {operator} Q", f"({before}(|| x : S @ [A] P)) {operator} Q")

    @pytest.mark.parametrize("operator", ["[| X |]", "[ X || Y ]", "[| X |>", "[ a <-> b ]"])
    def test_does_not_associate_with_its_like(self, operator: str) -> None:
        assert refusals(f"|| x : S @ [A] P {operator} Q") == {"CSP105"}
        assert refusals(f"(|| x : S @ [A] P) {operator} Q") == set()
        assert refusals(f"|| x : S @ [A] (P {operator} Q)") == set()
        assert refusals(f"P {operator} || x : S @ [A] Q") == set()

    def test_can_end_in_what_reaches_to_the_right(self) -> None:
        assert same("|| x : S @ [A] if b then P else Q \\ H", "|| x : S @ [A] (if b then P else (Q \\ H))")
        assert same("P [] || x : S @ [A] c & [] y : T @ Q ||| R", "P [] (|| x : S @ [A] (c & ([] y : T @ (Q ||| R))))")


@pytest.mark.parametrize("opening", ["if b then 1 else", "let y = 1 within", "\\ x @"])
@pytest.mark.parametrize("sign", ["-", "not", "#"])
def test_what_extends_to_the_right_can_stand_behind_a_sign(opening: str, sign: str) -> None:
    assert same(f"{sign} {opening} x + 1", f"{sign} ({opening} (x + 1))")


# --- random rows against an obvious reader -------------------------------------------------------------------


class Chained(Exception):
    """A comparison has a comparison as its operand, with no brackets between the two."""


def climb(row: list[str], loosest: int) -> str:
    """Read a row of value operators and signs by precedence climbing; the result has all its brackets."""
    first = row.pop(0)
    if first in ("-", "not", "#"):
        level = LEVEL[first] if first != "-" else LEVEL["+"]
        left = f"({first} {climb(row, level - 1)})"
    else:
        left = first
    compared = False
    while row and LEVEL[row[0]] <= loosest:
        operator = row.pop(0)
        if LEVEL[operator] == LEVEL["=="]:
            if compared:
                raise Chained
            compared = True
        left = f"({left} {operator} {climb(row, LEVEL[operator] - (SIDE[operator] != 'right'))})"
    return left


def refusals(text: str) -> set[str]:
    """The codes of the mistakes in an expression."""
    try:
        parse_expression(text)
    except ScriptError as error:
        return {diagnostic.code for diagnostic in error.diagnostics}
    return set()


operands = st.sampled_from(["x", "y", "z", "1", "f(x)"])
signs = st.lists(st.sampled_from(["-", "not", "#"]), max_size=2)
value_operators = st.sampled_from([operator for operator in BINARY if LEVEL[operator] < len(VALUES)])


@st.composite
def value_rows(draw: st.DrawFn) -> list[str]:
    row = [*draw(signs), draw(operands)]
    for _ in range(draw(st.integers(0, 6))):
        row += [draw(value_operators), *draw(signs), draw(operands)]
    return row


@given(value_rows())
def test_rows_of_values_are_read_as_by_precedence_climbing(row: list[str]) -> None:
    try:
        meant = climb(list(row), len(VALUES))
    except Chained:
        assert refusals(" ".join(row)) == {"CSP106"}
    else:
        assert same(" ".join(row), meant)


def tree(row: list[str]) -> object:
    """The grouping of a row of process operators, read as the table says and rearranged afterwards.

    Taken literally, `\\` is a left-associative operator that binds less tightly than all others, so that what
    stands behind it is part of the set. Then each (P \\ (A op Q)) becomes ((P \\ A) op Q), from the outside in.
    """
    for level in [100, *range(len(VALUES + PROCESSES) - 1, len(VALUES), -1)]:
        places = [i for i, token in enumerate(row) if (level == 100 and token == "\\") or LEVEL.get(token) == level]
        if places:
            # All these levels associate to the left: the last operator is the outermost.
            last = places[-1]
            return rearranged(row[last], tree(row[:last]), tree(row[last + 1 :]))
    (operand,) = row
    return operand


def rearranged(operator: str, left: object, right: object) -> object:
    if operator == "\\" and isinstance(right, tuple) and right[0] != "\\":
        return (right[0], rearranged("\\", left, right[1]), right[2])
    return (operator, left, right)


def written(grouping: object) -> str:
    if isinstance(grouping, tuple):
        operator, left, right = grouping
        return f"({written(left)} {operator} {written(right)})"
    return str(grouping)


process_operators = st.sampled_from(
    ["\\", "\\", *(operator for operator in BINARY if LEVEL[operator] > LEVEL["->"] and SIDE[operator] == "left")]
)


@given(st.lists(process_operators, max_size=7))
def test_rows_of_processes_are_read_as_the_table_says_and_rearranged(operators: list[str]) -> None:
    row = ["P"]
    for number, operator in enumerate(operators):
        row += [operator, f"Q{number}"]
    assert same(" ".join(row), written(tree(row)))


@given(st.lists(st.sampled_from(["[]", "|||", "[| A |]", "[ A || B ]", "|~|"]), min_size=2, max_size=6))
def test_parallel_operators_meet_only_where_brackets_or_interleaving_part_them(operators: list[str]) -> None:
    row = "P" + "".join(f" {operator} P" for operator in operators)
    # Between two parallel operators stands something looser, or the row is refused.
    parallel = [i for i, operator in enumerate(operators) if SIDE[operator] == "none"]
    chained = any("|||" not in operators[i:j] for i, j in pairwise(parallel))
    assert refusals(row) == ({"CSP105"} if chained else set())
