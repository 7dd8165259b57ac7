"""The Object-Z part of a loaded script: its specification, what is odd about it, and what the core asks of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import cspcheck.cspm.oz.processes.evaluating  # noqa: F401  (registers how what classes become is evaluated)
from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.naming.symbols import Names
from cspcheck.cspm.notation import ClassReading
from cspcheck.cspm.oz.core import Specification
from cspcheck.cspm.oz.processes.alphabets import Alphabets
from cspcheck.cspm.oz.processes.context import ClassContext
from cspcheck.cspm.oz.processes.desugaring import desugared
from cspcheck.cspm.oz.typing.elaboration import elaborate
from cspcheck.cspm.oz.values.readings import written
from cspcheck.cspm.recursion import deep_recursion
from cspcheck.cspm.syntax import tree as syntax

if TYPE_CHECKING:
    from cspcheck.cspm.script import Script


@dataclass(frozen=True, slots=True)
class ObjectZPart:
    """The Object-Z part of a script: what its classes share, and what is odd about them."""

    context: ClassContext
    warnings: tuple[Diagnostic, ...]

    @property
    def control(self) -> bool:
        """Whether the data is dropped."""
        return self.context.control

    @property
    def has_left(self) -> bool:
        """Whether some class has met something outside the finite readings."""
        return self.context.has_left

    def chosen(self, readings: Sequence[str]) -> bool:
        """Whether one of some readings is none of the script: a value of a constant that its axioms leave open."""
        return not set(readings) <= {written(reading) for reading in self.context.specification.readings}

    def readings(self, names: Names, operands: Sequence[syntax.Expr]) -> tuple[str, ...]:
        """The finite readings that the classes behind some expressions follow, as the script writes them."""
        owners = {foreign.owner: None for foreign in Alphabets(names).foreign(operands)}
        return self.context.used(owners)


def classes_of_tree(tree: syntax.Script, semantics: ClassReading | None) -> tuple[ObjectZPart, syntax.Script]:
    """The classes of a script, and the script with what they become in their place.

    Raises:
        ScriptError: a paragraph is wrong.
    """
    elaborated = elaborate(tree)
    view = semantics.view if semantics is not None else None
    context = ClassContext(
        elaborated.specification,
        control=elaborated.specification.control if view is None else view == "control",
        angelic=semantics is not None and semantics.outputs == "angelic",
    )
    with deep_recursion():
        return ObjectZPart(context, elaborated.warnings), desugared(tree, elaborated, context)


def context_of(script: Script) -> ClassContext | None:
    """What the classes of a loaded script share; None if it has none."""
    return script.classes.context if isinstance(script.classes, ObjectZPart) else None


def specification_of(script: Script) -> Specification | None:
    """What the Object-Z part of a loaded script says; None if there is none."""
    context = context_of(script)
    return None if context is None else context.specification
