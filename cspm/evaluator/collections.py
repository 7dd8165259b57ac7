"""Tuples, sets, sequences and maps that are written out, and ranges."""

from __future__ import annotations

from typing import Any

from cspcheck.cspm.evaluator.comprehensions import sequence_comprehension, set_comprehension
from cspcheck.cspm.evaluator.core import DELAYED, VALUES, Evaluator
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.dots import completions
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.set_algebra import union
from cspcheck.cspm.values.sets import EMPTY_SET, EventsSet, Range, Set, set_of
from cspcheck.cspm.values.symbolic_sets import Integers
from cspcheck.cspm.values.thunks import Code, Env, force
from cspcheck.cspm.values.values import EMPTY_SEQUENCE, Map, Sequence, counting, counting_from, deep


@VALUES(syntax.TupleExpr)
@DELAYED(syntax.TupleExpr)
def _tuple(evaluator: Evaluator, node: syntax.TupleExpr, frame: Frame) -> Code:
    items = [evaluator.delayed(item, frame) for item in node.items]
    if len(items) == 2:
        first, second = items
        return lambda env: (first(env), second(env))
    return lambda env: tuple([item(env) for item in items])


@VALUES(syntax.SequenceExpr)
def _sequence(evaluator: Evaluator, node: syntax.SequenceExpr, frame: Frame) -> Code:
    if node.statements is not None:
        return sequence_comprehension(evaluator, node.items, node.statements, frame)
    return _listed_sequence(evaluator, node, frame)


@DELAYED(syntax.SequenceExpr)
def _delayed_sequence(evaluator: Evaluator, node: syntax.SequenceExpr, frame: Frame) -> Code:
    if node.statements is not None:
        return evaluator.thunk(node, frame)
    return _listed_sequence(evaluator, node, frame)


def _listed_sequence(evaluator: Evaluator, node: syntax.SequenceExpr, frame: Frame) -> Code:
    items = [evaluator.delayed(item, frame) for item in reversed(node.items)]
    if not items:
        return lambda env: EMPTY_SEQUENCE
    size = len(items)
    return lambda env: Sequence([item(env) for item in items], size)


@VALUES(syntax.SetExpr)
def _set(evaluator: Evaluator, node: syntax.SetExpr, frame: Frame) -> Code:
    if node.statements is not None:
        return set_comprehension(evaluator, node.items, node.statements, frame)
    if not node.items:
        return lambda env: EMPTY_SET
    items = [evaluator.value(item, frame) for item in node.items]
    return lambda env: set_of([deep(item(env)) for item in items])


@DELAYED(syntax.SetExpr)
def _delayed_set(evaluator: Evaluator, node: syntax.SetExpr, frame: Frame) -> Code:
    if node.statements is None and not node.items:
        return lambda env: EMPTY_SET
    return evaluator.thunk(node, frame)


@VALUES(syntax.MapExpr)
def _map(evaluator: Evaluator, node: syntax.MapExpr, frame: Frame) -> Code:
    entries = [(evaluator.value(key, frame), evaluator.delayed(value, frame)) for key, value in node.items]
    return lambda env: Map({deep(key(env)): value(env) for key, value in entries})


# --- ranges --------------------------------------------------------------------------------------------------


def _bound(value: Any, span: Span) -> int:
    if type(value) is int:
        return value
    raise Failure(messages.wrong_kind("a number", value, span))


def _range(low: Any, high: Any) -> Set:
    return Range(low, high) if low <= high else EMPTY_SET


@VALUES(syntax.SetRange)
def _set_range(evaluator: Evaluator, node: syntax.SetRange, frame: Frame) -> Code:
    if node.statements is not None:
        return _set_of_ranges(evaluator, node, frame)
    low = evaluator.value(node.low, frame)
    low_span = node.low.span
    if node.high is None:
        return lambda env: Integers(_bound(low(env), low_span))
    high = evaluator.value(node.high, frame)
    high_span = node.high.span
    return lambda env: _range(_bound(low(env), low_span), _bound(high(env), high_span))


def _set_of_ranges(evaluator: Evaluator, node: syntax.SetRange, frame: Frame) -> Code:
    """``{m..n | statements}``: the union of the ranges."""
    assert node.statements is not None
    plain = syntax.SetRange(low=node.low, high=node.high, span=node.span)
    return set_comprehension(evaluator, (plain,), node.statements, frame, unite=True)


@VALUES(syntax.SequenceRange)
def _sequence_range(evaluator: Evaluator, node: syntax.SequenceRange, frame: Frame) -> Code:
    if node.statements is not None:
        plain = syntax.SequenceRange(low=node.low, high=node.high, span=node.span)
        return sequence_comprehension(evaluator, (plain,), node.statements, frame, join=True)
    low = evaluator.value(node.low, frame)
    low_span = node.low.span
    if node.high is None:
        return lambda env: counting_from(_bound(low(env), low_span))
    high = evaluator.value(node.high, frame)
    high_span = node.high.span

    def count(env: Env) -> Sequence:
        return counting(_bound(low(env), low_span), _bound(high(env), high_span))

    return count


# --- productions ---------------------------------------------------------------------------------------------


def _all(sets: list[Set], channels: Any) -> Set:
    """The union of many sets, at once where all are of events."""
    if sets and all(type(s) is EventsSet for s in sets):
        ranges = [r for s in sets if isinstance(s, EventsSet) for r in s.events.ranges]
        return EventsSet.of(EventSet(ranges), channels)
    result: Set = EMPTY_SET
    for s in sets:
        result = union(result, s)
    return result


@VALUES(syntax.Productions)
def _productions(evaluator: Evaluator, node: syntax.Productions, frame: Frame) -> Code:
    channels = evaluator.channels
    if node.statements is not None:
        from cspcheck.cspm.evaluator.comprehensions import collect

        run = collect(evaluator, node.items, node.statements, frame)
        span = node.span

        def complete_all(env: Env) -> Set:
            try:
                return _all([completions(value) for value in run(env)], channels)
            except Failure as failure:
                failure.at(span)
                raise

        return complete_all
    items = [(evaluator.value(item, frame), item.span) for item in node.items]

    def complete(env: Env) -> Set:
        found: list[Set] = []
        for item, span in items:
            try:
                found.append(completions(force(item(env))))
            except Failure as failure:
                failure.at(span)
                raise
        return _all(found, channels)

    return complete
