"""Revivals and refusal testing as traces: what an observer of refusals sees becomes events of their own.

The model V (stable revivals) has traces, deadlocks and revivals: a trace, a set that is refused after it in a stable
state, and an event that this state then performs. The model R (refusal testing) has sequences of events before any of
which a refusal may have been observed in the stable state that performs it. (Roscoe, Understanding Concurrent Systems,
chapters 11 and 12.) In both, a process with less to be seen refines one with more, and smaller refusals follow from
greater ones, so of the implementation only the whole complement of each stable state's offer needs to be looked at.

So for each offer Y of the implementation and each event a of it there is one more event, "refuse all but Y, then a".
A stable state of the implementation that offers Y performs it instead of a as well; so does a stable state of the
specification whose offer is within Y and has a. In R the machine goes on after it as after a; in V nothing comes
after. A stable state that offers nothing performs an event that stands for its deadlock. Then ``P [V= Q`` and
``P [R= Q`` are inclusions of traces, and VD and RD are the same with divergences: a specification that can diverge
allows everything from there on.

A state that can tick offers tick alone, as everywhere; what else it does belongs to states before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from cspcheck.checker.arrays import BoolArray, Int64Array, distinct
from cspcheck.checker.budget import Budget, Incomplete
from cspcheck.checker.lts import Lts, machine, sources
from cspcheck.checker.sparse_rows import gather_rows
from cspcheck.checker.specification.acceptances import StateAcceptances
from cspcheck.cspm.process.events import FIRST_EVENT, TAU, TICK

Observed = Literal["V", "R"]

MOST_OBSERVATIONS = 20_000_000
"""So many transitions that observe something may be added to a machine."""


@dataclass(frozen=True, eq=False, slots=True)
class Observations:
    """Two machines whose traces are what can be observed of two others.

    States keep their numbers; two more stand for SKIP and what is left of it where a state can tick and do something
    else as well, and one for the end of observation.

    Attributes:
        specification, implementation: the machines.
        events: what the labels from ``FIRST_EVENT`` on stand for, the events of both machines in order.
        offers: the implementation's different offers, as labels.
        skip: the number of the implementation's state SKIP.
    """

    specification: Lts
    implementation: Lts
    events: Int64Array
    offers: tuple[frozenset[int], ...]
    skip: int

    def event(self, label: int) -> int:
        """The event of the script that a label stands for, observed with a refusal or not; -1 for a deadlock."""
        plain = self.plain(label)
        return plain if plain < FIRST_EVENT else int(self.events[plain - FIRST_EVENT])

    def plain(self, label: int) -> int:
        """The label of the event itself; -1 for a deadlock."""
        if label < self._first:
            return label
        return (label - self._first) % self._width - 1

    def offer(self, label: int) -> frozenset[int] | None:
        """For an observation the offer that it is made in, as events of the script; None for an event alone."""
        if label < self._first:
            return None
        return self.as_events(self.offers[(label - self._first) // self._width])

    def as_events(self, labels: frozenset[int]) -> frozenset[int]:
        """The events of the script for labels of events alone."""
        return frozenset(self.event(label) for label in labels)

    @property
    def _first(self) -> int:
        return FIRST_EVENT + len(self.events)

    @property
    def _width(self) -> int:
        return self._first + 1


def observations(specification: Lts, implementation: Lts, model: Observed, budget: Budget) -> Observations:
    """What can be observed of two machines.

    Raises:
        Incomplete: there is too much of it.
    """
    present = distinct(np.concatenate([specification.labels, implementation.labels]))
    events = present[present >= FIRST_EVENT]
    impl, spec = (_prepared(lts, events) for lts in (implementation, specification))
    offers = tuple(impl.offers)
    first = FIRST_EVENT + len(events)
    within = _within(spec.offers, offers, first)
    own = np.eye(len(offers), dtype=np.bool_)
    budget.check_time("working out what can be observed")
    return Observations(
        _observed(spec, within, offers, model, first, diverges=True),
        _observed(impl, own, offers, model, first, diverges=False),
        events,
        offers,
        implementation.states,
    )


@dataclass(frozen=True, eq=False, slots=True)
class _Prepared:
    """A machine with dense labels in which a tick is all that a state can do, and the offers of its stable states.

    ``number`` tells which of ``offers`` a state has; -1 if it has none, for want of stability or after a tick.
    """

    lts: Lts
    number: Int64Array
    offers: list[frozenset[int]]


def _prepared(lts: Lts, events: Int64Array) -> _Prepared:
    labels = np.where(lts.labels < FIRST_EVENT, lts.labels, FIRST_EVENT + np.searchsorted(events, lts.labels))
    starts, targets = sources(lts), lts.targets.copy()
    skip, ended, end = lts.states, lts.states + 1, lts.states + 2
    early = (lts.labels == TICK) & (np.diff(lts.offsets)[starts] > 1)
    labels[early], targets[early] = TAU, skip
    whole = machine(end + 1, np.append(starts, skip), np.append(labels, TICK), np.append(targets, ended), lts.root)
    accepting = StateAcceptances(whole, whole.labels)
    number = accepting.number.copy()
    number[whole.targets[whole.labels == TICK]] = -1
    number[[ended, end]] = -1
    used, number_of_used = np.unique(number[number >= 0], return_inverse=True)
    number[number >= 0] = number_of_used
    return _Prepared(whole, number, [frozenset(accepting.acceptances[i]) for i in used.tolist()])


def _within(smaller: list[frozenset[int]], greater: tuple[frozenset[int], ...], labels: int) -> BoolArray:
    """Which of some offers are part of which others, shape (smaller, greater)."""
    if len(smaller) * len(greater) > MOST_OBSERVATIONS:
        raise Incomplete(_too_much())

    def table(offers: Sequence[frozenset[int]]) -> npt.NDArray[np.float32]:
        rows = np.zeros((len(offers), labels), dtype=np.float32)
        for row, offer in zip(rows, offers, strict=True):
            row[list(offer)] = 1
        return rows

    few = table(smaller)
    within: BoolArray = few @ table(greater).T == few.sum(axis=1, keepdims=True)
    return within


def _too_much() -> str:
    return f"more than {MOST_OBSERVATIONS:,} different observations of refusals would have to be compared"


def _observed(
    prepared: _Prepared,
    within: BoolArray,
    offers: tuple[frozenset[int], ...],
    model: Observed,
    first: int,
    *,
    diverges: bool,
) -> Lts:
    """The machine with its observations.

    Args:
        prepared: the machine.
        within: which of its own offers are part of which of *offers*.
        offers: those of the implementation.
        model: V or R.
        first: the first label that is none of an event.
        diverges: whether a tau to a deadlock is added everywhere, so that no refusal is wrong where only divergence
            is to be looked at beside traces.
    """
    lts = prepared.lts
    end = lts.states - 1
    starts, labels, targets = [sources(lts)], [lts.labels], [lts.targets]
    degrees = np.diff(lts.offsets)
    width = first + 1
    by_offer = [np.flatnonzero(prepared.number == i) for i in range(len(prepared.offers))]
    added = sum(int(row.sum()) * int(degrees[states].sum()) for row, states in zip(within, by_offer, strict=True))
    if added > MOST_OBSERVATIONS:
        raise Incomplete(_too_much())
    for row, states in zip(within, by_offer, strict=True):
        rows = gather_rows(lts.offsets, states)
        origins = np.repeat(states, degrees[states])
        for offer in np.flatnonzero(row).tolist():
            base = first + offer * width
            if not offers[offer]:
                starts.append(states)
                labels.append(np.full(len(states), base, dtype=np.int64))
                targets.append(np.full(len(states), end, dtype=np.int64))
            starts.append(origins)
            labels.append(base + 1 + lts.labels[rows])
            targets.append(lts.targets[rows] if model == "R" else np.full(len(rows), end, dtype=np.int64))
    if diverges:
        others = np.setdiff1d(np.arange(lts.states), [end])
        starts.append(others)
        labels.append(np.full(len(others), TAU, dtype=np.int64))
        targets.append(np.full(len(others), end, dtype=np.int64))
    return machine(lts.states, np.concatenate(starts), np.concatenate(labels), np.concatenate(targets), lts.root)
