"""Determinism: no event is ever both possible and refusable.

A process without taus in which no event leads to two states is deterministic by its form. Every other process without
divergence is held against a candidate: at each moment one of the stable states that it can be in is chosen, and for
each event one of its targets. If the process is deterministic the choice does not matter, and it refines the
candidate; if it refines the deterministic candidate, it is deterministic (Lazic 1999; Roscoe, Understanding
Concurrent Systems, section 10.5).

The candidate also tells the shortest trace with an event that is both possible and refusable: as long as there is
none, every stable state offers everything that is possible, so the candidate follows all traces; after the first
trace that has one, either the candidate's state or another one disagrees with the rest.
"""

from __future__ import annotations

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int64Array, distinct
from cspcheck.checker.budget import Incomplete
from cspcheck.checker.checks.choosing import chosen_part
from cspcheck.checker.checks.context import Context, in_chunks
from cspcheck.checker.checks.properties import divergence_found
from cspcheck.checker.checks.reduced import looked_at
from cspcheck.checker.checks.reducing import as_they_are, model_for, reduced
from cspcheck.checker.checks.state_sets import StateSets
from cspcheck.checker.checks.store import Aim
from cspcheck.checker.checks.trace_runs import Along, along_original
from cspcheck.checker.explain.behaviour import visible
from cspcheck.checker.explain.replay import can_perform, can_refuse
from cspcheck.checker.kernels.arrays import MAY_BRANCH
from cspcheck.checker.lts import Lts
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.exploration import Exploration, explore
from cspcheck.checker.search.paths import shortest_path
from cspcheck.checker.specification.acceptances import StateAcceptances
from cspcheck.checker.specification.normal_form import FailuresModel, NormalForm
from cspcheck.checker.specification.normaliser import Normaliser
from cspcheck.checker.verdict import Counterexample, Outcome, Verdict
from cspcheck.cspm.process.events import TAU, TICK
from cspcheck.cspm.process.terms import Process

Trace = tuple[int, ...]

LISTED = 4
"""So many times the size of a machine is needed to list it and to look for nondeterminism in it."""


def deterministic(context: Context, process: Process, model: FailuresModel) -> Outcome:
    """Whether there is no trace after which an event is both possible and refusable; in FD also no divergence.

    States and transitions are those of the process. In FD what comes after the first trace is shown, divergence or
    nondeterminism, and the divergence if both do; in F a divergence refuses nothing, and only the states that can be
    relied on count.
    """
    machines, budget = context.machines, context.budget
    aim: Aim = "divergence" if model == "FD" else "everything"
    exploration = machines.first_look(process, aim, budget)
    if exploration is None and machines.reduces:
        outcome = _by_rules(context, process, aim) or _reduced(context, process, model)
        if outcome is not None and outcome.verdict is Verdict.FAIL:
            exploration = machines.second_look(process, aim, budget)
        if outcome is not None and exploration is None:
            return outcome
    if exploration is None:
        exploration = machines.exploration(process, aim, budget)
    level = exploration.divergence_level
    if level is not None and model == "FD":
        if context.whole is None or level < context.whole:
            context.failed(*context.covered(exploration, level))
        return _earlier_nondeterminism(context, process, exploration, level) or divergence_found(
            context, process, exploration, level
        )
    counts = exploration.levels[-1], exploration.transitions
    if not exploration.complete:
        return _as_far_as_explored(context, process, exploration, model)
    if _by_form(exploration):
        return budget.outcome(Verdict.PASS, None, *counts)
    try:
        trace = _first_nondeterminism(context, process, exploration)
        if trace is not None:
            context.rely_on(len(trace))
            context.failed(*counts, _begun(context, trace))
        counterexample = None if trace is None else _explained(context, process, trace)
    except Incomplete as incomplete:
        raise Incomplete(incomplete.reason, *counts) from None
    return budget.outcome(Verdict.PASS if trace is None else Verdict.FAIL, None, *counts, counterexample)


def _first_nondeterminism(context: Context, process: Process, exploration: Exploration) -> Trace | None:
    """The first trace with nondeterminism of a process that has been explored to its end, or None."""
    machines, budget = context.machines, context.budget
    packed, at_hand = machines.packed(process, budget), _is_at_hand(context, exploration)
    if exploration.divergence_level is None:
        # The choices that a candidate makes are not those of another; the traces that it does not match are the same.
        chosen = (machines.lts(process, budget), None) if at_hand else chosen_part(packed, budget)
        return _against_candidate(context, packed, candidate(*chosen))
    if at_hand:
        return _by_normal_form(context, machines.lts(process, budget))
    return StateSets(packed, budget, machines.beyond).first_nondeterminism()


def _is_at_hand(context: Context, exploration: Exploration) -> bool:
    """Whether the machine that was explored is better listed: there is room, or there is nowhere else."""
    if exploration.is_partial or context.machines.beyond is None:
        return not exploration.is_partial
    left = context.budget.remaining().memory_bytes
    return left is None or left >= LISTED * (8 * exploration.levels[-1] + 16 * exploration.transitions)


def _by_rules(context: Context, process: Process, aim: Aim) -> Outcome | None:
    """A pass where the rules of the network show that there are no taus and no event with two targets, else None."""
    packed = context.machines.packed(process, context.budget)
    if packed.network.terminated or len(packed.tau.items) or (packed.rules.care & MAY_BRANCH).any():
        return None
    return context.budget.outcome(Verdict.PASS, None, *looked_at(context, process, aim))


def _reduced(context: Context, process: Process, model: FailuresModel) -> Outcome | None:
    """The outcome from a process reduced for this question; None where that does not tell."""
    budget = context.budget
    packed = context.machines.packed(process, budget)
    small = reduced(packed.network, model_for(packed, model), as_they_are, budget)
    if small is None:
        return None
    exploration = explore(small.packed, limits=budget.remaining(), workers=context.machines.workers)
    if not exploration.complete or exploration.divergence_level is not None:
        return None
    counts = small.counts(exploration)
    if _by_form(exploration):
        return budget.outcome(Verdict.PASS, None, *counts)
    try:
        trace = _against_candidate(context, small.packed, candidate(exploration.to_lts()))
        counterexample = None if trace is None else _explained(context, process, trace)
    except Incomplete:
        if budget.is_over():
            raise
        return None
    return budget.outcome(Verdict.PASS if trace is None else Verdict.FAIL, None, *counts, counterexample)


def _earlier_nondeterminism(context: Context, process: Process, exploration: Exploration, level: int) -> Outcome | None:
    """The failure by nondeterminism after a trace that comes before that of the first divergence, if there is one.

    After no trace that comes before that one does the process diverge, so that choices tell. Where there is no time
    for this the divergence has to do.
    """
    divergence = visible(shortest_path(exploration, exploration.tau_cyclic(level)))
    packed = context.machines.packed(process, context.budget)
    try:
        chosen = candidate(*chosen_part(packed, context.budget, level))
        trace = _against_candidate(context, packed, chosen, level)
        if trace is None or (len(trace), trace) >= (level, divergence):
            return None
        context.rely_on(len(trace))
        counterexample = _explained(context, process, trace)
    except Incomplete:
        return None
    return context.budget.outcome(Verdict.FAIL, None, *context.covered(exploration, level), counterexample)


def _as_far_as_explored(context: Context, process: Process, exploration: Exploration, model: FailuresModel) -> Outcome:
    """The outcome where a limit was reached: a failure if the levels that were completed show one, else unknown."""
    budget = context.budget
    counts = exploration.levels[-1], exploration.transitions
    sought = "divergence" if model == "FD" else ""
    at_hand = not exploration.is_partial and exploration.levels[-1] > 0
    if exploration.divergence_level is None and exploration.stop == "states" and at_hand:
        lts = explored_part(exploration)
        try:
            chosen = candidate(lts, np.arange(lts.states) == lts.states - 1)
            trace = _against_candidate(context, context.machines.packed(process, budget), chosen)
            # Beyond what was explored there may be a shorter trace than one that leads further.
            if trace is not None and len(trace) <= exploration.depth:
                context.rely_on(len(trace))
                context.failed(*counts, _begun(context, trace))
                counterexample = _explained(context, process, trace)
                return budget.outcome(Verdict.FAIL, None, *counts, counterexample)
            sought = "divergence or nondeterminism" if model == "FD" else "nondeterminism"
        except Incomplete:
            if context.sure.outcome is not None:
                raise
            # The search of pairs ran into the limit as well, so nothing can be said of nondeterminism.
    return budget.outcome(Verdict.UNKNOWN, budget.shortfall(exploration, sought), *counts)


def explored_part(exploration: Exploration) -> Lts:
    """The machine of the completed levels; its last state is all that is beyond them."""
    beyond = exploration.levels[-1]
    none = np.zeros(0, dtype=np.int64)
    lengths, labels, targets = [none], [none], [none]
    for chunk in in_chunks(exploration, np.arange(beyond)):
        places = exploration.indices(chunk.targets)
        places[(places < 0) | (places >= beyond)] = beyond
        lengths.append(np.diff(chunk.offsets))
        sources = np.repeat(np.arange(len(lengths[-1])), lengths[-1])
        order = np.lexsort([places, chunk.events, sources])
        labels.append(chunk.events[order])
        targets.append(places[order])
    offsets = np.concatenate([[0], *lengths, [0]]).cumsum()
    return Lts(offsets.astype(np.int64), np.concatenate(labels), np.concatenate(targets))


def _by_form(exploration: Exploration) -> bool:
    """Whether there are no taus, no event with two targets, and nothing beside a tick, as far as what is kept tells."""
    if exploration.has_tau or exploration.branching:
        return False
    if not exploration.packed.network.terminated:
        return True
    if exploration.is_partial:
        return False  # its states would have to be looked at
    for chunk in in_chunks(exploration, np.arange(exploration.levels[-1])):
        lengths = np.diff(chunk.offsets)
        if (np.repeat(lengths, lengths)[chunk.events == TICK] > 1).any():
            return False
    return True


def candidate(lts: Lts, beyond: BoolArray | None = None) -> NormalForm:
    """A deterministic process that *lts*, which must not diverge, refines in F if it is deterministic itself.

    Nodes are the stable states. From each state the first taus are followed to the one that stands for it. After
    states that are *beyond* what is known, none of which has a tau, anything is allowed.
    """
    sources = np.repeat(np.arange(lts.states), np.diff(lts.offsets))
    taus = np.flatnonzero(lts.labels == TAU)[::-1]
    stands_for = np.arange(lts.states)
    # Written backwards, so that the first tau of a state is what remains.
    stands_for[sources[taus]] = lts.targets[taus]
    unstable = stands_for != np.arange(lts.states)
    while True:
        further = stands_for[stands_for]
        if np.array_equal(further, stands_for):
            break
        stands_for = further
    node = np.cumsum(~unstable) - 1
    ticking = np.zeros(lts.states, dtype=np.bool_)
    ticking[sources[lts.labels == TICK]] = True
    kept = ~unstable[sources] & (~ticking[sources] | (lts.labels == TICK))
    again = np.zeros(lts.transitions, dtype=np.bool_)
    again[1:] = (lts.labels[1:] == lts.labels[:-1]) & (sources[1:] == sources[:-1])
    kept &= ~again
    events: Int64Array = distinct(lts.labels[lts.labels != TAU])
    columns = np.searchsorted(events, lts.labels)
    accepting = StateAcceptances(lts, columns)
    nodes = int((~unstable).sum())
    unknown = np.zeros(nodes, dtype=np.bool_)
    if beyond is not None:
        unknown[node[beyond]] = True
    return NormalForm(
        "F",
        events,
        np.concatenate([[0], np.cumsum(np.bincount(node[sources[kept]], minlength=nodes))]).astype(np.int64),
        columns[kept].astype(np.int32),
        node[stands_for[lts.targets[kept]]].astype(np.int32),
        unknown,
        accepting.number[~unstable].astype(np.int32),
        tuple((acceptance,) for acceptance in accepting.acceptances),
        int(node[stands_for[lts.root]]),
    )


def _against_candidate(
    context: Context, packed: PackedNetwork, chosen: NormalForm, deepest: int | None = None
) -> Trace | None:
    """The first trace with nondeterminism, or None; the process must not diverge.

    Traces with more events than the *deepest* are not looked at, if it is given.
    """
    pairs = context.machines.pairs_of(packed, chosen, "F", context.budget, full=False, deepest=deepest)
    if pairs.violation_level is not None:
        goals = distinct(np.array([violation.index for violation in pairs.violations()], dtype=np.int64))
        return visible(shortest_path(pairs, goals))
    if not pairs.complete and pairs.stop != "depth":
        raise Incomplete(context.budget.shortfall(pairs, "nondeterminism"))
    return None


def _by_normal_form(context: Context, lts: Lts) -> Trace | None:
    """The first trace with nondeterminism, or None, by the subset construction.

    With divergence there need not be a stable state to choose after a trace, so all states are followed.
    """
    normaliser = Normaliser(lts, "F")
    came_by: dict[int, tuple[int, int]] = {}
    node = 0
    while node < normaliser.nodes:
        if node % 256 == 0:
            context.budget.check_time("looking for nondeterminism")
        known = normaliser.nodes
        moves = normaliser.extend(node)
        possible = {int(normaliser.events[column]) for column, _ in moves}
        if any(possible - set(acceptance) for acceptance in normaliser.acceptances(node)):
            trace: list[int] = []
            while node:
                node, event = came_by[node]
                trace.append(event)
            return tuple(reversed(trace))
        for column, target in moves:
            if target >= known:
                came_by.setdefault(target, (node, int(normaliser.events[column])))
        node += 1
    return None


def _begun(context: Context, trace: Trace) -> Counterexample:
    """What is known of nondeterminism before the runs with its trace are looked at."""
    return Counterexample("nondeterminism", tuple(context.events.name(event) for event in trace))


def _explained(context: Context, process: Process, trace: Trace) -> Counterexample:
    """The run of *trace* that ends by refusing the first event that is also possible, and one that performs it."""
    along = Along(context, process, trace, "T", beyond=True)
    if along.pairs.packed.network.is_compressed:
        along = along_original(context, process, trace, "T") or along
    if along.pairs.depth < len(trace):
        raise Incomplete(context.budget.shortfall(along.pairs, "end of the trace that shows nondeterminism"))
    offers = along.offers(len(trace))
    event = next(event for event in offers.possible if offers.refusers(event).any())
    behaviour = along.behaviour(offers.indices[offers.refusers(event)])
    behaviour.confirm(can_refuse(event), "a state that refuses the event")
    other = along.behaviour(offers.indices[offers.performers(event)])
    other.confirm(can_perform(event), "a state that can perform the event")
    name = context.events.name(event)
    return Counterexample(
        "nondeterminism",
        behaviour.trace,
        behaviour.causes,
        event=name,
        refusal=(name,),
        components=behaviour.components(),
        run=behaviour.run,
        alternative=(*other.trace, name),
    )
