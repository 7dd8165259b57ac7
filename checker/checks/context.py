"""What every check works with."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.budget import Budget, Incomplete
from cspcheck.checker.checks.store import Machines
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.packing.stubborn import Kept
from cspcheck.checker.search.exploration import Exploration, Successors
from cspcheck.checker.search.paths import PathStep
from cspcheck.checker.verdict import Counterexample, Outcome, Verdict
from cspcheck.cspm.process.events import EventTable
from cspcheck.cspm.syntax.tree import Assertion

CHUNK = 1 << 16
"""States whose transitions are looked at together."""


@dataclass(slots=True)
class Sure:
    """What is sure of an assertion before all is told of it: a limit that is reached later takes nothing of that away.

    Attributes:
        about: the assertion.
        outcome: the failure, with what is known of its counterexample; None while nothing is.
    """

    about: Assertion | None = None
    outcome: Outcome | None = None


@dataclass(slots=True)
class PartialOrder:
    """What becomes of the wish that an assertion be searched by partial order.

    Attributes:
        wanted: whether it is wished for.
        used: whether a search has left something out.
        unsuited: whether there was a search that could not.
    """

    wanted: bool = False
    used: bool = False
    unsuited: bool = False


@dataclass(frozen=True, slots=True)
class Context:
    """Machines to share, names for events, the limits of the assertion, what is sure of it, and how it is searched.

    Attributes:
        machines, events, budget, sure, order: these.
        whole: where the machines are the beginning of what they stand for: how many levels of them are as they should.
    """

    machines: Machines
    events: EventTable
    budget: Budget
    sure: Sure = field(default_factory=Sure)
    order: PartialOrder = field(default_factory=PartialOrder)
    whole: int | None = None

    def kept(self, packed: PackedNetwork, kept: Kept) -> Kept | None:
        """What a search of a network by partial order is to keep; None where it is not to be searched so."""
        if not self.order.wanted or self.machines.full:
            return None
        if self.machines.narrowed(packed, kept) is None:
            self.order.unsuited = True
            return None
        return kept

    def searched_by(self, exploration: Exploration) -> None:
        """Note by what search the answer is given."""
        self.order.used = exploration.packed.is_narrowed

    def searched(self, packed: PackedNetwork, kept: Kept) -> PackedNetwork:
        """A network as it is to be searched: by partial order if that is wished for, and can be."""
        if self.kept(packed, kept) is None:
            return packed
        return self.machines.narrowed(packed, kept) or packed

    def failed(self, states: int, transitions: int, counterexample: Counterexample | None = None) -> None:
        """Note that the assertion fails, whatever becomes of the telling; *counterexample* as far as it is known."""
        self.sure.outcome = self.budget.outcome(Verdict.FAIL, None, states, transitions, counterexample)

    def rely_on(self, level: int) -> None:
        """Give up where *level* is not as it should, before anything is told of what was found there.

        Raises:
            Incomplete: it is not.
        """
        if self.whole is not None and level >= self.whole:
            raise Incomplete(f"only {self.whole:,} levels of the process are known")

    def not_found(self, exploration: Exploration, sought: str) -> Outcome:
        """The outcome of a search that met nothing wrong: a pass if it was completed, else unknown."""
        states, transitions = int(exploration.levels[-1]), exploration.transitions
        if exploration.complete:
            return self.budget.outcome(Verdict.PASS, None, states, transitions)
        reason = self.budget.shortfall(exploration, sought)
        return self.budget.outcome(Verdict.UNKNOWN, reason, states, transitions)

    def covered(self, exploration: Exploration, level: int) -> tuple[int, int]:
        """The states and transitions to report for an answer that *level* gave.

        What had to be looked at for it, whether or not another assertion has had more explored; or everything, when
        the whole space is asked for.
        """
        if self.machines.full or level == exploration.depth:
            return int(exploration.levels[-1]), exploration.transitions
        return int(exploration.levels[level + 1]), exploration.transitions_at[level]


def in_chunks(exploration: Exploration, indices: Int64Array) -> Iterator[Successors]:
    """The transitions of many states, some at a time."""
    for start in range(0, len(indices), CHUNK):
        yield exploration.successors(indices[start : start + CHUNK])


def reached(exploration: Exploration, path: tuple[PathStep, ...]) -> int:
    """The index of what a path ends in."""
    if not path:
        return 0
    last = path[-1]
    return exploration.index(np.array(last.state, dtype=np.int64), last.node)
