"""Applications, functions without names, ``if`` and brackets."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cspcheck.cspm.evaluator.builtins import Builtin
from cspcheck.cspm.evaluator.core import (
    CONDITIONS,
    DELAYED,
    PROCESS_TYPES,
    PROCESSES,
    VALUES,
    Condition,
    Evaluator,
)
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.evaluator.keys import native
from cspcheck.cspm.evaluator.routines import Routine, apply, apply_process, call_routine, passed
from cspcheck.cspm.evaluator.sorts import Sort
from cspcheck.cspm.evaluator.timed import timed_name
from cspcheck.cspm.interruption import Stopped
from cspcheck.cspm.naming.symbols import SymbolKind
from cspcheck.cspm.process.terms import Process, Reference
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.thunks import Code, Env
from cspcheck.cspm.values.values import Function, deep

# --- literals and brackets -----------------------------------------------------------------------------------


@VALUES(syntax.Paren)
def _paren(evaluator: Evaluator, node: syntax.Paren, frame: Frame) -> Code:
    return evaluator.value(syntax.bare(node), frame)


@PROCESSES(syntax.Paren)
def _process_paren(evaluator: Evaluator, node: syntax.Paren, frame: Frame) -> Code:
    return evaluator.process(syntax.bare(node), frame)


@CONDITIONS(syntax.Paren)
def _condition_paren(evaluator: Evaluator, node: syntax.Paren, frame: Frame) -> Condition:
    return evaluator.condition(syntax.bare(node), frame)


@DELAYED(syntax.Paren)
def _delayed_paren(evaluator: Evaluator, node: syntax.Paren, frame: Frame) -> Code:
    return evaluator.delayed(syntax.bare(node), frame)


# --- if ---------------------------------------------------------------------------------------------------


@VALUES(syntax.If)
def _if(evaluator: Evaluator, node: syntax.If, frame: Frame) -> Code:
    return _choose(
        evaluator.condition(node.condition, frame),
        evaluator.value(node.then, frame),
        evaluator.value(node.otherwise, frame),
    )


@PROCESSES(syntax.If)
def _process_if(evaluator: Evaluator, node: syntax.If, frame: Frame) -> Code:
    return _choose(
        evaluator.condition(node.condition, frame),
        evaluator.process(node.then, frame),
        evaluator.process(node.otherwise, frame),
    )


def _choose(condition: Condition, then: Code, otherwise: Code) -> Code:
    def choose(env: Env) -> Any:
        return then(env) if condition(env) else otherwise(env)

    return choose


@CONDITIONS(syntax.If)
def _condition_if(evaluator: Evaluator, node: syntax.If, frame: Frame) -> Condition:
    return _choose(
        evaluator.condition(node.condition, frame),
        evaluator.condition(node.then, frame),
        evaluator.condition(node.otherwise, frame),
    )


# --- functions -----------------------------------------------------------------------------------------------


@VALUES(syntax.Lambda)
@DELAYED(syntax.Lambda)
def _lambda(evaluator: Evaluator, node: syntax.Lambda, frame: Frame) -> Code:
    key = (id(node), frame.unit)
    routine: Routine | None = evaluator.routines.get(key)
    if routine is None:
        head = ", ".join(parameter.span.text for parameter in node.parameters)
        sort = evaluator.sorts.of(node.body)
        clauses = [(node.parameters, node.body)]
        routine = Routine(evaluator, f"(\\ {head} @ ...)", node.span, frame, (len(node.parameters),), clauses, sort)
        evaluator.routines[key] = routine
    found = routine
    return lambda env: Function(found, env)


@VALUES(syntax.Apply)
def _apply(evaluator: Evaluator, node: syntax.Apply, frame: Frame) -> Code:
    known = known_function(evaluator, node, frame)
    if isinstance(known, Builtin):
        return known.compile(evaluator, node, frame)
    span = node.span
    if isinstance(known, Routine):
        wrong = _wrong_count(known, len(node.arguments), span)
        if wrong is not None:
            return wrong
        if len(known.groups) == 1:
            strict = known.strict or (False,) * known.width
            ways = [evaluator.value if needed else evaluator.delayed for needed in strict]
            given = [way(argument, frame) for way, argument in zip(ways, node.arguments, strict=True)]
            return _local_call(known, given, span) if known.frame.size else _call(known, given, span)
    arguments = [evaluator.delayed(argument, frame) for argument in node.arguments]
    function = evaluator.value(node.function, frame)

    def call(env: Env) -> Any:
        return apply(function(env), tuple([argument(env) for argument in arguments]), span)

    return call


def known_function(evaluator: Evaluator, node: syntax.Apply, frame: Frame) -> Routine | Builtin | None:
    """The function that is applied, if the script names it: one of its own, or a built-in."""
    name = syntax.bare(node.function)
    if not isinstance(name, syntax.Name):
        return None
    symbol = evaluator.names.symbol(name)
    if symbol.kind is SymbolKind.FUNCTION:
        if symbol in frame.slots:
            routine = evaluator.routines.get((symbol, frame.unit))
            return routine if isinstance(routine, Routine) else None
        function: Function = frame.unit.thing(symbol)
        known: Routine = function.routine
        return known
    if symbol.kind is SymbolKind.BUILTIN:
        if frame.timing is not None and timed_name(evaluator, symbol.name, frame.timing) is not None:
            found = timed_name(evaluator, symbol.name, frame.timing)
            assert found is not None
            value = found(())
        else:
            value = evaluator.builtins[symbol.name]
        return value if isinstance(value, Builtin) else None
    return None


def _wrong_count(routine: Routine, given: int, span: Span) -> Code | None:
    expected = routine.groups[0]
    if expected == given:
        return None

    def fail(env: Env) -> Any:
        raise Failure(messages.argument_count(routine.name, expected, given, span, routine.span))

    return fail


def _call(routine: Routine, arguments: list[Code], span: Span) -> Code:
    """A call of a definition at the top of a unit, with all its arguments."""
    if routine.sort is Sort.PROCESS:
        return lambda env: routine.reference((), [argument(env) for argument in arguments])
    checked = routine.sort is Sort.UNKNOWN
    if len(arguments) == 1:
        (only,) = arguments

        def call_one(env: Env) -> Any:
            given = (only(env),)
            if routine.known_process:
                return routine.reference((), given)
            try:
                value = routine.enter(given)
            except (Failure, RecursionError, Stopped) as error:
                raise passed(error, routine, given, span) from None
            if checked and type(value) in PROCESS_TYPES and type(value) is not Reference:
                return routine.reference((), given, value)
            return value

        return call_one
    if len(arguments) == 2:
        first, second = arguments

        def call_two(env: Env) -> Any:
            given = (first(env), second(env))
            if routine.known_process:
                return routine.reference((), given)
            try:
                value = routine.enter(given)
            except (Failure, RecursionError, Stopped) as error:
                raise passed(error, routine, given, span) from None
            if checked and type(value) in PROCESS_TYPES and type(value) is not Reference:
                return routine.reference((), given, value)
            return value

        return call_two

    def call(env: Env) -> Any:
        return call_routine(routine, (), tuple([argument(env) for argument in arguments]), span)

    return call


def _local_call(routine: Routine, arguments: list[Code], span: Span) -> Code:
    """A call of a definition inside an expression: its surroundings are the beginning of ours."""
    size = routine.frame.size
    checked = routine.sort is Sort.UNKNOWN

    def call(env: Env) -> Any:
        given = tuple([argument(env) for argument in arguments])
        base = env[:size]
        if routine.known_process:
            return routine.reference(base, given)
        try:
            value = routine.enter(base + given)
        except (Failure, RecursionError, Stopped) as error:
            raise passed(error, routine, given, span) from None
        if checked and type(value) in PROCESS_TYPES and type(value) is not Reference:
            return routine.reference(base, given, value)
        return value

    return call


def _reference(routine: Routine, codes: list[Code], delayed: list[Code]) -> Callable[[Env], Process]:
    """A mention of a process with arguments, which its reference needs evaluated.

    *delayed* are the same arguments put off: the way where one of them cannot be evaluated, or has no end, which does
    not matter as long as nobody asks for it.
    """
    size = routine.frame.size
    evaluated = True

    def in_general(env: Env) -> Process:
        return routine.reference(env[:size], [argument(env) for argument in delayed])

    def refer_one(env: Env) -> Process:
        nonlocal evaluated
        if evaluated:
            try:
                value = deep(only(env))
                return routine.refer((native(value),), env[:size], (value,))
            except Failure:
                evaluated = False
        return in_general(env)

    def refer(env: Env) -> Process:
        nonlocal evaluated
        if evaluated:
            try:
                values = tuple([deep(code(env)) for code in codes])
                return routine.refer(tuple([native(value) for value in values]), env[:size], values)
            except Failure:
                evaluated = False
        return in_general(env)

    if len(codes) == 1:
        (only,) = codes
        return refer_one
    return refer


@PROCESSES(syntax.Apply)
def _process_apply(evaluator: Evaluator, node: syntax.Apply, frame: Frame) -> Callable[[Env], Process]:
    span = node.span
    known = known_function(evaluator, node, frame)
    if isinstance(known, Builtin):
        value = known.compile(evaluator, node, frame)
    else:
        arguments = [evaluator.delayed(argument, frame) for argument in node.arguments]
        if isinstance(known, Routine):
            wrong = _wrong_count(known, len(arguments), span)
            if wrong is not None:
                return wrong
            if len(known.groups) == 1:
                return _reference(known, [evaluator.value(argument, frame) for argument in node.arguments], arguments)
        function = evaluator.value(node.function, frame)

        def value(env: Env) -> Any:
            return apply_process(function(env), tuple([argument(env) for argument in arguments]), span)

    def check(env: Env) -> Process:
        found = value(env)
        if type(found) not in PROCESS_TYPES:
            raise Failure(messages.wrong_kind("a process", found, span))
        return found  # type: ignore[no-any-return]

    return check
