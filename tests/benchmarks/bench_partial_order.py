"""What partial order spares, beside the whole search and beside reduction by itself.

    python -m tests.benchmarks.bench_partial_order [PATTERN]

Verdicts and counts are asserted: of the whole search (``--as-written``), of the search by partial order alone
(``--as-written`` and the option), and of the default with the option, which first composes and minimises components.
Times are processor seconds of one worker, without loading the tool.
"""

from __future__ import annotations

import time
from pathlib import Path

from cspcheck.checker.check import Checker
from cspcheck.checker.verdict import Limits
from cspcheck.cspm import script
from cspcheck.cspm.source import Source
from tests.benchmarks.bench_reduction import BUFFERS, LEFT_HANDED, PHILOSOPHERS, SCHEDULER
from tests.benchmarks.choosing import measure_chosen

REPOSITORY = Path(__file__).parent.parent.parent
OPTION = ":[partial order reduce]"
MOST_STATES = 3_000_000

CYCLES = """
N = {n}
ID = {{0..N-1}}
channel a, b, c : ID
Cycle(i) = a.i -> b.i -> c.i -> Cycle(i)
Cycles = ||| i : ID @ Cycle(i)
assert Cycles :[deadlock free]
RunA = a?i -> RunA
assert RunA [FD= Cycles \\ {{| b, c |}}
Worker(i) = b.i -> c.i -> a.i -> STOP
Workers = (||| i : ID @ Worker(i)) \\ {{| b, c |}}
Count(k) = k < N & ([] i : ID @ a.i -> Count(k+1)) [] STOP
assert Count(0) [T= Workers
"""

Counts = tuple[str, int, int] | None
"""Verdict, states and transitions; None where the whole has more than ``MOST_STATES``."""

WORKLOADS: dict[str, tuple[str, list[tuple[Counts, Counts, Counts]]]] = {
    "cycles, 12": (
        CYCLES.format(n=12),
        [
            (("PASS", 531441, 6377292), ("PASS", 3, 3), ("PASS", 3, 3)),
            (("PASS", 531441, 6377292), ("PASS", 25, 36), ("PASS", 25, 36)),
            (None, ("PASS", 4120, 24600), ("PASS", 4120, 24600)),
        ],
    ),
    "cycles, 100": (CYCLES.format(n=100).split("RunA =")[0], [(None, ("PASS", 3, 3), ("PASS", 3, 3))]),
    "philosophers, one left-handed, 6": (
        PHILOSOPHERS.format(n=6, which=LEFT_HANDED),
        [(("PASS", 42213, 222326), ("PASS", 163, 192), ("PASS", 78, 186))],
    ),
    "philosophers, all alike, 6": (
        PHILOSOPHERS.format(n=6, which="Phil(i)"),
        [(("FAIL", 9870, 51930), ("FAIL", 127, 161), ("FAIL", 9870, 51930))],
    ),
    "scheduler, 12 cells": (
        SCHEDULER.format(n=12),
        [
            (("PASS", 73728, 479232), ("PASS", 59, 71), ("PASS", 168, 321)),
            (("PASS", 73728, 479232), ("PASS", 59, 71), ("PASS", 1216, 7171)),
            (("PASS", 73728, 479232), ("PASS", 48, 60), ("PASS", 9293, 38415)),
        ],
    ),
    "buffers, chain of 16": (
        BUFFERS.format(n=16),
        [(("PASS", 65536, 311296), ("PASS", 242, 257), ("PASS", 136, 317))],
    ),
    "vehicle": (
        (REPOSITORY / "specs" / "rov" / "rov.csp").read_text(encoding="utf-8"),
        [
            (("PASS", 2519424, 23549616), ("PASS", 30, 30), ("PASS", 65, 103)),
            (("PASS", 2519424, 23549616), ("PASS", 30, 30), ("PASS", 626, 4577)),
            (("PASS", 2519424, 23549616), ("PASS", 2519424, 23549616), ("PASS", 626, 4577)),
        ],
    ),
}


def measured(name: str) -> None:
    """Check a workload in three ways, hold the answers against those that are right, and print what they took."""
    text, expected = WORKLOADS[name]
    path = str(REPOSITORY / "specs" / "rov" / "workload.csp")
    lines = [f"{line} {OPTION}" if line.startswith("assert") else line for line in text.splitlines()]
    plain, wished = script.load(Source(path, text)), script.load(Source(path, "\n".join(lines)))
    for number, assertion in enumerate(plain.assertions):
        ways = [
            (plain, Checker(plain, workers=1, as_written=True, limits=Limits(states=MOST_STATES))),
            (wished, Checker(wished, workers=1, as_written=True)),
            (wished, Checker(wished, workers=1)),
        ]
        found: list[Counts] = []
        took: list[str] = []
        for loaded, checker in ways:
            begun = time.process_time()
            outcome = checker.check(loaded.assertions[number].node)
            seconds = time.process_time() - begun
            known = outcome.verdict.name, outcome.states, outcome.transitions
            found.append(None if outcome.verdict.name == "UNKNOWN" else known)
            took.append(f"{outcome.states:10,} {seconds:6.2f} s")
        print(f"{name:34} {assertion.text[:34]:34} {' | '.join(took)}", flush=True)
        assert tuple(found) == expected[number], (name, assertion.text, tuple(found))


if __name__ == "__main__":
    measure_chosen(WORKLOADS, measured)
