"""Names, applications, functions without names, ``let`` and ``if``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cspm import syntax
from cspm.evaluator.builtins import Builtin
from cspm.evaluator.core import (
    CONDITIONS,
    DELAYED,
    PROCESS_TYPES,
    PROCESSES,
    VALUES,
    Condition,
    Evaluator,
    compiles,
    unwrap,
)
from cspm.evaluator.frames import Frame
from cspm.evaluator.patterns import compile_pattern
from cspm.evaluator.routines import Routine, apply, apply_process, call_routine, passed
from cspm.evaluator.sorts import Sort
from cspm.evaluator.timed import timed_name
from cspm.evaluator.units import function_routine, named_routine, timing
from cspm.failure import Failure
from cspm.messages import evaluation as messages
from cspm.names_patterns import variables
from cspm.names_symbols import Symbol, SymbolKind
from cspm.process import Process, Reference
from cspm.source import Span
from cspm.thunks import Code, Env, Thunk
from cspm.values import Function

# --- names ---------------------------------------------------------------------------------------------------


@compiles(VALUES, syntax.Name)
def _name(evaluator: Evaluator, node: syntax.Name, frame: Frame) -> Code:
    symbol = evaluator.names.symbol(node)
    slot = frame.slots.get(symbol)
    if slot is not None:
        return _evaluated(slot) if symbol in frame.evaluated else _variable(slot, node.span)
    if symbol.kind is SymbolKind.BUILTIN:
        return _builtin(evaluator, symbol, frame, node.span)
    thing = frame.unit.thing(symbol)
    if isinstance(thing, Routine):
        return _named(thing, node.span)
    if type(thing) is Thunk:
        return _forced(thing, node.span)
    if symbol.kind in (SymbolKind.CHANNEL, SymbolKind.CONSTRUCTOR):
        return lambda env: thing.value
    return lambda env: thing


def _evaluated(slot: int) -> Code:
    return lambda env: env[slot]


def _variable(slot: int, span: Span) -> Code:
    def get(env: Env) -> Any:
        value = env[slot]
        if type(value) is not Thunk:
            return value
        if value.code is None:
            return value.value
        try:
            return value.force()
        except Failure as failure:
            failure.at(span)
            raise

    return get


def _forced(thunk: Thunk, span: Span) -> Code:
    get = _variable(0, span)
    here = (thunk,)
    return lambda env: get(here)


def _named(routine: Routine, span: Span) -> Code:
    thunk = routine.thunk
    assert thunk is not None

    def get(env: Env) -> Any:
        if thunk.code is None:
            return thunk.value
        if routine.known_process:
            return thunk.settle(routine.reference((), ()))
        if thunk.is_being_evaluated:
            raise Failure(messages.depends_on_itself(routine.name, span))
        try:
            return thunk.force()
        except (Failure, RecursionError) as error:
            raise passed(error, routine, (), span) from None

    return get


def _builtin(evaluator: Evaluator, symbol: Symbol, frame: Frame, span: Span) -> Code:
    if frame.timing is not None:
        found = timed_name(evaluator, symbol.name, frame.timing)
        if found is not None:
            return found
    value = evaluator.builtins[symbol.name]
    if symbol.name == "Events":
        return lambda env: value()
    return lambda env: value


@compiles(PROCESSES, syntax.Name)
def _process_name(evaluator: Evaluator, node: syntax.Name, frame: Frame) -> Callable[[Env], Process]:
    symbol = evaluator.names.symbol(node)
    span = node.span
    slot = frame.slots.get(symbol)
    routine = evaluator.routines.get((symbol, frame.unit))
    if slot is not None and isinstance(routine, Routine) and not routine.groups:
        return _local_process(routine, slot)
    if slot is None and symbol.kind is not SymbolKind.BUILTIN:
        thing = frame.unit.thing(symbol)
        if isinstance(thing, Routine):
            return _global_process(thing)
    value = _name(evaluator, node, frame)

    def check(env: Env) -> Process:
        found = value(env)
        if type(found) not in PROCESS_TYPES:
            raise Failure(messages.wrong_kind("a process", found, span))
        return found  # type: ignore[no-any-return]

    return check


def _global_process(routine: Routine) -> Callable[[Env], Process]:
    thunk = routine.thunk
    assert thunk is not None

    def get(env: Env) -> Process:
        if thunk.code is None and type(thunk.value) in PROCESS_TYPES:
            return thunk.value  # type: ignore[no-any-return]
        routine.known_process = True
        return thunk.settle(routine.reference((), ()))  # type: ignore[no-any-return]

    return get


def _local_process(routine: Routine, slot: int) -> Callable[[Env], Process]:
    size = routine.frame.size

    def get(env: Env) -> Process:
        thunk = env[slot]
        if type(thunk) is Thunk:
            if thunk.code is not None:
                routine.known_process = True
                return thunk.settle(routine.reference(env[:size], ()))  # type: ignore[no-any-return]
            thunk = thunk.value
        if type(thunk) not in PROCESS_TYPES:
            raise Failure(messages.wrong_kind("a process", thunk, routine.span))
        return thunk  # type: ignore[no-any-return]

    return get


@compiles(DELAYED, syntax.Name)
def _delayed_name(evaluator: Evaluator, node: syntax.Name, frame: Frame) -> Code:
    symbol = evaluator.names.symbol(node)
    slot = frame.slots.get(symbol)
    if slot is not None:
        return _evaluated(slot)
    if symbol.kind is not SymbolKind.BUILTIN:
        thing = frame.unit.thing(symbol)
        if isinstance(thing, Routine):
            routine_thunk = thing.thunk
            assert routine_thunk is not None
            return _shared(routine_thunk)
        if type(thing) is Thunk:
            return _shared(thing)
        if symbol.kind is SymbolKind.CHANNEL or symbol.kind is SymbolKind.CONSTRUCTOR:
            return evaluator.thunk(node, frame)
    return _name(evaluator, node, frame)


def _shared(thunk: Thunk) -> Code:
    def get(env: Env) -> Any:
        return thunk.value if thunk.code is None else thunk

    return get


# --- literals and brackets -----------------------------------------------------------------------------------


@compiles(VALUES, syntax.Paren)
def _paren(evaluator: Evaluator, node: syntax.Paren, frame: Frame) -> Code:
    return evaluator.value(unwrap(node), frame)


@compiles(PROCESSES, syntax.Paren)
def _process_paren(evaluator: Evaluator, node: syntax.Paren, frame: Frame) -> Code:
    return evaluator.process(unwrap(node), frame)


@compiles(CONDITIONS, syntax.Paren)
def _condition_paren(evaluator: Evaluator, node: syntax.Paren, frame: Frame) -> Condition:
    return evaluator.condition(unwrap(node), frame)


@compiles(DELAYED, syntax.Paren)
def _delayed_paren(evaluator: Evaluator, node: syntax.Paren, frame: Frame) -> Code:
    return evaluator.delayed(unwrap(node), frame)


# --- if and let ----------------------------------------------------------------------------------------------


@compiles(VALUES, syntax.If)
def _if(evaluator: Evaluator, node: syntax.If, frame: Frame) -> Code:
    return _choose(
        evaluator.condition(node.condition, frame),
        evaluator.value(node.then, frame),
        evaluator.value(node.otherwise, frame),
    )


@compiles(PROCESSES, syntax.If)
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


@compiles(CONDITIONS, syntax.If)
def _condition_if(evaluator: Evaluator, node: syntax.If, frame: Frame) -> Condition:
    return _choose(
        evaluator.condition(node.condition, frame),
        evaluator.condition(node.then, frame),
        evaluator.condition(node.otherwise, frame),
    )


@compiles(VALUES, syntax.Let)
def _let(evaluator: Evaluator, node: syntax.Let, frame: Frame) -> Code:
    extend, inner = _definitions(evaluator, node, frame)
    body = evaluator.value(node.body, inner)
    return lambda env: body(extend(env))


@compiles(PROCESSES, syntax.Let)
def _process_let(evaluator: Evaluator, node: syntax.Let, frame: Frame) -> Code:
    extend, inner = _definitions(evaluator, node, frame)
    body = evaluator.process(node.body, inner)
    return lambda env: body(extend(env))


@compiles(CONDITIONS, syntax.Let)
def _condition_let(evaluator: Evaluator, node: syntax.Let, frame: Frame) -> Condition:
    extend, inner = _definitions(evaluator, node, frame)
    body = evaluator.condition(node.body, inner)
    return lambda env: body(extend(env))


def _definitions(evaluator: Evaluator, node: syntax.Let, frame: Frame) -> tuple[Callable[[Env], Env], Frame]:
    """What extends the environment by the definitions of a ``let``, which see each other, and the frame inside."""
    local: list[tuple[syntax.Declaration, syntax.TimedDeclaration | None, Frame | None]] = []

    def collect(declarations: tuple[syntax.Declaration, ...], section: syntax.TimedDeclaration | None) -> None:
        for declaration in declarations:
            if isinstance(declaration, syntax.TimedDeclaration):
                collect(declaration.declarations, declaration)
            elif isinstance(declaration, syntax.FunctionDefinition | syntax.PatternDefinition):
                local.append((declaration, section, None))

    collect(node.declarations, None)
    names = evaluator.names
    symbols: list[Symbol | None] = []
    for declaration, _, _ in local:
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
    for declaration, section, _ in local:
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


# --- functions -----------------------------------------------------------------------------------------------


@compiles(VALUES, syntax.Lambda)
@compiles(DELAYED, syntax.Lambda)
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


@compiles(VALUES, syntax.Apply)
def _apply(evaluator: Evaluator, node: syntax.Apply, frame: Frame) -> Code:
    known = _known_function(evaluator, node, frame)
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


def _known_function(evaluator: Evaluator, node: syntax.Apply, frame: Frame) -> Routine | Builtin | None:
    """The function that is applied, if the script names it: one of its own, or a built-in."""
    name = unwrap(node.function)
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
            except (Failure, RecursionError) as error:
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
            except (Failure, RecursionError) as error:
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
        except (Failure, RecursionError) as error:
            raise passed(error, routine, given, span) from None
        if checked and type(value) in PROCESS_TYPES and type(value) is not Reference:
            return routine.reference(base, given, value)
        return value

    return call


@compiles(PROCESSES, syntax.Apply)
def _process_apply(evaluator: Evaluator, node: syntax.Apply, frame: Frame) -> Callable[[Env], Process]:
    span = node.span
    known = _known_function(evaluator, node, frame)
    if isinstance(known, Builtin):
        value = known.compile(evaluator, node, frame)
    else:
        arguments = [evaluator.delayed(argument, frame) for argument in node.arguments]
        if isinstance(known, Routine):
            wrong = _wrong_count(known, len(arguments), span)
            if wrong is not None:
                return wrong
            if len(known.groups) == 1:
                known_routine = known
                size = known.frame.size

                def refer(env: Env) -> Process:
                    return known_routine.reference(env[:size], [argument(env) for argument in arguments])

                return refer
        function = evaluator.value(node.function, frame)

        def value(env: Env) -> Any:
            return apply_process(function(env), tuple([argument(env) for argument in arguments]), span)

    def check(env: Env) -> Process:
        found = value(env)
        if type(found) not in PROCESS_TYPES:
            raise Failure(messages.wrong_kind("a process", found, span))
        return found  # type: ignore[no-any-return]

    return check
