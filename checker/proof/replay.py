"""Values that the solver found, put into the specification by the independent evaluator.

The evaluator shares nothing with the encoding but the terms. What it cannot go through, because a quantifier ranges
over an infinite set, is said to be undecided; what it finds to be wrong is a mistake of the encoding or an
approximation, and is never shown.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from enum import Enum
from fractions import Fraction
from typing import Any

from cspcheck.checker.proof.terms import Key, renamed, universe
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Constant, Construct, Record, Term, Variable
from cspcheck.cspm.values.failure import Failure


class Replayed(Enum):
    """What the evaluator says of a predicate."""

    HOLDS = "holds"
    FAILS = "fails"
    UNDECIDED = "undecided"


class PredicateReplay:
    """Evaluates predicates at given values.

    Args:
        specification, model: where the predicates come from.
        sizes: the number of elements of each given set.
        values: ground terms by variable.
    """

    def __init__(
        self,
        specification: core.Specification,
        model: core.ClassModel | None,
        sizes: Mapping[str, int],
        values: Mapping[Variable, Term],
    ) -> None:
        from cspcheck.cspm.oz.values.evaluation import TermEvaluator

        # The script's own finite readings would make the predicates say something else.
        readings = tuple(given_reading(name, size) for name, size in sizes.items())
        self._evaluator = TermEvaluator(replace(specification, readings=readings), model)
        self._computed = frozenset(self._evaluator.recursions)
        self._assignment: dict[Any, Any] = {}
        self._unreadable = False
        for variable, value in values.items():
            if variable.role == "constant" and variable.name in self._computed:
                continue
            try:
                self._assignment[_slot(variable)] = self._value(value)
            except (ValueError, Failure):
                self._unreadable = True

    def holds(self, predicate: Term) -> Replayed:
        """Whether a predicate is defined and true at the values."""
        from cspcheck.cspm.oz.values.evaluation import TooLarge, Unbounded, Undefined

        if self._unreadable:
            return Replayed.UNDECIDED
        free = constant_free(predicate, self._computed)
        try:
            return Replayed.HOLDS if self._evaluator.holds(free, self._assignment) else Replayed.FAILS
        except Undefined:
            return Replayed.FAILS
        except (Unbounded, TooLarge, Failure, KeyError):
            return Replayed.UNDECIDED

    def _value(self, ground: Term) -> Any:
        """The value of a ground term.

        Raises:
            ValueError: it has none that the evaluator knows: an infinite set or function.
        """
        from cspcheck.cspm.oz.values.values import Construction, Element, Graph

        match ground:
            case Constant(type=core.RealType(), value=value):
                return Fraction(value)
            case Constant(value=value):
                return value
            case Variable(type=core.GivenType(name=name)):
                return Element(name, int(ground.name.rsplit("_", 1)[1]))
            case Construct(type=core.FreeType(name=name)):
                rank = self._evaluator.rank(name, ground.constructor)
                argument = None if ground.argument is None else self._value(ground.argument)
                return Construction(rank, ground.constructor, argument)
            case Record(values=values):
                return tuple(map(self._value, values))
            case Apply(operator="tuple" | "sequence", operands=operands):
                return tuple(map(self._value, operands))
            case Apply(operator="set", operands=operands):
                return frozenset(map(self._value, operands))
            case Apply(operator="function", operands=operands):
                return Graph([self._value(pair) for pair in operands])
            case Apply(operator="bag_display", operands=operands):
                counts: dict[Any, int] = {}
                for value in map(self._value, operands):
                    counts[value] = counts.get(value, 0) + 1
                return Graph(counts)
        raise ValueError(ground)


def given_reading(name: str, size: int) -> core.FiniteReading:
    """A given set of so many elements."""
    from cspcheck.cspm.source import Source

    subject = universe(core.GivenType(name))
    return core.FiniteReading(
        subject=subject, text=name, values=None, bound=max(size, 1), span=Source("", "").span(0, 0), whole=True
    )


def constant_free(term: Term, computed: Collection[str] = ()) -> Term:
    """The term with ordinary variables for constants, of which the evaluator would look for values of its own.

    Those that are *computed* stay what they are.
    """

    def freed(variable: Variable) -> Variable | None:
        if not _is_constant(variable) or variable.name in computed:
            return None
        return Variable(type=variable.type, name=f"{variable.name}%c", role="bound")

    (free,) = renamed([term], freed)
    return free


def _is_constant(variable: Variable) -> bool:
    return variable.role == "constant"


def _slot(variable: Variable) -> Key:
    return (f"{variable.name}%c", "bound") if _is_constant(variable) else (variable.name, variable.role)
