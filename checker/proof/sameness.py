"""Whether two versions of the classes of a script mean the same, proved for all values.

The versions have the same parts; what may differ is what the predicates say. Each that does is held against the other:
an invariant in the carriers, INIT and the operations in the states of the class. Then a state is one of the one version
where it is one of the other, and the same steps lead from it, so that processes, objects and refinements of the classes
are the same.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from cspcheck.checker.proof.prover import Prover
from cspcheck.checker.proof.question import Constraint, Impossible, SolverSettings
from cspcheck.checker.proof.terms import all_of
from cspcheck.cspm.oz.core import ClassModel, Operation, Specification, Term


def mean_the_same(first: Specification, second: Specification, settings: SolverSettings | None = None) -> bool:
    """Whether it is proved that all classes of two versions mean the same; False where it is not known.

    Args:
        first, second: the versions.
        settings: how hard to try.
    """
    if replace(second, classes=first.classes) != first or first.classes.keys() != second.classes.keys():
        return False
    return all(
        one == second.classes[name] or _same(first, one, second.classes[name], settings)
        for name, one in first.classes.items()
    )


def _same(specification: Specification, one: ClassModel, other: ClassModel, settings: SolverSettings | None) -> bool:
    operations = {name: _filled(operation, one.operations.get(name)) for name, operation in other.operations.items()}
    if replace(other, invariant=one.invariant, initial=one.initial, operations=operations) != one:
        return False
    prover = Prover(specification, one, settings)
    situation = prover.situation
    if (one.initial is None) != (other.initial is None):
        return False
    return (
        _alike(prover, situation.carriers(), one.invariant, other.invariant)
        and _alike(prover, situation.state(), one.initial or (), other.initial or ())
        and all(_same_steps(prover, operation, other.operations[name]) for name, operation in one.operations.items())
    )


def _filled(operation: Operation, other: Operation | None) -> Operation:
    """An operation with the predicates of another version of it."""
    return operation if other is None else replace(operation, guard=other.guard, effect=other.effect)


def _same_steps(prover: Prover, operation: Operation, other: Operation) -> bool:
    situation = prover.situation
    known = (*situation.state(), *situation.inputs(operation))
    if not _alike(prover, known, operation.guard, other.guard):
        return False
    around = (*situation.guard(operation), *situation.frame(operation), *situation.outputs(operation))
    return _alike(prover, (*known, *around, *situation.state("after")), operation.effect, other.effect)


def _alike(prover: Prover, known: Sequence[Constraint], one: Iterable[Term], other: Iterable[Term]) -> bool:
    """Whether conjuncts are both true, or both not, wherever something is known."""
    one, other = tuple(one), tuple(other)
    if one == other:
        return True
    return all(
        isinstance(prover.refutes([*known, *_claimed(premises)], all_of(goals)), Impossible)
        for premises, goals in ((one, other), (other, one))
    )


def _claimed(terms: Iterable[Term]) -> tuple[Constraint, ...]:
    return tuple(Constraint(term, "claim", term.span) for term in terms)
