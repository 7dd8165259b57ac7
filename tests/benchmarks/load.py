"""Many checks at once on few processors: nothing fails, and no verdict is another one.

    python -m tests.benchmarks.load [--commands N] [--pytest N] [SCRIPT...]

*commands*: so many commands are started at the same moment, with a cache that is empty, so that the first of them
compile the kernels side by side. *pytest*: the assertions of the scripts with so many workers of pytest, again with an
empty cache. Held is that each assertion has the verdict that its script expects, and that nobody says anything else.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parents[2]
HANG = 3600
"""Seconds after which a command is taken to hang."""


def commands(scripts: Sequence[Path], number: int, cache: Path) -> list[str]:
    """Check scripts with so many commands at once, each with the next script; what was wrong."""
    # Kernels are needed by all: otherwise small scripts would do without.
    started = [
        (script, _start(["-m", "cspcheck", "check", str(script), "--format", "json"], cache))
        for script in (scripts[place % len(scripts)] for place in range(number))
    ]
    wrong: list[str] = []
    for script, process in started:
        out, err = process.communicate(timeout=HANG)
        try:
            found = json.loads(out)
        except json.JSONDecodeError:
            wrong.append(f"{script}: exit {process.returncode}: {err[-500:]}")
            continue
        wrong += [f"{script}: {d['message']}" for d in found["diagnostics"] if d["severity"] == "error"]
        wrong += [
            f"{script}: {one['assertion']}: {one['verdict']}, not {one['expected']}"
            for one in found["results"]
            if one["verdict"] != one["expected"]
        ]
        right = (0, 1) if found["results"] else (5,)  # a script that asserts nothing
        if "Traceback" in err or "damaged" in err or process.returncode not in right:
            wrong.append(f"{script}: exit {process.returncode}: {err[-500:]}")
    return wrong


def tests(scripts: Sequence[Path], workers: int, cache: Path) -> tuple[int, list[str]]:
    """Check scripts with so many workers of pytest: how many assertions passed, and what was wrong."""
    arguments = ["-m", "pytest", "-q", "-p", "no:cacheprovider", "-n", str(workers), *map(str, scripts)]
    process = _start(arguments, cache)
    out, err = process.communicate(timeout=HANG)
    last = out.strip().splitlines()[-1] if out.strip() else err
    passed = re.search(r"(\d+) passed", last)
    good = process.returncode == 0 and "failed" not in last and "error" not in last
    return int(passed[1]) if passed else 0, [] if good else [out[-3000:] + err[-1000:]]


def _start(arguments: Sequence[str], cache: Path) -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "XDG_CACHE_HOME": str(cache)}
    return subprocess.Popen(
        [sys.executable, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        cwd=ROOT,
        env=environment,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--commands", type=int, default=100, help="commands at once (default 100; 0: none)")
    parser.add_argument("--pytest", type=int, default=8, help="workers of pytest (default 8; 0: none)")
    parser.add_argument("scripts", nargs="*", type=Path, help="by default all that are shown")
    options = parser.parse_args()
    scripts = options.scripts or sorted((ROOT / "specs").rglob("*.csp"))
    wrong: list[str] = []
    with tempfile.TemporaryDirectory() as folder:
        if options.commands:
            begun = time.monotonic()
            wrong += commands(scripts, options.commands, Path(folder) / "first")
            print(
                f"{options.commands} commands at once: {len(wrong)} wrong, {time.monotonic() - begun:.0f} s", flush=True
            )
        if options.pytest:
            begun = time.monotonic()
            passed, faults = tests(scripts, options.pytest, Path(folder) / "second")
            print(
                f"{passed} assertions passed with {options.pytest} workers, {time.monotonic() - begun:.0f} s",
                flush=True,
            )
            wrong += faults
    print("\n".join(wrong))
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
