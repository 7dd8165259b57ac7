"""Names: local variables, definitions at the top of a unit, channels and constructors, what is built in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cspcheck.cspm.evaluator.core import (
    DELAYED,
    PROCESS_TYPES,
    PROCESSES,
    VALUES,
    Evaluator,
)
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.evaluator.routines import Routine, passed
from cspcheck.cspm.evaluator.timed import timed_name
from cspcheck.cspm.interruption import Stopped
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.thunks import Code, Env, Thunk


@VALUES(syntax.Name)
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
        except (Failure, RecursionError, Stopped) as error:
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


@PROCESSES(syntax.Name)
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


@DELAYED(syntax.Name)
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
