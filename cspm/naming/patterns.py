"""What can be said of a pattern from its form alone."""

from __future__ import annotations

from collections.abc import Iterator

from cspcheck.cspm.syntax import tree as syntax


def parts(pattern: syntax.Pattern) -> tuple[syntax.Pattern, ...]:
    """The patterns directly inside *pattern*."""
    match pattern:
        case syntax.ParenPattern():
            return (pattern.inner,)
        case syntax.TuplePattern() | syntax.SequencePattern() | syntax.SetPattern():
            return pattern.items
        case syntax.ConcatPattern() | syntax.DotPattern() | syntax.BothPattern():
            return (pattern.left, pattern.right)
    return ()


def variables(pattern: syntax.Pattern) -> Iterator[syntax.NamePattern]:
    """The names in a pattern, left to right; which of them are variables depends on the scope."""
    stack = [pattern]
    while stack:
        node = stack.pop()
        if isinstance(node, syntax.NamePattern):
            yield node
        stack.extend(reversed(parts(node)))


def doubles(pattern: syntax.Pattern) -> Iterator[syntax.BothPattern]:
    """The patterns ``p @@ q`` in a pattern."""
    stack = [pattern]
    while stack:
        node = stack.pop()
        if isinstance(node, syntax.BothPattern):
            yield node
        stack.extend(parts(node))
