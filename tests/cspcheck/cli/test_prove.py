"""``cspcheck prove``: what it tells, and its exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cspcheck.cli import run

COUNTER = """
class Counter
  chan up : []
  chan down : []
  main = up -> main [] down -> main
  state
    n : nat
  where
    n <= 9
  init
    n = 0
  op up
    Delta(n)
  where
    UP
    n' = n + 1
  op down
    Delta(n)
  where
    n' = n - 1
end
"""
GOOD = COUNTER.replace("UP", "n < 9").replace("n' = n - 1", "n > 0\n    n' = n - 1")
BAD = COUNTER.replace("    UP\n", "")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "good.csp").write_text(GOOD)
    (tmp_path / "bad.csp").write_text(BAD)
    return tmp_path


def test_everything_proved_is_zero(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["prove", "good.csp", "--color", "never"]) == 0

    told = capsys.readouterr().out
    assert told.startswith("good.csp\n\nCounter\n")
    assert "invariant preserved      up `n <= 9`" in told
    assert told.splitlines()[-1] == "14 obligations: 14 proved"


def test_a_refutation_is_one_and_shows_the_step(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["prove", "bad.csp", "-q"]) == 1

    lines = [line.rstrip() for line in capsys.readouterr().out.splitlines()]
    start = next(i for i, line in enumerate(lines) if "invariant preserved" in line)
    assert lines[start + 1 : start + 5] == [
        "      The operation breaks the invariant `n <= 9`.",
        "        before  n  = 9",
        "        after   n' = 10",
        "      There `n' <= 9` does not hold.",
    ]


def test_a_warning_alone_is_zero_and_by_its_name_one(folder: Path) -> None:
    assert run(["prove", "bad.csp", "--operation", "down"]) == 0
    assert run(["prove", "bad.csp", "--operation", "down", "--obligation", "carrier kept"]) == 1


def test_json_has_every_obligation(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["prove", "bad.csp", "--obligation", "invariant preserved", "--format", "json"]) == 1

    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "cspcheck/proof/1"
    assert [(o["operation"], o["status"], o["values"]) for o in document["obligations"]] == [
        ("up", "refuted", {"n": "9", "n'": "10"}),
        ("down", "proved", {}),
    ]


def test_more_tells_the_lines_that_a_proof_needed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["prove", "good.csp", "--obligation", "invariant preserved", "-v", "--color", "never"]) == 0

    lines = capsys.readouterr().out.splitlines()
    start = next(i for i, line in enumerate(lines) if "up `n <= 9`" in line)
    assert lines[start + 1 : start + 4] == [
        "      What was needed:",
        "        15  n < 9       effect",
        "        16  n' = n + 1  effect",
    ]
    assert run(["prove", "good.csp", "--obligation", "invariant preserved", "-v", "--format", "json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["obligations"][0]["used"] == [
        {"what": "effect", "line": 15, "text": "n < 9"},
        {"what": "effect", "line": 16, "text": "n' = n + 1"},
    ]
    assert run(["prove", "good.csp", "--obligation", "invariant preserved", "--format", "json"]) == 0
    assert json.loads(capsys.readouterr().out)["obligations"][0]["used"] is None


def test_preconditions(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["prove", "bad.csp", "--precondition", "up"]) == 0
    assert capsys.readouterr().out == "`Counter.up` is possible where\n  n <= 8\n"


def test_queries_can_be_kept(folder: Path) -> None:
    assert run(["prove", "good.csp", "--obligation", "feasible", "--smtlib", "queries"]) == 0

    files = sorted(path.name for path in (folder / "queries").iterdir())
    assert files == ["Counter-feasible-down-002.smt2", "Counter-feasible-up-001.smt2"]
    assert "(check-sat)" in (folder / "queries" / files[0]).read_text()


def test_a_class_that_there_is_not(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["prove", "good.csp", "--class", "Conter"]) == 2
    assert "`Conter` is no class of this script" in capsys.readouterr().err


def test_nothing_to_prove(folder: Path) -> None:
    (folder / "plain.csp").write_text("P = STOP\n")
    assert run(["prove", "plain.csp"]) == 5


def test_a_rule_of_refinement_can_be_picked(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = GOOD.replace("class Counter", "class Slow").replace("n < 9", "n < 8")
    same = "retrieve R between Counter and Slow where\n  Counter.n = Slow.n\nend\nassert Counter [OZ= Slow via R\n"
    (folder / "two.csp").write_text(GOOD + other + same)

    assert run(["prove", "two.csp", "--obligation", "applicability", "--operation", "up", "--color", "never"]) == 1

    told = capsys.readouterr().out
    assert [line.split()[0] for line in told.splitlines() if "applicability" in line] == ["✗", "✓"]
    assert "invariant preserved" not in told
    assert "correctness" not in told


def test_what_is_typed_alone_is_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "loop.csp").write_text("class Loop\n  state\n    me : Loop\nend\n")
    run(["prove", str(folder / "loop.csp")])
    assert "`Loop` is typed, but cannot be run: an object of `Loop` within itself" in capsys.readouterr().err
    run(["prove", "-q", str(folder / "loop.csp")])
    assert capsys.readouterr().err == ""
