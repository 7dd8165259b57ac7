"""README.md shows what is so: its commands are run, and what they print is what stands there, times apart."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS: list[tuple[str, str]] = re.findall(r"^```(\w*)\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)
SMALL = "specs/producer_consumer/"
"""Stands for all of specs/ where a command would check them all."""


def shown(text: str) -> list[str]:
    """The lines of what is printed, with times and the width of gaps out of the way."""
    lines = (re.sub(r"(\d+ min )?\d+(\.\d+)? s\b", "", line) for line in text.strip().splitlines())
    return [" ".join(line.split()) for line in lines]


def stands_in(excerpt: list[str], whole: list[str]) -> bool:
    """Whether some lines stand one after the other in others."""
    return any(whole[i : i + len(excerpt)] == excerpt for i in range(len(whole) - len(excerpt) + 1))


def run(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a command line of the page in a folder that has specs/, with this Python's cspcheck, python and pytest."""
    words = shlex.split(command, comments=True)
    start = {"cspcheck": ["-m", "cspcheck"], "python": [], "pytest": ["-m", "pytest"]}[Path(words[0]).name]
    return subprocess.run(
        [sys.executable, *start, *words[1:]],
        cwd=folder,
        env={**os.environ, "COLUMNS": "80", "PYTHONIOENCODING": "utf-8", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        encoding="utf-8",
        check=False,
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("readme")
    (place / "specs").symlink_to(ROOT / "specs")
    return place


def consoles() -> list[tuple[str, str]]:
    """Commands behind ``$`` with what is printed below them."""
    found = []
    for _, text in BLOCKS:
        for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
            command, _, output = part.partition("\n")
            found.append((command, output))
    return found


def test_the_console_blocks(folder: Path) -> None:
    commands = consoles()
    assert len(commands) >= 5
    for command, output in commands:
        done = run(command, folder)
        assert stands_in(shown(output), shown(done.stdout + done.stderr)), f"{command}\n{done.stdout}{done.stderr}"


def test_the_main_job(folder: Path) -> None:
    places = [i for i, (_, text) in enumerate(BLOCKS) if "pip install . &&" in text]
    (place,) = places
    command = BLOCKS[place][1].split("&&")[-1].strip()

    assert stands_in(shown(BLOCKS[place + 1][1]), shown(run(command, folder).stdout))


def test_the_test_command_is_that_of_the_build() -> None:
    build = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    (command,) = [text.strip() for _, text in BLOCKS if "-m tests" in text]

    assert command.split("&&")[-1].strip() in build
    assert "pip install" in build
    assert "-e '.[dev]'" in build
    assert "-e '.[dev]'" in command


def test_the_commands_of_a_build(folder: Path) -> None:
    lines = [
        line for _, text in BLOCKS for line in text.splitlines() if re.match(r"(cspcheck|pytest) specs/ ", f"{line} ")
    ]

    assert len(lines) >= 3
    for line in lines:
        done = run(line.replace("specs/", SMALL, 1), folder)
        assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"


def test_the_python_snippets(folder: Path) -> None:
    program = folder / "program"
    generated = "".join(path.read_text(encoding="utf-8") for path in program.rglob("*.py")) if program.is_dir() else ""
    for _, text in [block for block in BLOCKS if block[0] == "python"]:
        if text.startswith("import"):
            done = subprocess.run(
                [sys.executable, "-c", text], cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False
            )
            assert done.returncode == 0
        elif generated:  # an excerpt of the program that the page generates
            assert text.strip("\n") in generated
