"""Files are written whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from cspcheck.cli.streams import OutputLost, StandardOutput, output_to, replace_text
from cspcheck.cspm.diagnostics import ScriptError


def test_the_file_appears_when_all_is_written(tmp_path: Path) -> None:
    path = tmp_path / "result.json"
    with output_to(str(path)) as output:
        output.write("one ")
        assert not path.exists()
        output.write("two ✓")

    assert path.read_text(encoding="utf-8") == "one two ✓"
    assert os.listdir(tmp_path) == ["result.json"]


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "result.json"
    path.write_text("old")

    def write_and_fail() -> None:
        with output_to(str(path)) as output:
            output.write("new")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        write_and_fail()

    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["result.json"]


def test_permissions_are_those_of_the_old_file_or_the_usual_ones(tmp_path: Path) -> None:
    old, new, usual = tmp_path / "old", tmp_path / "new", tmp_path / "usual"
    old.write_text("")
    old.chmod(0o640)
    usual.write_text("")
    for path in (old, new):
        replace_text(str(path), "text")

    assert stat.S_IMODE(old.stat().st_mode) == 0o640
    assert new.stat().st_mode == usual.stat().st_mode


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    real, link = tmp_path / "real", tmp_path / "link"
    real.write_text("old")
    link.symlink_to(real)
    replace_text(str(link), "new")

    assert link.is_symlink()
    assert real.read_text() == "new"


def test_a_folder_that_is_missing_is_told_at_once(tmp_path: Path) -> None:
    with pytest.raises(ScriptError) as caught:
        output_to(str(tmp_path / "missing" / "result.json"))

    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "CSP905"
    assert diagnostic.message == f"cannot write `{tmp_path}/missing/result.json`: No such file or directory"


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(ScriptError) as caught:
        output_to(str(tmp_path))

    assert caught.value.diagnostics[0].message == f"cannot write `{tmp_path}`: Is a directory"


def test_a_device_is_written_and_stays_a_device() -> None:
    with output_to(os.devnull) as output:
        output.write("text")

    assert stat.S_ISCHR(os.stat(os.devnull).st_mode)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="this system has no device that is always full")
class TestFullDisk:
    def test_standard_output(self, monkeypatch: pytest.MonkeyPatch) -> None:
        with open("/dev/full", "w") as full:
            monkeypatch.setattr("sys.stdout", full)
            with pytest.raises(OutputLost) as caught:
                StandardOutput().write("text")
            monkeypatch.undo()
            with contextlib.suppress(OSError):
                full.close()

        assert caught.value.diagnostic.message == "cannot write `standard output`: No space left on device"

    def test_a_device(self) -> None:
        with pytest.raises(OutputLost) as caught, output_to("/dev/full") as output:
            output.write("text")

        assert caught.value.diagnostic.message == "cannot write `/dev/full`: No space left on device"

    @pytest.mark.parametrize("verb", [["check"], ["explain", "CSP101"], ["--help"], ["check", "--format", "json"]])
    def test_the_command_says_so(self, verb: list[str], tmp_path: Path) -> None:
        (tmp_path / "x.csp").write_text("assert STOP [T= STOP\n")
        files = [str(tmp_path / "x.csp")] if verb[0] == "check" else []
        with open("/dev/full", "w") as full:
            done = subprocess.run(
                [sys.executable, "-m", "cspcheck", *verb, *files], stdout=full, stderr=subprocess.PIPE, text=True
            )

        said = "error[CSP905]: cannot write `standard output`: No space left on device"
        assert (done.returncode, done.stderr.strip()) == (2, said)


@pytest.mark.parametrize("moment", ["write", "flush"])
def test_a_disk_that_fills_up_leaves_the_old_file_and_nothing_else(moment: str, tmp_path: Path) -> None:
    path = tmp_path / "result.json"
    path.write_text("old")

    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    def write() -> None:
        with output_to(str(path)) as output:
            output.stream = type("Full", (), {"write": fail if moment == "write" else id, "flush": fail, "close": fail})
            output.write("new")

    with pytest.raises(OutputLost) as caught:
        write()

    assert caught.value.diagnostic.message == f"cannot write `{path}`: No space left on device"
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["result.json"]
