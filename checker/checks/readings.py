"""Verdicts about processes that a search under finite readings has not followed to their ends.

A class that demands a value outside the finite reading of its type goes on in a way that the search does not know
(:class:`cspcheck.cspm.process.terms.Beyond`). Where such a state is reachable, what the search saw is a part of the
behaviour: what happened in it is real, but nothing that it lacks proves anything.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final, Literal

import numpy as np

from cspcheck.checker.budget import Budget, Incomplete
from cspcheck.checker.checks.context import CHUNK
from cspcheck.checker.network.compiler import LimitReached, compile_network
from cspcheck.checker.network.network import Network
from cspcheck.checker.packing.packed import pack
from cspcheck.checker.search.exploration import explore
from cspcheck.checker.semantics.menus import unlike_menus
from cspcheck.checker.verdict import Outcome, Verdict
from cspcheck.cspm.process.terms import Beyond, Process

MARK: Final = "beyond the finite reading"
"""How the text of a state that was left begins (``cspcheck.cspm.process.text``)."""


def left_in(term: Process) -> Beyond | None:
    """What lies beyond the readings in a state; None if nothing does."""
    waiting, seen = [term], {term}
    while waiting:
        part = waiting.pop()
        if isinstance(part, Beyond):
            return part
        for operand in part.active():
            if operand not in seen:
                seen.add(operand)
                waiting.append(operand)
    return None


def first_left(process: Process, budget: Budget) -> str | None:
    """What the first state that leaves the readings demands; None if no reachable state does.

    The process is explored without reductions, which could take such a state for one that is merely stuck.

    Raises:
        Incomplete: a limit was reached before that was known.
    """
    try:
        network = compile_network(process, budget.limits, poll=lambda _: budget.check_time("looking beyond"))
    except LimitReached as reached:
        raise Incomplete(budget.too_many_terms(reached), reached.states) from None
    left = _slots_left(network)
    if not left:
        return None
    packed = pack(network)
    exploration = explore(packed, limits=budget.remaining(), look_for_divergence=False)
    best: tuple[int, str] | None = None
    for slot, reports in left.items():
        field = packed.layout.slots[slot]
        numbers = np.array(sorted(reports), dtype=np.int64)
        for start in range(0, exploration.levels[-1], CHUNK):
            until = min(exploration.levels[-1], start + CHUNK)
            if best is not None and start > best[0]:
                break
            words = exploration.states_at(slice(start, until))[:, field.word]
            local = words >> field.shift & (1 << field.width) - 1
            found = np.flatnonzero(np.isin(local, numbers))
            if len(found):
                state = start + int(found[0])
                if best is None or state < best[0]:
                    best = (state, reports[int(local[found[0]])])
                break
    if best is None and not exploration.complete:
        raise Incomplete(budget.reached(exploration), exploration.levels[-1], exploration.transitions)
    return None if best is None else best[1]


def _slots_left(network: Network) -> dict[int, dict[int, str]]:
    """By slot, the local states that leave the readings, with what they demand."""
    found: dict[int, dict[int, str]] = {}
    for number, slot in enumerate(network.slots):
        for local, term in unlike_menus(slot.terms):
            left = left_in(term)
            if left is not None:
                found.setdefault(number, {})[local] = left.report
    return found


Trace = Literal["no", "possible", "reliable"]
"""Whether the assertion is that a trace can be performed, and whether it must be possible to rely on it."""


def held_against_readings(
    outcome: Outcome,
    implementation: Process,
    specification: Process | None,
    budget: Budget,
    *,
    traces: bool = False,
    trace: Trace = "no",
) -> Outcome:
    """The outcome, or ``unknown`` where it depends on what lies beyond the finite readings.

    Args:
        outcome: of the search.
        implementation, specification: what it is about.
        budget: what is left of it.
        traces: a refinement is one of traces.
        trace: what is claimed of a trace, if that is the assertion.
    """
    for process in _doubtful(outcome, implementation, specification, traces, trace):
        try:
            report = first_left(process, budget)
        except Incomplete as incomplete:
            report = f"it is not known whether the finite readings are left: {incomplete.reason}"
        if report is not None:
            return replace(outcome, verdict=Verdict.UNKNOWN, reason=report, counterexample=None)
    return outcome


def _doubtful(
    outcome: Outcome, implementation: Process, specification: Process | None, traces: bool, trace: Trace
) -> Iterator[Process]:
    """The processes of which the search must have seen everything for the verdict to be right."""
    found = outcome.counterexample
    if outcome.verdict is Verdict.PASS:
        if trace != "possible":
            yield implementation
        if traces:
            return  # what the specification is not known to do it was not needed for
    elif outcome.verdict is Verdict.FAIL:
        # What a process did, it can do; what it refuses it refuses where the state at hand is known to its end.
        known = found is not None and (
            found.kind in ("trace", "divergence")
            or (bool(found.components) and not any(MARK in component.state for component in found.components))
        )
        if trace != "no" or not known:
            yield implementation
    else:
        return
    if specification is not None:
        yield specification
