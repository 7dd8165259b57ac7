"""What normal forms, ``normal``, ``diamond`` and bisimulations cost on machines of 10^5 states.

    python -m tests.benchmarks.bench_normal [PATTERN]

Counts are asserted. Times are processor seconds; ``kernels`` is what it takes to make them, in an empty cache.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator

import numpy as np

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.check import Checker
from cspcheck.checker.kernels.jit import tau_kernels
from cspcheck.checker.lts import Lts, machine
from cspcheck.checker.reduction.compression import COMPRESSIONS
from cspcheck.cspm import script
from cspcheck.cspm.process.events import TAU
from cspcheck.cspm.source import Source

BUFFERS = """
N = {n}
channel c : {{0..N}}.{{0..1}}
Cell(i) = c.i?x -> c.(i+1)!x -> Cell(i)
Chain = (|| i:{{0..N-1}} @ [{{|c.i, c.(i+1)|}}] Cell(i)) \\ {{|c.i | i <- {{1..N-1}}|}}
assert Chain [{model}= Chain
"""


def buffers(cells: int) -> Lts:
    """A chain of cells for a bit each, whose moves within are taus: 3^cells states."""
    states = np.arange(3**cells)
    contents = [states // 3**cell % 3 for cell in range(cells)]
    rows: list[tuple[Int64Array, int, Int64Array]] = []
    for bit in (1, 2):
        empty, full = contents[0] == 0, contents[-1] == bit
        rows.append((states[empty], 1 + bit, states[empty] + bit))
        rows.append((states[full], 3 + bit, states[full] - bit * 3 ** (cells - 1)))
        for cell in range(cells - 1):
            moves = (contents[cell] == bit) & (contents[cell + 1] == 0)
            rows.append((states[moves], TAU, states[moves] + bit * (3 ** (cell + 1) - 3**cell)))
    return _machine(len(states), rows)


def grid(side: int) -> Lts:
    """Taus lead along the rows of a square, events from row to row: no state is like another."""
    states = np.arange(side * side)
    row, column = np.divmod(states, side)
    inner = row < side - 1
    rows: list[tuple[Int64Array, int, Int64Array]] = [
        (states[column < side - 1], TAU, states[column < side - 1] + 1),
        (states[-side:], 6, np.zeros(side, dtype=np.int64)),
    ]
    for event in range(4):
        chosen = inner & ((7 * row + column) % 4 == event)
        rows.append((states[chosen], 2 + event, states[chosen] + side))
    return _machine(side * side, rows)


def scattered(states: int, events: int, degree: int, taus: float) -> Lts:
    """Transitions drawn at random, so many from each state, a share of them taus."""
    drawn = np.random.default_rng(1)
    count = states * degree
    starts = np.repeat(np.arange(states), degree)
    labels = np.where(drawn.random(count) < taus, TAU, 2 + drawn.integers(0, events, count))
    steps = drawn.integers(-states // 2, states // 2, count)
    return machine(states, starts, labels, np.clip(starts + steps, 0, states - 1))


def _machine(states: int, rows: list[tuple[Int64Array, int, Int64Array]]) -> Lts:
    starts, targets = (np.concatenate([row[place] for row in rows]) for place in (0, 2))
    return machine(states, starts, np.repeat([row[1] for row in rows], [len(row[0]) for row in rows]), targets)


MACHINES: dict[str, tuple[Callable[[], Lts], dict[str, tuple[int, int]]]] = {
    "buffers, 10 cells": (
        lambda: buffers(10),
        dict.fromkeys(("sbisim", "diamond", "normal", "dbisim", "wbisim"), (2047, 4092)) | {"sbisim": (59049, 196830)},
    ),
    "buffers, 11 cells": (lambda: buffers(11), dict.fromkeys(("diamond", "normal", "dbisim", "wbisim"), (4095, 8188))),
    "grid, side 120": (lambda: grid(120), dict.fromkeys(("dbisim", "wbisim"), (11980, 23956))),
    "grid, side 316": (
        lambda: grid(316),
        {"diamond": (83266, 413176), "normal": (82951, 347341), "dbisim": (83161, 166318)},
    ),
    "random, 20,000 states": (lambda: scattered(20_000, 2_000, 4, 0.02), {"normal": (18657, 81243)}),
    "random, 100,000 states": (lambda: scattered(100_000, 10_000, 3, 0.02), {"normal": (84515, 269425)}),
}


def compressions(name: str) -> Iterator[str]:
    """Compress a machine, hold the sizes against those that are right; what it took."""
    make, expected = MACHINES[name]
    lts = make()
    for compression, size in expected.items():
        begun = time.process_time()
        found = COMPRESSIONS[compression](lts)
        seconds = time.process_time() - begun
        assert (found.states, found.transitions) == size, (name, compression, found.states, found.transitions)
        yield f"{name:24} {compression:8} {lts.states:8,} to {found.states:8,} states {seconds:8.2f} s"


def refinements(cells: int) -> Iterator[str]:
    """A chain of buffers against itself, whole; what it took."""
    for model in ("T", "F", "FD"):
        loaded = script.load(Source("buffers.csp", BUFFERS.format(n=cells, model=model)))
        checker = Checker(loaded, workers=1, full=True)
        begun = time.process_time()
        outcome = checker.check(loaded.assertions[0].node)
        seconds = time.process_time() - begun
        assert (outcome.verdict.name, outcome.states) == ("PASS", 3**cells), outcome
        yield f"{f'{cells} buffers':24} {model:8} {outcome.states:8,} states {seconds:22.2f} s"


def making() -> Iterator[str]:
    """Make the kernels where none are kept; what it took."""
    text = "import time\nfrom cspcheck.checker.kernels import jit\njit.{}(True)\nprint(time.process_time())"
    with tempfile.TemporaryDirectory() as cache:
        for name in ("kernels", "tau_kernels"):
            for cold in ("made", "read"):
                environment = {**os.environ, "XDG_CACHE_HOME": cache}
                command = [sys.executable, "-c", text.format(name)]
                made = subprocess.run(command, env=environment, capture_output=True, check=True)
                yield f"{name:24} {cold:8} {float(made.stdout):38.2f} s"


def main() -> None:
    """Measure what has the pattern in its line."""
    pattern = sys.argv[1] if len(sys.argv) > 1 else ""
    tau_kernels(True)
    work: dict[str, Callable[[], Iterator[str]]] = {"kernels": making}
    work |= {name: lambda name=name: compressions(name) for name in MACHINES}  # type: ignore[misc]
    work |= {f"{cells} buffers": lambda cells=cells: refinements(cells) for cells in (9, 11, 12)}  # type: ignore[misc]
    for name, measure in work.items():
        if pattern in name:
            for line in measure():
                print(line, flush=True)


if __name__ == "__main__":
    main()
