"""Dots between expressions: events and datatype values, looked up whole where their parts are simple."""

from __future__ import annotations

from typing import Any

from cspcheck.cspm.evaluator.core import VALUES, Evaluator
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.naming.symbols import SymbolKind
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values.dots import Dotted, Event, dot
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.thunks import Code, Env
from cspcheck.cspm.values.values import Boolean


def dot_parts(node: syntax.Expr) -> list[syntax.Expr]:
    """The expressions that dots join in *node*, left to right, brackets looked through."""
    found: list[syntax.Expr] = []
    stack = [node]
    while stack:
        current = syntax.bare(stack.pop())
        if isinstance(current, syntax.Dot):
            stack += (current.right, current.left)
        else:
            found.append(current)
    return found


SIMPLE = frozenset({int, str, Boolean, Event})
"""Kinds of values that are one field whatever stands around them, and cheap to look up."""


def with_fields(evaluator: Evaluator, parts: list[syntax.Expr], frame: Frame, span: Span) -> Code | None:
    """Code for a channel or constructor with fields, by looking up the complete value.

    None if the first of *parts* is no name of a channel or constructor.
    """
    name = parts[0]
    if len(parts) < 2 or not isinstance(name, syntax.Name):
        return None
    symbol = evaluator.names.symbol(name)
    if symbol.kind not in (SymbolKind.CHANNEL, SymbolKind.CONSTRUCTOR):
        return None
    head = frame.unit.head(symbol)
    codes = [evaluator.value(part, frame) for part in parts[1:]]
    known = head.known

    def build(fields: Env) -> Any:
        joined = fields[-1]
        try:
            for field in reversed(fields[:-1]):
                joined = dot(field, joined)
            return dot(head.value, joined)
        except Failure as failure:
            failure.at(span)
            raise

    if len(codes) == 1:
        (only,) = codes

        def one(env: Env) -> Any:
            fields = (only(env),)
            if type(fields[0]) in SIMPLE:
                return known.get(fields) or build(fields)
            return build(fields)

        return one

    def several(env: Env) -> Any:
        fields = tuple([code(env) for code in codes])
        for field in fields:
            if type(field) not in SIMPLE and not (type(field) is Dotted and field.complete):
                return build(fields)
        return known.get(fields) or build(fields)

    return several


@VALUES(syntax.Dot)
def _dot(evaluator: Evaluator, node: syntax.Dot, frame: Frame) -> Code:
    return with_fields(evaluator, dot_parts(node), frame, node.span) or _dot_in_general(evaluator, node, frame)


def _dot_in_general(evaluator: Evaluator, node: syntax.Dot, frame: Frame) -> Code:
    left = evaluator.value(node.left, frame)
    right = evaluator.value(node.right, frame)
    span = node.span

    def join(env: Env) -> Any:
        a = left(env)
        b = right(env)
        try:
            return dot(a, b)
        except Failure as failure:
            failure.at(span)
            raise

    return join
