"""Searches that may become larger than one process, and where they go then."""

from __future__ import annotations

from typing import Any

from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.cluster import Cluster, ClusterSearch
from cspcheck.checker.search.levels import LevelSearch
from cspcheck.checker.search.pairs import Pairs
from cspcheck.checker.search.spill import Spill, SpillSearch

Beyond = Spill | Cluster
"""A folder on disk, or other processes."""


def prepared(
    beyond: Beyond | None, packed: PackedNetwork, pairs: Pairs | None, **options: Any
) -> LevelSearch | ClusterSearch:
    """A search, to be run.

    A specification that is normalised as the search reaches it is known to this process only: others cannot help. Nor
    can they once one of the processes has failed in the midst of a search.
    """
    if isinstance(beyond, Spill):
        return SpillSearch(packed, pairs, spill=beyond, **options)
    if isinstance(beyond, Cluster) and not beyond.is_broken and (pairs is None or not pairs.is_lazy):
        return ClusterSearch(packed, pairs, cluster=beyond, **options)
    return LevelSearch(packed, pairs, **options)
