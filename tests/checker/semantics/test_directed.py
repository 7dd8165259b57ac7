"""What a state becomes by one event is what its transitions say, for every operator, at every depth."""

from __future__ import annotations

from contextlib import suppress

from hypothesis import given, settings, strategies as st

from cspcheck.checker.semantics.directed import Directed
from cspcheck.checker.semantics.transitions import MoreStates, Semantics, breadth_first
from cspcheck.cspm.process.events import FIRST_EVENT, TAU, TICK, EventSet
from cspcheck.cspm.process.terms import Process
from tests.checker.terms import processes
from tests.examples import examples


@settings(max_examples=examples(300))
@given(st.one_of(processes(), processes(clocks=EventSet.of([FIRST_EVENT]))))
def test_one_event_at_a_time_gives_all_transitions(process: Process) -> None:
    semantics = Semantics()
    directed = Directed(semantics)
    terms: list[Process] = []
    with suppress(MoreStates):
        breadth_first(semantics.state(process), semantics.transitions, 60, terms=terms)
    for state in terms:
        row = semantics.transitions(state)
        assert directed.initials(state) == {event for event, _ in row}
        for event in {TAU, TICK, *range(FIRST_EVENT, FIRST_EVENT + 6), *[event for event, _ in row]}:
            after = directed.after(state, event)
            targets = [semantics.state(target) for target in after]
            assert len(set(after)) == len(after)
            assert set(targets) == {semantics.state(target) for label, target in row if label == event}
