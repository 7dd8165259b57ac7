"""Patterns become matchers: functions that extend the environment by the variables bound, or give None."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.naming.symbols import SymbolKind
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values.comparison import equal
from cspcheck.cspm.values.dots import DotList, Dotted, Event, Head
from cspcheck.cspm.values.sets import Set
from cspcheck.cspm.values.thunks import Env, Thunk, force
from cspcheck.cspm.values.values import FALSE, TRUE, Sequence, string

if TYPE_CHECKING:
    from cspcheck.cspm.evaluator.core import Evaluator

Matcher: TypeAlias = Callable[[Env, Any], Env | None]
"""From the environment and a value (or thunk) to the environment with the variables, or None if it does not match."""


def compile_pattern(
    evaluator: Evaluator, pattern: syntax.Pattern, frame: Frame, *, evaluated: bool
) -> tuple[Matcher, Frame]:
    """The matcher of *pattern* and the frame behind it; *evaluated*: it will be given values without thunks inside."""
    match pattern:
        case syntax.ParenPattern():
            return compile_pattern(evaluator, pattern.inner, frame, evaluated=evaluated)
        case syntax.Wildcard():
            return _anything, frame
        case syntax.NamePattern():
            symbol = evaluator.names.symbol(pattern)
            if symbol.kind in (SymbolKind.CHANNEL, SymbolKind.CONSTRUCTOR):
                return _same_head(_head(evaluator, pattern, frame)), frame
            return _variable, frame.with_variables((symbol,), evaluated=evaluated)
        case syntax.LiteralPattern():
            return _literal(pattern), frame
        case syntax.TuplePattern():
            return _tuple(evaluator, pattern, frame, evaluated)
        case syntax.SequencePattern() | syntax.ConcatPattern():
            return _sequence(evaluator, pattern, frame, evaluated)
        case syntax.SetPattern():
            return _set(evaluator, pattern, frame)
        case syntax.DotPattern():
            return _dots(evaluator, pattern, frame)
        case syntax.BothPattern():
            left, frame = compile_pattern(evaluator, pattern.left, frame, evaluated=evaluated)
            right, frame = compile_pattern(evaluator, pattern.right, frame, evaluated=evaluated)

            def both(env: Env, value: Any) -> Env | None:
                found = left(env, value)
                return None if found is None else right(found, value)

            return both, frame
    raise AssertionError(pattern)


def is_variable(evaluator: Evaluator, pattern: syntax.Pattern) -> bool:
    """Whether *pattern* is a plain variable."""
    while isinstance(pattern, syntax.ParenPattern):
        pattern = pattern.inner
    return isinstance(pattern, syntax.NamePattern) and evaluator.names.symbol(pattern).kind not in (
        SymbolKind.CHANNEL,
        SymbolKind.CONSTRUCTOR,
    )


def is_irrefutable(evaluator: Evaluator, pattern: syntax.Pattern) -> bool:
    """Whether *pattern* matches without looking at the value."""
    while isinstance(pattern, syntax.ParenPattern):
        pattern = pattern.inner
    return isinstance(pattern, syntax.Wildcard) or is_variable(evaluator, pattern)


def _anything(env: Env, value: Any) -> Env | None:
    return env


def _variable(env: Env, value: Any) -> Env | None:
    return (*env, value)


def _head(evaluator: Evaluator, pattern: syntax.NamePattern, frame: Frame) -> Callable[[], Head]:
    symbol = evaluator.names.symbol(pattern)
    unit = frame.unit
    return lambda: unit.head(symbol)


def named_head(evaluator: Evaluator, pattern: syntax.Pattern, frame: Frame) -> Callable[[], Head] | None:
    """What finds the channel or constructor that *pattern* is; None if it is any other pattern."""
    while isinstance(pattern, syntax.ParenPattern):
        pattern = pattern.inner
    if isinstance(pattern, syntax.NamePattern) and not is_variable(evaluator, pattern):
        return _head(evaluator, pattern, frame)
    return None


def _same_head(find: Callable[[], Head]) -> Matcher:
    def match(env: Env, value: Any) -> Env | None:
        if type(value) is Thunk:
            value = value.force()
        return env if value == find().value else None

    return match


def _literal(pattern: syntax.LiteralPattern) -> Matcher:
    wanted: Any = pattern.value
    if pattern.kind == "string":
        text = string(str(wanted))

        def match_text(env: Env, value: Any) -> Env | None:
            value = force(value)
            return env if type(value) is Sequence and equal(value, text) else None

        return match_text
    if pattern.kind == "bool":
        wanted = TRUE if wanted else FALSE

        def match_truth(env: Env, value: Any) -> Env | None:
            if type(value) is Thunk:
                value = value.force()
            return env if value is wanted else None

        return match_truth
    kind = type(wanted)

    def match(env: Env, value: Any) -> Env | None:
        if type(value) is Thunk:
            value = value.force()
        return env if type(value) is kind and value == wanted else None

    return match


def _tuple(evaluator: Evaluator, pattern: syntax.TuplePattern, frame: Frame, evaluated: bool) -> tuple[Matcher, Frame]:
    width = len(pattern.items)
    if all(is_variable(evaluator, item) for item in pattern.items):
        frame = _with_all(evaluator, pattern.items, frame, evaluated)

        def match_variables(env: Env, value: Any) -> Env | None:
            if type(value) is Thunk:
                value = value.force()
            return env + value if type(value) is tuple and len(value) == width else None

        return match_variables, frame
    inner, frame = compile_all(evaluator, pattern.items, frame, evaluated=evaluated)

    def match(env: Env, value: Any) -> Env | None:
        if type(value) is Thunk:
            value = value.force()
        return inner(env, value) if type(value) is tuple and len(value) == width else None

    return match, frame


def _with_all(evaluator: Evaluator, items: tuple[syntax.Pattern, ...], frame: Frame, evaluated: bool) -> Frame:
    for item in items:
        _, frame = compile_pattern(evaluator, item, frame, evaluated=evaluated)
    return frame


def compile_all(
    evaluator: Evaluator, patterns: tuple[syntax.Pattern, ...], frame: Frame, *, evaluated: bool
) -> tuple[Callable[[Env, Any], Env | None], Frame]:
    """A matcher of several patterns against as many values (a tuple or list of them)."""
    matchers: list[tuple[int, Matcher]] = []
    for i, item in enumerate(patterns):
        matcher, frame = compile_pattern(evaluator, item, frame, evaluated=evaluated)
        if matcher is not _anything:
            matchers.append((i, matcher))

    def match(env: Env, values: Any) -> Env | None:
        found: Env | None = env
        for i, matcher in matchers:
            found = matcher(found, values[i])  # type: ignore[arg-type]
            if found is None:
                return None
        return found

    return match, frame


# --- sequences and sets --------------------------------------------------------------------------------------


def _flat_concat(pattern: syntax.Pattern) -> list[syntax.Pattern | str]:
    """The items of a sequence pattern in order; a part of unknown length stands as it is, marked by its class."""
    match pattern:
        case syntax.ParenPattern():
            return _flat_concat(pattern.inner)
        case syntax.ConcatPattern():
            return [*_flat_concat(pattern.left), *_flat_concat(pattern.right)]
    return [pattern]


def _sequence(evaluator: Evaluator, pattern: syntax.Pattern, frame: Frame, evaluated: bool) -> tuple[Matcher, Frame]:
    front: list[syntax.Pattern] = []
    back: list[syntax.Pattern] = []
    middle: syntax.Pattern | None = None
    for part in _flat_concat(pattern):
        assert isinstance(part, syntax.Pattern)
        into = front if middle is None else back
        if isinstance(part, syntax.SequencePattern):
            into.extend(part.items)
        elif isinstance(part, syntax.LiteralPattern) and part.kind == "string":
            into.extend(
                syntax.LiteralPattern(kind="char", value=character, span=part.span) for character in str(part.value)
            )
        else:
            middle = part
    if middle is None:
        inner, frame = compile_all(evaluator, tuple(front), frame, evaluated=evaluated)
        return _fixed(inner, len(front)), frame
    if len(front) == 1 and not back and is_variable(evaluator, front[0]) and is_variable(evaluator, middle):
        frame = _with_all(evaluator, (front[0], middle), frame, False)
        return _head_and_tail, frame
    inner, frame = compile_all(evaluator, tuple(front), frame, evaluated=evaluated)
    rest, frame = compile_pattern(evaluator, middle, frame, evaluated=False)
    behind, frame = compile_all(evaluator, tuple(back), frame, evaluated=evaluated)
    count, count_back = len(front), len(back)

    def match(env: Env, value: Any) -> Env | None:
        if type(value) is Thunk:
            value = value.force()
        if type(value) is not Sequence:
            return None
        taken: list[Any] = []
        remaining: Any = value
        for _ in range(count):
            if type(remaining) is Thunk:
                remaining = remaining.force()
            step = remaining.uncons()
            if step is None:
                return None
            item, remaining = step
            taken.append(item)
        if not count_back:
            found = inner(env, taken)
            return None if found is None else rest(found, remaining)
        items = force(remaining).items()
        cut = len(items) - count_back
        if cut < 0:
            return None
        found = inner(env, taken)
        if found is not None:
            found = rest(found, Sequence.of(items[:cut]))
        return None if found is None else behind(found, items[cut:])

    return match, frame


def _head_and_tail(env: Env, value: Any) -> Env | None:
    """``<x>^xs`` with two variables, the most frequent pattern of all."""
    if type(value) is Thunk:
        value = value.force()
    if type(value) is not Sequence:
        return None
    step = value.uncons()
    return None if step is None else env + step


def _fixed(inner: Matcher, length: int) -> Matcher:
    def match(env: Env, value: Any) -> Env | None:
        if type(value) is Thunk:
            value = value.force()
        if type(value) is not Sequence:
            return None
        taken: list[Any] = []
        while True:
            step = value.uncons()
            if step is None:
                return inner(env, taken) if len(taken) == length else None
            if len(taken) == length:
                return None
            taken.append(step[0])
            value = force(step[1])

    if length == 0:

        def match_empty(env: Env, value: Any) -> Env | None:
            if type(value) is Thunk:
                value = value.force()
            return env if type(value) is Sequence and value.is_empty() else None

        return match_empty
    return match


def _set(evaluator: Evaluator, pattern: syntax.SetPattern, frame: Frame) -> tuple[Matcher, Frame]:
    inner, frame = compile_all(evaluator, pattern.items, frame, evaluated=True)
    length = len(pattern.items)

    def match(env: Env, value: Any) -> Env | None:
        value = force(value)
        if not isinstance(value, Set) or not value.is_finite() or value.size() != length:
            return None
        return inner(env, value.elements())

    return match, frame


# --- dotted values -------------------------------------------------------------------------------------------


def flat_dots(pattern: syntax.Pattern) -> list[syntax.Pattern]:
    """The patterns between the dots of *pattern*, brackets or not."""
    match pattern:
        case syntax.ParenPattern():
            return flat_dots(pattern.inner)
        case syntax.DotPattern():
            return [*flat_dots(pattern.left), *flat_dots(pattern.right)]
    return [pattern]


def _width(pattern: syntax.Pattern) -> int:
    """How many parts of a dotted value *pattern* stands for where others follow: ``(x.y) @@ (a.b.c)`` for three."""
    while isinstance(pattern, syntax.ParenPattern):
        pattern = pattern.inner
    if isinstance(pattern, syntax.BothPattern):
        return max(_width(pattern.left), _width(pattern.right))
    return sum(map(_width, flat_dots(pattern))) if isinstance(pattern, syntax.DotPattern) else 1


def _spread(value: Any) -> tuple[Any, ...]:
    """What stands side by side in a value, a channel or constructor in front of its fields."""
    if type(value) is DotList:
        first, *others = value.parts
        return (first, *others)
    if type(value) is Event:
        head, fields = value.parts
        return (head.value, *fields)
    if type(value) is Dotted:
        return (value.head.value, *value.fields)
    return (value,)


def _dots(evaluator: Evaluator, pattern: syntax.DotPattern, frame: Frame) -> tuple[Matcher, Frame]:
    """Parts match from the left: a constructor or channel by name, its fields behind it; the last takes the rest."""
    steps: list[tuple[Callable[[], Head] | None, Matcher | None, int]] = []
    flat = flat_dots(pattern)
    for item in flat:
        if isinstance(item, syntax.NamePattern) and not is_variable(evaluator, item):
            steps.append((_head(evaluator, item, frame), None, 1))
        else:
            matcher, frame = compile_pattern(evaluator, item, frame, evaluated=True)
            steps.append((None, matcher, _width(item)))
    last = len(steps) - 1

    def match(env: Env, value: Any) -> Env | None:
        value = force(value)
        remaining = list(_spread(value))
        if len(remaining) == 1 and steps[0][0] is None:
            return None
        remaining.reverse()
        found: Env | None = env
        for i, (head, matcher, width) in enumerate(steps):
            if not remaining:
                return None
            part = remaining.pop()
            if head is not None:
                wanted = head()
                if type(part) is Dotted and part.head is wanted:
                    remaining.extend(reversed(part.fields))
                elif type(part) is Event and part == wanted.value:
                    pass
                elif type(part) is Event and part.parts[0] is wanted:
                    remaining.extend(reversed(part.parts[1]))
                else:
                    return None
                continue
            assert matcher is not None
            assert found is not None
            if i == last and remaining:
                part = DotList((part, *reversed(remaining)))
                remaining.clear()
            elif width > 1:
                part = DotList((part, *[remaining.pop() for _ in range(min(width - 1, len(remaining)))]))
            found = matcher(found, part)
            if found is None:
                return None
        return None if remaining else found

    return match, frame
