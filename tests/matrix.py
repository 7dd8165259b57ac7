"""``python -m tests.matrix``: the fast set of tests under every supported Python that this machine has.

Each Python that is found as ``python3.11`` to ``python3.13`` gets a virtual environment with the newest dependencies;
the oldest of them gets one more with the lowest versions that ``pyproject.toml`` allows. ``--only 3.13`` or ``--only
lowest`` picks.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PYTHONS = ("3.11", "3.12", "3.13")
TESTS = ("tests/cspm", "tests/checker/semantics", "tests/checker/search", "tests/codegen", "tests/cspcheck/test_api.py")


def lowest() -> list[str]:
    """The lowest versions that our dependencies may have, as constraints."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    found = [re.match(r"([\w-]+)>=([\d.]+)", requirement) for requirement in project["dependencies"]]
    return [f"{match[1]}=={match[2]}" for match in found if match]


def run(python: str, constraints: list[str], arguments: list[str]) -> bool:
    """Install in a new environment and run the tests; gives whether they pass."""
    with tempfile.TemporaryDirectory() as folder:
        limits = Path(folder) / "constraints.txt"
        limits.write_text("\n".join(constraints) + "\n")
        environment = Path(folder) / "venv"
        binaries = environment / "bin"
        steps = (
            [python, "-m", "venv", str(environment)],
            [str(binaries / "pip"), "install", "--quiet", "-c", str(limits), "-e", f"{ROOT}[dev]"],
            [str(binaries / "python"), "-m", "pytest", "-q", "-m", "not slow", *arguments],
        )
        return all(subprocess.run(step, cwd=ROOT, check=False).returncode == 0 for step in steps)


def main(arguments: list[str]) -> int:
    """Run the matrix; the exit status is 1 if something in it failed."""
    parser = argparse.ArgumentParser(prog="python -m tests.matrix")
    parser.add_argument("--only", help="a version of Python, or `lowest`")
    options, rest = parser.parse_known_args(arguments)
    found = {version: path for version in PYTHONS if (path := shutil.which(f"python{version}")) is not None}
    for version in PYTHONS:
        if version not in found:
            print(f"python{version} is not on this machine", flush=True)
    jobs = [(version, path, list[str]()) for version, path in found.items()]
    if found:
        oldest = next(iter(found))
        jobs.append(("lowest", found[oldest], lowest()))
    failed = []
    for name, path, constraints in jobs:
        if options.only in (None, name):
            print(f"== {name}{' of ' + ', '.join(constraints) if constraints else ''}", flush=True)
            if not run(path, constraints, rest or list(TESTS)):
                failed.append(name)
    print(f"failed: {', '.join(failed)}" if failed else "all good", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
