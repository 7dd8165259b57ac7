"""``python -m tests``: everything that must hold before a change is good, in one command.

Runs the linter, the formatter's check, the type checker, the import contract and the test suite, prints what
each says, and exits non-zero if any of them fails. Further arguments go to pytest.

``--nightly`` runs the tests with damaged and made-up inputs instead, a million and others every time, which takes
hours; ``CSPCHECK_FUZZ`` says how many. What it finds becomes a test of the room that it was found in.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BIN = Path(sys.executable).parent

STEPS: tuple[tuple[str, list[str]], ...] = (
    ("ruff check", [sys.executable, "-m", "ruff", "check", "."]),
    ("ruff format", [sys.executable, "-m", "ruff", "format", "--check", "."]),
    ("import contract", [str(BIN / "lint-imports"), "--no-cache"]),
    ("mypy --strict", [sys.executable, "-m", "mypy"]),
    ("pytest", [sys.executable, "-m", "pytest", "-n", "2", "--dist", "worksteal", "-q"]),
)

NIGHTLY = (
    "tests/cspm/parsing/test_parser_fuzz.py",
    "tests/cspm/test_script_fuzz.py",
    "tests/cspm/evaluator/test_evaluator_robustness.py",
)
"""The tests that make their inputs at random, as many as ``CSPCHECK_FUZZ`` says."""


def nightly(arguments: list[str]) -> int:
    """Run the random inputs of a night; pytest's exit status."""
    # Examples that are said to be so many are drawn anew each time.
    settings = {
        "CSPCHECK_FUZZ": "1000000",
        "CSPCHECK_EXAMPLES": "1000",
        "CSPCHECK_SEED": str(time.time_ns()),
        **os.environ,
    }
    command = [sys.executable, "-m", "pytest", "-n", "2", "--dist", "worksteal", "-q", *NIGHTLY, *arguments]
    return subprocess.run(command, cwd=ROOT, env=settings, check=False).returncode


def step(name: str, command: list[str], failed: list[str]) -> None:
    """Run a step, and add its name to those that failed if it does."""
    print(f"== {name}", flush=True)
    started = time.monotonic()
    if subprocess.run(command, cwd=ROOT, check=False).returncode != 0:
        failed.append(name)
    print(f"   {time.monotonic() - started:.0f} s", flush=True)


def main(arguments: list[str]) -> int:
    """Run every step and report; the exit status is 1 if one failed."""
    if "--nightly" in arguments:
        return nightly([argument for argument in arguments if argument != "--nightly"])
    failed: list[str] = []
    *quick, (types, type_command), (last, last_command) = STEPS
    for name, command in quick:
        step(name, command, failed)
    # One process can check the types while two run the tests: each of them waits for something now and then.
    with tempfile.TemporaryFile("w+", encoding="utf-8") as output:
        with subprocess.Popen(type_command, cwd=ROOT, stdout=output, stderr=subprocess.STDOUT) as checking:
            step(last, [*last_command, *arguments], failed)
            print(f"== {types}", flush=True)
            if checking.wait() != 0:
                failed.append(types)
        output.seek(0)
        print(output.read(), end="", flush=True)
    print(f"failed: {', '.join(failed)}" if failed else "all good", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
