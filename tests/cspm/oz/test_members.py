"""The members of a class may have any name that a script can write: none is kept for the class itself."""

from __future__ import annotations

import pytest

from cspcheck.checker.check import Checker
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source

COUNTER = """class C
  method {name} : [v! : 0..3]
  state n : 0..3
  init n = 0
  op {name} Delta(n) v! : 0..3 where v! = n and n' = (n + 1) mod 4
end
"""


def verdict(text: str, assertion: str) -> str:
    script = load(Source("classes.csp", text))
    return Checker(script).check(script.assertion(assertion).node).verdict.value


@pytest.mark.parametrize("name", ["visible", "main", "done", "data", "C", "init", "tick", "tau"])
def test_a_method_may_have_any_name(name: str) -> None:
    text = COUNTER.format(name=name)
    whole = "C::visible'" if name == "visible" else "C::visible"

    assert verdict(text, f"{whole} :[has trace]: <C::{name}.0, C::{name}.1>") == "pass"
    assert verdict(text, f"{whole} :[has trace]: <C::{name}.1>") == "fail"
    assert verdict(text, "C :[divergence free]") == "fail"


def test_an_equation_and_a_constant_may_have_the_name_of_the_process_with_the_methods_visible() -> None:
    text = COUNTER.format(name="step").replace("end\n", "  main = visible\n  visible = step.0 -> STOP\nend\n")

    assert verdict(text, "C::visible :[has trace]: <C::step.0>") == "pass"
    assert verdict(text, "C::visible' :[has trace]: <C::step.0>") == "pass"
    assert verdict(text, "C::visible' [T= C::visible") == "pass"
    constant = COUNTER.format(name="step").replace("  state", "  const visible : 0..3 where visible = 2 end\n  state")
    assert (
        verdict(
            constant,
            "C::visible' :[has trace]: <C::step.0, C::step.1, C::step.visible>".replace(
                "step.visible", "step.C::visible"
            ),
        )
        == "pass"
    )


def test_a_subclass_inherits_the_name() -> None:
    text = COUNTER.format(name="visible") + "class D inherit C end\n"

    assert verdict(text, "D::visible' :[has trace]: <D::visible.0, D::visible.1>") == "pass"


def test_a_field_of_a_schema_may_be_called_init() -> None:
    text = """schema S
  init : 0..2
end
class C
  chan step
  state s : S
  init s.init = 1
  op step Delta(s) where s.init < 2 and s'.init = s.init + 1
end
"""

    assert verdict(text, "C :[has trace]: <step>") == "pass"
    assert verdict(text, "C :[has trace]: <step, step>") == "fail"
