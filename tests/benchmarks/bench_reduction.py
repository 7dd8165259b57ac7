"""What plain scripts cost that are reduced unasked, and what compressions and priorities on every level cost.

    python -m tests.benchmarks.bench_reduction [PATTERN]

No script here has a compression function if its name does not say so. Verdicts and counts are asserted. Times are
processor seconds of one worker, without loading the tool.
"""

from __future__ import annotations

import time
from pathlib import Path

from cspcheck.checker.check import Checker
from cspcheck.cspm import script
from cspcheck.cspm.source import Source
from tests.benchmarks.choosing import measure_chosen

REPOSITORY = Path(__file__).parent.parent.parent

PHILOSOPHERS = """
N = {n}
ID = {{0..N-1}}
channel sit, eat, getup : ID
channel pick, put : ID.ID
Phil(i) = sit.i -> pick.i.i -> pick.i.(i+1)%N -> eat.i -> put.i.(i+1)%N -> put.i.i -> getup.i -> Phil(i)
Left(i) = sit.i -> pick.i.(i+1)%N -> pick.i.i -> eat.i -> put.i.i -> put.i.(i+1)%N -> getup.i -> Left(i)
Fork(i) = pick?j:{{i,(i-1)%N}}!i -> put.j.i -> Fork(i)
AP(i) = {{| sit.i, eat.i, getup.i, pick.i, put.i |}}
AF(i) = {{| pick.i.i, pick.(i-1)%N.i, put.i.i, put.(i-1)%N.i |}}
Forks = || i:ID @ [AF(i)] Fork(i)
System = (|| i:ID @ [AP(i)] ({which})) [| {{| pick, put |}} |] Forks
assert System :[deadlock free [F]]
"""
LEFT_HANDED = "if i == 0 then Left(i) else Phil(i)"

SCHEDULER = """
N = {n}
ID = {{0..N-1}}
channel a, b, c : ID
Rest(i) = b.i -> c.(i+1)%N -> Cell(i) [] c.(i+1)%N -> b.i -> Cell(i)
Cell(i) = c.i -> a.i -> Rest(i)
System = (|| i:ID @ [{{a.i, b.i, c.i, c.(i+1)%N}}] (if i == 0 then a.0 -> Rest(0) else Cell(i))) \\ {{| c |}}
Order(i) = a.i -> Order((i+1)%N)
assert System :[deadlock free [FD]]
assert System :[divergence free]
assert Order(0) [FD= System \\ {{| b |}}
"""

RING = """
N = {n}
ID = {{0..N-1}}
channel pass, enter, leave : ID
Has(i) = enter.i -> leave.i -> pass.(i+1)%N -> Idle(i) [] pass.(i+1)%N -> Idle(i)
Idle(i) = pass.i -> Has(i)
Ring = || i:ID @ [{{enter.i, leave.i, pass.i, pass.(i+1)%N}}] (if i == 0 then Has(i) else Idle(i))
Mutex = enter?i -> leave.i -> Mutex
assert Ring :[deadlock free [FD]]
assert Mutex [T= Ring \\ {{| pass |}}
assert Ring :[deterministic]
"""

BUFFERS = """
N = {n}
channel c : {{0..N}}
Cell(i) = c.i -> c.(i+1) -> Cell(i)
Chain = (|| i:{{0..N-1}} @ [{{c.i, c.(i+1)}}] Cell(i)) \\ {{c.i | i <- {{1..N-1}}}}
Count(k) = k < N & c.0 -> Count(k+1) [] k > 0 & c.N -> Count(k-1)
assert Count(0) [FD= Chain
"""

SIDE_BY_SIDE = """
N = {n}
ID = {{1..N}}
channel get, put, s1, s2, s3 : ID
Cell(i) = get.i -> s1.i -> s2.i -> s3.i -> put.i -> Cell(i)
System = ||| i:ID @ Cell(i) \\ {{| s1, s2, s3 |}}
Box(i) = get.i -> put.i -> Box(i)
assert System :[deadlock free [F]]
assert System :[deadlock free [FD]]
assert ||| i:ID @ Box(i) [FD= System
assert System :[deterministic]
"""

ALIKE = """
N = {n}
channel go, x, y, done
Cell = go -> x -> y -> done -> Cell
System = ||| i:{{1..N}} @ Cell \\ {{x, y}}
Count(k) = k < N & go -> Count(k+1) [] k > 0 & done -> Count(k-1)
assert Count(0) [FD= System
assert System :[deterministic]
"""

KNOWLEDGE = """
external chase
N = {n}
channel learn, say : {{1..N}}
channel infer : {{1..N}}.{{1..N}}
More(f) = {{g | g <- {{1..N}}, g == 2*f or g == 2*f+1}}
Ignorant(f) = learn.f -> Knows(f) [] infer?g!f -> Knows(f)
Knows(f) = say.f -> Knows(f) [] learn.f -> Knows(f) [] infer.f?g:More(f) -> Knows(f)
Less(f) = {{g | g <- {{1..N}}, f == 2*g or f == 2*g+1}}
Al(f) = Union({{{{learn.f, say.f}}, {{infer.f.g | g <- More(f)}}, {{infer.g.f | g <- Less(f)}}}})
Spy = chase((|| f : {{1..N}} @ [Al(f)] Ignorant(f)) \\ {{| infer |}})
Agent = learn.(N/2) -> say.N -> STOP
System = Agent [| {{| learn, say |}} |] Spy
assert System :[has trace [T]]: <learn.(N/2), say.N>
"""

Answer = tuple[str, int, int]
"""Verdict, states and transitions."""

WORKLOADS: dict[str, tuple[str, list[Answer]]] = {
    "philosophers, one left-handed, 100": (
        PHILOSOPHERS.format(n=100, which=LEFT_HANDED),
        [("PASS", 58, 128)],
    ),
    "philosophers, one left-handed, 1000": (
        PHILOSOPHERS.format(n=1000, which=LEFT_HANDED),
        [("PASS", 58, 128)],
    ),
    "philosophers, all alike, 20": (PHILOSOPHERS.format(n=20, which="Phil(i)"), [("FAIL", 53, 110)]),
    "scheduler, 100 cells": (
        SCHEDULER.format(n=100),
        [("PASS", 2061, 5718), ("PASS", 1217, 7185), ("PASS", 9355, 38423)],
    ),
    "token ring, 100 stations": (RING.format(n=100), [("PASS", 300, 400)] * 3),
    "buffers, chain of 100": (BUFFERS.format(n=100), [("PASS", 4522, 12845)]),
    "cells side by side, 12": (
        SIDE_BY_SIDE.format(n=12),
        [("PASS", 1, 1), ("PASS", 1, 1), ("PASS", 4096, 49152), ("PASS", 4096, 49152)],
    ),
    "equal cells side by side, 40": (ALIKE.format(n=40), [("PASS", 738, 2656)] * 2),
    "knowledge chased, 20 facts": (KNOWLEDGE.format(n=20), [("PASS", 3, 2)]),
    "knowledge chased, 60 facts": (KNOWLEDGE.format(n=60), [("PASS", 3, 2)]),
    "vehicle": (
        (REPOSITORY / "specs" / "rov" / "control_view.csp").read_text(encoding="utf-8"),
        [("PASS", 18, 24), ("PASS", 626, 4577), ("PASS", 626, 4577)],
    ),
}


def measured(name: str) -> None:
    """Check a workload, hold its answers against those that are right, and print what they took."""
    text, expected = WORKLOADS[name]
    path = REPOSITORY / "specs" / "rov" / "workload.csp"
    loaded = script.load(Source(str(path), text))
    checker = Checker(loaded, workers=1)
    for assertion, answer in zip(loaded.assertions, expected, strict=False):
        begun = time.process_time()
        outcome = checker.check(assertion.node)
        seconds = time.process_time() - begun
        found = outcome.verdict.name, outcome.states, outcome.transitions
        assert found == answer, (name, found, answer)
        print(f"{name:40} {outcome.verdict.name:7} {outcome.states:10,} states {seconds:8.2f} s", flush=True)


if __name__ == "__main__":
    measure_chosen(WORKLOADS, measured)
