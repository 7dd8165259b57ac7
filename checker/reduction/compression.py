"""The compression functions of scripts, as functions from explicit machines to smaller ones that mean the same.

Each keeps traces, failures and divergences. Bisimulations live in :mod:`cspcheck.checker.reduction.bisimulation`;
here are those that work on taus and acceptances (Roscoe, Understanding Concurrent Systems, section 16.3).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from types import MappingProxyType

from cspcheck.checker.lts import Lts, reachable
from cspcheck.checker.reduction.bisimulation import (
    delay_bisimulation,
    factor_tau_loops,
    strong_bisimulation,
    weak_bisimulation,
)
from cspcheck.checker.specification.acceptances import divergent_states
from cspcheck.cspm.process.events import TAU, TICK

Moves = list[tuple[tuple[int, int], ...]]
"""The (label, target) pairs of each state."""


def _moves(lts: Lts) -> Moves:
    return [tuple(lts.successors(state)) for state in range(lts.states)]


class _Taus:
    """What taus lead to, looked up when it is asked for: many states never are."""

    def __init__(self, rows: Moves) -> None:
        self._taus = [[target for label, target in row if label == TAU] for row in rows]
        self._known: dict[int, frozenset[int]] = {}

    def from_state(self, state: int) -> frozenset[int]:
        """The states that taus lead to from a state, itself included."""
        found = self._known.get(state)
        if found is None:
            found = self._known[state] = self.from_states((state,))
        return found

    def from_states(self, states: Iterable[int]) -> frozenset[int]:
        """The states that taus lead to from some states, these included."""
        seen = set(states)
        pending = list(seen)
        while pending:
            for target in self._taus[pending.pop()]:
                if target not in seen:
                    seen.add(target)
                    pending.append(target)
        return frozenset(seen)


def eliminate_diamonds(lts: Lts) -> Lts:
    """``diamond``: states that only taus lead to disappear.

    A state takes over the visible transitions of all the states that its taus lead to. What remains of its taus is
    what failures and divergences can see: a tau to each stable state of least acceptance (none where its own offer is
    the only one), and a tau to itself where it diverges. A transition to a state that another of the same event
    leads to by taus is left out.
    """
    factored = factor_tau_loops(strong_bisimulation(lts))
    diverging = divergent_states(factored)
    successors = _moves(factored)
    taus = _Taus(successors)
    unstable = [any(label == TAU for label, _ in row) for row in successors]
    rows: list[set[tuple[int, int]]] = [set() for _ in successors]
    pending, seen = [factored.root], {factored.root}
    while pending:
        state = pending.pop()
        if unstable[state]:
            reached = taus.from_states((state,))
            visible = {(label, t) for u in reached for label, t in successors[u] if label != TAU}
            rows[state] = _without_subsumed(visible, taus)
            acceptances = _minimal_acceptances(reached, successors, unstable)
            if diverging[state] or list(acceptances) != [frozenset(label for label, _ in visible)]:
                # An unstable state that can tick is its own witness of the acceptance {tick}.
                rows[state] |= {(TAU, u) for u in acceptances.values() if u != state}
            if diverging[state]:
                rows[state].add((TAU, state))
        else:
            rows[state] = _without_subsumed(set(successors[state]), taus)
        for _, target in rows[state]:
            if target not in seen:
                seen.add(target)
                pending.append(target)
    return reachable(Lts.from_successors(rows, factored.root))


def _without_subsumed(moves: set[tuple[int, int]], taus: _Taus) -> set[tuple[int, int]]:
    """Leave out a move to a state that taus reach from the target of another move on the same label."""
    by_label: dict[int, list[int]] = {}
    for label, target in moves:
        by_label.setdefault(label, []).append(target)
    kept: set[tuple[int, int]] = set()
    for label, targets in by_label.items():
        if len(targets) > 1:
            wanted = set(targets)
            subsumed = {other for target in targets for other in taus.from_state(target) & wanted if other != target}
            targets = [target for target in targets if target not in subsumed]
        kept.update((label, target) for target in targets)
    return kept


def _minimal_acceptances(states: frozenset[int], successors: Moves, unstable: list[bool]) -> dict[frozenset[int], int]:
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


class TooManyNodes(Exception):
    """A normal form is larger than it may be."""


def normalise(lts: Lts, most: int | None = None) -> Lts:
    """``normal``: one state for each behaviour after a trace, with its acceptances behind taus.

    The subset construction: a state of the result is a set of states. Where a set has one acceptance and it is all
    that the set can do, the state is stable; otherwise a tau leads to one stable state for each minimal acceptance.
    A diverging set has a tau to itself.

    Raises:
        TooManyNodes: there are more than *most*.
    """
    lts = strong_bisimulation(lts)
    diverging = divergent_states(lts)
    successors = _moves(lts)
    taus = _Taus(successors)
    unstable = [any(label == TAU for label, _ in row) for row in successors]
    rows: list[set[tuple[int, int]]] = []
    numbers: dict[tuple[frozenset[int], frozenset[int] | None], int] = {}
    pending: list[tuple[frozenset[int], frozenset[int] | None]] = []

    def number(states: frozenset[int], offered: frozenset[int] | None) -> int:
        key = (states, offered)
        if key not in numbers:
            if len(rows) == most:
                raise TooManyNodes
            numbers[key] = len(rows)
            rows.append(set())
            pending.append(key)
        return numbers[key]

    root = number(taus.from_state(lts.root), None)
    while pending:
        key = pending.pop()
        states, offered = key
        row = rows[numbers[key]]
        after: dict[int, set[int]] = {}
        for state in states:
            for label, target in successors[state]:
                if label != TAU and (offered is None or label in offered):
                    after.setdefault(label, set()).add(target)
        row |= {(label, number(taus.from_states(targets), None)) for label, targets in after.items()}
        if offered is not None:
            continue
        diverges = any(diverging[state] for state in states)
        if diverges:
            row.add((TAU, numbers[key]))
        acceptances = _minimal_acceptances(states, successors, unstable)
        if diverges or list(acceptances) != [frozenset(after)]:
            row |= {(TAU, number(states, acceptance)) for acceptance in acceptances}
    return strong_bisimulation(Lts.from_successors(rows, root))


def normalise_if_small(lts: Lts) -> Lts:
    """``lazynorm``: ``normal``, unless that would be much larger than the machine; then bisimilar states together.

    To normalise lazily is to pay only for what is reached; here it is paid for only where it is cheap.
    """
    reduced = strong_bisimulation(lts)
    try:
        return normalise(reduced, 2 * reduced.states + 1_000)
    except TooManyNodes:
        return reduced


def compress_for_failures_divergences(lts: Lts) -> Lts:
    """``model_compress``: the smallest that these compressions reach together."""
    return strong_bisimulation(eliminate_diamonds(weak_bisimulation(lts)))


COMPRESSIONS: MappingProxyType[str, Callable[[Lts], Lts]] = MappingProxyType(
    {
        "sbisim": strong_bisimulation,
        "wbisim": weak_bisimulation,
        "dbisim": delay_bisimulation,
        "diamond": eliminate_diamonds,
        "tau_loop_factor": factor_tau_loops,
        "normal": normalise,
        "model_compress": compress_for_failures_divergences,
        "lazynorm": normalise_if_small,
        # To list the states of a component is what is asked for; that equal ones are listed once can only help.
        "explicate": strong_bisimulation,
        "lazyenumerate": strong_bisimulation,
    }
)
"""What each compression function of a script does to the machine of its operand."""
