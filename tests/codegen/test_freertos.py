"""Programs in C for FreeRTOS: they compile without a warning, and every run of them is a trace of the script."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st

import cspcheck
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.codegen import quoting
from cspcheck.codegen.design.system import system
from cspcheck.codegen.emit import freertos
from cspcheck.codegen.emit.keeping import write
from cspcheck.following import Follower
from cspcheck.runs import RunVerdict, follow, read_records
from tests.codegen.programs import SPECS
from tests.examples import examples

API = Path(__file__).parent / "freertos_api"
COMPILER = shutil.which("cc")
CROSS = shutil.which("arm-none-eabi-gcc")
hosted = pytest.mark.skipif(COMPILER is None or shutil.which("make") is None, reason="there is no C compiler here")

EXAMPLES = (
    ("classics/token_ring.csp", "Ring"),
    ("freertps/freertps.csp", "Proposed(Drop, Drop, {})"),
    ("microautoware/microautoware.csp", "Repaired(SIGNALS)"),
    ("rov/annex_b.csp", "Architecture"),
)


def generate(script: cspcheck.Script, process: str, folder: Path) -> None:
    """Write the program of a process."""
    write(freertos.project(system(script._script, process, Semantics(), "policy"), str(folder)), folder)


def built(folder: Path) -> None:
    """Compile a program for this machine."""
    done = subprocess.run(["make", "-s", "host"], cwd=folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def run(folder: Path, events: int, seed: int = 1) -> tuple[int, str]:
    """Run a program and record it; the exit code and what it says."""
    command = ["./host", "--events", str(events), "--seed", str(seed), "--record", "run.jsonl"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stderr.strip()


def followed(script: cspcheck.Script, process: str, folder: Path, inside: bool = False) -> RunVerdict:
    """What the specification says of the recorded run."""
    follower = Follower(script._script, script._script.process(process), hidden=inside)
    with open(folder / "run.jsonl", encoding="utf-8") as lines:
        return follow(follower, read_records(lines, "run.jsonl"))


@hosted
@pytest.mark.parametrize(("name", "process"), EXAMPLES, ids=[process for _, process in EXAMPLES])
def test_runs_are_traces_of_the_script(name: str, process: str, tmp_path: Path) -> None:
    """A longer run of all exhibits is ``python tests/benchmarks/bench_conformance.py 1000000 freertos``."""
    script = cspcheck.load(SPECS / name)
    generate(script, process, tmp_path)
    built(tmp_path)
    assert run(tmp_path, 2_000) == (0, "2000 events; stopped")
    for inside in (False, True):
        verdict = followed(script, process, tmp_path, inside)
        assert verdict.departure is None, verdict.departure
        assert verdict.events == 2_000


METHODS = """
datatype Colour = red | green
channel read : {0..9}
channel show : Colour.{0..9}
channel c : {0..9}
channel done
Sensor = read?x -> c!x -> Sensor
Lamp = c?x -> show!(if x > 4 then red else green)!x -> Lamp
SYSTEM = Sensor [| {| c |} |] Lamp
"""


@hosted
def test_methods_are_called_with_values_and_held_to_them(tmp_path: Path) -> None:
    script = cspcheck.loads(METHODS)
    generate(script, "SYSTEM", tmp_path)
    methods = tmp_path / "methods.c"
    text = methods.read_text()
    assert "int32_t sensor_read(int32_t any)" in text
    assert "void lamp_show(type_1_t field_1, int32_t field_2)" in text
    methods.write_text(text.replace("return any;", "static int32_t n; (void)any; n = (n + 3) % 10; return n;"))
    built(tmp_path)
    assert run(tmp_path, 30)[0] == 0
    verdict = followed(script, "SYSTEM", tmp_path)
    assert verdict.departure is None
    events = re.findall(r'"read\.(\d)"', (tmp_path / "run.jsonl").read_text())
    assert events[:4] == ["3", "6", "9", "2"]
    methods.write_text(text.replace("return any;", "(void)any; return 10;"))
    built(tmp_path)
    code, said = run(tmp_path, 30)
    assert (code, said.partition(": ")[2]) == (3, "(field_1 >= 0) && (field_1 <= 9) does not hold")


@hosted
def test_deadlock_termination_and_time(tmp_path: Path) -> None:
    generate(cspcheck.load(SPECS / "classics" / "election.csp"), "Election", tmp_path / "stuck")
    built(tmp_path / "stuck")
    assert run(tmp_path / "stuck", 100) == (1, "7 events; deadlock: every task waits for ever")
    ends = cspcheck.loads("channel a, b\nP = a -> b -> SKIP\nQ = b -> SKIP\nSYSTEM = P [| {b} |] Q\n")
    generate(ends, "SYSTEM", tmp_path / "ends")
    built(tmp_path / "ends")
    assert run(tmp_path / "ends", 100) == (0, "2 events; all tasks have ended")
    assert followed(ends, "SYSTEM", tmp_path / "ends").departure is None


@pytest.mark.skipif(CROSS is None, reason="arm-none-eabi-gcc is not here: apt-get install gcc-arm-none-eabi")
def test_a_program_compiles_for_a_microcontroller(tmp_path: Path) -> None:
    assert CROSS is not None
    generate(cspcheck.load(SPECS / "microautoware" / "microautoware.csp"), "Repaired(SIGNALS)", tmp_path)
    flags = ["-std=c11", "-Os", "-mcpu=cortex-m4", "-mthumb", "-Wall", "-Wextra", "-Wconversion", "-Werror"]
    sources = ["csp.c", "program.c", "methods.c", "main.c"]
    command = [CROSS, *flags, "-I.", f"-I{API}", "-c", *sources]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    undefined = subprocess.run(
        ["arm-none-eabi-nm", "-u", "csp.o", "program.o"], cwd=tmp_path, capture_output=True, text=True, check=True
    ).stdout
    # Static memory only: nothing is asked for when the program runs.
    assert not re.search(r"\b(malloc|calloc|free|pvPortMalloc|xTaskCreate)\b", undefined)


hostile = st.text(alphabet=st.sampled_from('"\\*/?\n\r\té\u2028%{}()#ab\x00'), min_size=1, max_size=8)


@settings(max_examples=examples(100))
@given(hostile)
def test_texts_stay_texts_in_c(text: str) -> None:
    literal = quoting.c_text(text)
    assert re.fullmatch(r'"(?:[ -!#->@-\[\]-~]|\\[0-7]{3})*"', literal)
    octal = re.sub(r"\\([0-7]{3})", lambda match: chr(int(match[1], 8)), literal[1:-1])
    assert octal.encode("latin-1").decode("utf-8") == text
    comment = quoting.c_comment(text)
    assert "*/" not in comment
    assert "\n" not in comment
    assert re.fullmatch(r"[A-Za-z_]\w*", quoting.c_name(text), re.ASCII)


@hosted
def test_hostile_names_compile(tmp_path: Path) -> None:
    script = cspcheck.loads(
        "channel int, while, main : {0..1}\nP(t) = int?x -> while!x -> main.x -> P(t)  -- */ #error ??/\n"
        "Q = int?x -> Q\n"
        'SYSTEM = P("*/ \\" \\\\ ??/") [| {| int |} |] Q\n',
        name='*/ "\n#error',
    )
    generate(script, "SYSTEM", tmp_path)
    built(tmp_path)
    assert run(tmp_path, 20)[0] == 0
    assert followed(script, "SYSTEM", tmp_path).departure is None


@hosted
def test_the_commands_of_the_page_do_what_it_says(tmp_path: Path) -> None:
    root = SPECS.parent
    page = (root / "docs" / "targets.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```\n(cspcheck gen [^`]*--target freertos.*?)```", page, re.DOTALL)
    shown, (refused, *said) = "".join(blocks[:2]), blocks[2].splitlines()
    (tmp_path / "specs").symlink_to(SPECS)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        f"set -e\n{shown}set +e\n{refused}",
        shell=True, cwd=tmp_path, capture_output=True, text=True, env={**os.environ, "PATH": path},
    )  # fmt: skip
    assert "run.jsonl is a trace of `Repaired(SIGNALS)`: 3,000 events" in done.stdout
    assert (tmp_path / "program" / "program.c").exists()
    assert done.returncode == 2
    assert " ".join(said) in " ".join(done.stderr.split())
