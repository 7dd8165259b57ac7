"""Monitors say what following a run says, event by event, in every language."""

from __future__ import annotations

import random
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

import cspcheck
from cspcheck.cli import front_door
from cspcheck.following import Follower

SCRIPT = """
channel put, get : {0..2}
channel other
Buffer(s) = #s < 2 & put?x -> Buffer(s^<x>) [] #s > 0 & get!head(s) -> Buffer(tail(s))
Either = put?x -> (get!x -> Either |~| put?y -> get!y -> Either)
"""


def monitored(folder: Path, process: str, target: str, text: str = SCRIPT) -> str:
    """Write the monitor of a process; what the command says."""
    (folder / "spec.csp").write_text(text, encoding="utf-8")
    arguments = ["monitor", str(folder / "spec.csp"), "--process", process, "--target", target, "-o", str(folder)]
    said = CliRunner().invoke(front_door, arguments)
    assert said.exit_code == 0, said.output
    return said.output


def runs(process: str) -> list[list[str]]:
    """Runs that keep to a process for a while, and leave it."""
    script = cspcheck.loads(SCRIPT)._script
    choose = random.Random(7)
    found = []
    for _ in range(40):
        follower = Follower(script, script.process(process))
        events: list[str] = []
        for _ in range(choose.randrange(25)):
            event = choose.choice(follower.allowed())
            assert follower.step(event) is None
            events.append(event)
        events.append(choose.choice([f"{name}.{i}" for name in ("put", "get") for i in range(3)]))
        found.append(events)
    return found


def departure(process: str, events: list[str]) -> tuple[int, tuple[str, ...]] | None:
    """Where following leaves the process, and what was allowed there."""
    script = cspcheck.loads(SCRIPT)._script
    follower = Follower(script, script.process(process))
    for i, event in enumerate(events):
        departed = follower.step(event)
        if departed is not None:
            return i, departed.allowed
    return None


@pytest.mark.parametrize("process", ["Buffer(<>)", "Either"])
def test_python_says_what_following_says(process: str, tmp_path: Path) -> None:
    assert "states, 6 events" in monitored(tmp_path, process, "python")
    namespace: dict[str, Any] = {}
    exec((tmp_path / "monitor.py").read_text(), namespace)
    make: Callable[[], Any] = namespace["Monitor"]
    for events in runs(process):
        monitor = make()
        steps = [monitor.step(event) for event in events]
        expected = departure(process, events)
        if expected is None:
            assert all(steps)
            assert monitor.explain() == ""
        else:
            place, allowed = expected
            assert steps == [i < place for i in range(len(events))]
            assert tuple(monitor.allowed()) == allowed
            assert f"event {place + 1}, `{events[place]}`, is not allowed there" in monitor.explain()
    assert make().step("other")


DRIVER = r"""
#include <stdio.h>
#include <string.h>
#include "monitor.h"
int main(void) {
    char line[256], text[512];
    monitor_t monitor;
    _Static_assert(sizeof(monitor_t) == 28, "what the command says");
    monitor_reset(&monitor);
    while (fgets(line, sizeof line, stdin) != NULL) {
        line[strcspn(line, "\n")] = '\0';
        if (line[0] == '\0') {
            (void)monitor_explain(&monitor, text, sizeof text);
            (void)printf("%lu|%s\n", (unsigned long)monitor.count, monitor.departed == MONITOR_UNKNOWN ? "" : text);
            monitor_reset(&monitor);
        } else {
            (void)monitor_step(&monitor, monitor_event(line));
        }
    }
    return 0;
}
"""


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler here")
def test_c_says_what_following_says(tmp_path: Path) -> None:
    assert "a monitor takes 28 bytes, its constant tables " in monitored(tmp_path, "Either", "c")
    (tmp_path / "driver.c").write_text(DRIVER)
    flags = ["-std=c11", "-O1", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-pedantic"]
    done = subprocess.run(
        ["cc", *flags, "monitor.c", "driver.c", "-o", "driver"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    all_runs = runs("Either")
    given = "".join("\n".join([*events, "other"]) + "\n\n" for events in all_runs)
    said = subprocess.run(["./driver"], cwd=tmp_path, input=given, capture_output=True, text=True, check=True).stdout
    answers = re.findall(r"^(\d+)\|((?:.|\n  )*)$", said, re.MULTILINE)
    assert len(answers) == len(all_runs)
    for events, (count, text) in zip(all_runs, answers, strict=True):
        expected = departure("Either", events)
        assert int(count) == (len(events) if expected is None else expected[0])
        if expected is not None:
            assert text.startswith(f"event {expected[0] + 1}, `{events[expected[0]]}`, is not allowed there\n")
            assert f"allowed     {', '.join(expected[1]) or 'nothing'}" in text


def test_a_process_without_end_is_refused(tmp_path: Path) -> None:
    (tmp_path / "spec.csp").write_text("channel a\nP(n) = a -> (if n == 0 then STOP else P(n + 1))\n")
    arguments = ["monitor", str(tmp_path / "spec.csp"), "--process", "P(1)", "-o", str(tmp_path), "--max-states", "50"]
    said = CliRunner().invoke(front_door, arguments)
    assert isinstance(said.exception, cspcheck.ScriptError)
    assert "CSP825: `P(1)` has more than 50 states" in str(said.exception)


@pytest.mark.parametrize("target", ["python", "c"])
def test_a_process_that_shows_nothing_is_refused(target: str, tmp_path: Path) -> None:
    (tmp_path / "spec.csp").write_text("channel a\nP = a -> P\nHIDDEN = P \\ {a}\n")
    arguments = ["monitor", str(tmp_path / "spec.csp"), "--process", "HIDDEN", "--target", target, "-o", str(tmp_path)]
    said = CliRunner().invoke(front_door, arguments)
    assert "CSP826: `HIDDEN` performs nothing that can be seen" in str(said.exception)


DRIVING = """
datatype Mode = AUTOWARE | MANUAL | EMERGENCY
datatype Source = Autoware | Joystick
channel enter : Mode
channel drive : Source
Drives(source) = drive!source -> Drives(source) [] enter?mode -> Drives(source)
"""
LOGS = {
    "log": (
        'format = "log"\n[[event]]\nmatch = "drove by (?P<who>[a-z]+)"\nevent = "drive.{who}"\n'
        '[[event]]\nmatch = "now (?P<mode>[A-Z]+)"\nevent = "enter.{mode}"\n[values]\nauto = "Autoware"\n',
        "boot\n12 drove by auto\n13 something else\n14 now EMERGENCY\n",
    ),
    "csv": (
        'format = "csv"\ntime = "t"\n[[event]]\nwhen = { topic = "/cmd" }\nevent = "drive.{value}"\n'
        '[[event]]\nwhen = { topic = "/mode" }\nevent = "enter.{value}"\n',
        "t,topic,value\n0.5,/cmd,Autoware\n0.6,/odometry,3\n0.7,/mode,EMERGENCY\n",
    ),
    "json": (
        'format = "json"\n[[event]]\nwhen = { topic = "/cmd", "msg.valid" = "true" }\nevent = "drive.{msg.source}"\n'
        '[[event]]\nwhen = { topic = "/mode" }\nevent = "enter.{msg}"\n',
        '{"topic": "/cmd", "msg": {"source": "Autoware", "valid": true}}\n'
        '{"topic": "/cmd", "msg": {"source": "Joystick", "valid": false}}\n{"topic": "/mode", "msg": "EMERGENCY"}\n',
    ),
}


@pytest.mark.parametrize("form", LOGS)
def test_logs_are_read_by_a_pattern(form: str, tmp_path: Path) -> None:
    pattern, log = LOGS[form]
    (tmp_path / "pattern.toml").write_text(pattern)
    (tmp_path / "run").write_text(log)
    script = str(tmp_path / "spec.csp")
    Path(script).write_text(DRIVING)

    def trace(process: str) -> tuple[int, str]:
        arguments = ["trace", script, str(tmp_path / "run"), "--process", process]
        said = CliRunner().invoke(front_door, [*arguments, "--pattern", str(tmp_path / "pattern.toml")])
        return said.exit_code, said.output

    assert trace("Drives(Autoware)")[0] == 0
    code, said = trace("Drives(Joystick)")
    assert code == 1
    assert "`drive.Autoware`, is not allowed there" in said


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("format = ", "it is no TOML"),
        ('format = "xml"\n', "`format` is one of log, csv, json"),
        ('format = "log"\n', "it has no `[[event]]`"),
        ('[[event]]\nmatch = "(a"\nevent = "a"\n', "is no regular expression"),
        ('[[event]]\nmatch = "a"\n', "has no text `event`"),
        ('[[event]]\nevent = "a"\nmatches = "a"\n', "and nothing else"),
    ],
)
def test_a_wrong_pattern_file_is_told(text: str, why: str, tmp_path: Path) -> None:
    (tmp_path / "pattern.toml").write_text(text)
    (tmp_path / "run").write_text("a\n")
    (tmp_path / "spec.csp").write_text("channel a\nP = a -> P\n")
    arguments = ["trace", str(tmp_path / "spec.csp"), str(tmp_path / "run"), "--process", "P"]
    said = CliRunner().invoke(front_door, [*arguments, "--pattern", str(tmp_path / "pattern.toml")])
    assert said.exit_code == 2
    assert "CSP824" in said.output
    assert why in " ".join(said.output.split())
