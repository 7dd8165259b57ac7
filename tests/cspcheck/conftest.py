"""Fixed results and diagnostics that every renderer is shown, so that their outputs can be compared."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from cspcheck.checker.verdict import (
    BrokenObligation,
    ComponentBehaviour,
    Counterexample,
    Outcome,
    SpecificationRun,
    Verdict,
)
from cspcheck.cspm.diagnostics import Diagnostic, Label, Severity
from cspcheck.cspm.source import Source, Span
from cspcheck.result import Result, Summary

SCRIPT = """\
channel a, b, c : {0..1}
N = 2
Fork(i) = a.i -> b.i -> Fork(i)
P = a.0 -> Foo
\tQ(x) = if x then 日本 -> Foo(Bar) else STOP
R =
  a ->
  b ->
  c -> STOP
"""


def outcome(verdict: Verdict, counterexample: Counterexample | None = None, reason: str | None = None) -> Outcome:
    return Outcome(verdict, reason, 1234, 5678, 0.25, 65536, counterexample)


def result(
    verdict: str, counterexample: Counterexample | None = None, *, reason: str | None = None, **changes: object
) -> Result:
    attributes: dict[str, object] = {
        "file": "table.csp",
        "line": 31,
        "assertion": "SYSTEM :[deadlock free [FD]]",
        "kind": "deadlock free",
        "model": "FD",
        "process": "SYSTEM",
        "outcome": outcome(Verdict(verdict), counterexample, reason),
    }
    return Result(**(attributes | changes))  # type: ignore[arg-type]


def refinement(
    verdict: str, counterexample: Counterexample | None = None, model: str = "T", **changes: object
) -> Result:
    return result(
        verdict,
        counterexample,
        **{
            "line": 40,
            "assertion": f"SPEC [{model}= IMPL",
            "kind": "refinement",
            "model": model,
            "process": "IMPL",
            "specification": "SPEC",
        }
        | changes,
    )


DEADLOCK = Counterexample(
    kind="deadlock",
    trace=("sit.0", "tau", "take.1.1"),
    causes=(None, "take.0.0", None),
    refusal=("sit.0", "sit.1", "take.0.1", "take.1.0"),
    components=(
        ComponentBehaviour(
            "Phil(0)", ("sit", "take.0.0", None), "take.0.1 -> Eating(0)", 12, ("take.0.1",), ("Fork(1)",)
        ),
        ComponentBehaviour(
            "Phil(1)", (None, None, "take.1.1"), "take.1.0 -> Eating(1)", 12, ("take.1.0",), ("Fork(0)",)
        ),
        ComponentBehaviour("Fork(0)", (None, "take.0.0", None), "put.0.0 -> Fork(0)", 20, ("put.0.0",), ("Phil(0)",)),
        ComponentBehaviour("Fork(1)", (None, None, "take.1.1"), "put.1.1 -> Fork(1)", 20, ("put.1.1",), ("Phil(1)",)),
        ComponentBehaviour("Clock", (None, None, None), "tick -> Clock", None, (), ()),
    ),
    waiting_cycle=("Phil(0)", "Fork(1)", "Phil(1)", "Fork(0)"),
)
TRACE = Counterexample(
    kind="trace",
    trace=("in.0", "tau", "tau"),
    causes=(None, "mid.0", None),
    event="out.1",
    allowed=(("out.0", "in.1"),),
    specification_trace=("in.0",),
    specification=SpecificationRun(("tau", "in.0"), (None, None), ("SPEC", "Copy", "out.0 -> Copy [] in.1 -> STOP")),
    components=(
        ComponentBehaviour("Left", ("in.0", "mid.0", None), "STOP", 3, (), ()),
        ComponentBehaviour("Right", (None, "mid.0", "tau"), "out.1 -> Right", 4, ("out.1",), ()),
    ),
    event_parts=(("Right", "out.1"),),
)
REFUSAL = Counterexample(
    kind="refusal",
    trace=("in.0",),
    refusal=("out.0",),
    offered=("out.1",),
    allowed=(("out.0",), ("in.1", "in.0")),
    specification_trace=("in.0",),
)
DIVERGENCE = Counterexample(
    kind="divergence",
    trace=("in.0",),
    loop=("mid.0", "tau"),
    components=(
        ComponentBehaviour("Left", ("in.0",), "mid.0 -> Left", 3, ("mid.0",), ()),
        ComponentBehaviour("Right", (None,), "mid.0 -> Right", 4, ("mid.0",), ()),
    ),
    loop_parts=((("Left", "mid.0"), ("Right", "mid.0")), (("Right", "tau"),)),
)
NONDETERMINISM = Counterexample(
    kind="nondeterminism", trace=("c.0", "tau"), event="a", refusal=("a",), alternative=("c.0", "a")
)
CANNOT = Counterexample(kind="refusal", trace=("a",), event="b", refusal=("b",), allowed=(("a", "c.0"),))
NEED_NOT = Counterexample(kind="refusal", trace=("a",), event="b", refusal=("b",), allowed=(("a", "b"),))
OBLIGATION = Counterexample(
    kind="obligation",
    trace=(),
    values={"n": "9", "limit": "10", "amount?": "2", "old!": "9", "n'": "11"},
    obligation=BrokenObligation(
        name="invariant preserved",
        subject="Counter",
        operation="add",
        message="the operation breaks the invariant `n <= limit`",
        line=12,
        failing="n' <= limit",
        lines=((12, "n <= limit"), (20, "n' = n + amount?")),
        others=("`feasible` of `take`: the operation can never be performed",),
    ),
)
LONG = Counterexample(kind="divergence", trace=tuple(f"c.{i}" for i in range(100)), loop=("tau",) * 50)

RESULTS: dict[str, Result] = {
    "pass": result("pass"),
    "deadlock": result("fail", DEADLOCK),
    "trace": refinement("fail", TRACE),
    "refusal": refinement("fail", REFUSAL, "F"),
    "divergence": result(
        "fail", DIVERGENCE, assertion="SYSTEM :[divergence free [FD]]", kind="divergence free", line=33
    ),
    "divergence in a refinement": refinement("fail", DIVERGENCE, "FD"),
    "nondeterminism": result(
        "fail", NONDETERMINISM, assertion="SYSTEM :[deterministic [FD]]", kind="deterministic", line=35
    ),
    "no such trace": result(
        "fail", CANNOT, assertion="SYSTEM :[has trace [T]]: <a, b>", kind="has trace", model="T", line=36
    ),
    "trace that is not sure": result(
        "fail", NEED_NOT, assertion="SYSTEM :[has trace [F]]: <a, b>", kind="has trace", model="F", line=37
    ),
    "obligation": result(
        "fail", OBLIGATION, assertion="Counter :[obligations]", kind="obligations", model=None, process="Counter"
    ),
    "unknown": result("unknown", reason="the limit of 1,000 states was reached; no fault among those explored"),
    "error": result("error", reason="`0` is not a value of the first field of `c`"),
    "false": result(
        "fail",
        assertion="1 == 2",
        kind="boolean",
        model=None,
        process="",
        outcome=Outcome(Verdict.FAIL, None, 0, 0, 0, 0),
    ),
    "expected failure": result("fail", DEADLOCK, expected=Verdict.FAIL),
    "unexpected pass": result("pass", expected=Verdict.FAIL),
    "expected unknown": result("unknown", reason="the time limit of 5 s was reached", expected=Verdict.UNKNOWN),
    "negated pass": result("pass", DEADLOCK, negated=True, assertion="not SYSTEM :[deadlock free [FD]]"),
    "negated fail": result("fail", negated=True, assertion="not SYSTEM :[deadlock free [FD]]"),
    "hostile": refinement(
        "fail", TRACE, file="a%b,c:d.csp", assertion='P\x1b[31m <&"> ]]> [T= Q\nR', expected=Verdict.PASS
    ),
    "folded": result("fail", LONG),
}


def place(source: Source, text: str, occurrence: int = 0, until: str | None = None) -> Span:
    start = -1
    for _ in range(occurrence + 1):
        start = source.text.index(text, start + 1)
    end = start + len(text) if until is None else source.text.index(until, start) + len(until)
    return source.span(start, end)


def diagnostics() -> dict[str, Diagnostic]:
    source = Source("table.csp", SCRIPT)
    other = Source("lib/common.csp", "-- shared\nFoo = STOP\n")
    long = Source("long.csp", "L = " + "a.0 -> " * 40 + "ZZZ -> STOP\n")
    return {
        "plain": Diagnostic(
            "CSP201",
            "`Foo` is not defined",
            place(source, "Foo"),
            annotation="not in scope",
            notes=("in `P`", "in a note\nof two lines"),
            help="did you mean `Fork`?",
        ),
        "labels on one line, wide characters, tabs": Diagnostic(
            "CSP301",
            "these do not fit",
            place(source, "Foo", 1),
            annotation="this one",
            labels=(
                Label(place(source, "日本"), "is wide"),
                Label(place(source, "Bar"), "an argument"),
                Label(place(source, "N"), "defined here"),
            ),
        ),
        "several lines": Diagnostic(
            "CSP101", "this is long", place(source, "a ->", until="STOP\n"), annotation="all of this"
        ),
        "several lines from within a line": Diagnostic(
            "CSP102", "this is long", place(source, "if x", until="b ->"), severity=Severity.WARNING
        ),
        "two sources": Diagnostic(
            "CSP202", "`Foo` is defined twice", place(source, "Foo"), labels=(Label(place(other, "Foo"), "first here"),)
        ),
        "a long line": Diagnostic("CSP201", "`ZZZ` is not defined", place(long, "ZZZ"), annotation="not in scope"),
        "the end of the file": Diagnostic(
            "CSP103", "unexpected end of file", source.span(len(SCRIPT), len(SCRIPT)), annotation="something is missing"
        ),
        "no place": Diagnostic("CSP001", "no such file: `x.csp`", help="check the name"),
        "hostile": Diagnostic("CSP001", "bad \x1b[2Jtext\n::error::100%", place(source, "N")),
    }


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """``result`` and ``diagnostic`` stand for each of the samples in turn."""
    if "result" in metafunc.fixturenames:
        metafunc.parametrize("result", RESULTS.values(), ids=RESULTS.keys())
    if "diagnostic" in metafunc.fixturenames:
        samples = diagnostics()
        metafunc.parametrize("diagnostic", samples.values(), ids=samples.keys())


@pytest.fixture
def results() -> dict[str, Result]:
    return RESULTS


@pytest.fixture
def mistakes() -> dict[str, Diagnostic]:
    return diagnostics()


@pytest.fixture
def summary() -> Summary:
    """What the samples add up to, in a run of 12.3 seconds."""
    total = Summary.empty()
    for one in RESULTS.values():
        total.add(one)
    total.seconds = 12.3
    return total


ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def environment() -> dict[str, str]:
    """The environment in which programs are run: this source tree, and UTF-8."""
    return {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"}
