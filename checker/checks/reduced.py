"""Answers from a network that is composed two by two and minimised in between (``reduction.composing``).

A search looks at the first states of a process as they are: most questions are answered there, with the shortest
counterexample. Where there are more states than that, the process is reduced for the question before it is searched on.
A verdict never depends on it: what is found in a reduced space is unfolded into a run of the script's components and
replayed, and where that does not succeed the process is searched as it is.
"""

from __future__ import annotations

from cspcheck.checker.checks.context import Context
from cspcheck.checker.checks.reducing import all_alike, everything_hidden, reduced
from cspcheck.checker.checks.store import Aim
from cspcheck.checker.explain.behaviour import deadlocked
from cspcheck.checker.explain.unfolding import NotUnfolded, unfolded
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.packing.stubborn import Kept
from cspcheck.checker.search.exploration import explore
from cspcheck.checker.search.paths import shortest_path
from cspcheck.checker.verdict import Outcome, Verdict
from cspcheck.cspm.process.terms import Process


def reduced_search(context: Context, process: Process, aim: Aim) -> Outcome | None:
    """Whether a process has a deadlock or a divergence, from its reduced form; None if that does not tell.

    None also where nothing is to be reduced.

    Raises:
        Incomplete: the time is over.
    """
    if not context.machines.reduces:
        return None
    # Where no taus can go round there is no divergence, and the order of all that happens does not matter.
    cycles = "divergence" in aim and len(context.machines.packed(process, context.budget).cycling.items) > 0
    if aim == "divergence" and not cycles:
        return context.budget.outcome(Verdict.PASS, None, *looked_at(context, process, aim))
    network = context.machines.network(process, context.budget)
    found = reduced(network, "FD" if cycles else "F", all_alike if cycles else everything_hidden, context.budget)
    if found is None:
        return None
    exploration = explore(
        context.searched(found.packed, what_is_kept(found.packed, aim)),
        limits=context.budget.remaining(),
        workers=context.machines.workers,
        stop_at_deadlock="deadlock" in aim,
        stop_at_divergence=cycles,
        look_for_divergence=cycles,
        beyond=context.machines.beyond,
    )
    context.searched_by(exploration)
    counts = found.counts(exploration)
    if exploration.divergence_level is None and exploration.deadlock_level is None:
        return context.budget.outcome(Verdict.PASS, None, *counts) if exploration.complete else None
    if exploration.deadlock_level is None or "deadlock" not in aim:
        return None
    path = shortest_path(exploration, exploration.deadlocked(exploration.deadlock_level))
    original = context.machines.packed(process, context.budget)
    try:
        run = unfolded(original, found.composition, found.packed, path)
    except NotUnfolded:
        return None
    counterexample = deadlocked(process, original, run, context.events)
    return context.budget.outcome(Verdict.FAIL, None, *counts, counterexample)


def what_is_kept(packed: PackedNetwork, aim: Aim) -> Kept:
    """What a search of a network by partial order must keep: where no taus can go round there is no divergence."""
    return "behaviour" if "divergence" in aim and len(packed.cycling.items) else "deadlocks"


def looked_at(context: Context, process: Process, aim: Aim) -> tuple[int, int]:
    """What has been looked at so far of a process."""
    exploration = context.machines.looked_at(process, aim)
    return (0, 0) if exploration is None else (int(exploration.levels[-1]), exploration.transitions)
