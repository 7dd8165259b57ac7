"""The solver is a process of its own: whatever becomes of it, there is an answer, and the next question has one."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from cspcheck.checker.guard import Guard
from cspcheck.checker.proof import channel, client, kept
from cspcheck.checker.proof.client import SolverClient, SolverProcess
from cspcheck.checker.proof.question import Constraint, Found, Impossible, Question, Request, SolverSettings, Unanswered
from cspcheck.checker.proof.terms import equal, integer
from cspcheck.cspm import caches
from cspcheck.cspm.interruption import Stopped
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Variable
from cspcheck.cspm.source import Source

SPECIFICATION = core.Specification()
X = Variable(type=core.INT, name="x", role="before")
POSSIBLE = Question((Constraint(equal(X, integer(5)), "claim"),), (X,))
IMPOSSIBLE = Question((Constraint(equal(X, integer(5)), "claim"), Constraint(equal(X, integer(6)), "claim")))


@pytest.fixture
def process(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[SolverProcess]:
    """A process of its own for each test, and an empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    made = SolverProcess()
    yield made
    made.end()


def solver(process: SolverProcess, **settings: float) -> SolverClient:
    return SolverClient(SPECIFICATION, settings=SolverSettings(**settings), process=process)  # type: ignore[arg-type]


def running(process: SolverProcess) -> int:
    assert process._process is not None
    return process._process.pid


def test_questions_are_answered_by_one_process(process: SolverProcess) -> None:
    found = solver(process).ask(POSSIBLE)
    assert isinstance(found, Found)
    assert found.values == {X: integer(5)}
    first = running(process)
    assert solver(process).ask(IMPOSSIBLE) == Impossible()
    assert running(process) == first


def test_a_crash_takes_nobody_along(process: SolverProcess) -> None:
    solver(process).ask(POSSIBLE)
    os.kill(running(process), signal.SIGSEGV)
    process._process.wait()  # type: ignore[union-attr]
    assert solver(process).ask(IMPOSSIBLE) == Impossible()


def test_a_crash_in_the_midst_of_a_question_is_told(process: SolverProcess, monkeypatch: pytest.MonkeyPatch) -> None:
    solver(process).ask(POSSIBLE)
    pid = running(process)
    write = os.write
    monkeypatch.setattr(os, "write", lambda number, content: (os.kill(pid, signal.SIGSEGV), write(number, content))[1])
    answer = solver(process).ask(IMPOSSIBLE)
    monkeypatch.undo()
    assert isinstance(answer, Unanswered)
    assert answer.reason.startswith("the solver crashed")


def test_one_that_hangs_is_ended_when_the_time_is_over(process: SolverProcess) -> None:
    solver(process).ask(POSSIBLE)
    pid = running(process)
    os.kill(pid, signal.SIGSTOP)
    answer = solver(process, limit=0.3).ask(IMPOSSIBLE)
    assert answer == Unanswered("the solver did not answer within 0.3 s")
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    assert solver(process).ask(IMPOSSIBLE) == Impossible()


def test_one_that_works_far_too_long_is_ended(process: SolverProcess, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the time that it has worked, not the time that has passed."""
    solver(process).ask(POSSIBLE)
    os.kill(running(process), signal.SIGSTOP)
    seconds = iter([1.0, *([1.5] * 3), *([100.0] * 100)])
    monkeypatch.setattr(client, "_processor_seconds", lambda _: next(seconds))
    assert solver(process).ask(IMPOSSIBLE) == Unanswered("the solver did not answer")


def test_an_obligation_is_given_up_when_the_solver_loses_count_again(
    process: SolverProcess, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Once may be a mishap; then the next question may work as long as it should, and the one after it is not asked."""
    asked = solver(process, seconds=20.0)
    worked: list[float] = []
    ask = process.ask

    def loses_count(*arguments: Any) -> Any:
        worked.append(arguments[3])
        if len(worked) <= 2:
            raise client.LostCount(client.NO_ANSWER)
        return ask(*arguments)

    monkeypatch.setattr(process, "ask", loses_count)
    asked.begin()
    assert not asked.is_late
    for _ in range(3):
        assert asked.ask(IMPOSSIBLE) == Unanswered("the solver did not answer")
    assert (worked, asked.is_late) == ([client.OVERWORK, 1], True)
    asked.begin()
    assert (asked.ask(IMPOSSIBLE), asked.is_late) == (Impossible(), False)


def test_the_time_of_an_obligation_is_shared_by_its_questions(process: SolverProcess) -> None:
    passed = iter([0.0, 1.0, 3.5, 4.5, 5.0, 6.0])
    asked = SolverClient(SPECIFICATION, None, SolverSettings(limit=4.0), lambda: next(passed), process)
    asked.begin()
    assert isinstance(asked.ask(POSSIBLE), Found)
    assert asked.ask(IMPOSSIBLE) == Impossible()
    assert asked.ask(IMPOSSIBLE) == Unanswered("the time limit was reached")
    asked.begin()
    assert asked.ask(IMPOSSIBLE) == Impossible()


def test_each_finding_has_a_time_of_its_own() -> None:
    passed = iter([0.0, 1.0, 2.0, 2.5])
    asked = SolverClient(SPECIFICATION, None, SolverSettings(limit=1.0), lambda: next(passed))
    assert list(asked.one_after_another("ab")) == ["a", "b"]
    assert not asked.is_late


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not tell of parents")
def test_a_solver_that_works_does_not_outlive_who_asked_it() -> None:
    """Somebody who was killed could not end it."""
    busy = "from cspcheck.checker.proof import worker; worker.LOOK = 0.01; worker.leave_with(%d); print(1, flush=True)"
    asking = f"""
import os, subprocess, sys
solver = subprocess.Popen([sys.executable, "-c", {busy!r} % os.getpid() + chr(10) + "while True: pass"], stdout=-1)
solver.stdout.readline()
print(solver.pid, flush=True)
solver.wait()
"""
    with subprocess.Popen([sys.executable, "-c", asking], stdout=subprocess.PIPE, text=True) as running:
        assert running.stdout is not None
        solver_process = int(running.stdout.readline())
        running.kill()
    for _ in range(6_000):
        shown = subprocess.run(
            ["ps", "-o", "stat=", "-p", str(solver_process)], capture_output=True, text=True, check=False
        )
        if shown.stdout.strip() in ("", "Z"):  # a process that waits to be taken note of counts as ended
            return
        time.sleep(0.01)
    raise AssertionError("it goes on")


def test_who_is_stopped_ends_the_solver(process: SolverProcess) -> None:
    solver(process).ask(POSSIBLE)
    pid = running(process)
    os.kill(pid, signal.SIGSTOP)
    with pytest.raises(Stopped) as caught, Guard(seconds=0.0):
        solver(process).ask(IMPOSSIBLE)
    assert caught.value.doing == ["waiting for the solver"]
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def test_nesting_without_measure_is_no_crash(process: SolverProcess) -> None:
    term = equal(X, integer(5))
    for _ in range(100_000):
        term = core.Apply(type=core.BOOL, operator="not", operands=(term,))
    answer = process_answer(process, term)
    assert answer == Unanswered("the question is nested too deeply")
    assert solver(process).ask(IMPOSSIBLE) == Impossible()


def process_answer(process: SolverProcess, term: core.Term) -> object:
    asked = solver(process)
    asked._kept = None
    return asked.ask(Question((Constraint(term, "claim"),)))


class TestKeptAnswers:
    def test_are_there_in_the_next_run_without_a_solver(self, process: SolverProcess) -> None:
        first = solver(process).ask(POSSIBLE), solver(process).ask(IMPOSSIBLE)
        process.end()
        assert (solver(process).ask(POSSIBLE), solver(process).ask(IMPOSSIBLE)) == first
        assert process._process is None

    def test_belong_to_one_question_one_effort_and_one_version(
        self, process: SolverProcess, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        answers = kept.KeptAnswers(SPECIFICATION, None)
        request = Request("ask", POSSIBLE, 10.0, (1, 2), 1)
        requests = [
            request,
            Request("ask", IMPOSSIBLE, 10.0, (1, 2), 1),
            Request("ask", POSSIBLE, 5.0, (1, 2), 1),
            Request("ask", POSSIBLE, 10.0, (1,), 1),
            Request("conflict", POSSIBLE, 10.0, (1, 2), 1),
        ]
        names = [answers.keys(each) for each in requests]
        monkeypatch.setattr(kept, "_versions", lambda: ("other",))
        names.append(answers.keys(request))
        found = [name for name in names if name is not None]
        assert len({whole for _, whole in found}) == 6
        # What is proved holds whatever the effort.
        assert len({proved for proved, _ in found}) == 5
        assert found[0][0] == found[2][0]

    def test_a_proof_is_one_whatever_the_effort(self, process: SolverProcess) -> None:
        first = solver(process, seconds=4.0)
        first.ask(IMPOSSIBLE)
        first.ask(POSSIBLE)
        process.end()
        assert solver(process, seconds=10.0).ask(IMPOSSIBLE) == Impossible()
        assert process._process is None
        solver(process, seconds=10.0).ask(POSSIBLE)
        assert process._process is not None

    def test_a_limit_in_time_finds_what_an_earlier_run_with_it_has_kept(self, process: SolverProcess) -> None:
        solver(process, limit=4.0).ask(POSSIBLE)
        process.end()
        later = SolverClient(SPECIFICATION, settings=SolverSettings(limit=4.0), process=process)
        passed = iter([0.0, 0.9, 0.9])
        later._clock = lambda: next(passed)
        later.begin()
        assert isinstance(later.ask(POSSIBLE), Found)
        assert process._process is None

    def test_do_not_depend_on_where_something_stands(self, process: SolverProcess) -> None:
        answers = kept.KeptAnswers(SPECIFICATION, None)
        source = Source("x.csp", "some text")
        here = Question((Constraint(equal(X, integer(5)), "claim", source.span(0, 4)),), (X,))
        there = Question((Constraint(equal(X, integer(5)), "claim", source.span(5, 9)),), (X,))
        assert answers.keys(Request("ask", here, 1.0, (), 1)) == answers.keys(Request("ask", there, 1.0, (), 1))

    def test_a_damaged_one_is_found_anew(self, process: SolverProcess, tmp_path: Path) -> None:
        solver(process).ask(IMPOSSIBLE)
        (path,) = [path for path in (tmp_path / "cspcheck" / "proofs").rglob("*") if path.is_file()]
        whole = path.read_bytes()
        for damage in (b"", whole[:-1], b"cos\nsystem\n(S'true'\ntR."):
            path.write_bytes(damage)
            assert solver(process).ask(IMPOSSIBLE) == Impossible()
            assert path.read_bytes() == whole

    def test_damage_is_told_once(
        self,
        process: SolverProcess,
        tmp_path: Path,
        caplog: pytest.LogCaptureFixture,
        monkeypatch: pytest.MonkeyPatch,
    ) -> None:
        monkeypatch.setattr(caches, "_told", set())
        solver(process).ask(IMPOSSIBLE)
        solver(process).ask(POSSIBLE)
        folder = tmp_path / "cspcheck" / "proofs"
        for path in [path for path in folder.rglob("*") if path.is_file()]:
            path.write_bytes(b"")
        assert solver(process).ask(IMPOSSIBLE) == Impossible()
        assert isinstance(solver(process).ask(POSSIBLE), Found)
        assert caplog.messages == [f"the cache `{folder}` has damaged files, which are made anew"]

    def test_that_one_was_ended_is_not_kept(self, process: SolverProcess, tmp_path: Path) -> None:
        solver(process).ask(POSSIBLE)
        os.kill(running(process), signal.SIGSTOP)
        solver(process, limit=0.1).ask(IMPOSSIBLE)
        assert solver(process).ask(IMPOSSIBLE) == Impossible()

    def test_the_oldest_go_when_there_are_too_many(self, tmp_path: Path) -> None:
        (tmp_path / "ab").mkdir()
        for age, name in enumerate("xyz"):
            (tmp_path / "ab" / name).write_bytes(bytes(100))
            os.utime(tmp_path / "ab" / name, (time.time() - age, time.time() - age))
        kept.tidy(tmp_path, 250)
        assert sorted(path.name for path in (tmp_path / "ab").iterdir()) == ["x", "y"]

    def test_one_in_many_looks_at_how_large_all_are(
        self, process: SolverProcess, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """Whoever keeps it: a program that asks a single question looks, too, now and then."""
        looked: list[str] = []
        solver(process).ask(POSSIBLE)  # makes the folder
        monkeypatch.setattr(kept, "tidy", lambda folder: looked.append(key))
        for number in range(1024):
            key = f"{number * 0x10001 % 2**32:08x}".ljust(64, "0")
            kept.KeptAnswers(SPECIFICATION, None).keep((key, key), Impossible(), ())
        assert 4 <= len(looked) <= 16


def test_only_values_of_ours_can_be_received() -> None:
    import pickle

    class Evil:
        def __reduce__(self) -> object:
            return (os.system, ("true",))

    with pytest.raises(channel.ForeignValue):
        channel.unpacked(pickle.dumps(Evil()), channel.Sources())
    with pytest.raises(channel.ForeignValue):
        channel.unpacked(b"nonsense", channel.Sources())
