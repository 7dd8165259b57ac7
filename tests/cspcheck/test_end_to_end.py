"""The command from the shell on scripts that are right: results, streams, selection, exit codes."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from syrupy.assertion import SnapshotAssertion

from cspcheck.cli import run

ROOT = Path(__file__).resolve().parents[2]

PHILOSOPHERS = """\
-- Two philosophers who take their left fork first.
N = 2
Ids = {0..N-1}
channel takes, puts : Ids.Ids
channel eats : Ids
Phil(i) = takes.i.i -> takes.i.(i+1)%N -> eats.i -> puts.i.i -> puts.i.(i+1)%N -> Phil(i)
Fork(i) = takes?p!i -> puts.p.i -> Fork(i)
Table = (||| i : Ids @ Phil(i)) [| {| takes, puts |} |] (||| i : Ids @ Fork(i))

assert Table :[deadlock free]
assert Table :[divergence free]  -- a second one
-- expect: fail
assert Table :[deadlock free [F]]
"""
BUFFER = """\
channel left, mid, right : {0..1}
Copy(i, o) = i?x -> o!x -> Copy(i, o)
One = Copy(left, right)
Two = (Copy(left, mid) [| {| mid |} |] Copy(mid, right)) \\ {| mid |}
assert One [T= Two
assert not One [T= Two
assert Two [F= One
assert (left?x -> STOP |~| STOP) :[deterministic]
assert (Copy(left, mid) \\ {| left, mid |}) :[divergence free]
assert One :[has trace]: <left.0, right.1>
"""


Shell = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def shell(folder: Path, environment: dict[str, str]) -> Shell:
    """Runs the command in the folder of the scripts."""

    def run_command(*arguments: str, stdin: str | None = None) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", "cspcheck", *arguments],
            cwd=folder,
            env=environment,
            input=stdin,
            capture_output=True,
            encoding="utf-8",
            check=False,
            timeout=120,
        )

    return run_command


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "table.csp").write_text(PHILOSOPHERS)
    (tmp_path / "buffer.csp").write_text(BUFFER)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def document(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, dict[str, Any]]:
    code = run([*arguments, "--format", "json"])
    parsed: dict[str, Any] = json.loads(capsys.readouterr().out)
    return code, parsed


def timeless(text: str) -> str:
    return re.sub(r" +\d+\.\d+ s\b", " ... s", text)


@pytest.mark.parametrize("script", ["table.csp", "buffer.csp"])
def test_what_people_see(
    folder: Path, capsys: pytest.CaptureFixture[str], script: str, snapshot: SnapshotAssertion
) -> None:
    assert run([script]) == 1
    out, err = capsys.readouterr()

    assert err == ""
    assert timeless(out) == snapshot


def test_the_document(folder: Path, capsys: pytest.CaptureFixture[str], snapshot: SnapshotAssertion) -> None:
    code, found = document(capsys, "table.csp")
    for result in found["results"]:
        assert result.pop("seconds") >= 0
        assert result.pop("peak_memory_bytes") >= 0

    assert code == 1
    assert found == snapshot


def test_the_same_document_whatever_the_workers(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def found(*options: str) -> dict[str, Any]:
        _, parsed = document(capsys, "table.csp", "buffer.csp", *options)
        for result in parsed["results"]:
            del result["seconds"], result["peak_memory_bytes"]
        return parsed

    assert found("--workers", "1") == found("--workers", "2") == found()


class TestSelection:
    def texts(self, capsys: pytest.CaptureFixture[str], *arguments: str) -> list[str]:
        _, found = document(capsys, *arguments)
        return [result["assertion"] for result in found["results"]]

    def test_by_pattern(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert self.texts(capsys, "table.csp", "buffer.csp", "--assert", "Table*divergence", "--assert", "[F= One") == [
            "Table :[divergence free]",
            "Two [F= One",
        ]

    def test_by_line(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert self.texts(capsys, "table.csp:11", "buffer.csp:7") == ["Table :[divergence free]", "Two [F= One"]

    def test_a_folder(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        _, found = document(capsys, ".")
        assert [result["file"] for result in found["results"]] == ["./buffer.csp"] * 6 + ["./table.csp"] * 3


class TestStreams:
    def test_standard_input(self, shell: Shell) -> None:
        done = shell("-", "--assert", "divergence", stdin=PHILOSOPHERS)

        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.startswith("<stdin>\n✓ Table :[divergence free]")

    def test_a_terminal_that_knows_ascii_only(self, folder: Path, environment: dict[str, str]) -> None:
        done = subprocess.run(
            [sys.executable, "-m", "cspcheck", "table.csp"],
            cwd=folder,
            env={**environment, "PYTHONIOENCODING": "ascii"},
            capture_output=True,
            check=False,
            timeout=60,
        )

        assert done.returncode == 1
        assert done.stdout.decode("ascii").startswith("table.csp\nx Table :[deadlock free]")

    def test_a_result_file(self, folder: Path, shell: Shell) -> None:
        done = shell("table.csp", "--format", "json", "-o", "result.json")

        assert (done.returncode, done.stdout, done.stderr) == (1, "", "")
        assert len(json.loads((folder / "result.json").read_text())["results"]) == 3
        assert sorted(os.listdir(folder)) == ["buffer.csp", "result.json", "table.csp"]

    def test_color_on_demand(self, shell: Shell) -> None:
        assert "\x1b[" in shell("table.csp", "--color", "always").stdout
        assert "\x1b[" not in shell("table.csp").stdout

    def test_a_reader_that_leaves_early_is_no_accident(self, folder: Path, environment: dict[str, str]) -> None:
        with subprocess.Popen(
            [sys.executable, "-m", "cspcheck", *["table.csp", "buffer.csp"], "--format", "jsonl"],
            cwd=folder,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        ) as process:
            assert process.stdout is not None
            assert process.stderr is not None
            process.stdout.close()
            assert process.stderr.read() == b""
            assert process.wait(60) == 141

    def test_closed_streams_are_no_accident(self, folder: Path, environment: dict[str, str]) -> None:
        command = f"{sys.executable} -m cspcheck table.csp >&- 2>&-"

        assert subprocess.run(["sh", "-c", command], cwd=folder, env=environment, check=False).returncode == 1


class TestDefinitions:
    def test_a_constant(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        code, found = document(capsys, "table.csp:10", "-D", "N=3", "--full")

        assert code == 1
        assert len(found["results"][0]["counterexample"]["trace"]) == 3

    def test_a_name_that_there_is_not(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        code, found = document(capsys, "table.csp", "-D", "M=3")

        assert code == 2
        assert "`M`" in found["diagnostics"][0]["message"]

    def test_an_expression_that_is_none(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["table.csp", "-D", "N=(3"]) == 2
        assert "error[CSP1" in capsys.readouterr().err


ENDLESS = "channel a : {0..9}\nP(n) = a?x -> P(n + x + 1)\nassert P(0) :[deadlock free]\n"


class TestLimits:
    @pytest.mark.parametrize("limit", [["--timeout", "1s"], ["--max-states", "500"], ["--max-memory", "3MiB"]])
    def test_a_script_without_end_ends_as_unknown(
        self, folder: Path, capsys: pytest.CaptureFixture[str], limit: list[str]
    ) -> None:
        (folder / "endless.csp").write_text(ENDLESS)
        code, found = document(capsys, "endless.csp", *limit)

        assert code == 3
        assert found["results"][0]["verdict"] == "unknown"
        assert found["results"][0]["reason"]

    def test_the_time_is_that_of_each_assertion(self, folder: Path, environment: dict[str, str]) -> None:
        (folder / "endless.csp").write_text(ENDLESS + "assert STOP [T= STOP\nassert P(1) :[deadlock free]\n")
        # In a process of its own: one that has run thousands of tests takes long to give memory back.
        command = [sys.executable, "-m", "cspcheck", "endless.csp", "--timeout", "2s", "--format", "json"]
        ended = subprocess.run(command, cwd=folder, env=environment, capture_output=True, check=False)

        assert ended.returncode == 3
        found = json.loads(ended.stdout)
        assert [result["verdict"] for result in found["results"]] == ["unknown", "pass", "unknown"]


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_a_search_and_prints_what_was_finished(
    how: signal.Signals, folder: Path, environment: dict[str, str]
) -> None:
    (folder / "endless.csp").write_text(ENDLESS.replace("assert", "assert STOP [T= STOP\nassert", 1))
    with subprocess.Popen(
        [sys.executable, "-m", "cspcheck", "endless.csp", "--format", "jsonl"],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
    ) as process:
        assert process.stdout is not None
        first = json.loads(process.stdout.readline())
        time.sleep(0.5)
        process.send_signal(how)
        out, err = process.communicate(timeout=30)

    assert first["verdict"] == "pass"
    rest = [json.loads(line) for line in out.splitlines()]
    assert {(result["verdict"], result["reason"]) for result in rest[:-1]} == {("unknown", "interrupted")}
    assert rest[-1] == {"interrupted": True}
    assert (process.returncode, err) == (130, "")


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_keeps_the_document_and_leaves_no_other_file(
    how: signal.Signals, folder: Path, environment: dict[str, str]
) -> None:
    (folder / "endless.csp").write_text(ENDLESS.replace("assert", "assert STOP [T= STOP\nassert", 1))
    before = set(os.listdir(folder))
    with subprocess.Popen(
        [sys.executable, "-m", "cspcheck", "endless.csp", "--format", "json", "-o", "result.json"],
        cwd=folder,
        env=environment,
        stderr=subprocess.PIPE,
        encoding="utf-8",
    ) as process:
        while not any(name.endswith(".tmp") for name in os.listdir(folder)):
            time.sleep(0.05)
        time.sleep(1)
        process.send_signal(how)
        _, err = process.communicate()

    assert (process.returncode, err) == (130, "")
    assert set(os.listdir(folder)) - before == {"result.json"}
    assert json.loads((folder / "result.json").read_text())["schema"] == "cspcheck/1"


@pytest.mark.parametrize("wait", [0.0, 0.02, 0.05, 0.1, 0.2])
def test_a_signal_in_the_first_moments_ends_the_command_without_a_traceback(
    wait: float, folder: Path, environment: dict[str, str]
) -> None:
    (folder / "endless.csp").write_text(ENDLESS)
    with subprocess.Popen(
        [sys.executable, "-c", "from cspcheck.__main__ import main; print('begun', flush=True); main()", "endless.csp"],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(0.1 + wait)
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate()

    assert (process.returncode, err.strip()) == (130, "")


def test_a_small_script_needs_no_compiler(environment: dict[str, str]) -> None:
    """A small machine is searched by interpretation: the libraries that take long to import stay out."""
    script = ROOT / "specs/producer_consumer/producer_consumer.csp"
    code = (
        f"import sys; from cspcheck.cli import run; run([{str(script)!r}]); "
        "print(sorted({'llvmlite', 'networkx', 'z3', 'jinja2'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)

    assert done.stdout.splitlines()[-1] == "[]"
