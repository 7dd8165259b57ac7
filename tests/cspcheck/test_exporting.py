"""Classes written as plain CSPm: the same verdicts, and the same states up to strong bisimulation."""

from __future__ import annotations

from pathlib import Path

import pytest

from cspcheck.checker.check import Checker
from cspcheck.checker.proof.answer import specification_of
from cspcheck.checker.reduction.bisimulation import strong_bisimulation
from cspcheck.checker.semantics.transitions import explore
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.notation import ClassReading
from cspcheck.cspm.script import Script, load
from cspcheck.cspm.source import Source
from cspcheck.exporting import plain_text

PRODUCER = Path(__file__).parents[2] / "specs" / "producer_consumer" / "requirement.csp"

PRODUCER_TEXT = PRODUCER.with_name("classes.csp").read_text(encoding="utf-8") + (
    PRODUCER.read_text(encoding="utf-8").replace('include "classes.csp"', "")
)

COUNTERS = """
reading nat = 0..9
class Counter
  chan inc, dec
  chan get : [v! : nat]
  state n : nat
  init n = 0
  op com_inc Delta(n) where n < 3 and n' = n + 1
  op com_dec Delta(n) where n > 0 and n' = n - 1
  op com_get v! : nat where v! = n
end
class Small
  inherit Counter
  main = inc -> inc -> dec -> second
  second = dec -> main
end
class Both
  chan a : [x? : 0..2; y! : 0..3]
  chan b
  local_chan inner
  state n : 0..3
  init n <= 1
  op com_a Delta(n) x? : 0..2; y! : 0..3 where y! <= x? and n' = x?
  op enable_b where n > 0
  op effect_b Delta(n) where n > 1 and n' = 0
  op com_inner where n = 2
end
class Ends
  chan c, d
  main = c -> SKIP
  state n : 0..3
  init n = 0
  op com_c Delta(n) where n' = n + 1
  op com_d Delta(n) where n > 0 and n' = 0
end
class Free
  chan inc
end
channel z
Two = Counter || Small
assert Counter :[deadlock free]
assert Small :[deadlock free]
assert Counter [T= Small
-- expect: fail
assert Small [T= Counter
assert Two :[deadlock free]
assert Both :[deadlock free [F]]
-- expect: fail
assert Both :[divergence free]
assert Both :[has trace]: <a.2.1, b>
assert Ends ; z -> STOP :[has trace]: <c, z>
assert Free :[divergence free]
assert Ends ; z -> STOP :[has trace]: <c, d, z>
"""

VALUES = """
STATUS ::= normal | alert<<0..1>>
SPEED == {v : real | -1.0 <= v <= 1.0}
reading SPEED = {-1.0, 0.5, 1.0}
given M
reading M = 2
schema Data
  vx, vy : SPEED
end
const limit : nat where limit = 2 end
datatype Colour = red | green
class C
  chan status : [s! : STATUS]
  chan data : [d? : Data]
  chan table : [f! : 0..1 --> Colour]
  method note : [m? : M]
  state last : Data; level : 0..limit; notes : seq M
  init last.vx = 1.0 and last.vy = -1.0 and level = 0 and notes = <>
  op com_status Delta(level) s! : STATUS where
    s! = (if level = limit then alert(1) else normal)
    level' = (if level = limit then 0 else level + 1)
  op com_data Delta(last) d? : Data where last' = d?
  op com_table f! : 0..1 --> Colour where f! = {0 |-> green, 1 |-> red}
  op com_note Delta(notes) m? : M where #notes < 2 and notes' = <m?> ^ notes
end
P = status?alert.n -> STOP [] status.normal -> P
Joined = C [| {| status |} |] P
assert C :[divergence free]
assert Joined :[has trace]: <status.normal, status.normal, status.alert.1>
assert C::visible :[has trace]: <C::note.M_1, C::note.M_2>
assert card({| C::note, data |}) == 11
"""


def written(text: str, **semantics: str) -> tuple[Script, Script, str]:
    """A script, the script that it becomes, and the text of that."""
    chosen = ClassReading(**semantics)  # type: ignore[arg-type]
    plain = plain_text(load(Source("classes.csp", text), semantics=chosen)).text
    return load(Source("classes.csp", text), semantics=chosen), load(Source("plain.csp", plain)), plain


@pytest.mark.parametrize("view", ["data", "control"])
@pytest.mark.parametrize("text", [COUNTERS, VALUES, PRODUCER_TEXT], ids=["counters", "values", "pc"])
def test_verdicts_and_states_are_those_of_the_classes(text: str, view: str) -> None:
    classes, plain, _ = written(text, view=view)

    assert plain.classes is None
    assert [a.expected for a in classes.assertions] == [a.expected for a in plain.assertions]
    before, after = Checker(classes), Checker(plain)
    for one, other in zip(classes.assertions, plain.assertions, strict=True):
        assert before.check(one.node).verdict is after.check(other.node).verdict, one.text
    for name in specification_of(classes).classes:
        for process in (name, f"{name}::visible"):
            machine = strong_bisimulation(explore(classes.process(process)).lts)
            copy = strong_bisimulation(explore(plain.process(process.replace("::", "_"))).lts)
            assert (machine.states, len(machine.labels)) == (copy.states, len(copy.labels)), process


def test_outputs_are_written_as_they_are_chosen() -> None:
    dice = "class Dice\n  chan roll : [v! : 1..3]\n  op com_roll v! : 1..3\nend\n"
    text = dice + "Fair = roll?v -> Fair\nassert Fair [FD= Dice\n"

    for outputs, verdict in (("demonic", "fail"), ("angelic", "pass")):
        _, plain, _ = written(text, outputs=outputs)
        assert Checker(plain).check(plain.assertions[0].node).verdict == verdict


def test_the_script_says_where_it_comes_from() -> None:
    _, _, plain = written(COUNTERS)

    head, *rest = plain.splitlines()
    assert head == "-- classes.csp as plain CSPm, written by `cspcheck cspm`."
    assert rest[0] == "-- Finite readings: nat = 0..9."
    assert "Counter_data(n) =" in rest
    assert "  (n < 3 and 0 <= n + 1 and n + 1 <= 9 & inc -> Counter_data(n + 1))" in rest


def test_a_class_that_leaves_its_readings_is_not_written() -> None:
    text = COUNTERS.replace("n < 3 and ", "")

    with pytest.raises(ScriptError) as error:
        written(text)

    assert error.value.diagnostics[0].code == "CSP686"
    assert "leads to n' = 10, outside the reading `nat = 0..9`" in error.value.diagnostics[0].message


def test_what_the_equations_prevent_from_leaving_is_written() -> None:
    text = (
        COUNTERS.replace("n < 3 and ", "").replace("class Counter", "class Up").replace("inherit Counter", "inherit Up")
    )
    small = text.replace("  op com_get", "  main = inc -> dec -> main\n  op com_get", 1).replace(
        "main = inc -> inc -> dec -> second\n  second = dec -> main", ""
    )
    only = "\n".join(line for line in small.splitlines() if not line.startswith(("assert", "Two")))

    classes, plain, _ = written(only)

    assert explore(classes.process("Up")).lts.states == explore(plain.process("Up")).lts.states == 2


def test_the_verb_writes_the_script_or_says_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from cspcheck.cli import front_door

    script, target = tmp_path / "c.csp", tmp_path / "plain.csp"
    script.write_text(COUNTERS)
    with pytest.raises(SystemExit) as ended:
        front_door.main(["cspm", str(script), "-o", str(target)], standalone_mode=False)
    assert ended.value.code == 0
    assert target.read_text() == plain_text(load(script)).text

    script.write_text(COUNTERS.replace("n < 3 and ", ""))
    with pytest.raises(SystemExit) as ended:
        front_door.main(["cspm", str(script)], standalone_mode=False)
    assert ended.value.code == 2
    assert "error[CSP686]" in capsys.readouterr().err


def test_what_no_assertion_uses_is_left_out_and_may_be_infinite() -> None:
    wide = """
given ITEM
class Wide
  chan put : [i? : ITEM]
  method count : [n! : nat]
  state n : nat; s : seq ITEM
  init n = 0 and s = <>
  op put Delta(n, s) i? : ITEM where n' = n + 1 and s' = s ^ <i?>
end
Loop = z -> Loop
"""
    _, plain, text = written(COUNTERS + wide)

    assert "-- Left out, since no assertion uses it: Wide." in text.splitlines()
    assert "Loop = z -> Loop" in text.splitlines()
    assert "Free :[divergence free]" in [a.text for a in plain.assertions]


def test_what_only_classes_can_be_asked_is_left_out_with_a_warning() -> None:
    asked = COUNTERS + "assert Counter :[obligations]\nassert not Counter [OZ= Small\n"
    exported = plain_text(load(Source("classes.csp", asked)))

    assert [w.code for w in exported.warnings] == ["CSP688", "CSP688"]
    plain = load(Source("plain.csp", exported.text))
    assert len(plain.assertions) == len(load(Source("classes.csp", COUNTERS)).assertions)
    assert "-- only classes have this: assert Counter :[obligations]" in exported.text


def test_nothing_is_written_that_other_tools_do_not_read() -> None:
    text = COUNTERS + "assert not 1 == 2\nassert <-1..1> == <(-1), 0, 1>\n"
    _, plain, written_text = written(text)

    assert "<-1" not in written_text
    assert "assert if <" not in written_text
    assert [Checker(plain).check(a.node).verdict.value for a in plain.assertions[-2:]] == ["pass", "pass"]
    assert not [a for a in plain.assertions if "==" in a.text and ":[divergence free]" not in a.text]


def test_events_that_a_class_does_not_declare_are_none_of_its_own() -> None:
    text = """
class P
  chan c : [x? : 0..1]
  main = c -> main
end
class Q
  chan c : [x! : 0..3]
  main = c -> SKIP
  op c x! : 0..3
end
assert P :[has trace [T]]: <c.1, c.0>
-- expect: fail
assert P :[has trace [T]]: <c.3>
-- expect: fail
assert P || Q :[deadlock free]
"""
    classes, plain, _ = written(text)
    for one, other in zip(classes.assertions, plain.assertions, strict=True):
        assert Checker(classes).check(one.node).verdict is Checker(plain).check(other.node).verdict, one.text


def test_a_script_without_classes_is_written_in_one_file_and_without_what_is_ours_alone(tmp_path: Path) -> None:
    (tmp_path / "types.csp").write_text("datatype Id = A | B\nassert card(Id) == 2\n")
    (tmp_path / "main.csp").write_text(
        'include "types.csp"\n'
        "transparent normalise, normal\nchannel tock\nchannel c : Id\nP = normalise(c?x -> P)\n"
        "Timed {\n  Q = c.A -> Q\n  assert Q :[divergence free]\n}\n"
        "assert P [T= P :[symmetry reduce]: Id\nassert not <-1..1> == <0>\n"
    )

    text = plain_text(load(tmp_path / "main.csp")).text

    plain = load(Source("plain.csp", text))
    assert [Checker(plain).check(a.node).verdict.value for a in plain.assertions] == ["pass"] * 4
    lines = text.splitlines()
    assert "include" not in text
    assert "transparent normal" in lines
    assert "P = normal(c?x -> P)" in lines
    assert "assert P [T= P" in lines
    assert "assert (if card(Id) == 2 then STOP else DIV) :[divergence free]" in lines
    assert text.count("assert Q") == 1


def test_a_channel_that_is_called_print_is_written_as_a_name() -> None:
    script = load(
        Source(
            "printer.csp",
            """
class Out
  chan print: [v! : 0..3]
  main = print-> main
  state n : 0..3
  init n = 0
  op com_print Delta(n) v! : 0..3 where v! = n and n' = (n + 1) mod 4
end
Q = print?y -> Q
assert Out || Q :[deadlock free]
assert Out :[has trace]: <print.0, print.1>
""",
        )
    )
    plain = load(Source("plain.csp", plain_text(script).text))

    assert not plain.classes
    assert [Checker(plain).check(a.node).verdict.value for a in plain.assertions] == ["pass", "pass"]
