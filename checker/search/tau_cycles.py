"""Cycles of taus in what a search has found. Each lies within one level, for taus are free."""

from __future__ import annotations

import numpy as np

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.kernels.jit import kernels_for
from cspcheck.checker.search.walk import Walk, backwards


def tau_cyclic_states(walk: Walk, level: int) -> Int64Array:
    """The states of a level that lie on a cycle of taus: ascending numbers."""
    sources, targets = walk.tau_edges(level)
    return cyclic_nodes(sources, targets, walk.levels[level], walk.levels[level + 1])


def cyclic_nodes(sources: Int64Array, targets: Int64Array, first: int, last: int) -> Int64Array:
    """The nodes from *first* to *last* that lie on a cycle of the edges between them; sources must ascend."""
    inside = targets >= first
    sources, targets = sources[inside] - first, targets[inside] - first
    nodes = last - first
    if not len(sources):
        return np.zeros(0, dtype=np.int64)
    offsets = np.searchsorted(sources, np.arange(nodes + 1)).astype(np.int64)
    component, low, stack = (np.zeros(nodes, dtype=np.int64) for _ in range(3))
    path = np.zeros(2 * nodes, dtype=np.int64)
    kernels = kernels_for(nodes)
    components = kernels.strong_components(offsets, np.ascontiguousarray(targets), nodes, component, low, stack, path)
    cyclic = np.zeros(components, dtype=np.bool_)
    cyclic[np.bincount(component, minlength=components) > 1] = True
    cyclic[component[sources[sources == targets]]] = True
    return first + np.flatnonzero(cyclic[component])


def divergent_states_of_level(walk: Walk, first_level: int, level: int) -> Int64Array:
    """The states of a level from which an infinite path of taus starts: ascending numbers.

    Args:
        walk: where.
        first_level: the first level that has a cycle of taus.
        level: the level that is asked for.
    """
    # A tau may lead to an earlier level, whose divergent states have to be known then.
    divergent = np.zeros(walk.levels[level + 1], dtype=np.bool_)
    for k in range(first_level, level + 1):
        first, last = walk.levels[k], walk.levels[k + 1]
        sources, targets = walk.tau_edges(k)
        seeds = [cyclic_nodes(sources, targets, first, last), sources[divergent[targets]]]
        distance = backwards(sources, targets, first, last, np.concatenate(seeds))
        divergent[first:last] = distance >= 0
    start = walk.levels[level]
    return start + np.flatnonzero(divergent[start:])
