"""``--watch``: what changes is checked again, nothing else, until Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from cspcheck.cli import run
from cspcheck.cli.watching import Goal, watch
from cspcheck.result import Exit
from cspcheck.selection import included_files, targets
from tests.cspcheck.interrupting import LISTENING

GOOD = "channel a\nP = a -> P\nassert P :[deadlock free]\n"
BAD = "channel a\nP = a -> STOP\nassert P :[deadlock free]\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(path: str, text: str) -> None:
    """A change that is seen however coarse the clock of the file system is, made as editors make it."""
    Path(path + "~").write_text(text)
    os.replace(path + "~", path)


def checked(arguments: list[str], *edits: Callable[[], object]) -> tuple[list[list[str]], Exit]:
    """What is checked, after the beginning and after each edit; Ctrl-C comes behind the last."""
    found: list[list[str]] = []
    pending = list(edits)

    def check(goals: Sequence[Goal]) -> Exit:
        found.append([goal.path for goal in goals])
        return Exit(len(found))

    def wait(seconds: float) -> None:
        if not pending:
            raise KeyboardInterrupt
        pending.pop(0)()

    code = watch(lambda: targets(arguments), check, lambda line: None, wait)
    return found, code


class TestWhatIsCheckedAgain:
    def test_nothing_without_a_change(self, folder: Path) -> None:
        write("x.csp", GOOD)
        assert checked(["x.csp"], lambda: None, lambda: None) == ([["x.csp"]], Exit(1))

    def test_the_script_that_changes(self, folder: Path) -> None:
        write("x.csp", GOOD)
        write("y.csp", GOOD)
        found, code = checked(["x.csp", "y.csp"], lambda: write("y.csp", BAD), lambda: write("x.csp", BAD))

        assert found == [["x.csp", "y.csp"], ["y.csp"], ["x.csp"]]
        assert code is Exit(3)

    def test_a_script_whose_include_changes(self, folder: Path) -> None:
        write("x.csp", 'include "d/i.csp"\n')
        write("y.csp", GOOD)
        Path("d").mkdir()
        write("d/i.csp", 'include "j.csp"\n')
        write("j.csp", GOOD)
        found, _ = checked(["x.csp", "y.csp"], lambda: write("j.csp", BAD), lambda: write("d/i.csp", ""))

        assert found == [["x.csp", "y.csp"], ["x.csp"], ["x.csp"]]

    def test_a_file_that_is_away_for_a_moment(self, folder: Path) -> None:
        write("x.csp", GOOD)
        found, _ = checked(["x.csp"], lambda: os.rename("x.csp", "z"), lambda: os.rename("z", "x.csp"))
        assert found == [["x.csp"]]

    def test_a_file_that_comes(self, folder: Path) -> None:
        found, _ = checked(["x.csp"], lambda: write("x.csp", GOOD))
        assert found == [["x.csp"], ["x.csp"]]

    def test_a_new_script_of_a_folder(self, folder: Path) -> None:
        write("x.csp", GOOD)
        found, _ = checked(["."], lambda: write("y.csp", GOOD))
        assert [[os.path.basename(path) for path in paths] for paths in found] == [["x.csp"], ["y.csp"]]

    def test_includes_in_a_circle_end(self, folder: Path) -> None:
        write("x.csp", 'include "y.csp"\n')
        write("y.csp", 'include "x.csp"\n')
        assert included_files("x.csp") == ["y.csp", "x.csp"]


def test_standard_input_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", "--watch", "-"]) == 2
    assert "standard input cannot be watched" in capsys.readouterr().err


def test_as_a_user_sees_it(folder: Path) -> None:
    write("x.csp", GOOD)
    with subprocess.Popen(
        [sys.executable, "-m", "cspcheck", "x.csp", "--watch", "--format", "concise"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=LISTENING,
    ) as program:
        try:
            assert program.stdout is not None
            assert program.stderr is not None
            assert program.stdout.readline() == "x.csp:3: pass: P :[deadlock free]\n"
            assert "watching 1 file; Ctrl-C ends" in program.stderr.readline()
            write("x.csp", BAD)
            assert program.stdout.readline().startswith("x.csp:3: fail: ")
            assert "watching" in program.stderr.readline()
            program.send_signal(signal.SIGINT)
            assert program.wait(60) == 1
            assert program.stderr.read() == ""
        finally:
            program.kill()
