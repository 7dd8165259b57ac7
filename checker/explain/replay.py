"""Replaying behaviours against the operational semantics: no counterexample is shown that the terms do not have.

The searches work on packed integers and rules; here the same behaviour is performed by the process terms
themselves, by ``cspcheck.checker.semantics.transitions`` and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from cspcheck.checker.network.compiler import Compiler
from cspcheck.checker.semantics.steps import Row
from cspcheck.checker.semantics.transitions import offer
from cspcheck.cspm.process.events import TAU
from cspcheck.cspm.process.terms import Process

CROWD = 64
"""So many terms may be followed side by side before the components' states are used to tell them apart."""


States = dict[Process, None]
"""A set of terms in the order in which they were met, so that what is told of them is always the same."""


class ReplayFailure(Exception):
    """A behaviour found by a search is not one of the process: the tool contradicts itself, which is its own bug."""


class Replay:
    """The states, as terms, that a process can be in after the transitions replayed so far.

    Attributes:
        states: the terms. Nearly always one; more where a label leads to several states.
        semantics: the transitions of terms.
    """

    def __init__(self, process: Process, *, in_order: bool = False) -> None:
        """*in_order*: where many states are alike, those count whose components are as they are, in the same order.

        Of many equal components each may be where another could be as well; only the order tells these states apart.
        It does so where components stand in a term as they are numbered.
        """
        self._process = process
        self._in_order = in_order
        self.semantics = Compiler().semantics
        self._rows: dict[Process, Row] = {}
        self.states: States = {self.semantics.state(process): None}
        self._labels: list[int] = []
        self._before: list[States] = []
        self._loops: dict[Process, list[States]] = {}

    def row(self, state: Process) -> Row:
        """The transitions of a state."""
        row = self._rows.get(state)
        if row is None:
            row = self._rows[state] = self.semantics.transitions(state)
        return row

    def step(self, label: int, components: Iterable[Process] = ()) -> None:
        """Perform *label*, leading to a state made of *components*.

        Raises:
            ReplayFailure: no state can.
        """
        self._labels.append(label)
        self._before.append(self.states)
        self.states = self._narrowed(self._after(self.states, label), components)
        if not self.states:
            raise ReplayFailure(f"the process has no transition {label} where the search found one")

    def expect(self, holds: Callable[[Row], bool], claim: str) -> None:
        """Keep the states whose transitions satisfy *holds*.

        Raises:
            ReplayFailure: none does; *claim* says what they should be (``a deadlock``).
        """
        self.states = {state: None for state in self.states if holds(self.row(state))}
        if not self.states:
            raise ReplayFailure(f"the behaviour that was found does not end in {claim}")

    def expect_loop(self, loop: Iterable[Iterable[Process]]) -> None:
        """Keep the states to which as many taus as *loop* has entries, each with its components, lead back.

        Raises:
            ReplayFailure: there is none.
        """
        entries = [tuple(components) for components in loop]
        kept: States = {}
        for state in self.states:
            passed: list[States] = [{state: None}]
            for components in entries:
                passed.append(self._narrowed(self._after(passed[-1], TAU), components))
            if state in passed[-1]:
                kept[state] = None
                self._loops[state] = passed[:-1]
        self.states = kept
        if not kept or not entries:
            raise ReplayFailure("the behaviour that was found does not end in a cycle of taus")

    def run(self) -> list[tuple[int, Process]]:
        """The labels replayed, each with the state after it, of a run to the first of the states at the end."""
        return self._backwards(next(iter(self.states)), self._labels, self._before)

    def loop(self) -> list[tuple[int, Process]]:
        """The taus that lead from the first of the states at the end back to it, as :meth:`expect_loop` found them."""
        end = next(iter(self.states))
        passed = self._loops.get(end, [])
        return self._backwards(end, [TAU] * len(passed), passed)

    def _backwards(self, end: Process, labels: list[int], passed: list[States]) -> list[tuple[int, Process]]:
        found: list[tuple[int, Process]] = []
        for label, before in zip(reversed(labels), reversed(passed), strict=True):
            found.append((label, end))
            end = next(state for state in before if (label, end) in self.row(state))
        return found[::-1]

    def _after(self, states: Iterable[Process], label: int) -> States:
        return {target: None for state in states for event, target in self.row(state) if event == label}

    def _narrowed(self, states: States, components: Iterable[Process]) -> States:
        wanted = list(components)
        if len(states) <= CROWD or not wanted:
            return states
        if self._in_order:
            kept = {state: None for state in states if _occur(wanted, _parts(state))}
        else:
            kept = {state: None for state in states if set(wanted) <= set(_parts(state))}
        return kept or states


def _occur(wanted: Iterable[Process], parts: Iterator[Process]) -> bool:
    """Whether terms are among others, in their order."""
    return all(any(part is one for part in parts) for one in wanted)


def _parts(term: Process) -> Iterator[Process]:
    """The term and everything that runs in it, from left to right."""
    pending = [term]
    while pending:
        part = pending.pop()
        yield part
        pending.extend(reversed(tuple(part.active())))


def states_after(process: Process, trace: Iterable[int], limit: int) -> list[Row] | None:
    """The transitions of every state that *process* can be in after a trace of visible events, taus included.

    None if more than *limit* states would have to be looked at for some prefix.
    """
    replay = Replay(process)

    def closed(states: set[Process]) -> set[Process] | None:
        pending = list(states)
        while pending:
            if len(states) > limit:
                return None
            for event, target in replay.row(pending.pop()):
                if event == TAU and target not in states:
                    states.add(target)
                    pending.append(target)
        return states

    states = closed(set(replay.states))
    for label in trace:
        if states is None:
            return None
        states = closed({target for state in states for event, target in replay.row(state) if event == label})
    return None if states is None else [replay.row(state) for state in states]


def can_perform(event: int) -> Callable[[Row], bool]:
    """Tells from a state's transitions whether it can perform *event*."""
    return lambda row: any(label == event for label, _ in row)


def can_refuse(event: int) -> Callable[[Row], bool]:
    """Tells from a state's transitions whether it can be relied on for something and *event* is not part of it."""

    def holds(row: Row) -> bool:
        accepted = offer(row)
        return accepted is not None and event not in accepted

    return holds
