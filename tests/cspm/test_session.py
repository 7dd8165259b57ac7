"""A session that evaluates for hours does not grow: what is written against a script is forgotten once it is told."""

from __future__ import annotations

import gc
import tracemalloc

import pytest

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.script import Script, load
from cspcheck.cspm.source import Source

SCRIPT = """\
channel c : {0..3}
datatype T = A | B.{0..1}
f(x) = let g(y) = x + y within g(1)
apply(h, x) = h(x)
P = c?x -> STOP
"""
FORMS = [
    "f({n}) + apply(\\ x @ x + {n}, 1)",
    "let k(z) = z * {n}\nh = k(2) within k(h)",
    "{{ (x, y) | x <- {{0..{n} % 5}}, y <- T, (z, _) <- {{(x, {n})}} }}",
    "if member(B.{n} % 2, T) then <{n}..{n} + 2> else <>",
    "let (a, b) = ({n}, f({n})) within a + b",
]


@pytest.fixture
def script() -> Script:
    return load(Source("session.csp", SCRIPT))


def evaluate(script: Script, start: int, count: int) -> None:
    for n in range(start, start + count):
        script.evaluate(FORMS[n % len(FORMS)].format(n=n))
        script.show(FORMS[(n + 1) % len(FORMS)].format(n=n))
        script.boolean(f"f({n}) == {n} + 1")
        script.event_set(f"{{| c.x | x <- {{0..{n} % 4}} |}}")
        script.trace(f"<c.x | x <- <0..{n} % 4>>")
        with pytest.raises(ScriptError):
            script.evaluate(f"apply(\\ x @ x, {n}, nowhere)")
        with pytest.raises(ScriptError):
            script.evaluate(f"(\\ x @ x + true)({n})")


def test_what_is_evaluated_leaves_nothing_behind(script: Script) -> None:
    evaluate(script, 0, 20)
    gc.collect()
    tracemalloc.start()
    try:
        before, _ = tracemalloc.get_traced_memory()
        evaluate(script, 20, 40)
        gc.collect()
        after, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert after - before < 280 * 100  # bytes for 280 expressions; kept trees would be some kilobytes each


def test_what_is_written_is_read_anew_each_time(script: Script) -> None:
    for _ in range(3):
        assert script.evaluate("apply(\\ x @ x + 1, 1)") == 2
        assert script.evaluate("let x = 5 within f(x)") == 6
