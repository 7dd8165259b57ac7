"""Every table of rules knows every form of the language, so that no form is forgotten when one is added."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

import cspcheck.cspm.evaluator
import cspcheck.cspm.oz.processes.evaluating
import cspcheck.cspm.typing.inference  # noqa: F401 -- they fill the tables
from cspcheck.cspm.evaluator.core import VALUES
from cspcheck.cspm.naming.resolve import TIES
from cspcheck.cspm.printing.declarations import Printer  # noqa: F401 -- fills the table
from cspcheck.cspm.printing.patterns import PRINTS
from cspcheck.cspm.syntax import tree as s
from cspcheck.cspm.syntax.dispatch import Dispatch
from cspcheck.cspm.syntax.nodes import Node
from cspcheck.cspm.typing.inference.context import INFERS

FORMS = [kind for kind in vars(s).values() if isinstance(kind, type) and issubclass(kind, Node)]


def concrete(*bases: type[Node]) -> list[type[Node]]:
    """The forms of CSPm among the classes below *bases*: those that nothing else is derived from."""
    derived = {base for kind in FORMS for base in kind.__mro__[1:]}
    return [kind for kind in FORMS if issubclass(kind, bases) and kind not in derived and kind not in bases]


ELSEWHERE = {s.Foreign, s.Paragraph, s.Clause, s.NameDeclaration, s.Comment, s.TypeConstraint}
"""What extensions bring, and the parts that are dealt with where the form that they belong to is."""

CASES: list[tuple[Dispatch[object], Iterable[type[Node]]]] = [
    (VALUES, concrete(s.Expr)),  # type: ignore[list-item]
    (INFERS, concrete(s.Expr, s.Pattern)),  # type: ignore[list-item]
    (PRINTS, concrete(Node)),  # type: ignore[list-item]
    (TIES, concrete(s.Expr, s.Declaration, s.Assertion)),  # type: ignore[list-item]
]


@pytest.mark.parametrize(("table", "forms"), CASES, ids=[table.purpose for table, _ in CASES])
def test_no_form_is_without_a_rule(table: Dispatch[object], forms: Iterable[type[Node]]) -> None:
    assert {kind.__name__ for kind in forms if kind not in table and kind not in ELSEWHERE} == set()


def test_a_form_has_one_rule() -> None:
    table = Dispatch[object]("count")
    table(s.Name)(len)

    with pytest.raises(AssertionError, match="two rules to count Name"):
        table(s.Name)(len)
