"""``python -m tests``: everything that must hold before a change is good, in one command.

Runs the linter, the formatter's check, the type checker, the import contract and the test suite, prints what
each says, and exits non-zero if any of them fails. Further arguments go to pytest.

``--nightly`` runs the tests with damaged and made-up inputs instead, a million and others every time, which takes
hours; ``CSPCHECK_FUZZ`` says how many. It tells after every round how many there were, and may be ended at any time.
What it finds becomes a test of the room that it was found in.
"""

from __future__ import annotations

import os
import signal
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


ROUND = 20_000
"""So many inputs are tried before it is told how far the night has come."""


def nightly(arguments: list[str]) -> int:
    """Try random inputs, round by round, until there were enough or somebody ends it; 1 if something was found.

    Each round has a seed of its own, which is told where it finds something: with ``CSPCHECK_SEED`` and the number of
    inputs it is the same again.
    """
    wanted = int(os.environ.get("CSPCHECK_FUZZ", "1000000"))
    seed = os.environ.get("CSPCHECK_SEED") or str(time.time_ns())
    command = [sys.executable, "-m", "pytest", "-n", "2", "--dist", "worksteal", "-q", *NIGHTLY, *arguments]
    started, tried, number, failed = time.monotonic(), 0, 0, 0
    ended = True
    while ended and tried < wanted:
        inputs = min(ROUND, wanted - tried)
        # Examples that are said to be so many are drawn anew each time.
        settings = {"CSPCHECK_EXAMPLES": "1000", "CSPCHECK_FUZZ": str(inputs)}
        settings["CSPCHECK_SEED"] = seed if number == 0 else f"{seed}+{number}"
        status = _carried_out(command, {**os.environ, **settings})
        ended = status in (0, 1)
        if ended:
            number, tried, failed = number + 1, tried + inputs, failed + status
        if status != 0:
            again = f"CSPCHECK_SEED={settings['CSPCHECK_SEED']} CSPCHECK_FUZZ={inputs} python -m tests --nightly"
            print(f"   this round again: {again}", flush=True)
        print(
            f"== {tried:,} of {wanted:,} inputs tried in {(time.monotonic() - started) / 60:.1f} min, "
            f"{failed} of {number} rounds with findings{'' if ended else '; ended before its time'}",
            flush=True,
        )
    return 0 if ended and not failed else 1


def _carried_out(command: list[str], environment: dict[str, str]) -> int:
    """Run a command; its exit status. Whoever ends this program ends the command, which says what it knows by then."""
    # A program that was started in the background ignores Ctrl-C, and what it starts would, too.
    interrupted = signal.signal(signal.SIGINT, signal.default_int_handler)
    with subprocess.Popen(command, cwd=ROOT, env=environment) as running:
        signal.signal(signal.SIGINT, interrupted)
        before = signal.signal(signal.SIGTERM, lambda *_: running.send_signal(signal.SIGINT))
        try:
            while True:
                try:
                    return running.wait()
                except KeyboardInterrupt:  # it has got that as well
                    continue
        finally:
            signal.signal(signal.SIGTERM, before)


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
