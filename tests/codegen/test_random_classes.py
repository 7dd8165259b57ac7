"""Random classes: operations as code do what the predicates say, and block only where these do."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import assume, event, given, settings, strategies as st

import cspcheck
from cspcheck.codegen.runtime import Deadlock, Program, Randomly, VirtualClock
from tests.codegen.programs import Both, generate, loaded
from tests.codegen.test_random_scripts import Kept
from tests.examples import examples

pytestmark = pytest.mark.slow

FREE = ("x < 2", "x = y", "x <= y", "not x = 1", "x + y >= 1", "exists k : 0..2 @ k = x and k /= y", "{x, y} = {1, 2}")
AFTER = (
    "{v}' = {v} + 1",
    "{v}' = 2 - {v}",
    "{v}' >= {v}",
    "{v} < 2 and {v}' = {v} + 1 or {v} = 2 and {v}' = 0",
    "x = 0 => {v}' = 1",
    "{v} = {v}' + 1",
    "not {v}' = {v}",
    "{v}' in {{0, 2}}",
    "({v}', 1) = (y, 1)",
    "{v}' = (if x = y then 0 else 1)",
    "{v}' - y = 0",
)


@st.composite
def predicates(draw: st.DrawFn, delta: tuple[str, ...], inputs: tuple[str, ...], outputs: tuple[str, ...]) -> str:
    """A conjunction about the after-values and outputs, with some that leave things open."""
    parts = []
    for variable in delta:
        pool = [*AFTER, *[f"{{v}}' = {name}?" for name in inputs], *[f"{{v}}' + {name}? = 2" for name in inputs]]
        if draw(st.integers(0, 5)):
            parts.append(draw(st.sampled_from(pool)).format(v=variable))
    for name in outputs:
        pool = [f"{name}! = x", f"{name}! >= y", f"{name}! = y and x < 2", f"{name}! + x = 2", "true"]
        pool += [f"{name}! = {variable}'" for variable in delta]
        parts.append(draw(st.sampled_from(pool)))
    for name in inputs:
        parts.append(draw(st.sampled_from(["true", f"{name}? >= x", f"{name}? /= y", f"{name}? in {{x, y}}"])))
    parts += draw(st.lists(st.sampled_from(FREE), max_size=1))
    return " and ".join(f"({part})" for part in parts) or "true"


@st.composite
def operations(draw: st.DrawFn, name: str, kind: str) -> str:
    """The schemas of an operation; *kind*: its parameter's decoration, or nothing."""
    delta = tuple(draw(st.lists(st.sampled_from(["x", "y"]), unique=True, max_size=2)))
    inputs, outputs = (("i",), ()) if kind == "?" else ((), ("i",)) if kind == "!" else ((), ())
    declared = f" i{kind} : 0..2" if kind else ""
    predicate = draw(predicates(delta, inputs, outputs))
    return f"  op com_{name} Delta({', '.join(delta)}){declared} where {predicate}\n"


@st.composite
def mains(draw: st.DrawFn, names: list[str]) -> str:
    """A process that mentions every operation."""
    order = draw(st.permutations(names))
    shape = draw(st.sampled_from(["sequence", "choice", "mixed", "none"]))
    if shape == "none":
        return ""
    if shape == "sequence":
        return f"  main = {' -> '.join(order)} -> main\n"
    if shape == "choice":
        return f"  main = {' [] '.join(f'{name} -> main' for name in order)}\n"
    first, *rest = order
    return f"  main = {first} -> Rest\n  Rest = {' [] '.join(f'{name} -> main' for name in rest)} [] {first} -> Rest\n"


@st.composite
def scripts(draw: st.DrawFn) -> str:
    """Two classes that are joined on a channel."""
    text = ""
    for name, kind in (("A", "!"), ("B", "?")):
        methods = [f"m{i}" for i in range(draw(st.integers(1, 2)))]
        text += f"class {name}\n  chan c : [i{kind} : 0..2]\n"
        text += "".join(f"  method {method}\n" for method in methods)
        text += draw(mains([*methods, "c"]))
        invariant = draw(st.sampled_from(["", "", f"\n  where {draw(st.sampled_from(FREE))}"]))
        text += f"  state\n    x : 0..2\n    y : 0..2{invariant}\n"
        text += f"  init {draw(st.sampled_from(['x = 1 and y = 2', 'x = 0', 'true', 'y = x + 1']))}\n"
        text += draw(operations("c", kind))
        text += "".join(draw(operations(method, "")) for method in methods)
        text += "end\n"
    return text + "SYSTEM = A || B\n"


@settings(max_examples=examples(60))
@given(scripts(), st.integers(0, 2**16))
def test_classes_do_what_their_predicates_say(text: str, seed: int) -> None:
    script = cspcheck.loads(text)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        codes: set[str] = set()
        try:
            generate(script, "SYSTEM", folder)
        except cspcheck.ScriptError as refused:
            codes = {diagnostic.code for diagnostic in refused.diagnostics}
        assert codes <= {"CSP684"}  # a class without an initial state
        assume(not codes)
        with loaded(folder) as main:
            program = Program(main.tasks())
        both = Both(script, "SYSTEM")
        try:
            program.run("loop", clock=VirtualClock(), policy=Randomly(seed), recorder=Kept(both), events=60)
        except Deadlock:
            event("deadlock")
            assert both.inside._follower.can_stop()
        else:
            event("ran")
