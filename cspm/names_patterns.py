"""What can be said of a pattern without types: its names, and whether it can be matched at all."""

from __future__ import annotations

from collections.abc import Iterator

from cspm import syntax
from cspm.diagnostics import Diagnostic
from cspm.messages import names as messages


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


def fixed_length(pattern: syntax.Pattern) -> int | None:
    """How long the sequences are that a sequence pattern matches; None if it does not say."""
    match pattern:
        case syntax.ParenPattern():
            return fixed_length(pattern.inner)
        case syntax.SequencePattern():
            return len(pattern.items)
        case syntax.LiteralPattern(kind="string"):
            return len(str(pattern.value))
        case syntax.ConcatPattern():
            left, right = fixed_length(pattern.left), fixed_length(pattern.right)
            return None if left is None or right is None else left + right
        case syntax.BothPattern():
            left = fixed_length(pattern.left)
            return fixed_length(pattern.right) if left is None else left
    return None


def check_pattern(pattern: syntax.Pattern, *, in_prefix: bool = False) -> Iterator[Diagnostic]:
    """What is wrong with a pattern whatever its type."""
    stack = [pattern]
    while stack:
        node = stack.pop()
        stack.extend(reversed(parts(node)))
        match node:
            case syntax.SetPattern() if len(node.items) > 1:
                yield messages.impossible_pattern(
                    "a set pattern can have one element at most",
                    node.span,
                    "sets have no order; match the whole set and use `member`, `diff` or `seq`",
                )
            case syntax.ConcatPattern() if fixed_length(node.left) is None and fixed_length(node.right) is None:
                yield messages.impossible_pattern(
                    "a sequence pattern can have one part of unknown length at most",
                    node.span,
                    "match a fixed number of elements on one side: `<x>^xs` or `xs^<x>`",
                )
            case syntax.BothPattern() if in_prefix:
                yield messages.impossible_pattern(
                    "`@@` cannot be used in the fields of a prefix",
                    node.span,
                    "bind the whole field and take it apart with a `let` or a function",
                )
