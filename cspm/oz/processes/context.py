"""What the evaluation of a script's classes shares: the specification, an evaluator for each, how they are read."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.values.evaluation import TermEvaluator
from cspcheck.cspm.oz.values.readings import written

if TYPE_CHECKING:
    from cspcheck.cspm.oz.processes.meaning import DataPart


@dataclass(eq=False)
class ClassContext:
    """Shared by everything that the classes of one script become.

    Attributes:
        specification: the script's.
        control: whether the data is dropped.
        angelic: whether the environment chooses outputs.
        models: classes by name, instances of generic ones included.
        visible: for each class the member that is its process with the methods visible.
        declared: what the CSPm part of the script declares.
        unshared: a class and a channel of it that is another than that of this name in other classes.
    """

    specification: core.Specification
    control: bool = False
    angelic: bool = False
    models: dict[str, core.ClassModel] = field(default_factory=dict)
    visible: dict[str, str] = field(default_factory=dict)
    declared: frozenset[str] = frozenset()
    unshared: frozenset[tuple[str, str]] = frozenset()
    parts: dict[str | None, DataPart] = field(default_factory=dict)
    """The data parts of the classes whose processes have been evaluated."""
    _evaluators: dict[str | None, TermEvaluator] = field(default_factory=dict)

    def evaluator(self, owner: str | None) -> TermEvaluator:
        """The evaluator of a class, or of what belongs to none."""
        found = self._evaluators.get(owner)
        if found is None:
            if owner is None:
                found = TermEvaluator(self.specification)
            else:
                outside = self.evaluator(None)
                found = TermEvaluator(self.specification, self.models[owner], outside.constants)
            self._evaluators[owner] = found
        return found

    def class_of(self, text: str) -> core.ClassModel | None:
        """The class whose process is called so, with its methods visible or not."""
        name, _, member = text.partition("::")
        if member and member != self.visible.get(name):
            return None
        return self.specification.classes.get(name)

    @property
    def has_left(self) -> bool:
        """Whether some class has met something outside the finite readings."""
        return any(evaluator.has_left for evaluator in self._evaluators.values())

    def used(self, owners: Iterable[str | None]) -> tuple[str, ...]:
        """The finite readings that some classes follow, in the order of the script; choices of constants last."""
        found: dict[str, None] = {}
        for owner in owners:
            if owner in self.parts:
                _ = self.parts[owner].operations  # what is not planned yet follows readings too
            found.update(self.evaluator(owner).used)
        order = [written(reading) for reading in self.specification.readings]
        return tuple(sorted(found, key=lambda text: order.index(text) if text in order else len(order)))
