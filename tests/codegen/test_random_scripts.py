"""Random scripts: what is generated from one does what the script says, and stops only where the script may."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import assume, event, given, settings, strategies as st

import cspcheck
from cspcheck.codegen.runtime import Deadlock, Program, Randomly, VirtualClock
from tests.codegen.programs import Both, generate, loaded
from tests.examples import examples

pytestmark = pytest.mark.slow

CHANNELS = ("a", "b", "c")
HEAD = "channel a, b : {0..1}\nchannel c : {0..1}.{0..2}\nchannel d\n"


@st.composite
def prefixes(draw: st.DrawFn, states: int, family: int) -> str:
    """``x == 0 & a?y -> P1_0(1 - x)`` and the like."""
    channel = draw(st.sampled_from(["a", "b", "c", "d"]))
    known = ["0", "1", "x", "1 - x"]
    event, after = channel, list(known)
    if channel in ("a", "b"):
        field, more = draw(fields("y", known))
        event, after = event + field, after + more
    elif channel == "c":
        first, more = draw(fields("y", known))
        second, others = draw(fields("z", ["0", "1", "2", "x + 1"], first=False))
        event += first + second
        after += more + (["z % 2"] if others else [])
    target = f"P{family}_{draw(st.integers(0, states - 1))}({draw(st.sampled_from(after))})"
    ending = draw(st.sampled_from([target] * 8 + ["SKIP", "STOP", f"d -> {target}"]))
    condition = draw(st.sampled_from(["", "", "", "x == 0 & ", "x != 0 and not false & ", "x + 1 <= 1 & "]))
    return f"{condition}{event} -> {ending}"


@st.composite
def fields(draw: st.DrawFn, name: str, values: list[str], *, first: bool = True) -> tuple[str, list[str]]:
    """A field and the variable that it binds."""
    kind = draw(st.sampled_from(["!", "?", "?set", "?_", *(["."] if first else [])]))
    if kind in ("!", "."):
        value = draw(st.sampled_from(values))
        return (f"!{value}" if kind == "!" else f".({value})"), []
    if kind == "?_":
        return "?_", []
    return f"?{name}{':{0, 1}' if kind == '?set' else ''}", [name]


@st.composite
def scripts(draw: st.DrawFn) -> str:
    """Up to four families of states, composed at random."""
    lines = [HEAD]
    families = draw(st.integers(2, 4))
    for family in range(families):
        states = draw(st.integers(1, 3))
        for state in range(states):
            branches = draw(st.lists(prefixes(states, family), min_size=1, max_size=3))
            body = "\n  [] ".join(f"({branch})" for branch in branches)
            shape = draw(st.sampled_from(["", "", "if"]))
            if shape == "if":
                other = draw(prefixes(states, family))
                body = f"if x == 0 then {body} else {other}"
            lines.append(f"P{family}_{state}(x) = {body}")
    whole = f"P0_0({draw(st.integers(0, 1))})"
    for family in range(1, families):
        part = f"P{family}_0({draw(st.integers(0, 1))})"
        part = draw(wrappings(part))
        operator = draw(st.sampled_from(["shared", "shared", "interleaved", "alphabetised"]))
        if operator == "interleaved":
            whole = f"({whole} ||| {part})"
        elif operator == "shared":
            whole = f"({whole} [| {draw(sets())} |] {part})"
        else:
            whole = f"({whole} [ {draw(sets())} || {draw(sets())} ] {part})"
        whole = draw(wrappings(whole))
    lines.append(f"SYSTEM = {whole}")
    return "\n".join(lines) + "\n"


@st.composite
def sets(draw: st.DrawFn) -> str:
    names = draw(st.lists(st.sampled_from(["a", "b", "c", "d", "a.0", "c.1"]), unique=True, max_size=4))
    return f"{{| {', '.join(names)} |}}"


@st.composite
def wrappings(draw: st.DrawFn, process: str) -> str:
    kind = draw(st.sampled_from(["", "", "", "hide", "rename", "swap"]))
    if kind == "hide":
        return f"({process} \\ {{| {draw(st.sampled_from(['a', 'b', 'c', 'd']))} |}})"
    if kind == "rename":
        return f"({process}[[a <- b]])"
    return f"({process}[[a <- b, b <- a]])" if kind == "swap" else process


@settings(max_examples=examples(100))
@given(scripts(), st.integers(0, 2**16))
def test_programs_do_what_their_scripts_say(text: str, seed: int) -> None:
    script = cspcheck.loads(text)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        codes: set[str] = set()
        try:
            generate(script, "SYSTEM", folder)
        except cspcheck.ScriptError as refused:
            codes = {diagnostic.code for diagnostic in refused.diagnostics}
        if codes:
            event(f"refused: {sorted(codes)}")
        assert codes <= {"CSP805", "CSP806", "CSP812"}
        assume(not codes)
        both = Both(script, "SYSTEM")
        with loaded(folder) as main:
            program = Program(main.tasks())
        followers = (both.outside._follower, both.inside._follower)
        try:
            program.run("loop", clock=VirtualClock(), policy=Randomly(seed), recorder=Kept(both), events=80)
        except Deadlock:
            event("deadlock")
            assert all(follower.can_stop() for follower in followers)
        else:
            event("ran" if both.events == 80 else "terminated")


class Kept:
    """Follows a run and stays where that ended."""

    def __init__(self, both: Both) -> None:
        self.both = both

    def record(self, record: object) -> None:
        self.both.record(record)  # type: ignore[arg-type]

    def close(self) -> None:
        pass
