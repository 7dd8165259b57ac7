"""What is said about wrong scripts: word for word, with every place."""

from __future__ import annotations

import pytest

from cspcheck.cspm.diagnostics import MISTAKES, Diagnostic, ScriptError
from cspcheck.cspm.parsing.reading import parse, parse_assertion, parse_expression
from cspcheck.cspm.source import Source


def mistakes(text: str) -> tuple[Diagnostic, ...]:
    with pytest.raises(ScriptError) as caught:
        parse(Source("script.csp", text))
    return caught.value.diagnostics


def remarks(text: str) -> list[str]:
    """The codes of what is told about a text, mistakes or warnings."""
    try:
        return [d.code for d in parse(Source("script.csp", text)).remarks]
    except ScriptError as error:
        return [d.code for d in error.diagnostics]


def told(diagnostic: Diagnostic) -> list[str]:
    """A diagnostic line by line."""
    span = diagnostic.span
    assert span is not None
    lines = [f"{diagnostic.code} {span.line}:{span.column} `{span.text}`: {diagnostic.message}"]
    if diagnostic.annotation:
        lines.append(f"^ {diagnostic.annotation}")
    lines += [
        f"{label.span.line}:{label.span.column} `{label.span.text}`: {label.message}" for label in diagnostic.labels
    ]
    lines += [f"note: {note}" for note in diagnostic.notes]
    if diagnostic.help is not None:
        lines.append(f"help: {diagnostic.help}")
    return lines


REPORTS: dict[str, list[str]] = {
    "P = (a -> STOP\nQ = STOP": [
        "CSP102 1:5 `(`: this `(` is never closed",
        "2:1 `Q`: expected `)` before name `Q`",
        "help: close it with `)`",
    ],
    "x = f(1,\nQ = 1": [
        "CSP102 1:6 `(`: this `(` is never closed",
        "2:1 `Q`: expected `)` before name `Q`",
        "help: close it with `)`",
    ],
    "x = {1": [
        "CSP102 1:5 `{`: this `{` is never closed",
        "1:7 ``: expected `}` before the end of the text",
        "help: close it with `}`",
    ],
    "P = a)": ["CSP103 1:6 `)`: `)` closes no bracket", "help: remove it, or open the bracket before"],
    "s = {(1, 2}": [
        "CSP104 1:11 `}`: `}` does not close `(`",
        "^ expected `)`",
        "1:6 `(`: the innermost open bracket",
        "help: close it with `)` first",
    ],
    "P = Q [| A |] R [ B || C ] S": [
        "CSP105 1:17 `[ B || C ]`: `[ A || B ]` beside `[| A |]` needs brackets",
        "1:7 `[| A |]`: the operator before it",
        "help: write `(P [| A |] Q) [ A || B ] R` or `P [| A |] (Q [ A || B ] R)`",
    ],
    "x = a < b <= c": [
        "CSP106 1:11 `<=`: `<=` cannot follow a comparison",
        "1:7 `<`: the comparison before it",
        "help: join two comparisons with `and`: `a < b and b <= c`",
    ],
    "f(x) = if x = 0 then 1 else 2": [
        "CSP107 1:13 `=`: `=` does not compare",
        "help: write `==` to compare; `=` only defines",
    ],
    "P == STOP": ["CSP108 1:3 `==`: `==` does not define", "help: write `=` to define; `==` only compares"],
    "s = <x | x <- t, x>2>": [
        "CSP109 1:20 `2`: unexpected number `2` behind the end of a sequence",
        "1:19 `>`: this `>` closes the sequence",
        "1:5 `<`: which is opened here",
        "help: put a comparison with `>` inside a sequence in brackets: `(x > y)`",
    ],
    "P = a ->\nQ = STOP": [
        "CSP110 1:7 `->`: no process behind `->`",
        "2:1 `Q`: here",
        "help: every prefix needs a process: `a -> STOP`",
    ],
    "channel = 1": ["CSP111 1:1 `channel`: `channel` is a reserved word", "help: choose another name"],
    "x = 3\n  - 1": [
        "CSP112 2:3 `-`: `-` at the beginning of a line begins a new declaration",
        "1:5 `3`: the declaration ends here",
        "help: leave the operator at the end of the line above, or put the expression in brackets",
    ],
    "P = a -> Q\n    b -> Q": [
        "CSP113 2:5 `b`: this line is neither a declaration nor the rest of one",
        "1:10 `Q`: the declaration above ends here",
        "help: join it to the line above with an operator, such as `[]`, or define something with `=`",
    ],
    "P = [] STOP": [
        "CSP114 1:5 `[]`: `[]` has no operand before it",
        "help: write `P [] Q`, or `[] x : S @ P(x)` for the replicated operator",
    ],
    "f(x) = let y = x\nz = 2": [
        "CSP123 1:8 `let`: this `let` has no `within`",
        "2:1 `z`: expected `within` before name `z`",
        "help: write `let declarations within expression`",
    ],
    "f(x) = if x then 1\ny = 2": [
        "CSP124 1:19 ``: expected `else` before the end of the line",
        "1:13 `then`: this `then` has no `else`",
        "help: `if` needs both branches: `if b then P else Q`; a guard is `b & P`",
    ],
    "P = [] x : S a.x -> STOP": [
        "CSP125 1:14 `a`: expected `@` before name `a`",
        "1:5 `[]`: the replicated `[]` begins here",
        "help: write `[] x : S @ P(x)`",
    ],
    "P = [| A |] x : S a.x -> STOP": [
        "CSP125 1:19 `a`: expected `@` before name `a`",
        "1:10 `|]`: the replicated `[|` begins here",
        "help: write `[] x : S @ P(x)`",
    ],
    "f = \\ x x + 1": [
        "CSP125 1:9 `x`: expected `@` before name `x`",
        "1:5 `\\`: the lambda begins here",
        "help: write `\\ x @ expression`",
    ],
    "P =": ["CSP126 1:3 `=`: the text ends behind `=` where an expression was expected"],
    "channel c :\nP = STOP": [
        "CSP127 2:1 `P`: the declaration before name `P` is not complete",
        "^ expected an expression",
        "1:11 `:`: nothing follows this",
    ],
    "1 + 1\nx = 2": [
        "CSP128 1:1 `1 + 1`: expected `=` before the end of the line",
        "help: a declaration is `name = expression`; to show a value write `print expression`, to claim something "
        "`assert`",
    ],
    "m = (|0 => 1|)": [
        "CSP129 1:5 `(|`: a map is opened by `(|` and a blank",
        "help: write `(| key => value |)`",
    ],
    "x = 1 2": ["CSP101 1:7 `2`: unexpected number `2`", "^ expected an operator or a new line"],
    "P = STOP || STOP": [
        "CSP101 1:10 `||`: unexpected `||`",
        "^ expected an operator or a new line",
        "help: write `P [| A |] Q` or `P [ A || B ] Q`, or `P ||| Q` if they share no events",
    ],
    "x = f(1,)": ["CSP101 1:9 `)`: unexpected `)`", "^ expected an expression"],
    "P = a?x:S!y": ["CSP126 1:11 `y`: the text ends behind `y` where `->` or an operator was expected"],
    "P = c!if b then 1 else 2 -> STOP": [
        "CSP101 1:7 `if`: unexpected `if`",
        "^ expected an expression",
        "help: put it in brackets",
    ],
    "include foo": ["CSP101 1:9 `foo`: unexpected name `foo`", "^ expected a file name in quotes"],
    "x :: {0}\nx = 1": ["CSP101 1:7 `0`: unexpected number `0`", "^ expected a type", "1:6 `{`: inside this bracket"],
    "s = {-1..1}": [
        "CSP005 1:5 `{-`: this comment is never closed",
        "help: `{-` opens a comment; for a set that begins with a minus write `{ -`",
    ],
    "s = {-1..1}\nt = 2 {- why -}\nu = 3": [
        "CSP005 1:5 `{-`: this comment is never closed",
        "help: `{-` opens a comment; for a set that begins with a minus write `{ -`",
    ],
    "s = {-1..1} -}\nt = 2": [
        "CSP127 2:1 `t`: the declaration before name `t` is not complete",
        "^ expected an expression",
        "1:3 `=`: nothing follows this",
        "note: the text between `{-` and `-}` is a comment; for a set that begins with a minus write `{ -`",
    ],
    "P = a \u2192 STOP": ["CSP004 1:7 `\u2192`: unknown character `\u2192`", "help: write `->`"],
    "assert P :[deadlok free]": [
        "CSP120 1:12 `deadlok free`: unknown property `deadlok free`",
        "help: did you mean `deadlock free`?",
    ],
    "f(x + 1) = x": [
        "CSP140 1:3 `x + 1`: an expression with `+` is not a pattern",
        "help: a pattern is a name, `_`, a literal, or a tuple, sequence, set or dotted value of patterns",
    ],
    "x = let channel c within 1": [
        "CSP160 1:9 `channel`: `channel` cannot stand in a `let`",
        "help: move it to the top of the script",
    ],
    "f :: Int\nf :: Bool\nf = 1": ["CSP163 2:1 `f`: `f` is annotated twice", "1:1 `f`: first annotated here"],
}


@pytest.mark.parametrize("text", REPORTS)
def test_reports(text: str) -> None:
    (diagnostic,) = mistakes(text)
    assert told(diagnostic) == REPORTS[text]


class TestSeveralMistakes:
    def test_are_all_reported_in_their_order(self) -> None:
        text = "P = (1\nQ = STOP\nf(x+1) = 2\nR = 3 = 4\nS = )\n"
        assert [(d.code, d.span.line) for d in mistakes(text) if d.span] == [
            ("CSP102", 1),
            ("CSP140", 3),
            ("CSP107", 4),
            ("CSP103", 5),
        ]

    def test_a_mistake_makes_no_others(self) -> None:
        text = "P = (a ->\n  b\n  [] c\nchannel x\nQ(x) = if x then 1 else 2\nassert P [T= Q\n"
        assert len(mistakes(text)) == 1

    def test_continuation_lines_are_not_taken_for_declarations(self) -> None:
        assert len(mistakes("P = f(1, 2\nx,\ny)\nQ = STOP")) == 1

    def test_an_annotation_before_the_mistake_is_not_missed_behind_it(self) -> None:
        assert [d.code for d in mistakes("f :: Int\ng = (1\nf = 1\nh :: Int\ny = 2")] == ["CSP102"]

    def test_at_most_twenty_are_reported(self) -> None:
        assert len(mistakes("x = )\n" * 100)) == 20

    def test_inside_a_module_only_the_first_is_reported(self) -> None:
        assert len(mistakes("module M\nx = )\nexports\ny = )\nendmodule\nz = )")) == 1

    def test_mistakes_in_characters_come_alone(self) -> None:
        assert [d.code for d in mistakes("x = \u20ac\ny = )\nz = \u20ac")] == ["CSP004", "CSP004"]


class TestLoneTexts:
    def test_an_expression(self) -> None:
        with pytest.raises(ScriptError, match="CSP126: the text ends behind `\\+` where an expression was expected"):
            parse_expression("1 +")

    def test_two_expressions(self) -> None:
        with pytest.raises(ScriptError, match="CSP101: unexpected name `y`"):
            parse_expression("x y")

    def test_a_definition_is_no_expression(self) -> None:
        with pytest.raises(ScriptError, match="CSP107"):
            parse_expression("x = 1")

    def test_nothing(self) -> None:
        with pytest.raises(ScriptError, match="CSP126: the text ends where an expression was expected"):
            parse_expression("")

    def test_a_pattern_is_no_expression(self) -> None:
        with pytest.raises(ScriptError, match="CSP141"):
            parse_expression("_")

    def test_an_assertion(self) -> None:
        with pytest.raises(ScriptError, match="CSP126"):
            parse_assertion("P [T=")


# Mistakes whose example is no script, needs files, or is told when the script is loaded.
WITHOUT_SCRIPT = {"CSP001", "CSP002", "CSP003", "CSP010", "CSP011", "CSP012", "CSP013", "CSP016", "CSP131", "CSP161"}
OF_FORM = sorted(code for code in MISTAKES if code < "CSP200")


@pytest.mark.parametrize("code", [code for code in OF_FORM if code not in WITHOUT_SCRIPT])
def test_the_documented_example_makes_the_mistake_and_the_repair_does_not(code: str) -> None:
    assert remarks(MISTAKES[code].example) == [code]
    assert remarks(MISTAKES[code].repair) == []


@pytest.mark.parametrize("code", OF_FORM)
def test_the_documentation_of_a_mistake_is_complete(code: str) -> None:
    mistake = MISTAKES[code]
    assert mistake.title
    assert not mistake.title.endswith(".")
    assert mistake.explanation.endswith(".")
    assert mistake.repair
