"""What is documented of mistakes with the processes of classes: each example makes it, and each repair mends it."""

from __future__ import annotations

import pytest

import cspcheck.cspm.oz.processes.messages  # noqa: F401 -- registers its mistakes
from cspcheck.checker.proof.answer import specification_of
from cspcheck.checker.semantics.transitions import LimitReached, explore
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.diagnostics import MISTAKES, ScriptError
from cspcheck.cspm.oz.values import evaluation
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from cspcheck.exporting import plain_text

CODES = sorted(code for code in MISTAKES if "CSP680" <= code <= "CSP699")


def codes(text: str) -> set[str]:
    """What is wrong with a script, its classes explored and written out."""
    source = Source("example.csp", text)
    try:
        script = load(source)
        for name in specification_of(script).classes:
            explore(script.process(name), Limits(states=2_000))
        exported = plain_text(load(source))
    except ScriptError as error:
        return {diagnostic.code for diagnostic in error.diagnostics}
    except LimitReached:
        return {"too many states"}
    return {warning.code for warning in exported.warnings}


@pytest.mark.parametrize("code", CODES)
def test_the_example_makes_the_mistake_and_the_repair_does_not(code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    mistake = MISTAKES[code]
    monkeypatch.setattr(evaluation, "MOST_TRIED", evaluation.MOST_TRIED // 20)  # too many are so sooner

    assert code in codes(mistake.example)
    assert codes(mistake.repair) == set()


def test_there_are_codes_to_be_tested() -> None:
    assert "CSP686" in CODES


@pytest.mark.parametrize(
    ("lines", "help_"),
    [
        ("  op enable up where n < 3\n  op effect_up Delta(n) where n' = n + 1", "write `op enable_up`"),
        ("  enable up where n < 3", "write `op enable_up`"),
        ("  op effect up Delta(n) where n' = n + 1", "write `op effect_up`"),
        ("  op up Delta(m) where m' = 0", "`x : {0..3}` declares a set, `x : 0..3` one of its numbers"),
    ],
)
def test_habits_are_told_with_their_repair(lines: str, help_: str) -> None:
    text = f"class C\n  chan up\n  state n : 0..3; m : {{0..3}}\n  init n = 0\n{lines}\nend\n"
    with pytest.raises(ScriptError) as error:
        load(Source("c.csp", text))

    assert error.value.diagnostics[0].help == help_


def test_a_set_of_one_range_is_told_where_no_type_clashes() -> None:
    text = """channel plain : {0..3}

const limit : {1..2}

class C
  chan up : [v? : {0..3}; w! : 0..3]
  state n : {0..3}; s : power (0..3); t : {0..3, 1..2}
  init forall k : {0..1} @ k = k
  op com_up v? : {0..3}; w! : 0..3 where w! = 0
end
"""
    script = load(Source("c.csp", text))

    told = [(warning.span.line, warning.help) for warning in script.warnings if warning.code == "CSP647"]
    assert told == [
        (3, "for a number write `1..2`"),
        (6, "for a number write `0..3`"),
        (7, "for a number write `0..3`"),
        (8, "for a number write `0..1`"),
        (9, "for a number write `0..3`"),
    ]


def test_a_mistake_of_type_comes_with_the_set_that_it_is_due_to() -> None:
    with pytest.raises(ScriptError) as error:
        load(Source("c.csp", "class C\n  chan up\n  state n : {0..3}\n  op com_up Delta(n) where n' = n + 1\nend\n"))

    assert [diagnostic.code for diagnostic in error.value.diagnostics] == ["CSP632", "CSP647"]
