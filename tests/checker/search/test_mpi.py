"""The same with processes that ``mpiexec`` starts; skipped where there is none."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

import pytest

from tests.checker.search.test_spill import SCRIPT

ROOT = Path(__file__).parents[3]


def mpiexec() -> list[str]:
    """The command that starts processes, with as many as are asked for on few processors."""
    pytest.importorskip("mpi4py", reason="mpi4py is not installed")
    beside = Path(sys.executable).parent / "mpiexec"
    found = str(beside) if beside.exists() else shutil.which("mpiexec")
    if found is None:
        pytest.skip("there is no mpiexec")
    told = subprocess.run([found, "--version"], capture_output=True, text=True, check=False).stdout
    if "Open MPI" not in told and "OpenRTE" not in told:
        return [found]
    return [found, "--allow-run-as-root", "--oversubscribe", "--mca", "mpi_yield_when_idle", "1"]


def run(ranks: int, *arguments: str, expected: int | None = None) -> str:
    command = [*mpiexec(), "-n", str(ranks), sys.executable, *arguments]
    place = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, capture_output=True, text=True, timeout=400, env=place, check=False)
    if expected is None:
        assert done.returncode != 0
    else:
        assert done.returncode == expected, done.stderr
    return done.stdout


def answers(text: str) -> list[dict[str, Any]]:
    """What a run says of each assertion, without what depends on the machine."""
    found = json.loads(text)["results"]
    return [{k: v for k, v in one.items() if k not in ("seconds", "peak_memory_bytes")} for one in found]


@pytest.mark.parametrize("ranks", [2, 4])
def test_a_check_says_what_one_process_says(ranks: int, tmp_path: Path) -> None:
    script = tmp_path / "s.csp"
    script.write_text(SCRIPT)
    check = ["-m", "cspcheck", "check", str(script), "--as-written", "--format", "json", "--workers", "1"]
    alone = subprocess.run([sys.executable, *check], capture_output=True, text=True, check=False, cwd=ROOT)
    assert alone.returncode == 1, alone.stderr
    assert answers(run(ranks, *check, "--cluster", expected=1)) == answers(alone.stdout)


PROGRAM = textwrap.dedent(
    """
    import os, signal, sys
    from pathlib import Path
    from cspcheck.checker.packing.packed import pack
    from cspcheck.checker.search.checkpoint import Checkpoints
    from cspcheck.checker.search import cluster
    from cspcheck.checker.search.exploration import explore
    from tests.checker.vehicle import cycle, synchronised

    folder, resume, lost, after = Path(sys.argv[1]), sys.argv[2] == "resume", int(sys.argv[3]), int(sys.argv[4])
    world = cluster.world()
    finish, levels = cluster.SharedSearch._finish_level, 0

    def dying(search, *rest):
        global levels
        levels += 1
        if world.ranks.rank == lost and levels > after:
            os.kill(os.getpid(), signal.SIGKILL)
        finish(search, *rest)

    cluster.SharedSearch._finish_level = dying
    if world.ranks.rank:
        world.serve()
    else:
        packed = pack(synchronised({f"P{i}": cycle(f"a{i}", f"b{i}", f"c{i}") for i in range(7)}))
        places = Checkpoints(folder, {"version": "1"}, resume=resume, every=0.0)
        found = explore(packed, compiled=False, beyond=world, checkpoints=places)
        print("levels", levels, found.levels[-1], found.transitions, found.complete)
        world.dismiss()
    """
)


@pytest.mark.parametrize(("before", "after"), [(2, 1), (2, 4), (4, 2)])
def test_a_process_that_is_lost_costs_what_came_after_the_last_checkpoint(
    before: int, after: int, tmp_path: Path
) -> None:
    program, folder = tmp_path / "p.py", str(tmp_path / "c")
    program.write_text(PROGRAM)
    assert "levels" not in run(before, str(program), folder, "begin", str(before - 1), "6")
    said = run(after, str(program), folder, "resume", "-1", "0", expected=0)
    # Fifteen levels, of which six were done.
    assert said.split() == ["levels", "9", "2187", "15309", "True"]


def test_without_mpi_it_says_what_to_install(tmp_path: Path) -> None:
    script = tmp_path / "s.csp"
    script.write_text("assert STOP [T= STOP\n")
    (tmp_path / "mpi4py").mkdir()
    (tmp_path / "mpi4py" / "__init__.py").write_text("raise ImportError('no MPI here')\n")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])}
    command = [sys.executable, "-m", "cspcheck", "check", "--cluster", str(script)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 2
    assert "pip install 'cspcheck[cluster]'" in done.stderr
