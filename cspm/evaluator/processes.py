"""The process operators: each form becomes its term of ``cspcheck.cspm.process.terms``."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from cspcheck.cspm.evaluator.comprehensions import collect_processes
from cspcheck.cspm.evaluator.core import PROCESSES, VALUES, Evaluator
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.evaluator.timed import timed_stop, tocks
from cspcheck.cspm.process import terms as process
from cspcheck.cspm.process.construction import external_choice, hide, rename
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values import dots, messages as messages
from cspcheck.cspm.values.dots import Dotted, Event
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.sets import LARGEST
from cspcheck.cspm.values.thunks import Env

ProcessCode = Callable[[Env], Process]
NO_EVENTS = EventSet()


@PROCESSES(syntax.Guard)
@VALUES(syntax.Guard)
def _guard(evaluator: Evaluator, node: syntax.Guard, frame: Frame) -> ProcessCode:
    condition = evaluator.condition(node.condition, frame)
    body = evaluator.process(node.body, frame)
    timing = frame.timing
    if timing is not None:
        return lambda env: body(env) if condition(env) else timed_stop(timing)
    return lambda env: body(env) if condition(env) else process.STOP


def chain(node: syntax.ProcessBinary) -> list[syntax.Expr]:
    """The operands of a chain of one operator: ``P [] Q [] R`` has three."""
    operands: list[syntax.Expr] = []
    stack: list[syntax.Expr] = [node]
    while stack:
        current = syntax.bare(stack.pop())
        if isinstance(current, syntax.ProcessBinary) and current.operator == node.operator:
            stack += (current.right, current.left)
        else:
            operands.append(current)
    return operands


@PROCESSES(syntax.ProcessBinary)
@VALUES(syntax.ProcessBinary)
def _binary(evaluator: Evaluator, node: syntax.ProcessBinary, frame: Frame) -> ProcessCode:
    timing = frame.timing
    if node.operator in ("[]", "|~|", "|||"):
        codes = [evaluator.process(operand, frame) for operand in chain(node)]

        def operands(env: Env) -> tuple[Process, ...]:
            return tuple([code(env) for code in codes])

        if node.operator == "|~|":
            return lambda env: process.InternalChoice(operands(env))
        if node.operator == "[]":
            if timing is not None:
                return lambda env: process.SynchronisingChoice(tocks(timing), operands(env))
            return lambda env: external_choice(operands(env))
        if timing is not None:
            return lambda env: _parallel(evaluator, tocks(timing), operands(env))
        return lambda env: _parallel(evaluator, NO_EVENTS, operands(env))
    left = evaluator.process(node.left, frame)
    right = evaluator.process(node.right, frame)
    match node.operator:
        case ";":
            return lambda env: process.Sequential(left(env), right(env))
        case "[>":
            return lambda env: process.SlidingChoice(left(env), right(env))
        case _:
            if timing is not None:
                return lambda env: process.SynchronisingInterrupt(left(env), tocks(timing), right(env))
            return lambda env: process.Interrupt(left(env), right(env))


def _parallel(evaluator: Evaluator, events: EventSet, operands: tuple[Process, ...]) -> Process:
    """Parallel composition on one set of events is associative: what is composed in place becomes one level."""
    if any(type(operand) is process.Parallel and operand.events == events for operand in operands):
        flat: list[Process] = []
        for operand in operands:
            if isinstance(operand, process.Parallel) and operand.events == events:
                flat.extend(operand.operands)
            else:
                flat.append(operand)
        operands = tuple(flat)
    return process.Parallel(events, operands, evaluator.channels.table.clocks)


def _with_tock(events: Callable[[Env], EventSet], frame: Frame) -> Callable[[Env], EventSet]:
    """A synchronisation set as written, and in a Timed section tock with it."""
    timing = frame.timing
    if timing is None:
        return events
    return lambda env: events(env) | tocks(timing)


@PROCESSES(syntax.Synchronised)
@VALUES(syntax.Synchronised)
def _synchronised(evaluator: Evaluator, node: syntax.Synchronised, frame: Frame) -> ProcessCode:
    left = evaluator.process(node.left, frame)
    right = evaluator.process(node.right, frame)
    written = evaluator.events(node.events, frame)
    events = _with_tock(written, frame)
    match node.operator:
        case "[|":
            return lambda env: _parallel(evaluator, events(env), (left(env), right(env)))
        case "[+":
            return lambda env: process.SynchronisingChoice(events(env), (left(env), right(env)))
        case "/+":
            return lambda env: process.SynchronisingInterrupt(left(env), events(env), right(env))
        case _:
            return lambda env: process.Throw(left(env), written(env), right(env))


@PROCESSES(syntax.AlphabetisedParallel)
@VALUES(syntax.AlphabetisedParallel)
def _alphabetised(evaluator: Evaluator, node: syntax.AlphabetisedParallel, frame: Frame) -> ProcessCode:
    left = evaluator.process(node.left, frame)
    right = evaluator.process(node.right, frame)
    left_events = _with_tock(evaluator.events(node.left_alphabet, frame), frame)
    right_events = _with_tock(evaluator.events(node.right_alphabet, frame), frame)

    def run(env: Env) -> Process:
        alphabets = (left_events(env), right_events(env))
        return process.AlphabetisedParallel(alphabets, (left(env), right(env)), evaluator.channels.table.clocks)

    return run


@PROCESSES(syntax.Hide)
@VALUES(syntax.Hide)
def _hide(evaluator: Evaluator, node: syntax.Hide, frame: Frame) -> ProcessCode:
    inner = evaluator.process(node.process, frame)
    events = evaluator.events(node.events, frame)
    if node.keep:
        return lambda env: process.Project(inner(env), events(env))
    return lambda env: hide(inner(env), events(env))


# --- renaming and linking ------------------------------------------------------------------------------------


def _pair_events(left: Any, right: Any, span: Span) -> list[tuple[int, int]]:
    """The events of a pair: of incomplete ones, each completion with the same completion of the other."""
    for value in (left, right):
        if type(value) is not Event and not (type(value) is Dotted and value.head.is_channel and not value.complete):
            raise Failure(messages.wrong_kind("an event", value, span))
    if type(left) is Event and type(right) is Event:
        return [(left.number, right.number)]
    if type(left) is Event:
        raise Failure(messages.incomplete_event(right, span))
    found: list[tuple[int, int]] = []
    try:
        plain = all(type(v) is Dotted and not (v.fields and dots.is_incomplete(v.fields[-1])) for v in (left, right))
        if plain:
            missing = [domain.canonical() for domain in dots.missing(left)]
            if missing == [domain.canonical() for domain in dots.missing(right)]:
                return list(zip(_numbers(left), _numbers(right), strict=True))
        for parts in dots.extension_parts(left):
            old = dots.joined(left, parts)
            new = dots.joined(right, parts)
            if type(new) is not Event:
                raise Failure(messages.incomplete_event(new, span))
            found.append((old.number, new.number))
    except Failure as failure:
        failure.at(span)
        raise
    return found


def _numbers(value: Dotted) -> Iterable[int]:
    completions = dots.completions(value)
    if completions.exceeds(LARGEST):
        raise Failure(messages.too_many_completions(value, LARGEST), is_limit=True)
    return () if completions.is_empty() else completions.events  # type: ignore[attr-defined]


def _pairs(
    evaluator: Evaluator,
    pairs: tuple[tuple[syntax.Expr, syntax.Expr], ...],
    statements: tuple[syntax.Statement, ...] | None,
    frame: Frame,
) -> Callable[[Env], list[tuple[int, int]]]:
    """Code for the event pairs of a renaming or a list of links."""

    def innermost(inside: Frame) -> Callable[[Env], list[tuple[int, int]]]:
        codes = [
            (evaluator.value(left, inside), evaluator.value(right, inside), left.span.to(right.span))
            for left, right in pairs
        ]

        def run(env: Env) -> list[tuple[int, int]]:
            found: list[tuple[int, int]] = []
            for left, right, span in codes:
                found.extend(_pair_events(left(env), right(env), span))
            return found

        return run

    if not statements:
        return innermost(frame)
    each = collect_processes(evaluator, statements, frame, innermost)
    return lambda env: [pair for found in each(env) for pair in found]


@PROCESSES(syntax.Rename)
@VALUES(syntax.Rename)
def _rename(evaluator: Evaluator, node: syntax.Rename, frame: Frame) -> ProcessCode:
    inner = evaluator.process(node.process, frame)
    pairs = _pairs(evaluator, node.pairs, node.statements, frame)
    return lambda env: rename(inner(env), pairs(env))


def _links(evaluator: Evaluator, found: list[tuple[int, int]], span: Span) -> tuple[tuple[int, int], ...]:
    """Links in order; each event once on its side, and a link written twice counts once."""
    links = tuple(sorted(set(found)))
    for side, name in ((0, "left"), (1, "right")):
        seen: set[int] = set()
        for link in links:
            if link[side] in seen:
                raise Failure(messages.linked_twice(evaluator.channels.event(link[side]), name, span))
            seen.add(link[side])
    return links


def _link(evaluator: Evaluator, left: Process, pairs: list[tuple[int, int]], right: Process, span: Span) -> Process:
    return process.LinkedParallel(left, _links(evaluator, pairs, span), right, evaluator.channels.table.clocks)


@PROCESSES(syntax.LinkedParallel)
@VALUES(syntax.LinkedParallel)
def _linked(evaluator: Evaluator, node: syntax.LinkedParallel, frame: Frame) -> ProcessCode:
    left = evaluator.process(node.left, frame)
    right = evaluator.process(node.right, frame)
    pairs = _pairs(evaluator, node.links, node.statements, frame)
    span = node.span
    return lambda env: _link(evaluator, left(env), pairs(env), right(env), span)


# --- replicated operators ------------------------------------------------------------------------------------


@PROCESSES(syntax.Replicated)
@VALUES(syntax.Replicated)
def _replicated(evaluator: Evaluator, node: syntax.Replicated, frame: Frame) -> ProcessCode:
    if node.operator == "||":
        return _replicated_alphabetised(evaluator, node, frame)
    if node.operator == "<->":
        return _replicated_links(evaluator, node, frame)
    timing = frame.timing
    operands = collect_processes(evaluator, node.statements, frame, lambda inside: evaluator.process(node.body, inside))
    span = node.span
    stop: ProcessCode = lambda env: process.STOP if timing is None else timed_stop(timing)  # noqa: E731
    match node.operator:
        case "[]":
            if timing is None:
                return lambda env: external_choice(operands(env))
            clock = timing
            return _joined(lambda env: tocks(clock), operands, process.SynchronisingChoice, stop)
        case "|~|":

            def choose(env: Env) -> Process:
                found = operands(env)
                if not found:
                    raise Failure(messages.empty_internal_choice("this `|~|`", span))
                return found[0] if len(found) == 1 else process.InternalChoice(tuple(found))

            return choose
        case ";":
            return _sequence(operands, frame)
        case "[+":
            assert node.events is not None
            events = _with_tock(evaluator.events(node.events, frame), frame)
            return _joined(events, operands, process.SynchronisingChoice, stop)
        case "[|":
            assert node.events is not None
            events = _with_tock(evaluator.events(node.events, frame), frame)
        case _:
            events = (lambda env: NO_EVENTS) if timing is None else (lambda env: tocks(timing))
    nothing: ProcessCode = (lambda env: process.SKIP) if timing is None else stop
    return _joined(events, operands, partial(_parallel, evaluator), nothing)


def _joined(
    events: Callable[[Env], EventSet],
    operands: Callable[[Env], list[Process]],
    operator: Callable[[EventSet, tuple[Process, ...]], Process],
    nothing: ProcessCode,
) -> ProcessCode:
    def join(env: Env) -> Process:
        shared = events(env)
        found = operands(env)
        if not found:
            return nothing(env)
        return found[0] if len(found) == 1 else operator(shared, tuple(found))

    return join


def _sequence(operands: Callable[[Env], list[Process]], frame: Frame) -> ProcessCode:
    from cspcheck.cspm.evaluator.timed import timed_skip

    timing = frame.timing

    def run(env: Env) -> Process:
        found = operands(env)
        if not found:
            return process.SKIP if timing is None else timed_skip(timing)
        result = found.pop()
        while found:
            result = process.Sequential(found.pop(), result)
        return result

    return run


def _replicated_links(evaluator: Evaluator, node: syntax.Replicated, frame: Frame) -> ProcessCode:
    """A chain: each process is linked to the chain behind it, by the links that its values of the variables give.

    Those of the last process link nothing and are not looked at: ``[c.i <-> c.(i + 1)]`` may lead out of the channel.
    """
    span = node.span

    def innermost(inside: Frame) -> Callable[[Env], tuple[Process, Callable[[], list[tuple[int, int]]]]]:
        body = evaluator.process(node.body, inside)
        pairs = _pairs(evaluator, node.links, node.link_statements, inside)
        return lambda env: (body(env), lambda: pairs(env))

    members = collect_processes(evaluator, node.statements, frame, innermost)

    def chain(env: Env) -> Process:
        found = members(env)
        if not found:
            raise Failure(messages.empty_linked_parallel(span))
        result: Process = found.pop()[0]
        while found:
            left, pairs = found.pop()
            result = _link(evaluator, left, pairs(), result, span)
        return result

    return chain


def _replicated_alphabetised(evaluator: Evaluator, node: syntax.Replicated, frame: Frame) -> ProcessCode:
    assert node.events is not None
    written = node.events
    timing = frame.timing

    def innermost(inside: Frame) -> Callable[[Env], tuple[EventSet, Process]]:
        events = _with_tock(evaluator.events(written, inside), inside)
        body = evaluator.process(node.body, inside)
        return lambda env: (events(env), body(env))

    each = collect_processes(evaluator, node.statements, frame, innermost)

    def run(env: Env) -> Process:
        found = each(env)
        if not found:
            return process.SKIP if timing is None else timed_stop(timing)
        alphabets, operands = zip(*found, strict=True)
        return process.AlphabetisedParallel(tuple(alphabets), tuple(operands), evaluator.channels.table.clocks)

    return run
