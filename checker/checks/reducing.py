"""Processes reduced before they are searched, unasked; see ``reduction.composing``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import log2
from typing import Literal

from cspcheck.checker.budget import Budget
from cspcheck.checker.network.network import Network
from cspcheck.checker.packing.packed import PackedNetwork, pack
from cspcheck.checker.reduction.composing import MOST_PRODUCT, ComposedNetwork, NotComposable, composed
from cspcheck.checker.search.exploration import Exploration
from cspcheck.checker.specification.normal_form import FailuresModel
from cspcheck.cspm.process.events import FIRST_EVENT, TAU

WORTH_WHILE = 2
"""A reduced network is searched if it could have fewer states than the network by so many powers of two."""

SEARCHED = 20
"""Where more powers of two of states are left, the process is reduced in another order, too."""


@dataclass(frozen=True, eq=False, slots=True)
class Reduced:
    """A process reduced for a question.

    Attributes:
        composition: what is left of it.
        packed: that, ready to be searched.
    """

    composition: ComposedNetwork
    packed: PackedNetwork

    def counts(self, exploration: Exploration) -> tuple[int, int]:
        """The states and transitions that were looked at: those composed on the way, and those of the search."""
        return (
            self.composition.states + int(exploration.levels[-1]),
            self.composition.transitions + exploration.transitions,
        )


def model_for(packed: PackedNetwork, model: Literal["T", "F", "FD"]) -> FailuresModel:
    """What must be kept for a question in a model: failures are enough where no taus can go round."""
    return "FD" if model == "FD" and len(packed.cycling.items) else "F"


def everything_hidden(_: int) -> int:
    """No event matters: deadlocks in F."""
    return TAU


def all_alike(_: int) -> int:
    """It matters that something happens, not what: divergences."""
    return FIRST_EVENT


def as_they_are(event: int) -> int:
    """Every event matters."""
    return event


def reduced(network: Network, model: FailuresModel, visible: Callable[[int], int], budget: Budget) -> Reduced | None:
    """The network of a process reduced for a question; None where that does not make it smaller.

    Args:
        network: the network.
        model: what must be kept; failures are enough where no taus can go round.
        visible: the event that an event counts as.
        budget: what may be used.

    Raises:
        Incomplete: the time is over.
    """
    if len(network.slots) < 2:
        return None
    before = sum(log2(slot.lts.states) for slot in network.slots)
    best: ComposedNetwork | None = None
    poll = partial(budget.check_time, "reducing the process")
    limit = budget.limits.states
    most = MOST_PRODUCT if limit is None else min(limit, MOST_PRODUCT)
    for by_ties in (False, True):
        try:
            found = composed(network, model, visible, poll, by_ties=by_ties, most=most)
        except NotComposable:
            return None
        if best is None or _size(found) < _size(best):
            best = found
        if _size(best) <= SEARCHED:
            break
    assert best is not None
    if _size(best) > before - WORTH_WHILE:
        return None
    return Reduced(best, pack(best.network))


def _size(composition: ComposedNetwork) -> float:
    """How many powers of two of states there may be."""
    return sum(log2(slot.lts.states) for slot in composition.network.slots)
