"""A long search killed again and again at random moments, and taken up each time.

    python -m tests.benchmarks.kills [--kills N] [--seed N] [--disk]

With ``--disk`` the search has hardly any memory and goes on on disk, now and then with more of it.
Checkpoints are written after every few rows, so that many of the kills meet one that is half written. Now and then
the run that takes up has another number of threads. In the end counts and levels are those of a run that nobody ended.
"""

from __future__ import annotations

import argparse
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from cspcheck.checker.packing.packed import PackedNetwork, pack
from cspcheck.checker.search import levels
from cspcheck.checker.search.checkpoint import Checkpoints
from cspcheck.checker.search.exploration import explore
from cspcheck.checker.search.spill import Spill
from tests.checker.vehicle import cycle, synchronised

ROOT = Path(__file__).parents[2]


def machine() -> PackedNetwork:
    """6,561 states."""
    return pack(synchronised({f"P{i}": cycle(f"a{i}", f"b{i}", f"c{i}") for i in range(8)}))


def search(folder: Path | None, workers: int, rows: int = 0) -> str:
    """Search, from where it was written down in the folder, and say what was found.

    *rows*: how many may be in memory; 0: all.
    """
    levels.INTERPRETED_ROWS = 16
    places = None if folder is None else Checkpoints(folder, {"version": "1"}, resume=folder.exists(), every=0.0)
    print("begun", flush=True)
    beyond = Spill(folder.parent / "rows", rows) if folder is not None and rows else None
    found = explore(machine(), workers=workers, compiled=False, checkpoints=places, beyond=beyond)
    return f"{found.levels} {found.transitions} {found.complete}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=50, help="how often (default 50)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--disk", action="store_true", help="on disk")
    parser.add_argument("--run", nargs=3, metavar=("FOLDER", "WORKERS", "ROWS"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.run:
        print(search(Path(options.run[0]), int(options.run[1]), int(options.run[2])), flush=True)
        return
    begun = time.monotonic()
    expected = search(None, 1)
    whole = time.monotonic() - begun
    chance, kills, starts, finished = random.Random(options.seed), 0, 0, 0
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "c"
        while kills < options.kills:
            command = [
                sys.executable,
                "-m",
                "tests.benchmarks.kills",
                "--run",
                str(place),
                str(chance.choice([1, 1, 2])),
                str(chance.choice([200, 200, 1_000, 0]) if options.disk else 0),
            ]
            starts += 1
            with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT) as process:
                assert process.stdout is not None
                if process.stdout.readline() != "begun\n":
                    raise SystemExit("a run did not begin")
                try:
                    process.wait(chance.uniform(0, whole))
                except subprocess.TimeoutExpired:
                    process.send_signal(signal.SIGKILL)
                    kills += 1
                    continue
                said = process.stdout.read().strip()
            if said != expected:
                raise SystemExit(f"after {kills} kills: {said}, and not {expected}")
            finished += 1
            for path in place.iterdir():
                path.unlink()
            place.rmdir()
        done = subprocess.run(
            [sys.executable, "-m", "tests.benchmarks.kills", "--run", str(place), "1", "0"],
            capture_output=True,
            text=True,
            cwd=ROOT,
            check=True,
        )
    said = done.stdout.splitlines()[-1]
    if said != expected:
        raise SystemExit(f"after {kills} kills: {said}, and not {expected}")
    print(f"{kills} kills in {starts} starts; {finished + 1} searches came to their end, all with {expected[-30:]}")


if __name__ == "__main__":
    main()
