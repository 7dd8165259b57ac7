"""What the classical studies cost at sizes of which nothing but reduction gives an answer.

    python -m tests.benchmarks.bench_studies [PATTERN]

The scripts are those of ``tests/cases/studies``, which say their verdicts and why. Counts are
asserted, too. Times are seconds of one worker, without loading the script.
"""

from __future__ import annotations

import time
from pathlib import Path

import cspcheck
from tests.benchmarks.choosing import measure_chosen

STUDIES = Path(__file__).parent.parent / "cases" / "studies"

WORKLOADS: dict[str, tuple[Path, dict[str, int | bool], list[int]]] = {
    "philosophers by 10, and 1,025 by halves": (
        STUDIES / "nested_philosophers.csp",
        {"N": 10, "LEVELS": 10},
        [95, 14, 14, 14, 97, 7, 7],
    ),
    "packet ring, 50 nodes": (STUDIES / "packet_ring.csp", {"N": 50}, [16, 17, 90, 60]),
    "public keys, all messages": (STUDIES / "needham_schroeder.csp", {"ALL": True}, [1416, 971, 2901, 1060]),
    "election in time, 6 nodes": (STUDIES / "bully.csp", {"N": 6}, [408, 679, 408, 407, 589]),
    "Fischer, 4 processes": (STUDIES / "fischer.csp", {"N": 4}, [1383, 1433, 1383, 1383]),
    "named variables, 6 of 5 values": (
        STUDIES / "named_variables.csp",
        {"VARIABLES": 6, "K": 5},
        [390626, 390626, 390626, 390626, 31],
    ),
} | {
    f"run queues, {processors} processors": (
        STUDIES / "run_queues.csp",
        {"PROCESSORS": processors, "TASKS": 4},
        [passed, passed, passed, failed],
    )
    for processors, passed, failed in (
        (2, 785, 61),
        (3, 2_737, 121),
        (4, 7_137, 201),
        (5, 15_521, 301),
        (6, 29_809, 421),
    )
}
"""Script, constants, and how many states are looked at for each assertion."""


def measured(name: str) -> None:
    """Check a script, hold its verdicts against those it says and its counts against these; what each took."""
    path, constants, counts = WORKLOADS[name]
    script = cspcheck.load(path, definitions=constants)
    begun = time.process_time()
    results = script.check(workers=1)
    seconds = time.process_time() - begun
    print(f"{name:40} {seconds:8.2f} s of processor time", flush=True)
    for result in results:
        assert result.as_expected, result.explain()
        print(f"    {result.verdict!s:5} {result.states:10,} states {result.seconds:8.2f} s  {result.assertion[:60]}")
    found = [result.states for result in results]
    assert found == counts or not counts, (name, found)


if __name__ == "__main__":
    measure_chosen(WORKLOADS, measured)
