"""The register of how operators are put as formulas: filled by the modules for sets, functions and sequences."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias, TypeVar

from cspcheck.checker.proof.sorts import Expr
from cspcheck.cspm.oz.core import Apply

if TYPE_CHECKING:
    from cspcheck.checker.proof.encode import Encoder

Value: TypeAlias = "Callable[[Encoder, Apply], Expr]"
Membership: TypeAlias = "Callable[[Encoder, Expr, Apply], Expr]"
Candidates: TypeAlias = "Callable[[Encoder, Apply], list[Expr] | None]"
F = TypeVar("F")

LARGEST_EXPANSION = 64
"""Quantifiers over more combinations of values than this are left to the solver."""

VALUES: dict[str, Value] = {}
"""The value of an operator's application."""

MEMBERSHIPS: dict[str, Membership] = {}
"""Whether a value is in the set that an operator gives."""

CANDIDATES: dict[str, Candidates] = {}
"""Values among which all elements of the set that an operator gives are; None where no such list is known."""


def value(*operators: str) -> Callable[[Value], Value]:
    """Register the rule for the value of operators."""
    return lambda rule: _register(VALUES, operators, rule)


def membership(*operators: str) -> Callable[[Membership], Membership]:
    """Register the rule for membership in what operators give."""
    return lambda rule: _register(MEMBERSHIPS, operators, rule)


def candidates(*operators: str) -> Callable[[Candidates], Candidates]:
    """Register the rule for the candidates of what operators give."""
    return lambda rule: _register(CANDIDATES, operators, rule)


def _register(table: dict[str, F], operators: tuple[str, ...], rule: F) -> F:
    for operator in operators:
        if operator in table:
            raise ValueError(f"two rules for {operator}")
        table[operator] = rule
    return rule
