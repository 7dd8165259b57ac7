"""Refinement in the models of revivals (V, VD) and of refusal testing (R, RD), by the machines of observations."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from cspcheck.checker.checks.context import Context, reached
from cspcheck.checker.checks.refinement import REPLAYED_SPECIFICATION, first_violation
from cspcheck.checker.explain.behaviour import Behaviour, diverging
from cspcheck.checker.explain.replay import ReplayFailure, can_perform
from cspcheck.checker.explain.specification_run import specification_run
from cspcheck.checker.network.network import Network, Rule, Slot
from cspcheck.checker.packing.packed import pack
from cspcheck.checker.search.exploration import Exploration
from cspcheck.checker.search.pair_search import PairExploration, explore_pairs
from cspcheck.checker.search.paths import PathStep
from cspcheck.checker.semantics.transitions import Semantics, offer
from cspcheck.checker.specification.normaliser import Normaliser
from cspcheck.checker.specification.observations import Observations, Observed, observations
from cspcheck.checker.verdict import Counterexample, Outcome, Verdict
from cspcheck.cspm.process.events import TAU, TICK
from cspcheck.cspm.process.terms import Process

ObservedModel = Literal["V", "VD", "R", "RD"]


def refines_observed(
    context: Context, specification: Process, model: ObservedModel, implementation: Process
) -> Outcome:
    """Whether ``specification [model= implementation``.

    Both sides are explored as a whole, without compressions, which these models could tell. States and transitions
    count the pairs of the search, whose transitions include the observations.

    Raises:
        Incomplete: a side could not be explored, or there is too much to be observed.
    """
    machines, budget = context.machines, context.budget
    exploration = machines.exploration(implementation, "everything", budget, original=True)
    observed: Observed = "V" if model.startswith("V") else "R"
    seen = observations(
        machines.lts(specification, budget, " in the specification", original=True),
        machines.lts(implementation, budget, original=True),
        observed,
        budget,
    )
    semantics: Literal["T", "FD"] = "FD" if model.endswith("D") else "T"
    normal_form = Normaliser(seen.specification, semantics)
    pairs = explore_pairs(
        pack(_network(seen)),
        normal_form,
        semantics,
        full=machines.full,
        limits=budget.remaining(),
        workers=machines.workers,
    )
    budget.used(pairs.peak_memory_bytes + normal_form.nbytes)
    if pairs.violation_level is None:
        return context.not_found(pairs, "violation")
    if context.whole is None:  # levels are not those of events
        context.failed(int(pairs.levels[-1]), pairs.transitions)
    counterexample = _Explanation(context, specification, implementation, exploration, seen, normal_form, pairs).made()
    return budget.outcome(Verdict.FAIL, None, int(pairs.levels[-1]), pairs.transitions, counterexample)


def _network(seen: Observations) -> Network:
    lts = seen.implementation
    return Network(
        (Slot("", None, lts, ()),),
        tuple(Rule(label, ((0, label),), label) for label in lts.alphabet()),
        initial=((0, lts.root),),
        terminated=TICK in lts.alphabet(),
    )


@dataclass(frozen=True, slots=True)
class _Observation:
    """A step of the implementation: its event, the state after it, and the offer that was observed before, if any."""

    event: int
    after: int
    offered: frozenset[int] | None


@dataclass(frozen=True, slots=True)
class _Explanation:
    """From a violation among the observations to a run of the process."""

    context: Context
    specification: Process
    implementation: Process
    exploration: Exploration
    seen: Observations
    normal_form: Normaliser
    pairs: PairExploration

    def made(self) -> Counterexample:
        """The counterexample."""
        path, violation = first_violation(self.pairs)
        events = self.context.events
        run = self._run(path)
        steps = self._steps(run)
        behaviour = Behaviour(self.implementation, self.exploration.packed, steps, events)
        trace = tuple(step.event for step in run if step.event != TAU)
        refusals = self._refusals(run)
        if violation.kind == "divergence":
            end = reached(self.exploration, steps)
            found = diverging(self.implementation, self.exploration, steps, end, events)
            allowed: tuple[tuple[str, ...], ...] = ()
            event, offered = None, None
        else:
            event, offered = self.seen.event(violation.event), self.seen.offer(violation.event)
            self._confirm(behaviour, run, event, offered)
            node = int(self.pairs.nodes[violation.index])
            allowed = self._allowed(node, offered is not None)
            found = Counterexample(
                "trace" if offered is None else "refusal",
                behaviour.trace,
                behaviour.causes,
                event=None if event < 0 else events.name(event),
                refusal=None if offered is None else self._names(self._alphabet() - offered),
                offered=None if offered is None else self._names(offered),
                allowed=allowed,
                components=behaviour.components(),
                run=behaviour.run,
                event_parts=behaviour.parts_in(event) if offered is None else (),
            )
        return replace(
            found,
            specification_trace=tuple(events.name(event) for event in trace),
            specification=specification_run(self.specification, trace, events),
            refusals=refusals if any(refusals) else None,
        )

    def _run(self, path: tuple[PathStep, ...]) -> list[_Observation]:
        """The steps of the process's own machine; the tau to SKIP in front of a tick is none."""
        run = []
        packed = self.pairs.packed
        for step in path:
            (state,) = packed.local_states(np.array(step.state, dtype=np.int64))
            if state == self.seen.skip:
                continue
            run.append(_Observation(self.seen.event(step.event), state, self.seen.offer(step.event)))
        return run

    def _steps(self, run: list[_Observation]) -> tuple[PathStep, ...]:
        """The run as steps of the process's network."""
        steps = []
        here = 0
        for seen in run:
            found = self.exploration.successors(np.array([here], dtype=np.int64))
            fitting = found.events == seen.event
            if seen.event != TICK:
                fitting &= self.exploration.indices(found.targets) == seen.after
            pick = int(np.flatnonzero(fitting)[0])
            words = found.targets[pick]
            steps.append(PathStep(seen.event, int(found.rules[pick]), tuple(words.tolist()), 0))
            here = self.exploration.index(words)
        return tuple(steps)

    def _alphabet(self) -> frozenset[int]:
        return frozenset(self.seen.events.tolist())

    def _names(self, events: frozenset[int]) -> tuple[str, ...]:
        return tuple(self.context.events.name(event) for event in sorted(events))

    def _refusals(self, run: list[_Observation]) -> tuple[tuple[str, ...] | None, ...]:
        return tuple(None if seen.offered is None else self._names(self._alphabet() - seen.offered) for seen in run)

    def _allowed(self, node: int, refused: bool) -> tuple[tuple[str, ...], ...]:
        """The offers that the specification can settle for at a node, or the events that it can perform there."""
        seen, labels = self.seen, self.seen.specification
        offers = set()
        possible = set()
        for state in self.normal_form.members(node).tolist():
            row = [label for label, _ in labels.successors(state)]
            events = {seen.event(label) for label in row if seen.offer(label) is None and label != TAU}
            possible |= events
            # The tau to the end of observation has been added to every state.
            if row.count(TAU) == 1 and events:
                offers.add(frozenset(events))
        if not refused:
            return (self._names(frozenset(possible)),)
        return tuple(self._names(offer) for offer in sorted(offers, key=lambda offer: (len(offer), sorted(offer))))

    def _confirm(
        self, behaviour: Behaviour, run: list[_Observation], event: int, offered: frozenset[int] | None
    ) -> None:
        """Replay the run, and hold what was observed in it against the terms of both sides.

        Raises:
            ReplayFailure: the implementation does not have the observations, or the specification does.
        """
        if offered is None:
            behaviour.confirm(can_perform(event), "a state with the forbidden event")
        else:
            behaviour.confirm(lambda row: offer(row) == offered, "a state that offers what was observed")
        seen = [(step.event, step.offered) for step in run if step.event != TAU]
        if event >= 0:
            seen.append((event, offered))
        is_deadlock = event < 0
        if _observable(self.implementation, seen, is_deadlock=is_deadlock) is False:
            raise ReplayFailure("the process does not have the observations that were found")
        if _observable(self.specification, seen, is_deadlock=is_deadlock):
            raise ReplayFailure("the specification has the observations that it was said not to allow")


def _observable(
    process: Process, seen: Iterable[tuple[int, frozenset[int] | None]], *, is_deadlock: bool
) -> bool | None:
    """Whether the terms of a process have observations, at the end a deadlock; None if that takes too long to see."""
    semantics = Semantics()
    states = _settling(semantics, {semantics.state(process)})
    for event, offered in seen:
        if states is None:
            return None
        states = _settling(semantics, _after(semantics, states, event, offered))
    if states is None:
        return None
    return any(not is_deadlock or semantics.transitions(state) == () for state in states)


def _after(semantics: Semantics, states: set[Process], event: int, offered: frozenset[int] | None) -> set[Process]:
    """Where *event* leads from the states that can be seen to refuse all that was not offered, if that was observed."""
    found: set[Process] = set()
    for state in states:
        row = semantics.transitions(state)
        accepted = offer(row)
        if offered is None or (accepted is not None and accepted <= offered and event in accepted):
            found.update(after for label, after in row if label == event)
    return found


def _settling(semantics: Semantics, states: set[Process]) -> set[Process] | None:
    """All states that taus lead to; None if they are too many."""
    seen = set(states)
    pending = list(seen)
    while pending:
        if len(seen) > REPLAYED_SPECIFICATION:
            return None
        for event, after in semantics.transitions(pending.pop()):
            if event == TAU and after not in seen:
                seen.add(after)
                pending.append(after)
    return seen
