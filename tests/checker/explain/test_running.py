"""Transitions are told apart by what each component does in them; nothing is explored for that."""

from __future__ import annotations

from hypothesis import given, settings, strategies as st

from cspcheck.checker.explain.running import Runner, Running, RunningComponent, distinct_names
from cspcheck.checker.semantics.derivation import Derivation, derive
from cspcheck.checker.semantics.transitions import MoreStates, Semantics, breadth_first
from cspcheck.cspm.process.events import TAU, TICK
from cspcheck.cspm.process.terms import SKIP, STOP, Hide, Interrupt, LinkedParallel, Process, Rename, Throw
from tests.checker.terms import compositions, layered, processes, reference
from tests.checker.textbook import a, b, c, choose, d, events, forever, hidden, interleave, sequence, share, then

terms = st.one_of(processes(size=8), compositions(size=5, components=3), layered())


def run(process: Process, *labels: int) -> tuple[Running, list[dict[str, int]]]:
    """A run along labels, always the first transition with the label; what each component did."""
    runner = Runner()
    running = runner.start(process)
    done = []
    for label in labels:
        after = next(state for event, state in runner.steps(running) if event == label)
        running, performed = runner.perform(running, label, after)
        done.append({component.name: event for component, event in performed.parts.items()})
    return running, done


def names(running: Running) -> list[str]:
    return [component.name for component, _ in running.components()]


def holds(semantics: Semantics, state: Process, step: Derivation) -> bool:
    """Every premise is a transition of its operand, and the premises alone give the step."""
    operands = state.active()
    for i, move in step.moves:
        if (move.event, move.after) not in semantics.transitions(operands[i]) or not holds(
            semantics, operands[i], move
        ):
            return False
    return (step.event, step.after) in semantics.transitions(state)


@settings(deadline=None)
@given(terms)
def test_every_transition_is_derived_from_transitions_of_its_operands(process: Process) -> None:
    semantics = Semantics()
    try:
        explored = breadth_first(semantics.state(process), semantics.transitions, 60, None).terms
    except MoreStates as more:
        explored = tuple(more.terms)
    for state in explored:
        for event, after in semantics.transitions(state):
            assert holds(semantics, state, derive(semantics, state, event, after))


@settings(deadline=None)
@given(terms, st.lists(st.integers(0, 100), max_size=12))
def test_components_and_state_stay_together_on_any_run(process: Process, choices: list[int]) -> None:
    runner = Runner()
    running = runner.start(process)
    for choice in choices:
        steps = runner.steps(running)
        if not steps:
            break
        before = dict(running.components())
        event, after = steps[choice % len(steps)]
        running, performed = runner.perform(running, event, after)
        following = dict(running.components())
        assert running.state is after
        assert performed.parts.keys() <= before.keys()
        for component, state in before.items():
            if component not in performed.parts and component in following:
                assert following[component] is state
            if component in performed.parts:
                assert any(label == performed.parts[component] for label, _ in runner.semantics.transitions(state))


class TestComponents:
    def test_operands_are_called_by_their_names(self) -> None:
        left, right = forever(a, name="Left"), forever(b, name="Right")
        running, done = run(share(events(), left, right), b)
        assert names(running) == ["Left", "Right"]
        assert done == [{"Right": b}]

    def test_all_take_part_in_a_shared_event(self) -> None:
        left, right = forever(a, name="Left"), forever(a, name="Right")
        assert run(share(events(a), left, right), a)[1] == [{"Left": a, "Right": a}]

    def test_of_two_that_could_the_first_is_named(self) -> None:
        assert run(interleave(forever(a, name="Left"), forever(a, name="Right")), a)[1] == [{"Left": a}]

    def test_what_a_sequence_passes_on_to_has_its_own_components(self) -> None:
        first = interleave(reference("A", lambda: then(a, SKIP)), reference("B", lambda: then(b, SKIP)))
        second = interleave(forever(c, name="C"), forever(d, name="D"))
        running, done = run(sequence(first, second), a, b, TAU, d)
        assert names(running) == ["C", "D"]
        assert done == [{"A": a}, {"B": b}, {"A": TICK, "B": TICK}, {"D": d}]

    def test_a_loop_comes_back_to_the_same_components(self) -> None:
        loop = reference("Loop", lambda: sequence(interleave(forever_once(a, "A"), forever_once(b, "B")), loop))
        runner = Runner()
        start = runner.start(loop)
        running = start
        for label in (a, b, TAU, a):
            running, _ = runner.perform(running, *next(step for step in runner.steps(running) if step[0] == label))
        assert [c for c, _ in running.components()] == [c for c, _ in start.components()]

    def test_a_component_that_becomes_a_composition_makes_room_for_it(self) -> None:
        system = reference("System", lambda: interleave(forever(a, name="A"), forever(b, name="B")))
        running, _ = run(then(c, system), c)
        assert names(running) == ["A", "B"]

    def test_who_interrupts_stays_who_it_was(self) -> None:
        left = interleave(forever(a, name="A"), forever(b, name="B"))
        running, done = run(Interrupt(left, forever(c, name="Alarm")), a, c)
        assert names(running) == ["Alarm"]
        assert done[1] == {"Alarm": c}

    def test_an_exception_hands_over_to_its_handler(self) -> None:
        left = interleave(forever(a, name="A"), forever(b, name="B"))
        running, _ = run(Throw(left, events(b), forever(c, name="Handler")), b)
        assert names(running) == ["Handler"]

    def test_parts_without_a_name_are_counted_in_the_definition_around_them(self) -> None:
        pair = reference("Pair", lambda: interleave(then(a, STOP), then(b, STOP)))
        assert names(run(pair)[0]) == ["part 1 of Pair", "part 2 of Pair"]

    def test_equal_names_are_numbered(self) -> None:
        assert distinct_names(["U", "L", "U"]) == ["U #1", "L", "U #2"]


class TestCauses:
    def cause(self, process: Process) -> int | None:
        runner = Runner()
        running = runner.start(process)
        return runner.performed(running, *next(step for step in runner.steps(running) if step[0] == TAU)).cause

    def test_a_hidden_event_is_the_cause_of_its_tau(self) -> None:
        assert self.cause(hidden(then(a, STOP), a)) == a

    def test_the_name_that_was_hidden_is_told_not_the_one_below(self) -> None:
        assert self.cause(Hide(Rename(then(a, STOP), ((a, b),)), events(b))) == b

    def test_a_link_is_told_by_its_left_end(self) -> None:
        assert self.cause(LinkedParallel(then(a, STOP), ((a, b),), then(b, STOP))) == a

    def test_a_choice_has_no_cause(self) -> None:
        assert self.cause(choose(then(b, STOP), hidden(then(a, STOP), a))) == a
        assert self.cause(sequence(SKIP, then(a, STOP))) is None


def forever_once(event: int, name: str) -> Process:
    return reference(name, lambda: then(event, SKIP))


def test_components_are_told_apart_by_identity() -> None:
    assert RunningComponent("A", None) != RunningComponent("A", None)
