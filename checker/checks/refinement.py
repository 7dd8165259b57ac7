"""Refinement in the models T, F and FD: a search for a behaviour of the implementation that the specification lacks.

Roscoe, Understanding Concurrent Systems, section 8.4: the specification is normalised, and the pairs of its nodes and
the implementation's states that common traces lead to are searched breadth first.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from cspcheck.checker.budget import Incomplete
from cspcheck.checker.checks.by_steps import BEFORE_STEPS, pairs_by_steps, with_taus
from cspcheck.checker.checks.context import Context, reached
from cspcheck.checker.checks.reducing import Reduced, as_they_are, model_for, reduced
from cspcheck.checker.checks.store import FIRST_LOOK, Specification
from cspcheck.checker.checks.trace_runs import along_original
from cspcheck.checker.explain.behaviour import Behaviour, begun, diverging, visible
from cspcheck.checker.explain.replay import ReplayFailure, can_perform, states_after
from cspcheck.checker.explain.specification_run import specification_run
from cspcheck.checker.explain.unfolding import NotUnfolded, unfolded
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.pair_search import PairExploration, Violation
from cspcheck.checker.search.paths import PathStep, shortest_path
from cspcheck.checker.semantics.steps import Row
from cspcheck.checker.semantics.transitions import offer
from cspcheck.checker.specification.normal_form import NormalForm, NormalModel
from cspcheck.checker.verdict import BY_STEPS, Counterexample, Outcome, Verdict
from cspcheck.cspm.process.events import TICK
from cspcheck.cspm.process.terms import Process

REPLAYED_SPECIFICATION = 2_000
"""A counterexample is also held against the specification's terms if no more states than this must be looked at."""


def refines(context: Context, specification: Process, model: NormalModel, implementation: Process) -> Outcome:
    """Whether ``specification [model= implementation``.

    States and transitions count the pairs of the search. Of several violations after the first violating trace an
    event that is not allowed is shown rather than a refusal, and a refusal rather than a divergence.

    Raises:
        Incomplete: the specification could not be explored as far as the implementation follows it.
    """
    machines, budget = context.machines, context.budget
    if machines.grows(specification, budget):
        try:
            followed = machines.followed(specification, model, implementation, budget)
            return _refines(context, specification, followed, model, implementation)
        except Incomplete:
            if budget.is_over():
                raise
    normal_form = machines.specification(specification, model, implementation, budget)
    return _refines(context, specification, normal_form, model, implementation)


def _refines(
    context: Context, specification: Process, normal_form: Specification, model: NormalModel, implementation: Process
) -> Outcome:
    """The outcome for a specification that is normalised; see :func:`refines`."""
    budget = context.budget
    pairs = None
    if context.machines.reduces:
        # Laid out under the limits of the assertion: a component may have more states than are looked at first.
        context.machines.packed(implementation, budget)
        few = budget.narrowed(FIRST_LOOK)
        pairs = context.machines.pairs(normal_form, implementation, model, few, full=False)
        if not pairs.complete and pairs.violation_level is None:
            outcome = _reduced(context, specification, normal_form, model, implementation)
            if outcome is None and pairs.depth < 0:
                # Taus lead to more states than that before the first event.
                outcome = _by_steps(context, specification, normal_form, model, implementation)
            if outcome is not None:
                return outcome
            pairs = None
    if pairs is None:
        packed = context.searched(context.machines.packed(implementation, budget), "behaviour")
        pairs = context.machines.pairs_of(packed, normal_form, model, budget, full=context.machines.full)
        context.searched_by(pairs)
    if pairs.violation_level is None:
        return context.not_found(pairs, "violation")
    counts = int(pairs.levels[-1]), pairs.transitions
    context.rely_on(pairs.violation_level)
    context.failed(*counts)
    path, violation = first_violation(pairs)
    node = int(pairs.nodes[violation.index])
    found = _Found(pairs, path, violation)
    context.failed(*counts, _begun(context, normal_form, node, implementation, found))
    if pairs.packed.network.is_compressed:
        found = _without_compression(context, normal_form, node, implementation, model, found) or found
    counterexample = _explained(context, specification, normal_form, node, implementation, found)
    return budget.outcome(Verdict.FAIL, None, *counts, counterexample)


def _reduced(
    context: Context, specification: Process, normal_form: Specification, model: NormalModel, implementation: Process
) -> Outcome | None:
    """The outcome from an implementation reduced for this question; None where that does not tell."""
    machines, budget = context.machines, context.budget
    packed = machines.packed(implementation, budget)
    small = reduced(packed.network, model_for(packed, model), as_they_are, budget)
    if small is None:
        return None
    pairs = machines.pairs_of(context.searched(small.packed, "behaviour"), normal_form, model, budget, full=False)
    context.searched_by(pairs)
    counts = small.counts(pairs)
    if pairs.violation_level is None:
        return budget.outcome(Verdict.PASS, None, *counts) if pairs.complete else None
    path, violation = first_violation(pairs)
    node = int(pairs.nodes[violation.index])
    found = _Found(pairs, path, violation)
    follow = partial(_without_compression, context, normal_form, node, implementation, model, found)
    # Who chooses among very many internal steps has to be led: a run that is unfolded is one, if not the shortest.
    whole = follow(at_hand=True) or _unfolded(packed, small, found) or follow()
    if whole is None:
        return None
    counterexample = _explained(context, specification, normal_form, node, implementation, whole)
    return budget.outcome(Verdict.FAIL, None, *counts, counterexample)


def _by_steps(
    context: Context, specification: Process, normal_form: Specification, model: NormalModel, implementation: Process
) -> Outcome | None:
    """The outcome for an event that is not allowed and only a few steps away; None where there is no such thing.

    It is not looked for where a search by events comes to the first one in time: that tells the shortest run.
    """
    packed = context.machines.packed(implementation, context.budget)
    if not isinstance(normal_form, NormalForm) or packed.network.is_compressed:
        return None
    begun = context.machines.pairs(
        normal_form, implementation, model, context.budget.narrowed(BEFORE_STEPS), full=False
    )
    if begun.complete or begun.violation_level is not None or begun.depth >= 0:
        return None
    pairs = pairs_by_steps(context.machines, normal_form, packed, context.budget)
    if pairs.violation_level is None:
        return None
    path, violation = first_violation(pairs)
    node = int(pairs.nodes[violation.index])
    found = _Found(pairs, with_taus(path, packed), violation, unfolded=packed)
    counts = int(pairs.levels[-1]), pairs.transitions
    context.failed(*counts, _begun(context, normal_form, node, implementation, found))
    counterexample = _explained(context, specification, normal_form, node, implementation, found)
    outcome = context.budget.outcome(Verdict.FAIL, None, *counts, counterexample)
    # With no event before the one that is not allowed there are no fewer, however many steps there are.
    return replace(outcome, remarks=(BY_STEPS,)) if visible(found.path) else outcome


@dataclass(frozen=True, slots=True)
class _Found:
    """A violation at the end of a path through an exploration.

    Attributes:
        exploration: where the violation was found.
        path: the path; one through *unfolded* if that is given.
        violation: the violation.
        unfolded: the network that the path goes through, if it is not that of the exploration.
    """

    exploration: PairExploration
    path: tuple[PathStep, ...]
    violation: Violation
    unfolded: PackedNetwork | None = None


def _unfolded(packed: PackedNetwork, small: Reduced, found: _Found) -> _Found | None:
    """The same violation by a run of the network that was reduced; None if there is none, or for a divergence."""
    if found.violation.kind == "divergence":
        return None
    event = found.violation.event if found.violation.kind == "trace" else None
    try:
        return replace(
            found, path=unfolded(packed, small.composition, small.packed, found.path, event), unfolded=packed
        )
    except NotUnfolded:
        return None


def _without_compression(
    context: Context,
    normal_form: Specification,
    node: int,
    implementation: Process,
    model: NormalModel,
    found: _Found,
    *,
    at_hand: bool = False,
) -> _Found | None:
    """The same violation after the same trace by components that are not compressed; None if they cannot be followed.

    Compressed or not, a process can do, refuse and diverge the same after a trace; the runs differ.
    """
    kind, event = found.violation.kind, found.violation.event
    allowed = [frozenset(acceptance) for acceptance in normal_form.acceptances(node)]

    def refuses(row: Row) -> bool:
        accepted = offer(row)
        return accepted is not None and not any(least <= accepted for least in allowed)

    goal = {"trace": can_perform(event), "refusal": refuses}.get(kind)
    along = along_original(
        context, implementation, visible(found.path), "FD" if model == "FD" else "T", goal, at_hand=at_hand
    )
    if along is None:
        return None
    length = along.pairs.depth
    offers = along.offers(length)
    if kind == "trace":
        goals = offers.indices[offers.performers(event)]
    elif kind == "divergence":
        goals = along.pairs.tau_cyclic(length)
    else:
        accepted = [offers.acceptance(place) for place in range(len(offers.indices))]
        refusing = [a is not None and not any(least <= a for least in allowed) for a in accepted]
        goals = offers.indices[np.array(refusing, dtype=np.bool_)]
    path = along.path(goals)
    return _Found(along.pairs, path, Violation(reached(along.pairs, path), kind, event))


def first_violation(pairs: PairExploration) -> tuple[tuple[PathStep, ...], Violation]:
    """The canonical path to a violation, and the violation at its end that comes first."""
    rank = {violation: _rank(violation) for violation in pairs.violations()}
    best: dict[int, int] = {}
    for violation, number in rank.items():
        best[violation.index] = min(number, best.get(violation.index, number))
    goals = np.array(sorted(best), dtype=np.int64)
    # Ranks are handed on as places in their order, since identifiers of events may be anything up to 2 ** 63.
    order = {number: place for place, number in enumerate(sorted(set(best.values())))}
    path = shortest_path(pairs, goals, np.array([order[best[index]] for index in goals.tolist()], dtype=np.int64))
    end = reached(pairs, path)
    return path, min((violation for violation in rank if violation.index == end), key=_rank)


def _rank(violation: Violation) -> int:
    """An event that is not allowed comes first, the least of them; then a refusal; then a divergence."""
    if violation.kind == "trace":
        return violation.event
    return 1 << 63 if violation.kind == "refusal" else 1 << 64


def _begun(
    context: Context, normal_form: Specification, node: int, implementation: Process, found: _Found
) -> Counterexample:
    """What is known of a violation before its run is looked at."""
    events, kind = context.events, found.violation.kind
    packed = found.unfolded or found.exploration.packed
    counterexample = begun(kind, implementation, packed, found.path, events)
    names = tuple(events.name(event) for event in visible(found.path))
    if kind != "trace":
        return replace(counterexample, specification_trace=names)
    allowed = (tuple(events.name(event) for event in sorted(normal_form.allowed(node))),)
    event = events.name(found.violation.event)
    return replace(counterexample, specification_trace=names, event=event, allowed=allowed)


def _explained(
    context: Context,
    specification: Process,
    normal_form: Specification,
    node: int,
    implementation: Process,
    found: _Found,
) -> Counterexample:
    pairs, path, violation = found.exploration, found.path, found.violation
    events = context.events
    behaviour = Behaviour(implementation, found.unfolded or pairs.packed, path, events)
    trace = visible(path)
    specification_trace = tuple(events.name(event) for event in trace)
    run = specification_run(specification, trace, events)
    if violation.kind == "trace":
        event = violation.event
        behaviour.confirm(can_perform(event), "a state with the forbidden event")
        _deny_event(specification, trace, event)
        return Counterexample(
            "trace",
            behaviour.trace,
            behaviour.causes,
            event=events.name(event),
            allowed=(behaviour.names(normal_form.allowed(node)),),
            components=behaviour.components(),
            run=behaviour.run,
            specification_trace=specification_trace,
            specification=run,
            event_parts=behaviour.parts_in(event),
        )
    if violation.kind == "divergence":
        divergence = diverging(implementation, pairs, path, violation.index, events)
        allowed = tuple(behaviour.names(acceptance) for acceptance in normal_form.acceptances(node))
        return replace(divergence, allowed=allowed, specification_trace=specification_trace, specification=run)
    offered = frozenset(pairs.successors(np.array([violation.index], dtype=np.int64)).events.tolist())
    accepted = frozenset({TICK}) if TICK in offered else offered
    acceptances = normal_form.acceptances(node)
    accepted = _offered_at_the_end(behaviour, accepted, less=found.unfolded is not None)
    _deny_acceptance(specification, trace, accepted)
    return Counterexample(
        "refusal",
        behaviour.trace,
        behaviour.causes,
        refusal=behaviour.names({event for acceptance in acceptances for event in acceptance} - accepted),
        offered=behaviour.names(accepted),
        allowed=tuple(behaviour.names(acceptance) for acceptance in acceptances),
        components=behaviour.components(),
        run=behaviour.run,
        specification_trace=specification_trace,
        specification=run,
    )


def _offered_at_the_end(behaviour: Behaviour, accepted: frozenset[int], *, less: bool) -> frozenset[int]:
    """What a behaviour offers at its end, once it has been confirmed that it is this, or perhaps *less*."""
    offered = [accepted]

    def holds(row: Row) -> bool:
        own = offer(row)
        if own is None or not (own <= accepted if less else own == accepted):
            return False
        offered.append(own)
        return True

    behaviour.confirm(holds, "a state that offers too little")
    return offered[min(1, len(offered) - 1)]  # the first of the states that are as claimed is the one that is shown


def _deny_event(specification: Process, trace: tuple[int, ...], event: int) -> None:
    rows = states_after(specification, trace, REPLAYED_SPECIFICATION)
    if rows is not None and any(label == event for row in rows for label, _ in row):
        raise ReplayFailure("the specification can perform the event that it was said not to allow")


def _deny_acceptance(specification: Process, trace: tuple[int, ...], accepted: frozenset[int]) -> None:
    rows = states_after(specification, trace, REPLAYED_SPECIFICATION)
    for row in rows or ():
        acceptance = offer(row)
        if acceptance is not None and acceptance <= accepted:
            raise ReplayFailure("the specification can refuse what it was said to offer")
