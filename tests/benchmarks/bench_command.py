"""How long the command takes as a whole process, from the shell to its end.

``python tests/benchmarks/bench_command.py`` prints the median of some runs (after one that warms the caches) and the
peak memory of the process. The state counts are asserted; the times are for reading.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RUNS = 3


def run(*arguments: str) -> tuple[float, float, str]:
    """Seconds, peak resident megabytes and standard output of one run of the command."""
    started = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-m", "cspcheck", *arguments], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    assert process.stdout is not None
    output = process.stdout.read().decode()
    _, _, usage = os.wait4(process.pid, 0)
    return time.perf_counter() - started, usage.ru_maxrss / 1024, output


def measure(name: str, *arguments: str) -> str:
    """Run warm, print a line, and give the output of the last run."""
    run(*arguments)
    results = [run(*arguments) for _ in range(RUNS)]
    seconds = [result[0] for result in results]
    print(
        f"{name:46s} median {statistics.median(seconds):6.2f} s   min {min(seconds):6.2f} s   max {max(seconds):6.2f} s"
        f"   peak {results[-1][1]:6.0f} MB"
    )
    return results[-1][2]


def first_check() -> None:
    """The vehicle on a machine that has never run a check: no cache at all. Processor seconds, of a process each."""
    used = []
    for _ in range(RUNS):
        with tempfile.TemporaryDirectory() as cache:
            before = children_seconds()
            arguments = ["specs/rov/rov.csp", "--full", "--format", "json", "--workers", "1"]
            done = subprocess.run(
                [sys.executable, "-m", "cspcheck", *arguments],
                cwd=ROOT,
                env={**os.environ, "XDG_CACHE_HOME": cache},
                capture_output=True,
                text=True,
                check=True,
            )
            used.append(children_seconds() - before)
            assert done.stderr.count("compiling the search kernels") == 1
            results = json.loads(done.stdout)["results"]
            assert [result["states"] for result in results] == [2_519_424] * 3
    print(f"the vehicle on a new machine: {min(used):.2f} to {max(used):.2f} s of processor time")


def children_seconds() -> float:
    """The processor seconds of the processes that were waited for."""
    times = os.times()
    return times.children_user + times.children_system


def main() -> None:
    """Measure the command's start, a small script, the vehicle on a new machine, with one thread and with two."""
    measure("--help", "--help")
    small = json.loads(
        measure(
            "two processes", "specs/producer_consumer/producer_consumer.csp", "--format", "json", "--assert", "SYSTEM"
        )
    )
    assert {result["states"] for result in small["results"]} == {4}
    first_check()
    for workers in ("1", "2"):
        output = measure(
            f"the vehicle, all three assertions, {workers} thread{'s' * (workers != '1')}",
            *("specs/rov/rov.csp", "--full", "--format", "json", "--workers", workers),
        )
        results = json.loads(output)["results"]
        assert [result["verdict"] for result in results] == ["pass"] * 3
        assert {(result["states"], result["transitions"]) for result in results} == {(2_519_424, 23_549_616)}


if __name__ == "__main__":
    main()
