"""Prefixes with their fields: ``c.a!b?x:S$y -> P`` becomes the events that it offers, each with what follows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from cspcheck.cspm.evaluator.core import PROCESSES, VALUES, Evaluator
from cspcheck.cspm.evaluator.dotting import dot_parts, with_fields
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.evaluator.free import mentioned
from cspcheck.cspm.evaluator.patterns import (
    Matcher,
    compile_pattern,
    flat_dots,
    is_irrefutable,
    is_variable,
    named_head,
)
from cspcheck.cspm.evaluator.timed import timed_prefix
from cspcheck.cspm.process.terms import STOP, InternalChoice, Prefix, Process
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values import dots, messages as messages
from cspcheck.cspm.values.dots import (
    ChannelHead,
    Dotted,
    Event,
    Head,
    absorb,
    as_one,
    extension_parts,
    joined,
    next_field,
    single_extensions,
)
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.sets import Set
from cspcheck.cspm.values.thunks import Code, Env

Branches: TypeAlias = list[tuple[int, Process]]
PrefixStep: TypeAlias = Callable[[Env, Any, Branches], None]
"""Goes on from an environment and the event so far, and adds the branches found."""
Choice: TypeAlias = Callable[[Env, Any], list[tuple[Env, Any]]]
"""From an environment and the event so far to those that each value of the next part leads to."""


MOST_BRANCHES = 1 << 20
"""A prefix offers at most so many events."""


@dataclass(frozen=True, slots=True)
class EventPart:
    """What a prefix says of the next part of its event: a field, or what stands between two dots of a pattern.

    Every part stands for one single field, but for the last one: a pattern there is for all that is missing.
    """

    field: syntax.Field
    pattern: syntax.Pattern | None
    is_last: bool


def _parts(node: syntax.Prefix) -> tuple[EventPart, ...]:
    """The fields of *node*, with dotted patterns taken apart, but for those with a set of their own."""
    found: list[tuple[syntax.Field, syntax.Pattern | None]] = []
    for field in node.fields:
        if field.pattern is None or field.restriction is not None:
            found.append((field, field.pattern))
        else:
            found += [(field, pattern) for pattern in flat_dots(field.pattern)]
    last = len(found) - 1
    return tuple([EventPart(field, pattern, i == last) for i, (field, pattern) in enumerate(found)])


def _number(branch: tuple[int, Process]) -> int:
    return branch[0]


@PROCESSES(syntax.Prefix)
@VALUES(syntax.Prefix)
def _prefix(evaluator: Evaluator, node: syntax.Prefix, frame: Frame) -> Callable[[Env], Process]:
    span = node.channel.span
    timing = frame.timing
    outputs = [field.expression for field in node.fields if field.expression is not None]
    parts = [*dot_parts(node.channel), *outputs]
    reach = span.to(node.fields[-1].span) if node.fields else span
    whole = with_fields(evaluator, parts, frame, reach) if len(outputs) == len(node.fields) else None
    channel = whole or evaluator.value(node.channel, frame)
    if not node.fields or whole is not None:
        body = evaluator.process(node.body, frame)

        def plain(env: Env) -> Process:
            event = channel(env)
            if type(event) is not Event:
                raise _no_event(event, span)
            branch = (event.number, body(env))
            if timing is not None:
                return timed_prefix(evaluator, timing, env, (branch,), span)
            return Prefix((branch,))

        return plain
    fields = _parts(node)
    if fields[0].field.kind == "$":
        return _internal(evaluator, node, fields, frame, channel)
    return _external(evaluator, node, fields, frame, channel)


def _external(
    evaluator: Evaluator, node: syntax.Prefix, parts: tuple[EventPart, ...], frame: Frame, event: Code
) -> Callable[[Env], Process]:
    """A prefix without internal choices of fields."""
    steps = _steps(evaluator, node, parts, frame, _shared_body(evaluator, node, frame))
    span = node.span
    timing = frame.timing

    def offer(env: Env) -> Process:
        branches: Branches = []
        steps(env, event(env), branches)
        if len(branches) > 1:
            branches.sort(key=_number)
        if timing is not None:
            return timed_prefix(evaluator, timing, env, branches, span)
        return Prefix(tuple(branches)) if branches else STOP

    return offer


def _no_event(value: Any, span: Span) -> Failure:
    if dots.is_incomplete(value) and value.head.is_channel:
        return Failure(messages.incomplete_event(value, span))
    if type(value) is dots.DotList and type(value.parts[0]) is Event:
        return Failure(messages.too_many_fields(value, span))
    return Failure(messages.wrong_kind("an event", value, span))


def _shared_body(evaluator: Evaluator, node: syntax.Prefix, frame: Frame) -> Callable[[Env], Process] | None:
    """What follows, if it does not depend on the fields: one evaluation then serves all events."""
    used = mentioned(node.body, evaluator.names, evaluator.free_variables)
    for field in node.fields:
        if field.pattern is not None:
            _, inside = compile_pattern(evaluator, field.pattern, Frame.outermost(frame.unit), evaluated=True)
            if not used.isdisjoint(inside.slots):
                return None
    body = evaluator.process(node.body, frame)
    size = frame.size
    return lambda env: body(env[:size])


def _steps(
    evaluator: Evaluator,
    node: syntax.Prefix,
    parts: tuple[EventPart, ...],
    frame: Frame,
    shared: Callable[[Env], Process] | None,
) -> PrefixStep:
    """The *parts* that are left, and what follows them (*shared* by all events, if it depends on no field)."""
    if not parts:
        body = evaluator.process(node.body, frame) if shared is None else shared
        span = node.span

        def finish(env: Env, event: Any, branches: Branches) -> None:
            if type(event) is not Event:
                raise _no_event(event, span)
            if shared is not None and branches:
                branches.append((event.number, branches[0][1]))
            else:
                branches.append((event.number, body(env)))

        return finish
    part, *others = parts
    field, pattern = part.field, part.pattern
    behind = tuple(others)
    if field.kind == "!":
        assert field.expression is not None
        value = evaluator.value(field.expression, frame)
        return _output(value, field.span, _steps(evaluator, node, behind, frame, shared))
    assert pattern is not None
    if part.is_last and _takes_anything(evaluator, part):
        matcher, inside = compile_pattern(evaluator, pattern, frame, evaluated=True)
        rest = _steps(evaluator, node, behind, inside, shared)
        body = evaluator.process(node.body, inside) if shared is None else shared
        return _whole_field(field.span, is_variable(evaluator, pattern), body, shared is not None, rest, matcher)
    choose, inside = _choice(evaluator, part, frame)
    rest = _steps(evaluator, node, behind, inside, shared)
    span = field.span

    everything = all(_takes_anything(evaluator, each) for each in parts)

    def read(env: Env, event: Any, branches: Branches) -> None:
        if everything:
            _check_few(_numbers(event), event, span)
        for found, extended in choose(env, event):
            rest(found, extended, branches)
            if len(branches) > MOST_BRANCHES:
                raise Failure(messages.too_many_completions(event, MOST_BRANCHES), is_limit=True).at(span)

    return read


def _output(value: Code, span: Span, rest: PrefixStep) -> PrefixStep:
    def output(env: Env, event: Any, branches: Branches) -> None:
        if not dots.is_incomplete(event):
            raise _no_field(event, span)
        given = value(env)
        try:
            event = dots.dot(event, given)
        except Failure as failure:
            failure.at(span)
            raise
        rest(env, event, branches)

    return output


def _no_field(event: Any, span: Span) -> Failure:
    if type(event) is Event:
        return Failure(messages.complete_already(event, span))
    return _no_event(event, span)


def _whole_field(
    span: Span,
    variable: bool,
    body: Callable[[Env], Process],
    shared: bool,
    rest: PrefixStep,
    matcher: Matcher,
) -> PrefixStep:
    """A last ``?x`` or ``?_`` over all that is missing: the events have consecutive numbers."""
    general = _input_over_all(span, matcher, rest)

    def whole(env: Env, event: Any, branches: Branches) -> None:
        if type(event) is not Dotted or event.complete:
            raise _no_field(event, span)
        same = shared or not variable
        single = len(event.fields) + 1 == event.head.arity
        numbers = _numbers(event)
        _check_few(numbers, event, span)
        if numbers is None or not (single or same):
            general(env, event, branches)
        elif not same:
            values = event.head.domains[-1].elements()
            branches.extend([(number, body((*env, value))) for number, value in zip(numbers, values, strict=True)])
        elif len(numbers):
            then = branches[0][1] if shared and branches else body(env)
            branches.extend([(number, then) for number in numbers])

    return whole


def _takes_anything(evaluator: Evaluator, part: EventPart) -> bool:
    """Whether a part is a ``?x`` or ``?_`` over all that can be there."""
    return part.field.restriction is None and part.pattern is not None and is_irrefutable(evaluator, part.pattern)


def _numbers(event: Any) -> range | None:
    """The numbers of all events that start with *event*; None if they are not side by side."""
    if type(event) is not Dotted or not isinstance(event.head, ChannelHead) or event.head.declared.size is None:
        return None
    if event.fields and dots.is_incomplete(event.fields[-1]):
        return None
    return event.head.channels.table.completions(event.head.declared, event.fields)


def _check_few(numbers: range | None, event: Any, span: Span) -> None:
    if numbers is not None and len(numbers) > MOST_BRANCHES:
        raise Failure(messages.too_many_completions(event, MOST_BRANCHES), is_limit=True).at(span)


def _missing(event: Dotted, last: bool, span: Span) -> list[tuple[Any, ...]]:
    """What the next field can be, as parts: everything missing if it is the last, else one single field."""
    try:
        if last:
            return list(extension_parts(event))
        return [(value,) for value in single_extensions(event)]
    except Failure as failure:
        failure.at(span)
        raise


def _input_over_all(span: Span, matcher: Matcher, rest: PrefixStep) -> PrefixStep:
    def over_all(env: Env, event: Any, branches: Branches) -> None:
        for parts in _missing(event, True, span):
            found = matcher(env, as_one(parts))
            if found is not None:
                rest(found, joined(event, parts), branches)
                if len(branches) > MOST_BRANCHES:
                    raise Failure(messages.too_many_completions(event, MOST_BRANCHES), is_limit=True).at(span)

    return over_all


def _choice(evaluator: Evaluator, part: EventPart, frame: Frame) -> tuple[Choice, Frame]:
    """What a part that is a ``?`` or ``$`` can be, and the frame behind it."""
    field, pattern = part.field, part.pattern
    assert pattern is not None
    if field.restriction is not None:
        restriction = evaluator.value(field.restriction, frame)
        matcher, inside = compile_pattern(evaluator, pattern, frame, evaluated=True)
        return _restricted(restriction, matcher, part.is_last, field.span), inside
    find = named_head(evaluator, pattern, frame)
    if find is not None:
        return _named(find, field.span), frame
    matcher, inside = compile_pattern(evaluator, pattern, frame, evaluated=True)
    span = field.span

    def choose(env: Env, event: Any) -> list[tuple[Env, Any]]:
        if not dots.is_incomplete(event):
            raise _no_field(event, span)
        chosen: list[tuple[Env, Any]] = []
        for parts in _missing(event, part.is_last, span):
            found = matcher(env, as_one(parts))
            if found is not None:
                chosen.append((found, joined(event, parts)))
        return chosen

    return choose, inside


def _named(find: Callable[[], Head], span: Span) -> Choice:
    """A part that names a constructor or channel: that comes next in the event, if it can, and its fields behind it."""

    def choose(env: Env, event: Any) -> list[tuple[Env, Any]]:
        if not dots.is_incomplete(event):
            raise _no_field(event, span)
        head = find()
        try:
            if dots.is_incomplete(head.value):
                allowed = next_field(event).may_contain_head(head)
            else:
                allowed = any(value == head.value for value in single_extensions(event))
            return [(env, absorb(event, head.value))] if allowed else []
        except Failure as failure:
            failure.at(span)
            raise

    return choose


def _restricted(restriction: Code, matcher: Matcher, last: bool, span: Span) -> Choice:
    """A part with a set of its own, ``?x:S``."""

    def choose(env: Env, event: Any) -> list[tuple[Env, Any]]:
        if not dots.is_incomplete(event):
            raise _no_field(event, span)
        values = restriction(env)
        if not isinstance(values, Set):
            raise Failure(messages.wrong_kind("a set", values, span))
        chosen: list[tuple[Env, Any]] = []
        try:
            if values.is_finite():
                for value in values.elements():
                    extended = dots.dot(event, value)
                    found = matcher(env, value)
                    if found is not None:
                        chosen.append((found, extended))
            else:
                for parts in _missing(event, last, span):
                    value = as_one(parts)
                    if values.contains(value):
                        found = matcher(env, value)
                        if found is not None:
                            chosen.append((found, joined(event, parts)))
        except Failure as failure:
            failure.at(span)
            raise
        return chosen

    return choose


def _internal(
    evaluator: Evaluator, node: syntax.Prefix, parts: tuple[EventPart, ...], frame: Frame, event: Code
) -> Callable[[Env], Process]:
    """A ``$`` field: one internal choice over its values, and those of the ``$`` fields behind it."""
    choose = _internal_steps(evaluator, node, parts, frame)
    span = parts[0].field.span

    def decide(env: Env) -> Process:
        operands: list[Process] = []
        choose(env, event(env), operands)
        if not operands:
            raise Failure(messages.empty_internal_choice("the `$` field", span))
        return operands[0] if len(operands) == 1 else InternalChoice(tuple(operands))

    return decide


def _internal_steps(
    evaluator: Evaluator, node: syntax.Prefix, parts: tuple[EventPart, ...], frame: Frame
) -> Callable[[Env, Any, list[Process]], None]:
    if not parts:
        body = evaluator.process(node.body, frame)
        span = node.span

        def finish(env: Env, event: Any, operands: list[Process]) -> None:
            if type(event) is not Event:
                raise _no_event(event, span)
            operands.append(Prefix(((event.number, body(env)),)))

        return finish
    part, *others = parts
    if part.field.kind != "$":
        steps = _steps(evaluator, node, parts, frame, None)

        def communicate(env: Env, event: Any, operands: list[Process]) -> None:
            branches: Branches = []
            steps(env, event, branches)
            branches.sort(key=_number)
            operands.append(Prefix(tuple(branches)) if branches else STOP)

        return communicate
    choose, inside = _choice(evaluator, part, frame)
    rest = _internal_steps(evaluator, node, tuple(others), inside)

    def decide(env: Env, event: Any, operands: list[Process]) -> None:
        for found, extended in choose(env, event):
            rest(found, extended, operands)

    return decide
