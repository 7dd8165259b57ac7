"""cspcheck beside a project that has modules called like our floors: nobody's own ``checker`` may get in the way."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """\
channel a, b
P = a -> b -> P
Q = b -> Q
System = P [| {b} |] Q
assert System :[deadlock free]
"""

TEST = """\
def test_the_system_is_deadlock_free(csp):
    (result,) = csp.load("x.csp").check()
    assert result
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A folder with a script, a test, and modules of the user's own that end whatever imports them."""
    (tmp_path / "x.csp").write_text(SCRIPT)
    (tmp_path / "test_x.py").write_text(TEST)
    (tmp_path / "conftest.py").write_text("")
    (tmp_path / "checker.py").write_text("raise RuntimeError('the user meant another checker')\n")
    for package in ("cspm", "codegen", "specs"):
        (tmp_path / package).mkdir()
        (tmp_path / package / "__init__.py").write_text(f"raise RuntimeError('the user meant another {package}')\n")
    return tmp_path


def run(folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    """A command in the folder, with the folder first on the path of Python."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONSAFEPATH"}
    return subprocess.run(
        command,
        cwd=folder,
        env={**environment, "PYTHONPATH": ".", "PYTHONIOENCODING": "utf-8"},
        capture_output=True,
        encoding="utf-8",
        check=False,
    )


COMMAND = str(Path(sys.executable).parent / "cspcheck")


@pytest.mark.parametrize("command", [(COMMAND,), (sys.executable, "-m", "cspcheck")], ids=["console", "module"])
def test_the_command_checks(project: Path, command: tuple[str, ...]) -> None:
    if not Path(command[0]).exists():
        pytest.skip("the console command is not installed beside this Python")
    done = run(project, *command, "x.csp")

    assert (done.returncode, done.stderr) == (0, "")
    assert "1 pass" in done.stdout


def test_every_message_is_found(project: Path) -> None:
    done = run(project, sys.executable, "-m", "cspcheck", "explain", "CSP801")

    assert done.returncode == 0, done.stderr


def test_pytest_collects_scripts_and_has_the_fixture(project: Path) -> None:
    done = run(project, sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "x.csp", "test_x.py")

    assert done.returncode == 0, done.stdout
    assert "2 passed" in done.stdout


def test_a_generated_program_runs(project: Path) -> None:
    made = run(project, sys.executable, "-m", "cspcheck", "gen", "x.csp", "--process", "System", "-o", "program")
    assert made.returncode == 0, made.stderr

    done = run(project, sys.executable, "program/main.py", "--events", "10")
    assert done.returncode == 0, done.stderr
