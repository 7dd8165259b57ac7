"""The settings of a project are defaults; wrong ones are said before anything is checked."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cspcheck.cli import run
from cspcheck.configuration import KEYS, Configuration, configuration_for
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.report.diagnostics import render_diagnostics
from cspcheck.report.style import PLAIN

SCRIPT = """\
N = 3
channel c : {0..100}
Count(n) = if n == N then STOP else c.n -> Count(n + 1)
assert Count(0) :[divergence free]
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "specs").mkdir()
    (tmp_path / "specs" / "count.csp").write_text(SCRIPT)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def settings(folder: Path, text: str, name: str = "pyproject.toml") -> None:
    (folder / name).write_text(f"[tool.cspcheck]\n{text}\n" if "[tool" not in text else text)


def checked(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, dict[str, object]]:
    code = run(["specs/count.csp", "--format", "json", *arguments])
    return code, json.loads(capsys.readouterr().out)["results"][0]


def complaint(folder: Path) -> str:
    with pytest.raises(ScriptError) as caught:
        configuration_for(None)
    return render_diagnostics(caught.value.diagnostics, PLAIN)


class TestSearch:
    def test_without_a_file_there_are_no_settings(self, folder: Path) -> None:
        assert configuration_for("specs/count.csp") == Configuration()

    def test_the_file_nearest_to_the_script_wins(self, folder: Path) -> None:
        settings(folder, "max-states = 7")
        assert configuration_for("specs/count.csp").settings == {"max_states": 7}
        settings(folder / "specs", "max-states = 8")
        assert configuration_for("specs/count.csp").settings == {"max_states": 8}
        assert configuration_for("specs").settings == {"max_states": 8}
        assert configuration_for(None).settings == configuration_for("-").settings == {"max_states": 7}

    def test_a_file_without_the_table_is_passed_over(self, folder: Path) -> None:
        settings(folder, "max-states = 7")
        settings(folder / "specs", "[tool.ruff]\nline-length = 88\n# cspcheck is great\n")
        assert configuration_for("specs/count.csp").settings == {"max_states": 7}

    def test_the_current_folder_counts_for_scripts_elsewhere(
        self, folder: Path, tmp_path_factory: pytest.TempPathFactory
    ) -> None:
        settings(folder, "max-states = 7")
        elsewhere = tmp_path_factory.mktemp("elsewhere")
        assert configuration_for(str(elsewhere / "x.csp")).settings == {"max_states": 7}


class TestSettings:
    def test_every_key(self, folder: Path) -> None:
        settings(
            folder,
            """\
[tool.cspcheck]
format = "concise"
timeout = "1m30s"
max-memory = "1GiB"
max-states = 1_000
workers = 2
full = true
as-written = true
termination = "deadlock"
typecheck = false
view = "control"
outputs = "angelic"
color = "never"
quiet = true
verbose = 2
include-root = ["common", "../shared"]
definitions = { N = 5, IDS = "{0..N-1}", DEBUG = true }
""",
        )
        found = configuration_for(None)
        assert found == Configuration(
            "pyproject.toml",
            {
                "form": "concise",
                "timeout": 90.0,
                "max_memory": 1 << 30,
                "max_states": 1000,
                "workers": 2,
                "full": True,
                "as_written": True,
                "termination": "deadlock",
                "typecheck": False,
                "view": "control",
                "outputs": "angelic",
                "color": "never",
                "quiet": True,
                "verbose": 2,
                "include_roots": ("common", "../shared"),
            },
            {"N": "5", "IDS": "{0..N-1}", "DEBUG": "true"},
        )
        assert len(found.settings) + 1 == len(KEYS)

    def test_definitions_may_be_a_table_of_their_own(self, folder: Path) -> None:
        settings(folder, "[tool.cspcheck]\n[tool.cspcheck.definitions]\nN = 4\n")
        assert configuration_for(None).definitions == {"N": "4"}

    def test_times_and_sizes_may_be_numbers(self, folder: Path) -> None:
        settings(folder, "timeout = 30\nmax-memory = 1048576")
        assert configuration_for(None).settings == {"timeout": 30.0, "max_memory": 1 << 20}


class TestBrokenFiles:
    @pytest.mark.parametrize(
        ("content", "said"),
        [
            (b"[tool", "Expected ']' at the end of a table declaration (at end of document)"),
            (b"[project]\nname = 'x", 'Expected "\'" (at end of document)'),
            (b"[project]\nname = '\xe9'\n", "it is not UTF-8: invalid continuation byte"),
            (b"a = " + 100_000 * b"[", ""),
        ],
    )
    def test_are_errors_whatever_they_are_about(self, content: bytes, said: str, folder: Path) -> None:
        (folder / "pyproject.toml").write_bytes(content)
        with pytest.raises(ScriptError) as caught:
            configuration_for(None)
        (diagnostic,) = caught.value.diagnostics
        assert diagnostic.code == "CSP916"
        assert said[1:] in diagnostic.message

    def test_a_setting_in_place_of_the_table(self, folder: Path) -> None:
        (folder / "pyproject.toml").write_text("[tool]\ncspcheck = 5\n")
        with pytest.raises(ScriptError) as caught:
            configuration_for(None)
        assert caught.value.diagnostics[0].message == "setting `tool.cspcheck`: `5` is not a table"


class TestCommandLine:
    def test_settings_are_defaults(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        settings(folder, "max-states = 2")
        code, result = checked(capsys)
        assert (code, result["verdict"]) == (3, "unknown")

    def test_the_command_line_wins(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        settings(folder, "max-states = 2")
        assert checked(capsys, "--max-states", "100")[0] == 0
        assert checked(capsys, "--max-states", "none")[0] == 0

    def test_definitions_are_joined_and_those_of_the_command_line_win(
        self, folder: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        settings(folder, "definitions = { N = 10 }")
        assert checked(capsys)[1]["states"] == 11
        assert checked(capsys, "-D", "N=20")[1]["states"] == 21

    def test_a_switch_can_be_turned_off(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        (folder / "specs" / "count.csp").write_text(SCRIPT + "assert (Count(0) [] c.0 -> DIV) :[divergence free]\n")
        settings(folder, "full = true")
        full = checked(capsys)[1], json_second(capsys)
        early = json_second(capsys, "--no-full")
        assert full[1]["states"] > early["states"]

    def test_the_format_is_a_setting_for_people_and_programs(
        self, folder: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        settings(folder, 'format = "concise"')
        assert run(["specs/count.csp"]) == 0
        assert capsys.readouterr().out == "specs/count.csp:4: pass: Count(0) :[divergence free]\n"

    def test_other_verbs_take_what_concerns_them(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        settings(folder, 'format = "junit"\nmax-states = 3\ndefinitions = { N = 5 }')
        assert run(["sweep", "specs/count.csp", "-D", "N=1..2"]) == 0
        assert capsys.readouterr().out.startswith("specs/count.csp\n")
        assert run(["graph", "specs/count.csp", "Count(0)", "-o", "x.dot"]) == 0
        assert (folder / "x.dot").read_text().count("->") == 5

    def test_wrong_settings_are_said_and_nothing_is_checked(
        self, folder: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        settings(folder, "max-state = 2")
        assert run(["specs/count.csp"]) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert "did you mean `max-states`?" in err

    def test_wrong_settings_do_not_keep_the_help_from_being_read(
        self, folder: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        settings(folder, "max-state = 2")
        assert run(["check", "--help"]) == 0


def json_second(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, int]:
    run(["specs/count.csp", "--format", "json", *arguments])
    found: dict[str, int] = json.loads(capsys.readouterr().out)["results"][1]
    return found


class TestComplaints:
    def test_an_unknown_key_gets_a_suggestion(self, folder: Path) -> None:
        settings(folder, 'max-memory = "1GiB"\nmax_states = 2')
        assert (
            complaint(folder)
            == """\
error[CSP914]: `[tool.cspcheck]` has no setting `max_states`
 --> pyproject.toml:3:1
  |
3 | max_states = 2
  | ^^^^^^^^^^
  |
  = help: did you mean `max-states`?

"""
        )

    def test_all_that_is_wrong_is_said_at_once(self, folder: Path) -> None:
        settings(folder, 'timeout = "soon"\nworkers = 0\nhue = 1\ndefinitions = { N = [1] }')
        text = complaint(folder)
        assert "setting `timeout`: `soon` is not a time; write it like 90s, 5m or 1h30m" in text
        assert "setting `workers`: `0` is not a whole number above zero" in text
        assert "help: the keys are as-written, color, format" in text
        assert "setting `definitions.N`: `[1]` is not a number, a truth value or text in CSPm" in text

    @pytest.mark.parametrize(
        ("line", "said"),
        [
            ('format = "xml"', "`xml` is none of full, concise, json, jsonl, junit, github"),
            ("full = 1", "`1` is not true or false"),
            ('max-states = "many"', "`many` is not a whole number above zero"),
            ("max-states = true", "`true` is not a whole number above zero"),
            ('max-memory = "lots"', "`lots` is not a size"),
            ("timeout = true", "`true` is not a time"),
            ('quiet = "yes"', "`yes` is not true, false or how many times"),
            ("definitions = 3", "`3` is not a table of names"),
        ],
    )
    def test_wrong_values(self, folder: Path, line: str, said: str) -> None:
        settings(folder, line)
        assert said in complaint(folder)

    def test_a_file_that_is_no_toml(self, folder: Path) -> None:
        (folder / "pyproject.toml").write_text("[tool.cspcheck\nfull = true\n")
        assert complaint(folder).startswith("error[CSP916]: cannot read `pyproject.toml`: expected")
