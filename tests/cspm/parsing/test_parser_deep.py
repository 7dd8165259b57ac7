"""Size: very deep and very long scripts, and how long a script takes."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.parsing.reading import parse, parse_expression, read_source
from cspcheck.cspm.printing.formatter import format_source
from cspcheck.cspm.printing.printer import print_expression, print_script
from cspcheck.cspm.source import Source

N = 2_000
HUGE = 100_000
DEEP = {
    "brackets": "(" * N + "x" + ")" * N,
    "prefixes": "a -> " * N + "STOP",
    "concatenations": "x" + "^x" * N,
    "sequences": "<" * N + ">" * N,
    "sets": "{" * N + "}" * N,
    "calls": "f(" * N + "x" + ")" * N,
    "curried calls": "f" + "(x)" * N,
    "sums": "x" + " + x" * N,
    "dots": "x" + ".x" * N,
    "signs": "not " * N + "x",
    "conditionals": "if x then y else " * N + "z",
    "conditions": "if " * N + "x" + " then y else z" * N,
    "choices": "P" + " [] P" * N,
    "hidings": "P" + " \\ A" * N,
    "nested parallels": "P [| A |] (" * N + "P" + ")" * N,
    "lambdas": "\\ x @ " * N + "x",
    "lets": "let x = 1 within " * N + "x",
    "replications": "[] x : S @ " * N + "x",
    "renamings": "P" + "[[a <- b]]" * N,
}


@pytest.mark.parametrize("text", DEEP.values(), ids=DEEP)
def test_deep_expressions_parse_and_print(text: str) -> None:
    printed = print_expression(parse_expression(text))
    # Comparing trees of this depth would exceed Python's stack; their texts say the same.
    assert print_expression(parse_expression(printed)) == printed
    assert "".join(printed.split()) == "".join(text.split())


def test_a_hundred_thousand_levels_parse_and_print() -> None:
    text = "(" * HUGE + "x" + ")" * HUGE

    assert "".join(print_expression(parse_expression(text)).split()) == text


@pytest.mark.parametrize(
    ("pattern", "code"),
    [
        ("(" * N + "x" + ")" * N, None),
        ("<" * N + ">" * N, None),
        ("x" + ".x" * N, None),
        ("<x>" + "^<x>" * N, None),
        ("x" + "^x" * N, "CSP144"),
        ("x" + " + x" * N, "CSP140"),
    ],
    ids=["brackets", "sequences", "dots", "concatenations", "open ends", "sums"],
)
def test_deep_patterns(pattern: str, code: str | None) -> None:
    source = Source("", f"f({pattern}) = 1")
    if code is None:
        assert "".join(print_script(parse(source)).split()) == "".join(source.text.split())
        return
    with pytest.raises(ScriptError) as caught:
        parse(source)
    assert [d.code for d in caught.value.diagnostics] == [code]


@pytest.mark.parametrize(
    "text", ["(" * N, "{<(" * N, "let x = " * N, "if " * N, "[] x : " * N, "f(x)" * N + ")", "a ->" * N]
)
def test_deep_mistakes(text: str) -> None:
    with pytest.raises(ScriptError):
        parse(Source("", f"P = {text}"))


def test_deep_types() -> None:
    text = "x :: " + "<" * N + "a" + ">" * N + "\nx = <>"
    assert "".join(print_script(parse(Source("", text))).split()) == "".join(text.split())


def test_deep_comments() -> None:
    assert parse(Source("", "{-" * N + "-}" * N)).declarations == ()


def test_deep_scripts_can_be_formatted() -> None:
    source = Source("", "P = " + "(" * N + "x" + ")" * N)
    assert "".join(format_source(source).split()) == "".join(source.text.split())


def test_a_script_of_75_kilobytes_parses_in_two_seconds() -> None:
    corpus = sorted((Path(__file__).parents[2] / "corpus" / "parse" / "pass").glob("*.csp"))
    texts = [read_source(path).text for path in corpus]
    text = "\n".join(text for text in texts if "include" not in text and " :: " not in text)
    text = "\n\n".join([text] * (75_000 // len(text) + 1))
    source = Source("", text)
    assert len(text) > 75_000
    parse(Source("", "x = 1"))

    started = time.process_time()
    parse(source)
    assert time.process_time() - started < 2


HOSTILE = {
    "unfinished heads": "f(\n" * 10_000,
    "brackets closed by others": "(" * 10_000 + "]" * 10_000,
    "wildcards": "x = _" + " + _" * 10_000,
    "wrong patterns": "f(x + 1, _) = _\n" * 5_000,
    "wrong declarations": "x = )\n" * 5_000,
    "unknown characters": "\u20ac" * 10_000,
    "unclosed strings": '"x\n' * 10_000,
    "quotes": "'" * 10_000,
    "properties without end": ":[a " * 10_000,
    "colons and blanks": (":" + " " * 200) * 1_000,
    "annotations": "".join(f"f{n} :: Int\n" for n in range(5_000)),
    "sequences of comparisons": "x = <" + "a > " * 10_000,
    "commas": "x" + ", x" * 10_000,
    "assertions with not": "assert not " * 10_000,
    "a long line of comments": "x = 1 " + "{- c -} " * 10_000,
    "digits": "x = " + "9" * 200_000,
}


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
def test_hostile_texts_end_in_five_seconds(text: str) -> None:
    started = time.process_time()
    diagnostics = refusal(text)
    assert time.process_time() - started < 5
    assert len(diagnostics) <= 20


def refusal(text: str) -> tuple[Diagnostic, ...]:
    """What is wrong with a script, nothing if it can be formatted."""
    try:
        format_source(Source("", text))
    except ScriptError as error:
        return error.diagnostics
    return ()
