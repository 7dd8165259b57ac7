"""Refinement as a search: pairs of a specification's node and an implementation's state, breadth first.

A pair is the packed state of the implementation with the node in a further field, explored by the same kernels as
a machine alone; its levels are those of the trace that leads to it. Taus of the implementation keep the node.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.beyond import Beyond, prepared
from cspcheck.checker.search.checkpoint import Checkpoints
from cspcheck.checker.search.exploration import Exploration
from cspcheck.checker.search.levels import NO_LIMITS, Progress
from cspcheck.checker.search.pairs import LazyNormalForm, Pairs
from cspcheck.checker.search.walk import CHUNK, refusing_rows, transitions_of
from cspcheck.checker.specification.normal_form import NormalForm, NormalModel
from cspcheck.checker.verdict import Limits

__all__ = ["LazyNormalForm", "PairExploration", "Violation", "ViolationKind", "explore_pairs"]

ViolationKind = Literal["trace", "refusal", "divergence"]


@dataclass(frozen=True, slots=True)
class Violation:
    """Why a pair breaks the refinement.

    Attributes:
        index: the pair's place in the exploration.
        kind: ``trace``: the state can perform ``event`` and the node does not allow it. ``refusal``: a stable state,
            or one that can tick, offers too little. ``divergence``: the state lies on a cycle of taus.
        event: the identifier of the event for a trace violation; -1 otherwise.
    """

    index: int
    kind: ViolationKind
    event: int


@dataclass(eq=False, slots=True)
class PairExploration(Exploration):
    """What a refinement search has found; the attributes of :class:`Exploration` speak of pairs.

    Attributes:
        model: what was compared.
        violation_level: the first level with a violation, or None. The refinement holds when there is none and the
            exploration is complete.
    """

    model: NormalModel
    violation_level: int | None

    @property
    def pairs(self) -> Pairs:
        """The specification."""
        assert self.walk.pairs is not None
        return self.walk.pairs

    @property
    def nodes(self) -> Int64Array:
        """The specification's node of each pair, shape (states,)."""
        return self.pairs.nodes(self.walk.span(0, self.walk.levels[-1]))

    def violations(self, level: int | None = None) -> tuple[Violation, ...]:
        """The violations by pairs of a level (by default the first that has any), in the order (index, kind, event)."""
        if level is None:
            level = self.violation_level
        if level is None:
            return ()
        found: list[Violation] = []
        if self.model == "FD":
            found += [Violation(index, "divergence", -1) for index in self.tau_cyclic(level).tolist()]
        first, last = self.walk.levels[level], self.walk.levels[level + 1]
        for start in range(first, last, CHUNK):
            rows = self.walk.span(start, min(last, start + CHUNK))
            found += [
                Violation(start + row, "refusal", -1) for row in refusing_rows(self.packed, self.pairs, rows).tolist()
            ]
            found += [Violation(start + row, "trace", event) for row, event in self._forbidden(rows)]
        return tuple(sorted(found, key=lambda violation: (violation.index, violation.kind, violation.event)))

    def _forbidden(self, rows: Int64Array) -> list[tuple[int, int]]:
        """The (row, event identifier) of the transitions that the specification does not allow."""
        found = transitions_of(self.packed, self.pairs, rows, [self.packed.visible])
        chosen = found.nodes < 0
        events = self.packed.events[found.events[chosen]]
        return sorted(set(zip(found.sources[chosen].tolist(), events.tolist(), strict=True)))


def explore_pairs(
    packed: PackedNetwork,
    specification: NormalForm | LazyNormalForm,
    model: NormalModel,
    *,
    full: bool = False,
    deepest: int | None = None,
    limits: Limits = NO_LIMITS,
    workers: int = 1,
    progress: Callable[[Progress], None] | None = None,
    notify: Callable[[str], None] | None = None,
    compiled: bool | None = None,
    checkpoints: Checkpoints | None = None,
    beyond: Beyond | None = None,
) -> PairExploration:
    """Search the reachable pairs for one that breaks ``specification [model= network``.

    Pairs with a divergent node (FD) are counted and not expanded. Unless *full*, the search ends after the first
    level with a violation; with it, forbidden events are skipped and everything else is explored. Levels behind the
    *deepest* are not looked at.

    Args are those of :func:`cspcheck.checker.search.exploration.explore`.
    """
    pairs = Pairs(specification, packed.layout, packed.events)
    search = prepared(
        beyond,
        packed,
        pairs,
        limits=limits,
        workers=workers,
        stop_at_violation=not full,
        deepest=deepest,
        look_for_divergence=model == "FD",
        progress=progress,
        notify=notify,
        compiled=compiled,
        checkpoints=checkpoints,
    )
    search.run()
    return PairExploration(
        packed,
        tuple(search.levels),
        search.transitions,
        tuple(search.transitions_at),
        search.complete,
        search.stop,
        search.known,
        None,
        search.divergence_level,
        search.has_tau,
        False,
        search.peak_memory_bytes,
        search.seconds,
        search.walk if search.has_found else search.walk(),
        model,
        search.violation_level,
    )
