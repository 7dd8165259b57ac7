"""``let``: local definitions that see each other."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cspcheck.cspm.evaluator.core import (
    CONDITIONS,
    PROCESSES,
    VALUES,
    Condition,
    Evaluator,
)
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.evaluator.patterns import compile_pattern
from cspcheck.cspm.evaluator.routines import Routine
from cspcheck.cspm.evaluator.sorts import Sort
from cspcheck.cspm.evaluator.units import function_routine, named_routine, timing
from cspcheck.cspm.naming.patterns import variables
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.thunks import Code, Env, Thunk
from cspcheck.cspm.values.values import Function


@VALUES(syntax.Let)
def _let(evaluator: Evaluator, node: syntax.Let, frame: Frame) -> Code:
    extend, inner = _definitions(evaluator, node, frame)
    body = evaluator.value(node.body, inner)
    return lambda env: body(extend(env))


@PROCESSES(syntax.Let)
def _process_let(evaluator: Evaluator, node: syntax.Let, frame: Frame) -> Code:
    extend, inner = _definitions(evaluator, node, frame)
    body = evaluator.process(node.body, inner)
    return lambda env: body(extend(env))


@CONDITIONS(syntax.Let)
def _condition_let(evaluator: Evaluator, node: syntax.Let, frame: Frame) -> Condition:
    extend, inner = _definitions(evaluator, node, frame)
    body = evaluator.condition(node.body, inner)
    return lambda env: body(extend(env))


def _definitions(evaluator: Evaluator, node: syntax.Let, frame: Frame) -> tuple[Callable[[Env], Env], Frame]:
    """What extends the environment by the definitions of a ``let``, which see each other, and the frame inside."""
    local: list[tuple[syntax.Declaration, syntax.TimedDeclaration | None]] = []

    def collect(declarations: tuple[syntax.Declaration, ...], section: syntax.TimedDeclaration | None) -> None:
        for declaration in declarations:
            if isinstance(declaration, syntax.TimedDeclaration):
                collect(declaration.declarations, declaration)
            elif isinstance(declaration, syntax.FunctionDefinition | syntax.PatternDefinition):
                local.append((declaration, section))

    collect(node.declarations, None)
    names = evaluator.names
    symbols: list[Symbol | None] = []
    for declaration, _ in local:
        if isinstance(declaration, syntax.FunctionDefinition):
            symbols.append(names.symbol(declaration))
            continue
        assert isinstance(declaration, syntax.PatternDefinition)
        bound = _bound(evaluator, declaration.pattern)
        if len(bound) == 1 and isinstance(_plain(declaration.pattern), syntax.NamePattern):
            symbols.append(bound[0])
        else:
            symbols.append(None)  # the matched value; its variables follow
            symbols.extend(bound)
    inner = frame.with_variables(symbols, evaluated=False)
    makers: list[Callable[[], Thunk | Function]] = []
    for declaration, section in local:
        place = inner if section is None else inner.with_timing(timing(evaluator, section, inner))
        if isinstance(declaration, syntax.FunctionDefinition):
            makers.append(_function_maker(_local_routine(evaluator, declaration, place)))
            continue
        assert isinstance(declaration, syntax.PatternDefinition)
        bound = _bound(evaluator, declaration.pattern)
        if len(bound) == 1 and isinstance(_plain(declaration.pattern), syntax.NamePattern):
            makers.append(_name_maker(_local_routine(evaluator, declaration, place)))
        else:
            makers.extend(_pattern_makers(evaluator, declaration, place, frame.size + len(makers)))

    def extend(env: Env) -> Env:
        new = [make() for make in makers]
        env = (*env, *new)
        for item in new:
            item.env = env
        return env

    return extend, inner


def _plain(pattern: syntax.Pattern) -> syntax.Pattern:
    while isinstance(pattern, syntax.ParenPattern):
        pattern = pattern.inner
    return pattern


def _bound(evaluator: Evaluator, pattern: syntax.Pattern) -> list[Symbol]:
    symbols = [evaluator.names.find(node) for node in variables(pattern)]
    return [symbol for symbol in symbols if symbol is not None and symbol.kind is SymbolKind.VALUE]


def _local_routine(
    evaluator: Evaluator, declaration: syntax.FunctionDefinition | syntax.PatternDefinition, frame: Frame
) -> Routine:
    """The one routine of a local definition, whichever way the expression around it is compiled."""
    if isinstance(declaration, syntax.FunctionDefinition):
        symbol = evaluator.names.symbol(declaration)
    else:
        symbol = evaluator.names.symbol(_plain(declaration.pattern))
    key = (symbol, frame.unit)
    routine: Routine | None = evaluator.routines.get(key)
    if routine is None:
        if isinstance(declaration, syntax.FunctionDefinition):
            routine = function_routine(evaluator, declaration, frame)
        else:
            routine = named_routine(evaluator, symbol, declaration, frame)
        evaluator.routines[key] = routine
    return routine


def _function_maker(routine: Routine) -> Callable[[], Function]:
    return lambda: Function(routine, ())


def _name_maker(routine: Routine) -> Callable[[], Thunk]:
    code = routine.named_value
    return lambda: Thunk(code, ())


def _pattern_makers(
    evaluator: Evaluator, declaration: syntax.PatternDefinition, frame: Frame, slot: int
) -> list[Callable[[], Thunk]]:
    """Thunks of the matched value, at *slot*, and of each of its variables."""
    pattern = declaration.pattern
    matcher, _ = compile_pattern(evaluator, pattern, Frame.outermost(frame.unit), evaluated=False)
    value = evaluator.delayed(declaration.body, frame)
    routine = Routine(evaluator, pattern.span.text, declaration.span, frame, (), [((), declaration.body)], Sort.UNKNOWN)

    def match(env: Env) -> Any:
        found = matcher((), value(env))
        if found is None:
            whole = evaluator.value(declaration.body, frame)(env)
            raise Failure(messages.no_match(whole, pattern.span.text, pattern.span))
        return found

    def part(i: int) -> Code:
        def take(env: Env) -> Any:
            item = env[slot].force()[i]
            return item.force() if type(item) is Thunk else item

        return take

    bound = _bound(evaluator, pattern)
    for symbol in bound:
        evaluator.routines[symbol, frame.unit] = _PartOf(routine)
    codes = [match, *[part(i) for i in range(len(bound))]]
    return [_delay(code) for code in codes]


def _delay(code: Code) -> Callable[[], Thunk]:
    return lambda: Thunk(code, ())


class _PartOf:
    """A variable of a local definition by a larger pattern: it depends on what the whole definition depends on."""

    __slots__ = ("sort", "whole")

    def __init__(self, whole: Routine) -> None:
        self.whole = whole
        self.sort = Sort.UNKNOWN

    def uses(self) -> list[Any]:
        return self.whole.uses()

    def is_plain_data(self) -> bool:
        return False
