"""A program is all that there is to install: it runs where this project is not, and beside whatever lies around."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import cspcheck
from tests.codegen.programs import SPECS, generate

SCRIPT = """
datatype Colour = red | green
channel paint : Colour
channel turn : {0..2}
channel done
Painter(c) = paint!c -> turn?n -> Painter(if n == 0 then red else c)
Wall = paint?c -> done -> Wall
SYSTEM = Painter(green) [| {| paint |} |] Wall
"""


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Python without anything that was installed, in a folder."""
    command = [sys.executable, "-S", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, env={"PATH": ""}, check=False)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with two programs, one of them with a name that is no name of Python."""
    script = cspcheck.loads(SCRIPT)
    generate(script, "SYSTEM", tmp_path / "one")
    generate(script, "SYSTEM", tmp_path / "the-other.program")
    return tmp_path


def test_a_program_needs_nothing_but_the_standard_library(folder: Path) -> None:
    for name in ("one", "the-other.program"):
        done = run(folder, f"{name}/main.py", "--events", "20", "--record", "run.jsonl", "--clock", "virtual")
        assert done.returncode == 0, done.stderr
        assert len((folder / "run.jsonl").read_text().splitlines()) == 20
    code = "import sys, one.main; print(*sorted({name.partition('.')[0] for name in sys.modules}))"
    modules = set(run(folder, "-c", code).stdout.split())
    assert {name for name in modules if name not in sys.stdlib_module_names} == {"one", "__main__"}


def test_two_programs_are_two_packages(folder: Path) -> None:
    generate(cspcheck.load(SPECS / "classics" / "milner.csp"), "Scheduler", folder / "two")
    code = (
        "import one.main, two.main\n"
        "for program in (one, two):\n"
        "    print(program.runtime.Program(program.main.tasks()).run('loop', events=5).events)\n"
    )
    assert run(folder, "-c", code).stdout == "5\n5\n"


def test_neighbours_do_not_get_in_the_way(folder: Path) -> None:
    for name in ("checker.py", "cspm.py", "queue.py", "json.py", "runtime.py", "channels.py", "_program.py"):
        (folder / name).write_text("raise SystemExit('the neighbour was imported')\n")
    for name in ("codegen", "cspcheck", "asyncio"):
        (folder / name).mkdir()
        (folder / name / "__init__.py").write_text("raise SystemExit('the neighbour was imported')\n")
    done = run(folder, "one/main.py", "--events", "5", "--runner", "asyncio")
    assert (done.returncode, done.stderr.split(" in ")[0]) == (0, "5 events")


def test_a_program_says_at_its_start_that_its_methods_do_not_fit(folder: Path) -> None:
    methods = folder / "one" / "painter_methods.py"
    text = methods.read_text()
    methods.write_text(
        text.replace("def turn(self)", "def turn(self, speed)") + "\n    def honk(self):\n        pass\n"
    )
    done = run(folder, "one/main.py", "--events", "5")
    assert (done.returncode, done.stderr.splitlines()) == (
        1,
        [
            "Painter(green): its methods in painter_methods.py do not fit the specification any more",
            "  `turn(self, speed)` is written, and should be `turn(self)`",
            "  `honk` is no method of it any more",
            "  change them there; `cspcheck gen` shows how they should look",
        ],
    )
