"""How fast the engine explores, held against a straightforward C program in the same run.

    python -m tests.benchmarks.bench_engine [--rounds N] [--loops N] [--no-c]

The subject is the control part of an underwater vehicle. Counts are asserted. Times are processor seconds where not
said otherwise, medians over rounds in which the contestants take turns, so that a busy machine troubles all alike.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from cspcheck.checker.kernels import jit
from cspcheck.checker.network.network import Network
from cspcheck.checker.packing.packed import PackedNetwork, pack
from cspcheck.checker.search.exploration import Exploration, explore
from tests.checker.vehicle import STATES, TRANSITIONS, vehicle

REPOSITORY = Path(__file__).parent.parent.parent
BYTES_PER_STATE = 40


def counts_with(loops: int) -> tuple[int, int]:
    """States and transitions of the vehicle beside independent loops of three events."""
    states, transitions = STATES, TRANSITIONS
    for _ in range(loops):
        states, transitions = 3 * states, 3 * (transitions + states)
    return states, transitions


def checked(exploration: Exploration, loops: int = 0) -> Exploration:
    found = exploration.levels[-1], exploration.transitions
    assert found == counts_with(loops), found
    assert exploration.complete
    assert exploration.deadlock_level is None
    assert exploration.divergence_level is None
    assert not exploration.branching
    return exploration


def explored(packed: PackedNetwork, loops: int) -> Exploration:
    return checked(explore(packed), loops)


def timed(job: Callable[[], object]) -> tuple[float, float]:
    """Processor and wall seconds."""
    wall, processor = time.perf_counter(), time.process_time()
    job()
    return time.process_time() - processor, time.perf_counter() - wall


def as_text(packed: PackedNetwork) -> str:
    """The network as the C program reads it."""
    rules = packed.rules
    rows = zip(rules.mask.tolist(), rules.value.tolist(), rules.set.tolist(), strict=True)
    lines = [f"{len(rules.event)} {int(packed.initial[0])}"]
    lines += [f"{mask} {value} {value ^ target}" for mask, value, target in rows]
    return "\n".join(lines)


class CProgram:
    """``explore.c``, compiled."""

    def __init__(self, folder: str) -> None:
        self.program = Path(folder) / "explore"
        source = Path(__file__).parent / "explore.c"
        subprocess.run(["gcc", "-O2", "-o", str(self.program), str(source)], check=True)

    def run(self, text: str, loops: int = 0) -> float:
        """Its processor seconds."""
        done = subprocess.run([str(self.program)], input=text, capture_output=True, text=True, check=True)
        states, transitions, seconds = done.stdout.split()
        assert (int(states), int(transitions)) == counts_with(loops)
        return float(seconds)


def compare(rounds: int, with_c: bool) -> None:
    packed = pack(vehicle())
    text = as_text(packed)
    one: list[tuple[float, float]] = []
    two: list[tuple[float, float]] = []
    c: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        program = CProgram(folder) if with_c else None
        for _ in range(rounds):
            one.append(timed(lambda: checked(explore(packed, workers=1))))
            if program:
                c.append(program.run(text))
            two.append(timed(lambda: checked(explore(packed, workers=2))))
    median = statistics.median
    processor, wall = median(p for p, _ in one), median(w for _, w in one)
    print(f"vehicle: {STATES:,} states, {TRANSITIONS:,} transitions, {rounds} rounds")
    print(f"  one thread    {processor:6.2f} s processor  {wall:6.2f} s wall")
    processor2, wall2 = median(p for p, _ in two), median(w for _, w in two)
    shares = median(w2 / w1 for (_, w1), (_, w2) in zip(one, two, strict=True))
    print(f"  two threads   {processor2:6.2f} s processor  {wall2:6.2f} s wall, {shares:.2f} of one thread's wall")
    if c:
        ratio = median(p / seconds for (p, _), seconds in zip(one, c, strict=True))
        print(f"  C program     {median(c):6.2f} s processor; one thread takes {ratio:.2f} times that")
        shared = median(p / 2 / seconds for (p, _), seconds in zip(two, c, strict=True))
        print(f"                two threads, each its half of the work, {shared:.2f} times")


def growth(loops: int) -> None:
    """Time per transition beside more and more independent loops."""
    base = None
    print("growth: independent loops of three events beside the vehicle, one thread")
    for n in range(loops + 1):
        packed = pack(vehicle(n))
        states, transitions = counts_with(n)
        times = [timed(partial(explored, packed, n))[0] for _ in range(3 if n < 2 else 1)]
        nanoseconds = min(times) / transitions * 1e9
        base = base or nanoseconds
        print(
            f"  {n} loops  {states:12,} states  {transitions:13,} transitions  {min(times):7.2f} s  "
            f"{nanoseconds:5.1f} ns a transition, {nanoseconds / base:.2f} times"
        )


def memory(workers: int) -> None:
    """Bytes per state at the peak; run in a process of its own."""
    jit.kernels(True)
    explore(pack(small()), workers=workers, compiled=True)
    before = high_water()
    exploration = checked(explore(pack(vehicle()), workers=workers))
    arrays = exploration.peak_memory_bytes / STATES
    resident = (high_water() - before) / STATES
    print(f"  {workers} threads: {arrays:.1f} bytes a state in arrays, {resident:.1f} resident above the interpreter")
    assert arrays <= BYTES_PER_STATE
    assert resident <= BYTES_PER_STATE


def high_water() -> int:
    """The most memory this process has had resident, in bytes (Linux)."""
    status = Path("/proc/self/status").read_text()
    return next(int(line.split()[1]) * 1024 for line in status.splitlines() if line.startswith("VmHWM"))


def small() -> Network:
    """A network that needs every library but no memory."""
    from tests.checker.vehicle import cycle, synchronised

    return synchronised({"P": cycle("a", "b"), "Q": cycle("b", "c")})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="rounds of the comparison (default 5)")
    parser.add_argument(
        "--loops", type=int, default=3, help="independent loops for the growth (default 3, 68 M states)"
    )
    parser.add_argument("--no-c", action="store_true", help="do not compile and run the C program")
    parser.add_argument("--memory", type=int, metavar="WORKERS", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.memory:
        memory(options.memory)
        return
    jit.kernels(True, lambda line: print(line, file=sys.stderr))
    explore(pack(vehicle()), workers=2)
    compare(options.rounds, with_c=not options.no_c and shutil.which("gcc") is not None)
    print("memory at the peak")
    for workers in (1, 2):
        sys.stdout.flush()
        command = [sys.executable, "-m", "tests.benchmarks.bench_engine", "--memory", str(workers)]
        subprocess.run(command, check=True, cwd=REPOSITORY, env=dict(os.environ))
    growth(options.loops)


if __name__ == "__main__":
    main()
