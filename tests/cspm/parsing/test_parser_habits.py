"""Habits of other languages: each gets one message, and it names the repair."""

from __future__ import annotations

import pytest

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.parsing.reading import decode, parse
from cspcheck.cspm.source import Source

REFINEMENT = "write `SPEC [T= IMPL`, `SPEC [F= IMPL` or `SPEC [FD= IMPL`"
COMMENT = "a comment begins with `--`, or stands between `{-` and `-}`"
DASH = "write `->` (a word processor has made a dash of the `-`)"
SEMICOLON = "leave it out: the end of the line is enough"
CONSTRUCTORS = "write the constructors with `|` between them: `datatype T = A | B`"
CHANNELS = "write a `channel` line for each type: `channel a : {0..1}` and `channel b`"


@pytest.mark.parametrize(
    ("text", "code", "written", "help"),
    [
        ("P = a —> P", "CSP004", "—", DASH),
        ("P = a – > P", "CSP004", "–", DASH),
        ("// a comment\nP = STOP // more\n// and more", "CSP117", "//", COMMENT),
        ("P = STOP // more", "CSP117", "//", COMMENT),
        ("/* a comment */\nP = STOP", "CSP117", "/*", COMMENT),
        ("# a comment\nP = STOP", "CSP117", "#", COMMENT),
        ("f(x) = x != 3 && x != 4", "CSP116", "&&", "write `and`"),
        ("P(x) = x != 3 && x != 4 & a -> P(x)", "CSP116", "&&", "write `and`"),
        ("f(x) = if x == 1 || x == 2 then 1 else 0", "CSP116", "||", "write `or`"),
        ("f(x) = (x == 1 || x == 2)", "CSP116", "||", "write `or`"),
        ("f(x) = !(x == 1)", "CSP116", "!", "write `not`"),
        ("P := a -> P", "CSP116", ":=", "write `=` to define, `==` to compare"),
        ("P = a => P", "CSP116", "=>", "write `->`: `a -> P` is a prefix"),
        ("f(x) = x > 1 => x < 3", "CSP116", "=>", "write `not p or q` for `p => q`"),
        ("channel a;\nP = a -> P;\nQ = a -> Q;\nassert P :[deadlock free];", "CSP119", ";", SEMICOLON),
        ("P = a -> P;", "CSP119", ";", SEMICOLON),
        ("P = a -> P;\nQ(x) = a -> Q(x)", "CSP119", ";", SEMICOLON),
        ("P = a -> P;\nchannel a", "CSP119", ";", SEMICOLON),
        ("assert P [deadlock free]", "CSP118", "[deadlock free]", "write `:[deadlock free]`"),
        ("assert P :[deadlock free] [FD]", "CSP118", ":[deadlock free] [FD]", "write `:[deadlock free [FD]]`"),
        ("assert P [livelock-free [F]]", "CSP118", "[livelock-free [F]]", "write `:[livelock free [F]]`"),
        ("assert P deadlock free", "CSP118", "deadlock free", "write `P :[deadlock free]`"),
        ("assert P is deterministic", "CSP118", "deterministic", "write `P :[deterministic]`"),
        ("assert P [= Q", "CSP118", "[=", REFINEMENT),
        ("assert P |= Q", "CSP118", "|=", REFINEMENT),
        ("assert P refines Q", "CSP118", "refines", REFINEMENT),
        ("assert P [T=] Q", "CSP118", "[T=]", REFINEMENT),
        ("nametype Id = 0..3", "CSP116", "0..3", "write `{0..3}`: a set stands in curly brackets"),
        ("channel a : 0..N", "CSP116", "0..N", "write `{0..N}`: a set stands in curly brackets"),
        ("datatype C = red, green", "CSP116", ",", CONSTRUCTORS),
        ("datatype C = {red, green}", "CSP116", "{", CONSTRUCTORS),
        ("channel a : {0..1}, b", "CSP116", ",", CHANNELS),
        ("P = let x = 3 in a -> P", "CSP116", "in", "write `within`: `let x = 3 within P`"),
        ("b = 1 in {1, 2}", "CSP116", "in", "write `member(x, S)`"),
        ("x = 7 mod 3", "CSP116", "mod", "write `%`"),
        ("P = Q [ {a} ] R", "CSP116", "]", "write `P [| A |] Q`, or `P [ A || B ] Q` with an alphabet for each side"),
        ("P = Q |[ {a} ]| R", "CSP116", "|[", "write `P [| A |] Q`"),
        ("s = <1> ++ <2>", "CSP116", "++", "write `s ^ t` to join sequences"),
        ("b = 1 <> 2", "CSP116", "<>", "write `!=`"),
        ("P = a then P", "CSP116", "then", "write `a -> P` for a prefix, `P ; Q` for one process after the other"),
        ("process P = STOP", "CSP116", "process", "write the process alone: `P = ...`"),
        ("f = lambda x: x", "CSP116", "lambda", "write `\\ x @ expression`"),
        ("```csp\nP = STOP\n```\n", "CSP014", "```", None),
        ("channel c 0;\nvar x = 0;\nP() = c!x -> P();\n#assert P() deadlockfree;", "CSP015", None, None),
        ('#define N 3;\nP(i) = "x;', "CSP015", "#define N 3;", None),
    ],
)
def test_one_message_that_names_the_repair(text: str, code: str, written: str | None, help: str | None) -> None:
    with pytest.raises(ScriptError) as caught:
        parse(Source("x.csp", text))
    (found,) = caught.value.diagnostics
    assert found.code == code
    assert found.span is not None
    assert written is None or found.span.text == written
    assert help is None or found.help == help


@pytest.mark.parametrize(
    "text",
    [
        "P = a -> SKIP;\n    Q",
        "P = (b & c & STOP)",
        "S = {x | x <- {0..3}}\nT = #s",
        "process = STOP\ncase = process\nin = 1\nmod = in % 2\nrefines = case",
        "P = Q [ A || B ] R",
        "P = x == 1 or x == 2 & STOP",
        "m = (| 1 => 2 |)",
    ],
)
def test_what_looks_alike_and_is_right_is_read(text: str) -> None:
    parse(Source("x.csp", text))


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be"])
def test_utf_16_is_called_by_its_name(encoding: str) -> None:
    with pytest.raises(ScriptError) as caught:
        decode("x.csp", "channel a\nP = a -> P\n".encode(encoding))
    (found,) = caught.value.diagnostics
    assert (found.code, found.message) == ("CSP003", "`x.csp` is text in UTF-16, not UTF-8")


def test_an_empty_and_a_tiny_text_are_not_utf_16() -> None:
    assert decode("x.csp", b"").text == ""
    assert decode("x.csp", b"a").text == "a"
