"""How fast sequential processes with data are explored: one definition, many values of its arguments.

    python -m tests.benchmarks.bench_leaves [PATTERN]

Each has some 10^5 states and no composition in it, so nothing but its transitions, one state after another, is
measured. Counts are asserted. Times are seconds of processor time of one worker, without loading the script.
"""

from __future__ import annotations

import time

from cspcheck.checker.network.components import ALONE, ComponentMachines
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from tests.benchmarks.choosing import measure_chosen

QUEUE = r"""
channel in, out : {0..2}
Q(s) = #s < 10 & in?x -> Q(s^<x>) [] #s > 0 & out!head(s) -> Q(tail(s))
P = Q(<>)
"""
PATTERNS = r"""
channel in, out : {0..2}
Q(<>) = in?x -> Q(<x>)
Q(<x>^s) = out!x -> Q(s) [] #s < 9 & in?y -> Q(<x>^s^<y>)
P = Q(<>)
"""
SET = r"""
V = {0..15}
channel add, remove : V
channel full
S(s) = add?x:diff(V, s) -> S(union(s, {x})) [] remove?x:s -> S(diff(s, {x})) [] s == V & full -> S({})
P = S({})
"""
MAP = r"""
K = {0..4}
channel read, write : K.{0..9}
M(m) = ([] k : K @ read.k!mapLookup(m, k) -> M(m)) [] write?k?v:{(mapLookup(m, k) + 1) % 10} -> M(mapUpdate(m, k, v))
P = M(mapFromList(<(k, 0) | k <- <0..4>>))
"""
COUNTERS = r"""
channel a, b, c, d
C(i, j) = i < 315 & a -> C(i + 1, j) [] j < 315 & b -> C(i, j + 1)
  [] i > 0 & c -> C(i - 1, j) [] j > 0 & d -> C(i, j - 1)
P = C(0, 0)
"""
PHASES = r"""
T = {0..4}
datatype Phase = Idle | Asked.T | Granted.T | Failed
channel ask, grant, release : T
channel pass, fail, repair
Server(phase, waiting, age) =
  (not member(phase, {Failed}) & pass -> Server(phase, waiting, (age + 1) % 45))
  [] (#waiting < 5 & ask?t:diff(T, set(waiting)) -> Server(phase, waiting^<t>, age))
  [] (phase == Idle and #waiting > 0 & Serve(head(waiting), tail(waiting), age))
  [] ([] t : T @ phase == (Granted.t) & release.t -> Server(Idle, waiting, 0))
  [] (if phase == Failed then repair -> Server(Idle, <>, 0) else fail -> Server(Failed, waiting, age))
Serve(t, rest, age) = grant.t -> Server((Granted.t), rest, age)
P = Server(Idle, <>, 0)
"""

WORKLOADS: dict[str, tuple[str, int, int]] = {
    "a queue": (QUEUE, 88_573, 177_144),
    "a queue by patterns": (PATTERNS, 88_573, 177_144),
    "a set": (SET, 1 << 16, 16 * (1 << 16) + 1),
    "a map": (MAP, 100_000, 1_000_000),
    "two counters": (COUNTERS, 316 * 316, 4 * 315 * 316),
    "a server with phases": (PHASES, 97_291, 375_661),
}
"""Script, and how many states and transitions its P has."""


def measured(name: str) -> None:
    """Explore a process; hold the counts against these; what it took."""
    text, states, transitions = WORKLOADS[name]
    script = load(Source(name + ".csp", text))
    semantics = Semantics()
    process = script.process("P")
    begun = time.process_time()
    lts = ComponentMachines(semantics).of(semantics.state(process), ALONE, 10**6).lts
    seconds = time.process_time() - begun
    print(
        f"{name:24} {lts.states:9,} states {lts.transitions:10,} transitions {seconds:7.2f} s"
        f" {lts.states / seconds:9,.0f} states/s {lts.transitions / seconds:9,.0f} transitions/s",
        flush=True,
    )
    assert (lts.states, lts.transitions) == (states, transitions), (
        name,
        lts.states,
        lts.transitions,
    )


if __name__ == "__main__":
    measure_chosen(WORKLOADS, measured)
