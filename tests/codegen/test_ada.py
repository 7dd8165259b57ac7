"""Programs in Ada: they compile without a warning, every run is a trace of the script, contracts hold the data."""

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
from cspcheck.codegen.design.links import links
from cspcheck.codegen.design.system import system
from cspcheck.codegen.emit import ada
from cspcheck.codegen.emit.ada_methods import tidy
from cspcheck.codegen.emit.keeping import write
from cspcheck.following import Follower
from cspcheck.runs import RunVerdict, follow, read_records
from tests.codegen.programs import SPECS
from tests.examples import examples

hosted = pytest.mark.skipif(
    shutil.which("gnatmake") is None or shutil.which("make") is None,
    reason="gnat is not here: apt-get install gnat make",
)
FLAGS = "-gnat2012 -gnata -gnatwa -O0"


def generate(script: cspcheck.Script, process: str, folder: Path) -> None:
    """Write the program of a process."""
    made = system(script._script, process, Semantics(), "policy")
    write(ada.project(made, str(folder), script._script), folder)


def built(folder: Path, target: str = "host") -> None:
    """Compile a program; the compiler has nothing to say."""
    done = subprocess.run(
        ["make", "-s", target, f"FLAGS={FLAGS}"], cwd=folder, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def run(folder: Path, events: int, seed: int = 1) -> tuple[int, str]:
    """Run a program and record it; the exit code and what it says."""
    with open(folder / "run.jsonl", "w", encoding="utf-8") as record:
        done = subprocess.run(
            ["./host", str(events), str(seed)],
            cwd=folder,
            stdout=record,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            timeout=120,
        )
    return done.returncode, done.stderr.strip()


def followed(script: cspcheck.Script, process: str, folder: Path) -> RunVerdict:
    """What the specification says of the recorded run, the events that the program hides among them."""
    follower = Follower(script._script, script._script.process(process), hidden=True)
    with open(folder / "run.jsonl", encoding="utf-8") as lines:
        return follow(follower, read_records(lines, "run.jsonl"))


@hosted
def test_the_data_of_classes_is_held_to_contracts(tmp_path: Path) -> None:
    script = cspcheck.load(SPECS / "producer_consumer" / "classes.csp")
    generate(script, "SYSTEM", tmp_path)
    types, spec = ((tmp_path / f"{name}.ads").read_text() for name in ("data_types", "producer_data"))
    assert "subtype DATA is Integer range 0 .. 10;" in types
    assert "with Dynamic_Predicate => Invariant (State.myData);" in spec
    assert "with Pre  => Can_produceData (Self)," in spec
    assert re.search(r"Post => \(\(Self'Old\.myData = 10\) and then \(Self\.myData = 0\)\)\s+or\s+else", spec)
    built(tmp_path)
    assert run(tmp_path, 300) == (0, "300 events; stopped")
    verdict = followed(script, "SYSTEM", tmp_path)
    assert (verdict.departure, verdict.events) == (None, 300)
    # A body that does something else is caught by its contract in the first round.
    body = tmp_path / "producer_data.adb"
    body.write_text(body.read_text().replace("myData => (Self.myData + 1)", "myData => Self.myData"))
    # For gnatmake a file that is at most two seconds newer has not changed.
    for old in (tmp_path / "desk" / "objects").glob("producer_data.*"):
        old.unlink()
    built(tmp_path)
    code, said = run(tmp_path, 300)
    assert (code, said.splitlines()[0]) == (1, "task 0 has failed: ADA.ASSERTIONS.ASSERTION_ERROR")


METHODS = """
datatype Colour = red | green
channel read : {0..9}
channel show : Colour.{0..9}
channel c : {0..9}
channel other
Sensor = read?x -> c!x -> Sensor
Lamp = c?x -> show!(if x > 4 then red else green)!x -> Lamp
Ends = other -> SKIP
SYSTEM = (Sensor [| {| c |} |] Lamp) ||| Ends
"""


@hosted
def test_methods_are_called_with_values_and_held_to_them(tmp_path: Path) -> None:
    script = cspcheck.loads(METHODS)
    generate(script, "SYSTEM", tmp_path)
    methods = tmp_path / "methods.adb"
    text = methods.read_text()
    head = "procedure Sensor_read (Field_1 : in out Type_0) is"
    assert head in text
    assert "procedure Lamp_show (Field_1 : Type_1; Field_2 : Type_0) is null;" in text
    methods.write_text(
        text.replace(
            f"{head} null;", f"{head}\n   begin\n      Field_1 := (Field_1 + 3) mod 8 + 4;\n   end Sensor_read;"
        )
    )
    built(tmp_path)
    code, said = run(tmp_path, 3_000)
    verdict = followed(script, "SYSTEM", tmp_path)
    assert verdict.departure is None
    values = set(re.findall(r'"read\.(\d)"', (tmp_path / "run.jsonl").read_text()))
    assert values
    assert values <= set("456789")
    # In the end the method gives 10 or 11, which its type does not have.
    assert (code, said.splitlines()[0]) == (1, "task 0 has failed: CONSTRAINT_ERROR")


@hosted
def test_deadlock_and_termination(tmp_path: Path) -> None:
    ends = cspcheck.loads(
        "channel a, b, c\nP = a -> b -> SKIP\nQ = b -> SKIP\nSYSTEM = P [| {b} |] Q\n"
        "R = a -> c -> R\nS = c -> b -> STOP\nSTUCK = R [| {c} |] S\n"
    )
    for process, said in (
        ("SYSTEM", "2 events; all tasks have ended"),
        ("STUCK", "4 events; deadlock: every task waits for ever"),
    ):
        folder = tmp_path / process
        generate(ends, process, folder)
        built(folder)
        assert run(folder, 100) == (int("deadlock" in said), said)
        assert followed(ends, process, folder).departure is None


def linked(text: str, process: str = "SYSTEM") -> list[tuple[list[str], str, list[str]]]:
    """The links of a program: channels, receiver, senders."""
    made = system(cspcheck.loads(text)._script, process, Semantics(), "policy")
    name = [task.name for task in made.tasks]
    return [
        ([made.channels[c].name for c in one.channels], name[one.receiver], [name[s] for s in one.senders])
        for one in links(made)
    ]


def test_which_channels_need_no_arbiter() -> None:
    head = "channel a, b : {0..1}\nchannel x, y\n"
    # A receiver chooses between two channels: one object.
    assert linked(
        f"{head}P = a!0 -> a!1 -> P\nQ = b!1 -> Q\nR = a?v -> R [] b?v -> x -> R\n"
        "SYSTEM = (P ||| Q) [| {| a, b |} |] R\n"
    ) == [(["a", "b"], "R", ["P", "Q"])]
    # A sender that may do something else, a receiver that may, an event of three, time, the end of a receiver.
    for parts in (
        "P = a!0 -> P [] x -> P\nR = a?v -> R",
        "P = a!0 -> P\nR = a?v -> R [] x -> R",
        "P = a!0 -> P\nR = a?v -> R [] SKIP",
        "P = a!0 -> P [] a!1 -> P\nR = a?v -> R",
    ):
        found = linked(f"{head}{parts}\nSYSTEM = P [| {{| a |}} |] R\n")
        # The second of two parties may still be the one that commits.
        assert all(receiver == "P" and senders == ["R"] for _, receiver, senders in found), parts
        assert not found or "R = a?v -> R\n" not in f"{parts}\n"
    three = f"{head}P = x -> P\nQ = x -> Q\nR = x -> R\nSYSTEM = P [| {{x}} |] (Q [| {{x}} |] R)\n"
    assert linked(three) == []


@hosted
def test_the_commands_of_the_page_do_what_it_says(tmp_path: Path) -> None:
    page = (SPECS.parent / "docs" / "targets.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```\n(cspcheck gen [^`]*--target ada.*?)```", page, re.DOTALL)
    (tmp_path / "specs").symlink_to(SPECS)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, "MAKEFLAGS": f"FLAGS={FLAGS.replace(' ', chr(92) + ' ')}"}
    done = subprocess.run(f"set -e\n{block}", shell=True, cwd=tmp_path, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    assert "run.jsonl is a trace of `ROV_Control_Module`: 3,000 events" in done.stdout
    assert "pragma Profile (Ravenscar);" in (tmp_path / "vehicle" / "gnat.adc").read_text()
    built(tmp_path / "vehicle", "main")  # and under that profile the compiler has nothing to say either


hostile = st.text(alphabet=st.sampled_from('"\\*-_/?\n\r\té\u2028%{}()#ab1\x00'), min_size=1, max_size=90)


@settings(max_examples=examples(100))
@given(hostile)
def test_texts_stay_texts_in_ada(text: str) -> None:
    literal = quoting.ada_text(text)
    piece = r'(?:"(?:[ !#-~]|"")*"|Character\'Val \(\d+\))'
    assert re.fullmatch(f"{piece}(?: & {piece})*", literal)
    data = bytearray()
    for found in re.finditer(r'"((?:[ !#-~]|"")*)"|Character\'Val \((\d+)\)', literal):
        data += bytes([int(found[2])]) if found[2] else found[1].replace('""', '"').encode()
    assert data.decode("utf-8", "surrogateescape") == text
    name = quoting.ada_name(text)
    assert re.fullmatch(r"[A-Za-z](?:_?[A-Za-z0-9])*", name)
    lines = tidy(f'   X : constant String := {literal} & "and this";').split("\n")
    assert " ".join(line.strip() for line in lines).replace(
        " ", ""
    ) == f'X:constantString:={literal}&"andthis";'.replace(" ", "")
    assert os.linesep not in quoting.c_comment(text)
