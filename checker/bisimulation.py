"""Equivalences on the states of an explicit machine, and the quotients by them.

All three are the coarsest partition that is stable under a set of moves: those of the machine itself (strong
bisimulation), tau* a (delay bisimulation) or tau* a tau* (weak bisimulation). The latter two respect
divergence: a state with an infinite path of taus is never put together with one that has none, and its class
keeps a tau to itself; so the quotient has the same failures and divergences.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from checker.lts import Lts
from cspm.events import TAU

Rows = Sequence[Iterable[tuple[int, int]]]


def strong_bisimulation(lts: Lts) -> Lts:
    """The quotient by strong bisimulation: as small as a strongly bisimilar machine can be."""
    rows = _rows(lts)
    return quotient(lts, coarsest_partition(rows, [0] * lts.states), keep_inner_taus=True)


def weak_bisimulation(lts: Lts) -> Lts:
    """The quotient by divergence-respecting weak bisimulation (Milner 1989, chapter 5; taus may follow the event)."""
    return _tau_abstracting_quotient(lts, taus_after=True)


def delay_bisimulation(lts: Lts) -> Lts:
    """The quotient by divergence-respecting delay bisimulation (van Glabbeek 1993: taus only before the event)."""
    return _tau_abstracting_quotient(lts, taus_after=False)


def _tau_abstracting_quotient(lts: Lts, *, taus_after: bool) -> Lts:
    components, diverging = tau_components(lts)
    reach = tau_reach(lts, components)
    rows = _rows(lts)
    moves: list[set[tuple[int, int]]] = []
    for state in range(lts.states):
        found = {(TAU, target) for target in reach[state]}
        for before in reach[state]:
            for label, target in rows[before]:
                if label != TAU:
                    found.add((label, target))
                    if taus_after:
                        found.update((label, after) for after in reach[target])
        moves.append(found)
    partition = coarsest_partition(moves, [int(d) for d in diverging])
    return quotient(lts, partition, keep_inner_taus=False, diverging=diverging)


def coarsest_partition(rows: Rows, initial: Sequence[int]) -> list[int]:
    """The coarsest refinement of a partition whose classes cannot be told apart by their moves.

    A state's signature is the set of (label, class of the target). Rounds recompute signatures only of states one
    of whose targets has changed its class; when a class falls apart its largest part keeps the number. A state
    changes its number only into a part at most half as large, hence at most log2(states) times (Hopcroft 1971;
    signatures as in Blom and Orzan 2003).

    Args:
        rows: (label, target) pairs of each state.
        initial: a class number for each state; any integers.

    Returns:
        The class of each state, numbered in the order of first occurrence.
    """
    moves = [tuple(set(row)) for row in rows]
    predecessors: list[list[int]] = [[] for _ in moves]
    for state, row in enumerate(moves):
        for target in {target for _, target in row}:
            predecessors[target].append(state)
    numbers: dict[int, int] = {}
    block = [numbers.setdefault(number, len(numbers)) for number in initial]
    members: list[set[int]] = [set() for _ in numbers]
    for state, number in enumerate(block):
        members[number].add(state)
    signature: list[frozenset[tuple[int, int]] | None] = [None] * len(members)
    dirty: Iterable[int] = range(len(moves))
    while True:
        parts: dict[int, dict[frozenset[tuple[int, int]], list[int]]] = {}
        for state in dirty:
            found = frozenset((label, block[target]) for label, target in moves[state])
            parts.setdefault(block[state], {}).setdefault(found, []).append(state)
        if not parts:
            break
        changed: list[int] = []
        for number, by_signature in parts.items():
            changed += _split(number, by_signature, members, signature, block)
        dirty = {p for state in changed for p in predecessors[state]}
    order: dict[int, int] = {}
    return [order.setdefault(number, len(order)) for number in block]


def _split(
    number: int,
    by_signature: dict[frozenset[tuple[int, int]], list[int]],
    members: list[set[int]],
    signature: list[frozenset[tuple[int, int]] | None],
    block: list[int],
) -> list[int]:
    """Take a class apart by the new signatures of some of its members; the states whose number has changed."""
    examined = sum(map(len, by_signature.values()))
    untouched = len(members[number]) - examined
    old = signature[number]
    sizes = {found: len(states) for found, states in by_signature.items()}
    if untouched:
        # States that were not looked at again still have the signature that the class had.
        assert old is not None
        sizes[old] = sizes.get(old, 0) + untouched
    kept = max(sizes, key=lambda found: sizes[found])
    signature[number] = kept
    changed: list[int] = []
    if untouched and old is not None and kept != old:
        moved = {state for states in by_signature.values() for state in states}
        by_signature = dict(by_signature)
        by_signature[old] = [*by_signature.get(old, ()), *(members[number] - moved)]
    for found, states in by_signature.items():
        if found == kept:
            continue
        members[number].difference_update(states)
        for state in states:
            block[state] = len(members)
        members.append(set(states))
        signature.append(found)
        changed += states
    return changed


def quotient(
    lts: Lts, partition: Sequence[int], *, keep_inner_taus: bool, diverging: Sequence[bool] | None = None
) -> Lts:
    """The machine whose states are the classes, numbered as in *partition*, without what the root cannot reach.

    Args:
        lts: the machine.
        partition: the class of each state.
        keep_inner_taus: whether a tau inside a class stays a tau of the class to itself.
        diverging: per state; a class with a diverging state gets a tau to itself.
    """
    rows: list[set[tuple[int, int]]] = [set() for _ in range(max(partition) + 1)]
    for state in range(lts.states):
        source = partition[state]
        for label, target in lts.successors(state):
            if label != TAU or keep_inner_taus or partition[target] != source:
                rows[source].add((label, partition[target]))
        if diverging is not None and diverging[state]:
            rows[source].add((TAU, source))
    return reachable(rows, partition[lts.root])


def reachable(rows: Rows, root: int) -> Lts:
    """The machine of the states that *root* reaches, numbered breadth first by ascending labels; the root is 0."""
    number = {root: 0}
    order = [root]
    for state in order:
        for _, target in sorted(rows[state]):
            if target not in number:
                number[target] = len(order)
                order.append(target)
    return Lts.from_successors([[(label, number[target]) for label, target in rows[state]] for state in order])


def tau_components(lts: Lts) -> tuple[list[int], list[bool]]:
    """Strongly connected components of the taus, and which states have an infinite path of taus.

    Components are numbered so that every tau leads to the same or a smaller number (Tarjan 1972, iterative).
    """
    taus: list[list[int]] = [[t for label, t in lts.successors(s) if label == TAU] for s in range(lts.states)]
    component = [-1] * lts.states
    low = [0] * lts.states
    index = [-1] * lts.states
    diverging_component: list[bool] = []
    stack: list[int] = []
    counter = 0
    for start in range(lts.states):
        if index[start] >= 0:
            continue
        work = [(start, iter(taus[start]))]
        index[start] = low[start] = counter
        counter += 1
        stack.append(start)
        while work:
            state, targets = work[-1]
            for target in targets:
                if index[target] < 0:
                    index[target] = low[target] = counter
                    counter += 1
                    stack.append(target)
                    work.append((target, iter(taus[target])))
                    break
                if component[target] < 0:
                    low[state] = min(low[state], index[target])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[state])
                if low[state] == index[state]:
                    number = len(diverging_component)
                    found: list[int] = []
                    while not found or found[-1] != state:
                        found.append(stack.pop())
                        component[found[-1]] = number
                    outside = {component[t] for s in found for t in taus[s]} - {number}
                    cyclic = len(found) > 1 or state in taus[state]
                    diverging_component.append(cyclic or any(diverging_component[c] for c in outside))
    return component, [diverging_component[c] for c in component]


def tau_reach(lts: Lts, components: Sequence[int]) -> list[frozenset[int]]:
    """For each state the states that taus lead to, itself included.

    Args:
        lts: the machine.
        components: as :func:`tau_components` gives them: taus lead to smaller or equal numbers.
    """
    inside: list[list[int]] = [[] for _ in range(max(components, default=-1) + 1)]
    for state, number in enumerate(components):
        inside[number].append(state)
    reach: list[frozenset[int]] = []
    for number, states in enumerate(inside):
        found = set(states)
        for state in states:
            for label, target in lts.successors(state):
                if label == TAU and components[target] != number:
                    found |= reach[components[target]]
        reach.append(frozenset(found))
    return [reach[number] for number in components]


def _rows(lts: Lts) -> list[list[tuple[int, int]]]:
    return [list(lts.successors(state)) for state in range(lts.states)]
