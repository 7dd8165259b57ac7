"""What classes' variables are, where a run is shown: in text, as JSON, as a chart and in the probe."""

from __future__ import annotations

import re
from functools import cache

import cspcheck
from cspcheck.report.probe import show_point, show_trace
from cspcheck.report.style import Style

SCRIPT = """class Lift
  chan call : [f? : 0..3]
  chan arrive
  method check
  main = call -> check -> arrive -> main
  state at, goal : 0..3
  init at = 0 and goal = 0
  op com_call Delta(goal) f? : 0..3 where goal' = f?
  op com_check Delta(at) where at' = goal
  op com_arrive where at = goal
end
class Door
  chan arrive
  state open : bool
  init open = false
  op com_arrive Delta(open) where open = false and open' = true
end
assert Lift || Door :[deadlock free]
"""


@cache
def result() -> cspcheck.Result:
    (found,) = cspcheck.loads(SCRIPT).check()
    return found


def test_the_text_names_classes_and_says_what_has_changed() -> None:
    rows = [re.sub(r"\s+", " ", line).strip() for line in result().explain().splitlines()]
    start = rows.index("Lift: at = 0, goal = 0; Door: open = false")
    assert rows[start + 1 : start + 5] == [
        "1 call.0 Lift",
        "2 tau (Lift::check) Lift",
        "3 arrive Lift; Door: open = true",
        "4 call.0 Lift",
    ]


def test_json_names_classes_and_says_what_has_changed() -> None:
    components = result().counterexample.components
    assert [(c.name, dict(c.variables)) for c in components] == [
        ("Lift", {"at": "0", "goal": "0"}),
        ("Door", {"open": "false"}),
    ]
    assert [dict(new) for new in components[1].changes[:3]] == [{}, {}, {"open": "true"}]


def test_the_chart_shows_values_at_the_beginning_and_where_they_change() -> None:
    values = re.findall(r'class="value"[^>]*>([^<]*)<', result().chart() or "")
    assert values == ["at = 0", "goal = 0", "open = false", "open = true"]


def test_the_probe_shows_values_instead_of_the_choices_that_they_leave() -> None:
    script = cspcheck.loads(SCRIPT)
    probe = script.process("Lift").probe()
    shown = show_point(probe, Style())
    assert "at = 0, goal = 0" in shown
    assert "call.0 -> Lift(" not in shown
    probe.perform("call.2")
    assert "Lift: goal = 2" in show_trace(probe, Style())
