"""Random schedules of every generated example, followed against its script: a million events without a departure.

``python tests/benchmarks/bench_conformance.py [EVENTS]`` generates the program of every exhibit that can be generated,
runs it under random schedules, and follows every event twice: what can be seen, and what is hidden as well. It stops
with an error at the first departure.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cspcheck
from tests.codegen.programs import EXAMPLES, SLOW, SPECS, TABLES, followed, generate


def main(events: int) -> None:
    """Follow so many events in all."""
    examples = (*EXAMPLES, *TABLES, *SLOW)
    share = events // len(examples) + 1
    total = 0
    for number, (script, process, choice) in enumerate(examples):
        started = time.perf_counter()
        loaded = cspcheck.load(SPECS / script)
        with tempfile.TemporaryDirectory() as folder:
            generate(loaded, process, Path(folder), choice)
            count, deadlocked = followed(loaded, process, Path(folder), share, seed=1000 * number)
        total += count
        seconds = time.perf_counter() - started
        end = ", with deadlocks on the way" if deadlocked else ""
        print(f"{script:45s} {process:20s} {count:9,} events  {seconds:7.1f} s{end}", flush=True)
    print(f"{total:,} events, no departure")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000)
