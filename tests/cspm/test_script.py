"""Loading a script, and asking it for processes, values and assertions."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import STOP, Prefix, Reference
from cspcheck.cspm.script import Script, load
from cspcheck.cspm.source import Source

TEXT = """
channel a, b
channel c : {0..2}
datatype T = A | B.{0..1}
N = 3
P(n) = a -> P((n + 1) % N)
print N + 1
print <c.0>
print P(0)
assert P(0) :[deadlock free]
"""


def script(text: str, **overrides: str) -> Script:
    return load(Source("test.csp", text), overrides=overrides)


# --- events, processes, values -------------------------------------------------------------------------------


def test_events_are_numbered_in_the_order_of_declaration() -> None:
    loaded = script(TEXT)
    assert [loaded.events.name(n) for n in range(2, 7)] == ["a", "b", "c.0", "c.1", "c.2"]
    assert loaded.event_set("{| c, b |}") == EventSet([(3, 7)])
    assert loaded.trace("<a, c.1, a>") == (2, 5, 2)


def test_channels_of_instances_come_behind_those_of_the_script() -> None:
    loaded = script("module M\nexports\nchannel x\nendmodule\ninstance I = M\ninstance J = M\nchannel z")
    assert [loaded.events.name(n) for n in range(2, 6)] == ["M::x", "z", "I::x", "J::x"]


def test_a_named_process_is_a_reference_that_says_its_name() -> None:
    term = script(TEXT).process("P(1 + 1)")
    assert isinstance(term, Reference)
    assert term.text == "P(2)"
    assert term.span is not None
    assert term.span.line == 6
    body = term.body()
    assert isinstance(body, Prefix)
    assert body.branches[0][1] is script_process_of(term)


def script_process_of(term: Reference) -> object:
    """What follows the first event of a process."""
    body = term.body()
    assert isinstance(body, Prefix)
    return body.branches[0][1]


def test_two_scripts_share_no_definitions() -> None:
    one, two = script(TEXT), script(TEXT)
    assert one.process("P(0)") is one.process("P(0)")
    assert one.process("P(0)") is not two.process("P(0)")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("N + 1", 4),
        ("N == 3", True),
        ("'x'", "x"),
        ('"abc"', "abc"),
        ('""', ()),
        ("<1, 2>", (1, 2)),
        ("<<>, <1>>", ((), (1,))),
        ("(1, true)", (1, True)),
        ("{1, 2}", frozenset({1, 2})),
        ("{<1>, <>}", frozenset({(1,), ()})),
        ("{{1}, {}}", frozenset({frozenset({1}), frozenset()})),
        ("(| 1 => <2>, 3 => <> |)", {1: (2,), 3: ()}),
        ("{(| 1 => 2 |)}", frozenset({frozenset({(1, 2)})})),
        ("{| c |}", frozenset({"c.0", "c.1", "c.2"})),
        ("B.1", "B.1"),
        ("T", frozenset({"A", "B.0", "B.1"})),
        ("c", "c"),
        ("P(1)", "P(1)"),
        ("a -> STOP", "a -> STOP"),
        ("card", "<function card>"),
    ],
)
def test_values_in_python(text: str, expected: object) -> None:
    found = script(TEXT).evaluate(text)
    assert found == expected
    assert type(found) is type(expected)


def test_booleans_and_integers_stay_apart_in_python() -> None:
    assert script(TEXT).evaluate("<1, 0>") == (1, 0)
    assert all(type(x) is int for x in script(TEXT).evaluate("<1, 0>"))
    assert script(TEXT).boolean("N > 2") is True


@pytest.mark.parametrize("text", ["Int", "<0..>", "Seq({1})", "{0..}"])
def test_infinite_values_have_none_in_python(text: str) -> None:
    with pytest.raises(ScriptError):
        script(TEXT).evaluate(text)


def test_prints_say_what_they_should() -> None:
    assert script(TEXT).printed == ("4", "<c.0>", "P(0)")


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("x +", "CSP1"),
        ("undefined", "CSP201"),
        ("1 + true", "CSP3"),
        ("1 / 0", "CSP401"),
    ],
)
def test_mistakes_in_what_is_asked_later(text: str, code: str) -> None:
    loaded = script(TEXT)
    with pytest.raises(ScriptError) as raised:
        loaded.evaluate(text)
    assert raised.value.diagnostics[0].code.startswith(code)
    assert loaded.evaluate("N") == 3


def test_assertions_written_later() -> None:
    loaded = script(TEXT)
    assertion = loaded.assertion("P(0) [T= STOP")
    assert assertion.text == "P(0) [T= STOP"
    assert assertion.expected is None
    with pytest.raises(ScriptError):
        loaded.assertion("N [T= STOP")
    with pytest.raises(ScriptError):
        loaded.assertion("Q [T= STOP")


# --- assertions and what is expected of them -------------------------------------------------------------------


def test_assertions_have_text_place_and_expectation() -> None:
    text = """channel a
P = a -> P
assert P :[deadlock free]
assert P [T= P -- expect: fail
-- expect: unknown
assert P :[ divergence-free ]
assert not P [F= P   -- it is so: expect: pass
-- expect: fail

assert P :[deterministic]
assert P [FD=
   P -- expect: fail
assert STOP [T= P
{- expect: fail -}
assert SKIP [T= P
"""
    found = script(text).assertions
    assert [(a.span.line, a.expected) for a in found] == [
        (3, None),
        (4, "fail"),
        (6, "unknown"),
        (7, "pass"),
        (10, None),
        (11, "fail"),
        (13, None),
        (15, "fail"),
    ]
    assert found[2].text == "P :[divergence free]"
    assert found[3].text == "not P [F= P"


@pytest.mark.parametrize("suffix", ["csp", "tex"])
def test_what_an_included_file_expects_counts_where_it_is_included(tmp_path: Path, suffix: str) -> None:
    asserted = "-- expect: fail\nassert STOP :[deadlock free]\nassert STOP [T= STOP\n"
    if suffix == "tex":
        asserted = f"\\begin{{cspm}}\n{asserted}\\end{{cspm}}\n"
    (tmp_path / f"inner.{suffix}").write_text(asserted)
    (tmp_path / "middle.csp").write_text(f'include "inner.{suffix}"\nassert SKIP [T= STOP\n')
    (tmp_path / "outer.csp").write_text('include "middle.csp"\n\nassert STOP [T= SKIP -- expect: fail\n')

    found = load(tmp_path / "outer.csp").assertions
    assert [(a.text, a.expected) for a in found] == [
        ("STOP :[deadlock free]", "fail"),
        ("STOP [T= STOP", None),
        ("SKIP [T= STOP", None),
        ("STOP [T= SKIP", "fail"),
    ]


def test_an_assertion_in_a_timed_section_is_timed() -> None:
    loaded = script("channel a, tock\nTimed {\nassert STOP :[deadlock free]\n}\nassert STOP :[deadlock free]")
    timed, untimed = (loaded.process(a.node.process) for a in loaded.assertions)  # type: ignore[attr-defined]
    assert isinstance(timed, Reference)
    assert untimed is STOP


# --- overrides -------------------------------------------------------------------------------------------------


def test_an_override_replaces_a_constant() -> None:
    loaded = script(TEXT, N="2 + 3")
    assert loaded.evaluate("N") == 5
    assert loaded.printed[0] == "6"


def test_an_override_may_use_the_script() -> None:
    assert script("N = 1\nM = 5", N="M * 2").evaluate("N") == 10


def test_an_override_works_in_included_files_and_timed_sections(tmp_path: Path) -> None:
    (tmp_path / "part.csp").write_text("N = 1\n")
    (tmp_path / "main.csp").write_text('channel tock\ninclude "part.csp"\nTimed {\nM = 2\n}\n')
    loaded = load(tmp_path / "main.csp", overrides={"N": "7", "M": "8"})
    assert loaded.evaluate("(N, M)") == (7, 8)


@pytest.mark.parametrize(
    ("name", "expression", "code", "said"),
    [
        ("M", "1", "CSP220", "`M` cannot be overridden: the script does not define it"),
        ("P", "STOP", "CSP220", "`P` cannot be overridden: it is not a constant"),
        ("a", "1", "CSP220", "`a` cannot be overridden: it is not a constant"),
        ("N", "1 +", "CSP126", None),
        ("N", "true", "CSP301", None),
        ("N", "undefined", "CSP201", None),
    ],
)
def test_an_override_that_does_not_fit(name: str, expression: str, code: str, said: str | None) -> None:
    with pytest.raises(ScriptError) as raised:
        script(TEXT, **{name: expression})
    assert raised.value.diagnostics[0].code == code
    if said is not None:
        assert raised.value.diagnostics[0].message == said


# --- nothing depends on chance -----------------------------------------------------------------------------------

DETERMINISM = """
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from cspcheck.cspm.process.text import describe
loaded = load(Source("d.csp", '''
channel c : {"b", "a", "ab"}.{<>, <'x'>}.Set({0, 1})
datatype T = K.{"z", "y"} | L
channel d : Set(T)
print {| c |}
print {(s, t) | s <- {"q", "p"}, t <- T}
print Set(T)
P = [] x : {"b", "a"} @ c.x?y?z -> (|~| t : T @ d!{t} -> P)
Q = [] R : {P, STOP, c?x?y?z -> P} @ R
'''))
print(loaded.printed)
print(describe(loaded.process("P").body(), loaded.events, width=10000))
print(describe(loaded.process("Q").body(), loaded.events, width=10000))
"""


def test_the_same_script_gives_the_same_result_whatever_the_hashes() -> None:
    outputs = {
        subprocess.run(
            [sys.executable, "-c", DETERMINISM],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            check=True,
            text=True,
            cwd=Path(__file__).parents[2],
        ).stdout
        for seed in ("1", "2", "33")
    }
    assert len(outputs) == 1


def test_the_recursion_limit_is_as_before() -> None:
    before = sys.getrecursionlimit()
    loaded = script("f(n) = if n == 0 then 0 else 1 + f(n - 1)\nprint f(50000)")
    with pytest.raises(ScriptError):
        loaded.evaluate("f(-1)")
    assert sys.getrecursionlimit() == before
    assert loaded.evaluate("f(20000)") == 20000


@pytest.mark.parametrize(
    "text",
    [
        "channel a\nP = " + "a -> " * 20_000 + "P",
        "channel a\nP = " + " [] ".join(["a -> STOP"] * 3_000),
        "channel a\nP = " + " ||| ".join(["a -> STOP"] * 3_000),
        "x = " + " + ".join(["1"] * 5_000) + "\nprint x",
        "channel a\nP = " + "a -> (" * 2_000 + "STOP" + ")" * 2_000,
    ],
    ids=["prefixes", "choices", "interleavings", "sums", "brackets"],
)
def test_long_expressions_are_no_deep_recursion(text: str) -> None:
    loaded = script(text)
    if "P =" in text:
        term = loaded.process("P")
        assert isinstance(term, Reference)
        term.body()
