"""Which types satisfy which constraints, and what must hold of their parts for it.

==========  ==========================================================================================
Eq          integers, Booleans, characters, events, datatypes all of whose fields have it, and collections,
            tuples, maps and dots of these; not processes, not functions
Ord         integers, characters, sequences and sets of Eq, tuples and maps of Ord
Set         whatever has Eq, processes, and datatypes of any kind
Complete    everything but functions and what still wants fields
Yieldable   events and datatypes
==========  ==========================================================================================
"""

from __future__ import annotations

from typing import Protocol

from cspcheck.cspm.typing.types import (
    BOOL,
    CHAR,
    COMPLETE,
    EQ,
    EVENT,
    INT,
    NOTHING,
    ORD,
    PROC,
    REAL,
    SET,
    YIELDABLE,
    Atom,
    Constraints,
    Datatype,
    Dot,
    Dotable,
    Extendable,
    Function,
    MapOf,
    Rigid,
    SequenceOf,
    SetOf,
    TupleOf,
    Type,
    Variable,
    components,
    implied,
    parts,
    resolve,
    subtypes,
)


class Unsatisfied(Exception):
    """*type* lacks *constraint*; ``trail`` has the types around it for which it was needed, inside out."""

    def __init__(self, constraint: Constraints, type_: Type) -> None:
        super().__init__(constraint)
        self.constraint = constraint
        self.type = type_
        self.trail: list[tuple[Constraints, Type]] = []


class ConstraintSolver(Protocol):
    """What satisfying a constraint needs of unification."""

    undecided: list[Datatype]

    def save(self, variable: Variable) -> None:
        """Log a variable that is about to change."""

    def step(self) -> None:
        """Count some work."""

    def settle(self, type_: Type) -> Type:
        """Read the dots of a type by the longest match."""

    def close(self, open_end: Extendable, row: Type) -> None:
        """Bind the open row of an extendable."""


def constrain(solver: ConstraintSolver, constraints: Constraints, type_: Type) -> None:
    """Make *type_* satisfy all of *constraints*.

    Raises:
        Unsatisfied: it cannot.
    """
    for single in (EQ, ORD, SET, COMPLETE, YIELDABLE):
        if constraints & single:
            _constrain(solver, single, type_)


def _constrain(solver: ConstraintSolver, single: Constraints, type_: Type) -> None:
    solver.step()
    head = resolve(type_)
    if type(head) is Variable:
        if not implied(head.constraints) & single:
            solver.save(head)
            head.constraints |= single
        return
    try:
        _constrain_known(solver, single, head)
    except Unsatisfied as failure:
        if failure.type is not head:
            failure.trail.append((single, head))
        raise


def _constrain_known(solver: ConstraintSolver, single: Constraints, head: Type) -> None:
    """Check, or make hold, one constraint on a type that is not a variable."""
    match head:
        case Rigid():
            holds = bool(implied(head.constraints) & single)
        case Atom():
            if head in (INT, CHAR):
                holds = single is not YIELDABLE
            elif head is BOOL or head is REAL:
                holds = single in (EQ, SET, COMPLETE)
            elif head is EVENT:
                holds = single is not ORD
            else:
                holds = head is PROC and single in (SET, COMPLETE)
        case Datatype():
            if single is EQ and head.comparable is None:
                solver.undecided.append(head)
            holds = head.comparable is not False if single is EQ else single is not ORD
        case SetOf() | SequenceOf():
            if single in (EQ, SET):
                _constrain(solver, single, head.element)
            elif single is ORD:
                _constrain(solver, EQ, head.element)
            holds = single is not YIELDABLE
        case TupleOf() | MapOf():
            if single in (EQ, SET, ORD):
                for part in components(head):
                    _constrain(solver, single, part)
            holds = single is not YIELDABLE
        case Dot():
            # Only completeness depends on how the dot is read, so nothing else forces the longest match.
            whole = solver.settle(head) if single in (COMPLETE, YIELDABLE) else head
            if type(whole) is not Dot:
                _constrain(solver, single, whole)
                return
            holds = single in (EQ, SET, COMPLETE)
            if holds:
                for part in parts(whole):
                    _constrain(solver, single, part)
        case Dotable():
            holds = single in (EQ, SET)
            if holds:
                _constrain(solver, single, head.argument)
                _constrain(solver, single, head.result)
        case Extendable():
            holds = single is not ORD
            if holds:
                _constrain(solver, single, head.result)
            if single in (COMPLETE, YIELDABLE):
                solver.close(head, NOTHING)
        case _:
            holds = False
    if not holds:
        raise Unsatisfied(single, head)


def lacks_equality(type_: Type) -> Type | None:
    """The first part of *type_* that has no equality (a process, a function, a datatype with one), or None.

    Looks only; datatypes whose own answer is not known yet count as comparable.
    """
    for part in subtypes(type_):
        if part is PROC or type(part) is Function or (type(part) is Datatype and part.comparable is False):
            return part
    return None
