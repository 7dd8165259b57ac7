"""Priority in the search: ``timed_priority(System)`` beside ``System``, a million states each.

    python -m tests.benchmarks.bench_priority

The counts are asserted. Of the rate without priority at least a third must be left.
"""

from __future__ import annotations

import time

from cspcheck.checker.kernels import jit
from cspcheck.checker.network.compiler import compile_network
from cspcheck.checker.packing.packed import pack
from cspcheck.checker.search.exploration import explore
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source

SCRIPT = r"""
channel tock
channel step : {0..5}.{0..9}
Cell(i, k) = step.i.k -> Cell(i, (k + 1) % 10) [] tock -> Cell(i, 0)
System = ([| {tock} |] i : {0..5} @ Cell(i, 0)) \ {| step.0.3, step.1.5 |}
Timed {
  Urgent = timed_priority(System)
}
"""
STATES = 1_000_000
TRANSITIONS = {"System": 7_000_000, "Urgent": 6_810_000}
"""Six steps and a tock in each state; no tock where a hidden step is possible, in 190,000 of them."""


def seconds(name: str) -> float:
    """Processor seconds of the search alone, one thread."""
    packed = pack(compile_network(load(Source("benchmark.csp", SCRIPT)).process(name)))
    started = time.process_time()
    found = explore(packed, workers=1)
    taken = time.process_time() - started
    assert (found.levels[-1], found.transitions) == (STATES, TRANSITIONS[name]), (found.levels[-1], found.transitions)
    return taken


def main() -> None:
    jit.kernels(compiled=True)
    seconds("System")
    plain, urgent = (min(seconds(name) for _ in range(3)) for name in ("System", "Urgent"))
    for name, taken in (("System", plain), ("Urgent", urgent)):
        print(f"  {name:8}{taken:6.2f} s processor, {STATES / taken / 1e6:.2f} million states a second")
    print(f"  the rate with priority is {plain / urgent:.2f} of that without")


if __name__ == "__main__":
    main()
