"""The corpus of names and evaluation, one script a row of the language; what is expected stands in the scripts.

In a script that passes:

``print e   -- => text``   the value of e, as the language writes it
``-- body e => text``      the process e, unfolded to its first operator
``-- same e === f``        e and f are one and the same term once unfolded
``-- states e => n``       so many different terms can be reached in e through events (prefixes and choices only)

In a script that fails ``-- error: CODE`` ends the line of each mistake (``-- error: CODE nowhere`` for one without a
place); ``-- note: text`` and ``-- help: text`` are parts of what else is said. A script that says ``-- untyped`` is not
what the type checker accepts; all others must say the same with and without types.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.process import terms as process
from cspcheck.cspm.process.terms import Process, Reference
from cspcheck.cspm.process.text import describe
from cspcheck.cspm.script import Script, load
from cspcheck.cspm.syntax import tree as syntax

CORPUS = Path(__file__).parents[2] / "corpus"
PASSING = sorted([*CORPUS.glob("names/pass/*.csp"), *CORPUS.glob("evaluate/pass/*.csp")])
FAILING = sorted([*CORPUS.glob("names/fail/*.csp"), *CORPUS.glob("evaluate/fail/*.csp")])
LONG = ("depth", "too_deep", "infinite")


def name(path: Path) -> str:
    return path.relative_to(CORPUS).with_suffix("").as_posix()


def ways(paths: list[Path]) -> list[object]:
    """Each script with types and without, unless it is not for the type checker or goes on for a million steps."""
    return [
        pytest.param(path, typed, id=f"{name(path)}-{'typed' if typed else 'untyped'}")
        for path in paths
        for typed in (True, False)
        if not (typed and ("-- untyped" in path.read_text(encoding="utf-8") or path.stem.startswith(LONG)))
    ]


def test_the_corpus_is_there() -> None:
    assert len(PASSING) > 35
    assert len(FAILING) > 100


@pytest.mark.parametrize(("path", "typed"), ways(PASSING))
def test_a_script_that_passes(path: Path, typed: bool) -> None:
    text = path.read_text(encoding="utf-8")
    script = load(path, typecheck=typed)

    printed = re.findall(r"^print .*?-- => (.*)$", text, re.MULTILINE)
    assert list(script.printed) == [line.rstrip() for line in printed]

    for line in re.findall(r"^-- (?:body|same|states) .*$", text, re.MULTILINE):
        check(script, line)


def check(script: Script, line: str) -> None:
    if line.startswith("-- same "):
        left, right = line.removeprefix("-- same ").split(" === ")
        assert unfolded(script.process(left)) is unfolded(script.process(right)), line
    else:
        kind, expression, expected = re.fullmatch(r"-- (body|states) (.*) => (.*?)\s*", line).groups()  # type: ignore[union-attr]
        if kind == "body":
            term = unfolded(script.process(expression))
            assert describe(term, script.events, width=2000) == expected, line
        else:
            assert len(reachable(script.process(expression))) == int(expected), line


def unfolded(term: Process) -> Process:
    return term.body() if isinstance(term, Reference) else term


def reachable(term: Process) -> set[Process]:
    """The states of a process made of prefixes, external choices, STOP and SKIP."""
    found: set[Process] = set()
    stack = [unfolded(term)]
    while stack:
        state = stack.pop()
        if state in found:
            continue
        found.add(state)
        stack.extend(unfolded(after) for after in successors(state))
    return found


def successors(state: Process) -> list[Process]:
    match state:
        case process.Prefix():
            return [after for _, after in state.branches]
        case process.ExternalChoice():
            return [after for operand in state.operands for after in successors(unfolded(operand))]
        case process.Stop() | process.Skip():
            return []
    raise AssertionError(f"{state} is not as simple as that")


@pytest.mark.parametrize(("path", "typed"), ways(FAILING))
def test_a_script_that_fails(path: Path, typed: bool) -> None:
    text = path.read_text(encoding="utf-8")
    found = mistakes(path, typed)
    assert [place(d) for d in found] == expected(text), found
    said = "\n".join(line for d in found for line in (d.message, d.help or "", *d.notes))
    for wanted in re.findall(r"^-- (?:note|help): (.*?)\s*$", text, re.MULTILINE):
        assert wanted in said


def expected(text: str) -> list[tuple[str, int | None]]:
    places: list[tuple[str, int | None]] = []
    for number, line in enumerate(text.splitlines(), 1):
        for code, nowhere in re.findall(r"-- error: (CSP\d+)( nowhere)?", line):
            places.append((code, None if nowhere else number))
    return places


def place(diagnostic: Diagnostic) -> tuple[str, int | None]:
    return diagnostic.code, None if diagnostic.span is None else diagnostic.span.line


def mistakes(path: Path, typed: bool) -> list[Diagnostic]:
    """What is wrong with a script, its assertions and the processes that they reach, and with what it prints."""
    try:
        script = load(path, typecheck=typed)
        for assertion in script.assertions:
            for term in operands(script, assertion.node):
                unfold_all(term)
    except ScriptError as error:
        return list(error.diagnostics)
    return sorted(script.warnings, key=lambda d: -1 if d.span is None else d.span.start)


def operands(script: Script, node: syntax.Assertion) -> list[Process]:
    match node:
        case syntax.NotAssertion():
            return operands(script, node.inner)
        case syntax.Refinement():
            return [script.process(node.specification), script.process(node.implementation)]
        case syntax.Property():
            if node.trace is not None:
                script.trace(node.trace)
            return [script.process(node.process)]
        case syntax.BooleanAssertion():
            script.boolean(node.condition)
    return []


def unfold_all(term: Process, limit: int = 200) -> None:
    """Evaluate the bodies of the references in *term*, and of those in them."""
    seen: set[Process] = set()
    stack: list[object] = [term]
    while stack and len(seen) < limit:
        item = stack.pop()
        if isinstance(item, tuple):
            stack.extend(item)
        elif isinstance(item, Process) and item not in seen:
            seen.add(item)
            if isinstance(item, Reference):
                stack.append(item.body())
            else:
                stack.extend(getattr(item, field, None) for field in item.__dataclass_fields__)
