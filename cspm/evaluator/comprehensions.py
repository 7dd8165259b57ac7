"""Generators and qualifiers: comprehensions, and what replicated operators range over.

The statements become nested loops in Python closures. Sets are listed at once. Sequences are produced in chunks of
growing size as they are looked at, so an infinite source gives an infinite sequence.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence as Items
from contextlib import suppress
from typing import Any, TypeAlias

from cspcheck.cspm.evaluator.core import Condition, Evaluator
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.evaluator.fusion import fused_elements
from cspcheck.cspm.evaluator.patterns import Matcher, compile_pattern, is_variable
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.set_algebra import union
from cspcheck.cspm.values.sets import EMPTY_SET, Set, set_of
from cspcheck.cspm.values.thunks import Code, Env, Thunk, force
from cspcheck.cspm.values.values import EMPTY_SEQUENCE, FRUITLESS, Sequence, deep

Emit: TypeAlias = Callable[[Any], None]
Loop: TypeAlias = Callable[[Env, Emit], None]
"""Runs the rest of the statements in an environment and emits what they produce."""
Over: TypeAlias = Callable[[Env, list[Any], Emit], None]
"""The same where the first statement is a generator, given what it ranges over."""

HOT = 200
"""After so many elements a comprehension is worth a function of its own."""


def source_items(value: Any, span: Span) -> list[Any]:
    """What a generator ranges over: a set in order, or a sequence.

    Raises:
        Failure: it is neither, or infinite.
    """
    try:
        if isinstance(value, Set):
            return value.elements()
        if type(value) is Sequence:
            return value.items()
    except Failure as failure:
        failure.at(span)
        raise
    raise Failure(messages.wrong_kind("a set or a sequence", value, span))


def compile_statements(
    evaluator: Evaluator, statements: Items[syntax.Statement], frame: Frame, innermost: Callable[[Frame], Loop]
) -> Loop:
    """The loops of *statements* around the loop that *innermost* makes in the frame behind them."""
    if not statements:
        return innermost(frame)
    statement, rest = statements[0], statements[1:]
    if isinstance(statement, syntax.Qualifier):
        condition = evaluator.condition(statement.condition, frame)
        inner = compile_statements(evaluator, rest, frame, innermost)
        return _qualified(condition, inner)
    assert isinstance(statement, syntax.Generator)
    source = evaluator.value(statement.source, frame)
    span = statement.source.span
    over = _over_first(evaluator, statements, frame, innermost)

    def loop(env: Env, emit: Emit) -> None:
        over(env, source_items(source(env), span), emit)

    return loop


def _over_first(
    evaluator: Evaluator, statements: Items[syntax.Statement], frame: Frame, innermost: Callable[[Frame], Loop]
) -> Over:
    """The loops of *statements*, which begin with a generator, given what that ranges over."""
    statement, rest = statements[0], statements[1:]
    assert isinstance(statement, syntax.Generator)
    matcher, inside, variable = _generator(evaluator, statement, frame)
    condition_first = None
    if rest and isinstance(rest[0], syntax.Qualifier):
        condition_first = evaluator.condition(rest[0].condition, inside)
        rest = rest[1:]
    inner = compile_statements(evaluator, rest, inside, innermost)
    return _generated(None if variable else matcher, condition_first, inner)


def _generator(evaluator: Evaluator, statement: syntax.Generator, frame: Frame) -> tuple[Matcher, Frame, bool]:
    """The matcher of a generator's pattern, the frame behind it, and whether it is a plain variable."""
    matcher, inside = compile_pattern(evaluator, statement.pattern, frame, evaluated=False)
    return matcher, inside, is_variable(evaluator, statement.pattern)


def _qualified(condition: Condition, inner: Loop) -> Loop:
    def loop(env: Env, emit: Emit) -> None:
        if condition(env):
            inner(env, emit)

    return loop


def _generated(matcher: Matcher | None, condition: Condition | None, inner: Loop) -> Over:
    """A generator, with the qualifier behind it if there is one."""
    if matcher is None and condition is None:

        def each(env: Env, items: list[Any], emit: Emit) -> None:
            for item in items:
                inner((*env, item), emit)

        return each
    if matcher is None:
        assert condition is not None
        test = condition

        def some(env: Env, items: list[Any], emit: Emit) -> None:
            for item in items:
                found = (*env, item)
                if test(found):
                    inner(found, emit)

        return some

    def matching(env: Env, items: list[Any], emit: Emit) -> None:
        for item in items:
            found = matcher(env, item)
            if found is not None and (condition is None or condition(found)):
                inner(found, emit)

    return matching


def collect(
    evaluator: Evaluator, items: Items[syntax.Expr], statements: Items[syntax.Statement], frame: Frame
) -> Callable[[Env], list[Any]]:
    """Code for the values of *items* for each way through *statements*, evaluated through and through, in a list."""

    def innermost(inside: Frame) -> Loop:
        codes = [evaluator.value(item, inside) for item in items]
        if len(codes) == 1:
            (only,) = codes

            def one(env: Env, emit: Emit) -> None:
                value = only(env)
                emit(value if type(value) is int else deep(value))

            return one

        def all_items(env: Env, emit: Emit) -> None:
            for code in codes:
                emit(deep(code(env)))

        return all_items

    if not statements or not isinstance(statements[0], syntax.Generator):
        loop = compile_statements(evaluator, statements, frame, innermost)

        def run(env: Env) -> list[Any]:
            found: list[Any] = []
            loop(env, found.append)
            return found

        return run
    source = evaluator.value(statements[0].source, frame)
    span = statements[0].source.span
    elements = _elements(evaluator, items, statements, frame, innermost, of_set=True)
    return lambda env: elements(env, source_items(source(env), span))


def _elements(
    evaluator: Evaluator,
    items: Items[syntax.Expr],
    statements: Items[syntax.Statement],
    frame: Frame,
    innermost: Callable[[Frame], Loop],
    *,
    of_set: bool,
) -> Callable[[Env, list[Any]], list[Any]]:
    """What a comprehension produces, given what its first generator ranges over; fused when it has got hot."""
    over = _over_first(evaluator, statements, frame, innermost)

    def closures(env: Env, first: list[Any]) -> list[Any]:
        found: list[Any] = []
        over(env, first, found.append)
        return found

    if evaluator.sorts.types is None:
        return closures
    seen = 0
    run: Callable[[Env, list[Any]], list[Any]] = closures

    def counted(env: Env, first: list[Any]) -> list[Any]:
        nonlocal seen, run
        if seen <= HOT:
            seen += len(first)
            if seen > HOT:
                run = fused_elements(evaluator, items, statements, frame, closures, of_set=of_set)
        return run(env, first)

    return counted


def collect_processes(
    evaluator: Evaluator,
    statements: Items[syntax.Statement],
    frame: Frame,
    innermost: Callable[[Frame], Code],
) -> Callable[[Env], list[Any]]:
    """Code for what *innermost* gives for each way through *statements*, in order."""

    def inner_loop(inside: Frame) -> Loop:
        code = innermost(inside)

        def one(env: Env, emit: Emit) -> None:
            emit(code(env))

        return one

    loop = compile_statements(evaluator, statements, frame, inner_loop)

    def run(env: Env) -> list[Any]:
        found: list[Any] = []
        loop(env, found.append)
        return found

    return run


def set_comprehension(
    evaluator: Evaluator,
    items: Items[syntax.Expr],
    statements: Items[syntax.Statement],
    frame: Frame,
    *,
    unite: bool = False,
) -> Code:
    """``{items | statements}``; with *unite* the items are sets whose union is wanted."""
    if unite:
        sets = collect_processes(evaluator, statements, frame, lambda inside: evaluator.value(items[0], inside))

        def unite_all(env: Env) -> Set:
            result: Set = EMPTY_SET
            for found in sets(env):
                result = union(result, found)
            return result

        return unite_all
    run = collect(evaluator, items, statements, frame)
    return lambda env: set_of(run(env))


# --- sequences -----------------------------------------------------------------------------------------------

_FIRST_CHUNK = 32
_GROWTH = 8
_LARGEST_CHUNK = 4096


def sequence_comprehension(
    evaluator: Evaluator,
    items: Items[syntax.Expr],
    statements: Items[syntax.Statement],
    frame: Frame,
    *,
    join: bool = False,
) -> Code:
    """``<items | statements>``; with *join* the items are sequences that are wanted one behind the other.

    The source of the first generator is followed as far as it is known; for each of its elements the other
    statements run to their end, unless one of their sources is infinite: then its elements come one by one too.
    """
    if not statements:
        return _innermost_sequence(evaluator, items, frame, join)
    statement, rest = statements[0], statements[1:]
    if isinstance(statement, syntax.Qualifier):
        condition = evaluator.condition(statement.condition, frame)
        then = sequence_comprehension(evaluator, items, rest, frame, join=join)
        return lambda env: then(env) if condition(env) else EMPTY_SEQUENCE
    assert isinstance(statement, syntax.Generator)
    source = evaluator.value(statement.source, frame)
    span = statement.source.span
    if join or any(isinstance(s, syntax.Generator) for s in rest):
        matcher, inside, _ = _generator(evaluator, statement, frame)
        then = sequence_comprehension(evaluator, items, rest, inside, join=join)
        return _joined(source, span, matcher, then)
    elements = _elements(
        evaluator, items, statements, frame, lambda last: _sequence_items(evaluator, items, last), of_set=False
    )
    return _chunked(source, span, elements, single=len(items) == 1)


def _sequence_items(evaluator: Evaluator, items: Items[syntax.Expr], frame: Frame) -> Loop:
    codes = [evaluator.delayed(item, frame) for item in items]
    if len(codes) == 1:
        (only,) = codes

        def one(env: Env, emit: Emit) -> None:
            emit(only(env))

        return one

    def all_items(env: Env, emit: Emit) -> None:
        for code in codes:
            emit(code(env))

    return all_items


def _innermost_sequence(evaluator: Evaluator, items: Items[syntax.Expr], frame: Frame, join: bool) -> Code:
    if join:
        return evaluator.value(items[0], frame)
    codes = [evaluator.delayed(item, frame) for item in items]
    return lambda env: Sequence.of([code(env) for code in codes])


def _source(value: Any, span: Span) -> Sequence:
    if type(value) is Sequence:
        return value
    return Sequence.of(source_items(value, span))


def _chunked(source: Code, span: Span, elements: Callable[[Env, list[Any]], list[Any]], *, single: bool) -> Code:
    """One generator: its elements in chunks that grow, each worked through at once.

    A chunk looks further ahead than was asked for. If that goes wrong, the sequence ends in a thunk that goes
    wrong in the same way when someone comes so far.
    """

    def produce(env: Env, known: list[Any], position: int, rest: Any, size: int, endless: bool) -> Sequence:
        passed = 0
        while True:
            if passed > FRUITLESS:
                raise Failure(messages.nothing_found(FRUITLESS), is_limit=True).at(span)
            stop = min(position + size, len(known))
            try:
                found = elements(env, known[position:stop])
            except (Failure, RecursionError):
                if size == 1:
                    raise
                size = 1  # look no further ahead than was asked for
                continue
            passed += stop - position
            position = stop
            if position == len(known):
                if rest is None:
                    return Sequence.of(found)
                if found:
                    return Sequence.lazy(
                        found, _later(env, known, position, rest, _GROWTH * size, endless), endless=endless
                    )
                known, rest = _known(force(rest), span)
                position = 0
            elif found:
                return Sequence.lazy(
                    found, _later(env, known, position, rest, _GROWTH * size, endless), endless=endless
                )
            size = min(_GROWTH * size, _LARGEST_CHUNK)

    def _later(env: Env, known: list[Any], position: int, rest: Any, size: int, endless: bool) -> Thunk:
        def go_on(_: Env) -> Sequence:
            if position == len(known):
                more, after = _known(force(rest), span)
                return produce(env, more, 0, after, size, endless)
            return produce(env, known, position, rest, size, endless)

        return Thunk(go_on, ())

    def start(env: Env) -> Sequence:
        sequence = _source(source(env), span)
        if single and sequence.rest is None:
            backward = sequence.known_backward()
            if len(backward) <= _FIRST_CHUNK:
                # A short sequence is worked through at once, back to front as it is kept.
                with suppress(Failure, RecursionError):
                    found = elements(env, backward)
                    return Sequence(found, len(found))
        known, rest = _known(sequence, span)
        return produce(env, known, 0, rest, _FIRST_CHUNK, sequence.endless)

    return start


def _known(value: Any, span: Span) -> tuple[list[Any], Any]:
    """The elements of a sequence that are known, and the thunk of the others if there may be any."""
    sequence = _source(value, span)
    return sequence.known_backward()[::-1], sequence.rest


def _joined(source: Code, span: Span, matcher: Matcher, then: Code) -> Code:
    """A generator around others: the sequences that its elements give, one behind the other, when they are needed."""
    from cspcheck.cspm.evaluator.builtins_data import append

    def later(state: Env) -> Sequence:
        return follow(*state)

    def follow(env: Env, remaining: Any) -> Sequence:
        for _ in range(FRUITLESS):
            step = _source(force(remaining), span).uncons()
            if step is None:
                return EMPTY_SEQUENCE
            inner = matcher(env, step[0])
            remaining = step[1]
            if inner is None:
                continue
            first: Sequence = then(inner)
            if first.is_empty():
                continue
            return append(first, Thunk(later, (env, remaining)))
        raise Failure(messages.nothing_found(FRUITLESS), is_limit=True).at(span)

    return lambda env: follow(env, _source(source(env), span))
