"""Patterns: read as expressions, converted here once what follows has shown that they are patterns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.parsing import messages as messages
from cspcheck.cspm.syntax import tree as s

_REPORTED: Final = -(10**9)
"""So few open ends has a pattern with too many of them, once that is said: however it goes on, it is said once."""


@dataclass(frozen=True, kw_only=True)
class WildcardExpr(s.Expr):
    """``_`` while it is not known that it stands in a pattern. Never part of a finished tree."""


@dataclass(frozen=True, kw_only=True)
class BothExpr(s.Expr):
    """``p @@ q`` while it is not known that it stands in a pattern. Never part of a finished tree."""

    left: s.Expr
    right: s.Expr


def to_pattern(
    expression: s.Expr, *, converted: Callable[[s.Expr], None], refuse: Callable[[Diagnostic], None]
) -> s.Pattern:
    """The pattern that *expression* is written like.

    *converted* is told of each ``_`` and ``@@`` that found its place, *refuse* of what is no pattern (a wildcard
    takes its place, so that more mistakes can be found).
    """
    # Postorder on explicit stacks: patterns can be as deep as memory allows.
    done: list[s.Pattern] = []
    lengths: dict[tuple[int, int], int] = {}  # of a concatenation's parts, how many can have any length
    work: list[tuple[s.Expr, bool]] = [(expression, False)]
    while work:
        node, ready = work.pop()
        span = node.span
        match node:
            case s.Name(parts=parts):
                done.append(s.NamePattern(span=span, parts=parts))
            case s.LiteralExpr(kind=kind, value=value):
                done.append(s.LiteralPattern(span=span, kind=kind, value=value))
            case s.Unary(operator="-", operand=s.LiteralExpr(kind="int", value=int(value))):
                done.append(s.LiteralPattern(span=span, kind="int", value=-value))
            case WildcardExpr():
                converted(node)
                done.append(s.Wildcard(span=span))
            case s.Paren(inner=inner):
                if ready:
                    done.append(s.ParenPattern(span=span, inner=done.pop()))
                else:
                    work += [(node, True), (inner, False)]
            case s.TupleExpr(items=items) | s.SequenceExpr(items=items, statements=None):
                if ready:
                    parts_done = _take(done, len(items))
                    if isinstance(node, s.TupleExpr):
                        done.append(s.TuplePattern(span=span, items=parts_done))
                    else:
                        done.append(s.SequencePattern(span=span, items=parts_done))
                else:
                    work.append((node, True))
                    work.extend((item, False) for item in reversed(items))
            case s.SetExpr(items=items, statements=None):
                if len(items) > 1 and not ready:
                    refuse(messages.set_pattern(span))
                if ready:
                    done.append(s.SetPattern(span=span, items=_take(done, len(items))))
                else:
                    work.append((node, True))
                    work.extend((item, False) for item in reversed(items))
            case (
                s.Binary(operator="^", left=left, right=right)
                | s.Dot(left=left, right=right)
                | BothExpr(left=left, right=right)
            ):
                if not ready:
                    work += [(node, True), (right, False), (left, False)]
                    continue
                first, second = _take(done, 2)
                match node:
                    case s.Binary():
                        flexible = _flexible(first, lengths) + _flexible(second, lengths)
                        if flexible > 1:
                            refuse(messages.sequence_pattern(span))
                            flexible = _REPORTED
                        lengths[span.start, span.end] = flexible
                        done.append(s.ConcatPattern(span=span, left=first, right=second))
                    case s.Dot():
                        done.append(s.DotPattern(span=span, left=first, right=second))
                    case _:
                        converted(node)
                        done.append(s.BothPattern(span=span, left=first, right=second))
            case _:
                refuse(messages.invalid_pattern(span, node))
                done.append(s.Wildcard(span=span))
    return done.pop()


def _flexible(pattern: s.Pattern, lengths: dict[tuple[int, int], int]) -> int:
    """How many parts of *pattern*, as a part of a concatenation, match sequences of any length."""
    while isinstance(pattern, s.ParenPattern):
        pattern = pattern.inner
    if isinstance(pattern, s.ConcatPattern):
        return lengths[pattern.span.start, pattern.span.end]
    return 0 if isinstance(pattern, s.SequencePattern | s.LiteralPattern) else 1


def _take(done: list[s.Pattern], count: int) -> tuple[s.Pattern, ...]:
    taken = tuple(done[len(done) - count :])
    del done[len(done) - count :]
    return taken


def names_in(pattern: s.Pattern) -> list[s.NamePattern]:
    """The names of a pattern, from left to right."""
    found = []
    work = [pattern]
    while work:
        match work.pop():
            case s.NamePattern() as name:
                found.append(name)
            case s.ParenPattern(inner=inner):
                work.append(inner)
            case s.TuplePattern(items=items) | s.SequencePattern(items=items) | s.SetPattern(items=items):
                work.extend(reversed(items))
            case (
                s.ConcatPattern(left=left, right=right)
                | s.DotPattern(left=left, right=right)
                | s.BothPattern(left=left, right=right)
            ):
                work += [right, left]
    return found
