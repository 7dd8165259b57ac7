"""``python -m tests``: everything that must hold before a change is good, in one command.

Runs the linter, the formatter's check, the type checker, the import contract and the test suite, prints what
each says, and exits non-zero if any of them fails. Further arguments go to pytest.
"""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BIN = Path(sys.executable).parent

STEPS: tuple[tuple[str, list[str]], ...] = (
    ("ruff check", [sys.executable, "-m", "ruff", "check", "."]),
    ("ruff format", [sys.executable, "-m", "ruff", "format", "--check", "."]),
    ("mypy --strict", [sys.executable, "-m", "mypy"]),
    ("import contract", [str(BIN / "lint-imports"), "--no-cache"]),
    ("pytest", [sys.executable, "-m", "pytest", "-n", "2", "--dist", "worksteal", "-q"]),
)


def main(arguments: list[str]) -> int:
    """Run every step and report; the exit status is 1 if one failed."""
    failed: list[str] = []
    for name, command in STEPS:
        extra = arguments if name == "pytest" else []
        print(f"== {name}", flush=True)
        started = time.monotonic()
        if subprocess.run([*command, *extra], cwd=ROOT, check=False).returncode != 0:
            failed.append(name)
        print(f"   {time.monotonic() - started:.0f} s", flush=True)
    print(f"failed: {', '.join(failed)}" if failed else "all good", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
