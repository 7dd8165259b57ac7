"""Two versions of classes that are said to mean the same do so in every state."""

from __future__ import annotations

from collections import Counter

import pytest

from cspcheck import checking
from cspcheck.checker.proof.answer import specification_of
from cspcheck.checker.proof.sameness import mean_the_same
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from cspcheck.equivalence import Version, equivalent
from cspcheck.mutation import mutants

TEXT = """
class C
  chan put : [x? : 0..2]
  chan get : [y! : 0..2]
  chan reset
  main = put -> main [] get -> main [] reset -> main
  state
    n : 0..2
    s : seq nat
    full : 0..1
  where
    #s <= 2
    full = 1 <=> #s = 2
    forall i : 1..#s @ s(i) <= 2
  init
    n = 0
    s = <>
  op enable_put
    x? : 0..2
  where
    #s < 2
    full = 0
  op effect_put
    Delta(s)
    x? : 0..2
  where
    s' = s ^ <x?>
  op com_get
    Delta(n, s)
    y! : 0..2
  where
    s /= <>
    s = <y!> ^ s'
    n' <= y!
    n' >= y!
  op com_reset
    Delta(n)
  where
    n' = 0
end
"""


def same(old: str, new: str) -> bool:
    assert old in TEXT
    one, other = (specification_of(load(Source("c.csp", text))) for text in (TEXT, TEXT.replace(old, new, 1)))
    return mean_the_same(one, other)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("", ""),
        ("#s < 2", "#s <= 1"),
        ("#s < 2\n", "true\n"),  # the rest of the guard says it
        ("    s /= <>\n", ""),  # and here the rest of the effect
        ("n' <= y!\n    n' >= y!", "n' = y!"),
        ("s = <y!> ^ s'", "y! = head s\n    s' = tail s"),  # with `s /= <>`
        ("#s <= 2", "not (#s > 2)"),
        ("s = <>\n  op", "#s = 0\n  op"),
        ("s' = s ^ <x?>", "#s' = #s + 1\n    s' = s ^ <x?>"),
    ],
)
def test_the_same(old: str, new: str) -> None:
    assert same(old, new)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("#s < 2\n    full = 0", "#s < 1"),
        ("n' <= y!", "true"),
        ("n' = 0", "n' = n"),
        ("n = 0\n    s = <>", "s = <>"),
        ("#s <= 2", "#s <= 3"),
        ("Delta(n)", "Delta(n, s)"),
        ("n : 0..2", "n : 0..3"),
        ("reset -> main", "reset -> STOP"),
        ("x? : 0..2]", "x? : 0..1]"),
    ],
)
def test_not_the_same(old: str, new: str) -> None:
    assert not same(old, new)


def test_against_the_machines_of_mutants() -> None:
    """Whatever is said to mean the same has the failures and divergences that it had, in every process."""
    source = Source("c.csp", TEXT + "assert C :[deadlock free]\n")
    first = Version(load(source), checking.Settings())
    told: Counter[tuple[bool, bool]] = Counter()
    for change, tree in mutants(parse(source)):
        try:
            script = load(tree)
        except ScriptError:
            continue
        proved = mean_the_same(specification_of(first.script), specification_of(script))
        second = Version(script, checking.Settings())
        seen = equivalent(first, second, [("C", "process")])
        assert seen or not proved, change.text
        told[proved, seen] += 1
    assert told[True, True] >= 3, told
    assert told[False, False] >= 10, told
