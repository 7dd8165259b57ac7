"""Scripts as tests: what is collected, what passes, what a failure shows."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from cspcheck.register import all_mistakes
from tests.cspcheck.interrupting import LISTENING

pytest_plugins = ["pytester"]

ROOT = Path(__file__).resolve().parents[2]
PLUGIN = () if any(e.name == "cspcheck" for e in entry_points(group="pytest11")) else ("-p", "cspcheck.pytest_plugin")
"""How a pytest of ours gets the plugin: by itself where the package is installed, else by name."""

GOOD = """\
channel a, b
P = a -> b -> P
Q = a -> STOP
assert P :[deadlock free]
-- expect: fail
assert Q :[deadlock free]
"""
BAD = "channel a\nQ = a -> STOP\nassert Q :[deadlock free]\n"
ENDLESS = """\
channel a : {0..99}
P(n) = a?x -> P(n + x + 1)
assert P(0) :[deadlock free]
"""
BROKEN = "channel a\nP = b -> P\nassert P :[deadlock free]\n"


# A run of pytest within pytest forgets what it has imported, and our messages can be registered once only.
for module in (
    "cspcheck.cspm.script",
    "cspcheck.cspm.typing.inference",
    "cspcheck.checker.check",
    "cspcheck.api",
    "cspcheck.report.full",
):
    import_module(module)
for module in (
    "cspcheck.configuration",
    "cspcheck.cspm.oz.processes.evaluating",
    "cspcheck.cspm.oz.reading.latex_reader",
):
    import_module(module)
all_mistakes()


@pytest.fixture
def place(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "" if not PLUGIN else "1")
    if not os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"]:
        monkeypatch.delenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD")
    return pytester


def write(place: pytest.Pytester, **files: str) -> None:
    for name, text in files.items():
        path = place.path / (name.replace("__", "/") + ".csp")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def run(place: pytest.Pytester, *arguments: str) -> pytest.RunResult:
    return place.runpytest_inprocess(*PLUGIN, *arguments)


def ids(place: pytest.Pytester, *arguments: str) -> list[str]:
    result = run(place, "--collect-only", "-q", *arguments)
    return [line for line in result.outlines if "::" in line]


class TestCollection:
    def test_one_item_an_assertion_named_by_its_text(self, place: pytest.Pytester) -> None:
        write(place, spec=GOOD)

        assert [one.split(" ", 1)[0] for one in ids(place, "spec.csp")] == ["spec.csp::P", "spec.csp::Q"]
        assert ids(place, "spec.csp")[0].startswith("spec.csp::P :[deadlock free")

    def test_a_document_is_collected_where_it_is_named(self, place: pytest.Pytester) -> None:
        text = "\\begin{class}{C} \\chan a \\\\ main = a \\then main \\end{class}"
        (place.path / "paper.tex").write_text(f"{text}\n\\begin{{cspm}}\nassert C :[deadlock free]\n\\end{{cspm}}\n")

        assert [one.split(" ", 1)[0] for one in ids(place, "paper.tex")] == ["paper.tex::C"]
        assert ids(place, ".") == []

    def test_equal_assertions_are_told_apart_by_their_line(self, place: pytest.Pytester) -> None:
        write(place, spec="assert STOP [T= STOP\nassert STOP [T= STOP\n")

        assert ids(place, "spec.csp") == ["spec.csp::STOP [T= STOP", "spec.csp::STOP [T= STOP (line 2)"]

    def test_a_folder_that_is_named(self, place: pytest.Pytester) -> None:
        write(place, specs__a=BAD, specs__deep__b=BAD, other__c=BAD)

        assert [one.split("::")[0] for one in ids(place, "specs")] == ["specs/a.csp", "specs/deep/b.csp"]

    def test_an_assertion_that_is_named(self, place: pytest.Pytester) -> None:
        write(place, spec=GOOD)
        (first, _) = ids(place, "spec.csp")

        assert ids(place, first) == [first]

    def test_nothing_without_a_name(self, place: pytest.Pytester) -> None:
        write(place, specs__a=BAD, b=BAD)

        assert ids(place) == []

    def test_test_paths_name_nothing(self, place: pytest.Pytester) -> None:
        place.makeini("[pytest]\ntestpaths = specs\n")
        write(place, specs__a=BAD)

        assert ids(place) == []

    def test_what_the_ini_option_matches_is_collected_from_folders(self, place: pytest.Pytester) -> None:
        place.makeini("[pytest]\ncsp_files = specs/**/*.csp\n")
        write(place, specs__a=BAD, specs__deep__b=BAD, other__c=BAD)

        assert [one.split("::")[0] for one in ids(place)] == ["specs/a.csp", "specs/deep/b.csp"]
        assert ids(place, "other") == []
        assert [one.split("::")[0] for one in ids(place, "other/c.csp")] == ["other/c.csp"]

    def test_what_others_include_is_a_part_of_them(self, place: pytest.Pytester) -> None:
        write(place, specs__main='include "part.csp"\nassert P :[deadlock free]\n', specs__part="P = STOP\n")

        assert [one.split("::")[0] for one in ids(place, "specs")] == ["specs/main.csp"]

    def test_a_broken_script_shows_its_diagnostics_and_no_frames(self, place: pytest.Pytester) -> None:
        write(place, spec=BROKEN)
        result = run(place, "spec.csp")

        result.assert_outcomes(errors=1)
        result.stdout.fnmatch_lines(["error[[]CSP2*: `b` is not *", " --> spec.csp:2:5", "2 | P = b -> P", "*^*"])
        result.stdout.no_fnmatch_line("*Traceback*")
        result.stdout.no_fnmatch_line("*.py:*")

    def test_python_tests_beside_scripts_are_collected_as_ever(self, place: pytest.Pytester) -> None:
        write(place, specs__a=GOOD)
        place.makepyfile(**{"specs/test_it": "def test_it(): pass"})

        run(place, "specs").assert_outcomes(passed=3)


class TestOutcome:
    def test_what_the_script_expects_passes(self, place: pytest.Pytester) -> None:
        write(place, spec=GOOD)

        run(place, "spec.csp").assert_outcomes(passed=2)

    def test_a_failure_shows_what_the_command_line_shows(self, place: pytest.Pytester) -> None:
        import cspcheck

        write(place, spec=BAD)
        result = run(place, "spec.csp")

        result.assert_outcomes(failed=1)
        (answer,) = cspcheck.load("spec.csp").check()
        shown = answer.explain().splitlines()
        assert "`Q` deadlocks after 1 event" in shown[2]
        start = result.outlines.index(shown[1])
        assert result.outlines[start : start + len(shown) - 1] == shown[1:]
        result.stdout.no_fnmatch_line("*Traceback*")
        result.stdout.no_fnmatch_line("*.py:*")

    def test_an_unknown_verdict_fails_with_its_reason(self, place: pytest.Pytester) -> None:
        write(place, spec="channel a\nP(n) = a -> P(n+1)\nassert P(0) :[deadlock free]\n")
        result = run(place, "spec.csp", "--csp-max-states", "100")

        result.assert_outcomes(failed=1)
        result.stdout.fnmatch_lines(["? P(0) :[[]deadlock free*"])

    def test_an_unknown_verdict_that_is_expected_passes(self, place: pytest.Pytester) -> None:
        text = "channel a\nP(n) = a -> P(n+1)\n-- expect: unknown\nassert P(0) :[deadlock free]\n"
        write(place, spec=text)

        run(place, "spec.csp", "--csp-max-states", "100").assert_outcomes(passed=1)

    def test_a_pass_that_is_not_expected_fails(self, place: pytest.Pytester) -> None:
        write(place, spec="-- expect: fail\nassert STOP [T= STOP\n")
        result = run(place, "spec.csp")

        result.assert_outcomes(failed=1)
        result.stdout.fnmatch_lines(["*It passes, but the script expects `fail`."])

    def test_an_error_while_checking_fails_with_its_diagnostics(self, place: pytest.Pytester) -> None:
        write(place, spec="channel a\nP = P [] a -> STOP\nassert P :[deadlock free]\nassert STOP [T= STOP\n")
        result = run(place, "spec.csp")

        result.assert_outcomes(failed=1, passed=1)
        result.stdout.fnmatch_lines(["error[[]CSP501[]]: `P` calls itself before any event"])
        result.stdout.no_fnmatch_line("*Traceback*")

    def test_a_mistake_of_ours_says_so(self, place: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
        from cspcheck.checker.check import Checker

        def broken(self: Checker, assertion: object) -> None:
            raise IndexError("list index out of range")

        monkeypatch.setattr(Checker, "check", broken)
        monkeypatch.setattr("cspcheck.failure.tempfile.tempdir", str(place.path))
        write(place, spec="assert STOP [T= STOP\n")
        result = run(place, "spec.csp")

        result.assert_outcomes(failed=1)
        result.stdout.fnmatch_lines(
            [
                "error[[]CSP900[]]: internal error while checking `STOP [[]T= STOP`: IndexError: list index *",
                "*arguments: pytest *spec.csp",
                f"*the traceback is in {place.path}/cspcheck-error-*",
            ]
        )
        result.stdout.no_fnmatch_line("*Traceback*")

    def test_states_are_in_the_report_of_the_run(self, place: pytest.Pytester) -> None:
        write(place, spec="channel a\nP = a -> P\nassert P :[deadlock free]\n")
        run(place, "spec.csp", "--junitxml=out.xml")

        assert '<property name="states" value="1"' in (place.path / "out.xml").read_text()


class TestOptions:
    def test_definitions(self, place: pytest.Pytester) -> None:
        write(place, spec="N = 1\nassert STOP [T= if N == 2 then STOP else DIV\nassert N == 2\n")

        run(place, "spec.csp", "--csp-define", "N=2").assert_outcomes(passed=2)

    @pytest.mark.parametrize(
        ("option", "message"),
        [
            ("--csp-timeout=soon", "cspcheck: `soon` is not a time; write it like 90s, 5m or 1h30m"),
            ("--csp-max-memory=big", "cspcheck: `big` is not a size; write it like 512MiB, 8GiB or 2GB"),
            ("--csp-max-states=0", "cspcheck: --csp-max-states wants a whole number above zero, not `0`"),
            ("--csp-workers=x", "cspcheck: --csp-workers wants a whole number above zero, not `x`"),
            ("--csp-define=N", "cspcheck: `N` is not NAME=EXPR"),
        ],
    )
    def test_a_wrong_value_is_told_before_anything_runs(
        self, place: pytest.Pytester, option: str, message: str
    ) -> None:
        result = run(place, option)

        assert result.ret == pytest.ExitCode.USAGE_ERROR
        result.stderr.fnmatch_lines([f"*{message.replace('[', '[[]')}*"])


class TestFixture:
    def test_it_loads_scripts(self, place: pytest.Pytester) -> None:
        write(place, specs__spec="N = 1\nchannel a\nP = a -> P\nassert P :[deadlock free]\n")
        place.makepyfile(
            """
            import pytest

            @pytest.fixture(scope="module")
            def script(csp):
                return csp.load("specs/spec.csp")

            def test_check(script):
                assert all(script.check())

            def test_evaluate(script, csp):
                assert script.evaluate("N") == 3
                assert csp.load("specs/spec.csp", definitions={"N": 5}).evaluate("N") == 5
            """
        )

        run(place, "--csp-define", "N=3").assert_outcomes(passed=2)

    def test_a_path_is_looked_up_in_the_root_folder_too(
        self, place: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        place.makeini("[pytest]\n")
        write(place, specs__spec="N = 1\n")
        place.makepyfile(**{"tests/test_it": "def test_it(csp): assert csp.load('specs/spec.csp').evaluate('N') == 1"})
        monkeypatch.chdir(place.path / "tests")

        run(place).assert_outcomes(passed=1)


class TestLaziness:
    """Everybody who has cspcheck installed loads the plugin with every pytest."""

    def test_without_a_script_nothing_is_imported(self, place: pytest.Pytester) -> None:
        place.makepyfile(
            """
            import sys

            def test_modules(pytestconfig):
                assert pytestconfig.getini("csp_files") is None
                ours = {"cspm", "checker", "cspcheck.api", "cspcheck.checking"}
                assert not (ours | {"numpy", "llvmlite", "lark", "click", "networkx"}) & set(sys.modules)
            """
        )
        write(place, spec=GOOD)

        result = place.runpytest_subprocess(*PLUGIN)
        result.assert_outcomes(passed=1)

    def test_the_fixture_is_known(self, place: pytest.Pytester) -> None:
        run(place, "--fixtures").stdout.fnmatch_lines(["csp [[]session scope[]]*"])


def test_a_file_shares_its_machines(place: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    """One checker a file, whatever the number of assertions."""
    from cspcheck import checking

    made = []
    real = checking.checker_for
    monkeypatch.setattr(checking, "checker_for", lambda *arguments: made.append(1) or real(*arguments))
    write(place, a=GOOD, b=GOOD)
    run(place, "a.csp", "b.csp").assert_outcomes(passed=4)

    assert len(made) == 2


@pytest.mark.slow
def test_workers_collect_what_the_command_line_means(place: pytest.Pytester) -> None:
    """With xdist each worker has its own configuration; it must come to the same items."""
    pytest.importorskip("xdist")
    place.makeini("[pytest]\ntestpaths = specs\n")
    write(place, specs__a=GOOD)
    place.makepyfile(**{"specs/test_it": "def test_it(): pass"})
    xdist = ("-p", "xdist.plugin") if "PYTEST_DISABLE_PLUGIN_AUTOLOAD" in os.environ else ()

    place.runpytest_subprocess(*PLUGIN, *xdist, "-n1").assert_outcomes(passed=1)
    place.runpytest_subprocess(*PLUGIN, *xdist, "-n1", "specs").assert_outcomes(passed=3)


class TestProject:
    """The settings in ``[tool.cspcheck]`` hold here too."""

    SCRIPT = (
        "N = 3\nchannel c : {0..9}\nP(n) = if n == N then STOP else c.n -> P(n + 1)\nassert P(0) :[divergence free]\n"
    )

    def test_they_are_defaults(self, place: pytest.Pytester) -> None:
        write(place, count=self.SCRIPT)
        (place.path / "pyproject.toml").write_text("[tool.cspcheck]\nmax-states = 2\n")

        run(place, "count.csp").assert_outcomes(failed=1)
        run(place, "count.csp", "--csp-max-states", "10").assert_outcomes(passed=1)

    def test_definitions_are_joined(self, place: pytest.Pytester) -> None:
        write(place, count=self.SCRIPT)
        (place.path / "pyproject.toml").write_text("[tool.cspcheck.definitions]\nN = 12\n")

        run(place, "count.csp").assert_outcomes(failed=1)
        run(place, "count.csp", "--csp-define", "N=4").assert_outcomes(passed=1)

    def test_the_fixture_honours_them(self, place: pytest.Pytester) -> None:
        write(place, count=self.SCRIPT)
        (place.path / "pyproject.toml").write_text("[tool.cspcheck.definitions]\nN = 5\n")
        place.makepyfile("def test(csp): assert csp.load('count.csp').check()[0].states == 6")

        run(place).assert_outcomes(passed=1)

    def test_wrong_ones_are_an_error_of_collection(self, place: pytest.Pytester) -> None:
        write(place, count=self.SCRIPT)
        (place.path / "pyproject.toml").write_text("[tool.cspcheck]\nmax-state = 2\n")
        result = run(place, "count.csp")

        result.assert_outcomes(errors=1)
        result.stdout.fnmatch_lines(["*CSP914*", "*did you mean `max-states`?*"])


def test_an_interrupt_is_told_without_what_was_going_on(
    place: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of each frame on the way pytest would parse the file, and that takes seconds."""

    def interrupted(*arguments: object) -> object:
        raise KeyboardInterrupt

    monkeypatch.setattr("cspcheck.checking.check", interrupted)
    write(place, good=GOOD)
    result = place.runpytest_inprocess(*PLUGIN, "--full-trace", "good.csp", no_reraise_ctrlc=True)

    assert result.ret is pytest.ExitCode.INTERRUPTED
    result.stdout.fnmatch_lines(["*pytest_plugin.py:*: KeyboardInterrupt"])
    result.stdout.no_fnmatch_line("*interrupted(*")


@pytest.mark.parametrize("name", ["endless.csp", "test_endless.py"])
def test_an_interrupt_ends_the_run_while_a_check_is_going_on(place: pytest.Pytester, name: str) -> None:
    write(place, endless=ENDLESS)
    (place.path / "test_endless.py").write_text(
        "import cspcheck\n\ndef test_it():\n    print('begun', flush=True)\n    cspcheck.load('endless.csp').check()\n"
    )
    (place.path / "conftest.py").write_text(
        "def pytest_runtest_call(item):\n    if item.path.suffix == '.csp':\n        print('begun', flush=True)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-m", "pytest", *PLUGIN, "-s", "-p", "no:cacheprovider", name],
        cwd=place.path,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        preexec_fn=LISTENING,
    ) as run:
        try:
            assert run.stdout is not None
            while "begun" not in run.stdout.readline():
                assert run.poll() is None
            time.sleep(1)
            run.send_signal(signal.SIGINT)
            rest = run.stdout.read()
            assert run.wait(120) == pytest.ExitCode.INTERRUPTED, rest
        finally:
            run.kill()
    assert "KeyboardInterrupt" in rest
    assert "internal error" not in rest.lower()
