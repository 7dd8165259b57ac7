"""Whatever is evaluated ends in a value or in a diagnostic with its place, even where types would have forbidden it."""

from __future__ import annotations

import os

from hypothesis import given, settings, strategies as st

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.prelude import BUILTINS, EXTERNAL, TRANSPARENT
from cspcheck.cspm.process.terms import Process, Reference
from cspcheck.cspm.script import Script, load
from cspcheck.cspm.source import Source

EXAMPLES = max(1, int(os.environ.get("CSPCHECK_FUZZ", "20000")) // 50)

DECLARATIONS = f"""
transparent {", ".join(sorted(TRANSPARENT))}
external {", ".join(sorted(EXTERNAL - TRANSPARENT))}
channel a, b, tock
channel c : {{0..2}}
channel d : Bool.T
channel i : Int
datatype T = A | B.{{0..1}} | C.T.T
subtype S = A | B.{{0}}
nametype N = {{0..1}}.Bool
f(x) = x
f2(0, y) = y
f2(<x>^xs, y) = (x, xs)
f2(B.n, {{y}}) = n
f2((x, y), c.n) = n
g(x)(y) = <x, y>
P = a -> P
Q(x) = c!x -> Q(x)
k = 3
(u, v) = (1, <k>)
Timed {{
  W(x) = x -> WAIT(k)
}}
"""


def fresh() -> Script:
    return load(Source("fuzz.csp", DECLARATIONS), typecheck=False)


LEAVES = [
    *("0", "1", "-2", "k", "u", "v", "x", "y", "true", "false", "'a'", '"ab"', "<>", "{}", "(| |)", "<1, 2>", "{0..2}"),
    *("{1..}", "<0..3>", "<2..>", "A", "B", "B.1", "C", "C.A.A", "T", "S", "N", "a", "b", "c", "c.1", "d", "d.true"),
    *(
        "d.false.A",
        "i",
        "i.7",
        "{| c |}",
        "{| d.true |}",
        "{a, c.0}",
        "P",
        "Q(1)",
        "Q",
        "f",
        "g",
        "g(1)",
        "W(a)",
        "STOP",
    ),
    *("SKIP", "(1, true)", "{(1, 2)}", "{(a, b)}", "<{a}, {c.1}>", r"(\ x @ x)", r"(\ <x> @ x)"),
    *sorted(BUILTINS - {"STOP", "SKIP"}),
    *("normal", "prioritise", "prioritisepo", "mtransclose", "relational_image", "loop"),
]
PATTERNS = [
    "x",
    "y",
    "_",
    "0",
    "true",
    "(x, y)",
    "<x>",
    "<x>^y",
    "x^<y>",
    "{}",
    "{x}",
    "A",
    "B.x",
    "c.x",
    "x.y",
    "x@@y",
    "'a'",
]
BINARY = [
    "+",
    "-",
    "*",
    "/",
    "%",
    "==",
    "!=",
    "<",
    "<=",
    ">",
    ">=",
    "and",
    "or",
    "^",
    ".",
    "[]",
    "|~|",
    ";",
    "|||",
    "[>",
    "/\\",
]
FIELDS = ["?x", "!{e}", "?x:{e}", "?_", "?(B.x)", "?x.y"]


def compound(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    e = inner.map(lambda text: f"({text})")
    pattern = st.sampled_from(PATTERNS)
    statements = st.lists(st.one_of(st.builds(lambda p, s: f"{p} <- {s}", pattern, e), e), min_size=1, max_size=2).map(
        ", ".join
    )

    def applied(function: str, arguments: list[str]) -> str:
        return f"{function}({', '.join(arguments)})"

    return st.one_of(
        st.builds(lambda x, o, y: f"{x} {o} {y}", e, st.sampled_from(BINARY), e),
        st.builds(lambda o, x: f"{o} {x}", st.sampled_from(["-", "not", "#"]), e),
        st.builds(lambda b, x, y: f"if {b} then {x} else {y}", e, e, e),
        st.builds(lambda x, y: f"{x} & {y}", e, e),
        st.builds(applied, st.one_of(e, st.sampled_from(sorted(BUILTINS))), st.lists(e, min_size=1, max_size=3)),
        st.builds(lambda x, y: f"({x}, {y})", e, e),
        st.builds(lambda x, y: f"<{x}, {y}>", e, e),
        st.builds(lambda x, y: f"{{{x}, {y}}}", e, e),
        st.builds(lambda x, y: f"{{ {x}..{y}}}", e, e),
        st.builds(lambda x, y: f"{{| {x}, {y} |}}", e, e),
        st.builds(lambda x, y: f"(| {x} => {y} |)", e, e),
        st.builds(lambda x, s: f"{{{x} | {s}}}", e, statements),
        st.builds(lambda x, s: f"<{x} | {s}>", e, statements),
        st.builds(lambda p, x, y: f"let {p} = {x} within {y}", pattern, e, e),
        st.builds(lambda p, x, y: f"(\\ {p} @ {x})({y})", pattern, e, e),
        st.builds(lambda x, y: f"{x} -> {y}", e, e),
        st.builds(
            lambda x, fs, v, y: f"{x}{''.join(fs).format(e=v)} -> {y}",
            e,
            st.lists(st.sampled_from(FIELDS), min_size=1, max_size=1),
            e,
            e,
        ),
        st.builds(lambda x, s: f"c$x:{s} -> {x}", e, e),
        st.builds(lambda x, s, y: f"{x} [| {s} |] {y}", e, e, e),
        st.builds(lambda x, s, t, y: f"{x} [ {s} || {t} ] {y}", e, e, e, e),
        st.builds(lambda x, s, t, y: f"{x} [ {s} <-> {t} ] {y}", e, e, e, e),
        st.builds(lambda x, s, t: f"{x} [[ {s} <- {t} ]]", e, e, e),
        st.builds(lambda x, s: f"{x} \\ {s}", e, e),
        st.builds(lambda o, s, x: f"{o} {s} @ {x}", st.sampled_from(["[]", "|~|", "|||", ";"]), statements, e),
        st.builds(lambda s, t, x: f"|| {s} @ [{t}] {x}", statements, e, e),
    )


expressions = st.recursive(st.sampled_from(LEAVES), compound, max_leaves=8)


@settings(max_examples=EXAMPLES, deadline=None)
@given(expressions)
def test_every_expression_ends_in_a_value_or_a_diagnostic(text: str) -> None:
    script = fresh_once()
    for ask in (script.show, script.evaluate, script.process, script.event_set, script.trace, script.boolean):
        try:
            found = ask(f"let x = 1\n    y = {{1}}\nwithin {text}")
            if isinstance(found, Reference):
                assert isinstance(found.body(), Process)
        except ScriptError as error:
            for diagnostic in error.diagnostics:
                assert diagnostic.span is not None, diagnostic
                assert not diagnostic.code.startswith("CSP9")


SCRIPTS: list[Script] = []


def fresh_once() -> Script:
    if not SCRIPTS:
        SCRIPTS.append(fresh())
    return SCRIPTS[0]
