"""What all nodes of the syntax tree are; patterns and types, which every kind of declaration needs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from cspcheck.cspm.source import Span


@dataclass(frozen=True, kw_only=True)
class Node:
    """Anything with a place in a source."""

    span: Span = field(compare=False, repr=False)


class Expr(Node):
    """An expression; processes are expressions."""


class Pattern(Node):
    """What stands left of ``=``, in parameters, generators and input fields."""


class Statement(Node):
    """A generator or a qualifier of a comprehension or a replicated operator."""


class Declaration(Node):
    """A declaration of a script, a module or a ``let``."""


class TypeExpr(Node):
    """A type as written in an annotation."""


# --- patterns ------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class NamePattern(Pattern):
    """``x``: a variable, or itself where the name is a channel or constructor in scope."""

    parts: tuple[str, ...]

    @property
    def text(self) -> str:
        """The name as written."""
        return "::".join(self.parts)


@dataclass(frozen=True, kw_only=True)
class Wildcard(Pattern):
    """``_``."""


@dataclass(frozen=True, kw_only=True)
class LiteralPattern(Pattern):
    """``7``, ``-7``, ``true``, ``'c'``, ``"text"``."""

    kind: Literal["int", "bool", "char", "string"]
    value: int | bool | str


@dataclass(frozen=True, kw_only=True)
class ParenPattern(Pattern):
    """``(p)``."""

    inner: Pattern


@dataclass(frozen=True, kw_only=True)
class TuplePattern(Pattern):
    """``(p, q)``."""

    items: tuple[Pattern, ...]


@dataclass(frozen=True, kw_only=True)
class SequencePattern(Pattern):
    """``<p, q>``, ``<>``."""

    items: tuple[Pattern, ...]


@dataclass(frozen=True, kw_only=True)
class ConcatPattern(Pattern):
    """``p ^ q``."""

    left: Pattern
    right: Pattern


@dataclass(frozen=True, kw_only=True)
class SetPattern(Pattern):
    """``{}``, ``{p}``."""

    items: tuple[Pattern, ...]


@dataclass(frozen=True, kw_only=True)
class DotPattern(Pattern):
    """``p.q``, right associative."""

    left: Pattern
    right: Pattern


@dataclass(frozen=True, kw_only=True)
class BothPattern(Pattern):
    """``p @@ q``: both must match."""

    left: Pattern
    right: Pattern


# --- types ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class TypeName(TypeExpr):
    """``Int``, ``Proc``, a datatype's name, or a type variable."""

    parts: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class SetType(TypeExpr):
    """``{a}``."""

    element: TypeExpr


@dataclass(frozen=True, kw_only=True)
class SequenceType(TypeExpr):
    """``<a>``."""

    element: TypeExpr


@dataclass(frozen=True, kw_only=True)
class TupleType(TypeExpr):
    """``(a, b)``."""

    items: tuple[TypeExpr, ...]


@dataclass(frozen=True, kw_only=True)
class MapType(TypeExpr):
    """``(| k => v |)``."""

    key: TypeExpr
    value: TypeExpr


@dataclass(frozen=True, kw_only=True)
class FunctionType(TypeExpr):
    """``(a, b) -> c``."""

    parameters: tuple[TypeExpr, ...]
    result: TypeExpr


@dataclass(frozen=True, kw_only=True)
class DotType(TypeExpr):
    """``a.b``."""

    left: TypeExpr
    right: TypeExpr


@dataclass(frozen=True, kw_only=True)
class DotableType(TypeExpr):
    """``a => b``, or with ``extendable`` the type ``a =>* b``."""

    argument: TypeExpr
    result: TypeExpr
    extendable: bool = False


@dataclass(frozen=True, kw_only=True)
class TypeConstraint(Node):
    """``Eq a`` in front of ``=>``."""

    constraint: str
    variable: str


@dataclass(frozen=True, kw_only=True)
class TypeScheme(Node):
    """``(Eq a, Ord b) => type``."""

    constraints: tuple[TypeConstraint, ...]
    type: TypeExpr
