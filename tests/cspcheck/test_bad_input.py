"""Wrong scripts from the shell, word for word: a message with its place, an exit code, never a traceback."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from syrupy.assertion import SnapshotAssertion

from cspcheck.cli import run

SCRIPTS: dict[str, tuple[str | bytes | None, int]] = {
    "missing file": (None, 2),
    "syntax error": ("channel a\nP = a -> -> P\nassert P :[deadlock free]\n", 2),
    "unfinished": ("channel a\nP = a -> (", 2),
    "undefined name": (
        "channel send, receive\nBuffer = send -> recieve -> Buffer\nassert Buffer :[deadlock free]\n",
        2,
    ),
    "wrong argument count": (
        "channel a : {0..3}\nCell(x) = a!x -> Cell(x)\nassert Cell(1, 2) :[deadlock free]\n",
        2,
    ),
    "non-finite set": ("channel a : Int\nP = [] x : Int @ a!x -> STOP\nassert P :[deadlock free]\n", 2),
    "infinite data recursion": ("channel a\nP(n) = a -> P(n+1)\nassert P(0) :[deadlock free]\n", 3),
    "unguarded recursion": ("channel a\nP = P [] a -> STOP\nassert P :[deadlock free]\n", 2),
    "value outside its channel": ("channel a : {0..3}\nP = a.7 -> STOP\nassert P :[deadlock free]\n", 2),
    "type error": ("channel a\nP = if 1 then a -> STOP else STOP\nassert P :[deadlock free]\n", 2),
    "failing evaluation": ("P(s) = if head(s) then STOP else SKIP\nassert P(<>) :[deadlock free]\n", 2),
    "missing include": ('include "nowhere.csp"\nassert STOP [T= STOP\n', 2),
    "rich text": (rb"{\rtf1\ansi P = STOP}", 2),
    "binary": (b"P = \x00\x01", 2),
    "no assertions": ("P = STOP\n", 5),
    "empty": ("", 5),
}


Shell = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def shell(folder: Path, environment: dict[str, str]) -> Shell:
    """Runs the command in the folder of the scripts."""

    def run_command(*arguments: str, stdin: bytes | None = None) -> subprocess.CompletedProcess[str]:
        done = subprocess.run(
            [sys.executable, "-m", "cspcheck", *arguments],
            cwd=folder,
            env=environment,
            input=stdin,
            capture_output=True,
            check=False,
            timeout=60,
        )
        return subprocess.CompletedProcess(arguments, done.returncode, done.stdout.decode(), done.stderr.decode())

    return run_command


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, (content, _) in SCRIPTS.items():
        if content is not None:
            data = content if isinstance(content, bytes) else content.encode()
            (tmp_path / f"{name.replace(' ', '_')}.csp").write_bytes(data)
    return tmp_path


def timeless(text: str) -> str:
    """The output without the times, which differ from run to run."""
    return re.sub(r" +\d+\.\d+ s\b", " ... s", text)


@pytest.mark.parametrize("name", SCRIPTS)
def test_word_for_word(
    folder: Path,
    name: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    snapshot: SnapshotAssertion,
) -> None:
    monkeypatch.chdir(folder)
    code = run([f"{name.replace(' ', '_')}.csp", "--max-states", "1000"])
    out, err = capsys.readouterr()

    assert code == SCRIPTS[name][1]
    assert f"{timeless(out)}--- standard error\n{err}" == snapshot


def test_from_the_shell(folder: Path, shell: Shell) -> None:
    names = [f"{name.replace(' ', '_')}.csp" for name in SCRIPTS]
    done = shell(*names, "--max-states", "1000")

    assert done.returncode == 2
    assert "Traceback" not in done.stdout + done.stderr
    assert done.stderr.count("error[CSP") == sum(code == 2 for _, code in SCRIPTS.values())


def test_all_of_them_in_one_document(folder: Path, shell: Shell) -> None:
    """One bad file does not stop the others, and every diagnostic has its place."""
    names = [f"{name.replace(' ', '_')}.csp" for name in SCRIPTS]
    done = shell(*names, "--max-states", "1000", "--format", "json")
    document = json.loads(done.stdout)

    assert done.returncode == 2
    assert {d["file"] for d in document["diagnostics"] if d["file"]} <= set(names)
    assert len(document["diagnostics"]) >= sum(code == 2 for _, code in SCRIPTS.values())
    assert [r["verdict"] for r in document["results"]] == ["error", "unknown", "error", "error", "error"]
    assert document["summary"]["unknown"] == 1


def test_typecheck_finds_what_can_be_found_without_checking(folder: Path, shell: Shell) -> None:
    done = shell("typecheck", "undefined_name.csp", "wrong_argument_count.csp", "unguarded_recursion.csp")

    assert done.returncode == 2
    assert "error[CSP201]: `recieve` is not defined" in done.stdout
    assert "✓ unguarded_recursion.csp" in done.stdout
    assert done.stdout.endswith("1 script without errors, 2 scripts with errors\n")
    assert done.stderr == ""


def test_a_folder_that_is_named_as_output_and_a_script_that_is_a_folder(folder: Path, shell: Shell) -> None:
    (folder / "empty").mkdir()
    done = shell("empty")

    assert done.returncode == 5
    assert done.stderr == "warning[CSP904]: no `.csp` files below `empty`\n\n"


def test_what_is_no_script_by_its_name(folder: Path, shell: Shell) -> None:
    (folder / "paper.md").write_text("\\begin{document}")
    done = shell("paper.md")

    assert done.returncode == 2
    assert done.stderr == "error[CSP909]: `paper.md` is not a CSPm script: `.md` files cannot be checked\n\n"


def test_a_file_that_may_not_be_read(folder: Path, shell: Shell) -> None:
    if os.geteuid() == 0:
        pytest.skip("root may read everything")
    (folder / "secret.csp").write_text("P = STOP\n")
    (folder / "secret.csp").chmod(0)
    done = shell("secret.csp")

    assert done.returncode == 2
    assert "error[CSP001]: cannot read `secret.csp`: permission denied" in done.stderr


def test_bytes_from_standard_input_may_be_anything(folder: Path, shell: Shell) -> None:
    done = shell("-", stdin=bytes(range(1, 256)))

    assert done.returncode == 2
    assert "error[CSP0" in done.stderr
    assert " --> <stdin>:1:1\n" in done.stderr
    assert not any(ord(c) < 32 and c != "\n" for c in done.stderr)
