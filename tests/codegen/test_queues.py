"""A channel is a queue only where that refines the process, and what is refined is what runs."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

import cspcheck
from cspcheck.buffering import queued
from cspcheck.checker.check import Checker
from cspcheck.checker.lts import Lts
from cspcheck.checker.semantics.machine_states import ExplicitMachine
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.checker.verdict import Verdict
from cspcheck.cli import run
from cspcheck.codegen.design.buffers import buffer, rows
from cspcheck.codegen.design.system import system
from cspcheck.cspm.process.terms import STOP
from cspcheck.following import Follower
from cspcheck.runs import follow, read_records
from tests.codegen.programs import SPECS

hosted = pytest.mark.skipif(shutil.which("cc") is None or shutil.which("make") is None, reason="no C compiler here")

SCRIPT = """
channel a, b, c, s : {0..2}
P(n) = c!n -> P((n + 1) % 3)
Q = a?x -> c!x -> Q
R = |~| x : {0..2} @ c!x -> R
ONCE = c!1 -> SKIP
C = c?x -> b!x -> C
LOST = c?x -> if x == 2 then STOP else LOST
ENDS = c?x -> b!x -> SKIP
BUFFER(n) = let B(q) = (#q < n & s?x -> B(q ^ <x>)) [] (not null(q) & c!head(q) -> B(tail(q)))
            within B(<>)
WITH(LEFT, n, RIGHT) = ((LEFT[[c <- s]] [| {| s |} |] BUFFER(n)) \\ {| s |}) [| {| c |} |] RIGHT
COUNTING = (P(0) [| {| c |} |] C) \\ {| c |}
PASSING = (Q [| {| c |} |] C) \\ {| c |}
CHOOSING = (R [| {| c |} |] C) \\ {| c |}
SEEN = P(0) [| {| c |} |] C
LOSING = R [| {| c |} |] LOST
FIFO(q) = if null(q) then a?x -> FIFO(<x>)
          else b!head(q) -> FIFO(tail(q)) [] #q < 4 & (STOP |~| a?x -> FIFO(q ^ <x>))
ENDING = (ONCE [| {| c |} |] ENDS) \\ {| c |}
"""
LEADING = {"COUNTING": "P(0)", "PASSING": "Q", "CHOOSING": "R", "SEEN": "P(0)", "LOSING": "R"}
FOLLOWING = {"LOSING": "LOST"}


def explicit(found: list[list[tuple[int, int]]]) -> object:
    lts = Lts.from_successors(found)
    return ExplicitMachine(lts, STOP).term(lts.root)


def same(script: cspcheck.Script, text: str, found: list[list[tuple[int, int]]]) -> bool:
    checker = Checker(script._script)
    one, other = script._script.process(text), explicit(found)
    return all(
        checker.check_refinement(left, "FD", right).verdict is Verdict.PASS  # type: ignore[arg-type]
        for left, right in ((one, other), (other, one))
    )


@pytest.mark.parametrize(
    ("file", "process"),
    [
        ("classics/token_ring.csp", "Ring"),
        ("producer_consumer/producer_consumer.csp", "Repaired"),
        ("channels/data_sync.csp", "SlotEach(ID)"),
    ],
)
def test_the_machine_without_queues_is_the_composition(file: str, process: str) -> None:
    script = cspcheck.load(SPECS / file)
    assert same(script, process, rows(system(script._script, process, Semantics(), "policy"), ()))


@pytest.mark.parametrize("length", [1, 3])
@pytest.mark.parametrize("process", LEADING)
def test_the_machine_with_a_queue_is_the_composition_with_a_buffer(process: str, length: int) -> None:
    script = cspcheck.loads(SCRIPT)
    made = system(script._script, process, Semantics(), "policy")
    hidden = "" if process in ("SEEN", "LOSING") else " \\ {| c |}"
    text = f"WITH({LEADING[process]}, {length}, {FOLLOWING.get(process, 'C')}){hidden}"
    assert same(script, text, rows(made, [buffer(made, "c", length)]))


@pytest.mark.parametrize(
    ("process", "length", "why"),
    [
        ("PASSING", 1, "after a.0, a.0, then `a.0` is possible, which `PASSING` does not allow"),
        ("COUNTING", 2, ""),
        ("CHOOSING", 2, ""),
        ("SEEN", 3, ""),
        ("LOSING", 1, ""),
        ("ENDING", 1, ""),
    ],
)
def test_it_is_a_queue_only_where_that_refines(process: str, length: int, why: str) -> None:
    script = cspcheck.loads(SCRIPT)
    made = system(script._script, process, Semantics(), "policy")
    if not why:
        assert [one.length for one in queued(made, script._script, [("c", length)])] == [length]
        return
    with pytest.raises(cspcheck.ScriptError) as refused:
        queued(made, script._script, [("c", length)])
    assert why in str(refused.value)


def test_what_is_needed_may_be_less_than_the_process() -> None:
    script = cspcheck.loads(SCRIPT)
    made = system(script._script, "PASSING", Semantics(), "policy")
    assert len(queued(made, script._script, [("c", 2)], "FIFO(<>)")) == 1
    with pytest.raises(cspcheck.ScriptError, match=r"which `FIFO\(<>\)` does not allow"):
        queued(made, script._script, [("c", 3)], "FIFO(<>)")


@hosted
@pytest.mark.parametrize("process", ["COUNTING", "SEEN", "LOSING", "ENDING"])
def test_runs_with_a_queue_are_traces_of_the_process(process: str, tmp_path: Path) -> None:
    (tmp_path / "script.csp").write_text(SCRIPT)
    folder = tmp_path / "program"
    arguments = ["gen", str(tmp_path / "script.csp"), "--process", process, "--target", "freertos", "-o", str(folder)]
    assert run([*arguments, "--internal-choice", "policy", "--queue", "c=3"]) == 0
    assert "is a queue of 3" in (folder / "README.md").read_text()
    subprocess.run(["make", "-s", "host"], cwd=folder, check=True)
    done = subprocess.run(
        ["./host", "--events", "3000", "--record", "run.jsonl"],
        cwd=folder, check=False, capture_output=True, text=True, timeout=100,
    )  # fmt: skip
    assert done.returncode == (1 if process == "LOSING" else 0), done.stderr
    assert ("deadlock" in done.stderr) == (process == "LOSING")
    script = cspcheck.loads(SCRIPT)
    with open(folder / "run.jsonl", encoding="utf-8") as lines:
        follower = Follower(script._script, script._script.process(process), hidden=False)
        assert follow(follower, read_records(lines, "run.jsonl")).departure is None


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--target", "freertos", "--queue", "d"], "the channels of `COUNTING` are `b`, `c`"),
        (["--target", "freertos", "--queue", "b=2"], "from one task"),
        (["--target", "freertos", "--queue", "c=0"], "a number from 1 to 255, not `0`"),
        (["--target", "ada", "--queue", "c"], "--queue is for --target freertos"),
    ],
)
def test_what_is_no_queue_is_said(
    arguments: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "script.csp").write_text(SCRIPT)
    command = ["gen", str(tmp_path / "script.csp"), "--process", "COUNTING", "-o", str(tmp_path / "program")]
    assert run([*command, *arguments]) == 2
    assert said in " ".join(capsys.readouterr().err.split())
