"""Deadlock freedom, divergence freedom, and the possession of a trace.

The first two are read off an exploration of the process. They are not properties of traces: STOP has no trace that
another process lacks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from cspcheck.checker.arrays import BoolArray
from cspcheck.checker.checks.context import Context, reached
from cspcheck.checker.checks.reduced import reduced_search, what_is_kept
from cspcheck.checker.checks.reducing import as_they_are, model_for, reduced
from cspcheck.checker.checks.store import FIRST_LOOK, Aim
from cspcheck.checker.checks.trace_runs import Along, Offers, along_original, chain
from cspcheck.checker.explain.behaviour import begun, deadlocked, diverging, visible
from cspcheck.checker.explain.replay import can_perform, can_refuse
from cspcheck.checker.network.network import Network
from cspcheck.checker.search.exploration import Exploration
from cspcheck.checker.search.paths import PathStep, shortest_path
from cspcheck.checker.semantics.steps import Row
from cspcheck.checker.specification.normal_form import FailuresModel, NormalModel
from cspcheck.checker.verdict import TERMINATES, Counterexample, CounterexampleKind, Outcome, Verdict
from cspcheck.cspm.process.events import TICK
from cspcheck.cspm.process.terms import Process


def deadlock_free(context: Context, process: Process, model: FailuresModel) -> Outcome:
    """Whether no reachable stable state refuses everything; to have terminated is not a deadlock.

    In FD a divergence counts as a deadlock, since a process that diverges may never do anything again; in F only the
    stable states are looked at. Of a deadlock and a divergence after the same trace the deadlock is shown.
    """
    divergence_counts = model == "FD"
    aim: Aim = "deadlock or divergence" if divergence_counts else "deadlock"
    exploration = context.machines.first_look(process, aim, context.budget)
    if exploration is None:
        outcome = reduced_search(context, process, aim)
        if outcome is not None and outcome.verdict is Verdict.FAIL:
            exploration = context.machines.second_look(process, aim, context.budget)
        if outcome is not None and exploration is None:
            ends = outcome.verdict is Verdict.PASS and may_terminate(context.machines.network(process, context.budget))
            return replace(outcome, remarks=(*outcome.remarks, TERMINATES)) if ends else outcome
        exploration = exploration or searched_on(context, process, aim)
    levels = (exploration.deadlock_level, exploration.divergence_level if divergence_counts else None)
    level = min((level for level in levels if level is not None), default=None)
    if level is None:
        found = context.not_found(exploration, "deadlock or divergence" if divergence_counts else "deadlock")
        if found.verdict is not Verdict.PASS or not may_terminate(exploration.packed.network):
            return found
        return replace(found, remarks=(*found.remarks, TERMINATES))
    context.rely_on(level)
    context.failed(*context.covered(exploration, level))
    deadlocks = exploration.deadlocked(level)
    cycles = exploration.tau_cyclic(level) if divergence_counts else deadlocks[:0]
    goals = np.concatenate([deadlocks, cycles])
    path = shortest_path(exploration, goals, np.repeat(np.arange(2), [len(deadlocks), len(cycles)]))
    end = reached(exploration, path)
    is_deadlock = end in deadlocks
    shown = exploration
    kind: CounterexampleKind = "deadlock" if is_deadlock else "divergence"
    counterexample = begun(kind, process, exploration.packed, path, context.events)
    context.failed(*context.covered(exploration, level), counterexample)
    along = _along_original(context, process, exploration, path, (lambda row: not row) if is_deadlock else None)
    if along is not None:
        last, shown = along.pairs.depth, along.pairs
        path = along.path(shown.deadlocked(last) if is_deadlock else shown.tau_cyclic(last))
        end = reached(shown, path)
    if is_deadlock:
        counterexample = deadlocked(process, shown.packed, path, context.events)
    else:
        counterexample = diverging(process, shown, path, end, context.events)
    return context.budget.outcome(Verdict.FAIL, None, *context.covered(exploration, level), counterexample)


def searched_on(context: Context, process: Process, aim: Aim) -> Exploration:
    """The exploration of a process as it is, by partial order if the assertion wishes that."""
    packed = context.machines.packed(process, context.budget)
    kept = context.kept(packed, what_is_kept(packed, aim))
    exploration = context.machines.exploration(process, aim, context.budget, kept=kept)
    context.searched_by(exploration)
    return exploration


def may_terminate(network: Network) -> bool:
    """Whether a rule ends in a tick that all of its components can give some time; no search says that they do."""
    ends = [rule for rule in network.rules if rule.result == TICK]
    alphabets = {slot: set(network.slots[slot].lts.alphabet()) for rule in ends for slot, _ in rule.moves}
    return any(all(label in alphabets[slot] for slot, label in rule.moves) for rule in ends)


def divergence_free(context: Context, process: Process) -> Outcome:
    """Whether no reachable state has an infinite path of taus. The same in every model."""
    exploration = context.machines.first_look(process, "divergence", context.budget)
    if exploration is None:
        outcome = reduced_search(context, process, "divergence")
        if outcome is not None:
            return outcome
        exploration = searched_on(context, process, "divergence")
    if exploration.divergence_level is None:
        return context.not_found(exploration, "divergence")
    return divergence_found(context, process, exploration, exploration.divergence_level)


def divergence_found(context: Context, process: Process, exploration: Exploration, level: int) -> Outcome:
    """The failure of a process that can diverge, first on *level*."""
    context.rely_on(level)
    counts = context.covered(exploration, level)
    context.failed(*counts)
    path = shortest_path(exploration, exploration.tau_cyclic(level))
    context.failed(*counts, begun("divergence", process, exploration.packed, path, context.events))
    shown = exploration
    along = _along_original(context, process, exploration, path)
    if along is not None:
        shown = along.pairs
        path = along.path(shown.tau_cyclic(shown.depth))
    counterexample = diverging(process, shown, path, reached(shown, path), context.events)
    return context.budget.outcome(Verdict.FAIL, None, *counts, counterexample)


def _along_original(
    context: Context,
    process: Process,
    exploration: Exploration,
    path: tuple[PathStep, ...],
    goal: Callable[[Row], bool] | None = None,
) -> Along | None:
    """The states of the components that the script has after the trace of a path with compressed ones."""
    if not exploration.packed.network.is_compressed:
        return None
    return along_original(context, process, visible(path), "FD", goal)


def has_trace(context: Context, process: Process, trace: Sequence[int], model: NormalModel) -> Outcome:
    """Whether *process* can perform *trace*; in F and FD also that it cannot refuse it at any step.

    A step is refused where a state after the events before it can be relied on for other events only. In F a process
    that only diverges there refuses nothing; in FD a divergence before the end of the trace is a failure too, since
    nothing can be relied on after it. What happens after the whole trace does not matter.
    """
    if context.machines.reduces:
        # Laid out under the limits of the assertion; only the pairs are few.
        context.machines.packed(process, context.budget)
        few = replace(context, budget=context.budget.narrowed(FIRST_LOOK))
        along = Along(few, process, trace, model, beyond=False)
        outcome = _along(context, along, trace, model)
        if outcome is None:
            outcome = _has_trace_reduced(context, process, trace, model)
        if outcome is not None:
            return outcome
    along = Along(context, process, trace, model, beyond=False)
    return _along(context, along, trace, model) or context.not_found(along.pairs, "refusal of the trace")


def _along(context: Context, along: Along, trace: Sequence[int], model: NormalModel) -> Outcome | None:
    """The outcome by what a process does along a trace; None where its states are not all there and none refuses."""
    pairs, budget = along.pairs, context.budget
    counts = int(pairs.levels[-1]), pairs.transitions

    def failed(length: int) -> None:
        context.rely_on(length)
        context.failed(*counts)

    for length, event in enumerate(trace):
        if length > pairs.depth:
            break
        obstacle = _obstacle(along, length, event, model, partial(failed, length))
        if obstacle is not None:
            context.failed(*counts, obstacle)
            if pairs.packed.network.is_compressed:
                original = along_original(context, along.process, trace[:length], "FD")
                obstacle = (original and _obstacle(original, length, event, model)) or obstacle
            return budget.outcome(Verdict.FAIL, None, *counts, obstacle)
    return context.not_found(pairs, "refusal of the trace") if pairs.complete else None


def _has_trace_reduced(context: Context, process: Process, trace: Sequence[int], model: NormalModel) -> Outcome | None:
    """The outcome from a process reduced for this question; None where that does not tell."""
    machines, budget = context.machines, context.budget
    packed = machines.packed(process, budget)
    small = reduced(packed.network, model_for(packed, model), as_they_are, budget)
    if small is None:
        return None
    form = chain(trace, model, beyond=False)
    pairs = machines.pairs_of(small.packed, form, model, budget, full=True, at_hand=True)
    if not pairs.complete:
        return None
    counts = small.counts(pairs)
    for length, event in enumerate(trace):
        if length > pairs.depth:
            break
        offers = Offers(pairs, np.arange(pairs.levels[length], pairs.levels[length + 1]))
        impossible = not offers.performers(event).any()
        refuses = model != "T" and bool(offers.refusers(event).any())
        if impossible or refuses or (model == "FD" and len(pairs.tau_cyclic(length))):
            context.failed(*counts)
            goal = can_refuse(event) if offers.refusers(event).any() else None
            whole = along_original(context, process, trace[:length], "FD", goal)
            obstacle = whole and _obstacle(whole, length, event, model)
            return budget.outcome(Verdict.FAIL, None, *counts, obstacle) if obstacle else None
    return budget.outcome(Verdict.PASS, None, *counts)


def _obstacle(
    along: Along, length: int, event: int, model: NormalModel, found: Callable[[], None] = lambda: None
) -> Counterexample | None:
    """Why *event* may not happen after the first *length* events of the trace; *found* is called before it is told."""
    offers = along.offers(length)
    refusing = offers.refusers(event)
    impossible = not offers.performers(event).any()
    if refusing.any() and (impossible or model != "T"):
        found()
        return _refusal(along, offers, refusing, event)
    if model == "FD":
        cycles = along.pairs.tau_cyclic(length)
        if len(cycles):
            found()
            path = along.path(cycles)
            end = reached(along.pairs, path)
            return diverging(along.process, along.pairs, path, end, along.events)
    if not impossible:
        return None
    found()
    return _refusal(along, offers, ~refusing, event)


def _refusal(along: Along, offers: Offers, here: BoolArray, event: int) -> Counterexample:
    """A run to one of the states *here*, which refuse *event* or, where none can be relied on, cannot perform it."""
    behaviour = along.behaviour(offers.indices[here])
    if (here & offers.settled).any():
        behaviour.confirm(can_refuse(event), "a state that refuses the next event")
    else:
        behaviour.confirm(lambda row: not can_perform(event)(row), "a state that cannot perform the next event")
    name = along.events.name(event)
    return Counterexample(
        "refusal",
        behaviour.trace,
        behaviour.causes,
        event=name,
        refusal=(name,),
        allowed=(behaviour.names(offers.possible),),
        components=behaviour.components(),
        run=behaviour.run,
    )
