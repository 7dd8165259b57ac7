"""Stepping through processes: what is shown, what commands do, and that nothing is explored ahead."""

from __future__ import annotations

import io
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st
from syrupy.assertion import SnapshotAssertion

import cspcheck
from cspcheck.checker.semantics.transitions import Semantics
from cspcheck.cli import run
from cspcheck.cli.probe_commands import COMMANDS, split_events
from cspcheck.probing import NoSuchStep, Probe

ROOT = Path(__file__).resolve().parents[3]
PHILOSOPHERS = "specs/classics/philosophers.csp"

SCRIPT = """\
channel up, down
channel a, b, c, t, trace
channel d : {0..50}.{0..50}
Count(n) = up -> Count(n + 1) [] n > 0 & down -> Count(n - 1)
P = a -> P [] a -> b -> P |~| trace -> STOP
Bad(n) = a -> (if 6 / (3 - n) > 0 then Bad(n + 1) else STOP)
Wide = d?x?y -> Wide
Phases = (a -> SKIP ||| b -> SKIP) ; c -> SKIP
Left = a -> c -> Left
Right = c -> b -> Right
Both = (Left [| {c} |] Right) \\ {c}
Letters = t -> a -> Letters
Endless = c -> Endless
assert Both :[deadlock free]
assert STOP [T= Both
assert a -> b -> STOP [T= Both
"""


Talk = Callable[..., tuple[int, str, str]]
"""Calls the verb with arguments and commands; the exit code, what it said, and what it complained of."""


@pytest.fixture
def script(tmp_path: Path) -> str:
    path = tmp_path / "small.csp"
    path.write_text(SCRIPT)
    return str(path)


@pytest.fixture
def probe(script: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Talk:
    def talk(*arguments: str, commands: str = "") -> tuple[int, str, str]:
        monkeypatch.setattr("sys.stdin", io.StringIO(commands.replace("; ", "\n") + "\n"))
        monkeypatch.chdir(ROOT)
        known = {"SCRIPT": script}
        code = run(["probe", *[known.get(a, a.replace("SCRIPT", script)) for a in arguments], "--color", "never"])
        output = capsys.readouterr()
        return code, output.out.replace(script, "small.csp"), output.err.replace(script, "small.csp")

    return talk


def after(text: str, command: str) -> str:
    """What a command made come."""
    return text.split(f"\n> {command}\n", 1)[1].split("\n> ", 1)[0]


class TestWhatIsShown:
    def test_a_session(self, probe: Talk, snapshot: SnapshotAssertion) -> None:
        commands = "1; run c, b; trace; undo 2; term Left; term; walk 4 7; restart; all; help; nonsense; undo; 9"
        code, out, _ = probe("SCRIPT", "Both", commands=commands)

        assert code == 1  # the last three cannot be done
        assert out == snapshot

    def test_a_counterexample(self, probe: Talk, snapshot: SnapshotAssertion) -> None:
        code, out, _ = probe("--at", f"{PHILOSOPHERS}:33", "-D", "N=2", commands="next; 2; next; undo; next 9")

        assert code == 1  # one `next` was off the way
        assert out == snapshot

    def test_the_specification_beside_the_implementation(self, probe: Talk, snapshot: SnapshotAssertion) -> None:
        code, out, _ = probe("--at", "SCRIPT:16", commands="next 20")

        assert code == 0
        assert out == snapshot

    def test_many_steps_are_folded(self, probe: Talk) -> None:
        _, out, _ = probe("SCRIPT", "Wide", commands="d.3.4; all")

        assert "2,581 steps more; `all` shows them" in out
        assert "d.50.50" not in out.split("> all")[0]
        assert "d.50.50" in after(out, "all")

    def test_steps_that_look_alike_say_where_they_lead(self, probe: Talk) -> None:
        _, out, _ = probe("SCRIPT", "P", commands="1")

        assert after(out, "1").splitlines()[-2:] == [
            "  1  a  then a -> P [] a -> b -> P |~| trace -> STOP",
            "  2  a  then b -> P",
        ]

    def test_terminated_is_no_deadlock(self, probe: Talk) -> None:
        _, out, _ = probe("SCRIPT", "Phases", commands="run a, b, c, tick")

        assert after(out, "run a, b, c, tick").splitlines()[0] == "after 5 steps  <a, b, tau, c, tick>"
        assert "it has terminated" in out
        assert "deadlock" not in out


class TestCommands:
    def test_a_process_with_endlessly_many_states(self, probe: Talk) -> None:
        code, out, _ = probe("SCRIPT", "Count(0)", commands="run up, up, up; down")

        assert code == 0
        assert "Count(0)   up -> Count(3) [] down -> Count(1)" in after(out, "down")

    def test_an_event_of_several_steps_is_asked_for_by_number(self, probe: Talk) -> None:
        code, out, _ = probe("SCRIPT", "P", commands="1; a")

        assert code == 1
        assert after(out, "a") == "`a` may be any of 1, 2: choose by number\n"

    def test_a_hidden_event_may_be_said_by_its_name(self, probe: Talk) -> None:
        code, out, _ = probe("SCRIPT", "Both", commands="a; c")

        assert code == 0
        assert after(out, "c").startswith("after 2 steps  <a, tau (c)>")

    def test_a_command_wins_over_an_event_and_do_means_the_event(self, probe: Talk) -> None:
        code, out, _ = probe("SCRIPT", "P", commands="2; trace; do trace")

        assert code == 0
        assert after(out, "trace") == "  1  tau\n"
        assert after(out, "do trace").startswith("after 2 steps  <tau, trace>")

    def test_an_event_wins_over_the_short_form_of_a_command(self, probe: Talk) -> None:
        _, out, _ = probe("SCRIPT", "Letters", commands="t; a; t")

        assert after(out, "a").startswith("after 2 steps  <t, a>")
        assert out.count("after 1 step  <t>") == 1

    def test_a_typing_error_gets_a_suggestion(self, probe: Talk) -> None:
        code, out, _ = probe("SCRIPT", "Count(0)", commands="undp; dwon")

        assert code == 1
        assert after(out, "undp") == "`undp` cannot happen here; did you mean `undo`?\n"

    def test_what_cannot_be_evaluated_leaves_the_process_where_it_was(self, probe: Talk) -> None:
        code, out, _ = probe("SCRIPT", "Bad(0)", commands="a; a; all")

        assert code == 1
        assert "error[CSP401]: division by zero" in out
        assert after(out, "all").startswith("after 1 step")

    def test_a_run_stops_where_it_cannot_go_on(self, probe: Talk) -> None:
        code, out, _ = probe("SCRIPT", "Count(0)", commands="run up, down, down")

        assert code == 1
        assert out.endswith("`down` cannot happen here; stopped after 2 steps\n")

    def test_walks_with_one_seed_are_one_walk(self, probe: Talk) -> None:
        first = probe("SCRIPT", "Count(0)", "--seed", "3", commands="walk 30; trace")
        second = probe("SCRIPT", "Count(0)", commands="walk 30 3; trace")
        other = probe("SCRIPT", "Count(0)", commands="walk 30 4; trace")

        assert first[1].split("> trace")[1] == second[1].split("> trace")[1] != other[1].split("> trace")[1]

    def test_a_walk_ends_in_a_deadlock(self, probe: Talk) -> None:
        _, out, _ = probe("SCRIPT", "a -> b -> STOP", commands="walk 30")

        assert "2 steps: <a, b>" in out
        assert "deadlock: nothing can happen" in out

    def test_every_command_is_in_the_help(self, probe: Talk) -> None:
        _, out, _ = probe("SCRIPT", "P", commands="help")

        assert all(command.usage in out for command in COMMANDS.values())

    def test_quit_leaves_the_rest_unread(self, probe: Talk) -> None:
        code, out, _ = probe("SCRIPT", "P", commands="quit; 1")

        assert code == 0
        assert out.endswith("> quit\n")


class TestWrongUse:
    @pytest.mark.parametrize(
        ("arguments", "said"),
        [
            (["SCRIPT"], "missing PROCESS"),
            ([], "missing FILE"),
            (["-", "P"], "standard input is where the commands come from"),
            (["SCRIPT", "P", "--at", "SCRIPT:14"], "leave PROCESS out"),
            (["--at", "SCRIPT:here"], "is not FILE:LINE"),
            (["--at", "SCRIPT:1"], "no assertion at"),
            (["--at", "SCRIPT:14"], "has no counterexample: its verdict is pass"),
            (["SCRIPT", "Nobody"], "`Nobody` is not defined"),
            (["SCRIPT", "chase(P)"], "chase"),
            (["missing.csp", "P"], "cannot read"),
        ],
    )
    def test_is_said_before_anything_starts(self, probe: Talk, arguments: list[str], said: str) -> None:
        code, out, err = probe(*arguments)

        assert (code, out) == (2, "")
        assert said in err

    def test_a_failure_of_the_solver_has_no_steps(self, probe: Talk, tmp_path: Path) -> None:
        script = tmp_path / "stuck.csp"
        script.write_text(
            "class Stuck\n  chan to : [i? : nat]\n  state n : nat\n  init n = 0\n"
            "  op com_to Delta(n) i? : nat where n /= 7 and n' = i?\nend\nassert Stuck :[deadlock free]\n"
        )
        code, out, err = probe("--at", f"{script}:7")

        assert (code, out) == (2, "")
        assert "`Stuck :[deadlock free]` fails, and there are no steps that lead to it one by one" in err


@pytest.mark.parametrize(
    ("text", "events"),
    [
        ("a, b.1", ["a", "b.1"]),
        ("<a,b>", ["a", "b"]),
        ("c.(1, 2), d.{3, 4}, e.<1, 2>.5", ["c.(1, 2)", "d.{3, 4}", "e.<1, 2>.5"]),
        ("", []),
        (" , ", []),
    ],
)
def test_events_are_split_at_the_commas_between_them(text: str, events: list[str]) -> None:
    assert split_events(text) == events


@settings(deadline=None)
@given(st.lists(st.integers(0, 50), max_size=30), st.data())
def test_any_way_is_a_run_of_the_process_and_can_be_undone(choices: list[int], data: st.DataObject) -> None:
    script = cspcheck.loads(SCRIPT)
    name = data.draw(st.sampled_from(["Count(0)", "P", "Phases", "Both", "Letters"]))
    probe = Probe(script.process(name)._term, script._script.events)
    semantics = Semantics()
    for choice in choices:
        steps = probe.steps()
        if not steps:
            break
        before = probe.here.state
        probe.take(steps[choice % len(steps)])
        assert probe.here.state in [after for _, after in semantics.transitions(before)]
    taken = len(probe.way) - 1
    assert probe.undo(taken + 1) == taken
    assert probe.here.state is semantics.state(script.process(name)._term)


def test_an_event_behind_endless_internal_steps_is_found_or_said_to_be_missing() -> None:
    script = cspcheck.loads("channel a, b, c\nD = c -> D [] a -> STOP\nLoop = D \\ {c}\n")
    probe = Probe(script.process("Loop")._term, script._script.events)

    with pytest.raises(NoSuchStep, match="`b` cannot happen"):
        probe.perform("b")
    probe.perform("a")
    assert [performed.event for performed in probe.trace()][-1] > 1


def test_the_whole_vehicle_can_be_probed_from_a_pipe() -> None:
    """2.5 million states, of which only those on the way are looked at."""
    done = subprocess.run(
        [sys.executable, "-m", "cspcheck", "probe", "specs/rov/rov.csp", "ROV_Control_Module"],
        cwd=ROOT,
        input="walk 25 1\ntrace\n",
        capture_output=True,
        encoding="utf-8",
        check=True,
        timeout=120,
    )

    assert "after 25 steps" in done.stdout
    assert done.stderr == ""


def test_numbers_that_nobody_means(probe: Talk) -> None:
    nines = "9" * 5_000
    commands = [nines, f"walk {nines}", "walk 100001", f"undo {nines}", f"next {nines}", f"walk 3 {nines}", "\u00b2"]
    code, out, _ = probe("SCRIPT", "P", commands="; ".join(commands))
    assert code == 1
    assert "a walk has 100,000 steps at most" in out
    assert out.count("is not a whole number above zero") == 2  # walk, undo; there is no counterexample to follow
