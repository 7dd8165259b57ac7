"""Verbs, options, help, and what is said of wrong ones."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from syrupy.assertion import SnapshotAssertion

from cspcheck import __version__, checking
from cspcheck.cli import VERBS, front_door, run
from cspcheck.cli.check import command as check_command

ROV = Path(__file__).resolve().parents[3] / "specs" / "rov" / "rov.csp"


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = run(arguments)
    out, err = capsys.readouterr()
    return code, out, err


class TestHelp:
    def test_of_the_command(self, capsys: pytest.CaptureFixture[str], snapshot: SnapshotAssertion) -> None:
        assert said(capsys, "--help") == (0, snapshot, "")

    def test_without_arguments_it_goes_to_standard_error(self, capsys: pytest.CaptureFixture[str]) -> None:
        code, out, err = said(capsys)

        assert (code, out) == (2, "")
        assert err.startswith("Usage: cspcheck [VERB] [OPTIONS] FILE...\n")

    @pytest.mark.parametrize("verb", VERBS)
    def test_of_a_verb(self, verb: str, capsys: pytest.CaptureFixture[str], snapshot: SnapshotAssertion) -> None:
        assert said(capsys, verb, "--help") == (0, snapshot, "")

    @pytest.mark.parametrize("verb", VERBS)
    def test_the_short_text_is_that_of_the_verb_itself(self, verb: str) -> None:
        with front_door.make_context("cspcheck", [verb], resilient_parsing=True) as context:
            command = front_door.get_command(context, verb)

        assert command is not None
        assert VERBS[verb].removesuffix(".").startswith(str(command.short_help).removesuffix("."))

    def test_behind_a_file_it_is_that_of_check(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert said(capsys, "x.csp", "--help") == said(capsys, "check", "--help")

    def test_version(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert said(capsys, "--version") == (0, f"cspcheck {__version__}\n", "")


class TestArrangement:
    """``check`` need not be said, and options may stand before the verb."""

    @pytest.mark.parametrize(
        ("given", "meant"),
        [
            ("x.csp", "check x.csp"),
            ("check x.csp", "check x.csp"),
            ("-", "check -"),
            ("-q x.csp", "check -q x.csp"),
            ("--format json x.csp", "check --format json x.csp"),
            ("--format=json typecheck x.csp", "typecheck --format=json x.csp"),
            ("-o typecheck x.csp", "check -o typecheck x.csp"),
            ("-q -v typecheck x.csp", "typecheck -q -v x.csp"),
            ("x.csp typecheck", "check x.csp typecheck"),
            ("-- typecheck", "check -- typecheck"),
            ("./explain", "check ./explain"),
            ("--timeout 5m --help", "check --timeout 5m --help"),
            ("--help", "--help"),
        ],
    )
    def test_of(self, given: str, meant: str) -> None:
        with front_door.make_context("cspcheck", ["check"], resilient_parsing=True) as context:
            assert front_door._arrange(context, given.split()) == meant.split()


@pytest.mark.parametrize(
    ("arguments", "message", "command"),
    [
        (["check"], "missing argument 'FILE...'", "cspcheck check"),
        (
            ["--max-states", "x", "a.csp"],
            "invalid value for '--max-states': `x` is not a whole number above zero",
            None,
        ),
        (
            ["--max-states", "0", "a.csp"],
            "invalid value for '--max-states': `0` is not a whole number above zero",
            None,
        ),
        (
            ["a.csp", "--timeout", "soon"],
            "invalid value for '--timeout': `soon` is not a time; write it like 90s, 5m or 1h30m",
            None,
        ),
        (["a.csp", "--timeout", "0"], "invalid value for '--timeout': `0` is not a time above zero", None),
        (
            ["a.csp", "--max-memory", "lots"],
            "invalid value for '--max-memory': `lots` is not a size; write it like 512MiB, 8GiB or 2GB",
            None,
        ),
        (["a.csp", "-D", "N"], "invalid value for '-D': `N` is not NAME=EXPR", None),
        (["a.csp", "-D", "=3"], "invalid value for '-D': `=3` is not NAME=EXPR", None),
    ],
)
def test_wrong_usage(
    capsys: pytest.CaptureFixture[str], arguments: list[str], message: str, command: str | None
) -> None:
    code, out, err = said(capsys, *arguments)

    assert (code, out) == (2, "")
    assert err.splitlines()[0].rstrip(".").lower() == f"error[csp901]: {message}".lower()
    assert err.splitlines()[1] == f"  = help: `{command or 'cspcheck check'} --help` lists what there is"


def test_an_option_that_there_is_not(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = said(capsys, "a.csp", "--xyz")

    assert (code, out) == (2, "")
    assert err.startswith("error[CSP901]: no such option")
    assert "--xyz" in err


def test_an_option_that_is_nearly_right_gets_a_hint(capsys: pytest.CaptureFixture[str]) -> None:
    assert "--timeout" in said(capsys, "a.csp", "--timout", "5")[2]


def test_a_result_file_that_cannot_be_written_is_told_before_anything_is_checked(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(checking, "load", lambda *_: pytest.fail("it was loaded"))
    code, out, err = said(capsys, "a.csp", "-o", str(tmp_path / "no" / "x.json"))

    assert (code, out) == (2, "")
    assert err == f"error[CSP905]: cannot write `{tmp_path}/no/x.json`: No such file or directory\n\n"


def test_the_settings_are_what_the_options_say(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    seen: list[checking.Settings] = []

    def load(path: str, settings: checking.Settings) -> object:
        seen.append(settings)
        raise KeyboardInterrupt

    monkeypatch.setattr(checking, "load", load)
    options = "--full --timeout 5m --max-memory 1GiB --max-states 1000 --workers 3 -D N=2+1 -D M=true --no-typecheck"
    assert run(["a.csp", *options.split()]) == 130
    assert run(["a.csp"]) == 130

    given, default = seen
    assert (given.limits.seconds, given.limits.memory_bytes, given.limits.states) == (300, 1024**3, 1000)
    assert (given.full, given.workers, given.typecheck) == (True, 3, False)
    assert given.definitions == {"N": "2+1", "M": "true"}
    assert (default.limits.seconds, default.limits.states) == (None, None)
    assert default.limits.memory_bytes == checking.default_memory_limit()
    assert (default.full, default.workers, default.typecheck, dict(default.definitions)) == (False, None, True, {})


def test_the_memory_limit_is_four_fifths_of_what_there_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checking, "machine_memory", lambda: 10_000)
    assert checking.default_memory_limit() == 8_000

    monkeypatch.setattr(checking, "machine_memory", lambda: None)
    assert checking.default_memory_limit() is None


class TestCompletion:
    @pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
    def test_the_script_of_a_shell(self, capsys: pytest.CaptureFixture[str], shell: str) -> None:
        code, out, err = said(capsys, "completion", shell)

        assert (code, err) == (0, "")
        assert "_CSPCHECK_COMPLETE=" in out

    @pytest.mark.parametrize(
        ("words", "candidate"),
        [
            ("cspcheck type", "plain,typecheck"),
            ("cspcheck ro", "file,ro"),
            ("cspcheck --max-m", "plain,--max-memory"),
            ("cspcheck --format js", "plain,json"),
            ("cspcheck x.csp --col", "plain,--color"),
            ("cspcheck x.csp ro", "file,ro"),
            ("cspcheck completion z", "plain,zsh"),
            ("cspcheck explain csp91", "plain,CSP913"),
            ("cspcheck examples cl", "plain,classics"),
            (f"cspcheck probe {ROV} ROV", "plain,ROV_Control_Module"),
            (f"cspcheck graph {ROV} Comp", "plain,Compass"),
        ],
    )
    def test_what_is_completed(self, environment: dict[str, str], words: str, candidate: str) -> None:
        done = subprocess.run(
            [sys.executable, "-m", "cspcheck"],
            env={
                **environment,
                "_CSPCHECK_COMPLETE": "bash_complete",
                "COMP_WORDS": words,
                "COMP_CWORD": str(len(words.split()) - 1),
            },
            capture_output=True,
            text=True,
            check=False,
        )

        assert candidate in done.stdout.splitlines()
        assert done.stderr == ""


class TestStart:
    def test_help_imports_nothing_heavy(self, environment: dict[str, str]) -> None:
        heavy = ["numpy", "llvmlite", "lark", "networkx", "z3", "cspcheck.checker", "cspcheck.cspm.script"]
        code = (
            f"import sys; from cspcheck.cli import run; run(['--help']); print(sorted({set(heavy)} & set(sys.modules)))"
        )
        done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)

        assert done.stdout.splitlines()[-1] == "[]"

    def test_the_package_imports_no_more_than_the_register_of_notations(self, environment: dict[str, str]) -> None:
        code = (
            "import sys, cspcheck; "
            "print(sorted(m for m in sys.modules if m.startswith('cspcheck.') or m in ('numpy', 'z3', 'lark')))"
        )
        done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)

        assert done.stdout == "['cspcheck.cspm', 'cspcheck.cspm.notation', 'cspcheck.cspm.oz']\n"

    def test_check_is_the_command_of_files(self) -> None:
        assert front_door.get_command(front_door.make_context("x", ["check"], resilient_parsing=True), "check") is (
            check_command
        )
