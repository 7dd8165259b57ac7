"""Types, constants and channels of classes are those of the script around them, and the other way round."""

from __future__ import annotations

from fractions import Fraction

import pytest

from cspcheck.cspm.diagnostics import ScriptError
from tests.cspm.oz.asking import outcome, script

VALUES = """
STATUS ::= normal | alert<<0..1>>
SPEED == {v : real | -1.0 <= v <= 1.0}
reading SPEED = {-1.0, 0.5, 1.0}
schema Data
  vx, vy : SPEED
end
const limit : nat where limit = 2 end
datatype Colour = red | green
class C
  chan status : [s! : STATUS]
  chan data : [d? : Data]
  chan paint : [c? : Colour]
  chan trail : [q! : seq SPEED]
  chan table : [f! : 0..1 --> Colour]
  state last : Data; colour : Colour; level : 0..limit
  init last.vx = 1.0 and last.vy = -1.0 and colour = red and level = 0
  op com_status Delta(level) s! : STATUS where
    s! = (if level = limit then alert(1) else normal)
    level' = (if level = limit then 0 else level + 1)
  op com_data Delta(last) d? : Data where last' = d?
  op com_paint Delta(colour) c? : Colour where colour' = c?
  op com_table f! : 0..1 --> Colour where f! = {0 |-> colour, 1 |-> red}
end
P = status?alert.n -> paint!green -> STOP [] status.normal -> P
"""


def test_values_of_classes_are_values_of_the_script() -> None:
    loaded = script(VALUES.replace("  chan trail : [q! : seq SPEED]\n", ""))

    assert loaded.evaluate("STATUS") == {"normal", "alert.0", "alert.1"}
    assert loaded.show("SPEED") == "{ -1, 0.5, 1}"
    assert loaded.evaluate("card(Data)") == 9
    assert loaded.evaluate("limit") == 2
    assert loaded.evaluate("SPEED") == {Fraction(-1), Fraction(1, 2), Fraction(1)}
    assert loaded.evaluate("card({| data, table |})") == 9 + 4
    names = {loaded.events.name(number) for number in loaded.event_set("{| data, table |}")}
    assert "data.(-1, 0.5)" in names
    assert "table.(| 0 => green, 1 => red |)" in names


def test_classes_and_processes_of_the_script_meet_on_their_channels() -> None:
    text = VALUES.replace("  chan trail : [q! : seq SPEED]\n", "")
    joined = "C [| {| status, paint |} |] P"

    assert (
        outcome(text, f"{joined} :[has trace]: <status.normal, status.normal, status.alert.1, paint.green>")[0]
        == "pass"
    )
    assert outcome(text, f"{joined} :[has trace]: <status.alert.1>")[0] == "fail"


def test_a_channel_may_be_declared_by_the_script() -> None:
    text = "channel a : {0..5}\nclass C\n  chan a : [x? : 0..2]\n  op com_a x? : 0..2\nend\nP = a?x -> P\n"

    assert script(text).evaluate("card({| a |})") == 6
    assert outcome(text, "C :[has trace]: <a.2>")[0] == "pass"
    assert outcome(text, "C :[has trace]: <a.3>")[0] == "fail"


def test_channels_may_carry_more_than_can_be_gone_through() -> None:
    text = """
class C
  chan wide : [x! : 0..10000000000]
  chan sets : [s! : power (0..40)]
  state n : 0..10000000000
  init n = 9999999999
  op com_wide Delta(n) x! : 0..10000000000 where n' = n + 1 and x! = n
  op com_sets s! : power (0..40) where s! = {1, n mod 7}
end
"""
    assert outcome(text, "C :[has trace]: <wide.9999999999>")[0] == "pass"
    assert outcome(text, "C :[has trace]: <wide.9999999999, wide.10000000000>")[0] == "fail", "n' would be too large"
    assert outcome(text, "C :[has trace]: <sets.{1, 3}>")[0] == "pass"
    assert outcome(text, "C :[deadlock free]")[0] == "pass"
    with pytest.raises(ScriptError, match="CSP682"):
        script(text + "P = sets?x -> P\n").process("P").body()  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("channel C\nclass C\n  chan a\nend\n", "`C` is a class and something else as well"),
        (
            "given M\nreading M = 2\nM_1 = STOP\nclass C\n  chan a : [x : M]\nend\n",
            "`M_1` is an element of the given set `M`",
        ),
    ],
)
def test_names_that_classes_need_are_theirs(text: str, message: str) -> None:
    with pytest.raises(ScriptError) as error:
        script(text)

    assert error.value.diagnostics[0].code == "CSP685"
    assert message in error.value.diagnostics[0].message
