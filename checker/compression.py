"""The compression functions of scripts, as functions from explicit machines to smaller ones that mean the same.

Each keeps traces, failures and divergences. Bisimulations live in :mod:`checker.bisimulation`; here are those that
work on taus and acceptances (Roscoe, Understanding Concurrent Systems, section 16.3).
"""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType

from checker.bisimulation import (
    delay_bisimulation,
    reachable,
    strong_bisimulation,
    tau_components,
    tau_reach,
    weak_bisimulation,
)
from checker.lts import Lts
from cspm.events import TAU, TICK

Rows = list[set[tuple[int, int]]]


def factor_tau_loops(lts: Lts) -> Lts:
    """``tau_loop_factor``: the states of a cycle of taus become one state, with a tau to itself."""
    components, _ = tau_components(lts)
    rows: Rows = [set() for _ in range(max(components) + 1)]
    for state in range(lts.states):
        for label, target in lts.successors(state):
            rows[components[state]].add((label, components[target]))
    return reachable(rows, components[lts.root])


def eliminate_diamonds(lts: Lts) -> Lts:
    """``diamond``: states that only taus lead to disappear.

    A state takes over the visible transitions of all the states that its taus lead to. What remains of its taus is
    what failures and divergences can see: a tau to each stable state of least acceptance (none where its own offer is
    the only one), and a tau to itself where it diverges. A transition to a state that another of the same event
    leads to by taus is left out.
    """
    factored = factor_tau_loops(lts)
    components, diverging = tau_components(factored)
    reach = tau_reach(factored, components)
    successors = [tuple(factored.successors(state)) for state in range(factored.states)]
    unstable = [any(label == TAU for label, _ in row) for row in successors]
    rows: Rows = [set() for _ in successors]
    pending, seen = [factored.root], {factored.root}
    while pending:
        state = pending.pop()
        if unstable[state]:
            visible = {(label, t) for u in reach[state] for label, t in successors[u] if label != TAU}
            rows[state] = _without_subsumed(visible, reach)
            acceptances = _minimal_acceptances(reach[state], successors, unstable)
            if diverging[state] or list(acceptances) != [frozenset(label for label, _ in visible)]:
                # An unstable state that can tick is its own witness of the acceptance {tick}.
                rows[state] |= {(TAU, u) for u in acceptances.values() if u != state}
            if diverging[state]:
                rows[state].add((TAU, state))
        else:
            rows[state] = _without_subsumed(set(successors[state]), reach)
        for _, target in rows[state]:
            if target not in seen:
                seen.add(target)
                pending.append(target)
    return reachable(rows, factored.root)


def _without_subsumed(moves: set[tuple[int, int]], reach: list[frozenset[int]]) -> set[tuple[int, int]]:
    """Leave out a move to a state that taus reach from the target of another move on the same label."""
    by_label: dict[int, list[int]] = {}
    for label, target in moves:
        by_label.setdefault(label, []).append(target)
    kept: set[tuple[int, int]] = set()
    for label, targets in by_label.items():
        for target in targets:
            if not any(target in reach[other] for other in targets if other != target):
                kept.add((label, target))
    return kept


def _minimal_acceptances(
    states: frozenset[int], successors: list[tuple[tuple[int, int], ...]], unstable: list[bool]
) -> dict[frozenset[int], int]:
    """The minimal acceptances of *states*, each with a state that has it.

    Stable states accept what they offer; a state that can tick, stable or not, accepts tick alone.
    """
    acceptances: dict[frozenset[int], int] = {}
    for state in sorted(states):
        offered = frozenset(label for label, _ in successors[state] if label != TAU)
        if TICK in offered:
            offered = frozenset({TICK})
        elif unstable[state]:
            continue
        acceptances.setdefault(offered, state)
    return {
        offered: state
        for offered, state in acceptances.items()
        if not any(smaller < offered for smaller in acceptances)
    }


def normalise(lts: Lts) -> Lts:
    """``normal``: one state for each behaviour after a trace, with its acceptances behind taus.

    The subset construction: a state of the result is a set of states. Where a set has one acceptance and it is all
    that the set can do, the state is stable; otherwise a tau leads to one stable state for each minimal acceptance.
    A diverging set has a tau to itself.
    """
    components, diverging = tau_components(lts)
    reach = tau_reach(lts, components)
    successors = [tuple(lts.successors(state)) for state in range(lts.states)]
    unstable = [any(label == TAU for label, _ in row) for row in successors]
    rows: Rows = []
    numbers: dict[tuple[frozenset[int], frozenset[int] | None], int] = {}
    pending: list[tuple[frozenset[int], frozenset[int] | None]] = []

    def number(states: frozenset[int], offered: frozenset[int] | None) -> int:
        key = (states, offered)
        if key not in numbers:
            numbers[key] = len(rows)
            rows.append(set())
            pending.append(key)
        return numbers[key]

    root = number(reach[lts.root], None)
    while pending:
        key = pending.pop()
        states, offered = key
        row = rows[numbers[key]]
        after: dict[int, set[int]] = {}
        for state in states:
            for label, target in successors[state]:
                if label != TAU and (offered is None or label in offered):
                    after.setdefault(label, set()).update(reach[target])
        row |= {(label, number(frozenset(targets), None)) for label, targets in after.items()}
        if offered is not None:
            continue
        diverges = any(diverging[state] for state in states)
        if diverges:
            row.add((TAU, numbers[key]))
        acceptances = _minimal_acceptances(states, successors, unstable)
        if diverges or list(acceptances) != [frozenset(after)]:
            row |= {(TAU, number(states, acceptance)) for acceptance in acceptances}
    return strong_bisimulation(reachable(rows, root))


def compress_for_failures_divergences(lts: Lts) -> Lts:
    """``model_compress``: the smallest that these compressions reach together."""
    return strong_bisimulation(eliminate_diamonds(weak_bisimulation(lts)))


def _unchanged(lts: Lts) -> Lts:
    return lts


COMPRESSIONS: MappingProxyType[str, Callable[[Lts], Lts]] = MappingProxyType(
    {
        "sbisim": strong_bisimulation,
        "wbisim": weak_bisimulation,
        "dbisim": delay_bisimulation,
        "diamond": eliminate_diamonds,
        "tau_loop_factor": factor_tau_loops,
        "normal": normalise,
        "model_compress": compress_for_failures_divergences,
        # A machine in arrays is explicit already; laziness changes when the work is done, not what is meant.
        "explicate": _unchanged,
        "lazyenumerate": _unchanged,
        "lazynorm": _unchanged,
    }
)
"""What each compression function of a script does to the machine of its operand."""
