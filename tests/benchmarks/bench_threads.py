"""What two threads gain on a search, held against one in turns.

    python -m tests.benchmarks.bench_threads [--rounds N] [--loops N] [--always]

The subject is the control part of an underwater vehicle beside independent loops. Counts are asserted; what is found
must be the same with one thread and with two. Wall times need a quiet machine; the processor time of each of two
threads, as a share of what one alone takes, says what is to be had there even on a busy one.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from functools import partial
from unittest import mock

from cspcheck.checker.kernels import jit
from cspcheck.checker.packing.packed import pack
from cspcheck.checker.search.exploration import explore
from cspcheck.checker.search.pace import Pace
from tests.benchmarks.bench_engine import checked, counts_with, timed
from tests.checker.vehicle import vehicle


def compare(loops: int, rounds: int) -> None:
    """Explore the vehicle beside so many loops, with one thread and with two."""
    packed = pack(vehicle(loops))
    states, transitions = counts_with(loops)

    def search(workers: int) -> None:
        checked(explore(packed, workers=workers), loops)

    one: list[tuple[float, float]] = []
    two: list[tuple[float, float]] = []
    for _ in range(rounds):
        one.append(timed(partial(search, 1)))
        two.append(timed(partial(search, 2)))
    median = statistics.median
    print(f"{loops} loops: {states:,} states, {transitions:,} transitions, {rounds} rounds")
    print(f"  one thread   {median(w for _, w in one):6.2f} s wall  {median(p for p, _ in one):6.2f} s processor")
    print(f"  two threads  {median(w for _, w in two):6.2f} s wall  {median(p for p, _ in two):6.2f} s processor")
    wall = median(w2 / w1 for (_, w1), (_, w2) in zip(one, two, strict=True))
    processor = median(p2 / 2 / p1 for (p1, _), (p2, _) in zip(one, two, strict=True))
    print(f"  {wall:.2f} of one thread's wall time; each {processor:.2f} of one thread's processor time", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3, help="rounds (default 3)")
    parser.add_argument("--loops", type=int, default=2, help="the most independent loops (default 2, 22.7 M states)")
    parser.add_argument("--always", action="store_true", help="two threads all the time, whether they gain or not")
    options = parser.parse_args()
    jit.kernels(True, lambda line: print(line, file=sys.stderr))
    explore(pack(vehicle()), workers=2)
    for loops in range(options.loops + 1):
        with mock.patch.object(Pace, "is_for_all", True) if options.always else mock.patch.dict({}):
            compare(loops, options.rounds)


if __name__ == "__main__":
    main()
