# ruff: noqa: D102 - an action is documented by the alternative of the grammar that it is named in
"""Types as written in annotations: the part of the tree builder for what stands behind ``::``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.parsing import messages as messages
from cspcheck.cspm.parsing.lexer import Tokens
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as s

CONSTRAINTS: Final = ("Eq", "Ord", "Set", "Complete", "Yieldable")


@dataclass(frozen=True, kw_only=True)
class TypeGroup(s.TypeExpr):
    """``(a, b)`` while it is not known whether it is a tuple or an argument list. Never part of a finished tree."""

    items: tuple[s.TypeExpr, ...]


class TypeActions:
    """The actions for types."""

    tokens: Tokens
    errors: list[Diagnostic]
    _refuse: Callable[[Diagnostic], None]

    def _type(self, written: s.TypeExpr) -> s.TypeExpr:
        if not isinstance(written, TypeGroup):
            return written
        if not written.items:
            self.errors.append(messages.empty_type(written.span))
            return s.TupleType(span=written.span, items=())
        return written.items[0] if len(written.items) == 1 else s.TupleType(span=written.span, items=written.items)

    def type_scheme(self, span: Span, body: s.TypeExpr) -> s.TypeScheme:
        return s.TypeScheme(span=span, constraints=(), type=self._type(body))

    def constrained_type_scheme(
        self, span: Span, constraints: s.TypeConstraint | list[s.TypeConstraint], body: s.TypeExpr
    ) -> s.TypeScheme:
        if isinstance(constraints, s.TypeConstraint):
            constraints = [constraints]
        return s.TypeScheme(span=span, constraints=tuple(constraints), type=self._type(body))

    def constraint(self, span: Span, constraint: int, variable: int) -> s.TypeConstraint:
        word = self.tokens.text(constraint)
        if word not in CONSTRAINTS:
            self.errors.append(messages.unknown_constraint(self.tokens.span(constraint), CONSTRAINTS))
        return s.TypeConstraint(span=span, constraint=word, variable=self.tokens.text(variable))

    def function_type(self, span: Span, parameters: s.TypeExpr, result: s.TypeExpr) -> s.FunctionType:
        if isinstance(parameters, TypeGroup):
            items = parameters.items
        else:
            self.errors.append(messages.function_type_without_list(parameters.span))
            items = (parameters,)
        return s.FunctionType(span=span, parameters=items, result=self._type(result))

    def dotable_type(self, span: Span, argument: s.TypeExpr, result: s.TypeExpr) -> s.DotableType:
        return s.DotableType(span=span, argument=self._type(argument), result=self._type(result))

    def extendable_type(self, span: Span, argument: s.TypeExpr, result: s.TypeExpr) -> s.DotableType:
        return s.DotableType(span=span, argument=self._type(argument), result=self._type(result), extendable=True)

    def dot_type(self, span: Span, left: s.TypeExpr, right: s.TypeExpr) -> s.DotType:
        return s.DotType(span=span, left=self._type(left), right=self._type(right))

    def type_name(self, span: Span, name: s.Name) -> s.TypeName:
        return s.TypeName(span=span, parts=name.parts)

    def no_types(self, span: Span) -> TypeGroup:
        return TypeGroup(span=span, items=())

    def types(self, span: Span, items: list[s.TypeExpr]) -> TypeGroup:
        return TypeGroup(span=span, items=tuple(self._type(item) for item in items))

    def set_type(self, span: Span, element: s.TypeExpr) -> s.SetType:
        return s.SetType(span=span, element=self._type(element))

    def sequence_type(self, span: Span, opening: int, element: s.TypeExpr, closing: int) -> s.SequenceType:
        return s.SequenceType(span=span, element=self._type(element))

    def map_type(self, span: Span, key: s.TypeExpr, value: s.TypeExpr) -> s.MapType:
        return s.MapType(span=span, key=self._type(key), value=self._type(value))
