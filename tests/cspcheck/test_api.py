"""The promises to Python programs."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from functools import partialmethod
from importlib.metadata import version
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import cspcheck
from cspcheck import Verdict, checking
from cspcheck.api import load_with
from cspcheck.checker.search.levels import Progress
from cspcheck.checking import Settings
from cspcheck.cli import progress
from cspcheck.interactive import Shown

SCRIPT = """\
channel left, mid, right : {0..1}
N = 1
Copy(i, o) = i?x -> o!x -> Copy(i, o)
Pair = (Copy(left, mid) [| {| mid |} |] Copy(mid, right)) \\ {| mid |}
Buffer(s) = #s < 2 & left?x -> Buffer(s ^ <x>) [] #s > 0 & right!head(s) -> Buffer(tail(s))
Once = left.0 -> STOP
Big(n) = left.0 -> Big((n + 1) % 100)
assert Buffer(<>) [FD= Pair
assert Pair :[deadlock free]
-- expect: fail
assert Once :[deadlock free]
print N + 1
"""


@pytest.fixture
def script() -> cspcheck.Script:
    return cspcheck.loads(SCRIPT, name="pair.csp")


class TestLoading:
    def test_a_file(self, tmp_path: Path) -> None:
        (tmp_path / "pair.csp").write_text(SCRIPT)
        script = cspcheck.load(tmp_path / "pair.csp")

        assert script.name == str(tmp_path / "pair.csp")
        assert script.assertions == (
            "Buffer(<>) [FD= Pair",
            "Pair :[deadlock free]",
            "Once :[deadlock free]",
        )
        assert script.printed == ("2",)
        assert script.warnings == ()

    def test_includes_are_found_beside_the_file(self, tmp_path: Path) -> None:
        (tmp_path / "main.csp").write_text('include "part.csp"\n')
        (tmp_path / "part.csp").write_text("N = 7\n")

        assert cspcheck.load(tmp_path / "main.csp").evaluate("N") == 7

    @pytest.mark.parametrize(("value", "shown"), [(5, 5), ("2 + 1", 3), ("card({1, 2})", 2)])
    def test_definitions_override_constants(self, value: object, shown: int) -> None:
        assert cspcheck.loads("N = 1\n", definitions={"N": value}).evaluate("N") == shown

    def test_a_truth_value_as_definition(self) -> None:
        assert cspcheck.loads("B = true\n", definitions={"B": False}).evaluate("B") is False

    def test_a_wrong_script_raises_its_diagnostics(self) -> None:
        with pytest.raises(cspcheck.ScriptError) as caught:
            cspcheck.loads("channel a\nP = a -> Q\n", name="wrong.csp")

        (diagnostic,) = caught.value.diagnostics
        assert diagnostic.code.startswith("CSP2")
        assert diagnostic.span is not None
        assert (diagnostic.span.source.name, diagnostic.span.line, diagnostic.span.column) == ("wrong.csp", 2, 10)

    def test_a_missing_file_raises_a_script_error(self) -> None:
        with pytest.raises(cspcheck.ScriptError, match=r"CSP001: cannot read `no\.csp`: no such file or directory"):
            cspcheck.load("no.csp")


class TestChecking:
    def test_all_assertions_in_order(self, script: cspcheck.Script) -> None:
        results = script.check()

        assert [result.verdict for result in results] == ["pass", "pass", "fail"]
        assert [bool(result) for result in results] == [True, True, False]
        assert [result.as_expected for result in results] == [True, True, True]
        assert [(result.file, result.line) for result in results] == [
            ("pair.csp", 8),
            ("pair.csp", 9),
            ("pair.csp", 11),
        ]
        assert [(result.kind, result.model) for result in results] == [
            ("refinement", "FD"),
            ("deadlock free", "FD"),
            ("deadlock free", "FD"),
        ]

    def test_one_that_is_given_as_text(self, script: cspcheck.Script) -> None:
        result = script.check("Pair [T= Buffer(<0>)")

        assert result.verdict is Verdict.FAIL
        assert result.counterexample is not None
        assert (result.counterexample.kind, result.counterexample.trace) == ("trace", ())
        assert result.counterexample.event == "right.0"
        assert "performs `right.0`" in result.explain()

    def test_counts_are_those_of_the_composed_machine(self, script: cspcheck.Script) -> None:
        result = script.check("Pair :[deadlock free [F]]", full=True)

        assert (result.states, result.transitions) == (9, 14)

    def test_the_counterexample_of_a_deadlock(self, script: cspcheck.Script) -> None:
        result = script.check("Once :[deadlock free]")

        assert result.counterexample is not None
        assert (result.counterexample.kind, result.counterexample.trace) == ("deadlock", ("left.0",))

    def test_reaching_a_limit_is_unknown(self, script: cspcheck.Script) -> None:
        result = script.check("Big(0) :[deadlock free]", max_states=10, full=True)

        assert result.verdict is Verdict.UNKNOWN
        assert result.reason is not None
        assert "10" in result.reason
        assert not result

    def test_limits_as_people_write_them(self, script: cspcheck.Script) -> None:
        assert script.check("Pair :[deadlock free]", timeout="5m", max_memory="1000GiB", workers=1)

    @pytest.mark.parametrize(
        ("option", "message"),
        [
            ({"timeout": 0}, "timeout must be above zero, not 0"),
            ({"max_states": -1}, "max_states must be above zero, not -1"),
            ({"max_memory": "lots"}, "`lots` is not a size"),
            ({"workers": 0}, "workers must be above zero, not 0"),
        ],
    )
    def test_what_is_no_limit(self, script: cspcheck.Script, option: dict[str, object], message: str) -> None:
        with pytest.raises(ValueError, match=message):
            script.check("Pair :[deadlock free]", **option)  # type: ignore[call-overload]

    def test_text_that_is_no_assertion(self, script: cspcheck.Script) -> None:
        with pytest.raises(cspcheck.ScriptError):
            script.check("Pair [T=")
        with pytest.raises(cspcheck.ScriptError, match="`Nobody` is not defined"):
            script.check("Nobody :[deadlock free]")

    def test_termination_is_what_is_asked_for(self) -> None:
        script = cspcheck.loads("assert SKIP :[deadlock free]\n")

        found = [script.check(termination=how)[0].verdict for how in ("deadlock", "success", None)]
        assert found == ["fail", "pass", "pass"]

    def test_the_settings_of_a_script_hold_where_nothing_is_said(self, tmp_path: Path) -> None:
        """Those of the project reach a script that a test loads, whatever limits the test gives."""
        (tmp_path / "x.csp").write_text("assert SKIP :[deadlock free]\n")
        script = load_with(str(tmp_path / "x.csp"), Settings(termination="deadlock"), {})

        assert [result.verdict for result in script.check(timeout=60)] == ["fail"]
        assert [result.verdict for result in script.check(termination="success")] == ["pass"]

    def test_reductions_are_those_that_are_asked_for(self, monkeypatch: pytest.MonkeyPatch) -> None:
        used: list[Settings] = []
        real = checking.checker_for

        def noted(script: Any, settings: Settings, watch: Any) -> Any:
            used.append(settings)
            return real(script, settings, watch)

        monkeypatch.setattr(checking, "checker_for", noted)
        script = cspcheck.loads("assert SKIP :[divergence free]\n")
        for how in ({}, {"as_written": True}, {"full": True}, {}):
            assert all(script.check(**how))

        assert [(settings.full, settings.as_written) for settings in used] == [
            (False, False), (False, True), (True, False),
        ]  # fmt: skip

    def test_an_error_met_while_checking_is_the_verdict_error(self) -> None:
        (result,) = cspcheck.loads("channel a : {0..1}\nP = a.7 -> STOP\nassert P :[deadlock free]\n").check()

        assert result.verdict is Verdict.ERROR
        assert [diagnostic.code for diagnostic in result.diagnostics] == ["CSP409"]
        assert "error[CSP409]" in result.explain()

    def test_a_script_without_assertions(self) -> None:
        assert cspcheck.loads("P = STOP\n").check() == []


class TestLookingInside:
    @pytest.mark.parametrize(
        ("text", "value"),
        [
            ("1 + 2", 3),
            ("N == 1", True),
            ("{1, 2}", frozenset({1, 2})),
            ("<1, 2>", (1, 2)),
            ("card({| left |})", 2),
        ],
    )
    def test_values(self, script: cspcheck.Script, text: str, value: object) -> None:
        assert script.evaluate(text) == value
        assert type(script.evaluate(text)) is type(value)

    def test_the_machine_of_a_process(self, script: cspcheck.Script) -> None:
        machine = script.process("Copy(left, right)").lts()

        assert (machine.states, machine.transitions, machine.initial) == (3, 4, 0)
        assert machine.alphabet == ("left.0", "left.1", "right.0", "right.1")
        assert [event for event, _ in machine.successors(0)] == ["left.0", "left.1"]
        assert [len(machine.successors(state)) for state in range(3)] == [2, 1, 1]
        assert sorted((source, target) for source, _, target in machine.edges()) == [(0, 1), (0, 2), (1, 0), (2, 0)]

    def test_hidden_and_terminating_steps_have_names(self, script: cspcheck.Script) -> None:
        assert "tau" in script.process("Pair").lts().alphabet
        assert script.process("SKIP").lts().alphabet == ("tick",)

    def test_a_state_that_there_is_not(self, script: cspcheck.Script) -> None:
        machine = script.process("STOP").lts()

        assert machine.successors(0) == []
        for state in (-1, 1):
            with pytest.raises(IndexError, match=f"there is no state {state}, only 0 to 0"):
                machine.successors(state)

    def test_as_a_graph(self, script: cspcheck.Script) -> None:
        machine = script.process("Pair").lts()
        graph = machine.to_networkx()

        assert (graph.number_of_nodes(), graph.number_of_edges()) == (machine.states, machine.transitions) == (9, 14)
        assert graph.graph == {"initial": 0}
        assert {event for _, _, event in graph.edges(data="event")} == set(machine.alphabet)

    def test_a_machine_that_is_too_large(self, script: cspcheck.Script) -> None:
        with pytest.raises(cspcheck.Incomplete):
            script.process("Big(0)").lts(max_states=10)

    def test_what_is_no_process(self, script: cspcheck.Script) -> None:
        with pytest.raises(cspcheck.ScriptError):
            script.process("1 +")


class TestThePackage:
    def test_every_promised_name_is_there(self) -> None:
        for name in cspcheck.__all__:
            assert getattr(cspcheck, name) is not None
            assert name in dir(cspcheck)

    def test_no_other_name_is(self) -> None:
        with pytest.raises(AttributeError, match="module 'cspcheck' has no attribute 'lode'"):
            cspcheck.lode  # noqa: B018

    def test_the_version_is_that_of_the_distribution(self) -> None:
        assert cspcheck.__version__ == version("cspcheck")

    def test_types_are_checked_by_who_uses_it(self, tmp_path: Path) -> None:
        """The public interface as a strict type checker sees it."""
        (tmp_path / "use.py").write_text(
            "import cspcheck\n"
            "script = cspcheck.load('rov.csp', definitions={'N': 3})\n"
            "results: list[cspcheck.Result] = script.check(timeout='5m')\n"
            "one: cspcheck.Result = script.check('P :[deadlock free]')\n"
            "assert one, one.explain()\n"
            "verdict: cspcheck.Verdict = one.verdict\n"
            "states: int = one.states\n"
            "trace: tuple[str, ...] = one.counterexample.trace if one.counterexample else ()\n"
            "machine: cspcheck.Machine = script.process('P').lts(max_states=10)\n"
            "wrong: int = script.check()\n"
        )
        pytest.importorskip("mypy")
        root = Path(__file__).resolve().parents[2]
        # With a cache of its own: other options would make that of the package anew.
        options = ["--strict", "--follow-imports=silent", "--cache-dir", str(tmp_path / "cache")]
        done = subprocess.run(
            [sys.executable, "-m", "mypy", *options, str(tmp_path / "use.py")],
            cwd=root,
            capture_output=True,
            text=True,
            check=False,
        )

        assert [line.split("use.py:")[1] for line in done.stdout.splitlines()[:-1]] == [
            '10: error: Incompatible types in assignment (expression has type "list[Result]", variable has type "int")'
            "  [assignment]"
        ]


def begun_with_progress(shown: Shown, begin: Callable[[Shown, str], None], what: str) -> None:
    """As if a search told where it is as soon as it has begun."""
    begin(shown, what)
    shown.progress(Progress(7, 8, 1, 3, 0.0, 0))


class TestNotebook:
    def test_results_are_short_and_show_themselves(self) -> None:
        script = cspcheck.loads("channel a\nP = a -> STOP\nassert P :[deadlock free]\n")
        (result,) = script.check()
        assert repr(result) == "<cspcheck.Result <text>:3: P :[deadlock free]: fail>"
        assert "deadlocks after 1 event" in result._repr_html_()
        assert "<svg" in result._repr_html_()
        assert result.chart() is not None
        assert script.check("P [T= P").chart() is None

    def test_pictures(self) -> None:
        script = cspcheck.loads("channel a, b\nP = a -> P\nQ = a -> b -> Q\nS = P [| {a} |] Q\nC(n) = a -> C(n + 1)\n")
        assert script.process("S").svg().startswith("<svg")
        assert script.process("S")._repr_svg_() == script.process("S").svg()
        assert script.process("C(0)")._repr_svg_() is None
        picture = script.process("S").architecture()
        assert repr(picture).startswith("<cspcheck.Picture")
        assert "P" in picture._repr_svg_()

    def test_counterexamples_and_machines(self) -> None:
        script = cspcheck.loads("channel a, b\nP = a -> b -> STOP\nQ = b -> Q\n")
        found = script.check("P ||| Q [T= P \\ {a} ; a -> STOP").counterexample
        assert found is None
        found = script.check("Q [T= P").counterexample
        assert repr(found) == "<cspcheck.Counterexample: trace after <>, then a>"
        found = script.check("P [| {b} |] Q :[deadlock free]").counterexample
        assert repr(found) == "<cspcheck.Counterexample: deadlock after <a, b>>"
        assert "<td>2</td><td>b</td><td>P, Q</td>" in found._repr_html_()
        assert script.process("P").lts()._repr_svg_() == script.process("P").svg()

    def test_an_assertion_of_the_file_is_that_assertion(self) -> None:
        script = cspcheck.loads("channel a\nP = a -> STOP\n-- expect: fail\nassert P :[deadlock  free]\n")
        result = script.check(script.assertions[0])
        assert (result.line, str(result.expected)) == (4, "fail")

    def test_a_mistake_is_shown_with_its_lines(self) -> None:
        with pytest.raises(cspcheck.ScriptError) as caught:
            cspcheck.loads("P = nobody -> P\n")
        (shown,) = caught.value._render_traceback_()  # as IPython asks
        assert "1 | P = nobody -> P" in shown

    def test_progress(self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
        monkeypatch.setattr(progress, "FIRST", 0)
        monkeypatch.setattr(progress, "LINE_INTERVAL", 0)
        monkeypatch.setattr(Shown, "begin", partialmethod(begun_with_progress, Shown.begin))
        script = cspcheck.loads("channel a\nP = a -> P\nassert P :[deadlock free]\n")
        script.check()
        assert capsys.readouterr().err == ""
        script.check(progress=True)
        assert capsys.readouterr().err.startswith("P :[deadlock free]: 7 states")

        texts: list[str] = []

        class Handle:
            def update(self, data: dict[str, str], *, raw: bool) -> None:
                texts.append(data["text/plain"])

        def display(data: dict[str, str], *, raw: bool, display_id: bool) -> Handle:
            texts.append(data["text/plain"])
            return Handle()

        notebook = SimpleNamespace(display=display, get_ipython=lambda: SimpleNamespace(kernel=None))
        monkeypatch.setitem(sys.modules, "IPython", notebook)
        monkeypatch.setitem(sys.modules, "IPython.display", notebook)
        script.check()
        assert texts[0].startswith("P :[deadlock free]: 7 states")
        assert texts[-1] == ""

    def test_probe(self) -> None:
        probe = cspcheck.loads("channel a, b\nP = a -> b -> STOP\n").process("P").probe()
        probe.perform("a")
        assert [probe.events.name(step.event) for step in probe.steps()] == ["b"]

    def test_sweep(self) -> None:
        script = cspcheck.loads("channel a\nN = 1\nP(n) = n < N & a -> P(n + 1)\nassert not P(0) :[deadlock free]\n")
        found = script.sweep(N=range(1, 4))
        assert [(values, result.verdict, result.states) for values, result in found] == [
            ({"N": "1"}, "pass", 2),
            ({"N": "2"}, "pass", 3),
            ({"N": "3"}, "pass", 4),
        ]

    def test_a_sweep_reads_classes_as_the_script_was_read(self) -> None:
        text = """\
N = 1
class C
  chan up
  main = up -> main
  state
    n : 0..1
  init
    n = 0
  op enable_up
  where
    n < N - 1
end
assert C :[deadlock free]
"""
        wide = cspcheck.loads(text, view="control").sweep(N=[1])
        assert [(result.verdict, result.control) for _, result in wide] == [("pass", True)]
        assert [result.verdict for _, result in cspcheck.loads(text).sweep(N=[1])] == ["fail"]

    def test_prove(self) -> None:
        text = "class C\nchan tick\nmain = tick -> main\nstate\nn : nat\ninit\nn = 0\nend\n"
        assert {finding.status for finding in cspcheck.loads(text).prove()} <= {"proved", "bounded"}

    def test_what_is_no_text_and_no_number_is_told(self) -> None:
        script = cspcheck.loads("channel a\nP = a -> P\nassert P :[deadlock free]\n")
        something: Any
        for something in (3, b"P", ["P"], object()):
            for ask in (cspcheck.loads, script.process, script.evaluate, script.show, script.check):
                with pytest.raises(TypeError, match="must be text, not"):
                    ask(something)
        for limit in ("timeout", "max_states", "max_memory", "workers"):
            for something in ([], True, 1.5, object()):
                if (limit, something) != ("timeout", 1.5):
                    with pytest.raises(TypeError, match=f"{limit} must be a number, not"):
                        script.check(**{limit: something})
        for something in (-1, 0, float("nan")):
            with pytest.raises(ValueError, match="timeout must be above zero"):
                script.check(timeout=something)
        assert [result.verdict for result in script.check(timeout=np.float64(60.0), workers=np.int64(1))] == ["pass"]
