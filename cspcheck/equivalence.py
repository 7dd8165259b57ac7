"""Whether two versions of a script mean the same by what their assertions speak of.

A mutant that no assertion notices may be no mistake at all. What decides is refinement both ways in failures and
divergences, between the machines that the two versions give to one expression (Roscoe, Understanding Concurrent
Systems, section 9.1). The machines are explicit: nothing that one script evaluated is mistaken for what the other did.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from cspcheck import checking
from cspcheck.checker.budget import Incomplete
from cspcheck.checker.verdict import Verdict
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.oz import syntax as oz
from cspcheck.cspm.process.events import FIRST_EVENT
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values.text import show

if TYPE_CHECKING:
    from cspcheck.checker.lts import Lts
    from cspcheck.cspm.script import Script

MOST_STATES = 100_000
"""Machines that are larger are not compared."""
_COMPARISONS = ("==", "!=", "<", "<=", ">", ">=")
_PREDICATES = (("empty",), ("null",), ("member",), ("elem",))


class Version:
    """What one version of a script means by expressions; each is worked out once.

    Args:
        script: the script as it was loaded.
        settings: how its processes are explored.
    """

    def __init__(self, script: Script, settings: checking.Settings) -> None:
        self._script = script
        self._checker = checking.checker_for(script, settings, checking.NoWatch())
        self._machines: dict[str, Lts | None] = {}
        self._values: dict[str, str | None] = {}

    @property
    def script(self) -> Script:
        """The script."""
        return self._script

    def machine(self, text: str, *, all_values: bool = False) -> Lts | None:
        """The machine of a process; None where it is none, cannot be evaluated, or is too large, or where it has some
        values only: of those that the script reads, unless *all_values* are meant, and never of those chosen for it."""
        if all_values and self._readings(text):
            return None
        if text not in self._machines:
            self._machines[text] = self._explored(text)
        return self._machines[text]

    def _readings(self, text: str) -> tuple[str, ...]:
        try:
            return self._script.readings(self._script.assertion(f"({text}) :[deadlock free]").node)
        except ScriptError:
            return ()

    def _explored(self, text: str) -> Lts | None:
        classes = self._script.classes
        try:
            if classes is not None and classes.chosen(self._readings(text)):
                return None
            machine = self._checker.lts(self._script.process(text))
        except (ScriptError, Incomplete, MemoryError):
            return None
        return None if classes is not None and classes.has_left else machine

    def value(self, text: str) -> str | None:
        """A value as the language writes it; None where it cannot be evaluated."""
        if text not in self._values:
            try:
                self._values[text] = self._script.show(text)
            except ScriptError:
                self._values[text] = None
        return self._values[text]


Sort = Literal["process", "class", "value"]
"""What an expression is: a process, a class of which all values count, or a value."""


def subjects(assertion: syntax.Assertion) -> Iterator[tuple[str, Sort]]:
    """What an assertion speaks of, as text, and what that is: processes by name, with their arguments.

    Looked for below operators, and in arguments that are processes themselves: what `P |\\ A` hides of P counts.
    """
    from cspcheck.cspm.printing.printer import print_expression

    match assertion:
        case syntax.NotAssertion():
            yield from subjects(assertion.inner)
        case syntax.Refinement():
            for operand in (assertion.specification, assertion.implementation):
                for part in _named(operand):
                    yield print_expression(part), "process"
        case syntax.Property():
            for part in _named(assertion.process):
                yield print_expression(part), "process"
        case syntax.BooleanAssertion():
            for value in _compared(assertion.condition):
                yield "" if value is None else print_expression(value), "value"
        case oz.Obligations():
            yield f"{assertion.subject.name}::visible", "class"
        case oz.DataRefinement():
            yield from ((f"{name.name}::visible", "class") for name in (assertion.abstract, assertion.concrete))
        case oz.Subtype():
            yield from ((f"{name.name}::visible", "class") for name in (assertion.parent, assertion.child))


def _named(expression: syntax.Expr) -> Iterator[syntax.Expr]:
    match expression:
        case syntax.Paren():
            yield from _named(expression.inner)
        case syntax.Hide() | syntax.Rename():
            yield from _named(expression.process)
        case (
            syntax.ProcessBinary() | syntax.Synchronised() | syntax.AlphabetisedParallel() | syntax.LinkedParallel()
        ) | syntax.ClassParallel():
            yield from _named(expression.left)
            yield from _named(expression.right)
        case syntax.Apply():
            yield expression
            for argument in expression.arguments:
                yield from (part for part in _named(argument) if isinstance(part, syntax.Apply))
        case _:
            yield expression


def _compared(condition: syntax.Expr) -> Iterator[syntax.Expr | None]:
    """The values that a condition is about; None where it is only known to be true or false, which tells nothing."""
    match condition:
        case syntax.Paren():
            yield from _compared(condition.inner)
        case syntax.Unary():
            yield from _compared(condition.operand)
        case syntax.Binary() if condition.operator in ("and", "or"):
            yield from _compared(condition.left)
            yield from _compared(condition.right)
        case syntax.Binary() if condition.operator in _COMPARISONS:
            yield condition.left
            yield condition.right
        case syntax.Apply() if isinstance(condition.function, syntax.Name) and condition.function.parts in _PREDICATES:
            yield from condition.arguments
        case _:
            yield None


def equivalent(
    first: Version,
    second: Version,
    expressions: Sequence[tuple[str, Sort]],
    control: Callable[[], tuple[Version, Version] | None] | None = None,
) -> bool:
    """Whether it is shown that two versions mean the same by all expressions (of :func:`subjects`); False for none.

    Args:
        first, second: the versions.
        expressions: what is compared.
        control: the same versions without the data of classes, where nothing that data depends on differs: a class is
            its control with its data beside it, and what is the same in that view is the same. None where the script
            cannot be read so.
    """
    if not expressions or _events(first.script) != _events(second.script):
        return False

    def same(text: str, sort: Sort) -> bool:
        if sort == "value":
            return _same_value(first, second, text)
        views = None if control is None else control()
        if views is not None and _same_process(*views, text, all_values=False):
            return True
        return _same_process(first, second, text, all_values=sort == "class")

    return all(same(text, sort) for text, sort in expressions)


def _same_value(first: Version, second: Version, text: str) -> bool:
    value = first.value(text) if text else None
    return value is not None and value == second.value(text)


def _same_process(first: Version, second: Version, text: str, *, all_values: bool) -> bool:
    from cspcheck.checker.check import Checker
    from cspcheck.checker.semantics.machine_states import ExplicitMachine
    from cspcheck.cspm.process.terms import STOP

    one, other = (version.machine(text, all_values=all_values) for version in (first, second))
    if one is None or other is None or not all(map(_is_counted, (one, other), (first.script, second.script))):
        return False
    if one.root == other.root and all(
        np.array_equal(getattr(one, field), getattr(other, field)) for field in ("offsets", "labels", "targets")
    ):
        return True
    terms = [ExplicitMachine(lts, STOP).term(lts.root) for lts in (one, other)]
    checker = Checker(second.script, limits=checking.limits(seconds=20.0))
    return all(
        checker.check_refinement(left, "FD", right).verdict is Verdict.PASS for left, right in (terms, terms[::-1])
    )


def _is_counted(lts: Lts, script: Script) -> bool:
    """Whether all events of a machine are numbered by their declaration alone, and not as they were met."""
    return all(script.events.parts(label)[0].size is not None for label in lts.alphabet() if label >= FIRST_EVENT)


def _events(script: Script) -> list[tuple[str, tuple[tuple[str, ...] | None, ...]]]:
    """The events of a script by their numbers, as far as they are numbered by their declarations."""
    return [
        (channel.name, tuple(None if d is None else tuple(map(show, d.values)) for d in channel.domains))
        for channel in script.events.channels
    ]
