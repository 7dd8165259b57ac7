"""Searches that are larger than memory: on disk, and by several processes, against the counts that are known.

    python -m tests.benchmarks.bench_large [--loops N] [--memory MIB] [--workers N]
    mpiexec -n 2 python -m tests.benchmarks.bench_large --cluster [--loops N]

The model is the vehicle with *loops* more processes of three states: 2,519,424 states three times as often for each.
The first form searches it in memory (unless that would be more than half of the machine's) and then on disk, with so
much memory for the whole process; four loops are 204,073,344 states and take some minutes and 10 GB of disk. The
second form has it searched by the processes that ``mpiexec`` has started, and tells what they have sent.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

from cspcheck.checker.guard import machine_memory
from cspcheck.checker.kernels import jit
from cspcheck.checker.packing.packed import PackedNetwork, pack
from cspcheck.checker.search.cluster import ClusterSearch, world
from cspcheck.checker.search.levels import LevelSearch
from cspcheck.checker.search.spill import Spill, SpillSearch
from cspcheck.checker.verdict import Limits
from tests.benchmarks.bench_engine import counts_with, high_water
from tests.checker.vehicle import vehicle

BYTES = 20
"""About what a state takes in memory."""


def told(what: str, search: LevelSearch | ClusterSearch, loops: int, begun: tuple[float, float]) -> bool:
    """Run a search and say how it went; whether the counts are those that are known."""
    search.run()
    wall, processor = time.perf_counter() - begun[0], time.process_time() - begun[1]
    right = (search.known, search.transitions) == counts_with(loops)
    print(
        f"{what}: {search.known:,} states, {search.transitions:,} transitions ({'as known' if right else 'WRONG'}), "
        f"{wall:.0f} s, {processor:.0f} s of processor time, {search.transitions / processor:,.0f} transitions in one; "
        f"at most {high_water() >> 20:,} MiB",
        flush=True,
    )
    return right


def on_disk(packed: PackedNetwork, loops: int, memory: int, workers: int) -> bool:
    """On disk, and before that in memory if there is enough; whether the counts are right."""
    jit.kernels(True, print)
    right = True
    with tempfile.TemporaryDirectory(dir=Path.cwd()) as folder:
        begun = time.perf_counter(), time.process_time()
        limits = Limits(memory_bytes=memory << 20)
        search = SpillSearch(packed, limits=limits, workers=workers, spill=Spill(Path(folder)))
        right &= told(f"on disk, {memory:,} MiB", search, loops, begun)
    if BYTES * counts_with(loops)[0] < (machine_memory() or 0) // 2:
        begun = time.perf_counter(), time.process_time()
        right &= told("in memory", LevelSearch(packed, limits=Limits(), workers=workers), loops, begun)
    return right


def by_several(packed: PackedNetwork, loops: int) -> bool:
    """By the processes that ``mpiexec`` has started; whether the counts are right."""
    together = world()
    jit.kernels(True)
    if together.ranks.rank:
        together.serve()
        return True
    begun = time.perf_counter(), time.process_time()
    search = ClusterSearch(packed, None, cluster=together, limits=Limits(), workers=1)
    right = told(f"the first of {together.ranks.size} processes", search, loops, begun)
    own, sent = search._worker.transitions, together.ranks.bytes_sent
    print(
        f"its own: {search.visited.known:,} states, {search.visited.peak_bytes / search.visited.known:.1f} bytes each; "
        f"{own:,} transitions, {sent / own:.2f} bytes sent for each",
        flush=True,
    )
    together.dismiss()
    return right


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--loops", type=int, help="further processes (default 4, with --cluster 0)")
    parser.add_argument("--memory", type=int, default=1750, metavar="MIB", help="for the arrays (default 1750)")
    parser.add_argument("--workers", type=int, default=1, help="threads (default 1)")
    parser.add_argument("--cluster", action="store_true", help="by the processes of mpiexec")
    options = parser.parse_args()
    loops = options.loops if options.loops is not None else 0 if options.cluster else 4
    packed = pack(vehicle(loops))
    right = by_several(packed, loops) if options.cluster else on_disk(packed, loops, options.memory, options.workers)
    sys.exit(0 if right else 1)


if __name__ == "__main__":
    main()
