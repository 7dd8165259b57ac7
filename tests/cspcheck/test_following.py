"""Runs against specifications: what is a trace is found to be one, and where one is left is said."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path
from random import Random

import pytest
from hypothesis import find, given, settings, strategies as st
from hypothesis.errors import NoSuchExample
from hypothesis.stateful import run_state_machine_as_test

import cspcheck
from cspcheck import following, testing
from cspcheck.following import Follower
from tests.examples import examples

BUFFER = """
channel left, right : {0..2}
channel inside
N = 2
Buffer(s) = #s < N & left?x -> Buffer(s ^ <x>) [] #s > 0 & right!head(s) -> Buffer(tail(s))
SPEC = Buffer(<>)
Bag(s) = #s < N & left?x -> Bag(s ^ <x>) [] #s > 0 & (|~| x : set(s) @ right!x -> Bag(remove(x, s)))
remove(x, <y>^s) = if x == y then s else <y> ^ remove(x, s)
Maybe = left?x -> (right!x -> Maybe |~| Maybe)
Inner = left?x -> inside -> right!x -> Inner
Hidden = Inner \\ {inside}
"""


@pytest.fixture(scope="module")
def buffer() -> cspcheck.Script:
    return cspcheck.loads(BUFFER)


def follower(script: cspcheck.Script, process: str, inside: bool = False) -> Follower:
    return Follower(script._script, script._script.process(process), hidden=inside)


class TestFollowing:
    def test_a_trace_is_followed_and_a_departure_explained(self, buffer: cspcheck.Script) -> None:
        spec = follower(buffer, "SPEC")
        for event in ("left.1", "left.2", "right.1"):
            assert spec.step(event) is None
        assert spec.allowed() == ("left.0", "left.1", "left.2", "right.2")
        departure = spec.step("right.1")
        assert departure is not None
        assert departure.explain().splitlines()[:3] == [
            "event 4 of the run, `right.1`, is not allowed there: the process does not offer it after these events",
            "  before it   left.1 -> left.2 -> right.1",
            "  allowed     left.0, left.1, left.2, right.2",
        ]
        assert spec.step("right.2") is None

    @pytest.mark.parametrize("process", ["SPEC", "Bag", "Maybe", "Hidden"])
    def test_what_is_forgotten_on_the_way_changes_nothing(
        self, buffer: cspcheck.Script, process: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        name = "Bag(<>)" if process == "Bag" else process
        whole, forgetful = follower(buffer, name), follower(buffer, name)
        turns = Random(7)
        for _ in range(60):
            event = turns.choice(["left.0", "left.1", "right.0", "right.1"])
            expected = whole.step(event)
            monkeypatch.setattr(following, "MOST_SETS", 2)
            found = forgetful.step(event)
            monkeypatch.undo()
            assert len(forgetful._sets) <= 3
            assert (found is None) == (expected is None)
            if found is not None and expected is not None:
                assert replace(found, why="") == replace(expected, why="")
            assert forgetful.allowed() == whole.allowed()
        forgetful.restart()
        whole.restart()
        assert forgetful.allowed() == whole.allowed()

    def test_events_that_there_are_not_are_told_apart(self, buffer: cspcheck.Script) -> None:
        spec = follower(buffer, "SPEC")
        for event in ("left.7", "wrong", "left", "-- x", "left.1, left.1"):
            departure = spec.step(event)
            assert departure is not None
            assert departure.why == "the script has no such event"

    def test_hidden_events_are_taus_or_followed(self, buffer: cspcheck.Script) -> None:
        outside, inside = follower(buffer, "Hidden"), follower(buffer, "Hidden", inside=True)
        assert (outside.follows("inside", True), inside.follows("inside", True)) == (False, True)
        for event in ("left.1", "right.1"):
            assert outside.step(event) is None
        assert inside.step("left.1") is None
        assert inside.step("right.1") is not None
        assert inside.step("inside") is None

    @settings(max_examples=examples(30))
    @given(st.lists(st.sampled_from(["left.0", "left.1", "right.0", "right.1"]), max_size=6))
    def test_it_says_what_the_checker_says(self, events: list[str]) -> None:
        script = SCRIPT
        for process in ("SPEC", "Bag(<>)", "Maybe", "Hidden"):
            spec = follower(script, process)
            followed = all(spec.step(event) is None for event in events)
            assert followed == bool(script.check(f"{process} :[has trace]: <{', '.join(events)}>"))

    def test_a_live_run_is_stopped_where_it_departs(self, buffer: cspcheck.Script) -> None:
        from cspcheck.codegen.runtime import Channel, Integers, Program, Task

        left, right = (Channel(name, [Integers(0, 2)], parties=["B"]) for name in ("left", "right"))

        class Stack(Task):
            async def run(self) -> None:
                while True:
                    for channel, value in ((left, 0), (left, 1), (right, 1), (right, 0)):
                        await self.perform(channel.put(value))

        for runner in ("threads", "asyncio", "loop"):
            with pytest.raises(testing.Departed) as raised:
                Program([Stack("B")]).run(runner, recorder=testing.follow(buffer, "SPEC"))  # type: ignore[arg-type]
            assert raised.value.departure.event == "right.1"
            assert raised.value.departure.before == ("left.0", "left.1")
        Program([Stack("B")]).run("loop", recorder=testing.follow(buffer, "Bag(<>)"), events=100)


SCRIPT = cspcheck.loads(BUFFER)


class TestStrategies:
    @settings(max_examples=examples(50))
    @given(testing.traces(SCRIPT, "SPEC", max_length=8))
    def test_traces_are_traces(self, trace: list[str]) -> None:
        spec = follower(SCRIPT, "SPEC")
        assert all(spec.step(event) is None for event in trace)
        assert len(trace) <= 8

    def test_traces_shrink(self) -> None:
        least = find(testing.traces(SCRIPT, "SPEC"), lambda trace: "right.1" in trace)
        assert least in (["left.1", "right.1"], ["left.1", "left.0", "right.1"])
        assert find(testing.traces(SCRIPT, "SPEC"), lambda trace: True) == []
        with pytest.raises(NoSuchExample):
            find(
                testing.traces(SCRIPT, "SPEC", max_length=6),
                lambda trace: trace[:1] == ["right.0"],
                settings=settings(max_examples=examples(200)),
            )


class Good:
    """A buffer of two places."""

    def __init__(self) -> None:
        self.kept: list[int] = []

    def left(self, value: int) -> None:
        if len(self.kept) == 2:
            raise testing.Refused
        self.kept.append(value)

    def right(self) -> int:
        if not self.kept:
            raise testing.Refused
        return self.kept.pop(0)


class LastOut(Good):
    """A stack."""

    def right(self) -> int:
        return self.kept.pop()


class Small(Good):
    """A buffer of one place."""

    def left(self, value: int) -> None:
        if self.kept:
            raise testing.Refused
        self.kept.append(value)


class TestMachines:
    @staticmethod
    def verdict(process: str, implementation: type[Good]) -> str | None:
        machine = testing.machine(SCRIPT, process, implementation, outputs={"right": 0})
        try:
            run_state_machine_as_test(machine, settings=settings(max_examples=examples(40), stateful_step_count=12))
        except AssertionError as wrong:
            return str(wrong)
        return None

    def test_what_conforms_passes(self) -> None:
        assert self.verdict("SPEC", Good) is None
        assert self.verdict("Bag(<>)", Good) is None
        assert self.verdict("Bag(<>)", LastOut) is None

    def test_a_wrong_value_is_found_and_shrunk(self) -> None:
        assert self.verdict("SPEC", LastOut) == (
            "after <left.0, left.1>: it performs `right.1`, which `SPEC` does not allow there; allowed are right.0"
        )

    def test_a_refusal_of_what_is_always_accepted_is_found(self) -> None:
        assert self.verdict("SPEC", Small) == (
            "after <left.0>: it refuses `left.0`, which `SPEC` always accepts there; "
            "allowed are left.0, left.1, left.2, right.0"
        )

    def test_what_may_be_refused_may_be_refused(self) -> None:
        class Losing(Good):
            def right(self) -> int:
                raise testing.Refused

        assert self.verdict("Maybe", Losing) is None

    def test_outputs_must_be_channels(self) -> None:
        with pytest.raises(ValueError, match="no channels of the script: rigth"):
            testing.machine(SCRIPT, "SPEC", Good, outputs={"rigth": 0})


def test_without_hypothesis_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "hypothesis", None)
    for name in ("hypothesis.strategies", "hypothesis.stateful"):
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(ImportError, match=r"pip install 'cspcheck\[testing\]'"):
        testing.traces(SCRIPT, "SPEC")


def test_gen_and_trace_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from cspcheck.cli import run

    script = tmp_path / "buffer.csp"
    script.write_text(
        BUFFER + "One = left?x -> inside -> right!x -> One\nOther = inside -> Other\n"
        "SYSTEM = (One [| {inside} |] Other) \\ {inside}\n"
    )
    out = str(tmp_path / "program")
    assert run(["gen", str(script), "-o", out]) == 0
    assert "run it with" in capsys.readouterr().out
    recorded = tmp_path / "run.jsonl"
    lines = ["left.1", "right.1", "left.0", "right.2"]
    recorded.write_text("".join(json.dumps({"event": event}) + "\n" for event in lines[:3]))
    assert run(["trace", str(script), "--process", "SYSTEM", str(recorded)]) == 0
    assert "is a trace of `SYSTEM`: 3 events" in capsys.readouterr().out
    recorded.write_text("".join(json.dumps({"event": event, "tasks": ["One"], "time": 1.5}) + "\n" for event in lines))
    assert run(["trace", str(script), "--process", "SYSTEM", str(recorded)]) == 1
    said = capsys.readouterr().out.splitlines()
    assert said[0] == f"{recorded} leaves `SYSTEM` in line 4"
    assert said[3] == "  allowed     right.0"
    assert said[-1] == "  performed by One at 1.5 s"
    assert run(["trace", str(script), "--process", "SYSTEM", str(recorded), "--format", "json"]) == 1
    document = json.loads(capsys.readouterr().out)
    assert (document["verdict"], document["line"], document["allowed"]) == ("fail", 4, ["right.0"])
    recorded.write_text('{"event": "left.1"}\nnonsense\n')
    assert run(["trace", str(script), "--process", "SYSTEM", str(recorded)]) == 2
    assert "error[CSP821]: line 2 of" in capsys.readouterr().err
    assert run(["trace", str(script), "--process", "SYSTEM", str(tmp_path / "none")]) == 2
    assert run(["gen", str(script), "--process", "Nobody", "-o", out]) == 2


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (b'{"event": "a.0", "time": ' + 400 * b"9" + b"}", None),
        (b'{"event": "a.0", "time": true}', None),
        (100_000 * b"[", "line 1 of"),
        (b'"a.\xff"', "it is not UTF-8: invalid start byte"),
    ],
)
def test_runs_that_no_program_records(
    line: bytes, said: str | None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "s.csp").write_text("channel a : {0..1}\nP = a.0 -> P\n")
    (tmp_path / "run.jsonl").write_bytes(line + b"\n")
    from cspcheck.cli import run

    code = run(["trace", str(tmp_path / "s.csp"), str(tmp_path / "run.jsonl"), "--process", "P"])
    err = capsys.readouterr().err
    assert code == (0 if said is None else 2)
    assert (said or "") in err
    assert "CSP900" not in err


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no pipes in its file system")
def test_a_pipe_is_no_recorded_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "s.csp").write_text("channel a\nP = a -> P\n")
    from cspcheck.cli import run

    os.mkfifo(tmp_path / "pipe")
    assert run(["trace", str(tmp_path / "s.csp"), str(tmp_path / "pipe"), "--process", "P"]) == 2
    assert "it is a folder, a device or a pipe, not a file" in capsys.readouterr().err
