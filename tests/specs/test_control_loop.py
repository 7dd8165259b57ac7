"""The vehicle's control loop as a generated program, over sockets, against a base station and a vehicle."""

from __future__ import annotations

import importlib
import json
import shutil
import threading
from pathlib import Path

from click.testing import CliRunner

import cspcheck
from cspcheck.cli import front_door
from cspcheck.codegen.runtime import JsonLines, Program
from tests.codegen.programs import generate, loaded

SCRIPT = Path(__file__).resolve().parents[2] / "specs" / "rov" / "control_loop.csp"
SMALL = SCRIPT.with_name("control_search.csp")
"""The same with readings in which the speeds that are sent here occur; quicker to follow."""
METHODS = Path(__file__).parent / "control_loop"


def test_the_loop_stops_the_vehicle_at_obstacles_and_in_silence_and_keeps_to_its_specification(tmp_path: Path) -> None:
    script = cspcheck.load(SCRIPT)
    generate(script, "Loop", tmp_path)
    for file in METHODS.glob("*.py"):
        shutil.copy(file, tmp_path)
    run = tmp_path / "run.jsonl"
    with loaded(tmp_path) as main:
        program = Program(main.tasks())
        world = importlib.import_module(f"{main.__package__}.link").world
        ended = threading.Event()
        threading.Thread(target=lambda: (ended.wait(), world.closed.set(), program.stop()), daemon=True).start()
        world.start(ended)
        try:
            summary = program.run(recorder=JsonLines(run), seconds=120)
        finally:
            ended.set()
            world.close()

    assert summary.lingering == ()
    scenes = [scene for scene, _ in world.seen]
    assert list(dict.fromkeys(scenes)) == ["ahead", "obstacle", "clear", "silent"]
    last = dict(world.seen)
    assert last == {"ahead": 100, "obstacle": 0, "clear": 100, "silent": 0}
    assert {torque for _, torque in world.seen} == {0, 100}

    # Methods are told too: the process is taken with them shown.
    shown = tmp_path / "shown.jsonl"
    records = [json.loads(line) for line in run.read_text().splitlines()]
    shown.write_text("".join(json.dumps({"event": r["event"], "tasks": r["tasks"]}) + "\n" for r in records))
    said = CliRunner().invoke(front_door, ["trace", str(SMALL), str(shown), "--process", "Inside"])
    assert said.exit_code == 0, said.output
    assert "Remote::skipMessage" in {record["event"] for record in records}


def test_a_run_that_passes_on_a_bad_message_is_no_run_of_the_specification(tmp_path: Path) -> None:
    run = tmp_path / "run.jsonl"
    run.write_text('{"event": "reception"}\n{"event": "s1_move.100"}\n')
    said = CliRunner().invoke(front_door, ["trace", str(SMALL), str(run), "--process", "Loop"])
    assert said.exit_code == 1
    assert "`s1_move.100`, is not allowed there" in said.output
