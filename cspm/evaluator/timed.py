"""Timed sections: what their forms mean in terms of ``tock`` (the table of the language facts, row by row).

``a -> P`` waits for a: ``X = tock -> X [] a -> tock^f(a) -> P``. STOP and SKIP let time pass; choices, interrupts and
every parallel operator synchronise on ``tock``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from cspcheck.cspm.evaluator.builtins import Builtin
from cspcheck.cspm.evaluator.builtins_processes import prioritise
from cspcheck.cspm.evaluator.frames import Timing
from cspcheck.cspm.process import terms as process
from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.definitions import Definition
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import Process, Reference
from cspcheck.cspm.source import Span
from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.dots import Event
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.sets import EventsSet
from cspcheck.cspm.values.thunks import Code, Env
from cspcheck.cspm.values.values import Sequence as SequenceValue

if TYPE_CHECKING:
    from cspcheck.cspm.evaluator.core import Evaluator


def tocks(timing: Timing) -> EventSet:
    """``{tock}``."""
    number = timing.event.number
    return EventSet(((number, number + 1),))


def timed_stop(timing: Timing) -> Process:
    """``TSTOP = tock -> TSTOP``."""
    tock = timing.event.number

    def body() -> Process:
        return prefix(tock, stop)

    stop = Reference(("timed STOP", timing.tock), Definition("STOP", None, body))
    return stop


def timed_skip(timing: Timing) -> Process:
    """``TSKIP = tock -> TSKIP [] SKIP``."""
    tock = timing.event.number

    def body() -> Process:
        return process.ExternalChoice((prefix(tock, skip), process.SKIP))

    skip = Reference(("timed SKIP", timing.tock), Definition("SKIP", None, body))
    return skip


def after_tocks(timing: Timing, count: Any, then: Process, span: Span | None = None) -> Process:
    """``tock -> ... -> then`` with *count* tocks."""
    if type(count) is not int:
        raise Failure(messages.wrong_kind("a number", count, span))
    if count < 0:
        raise Failure(messages.negative_duration(count, span))
    tock = timing.event.number
    for _ in range(count):
        then = prefix(tock, then)
    return then


def timed_prefix(
    evaluator: Evaluator, timing: Timing, env: Env, branches: Sequence[tuple[int, Process]], span: Span
) -> Process:
    """``X = tock -> X [] a -> tock^f(a) -> P [] ...``; without branches ``TSTOP``."""
    if not branches:
        return timed_stop(timing)
    waits = [1] * len(branches)
    if timing.duration is not None:
        from cspcheck.cspm.evaluator.routines import apply

        function = timing.duration(env[: timing.size])
        waits = [apply(function, (evaluator.channels.event(event),), span) for event, _ in branches]
    offered = process.Prefix(
        tuple(
            [
                (event, after_tocks(timing, count, then, span))
                for (event, then), count in zip(branches, waits, strict=True)
            ]
        )
    )
    tock = timing.event.number

    def body() -> Process:
        if all(event != tock for event, _ in offered.branches):
            return process.Prefix(tuple(sorted((*offered.branches, (tock, waiting)), key=_event)))
        return process.ExternalChoice((prefix(tock, waiting), offered))

    def text() -> str:
        from cspcheck.cspm.process.text import describe

        return describe(offered, evaluator.channels.table)

    waiting = Reference(("timed prefix", timing.tock, offered), Definition(text, span, body))
    return waiting


def _event(branch: tuple[int, Process]) -> int:
    return branch[0]


def timed_name(evaluator: Evaluator, name: str, timing: Timing) -> Code | None:
    """What a built-in name means in a Timed section, if it means something else there than outside."""
    if name == "STOP":
        return lambda env: timed_stop(timing)
    if name == "SKIP":
        return lambda env: timed_skip(timing)
    if name == "WAIT":
        wait = Builtin("WAIT", "v", lambda n: after_tocks(timing, n, timed_skip(timing)), timing.tock)
        return lambda env: wait
    if name == "timed_priority":

        def priority(p: Process) -> Process:
            levels = SequenceValue.of([EventsSet.of(EventSet(), evaluator.channels), _tock_set(timing.event)])
            return prioritise(p, levels)

        function = Builtin("timed_priority", "p", priority, timing.tock)
        return lambda env: function
    return None


def _tock_set(event: Event) -> Any:
    return EventsSet.of_numbers((event.number,), event.channels)
