"""Mutants: what is changed, and whether an assertion notices it."""

import json
from pathlib import Path

import pytest

from cspcheck import checking
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.printing.printer import print_script
from cspcheck.cspm.source import Source
from cspcheck.mutating import Mutation, Nothing
from cspcheck.mutation import KINDS, mutants

SCRIPT = """\
channel a, b, stop
N = 2
Count(n) = n < N & a -> Count(n + 1) [] b -> Count(n)
Other = a -> Other [] b -> STOP
System = Count(0) [| {| a, b |} |] Other \\ {| b |}
assert Count(0) :[deadlock free]
assert STOP [T= Count(2) \\ {| b |}
"""

CLASS = """\
class C
  chan tick
  main = tick -> main
  state
    n : 0..3
  where
    n <= 2
  init
    n = 0
  op enable_tick where
    n < 2
end
"""


def made(text: str) -> dict[str, str]:
    """By what is said of it, how each mutant's definition of P is printed."""
    head = "channel a, b, c\nchannel d : {0..3}\nQ = STOP\n"
    found = {}
    for change, tree in mutants(parse(Source("x.csp", f"{head}P = {text}\n"))):
        found[change.text] = print_script(tree).split("\nP = ", 1)[1].strip()
    return found


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "a -> Q",
            {"the event `a` is left out": "Q", "nothing happens instead of `a`": "STOP"},
        ),
        ("d?x -> Q", {"nothing happens instead of `d?x`": "STOP"}),
        (
            "Q [| {a, b} |] Q",
            {"`a` is not synchronised": "Q [| {b} |] Q", "`b` is not synchronised": "Q [| {a} |] Q"},
        ),
        ("Q [| Events |] Q", {"nothing of `Events` is synchronised": "Q [| {} |] Q"}),
        ("Q \\ {| a |}", {"`a` is not hidden": "Q \\ {| |}"}),
        ("Q [[a <- b]]", {"`a` is not renamed to `b`": "Q"}),
        (
            "Q |~| STOP",
            {
                "`|~|` becomes `[]` in `Q |~| STOP`": "Q [] STOP",
                "the alternative `STOP` is left out": "Q",
                "the alternative `Q` is left out": "STOP",
            },
        ),
        (
            "1 <= 2 & Q",
            {
                "the guard `1 <= 2` is left out": "Q",
                "the guard `1 <= 2` is never true": "STOP",
                "`<=` becomes `<` in `1 <= 2`": "1 < 2 & Q",
                "`1` becomes `2`": "2 <= 2 & Q",
                "`1` becomes `0`": "0 <= 2 & Q",
                "`2` becomes `3`": "1 <= 3 & Q",
                "`2` becomes `1`": "1 <= 1 & Q",
            },
        ),
    ],
)
def test_changes(text: str, expected: dict[str, str]) -> None:
    assert made(text) == expected


def test_classes_are_changed_too() -> None:
    found = {change.text: change.kind for change, _ in mutants(parse(Source("x.csp", CLASS)))}
    assert found["`n <= 2` is left out"] == "predicate"
    assert found["`<` becomes `<=` in `n < 2`"] == "predicate"
    assert found["the event `tick` is left out"] == "event"


def test_what_is_noticed_and_what_is_not(tmp_path: Path) -> None:
    path = tmp_path / "x.csp"
    path.write_text(SCRIPT)
    mutation = Mutation(str(path), checking.Settings(limits=checking.limits(states=500)))
    fates = {(m.change.span.line, m.change.text): (m.fate, m.by) for m in mutation.tried(mutation.changes())}
    assert fates[2, "`2` becomes `3`"] == ("noticed", "STOP [T= Count(2) \\ {| b |}")
    assert fates[2, "`2` becomes `1`"] == ("unnoticed", None)
    assert fates[3, "the guard `n < N` is left out"][0] in ("noticed", "undecided")
    assert fates[3, "nothing happens instead of `b`"] == ("noticed", "Count(0) :[deadlock free]")
    assert fates[3, "the event `b` is left out"] == ("invalid", None)
    assert fates[5, "`a` is not synchronised"] == ("unnoticed", None)
    assert {change.kind for change, _ in mutation.changes()} <= set(KINDS)


def test_nothing_to_notice(tmp_path: Path) -> None:
    path = tmp_path / "x.csp"
    path.write_text("channel a\nP = a -> P\n")
    with pytest.raises(Nothing):
        Mutation(str(path), checking.Settings())


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from cspcheck.cli import run

    path = tmp_path / "x.csp"
    path.write_text("channel a\nP = a -> P\nassert P :[deadlock free]\n")
    assert run(["mutate", str(path), "-v"]) == 0
    assert "2 changes: 1 noticed, 1 invalid; 100 % noticed" in capsys.readouterr().out
    path.write_text("channel a\nP = a -> P\nQ = a -> Q\nassert P :[deadlock free]\n")
    assert run(["mutate", str(path), "--kind", "event", "--format", "json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["schema"] == "cspcheck/mutation/1"
    assert [m["fate"] for m in found["mutants"]] == ["invalid", "noticed", "unnoticed", "unnoticed"]
    path.write_text("channel a\n")
    assert run(["mutate", str(path)]) == 2
    assert "CSP918" in capsys.readouterr().err
