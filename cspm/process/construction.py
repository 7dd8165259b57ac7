"""Terms put together: the operators where the number of operands, or an empty set, makes them something simpler."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import NO_EVENTS, SKIP, STOP, ExternalChoice, Hide, Parallel, Prefix, Process, Rename


def prefix(event: int, process: Process) -> Process:
    """``event -> process``."""
    return Prefix(((event, process),))


def external_choice(operands: Iterable[Process]) -> Process:
    """``[]`` over *operands*: chains are flattened and STOP is dropped; none is STOP, one is itself."""
    flat: list[Process] = []
    for operand in operands:
        if isinstance(operand, ExternalChoice):
            flat.extend(operand.operands)
        elif operand is not STOP:
            flat.append(operand)
    if not flat:
        return STOP
    return flat[0] if len(flat) == 1 else ExternalChoice(tuple(flat))


def parallel(events: EventSet, operands: Sequence[Process], clocks: EventSet = NO_EVENTS) -> Process:
    """``[| events |]`` over *operands*; none is SKIP, one is itself."""
    if not operands:
        return SKIP
    return operands[0] if len(operands) == 1 else Parallel(events, tuple(operands), clocks)


def hide(process: Process, events: EventSet) -> Process:
    r"""``process \ events``; hiding nothing is the process itself."""
    return Hide(process, events) if events else process


def rename(process: Process, pairs: Iterable[tuple[int, int]]) -> Process:
    """``process [[...]]``; renaming nothing is the process itself."""
    distinct = tuple(sorted(set(pairs)))
    return Rename(process, distinct) if distinct else process
