"""What every check works with."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from cspcheck.checker.arrays import Int64Array
from cspcheck.checker.budget import Budget, Incomplete
from cspcheck.checker.checks.store import Machines
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


@dataclass(frozen=True, slots=True)
class Context:
    """Machines to share, names for events, the limits of the assertion, and what is sure of it.

    Attributes:
        machines, events, budget, sure: these.
        whole: where the machines are the beginning of what they stand for: how many levels of them are as they should.
    """

    machines: Machines
    events: EventTable
    budget: Budget
    sure: Sure = field(default_factory=Sure)
    whole: int | None = None

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
