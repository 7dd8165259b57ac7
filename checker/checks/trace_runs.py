"""A process along one trace: the runs that perform just that trace, found as pairs with a specification of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from cspcheck.checker.arrays import BoolArray, Int64Array, distinct
from cspcheck.checker.budget import Incomplete
from cspcheck.checker.checks.context import Context, in_chunks
from cspcheck.checker.explain.behaviour import Behaviour
from cspcheck.checker.search.exploration import Exploration
from cspcheck.checker.search.pair_search import PairExploration
from cspcheck.checker.search.paths import PathStep, shortest_path
from cspcheck.checker.semantics.steps import Row
from cspcheck.checker.specification.normal_form import NormalForm, NormalModel
from cspcheck.cspm.interruption import during
from cspcheck.cspm.process.events import TAU, TICK, EventTable
from cspcheck.cspm.process.terms import Process

EXPLAINED_STATES = 100_000
"""So many states are looked at to explain a failure without compressions."""
EXPLAINED_TERMS = 2_000
"""So many states of one component, or along the trace, are looked at as terms for it."""
SMALL_COMPONENT = 300
"""Components with fewer states than this are always explained by their network."""


def chain(trace: Sequence[int], model: NormalModel, *, beyond: bool) -> NormalForm:
    """The specification of one trace: node ``i`` allows its ``i``-th event only and insists on nothing.

    Unless what lies *beyond* the trace is of interest, everything is allowed there, so that none of it is explored.
    """
    length = len(trace)
    events = distinct(np.array(trace, dtype=np.int64))
    open_end = np.zeros(length + 1, dtype=np.bool_)
    open_end[length] = not beyond
    return NormalForm(
        model,
        events,
        np.minimum(np.arange(length + 2), length),
        np.searchsorted(events, np.array(trace, dtype=np.int64)).astype(np.int32),
        np.arange(1, length + 1, dtype=np.int32),
        open_end,
        open_end.astype(np.int32),
        (((),), ()),
    )


class Along:
    """All states that a process can be in while it performs a trace.

    Attributes:
        process: the process.
        events: names the events.
        pairs: the exploration; level ``i`` holds the states after the first ``i`` events of the trace. The last level
            has those that the last event leads to; those that taus lead to from there only if *beyond* was asked for.
    """

    def __init__(
        self,
        context: Context,
        process: Process,
        trace: Sequence[int],
        model: NormalModel,
        *,
        beyond: bool,
        original: bool = False,
    ) -> None:
        self.process = process
        self.events: EventTable = context.events
        self.pairs: PairExploration = context.machines.pairs(
            chain(trace, model, beyond=beyond),
            process,
            model,
            context.budget,
            full=True,
            original=original,
            at_hand=True,
        )

    def offers(self, length: int) -> Offers:
        """What the states after that many events of the trace offer; there must be such states."""
        return Offers(self.pairs, np.arange(self.pairs.levels[length], self.pairs.levels[length + 1]))

    def path(self, goals: Int64Array) -> tuple[PathStep, ...]:
        """The canonical path to one of the given pairs."""
        return shortest_path(self.pairs, goals)

    def behaviour(self, goals: Int64Array) -> Behaviour:
        """The canonical run to one of the given pairs, to be explained."""
        return Behaviour(self.process, self.pairs.packed, self.path(goals), self.events)


def along_original(
    context: Context,
    process: Process,
    trace: Sequence[int],
    model: NormalModel,
    goal: Callable[[Row], bool] | None = None,
    *,
    at_hand: bool = False,
) -> Along | None:
    """The states after *trace* of a process whose compressed components have all their states.

    A failure that was found with compressed components is explained by what the components do that the script has:
    in the network of them where they are small, else in terms, else in the network of large ones.
    None where so many states would have to be looked at that this is not worth while.

    Args:
        context, process, trace, model: what is followed.
        goal: tells from its transitions whether a state is what the failure is about. Where the states after the trace
            are too many, one run to such a state will do.
        at_hand: whether nothing but the network of small components is tried.
    """
    along = _complete(partial(_in_network, context, process, trace, model, SMALL_COMPONENT))
    if along is not None or at_hand:
        return along
    ways: list[Callable[[], Along | None]] = [
        partial(_in_terms, context, process, trace, model),
        partial(_in_network, context, process, trace, model, EXPLAINED_TERMS),
    ]
    if goal is not None:
        one_run = partial(_in_terms, context, process, trace, model, goal)
        # Where the network is there, all states were too many, and are so in whatever form.
        ways = [one_run] if _has_network(context, process) else [ways[0], one_run, ways[1]]
    return next((found for way in ways if (found := _complete(way)) is not None), None)


def _complete(way: Callable[[], Along | None]) -> Along | None:
    """What a way of following the trace finds; None if that is not all that there is."""
    try:
        with during("explaining the failure without compression", vague=True):
            along = way()
    except Incomplete:
        return None
    return along if along is not None and along.pairs.complete else None


def _has_network(context: Context, process: Process) -> bool:
    """Whether the network of small components is there: it is the states after the trace that are too many."""
    try:
        budget = context.budget.narrowed(min(SMALL_COMPONENT, EXPLAINED_STATES))
        context.machines.packed(process, budget, original=True)
    except Incomplete:
        return False
    return True


def _in_network(context: Context, process: Process, trace: Sequence[int], model: NormalModel, most: int) -> Along:
    """The states after a trace in the network of components that have at most so many states."""
    machines, budget = context.machines, context.budget
    machines.packed(process, budget.narrowed(min(most, EXPLAINED_STATES)), original=True)
    narrow = replace(context, budget=budget.narrowed(EXPLAINED_STATES))
    return Along(narrow, process, trace, model, beyond=True, original=True)


def _in_terms(
    context: Context,
    process: Process,
    trace: Sequence[int],
    model: NormalModel,
    goal: Callable[[Row], bool] | None = None,
) -> Along | None:
    """The states after a trace as terms; None if there are too many on the way."""
    budget = context.budget.narrowed(EXPLAINED_STATES)
    machines = context.machines.along(process, trace, min(EXPLAINED_TERMS, EXPLAINED_STATES), budget, goal)
    if machines is None:
        return None
    return Along(replace(context, machines=machines, budget=budget), process, trace, model, beyond=True)


class Offers:
    """What each of some states can perform, and what each can be relied on to perform.

    Attributes:
        indices: the states.
        settled: which of them have an acceptance: those that can tick (it is {tick}) and the stable ones.
        possible: what at least one of them can perform, taus apart; ascending.
    """

    def __init__(self, exploration: Exploration, indices: Int64Array) -> None:
        self.indices = indices
        chunks = list(in_chunks(exploration, indices))
        none = np.zeros(0, dtype=np.int64)
        lengths = np.concatenate([none, *(np.diff(chunk.offsets) for chunk in chunks)])
        self._sources = np.repeat(np.arange(len(indices)), lengths)
        self._events = np.concatenate([none, *(chunk.events for chunk in chunks)])
        self._ticking = self.performers(TICK)
        self.settled = self._ticking | ~self.performers(TAU)
        self.possible: tuple[int, ...] = tuple(distinct(self._events[self._events != TAU]).tolist())

    def acceptance(self, state: int) -> frozenset[int] | None:
        """What the state with this place among ``indices`` can be relied on to perform; None if for nothing."""
        if not self.settled[state]:
            return None
        if self._ticking[state]:
            return frozenset({TICK})
        first, last = np.searchsorted(self._sources, [state, state + 1])
        return frozenset(self._events[first:last].tolist())

    def performers(self, event: int) -> BoolArray:
        """Which of the states can perform *event*."""
        able = np.zeros(len(self.indices), dtype=np.bool_)
        able[self._sources[self._events == event]] = True
        return able

    def refusers(self, event: int) -> BoolArray:
        """Which of the states can refuse *event*."""
        accepted = self._ticking if event == TICK else self.performers(event) & ~self._ticking
        refusing: BoolArray = self.settled & ~accepted
        return refusing
