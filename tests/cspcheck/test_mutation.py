"""Mutants: what is changed, and whether an assertion notices it."""

import json
import random
from collections import Counter
from pathlib import Path

import pytest

from cspcheck import checking
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.printing.printer import print_script
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from cspcheck.equivalence import Version, equivalent
from cspcheck.mutating import Mutation, NothingToNotice
from cspcheck.mutation import KINDS, mutants
from tests.reference.denotations import Semantics, TooLarge, Unguarded
from tests.reference.processes import EVENTS, random_process
from tests.reference.text import script
from tests.reference.verdicts import refinement

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
    mutation = Mutation([(str(path), None)], checking.Settings(limits=checking.limits(states=500)))
    trials = mutation.changes()
    fates = {(m.change.span.line, m.change.text): (m.fate, m.by) for m in mutation.tried(trials)}
    assert fates[2, "`2` becomes `3`"] == ("noticed", "STOP [T= Count(2) \\ {| b |}")
    assert fates[2, "`2` becomes `1`"] == ("unnoticed", None)
    assert fates[3, "the guard `n < N` is left out"][0] in ("noticed", "undecided")
    assert fates[3, "nothing happens instead of `b`"] == ("noticed", "Count(0) :[deadlock free]")
    assert fates[3, "the event `b` is left out"] == ("invalid", None)
    assert fates[5, "`a` is not synchronised"] == ("unnoticed", None)
    assert {trial.change.kind for trial in trials} <= set(KINDS)


def fates(
    *paths: Path, system: bool = False, only: tuple[tuple[int, str], ...] = ()
) -> dict[tuple[str, int, str], str]:
    """What becomes of the changes of scripts, by file, line and what is said of them."""
    mutation = Mutation([(str(path), None) for path in paths], checking.Settings(), system=system)
    return {
        (Path(m.change.span.source.name).name, m.change.span.line, m.change.text): m.fate
        for m in mutation.tried(
            [t for t in mutation.changes() if not only or (t.change.span.line, t.change.text) in only]
        )
    }


def test_a_change_that_changes_nothing_is_equivalent(tmp_path: Path) -> None:
    path = tmp_path / "x.csp"
    path.write_text("""\
channel a, b
N = 2
P(n) = n < N & a -> P((n + 1) % 2) [] n >= N & b -> STOP
Q = a -> Q [] a -> Q
twice(n) = if n > 0 then 2 * n else 0
Unasked = a -> STOP
assert P(0) :[divergence free]
assert Q |\\ {b} :[deadlock free]
assert twice(0) == 0 and twice(1) == 2
S = {1, 2, 3}
few(s) = card(s) < 7
assert not empty(S) and member(2, S)
assert few(union(S, {9}))
""")
    found = {(line, text): fate for (_, line, text), fate in fates(path).items()}
    assert found[2, "`2` becomes `3`"] == "equivalent"
    assert found[3, "the guard `n >= N` is never true"] == "equivalent"
    assert found[3, "nothing happens instead of `a`"] == "unnoticed"
    assert found[4, "the alternative `a -> Q` is left out"] == "equivalent"
    assert found[4, "`[]` becomes `|~|` in `a -> Q [] a -> Q`"] == "equivalent"
    assert found[5, "the condition `n > 0` is always true"] == "equivalent"
    assert found[5, "`0` becomes `1`"] == "noticed"
    # A condition that stays true tells nothing of what it is about.
    assert found[10, "`1` becomes `0`"] == found[11, "`7` becomes `8`"] == "unnoticed"
    assert found[6, "nothing happens instead of `a`"] == "unnoticed"  # nobody asks


def test_what_is_hidden_in_the_assertion_is_not_equivalent(tmp_path: Path) -> None:
    path = tmp_path / "x.csp"
    path.write_text("channel a, b\nP = a -> b -> P\nassert P \\ {b} :[deadlock free]\nassert STOP [T= P \\ {a, b}\n")
    assert fates(path)["x.csp", 2, "the event `b` is left out"] == "unnoticed"


def test_a_change_of_the_events_is_not_equivalent(tmp_path: Path) -> None:
    path = tmp_path / "x.csp"
    path.write_text(
        "N = 1\nchannel c : {0..N}\nchannel d : {0..2}\nP = d?x -> P\nQ = c.0 -> Q\nassert Q :[deadlock free]\n"
    )
    assert fates(path)["x.csp", 1, "`1` becomes `2`"] == "unnoticed"


def test_only_what_is_checked_is_changed(tmp_path: Path) -> None:
    path = tmp_path / "x.csp"
    path.write_text("channel a\nShould = a -> Should\nP = a -> P\nassert Should [T= P\nassert P :[deadlock free]\n")
    assert {line for _, line, _ in fates(path)} == {2, 3}
    assert {line for _, line, _ in fates(path, system=True)} == {3}


def test_a_file_that_is_included_is_asked_about_by_all(tmp_path: Path) -> None:
    (tmp_path / "p.csp").write_text("channel a, b\nP = a -> b -> P\n")
    one, other = tmp_path / "one.csp", tmp_path / "other.csp"
    one.write_text('include "p.csp"\nassert P :[deadlock free]\n')
    other.write_text('include "p.csp"\nQ = a -> b -> Q\nassert P [T= Q\n')
    change = "p.csp", 2, "the event `b` is left out"
    assert fates(one)[change] == "unnoticed"
    assert fates(one, other)[change] == "noticed"


def test_classes_that_stay_what_they_are(tmp_path: Path) -> None:
    path = tmp_path / "x.csp"
    path.write_text("""\
class C
  chan put : [x? : real]
  chan get : [y! : real]
  main = put -> get -> main [] put -> get -> main
  state
    n : real
    once : bool
  init
    once = true
  op com_put
    Delta(n)
    x? : real
  where
    n' = x?
  op com_get
    y! : real
  where
    y! = n
end
class D
  const SIZE : nat where SIZE = 3
  chan up
  main = up -> main
  state
    k : 0..9
    unseen : 0..2
  init
    k = 0
    unseen = 0
  op up
    Delta(k)
  where
    k < SIZE
    k' = k + 1
end
assert C :[state inhabited]

assert D :[divergence free]
""")
    lost = 4, "the alternative `put -> get -> main` is left out"
    only = lost, (21, "`3` becomes `4`"), (28, "`0` becomes `1`"), (29, "`unseen = 0` is left out")
    found = {(line, text): fate for (_, line, text), fate in fates(path, only=only).items()}
    # Without its data the one alternative is the other.
    assert found[lost] == "equivalent"
    # A script that speaks of values cannot be read without them.
    (tmp_path / "y.csp").write_text(path.read_text() + "P = put?x -> STOP\n")
    assert fates(tmp_path / "y.csp", only=(lost,))["y.csp", *lost] in ("equivalent", "unnoticed")
    assert found[21, "`3` becomes `4`"] == "unnoticed"  # constants are looked at for some values
    assert found[29, "`unseen = 0` is left out"] == "equivalent"
    assert found[28, "`0` becomes `1`"] == "unnoticed"


def test_equivalence_against_the_definitions() -> None:
    """Of random processes: what is called equivalent has the failures and divergences that it had, and no other."""
    rng = random.Random(7)
    told: Counter[bool] = Counter()
    while told.total() < 60:
        text = script(P=random_process(rng, 7))
        source = Source("x.csp", f"{text}\nassert P :[deadlock free]\n")
        try:
            first = Version(load(source), checking.Settings())
        except ScriptError:
            continue
        semantics = Semantics(EVENTS)
        for _, tree in mutants(parse(source)):
            try:
                second = Version(load(tree), checking.Settings())
                before, after = (semantics.of(version.script.process("P")) for version in (first, second))
                same = all(refinement(a, b, "FD") is None for a, b in ((before, after), (after, before)))
            except (ScriptError, Unguarded, TooLarge):
                continue
            assert equivalent(first, second, [("P", "process")]) == same, print_script(tree)
            told[same] += 1
    assert min(told[True], told[False]) > 8, told


def test_nothing_to_notice(tmp_path: Path) -> None:
    path = tmp_path / "x.csp"
    path.write_text("channel a\nP = a -> P\n")
    with pytest.raises(NothingToNotice):
        Mutation([(str(path), None)], checking.Settings())


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
    assert run(["mutate", str(tmp_path), "--sample", "2", "--seed", "1", "--format", "json"]) == 1
    assert len(json.loads(capsys.readouterr().out)["mutants"]) == 2
    path.write_text("channel a\nP = a -> P [] a -> P\nassert P :[deadlock free]\n")
    assert run(["mutate", str(path), "--kind", "operator"]) == 0
    assert "3 changes: 3 equivalent, in" in capsys.readouterr().out
    path.write_text("channel a\n")
    assert run(["mutate", str(path)]) == 2
    assert "CSP918" in capsys.readouterr().err
