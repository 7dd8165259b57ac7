"""What is nested deeper than can be followed is a message, wherever it is noticed; here little can be followed."""

from __future__ import annotations

from pathlib import Path

import pytest

from cspcheck.cli import run
from cspcheck.cspm import recursion

FRAMES = 2_500
DEPTH = 1_500

SHAPES = {
    "sequences": "X = " + "<" * DEPTH + ">" * DEPTH,
    "sets": "X = " + "{" * DEPTH + "}" * DEPTH,
    "signs": "X = " + "- " * DEPTH + "1",
    "negations": "X = " + "not " * DEPTH + "true",
    "brackets": "X = " + "(" * DEPTH + "1" + ")" * DEPTH,
    "sums": "X = " + "+".join(["1"] * DEPTH) + f"\nassert X == {DEPTH}",
    "conditionals": "X = " + "if true then 1 else " * DEPTH + "1",
    "lets": "X = " + "let y = 1 within " * DEPTH + "1",
    "lambdas": "X = " + "\\ x @ " * DEPTH + "1",
    "concatenations": "X = " + "^".join(["<1>"] * DEPTH),
    "calls": "f(x) = x\nX = " + "f(" * DEPTH + "1" + ")" * DEPTH,
    "patterns": "f(" + "<" * DEPTH + "x" + ">" * DEPTH + ") = 1",
    "dots": "channel a : {0}\nX = " + ".".join(["0"] * DEPTH),
    "prefixes": "channel a\nP = " + "a -> " * DEPTH + "STOP\nassert P :[deadlock free]",
    "sequential": "P = " + ";".join(["SKIP"] * DEPTH) + "\nassert P :[deadlock free]",
    "choices": "channel a\nP = " + "[]".join(["a->STOP"] * DEPTH) + "\nassert P :[deadlock free]",
    "interleavings": "P = " + "|||".join(["STOP"] * DEPTH) + "\nassert P :[deadlock free]",
    "hidings": "channel a\nP = STOP" + "\\{a}" * DEPTH + "\nassert P :[deadlock free]",
}


@pytest.mark.parametrize("shape", SHAPES)
def test_it_is_answered_or_said_to_be_nested_too_deeply(
    shape: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(recursion, "FRAMES", FRAMES)
    script = tmp_path / "deep.csp"
    script.write_text(SHAPES[shape] + "\n")
    code = run(["check", str(script), "--format", "concise"])
    out, err = capsys.readouterr()
    assert "CSP900" not in out + err
    if code == 2:
        assert "nested" in out + err
    else:
        assert (code, err) in ((0, ""), (1, "")) or code == 5


def test_such_depths_are_met(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(recursion, "FRAMES", FRAMES)
    script = tmp_path / "deep.csp"
    script.write_text(SHAPES["prefixes"])
    assert run(["check", str(script)]) == 2
    assert f"error[CSP013]: `{script}` is nested too deeply" in capsys.readouterr().err
