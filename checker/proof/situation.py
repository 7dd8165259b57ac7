"""What is known where an obligation stands: the constants, the state before and after, the operation."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Literal

from cspcheck.checker.proof.one_point import is_universe
from cspcheck.checker.proof.question import CARRIER, Constraint
from cspcheck.checker.proof.terms import (
    TRUE,
    Key,
    Unknown,
    all_of,
    bound_by,
    equal,
    member,
    mentions,
    primed,
    quantified,
    renamed,
    substitute,
    variables_of,
)
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Declared, Operation, Parameter, Role, Term, Variable

When = Literal["before", "after"]


class Situation:
    """A class of a specification, with the predicates that its obligations are made of."""

    def __init__(self, specification: core.Specification, model: core.ClassModel) -> None:
        self.specification = specification
        self.model = model
        self.constants = (*specification.constants, *model.constants)
        self.axioms = (*specification.axioms, *model.axioms)

    # --- constants ---------------------------------------------------------------------------------------------------

    def all_constants(self) -> tuple[Constraint, ...]:
        """That all constants have values that the axioms allow."""
        carriers = [_carrier_part(_constant(c), c) for c in self.constants]
        return (*carriers, *[Constraint(axiom, "axiom", axiom.span) for axiom in self.axioms])

    def with_constants(self, parts: Iterable[Constraint]) -> tuple[Constraint, ...]:
        """The parts behind what is known of the constants that they speak of, directly or by way of axioms."""
        parts = tuple(parts)
        used = {k for k in variables_of(p.term for p in parts) if k[1] == "constant"}
        known = self.all_constants()
        about = [{k for k in variables_of([p.term]) if k[1] == "constant"} for p in known]
        while True:
            more = {k for keys in about if keys & used for k in keys} - used
            if not more:
                break
            used |= more
        kept = [part for part, keys in zip(known, about, strict=True) if keys & used]
        return (*kept, *parts)

    def constant_variables(self, parts: Iterable[Constraint]) -> tuple[Variable, ...]:
        """The constants that parts speak of, in the order of their declaration."""
        used = variables_of(p.term for p in parts)
        return tuple(_constant(c) for c in self.constants if (c.name, "constant") in used)

    # --- states ------------------------------------------------------------------------------------------------------

    @property
    def variables(self) -> tuple[Declared, ...]:
        """The state variables, primary ones first."""
        return (*self.model.primary, *self.model.secondary)

    @property
    def secondary_keys(self) -> frozenset[str]:
        """Names of the secondary variables."""
        return frozenset(d.name for d in self.model.secondary)

    def state(self, when: When = "before") -> tuple[Constraint, ...]:
        """That a state is one of the class: carriers and invariant."""
        return (*self.carriers(when), *self.invariant(when))

    def carriers(self, when: When = "before", of: Iterable[Declared] | None = None) -> tuple[Constraint, ...]:
        """That state variables are in their carriers."""
        declared = self.variables if of is None else tuple(of)
        parts = [_carrier_part(state_variable(d, "before"), d) for d in declared]
        return _at(parts, when)

    def invariant(self, when: When = "before") -> tuple[Constraint, ...]:
        """The conjuncts of the invariant."""
        return _at([Constraint(term, "invariant", term.span) for term in self.model.invariant], when)

    def initial(self) -> tuple[Constraint, ...]:
        """The conjuncts of INIT."""
        return tuple(Constraint(term, "INIT", term.span) for term in self.model.initial or ())

    def state_variables(self, when: When = "before") -> tuple[Variable, ...]:
        """The variables of a state."""
        return tuple(state_variable(d, when) for d in self.variables)

    # --- operations --------------------------------------------------------------------------------------------------

    def inputs(self, operation: Operation) -> tuple[Constraint, ...]:
        """That inputs and simple parameters are in their carriers."""
        return tuple(_carrier_part(parameter_variable(p), p) for p in operation.parameters if p.kind != "output")

    def outputs(self, operation: Operation) -> tuple[Constraint, ...]:
        """That outputs are in their carriers."""
        return tuple(_carrier_part(parameter_variable(p), p) for p in operation.parameters if p.kind == "output")

    def guard(self, operation: Operation) -> tuple[Constraint, ...]:
        """The conjuncts of the enable schema."""
        return tuple(Constraint(term, "guard", term.span) for term in operation.guard)

    def effect(self, operation: Operation) -> tuple[Constraint, ...]:
        """The conjuncts of the schema, or of the effect schema."""
        return tuple(Constraint(term, "effect", term.span) for term in operation.effect)

    def frame(self, operation: Operation) -> tuple[Constraint, ...]:
        """That primary variables outside the Delta-list keep their values."""
        return tuple(
            Constraint(equal(state_variable(d, "after"), state_variable(d, "before")), f"`{d.name}` not in Delta")
            for d in self.model.primary
            if d.name not in operation.delta
        )

    def step(self, operation: Operation) -> tuple[Constraint, ...]:
        """That the operation is performed: all of the above, from a state of the class to one of the class."""
        return (
            *self.state(),
            *self.inputs(operation),
            *self.guard(operation),
            *self.effect(operation),
            *self.frame(operation),
            *self.outputs(operation),
            *self.state("after"),
        )

    def shown(self, operation: Operation | None = None, *, after: bool = True) -> tuple[Variable, ...]:
        """The variables of a counterexample: before, inputs, outputs, after."""
        found = list(self.state_variables())
        if operation is not None:
            kinds = ("simple", "input", "output") if after else ("simple", "input")
            found += [parameter_variable(p) for kind in kinds for p in operation.parameters if p.kind == kind]
            found += self.state_variables("after") if after else ()
        return tuple(found)

    def possible(self, operation: Operation, *, outputs: bool = True, guard: bool = False) -> Term:
        """That some after-state and outputs satisfy the effect and the class: ``pre`` of the effect.

        Args:
            operation: the operation.
            outputs: quantify over the outputs as well.
            guard: let the guard be a conjunct.
        """
        unknowns, parts = self.existential(operation, outputs=outputs)
        if guard:
            parts = (*self.guard(operation), *parts)
        binders, table = bound_by(unknowns)
        return quantified("exists", binders, TRUE, all_of(substitute(p.term, table) for p in parts))

    def existential(
        self, operation: Operation, *, outputs: bool = True
    ) -> tuple[tuple[Unknown, ...], tuple[Constraint, ...]]:
        """What :meth:`possible` quantifies over, and what it says; unchanged variables are written as before."""
        same = self.unchanged(operation)
        parts = [*self.effect(operation), *self.invariant("after")]
        unknowns = [
            Unknown(state_variable(d, "after"), substitute(primed([d.carrier])[0], same))
            for d in self.variables
            if (d.name, "after") not in same
        ]
        if outputs:
            unknowns += [Unknown(parameter_variable(p), p.carrier) for p in operation.parameters if p.kind == "output"]
        return tuple(unknowns), tuple(replace(part, term=substitute(part.term, same)) for part in parts)

    def unchanged(self, operation: Operation) -> dict[Key, Term]:
        """After-values of the primary variables outside the Delta-list."""
        return {
            (d.name, "after"): state_variable(d, "before") for d in self.model.primary if d.name not in operation.delta
        }

    def enabled(self, operation: Operation) -> Term:
        """When the operation is available, over before, input and simple variables."""
        match operation.form:
            case "com":
                return self.possible(operation)
            case _:
                return all_of(operation.guard)


def second(terms: Iterable[Term], mark: str = "second") -> tuple[Term, ...]:
    """The terms with other variables for after-values and outputs: a second outcome."""
    return renamed(terms, lambda v: replace(v, name=f"{v.name}%{mark}") if v.role in ("after", "output") else None)


def state_variable(declared: Declared, when: When) -> Variable:
    """A state variable before or after."""
    return Variable(type=declared.type, name=declared.name, role=when)


def parameter_variable(parameter: Parameter) -> Variable:
    """A parameter as the operation's predicates name it."""
    role: Role = parameter.kind
    return Variable(type=parameter.type, name=parameter.name, role=role)


def _constant(declared: Declared) -> Variable:
    return Variable(type=declared.type, name=declared.name, role="constant")


def _carrier_part(variable: Variable, declared: Declared) -> Constraint:
    if is_universe(declared.carrier):
        return Constraint(TRUE, f"{CARRIER}`{declared.name}`", declared.span)
    return Constraint(member(variable, declared.carrier), f"{CARRIER}`{declared.name}`", declared.span)


def _at(parts: Iterable[Constraint], when: When) -> tuple[Constraint, ...]:
    parts = tuple(parts)
    if when == "before":
        return parts
    terms = primed(part.term for part in parts)
    return tuple(replace(p, term=t, what=f"{p.what} afterwards") for p, t in zip(parts, terms, strict=True))


def speaks_of(part: Constraint, keys: Iterable[Key]) -> bool:
    """Whether a part speaks of one of some variables."""
    return mentions(part.term, keys)
