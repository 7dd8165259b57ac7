"""Generated programs: they are what a person would have written, and every run of them is a trace of the script."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import cspcheck
from cspcheck import testing
from cspcheck.codegen.design.candidates import candidates
from cspcheck.codegen.design.program import design
from cspcheck.codegen.emit.project import project
from cspcheck.codegen.runtime import Memory, Program, Randomly, VirtualClock
from tests.codegen.programs import EXAMPLES, SPECS, TABLES, followed, generate, loaded, strictly_typed

DEADLOCKING = {"Symmetric", "Election"}
IDS = [f"{script.partition('/')[2]}-{process}" for script, process, _ in EXAMPLES]


@pytest.mark.parametrize(("script", "process", "choice"), EXAMPLES, ids=IDS)
def test_random_schedules_are_traces_of_the_script(script: str, process: str, choice: str, tmp_path: Path) -> None:
    """A longer run of the same is ``python tests/benchmarks/bench_conformance.py``."""
    loaded_script = cspcheck.load(SPECS / script)
    generate(loaded_script, process, tmp_path, choice)  # type: ignore[arg-type]
    events, deadlocked = followed(loaded_script, process, tmp_path, 3_000, seed=1)
    assert events == 3_000
    assert deadlocked == (process in DEADLOCKING)


@pytest.mark.parametrize(
    ("script", "process", "choice"), TABLES, ids=[f"{s.partition('/')[2]}-{p}" for s, p, _ in TABLES]
)
def test_tables_keep_to_the_script_as_well(script: str, process: str, choice: str, tmp_path: Path) -> None:
    loaded_script = cspcheck.load(SPECS / script)
    generate(loaded_script, process, tmp_path / "p", choice)  # type: ignore[arg-type]
    assert followed(loaded_script, process, tmp_path / "p", 200, seed=1) == (200, False)
    lint = subprocess.run(
        [sys.executable, "-m", "ruff", "check", "."], cwd=tmp_path / "p", capture_output=True, text=True
    )
    assert lint.stdout == "All checks passed!\n"


@pytest.mark.parametrize(
    ("script", "process"),
    [
        ("microautoware/microautoware.csp", "Repaired(SIGNALS)"),
        ("microautoware/tasks.csp", "Owned"),  # events with groups of different sizes
        ("rov/data_view.csp", "ChainRepaired"),  # methods that are told records
    ],
)
def test_tables_are_strictly_typed(script: str, process: str, tmp_path: Path) -> None:
    generate(cspcheck.load(SPECS / script), process, tmp_path / "p", "policy")
    assert strictly_typed(tmp_path / "p") == ""


CLOCK = """
channel tock, press, lamp, out
-- tock: 250 ms
OneStep(_) = 0
Timed(OneStep) {
  Lamp = press -> lamp -> (WAIT(3) ; out -> Lamp)
  SYSTEM = Lamp ||| Lamp
}
"""


def test_a_timed_process_counts_the_time_of_the_clock(tmp_path: Path) -> None:
    script = cspcheck.loads(CLOCK)
    generate(script, "SYSTEM", tmp_path)
    with loaded(tmp_path) as main:
        memory = Memory()
        Program(main.tasks()).run("loop", clock=VirtualClock(), recorder=memory, seconds=3.1)
    outs = [record.time for record in memory.records if record.channel == "out"]
    assert outs == [0.75, 0.75, 1.5, 1.5, 2.25, 2.25, 3.0, 3.0]
    assert [record.time for record in memory.records if record.channel == "tock"] == [n * 0.25 for n in range(1, 13)]


def test_priorities_of_the_whole_are_kept(tmp_path: Path) -> None:
    script = cspcheck.loads(
        "external prioritise\nchannel a, b : {0..1}\nP(n) = a!n -> P(1 - n) [] b?x -> P(n)\nQ = b.0 -> a?x -> Q\n"
        "SYSTEM = prioritise(P(0) ||| Q, <{| a |}, {| b |}>)\n"
    )
    generate(script, "SYSTEM", tmp_path)
    assert followed(script, "SYSTEM", tmp_path, 200, seed=3) == (200, False)


@pytest.mark.slow
def test_generated_programs_pass_linter_and_type_checker(tmp_path: Path) -> None:
    for i, (script, process, choice) in enumerate(EXAMPLES):
        generate(cspcheck.load(SPECS / script), process, tmp_path / f"p{i}", choice)
    timed = cspcheck.loads(TIMED)
    generate(timed, "SYSTEM", tmp_path / "timed")
    data = cspcheck.loads(DATA)
    generate(data, "SYSTEM", tmp_path / "data")
    folders = sorted(tmp_path.iterdir())
    for folder in folders:
        lint = subprocess.run([sys.executable, "-m", "ruff", "check", "."], cwd=folder, capture_output=True, text=True)
        assert lint.returncode == 0, lint.stdout
    # Their modules have the same names, so each is checked by itself.
    for folder in (folders[0], tmp_path / "p10", tmp_path / "data"):
        assert strictly_typed(folder) == ""


TIMED = """
channel read, next, send : {0..3}
channel watch
-- task Sensor: period 100 ms at next, offset 10 ms
-- task Guard: period 250 ms at watch, priority 3
Sensor = read?x -> send!x -> next.0 -> Sensor
Guard = watch -> Guard
Base = send?x -> Base
SYSTEM = (Sensor [| {| send |} |] Base) ||| Guard
"""

DATA = """
datatype Colour = red | green
datatype Message = Empty | Full.Colour.{0..2}
N = 2
Small = {0..N}
channel paint : Colour
channel post : Message
channel sum : Small
channel pairs : (Small, Small)
swap((x, y)) = (y, x)
mixed(c, n) = if c == red then Full.green.n else Full.red.(N - n)
total(<>) = 0
total(<x>^rest) = (x + total(rest)) % (N + 1)
Painter(c, s) = paint!c -> post!mixed(c, #s) -> Counter(s ^ <#s>)
  [] #s == N & sum!total(s) -> pairs!swap((0, #s)) -> Painter(c, <>)
Counter(s) = if #s > N then Painter(red, <>) else sum?x:{0..#s} -> (let y = x within
  (member(y, {0, 1}) & post.Empty -> Painter(green, tail(s) ^ <y>) [] y == 2 & post?m -> SKIP ; Painter(red, s)))
Wall = paint?c -> Wall
Box = post?m -> Box
Ledger = sum.0 -> Ledger [] sum?n:{1..2} -> Ledger [] pairs?p -> Ledger
SYSTEM = Painter(red, <>) [| {| paint, post, sum, pairs |} |] (Wall ||| Box ||| Ledger)
"""


def test_data_and_functions_are_translated(tmp_path: Path) -> None:
    script = cspcheck.loads(DATA)
    generate(script, "SYSTEM", tmp_path)
    assert followed(script, "SYSTEM", tmp_path, 2_000, seed=3) == (2_000, False)


def test_the_text_of_a_task_is_what_a_person_would_write(tmp_path: Path) -> None:
    generate(cspcheck.load(SPECS / "rov" / "rov.csp"), "ROV_Control_Module", tmp_path)
    text = (tmp_path / "stop.py").read_text()
    assert (
        text[text.index("    async def run") :]
        == '''\
    async def run(self) -> None:
        """For ever."""
        while True:
            await self.perform(self.check_last_reception.own(self.methods.check_last_reception))
            choice = await self.select(
                self.stop_s2.meet(),
                self.get_next_execution_stp.own(self.methods.get_next_execution_stp),
            )
            if choice.taken == 0:
                await self.perform(self.get_next_execution_stp.own(self.methods.get_next_execution_stp))
'''
    )


def test_comments_make_tasks_periodic(tmp_path: Path) -> None:
    script = cspcheck.loads(TIMED)
    generate(script, "SYSTEM", tmp_path)
    with loaded(tmp_path) as main:
        memory = Memory()
        summary = Program(main.tasks()).run("threads", clock=VirtualClock(), recorder=memory, seconds=2.0)
    times = {name: [r.time for r in memory.records if r.channel == name] for name in ("next", "watch")}
    assert times["next"] == [0.01 + n * 0.1 for n in range(20)]
    assert times["watch"] == [n * 0.25 for n in range(8)]
    assert summary.missed == {"Sensor": 0, "Guard": 0}


REFUSED = {
    "a process that forks": ("channel a\nP = a -> (P ||| P)\nSYSTEM = P", "CSP803"),
    "hiding in a loop": ("channel a, b\nP = a -> (P \\ {b})\nSYSTEM = P ||| P", "CSP803"),
    "no name": ("channel a, b\nSYSTEM = (a -> STOP) ||| (b -> STOP)", "CSP802"),
    "internal choice": ("channel a, b\nP = a -> P |~| b -> P\nSYSTEM = P ||| P", "CSP804"),
    "interrupt": ("channel a, b\nP = a -> P /\\ b -> STOP\nSYSTEM = P ||| P", "CSP805"),
    "part of a channel hidden": ("channel a : {0..1}\nP = a?x -> P\nSYSTEM = (P ||| P) \\ {a.0}", "CSP806"),
    "part of a channel renamed": ("channel a, b : {0..1}\nP = a?x -> P\nSYSTEM = (P ||| P)[[a.0 <- b.1]]", "CSP806"),
    "time": ("channel a, tock\nStep(_) = 1\nTimed(Step) {\nP = a -> P\n}\nSYSTEM = P ||| P", "CSP805"),
    "a constructor in parts": (
        "datatype A = B.{0..1} | C\nchannel f : A\nP = f.B?x -> P\nSYSTEM = P ||| P",
        "CSP805",
    ),
    "two channels renamed to one": ("channel a, b\nP = a -> b -> P\nSYSTEM = (P ||| P)[[a <- b]]", "CSP812"),
    "a channel as argument": ("channel a\nP(c) = c -> P(c)\nSYSTEM = P(a) ||| P(a)", "CSP805"),
    "events as argument": ("channel a\nP(s) = a -> P(s)\nSYSTEM = P({a}) ||| P({a})", "CSP807"),
    "priorities": ("external prioritise\nchannel a\nP = a -> P\nSYSTEM = prioritise(P, <{a}>)", "CSP805"),
    "a wrong period": ("channel a\nP = a -> P\n-- task P: period often at a\nSYSTEM = P ||| P", "CSP811"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_generated_is_refused_with_a_reason(name: str) -> None:
    text, code = REFUSED[name]
    with pytest.raises(cspcheck.ScriptError) as raised:
        project(design(cspcheck.loads(text)._script, "SYSTEM"), "program")
    (diagnostic,) = raised.value.diagnostics
    assert diagnostic.code == code


@pytest.mark.parametrize("runner", ["threads", "asyncio"])
def test_threads_and_event_loops_conform_too(runner: str, tmp_path: Path) -> None:
    script = cspcheck.load(SPECS / "rov" / "rov.csp")
    generate(script, "ROV_Control_Module", tmp_path)
    with loaded(tmp_path) as main:
        follower = testing.follow(script, "ROV_Control_Module")
        Program(main.tasks()).run(runner, recorder=follower, events=1_000)  # type: ignore[arg-type]


def test_an_edited_program_that_departs_is_found_out(tmp_path: Path) -> None:
    """The test of the test: a task that leaves an event out, and one that does two in the wrong order."""
    script = cspcheck.load(SPECS / "rov" / "rov.csp")
    generate(script, "ROV_Control_Module", tmp_path)
    text = (tmp_path / "sensor.py").read_text()
    lines = [line for line in text.splitlines() if "await self.perform" in line]
    for wrong in (text.replace(lines[1] + "\n", ""), text.replace("\n".join(lines[:2]), "\n".join(lines[1::-1]))):
        assert wrong != text
        (tmp_path / "sensor.py").write_text(wrong)
        with loaded(tmp_path) as main:
            program = Program(main.tasks())
        follower = testing.follow(script, "ROV_Control_Module")
        with pytest.raises(testing.Departed):
            program.run("loop", recorder=follower, events=2_000, policy=Randomly(1))


def test_values_of_every_kind_are_written_as_the_script_writes_them(tmp_path: Path) -> None:
    script = cspcheck.loads(
        "channel c : { -2..1}\nchannel k : {'x', 'y'}\nchannel s : Set({0, 1})\nchannel q : {<>, <1>, <1, 2>}\n"
        "P = c?x -> k!'x' -> s!{1, 0} -> q!<1, 2> -> P\nR = c!(-1) -> k?y -> s?z -> q?v -> R\n"
        "SYSTEM = P [| {| c, k, s, q |} |] R\n"
    )
    generate(script, "SYSTEM", tmp_path)
    with loaded(tmp_path) as main:
        memory = Memory()
        Program(main.tasks()).run("loop", recorder=memory, events=4)
    assert memory.trace() == ["c.-1", "k.'x'", "s.{0, 1}", "q.<1, 2>"]
    assert followed(script, "SYSTEM", tmp_path, 40, seed=1) == (40, False)


def test_names_of_the_runtime_are_left_to_it(tmp_path: Path) -> None:
    script = cspcheck.loads(
        "datatype Task = Data | Channel\nchannel c : Task\nClass = c?x -> Class\nOperation = c!Data -> Operation\n"
        "SYSTEM = Class [| {| c |} |] Operation\n"
    )
    generate(script, "SYSTEM", tmp_path)
    assert followed(script, "SYSTEM", tmp_path, 10, seed=1) == (10, False)


def test_channels_of_modules_are_refused() -> None:
    text = "module M\nexports\nchannel c\nP = c -> P\nendmodule\nQ = M::c -> Q\nSYSTEM = Q ||| Q\n"
    with pytest.raises(cspcheck.ScriptError, match="CSP805"):
        project(design(cspcheck.loads(text)._script, "SYSTEM"), "program")


def test_the_process_that_is_meant_is_found() -> None:
    def found(name: str) -> list[str]:
        return candidates(cspcheck.load(SPECS / name)._script)

    assert found("rov/rov.csp") == ["ROV_Control_Module"]
    assert found("producer_consumer/producer_consumer.csp") == ["SYSTEM"]
    assert found("producer_consumer/classes.csp") == ["SYSTEM"]
    assert found("classics/buffer_chain.csp") == ["Chain", "Overtaking"]


def test_the_command_line_of_a_program(tmp_path: Path) -> None:
    def run(*arguments: str) -> tuple[int, str]:
        command = [sys.executable, str(tmp_path / "p" / "main.py"), *arguments]
        done = subprocess.run(command, capture_output=True, text=True, env={"PYTHONPATH": str(SPECS.parent)})
        return done.returncode, done.stderr

    generate(cspcheck.load(SPECS / "classics" / "philosophers.csp"), "Symmetric", tmp_path / "p")
    code, said = run("--runner", "asyncio", "--events", "5", "--record", str(tmp_path / "run.jsonl"))
    assert (code, said.split(" in ")[0]) == (0, "5 events")
    assert len((tmp_path / "run.jsonl").read_text().splitlines()) == 5
    code, said = run("--policy", "random", "--seed", "7", "--clock", "virtual")
    assert code == 1
    assert said.startswith("deadlock: every task waits for ever\n")
    assert said.splitlines()[-1].count(" -> ") == 10
