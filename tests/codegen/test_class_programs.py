"""The classes of the vehicle as programs: with their data, in Python, in C and in Ada."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import cspcheck
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.codegen.design.system import system
from cspcheck.codegen.emit import ada, freertos
from cspcheck.codegen.runtime import CannotList, Program, VirtualClock
from tests.codegen.programs import SPECS, followed, generate, loaded

READINGS = """
include "classes.csp"
reading real = {0, 1/2}
reading nat = {1, 100, 101, 201, 1000, 1001}
reading MESSAGE = 2
const
  stopped, ahead : ControlData
  clear, near : SONAR_TYPE
where
  stopped = (| vx == 0, vy == 0, vz == 0, vTheta == 0 |)
  ahead = (| vx == 1/2, vy == 0, vz == 0, vTheta == 0 |)
  clear = <0, 0, 0, 0>
  near = <0, 1/2, 0, 0>
end
reading ControlData = {stopped, ahead}
reading SONAR_TYPE = {clear, near}
"""


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> cspcheck.Script:
    folder = tmp_path_factory.mktemp("classes")
    shutil.copy(SPECS / "rov" / "classes.csp", folder)
    (folder / "programs.csp").write_text(READINGS, encoding="utf-8")
    return cspcheck.load(folder / "programs.csp")


@pytest.mark.parametrize(
    ("process", "stops"),
    [("BaseReader", False), ("Remote", False), ("S2", False), ("Move", True), ("Sensor", True), ("BlackBoard", False)],
)
def test_a_class_generates_runs_and_conforms(
    process: str, stops: bool, script: cspcheck.Script, tmp_path: Path
) -> None:
    """Where a clock is counted up, the program stops where the reading of the numbers ends."""
    generate(script, process, tmp_path, "policy")
    count, deadlocked = followed(script, process, tmp_path, 60, seed=1)
    assert (count >= 60) or stops
    assert deadlocked == stops
    made = system(script._script, process, Semantics(), "policy")
    assert "program.c" in freertos.project(made, "program").generated
    assert "tables.ads" in ada.project(made, "program", script._script).generated


def test_what_only_the_world_knows_has_to_be_written(script: cspcheck.Script, tmp_path: Path) -> None:
    generate(script, "Compass", tmp_path, "policy")
    with (
        loaded(tmp_path) as main,
        pytest.raises(
            CannotList, match=r"direction cannot be listed.*; the method of Compass::getDirection has to give them"
        ),
    ):
        Program(main.tasks()).run("loop", clock=VirtualClock(), events=10)
