"""Who waits for whom: an offered event that cannot happen names the components that it lacks."""

from __future__ import annotations

import pytest
from hypothesis import given, settings

from cspcheck.checker.explain import blocked_terms
from cspcheck.checker.explain.blocked_slots import blocked, shortest_cycle
from cspcheck.checker.explain.blocked_terms import waiting
from cspcheck.checker.explain.running import Runner
from cspcheck.checker.network.compiler import compile_network
from cspcheck.cspm.process.terms import SKIP, STOP, LinkedParallel, Process, Rename
from tests.checker.terms import compositions, reference
from tests.checker.textbook import a, b, c, choose, d, events, forever, hidden, interleave, meet, sequence, share, then

ab = events(a, b)


def named(name: str, *sequence: int) -> Process:
    return reference(name, lambda: then(*sequence, STOP))


def waits(process: Process) -> dict[str, list[str]]:
    """Who waits for whom in the initial state."""
    network = compile_network(process)
    name = [slot.name for slot in network.slots]
    found = blocked(process, network, network.initial_format, dict(network.initial))
    return {name[slot]: [name[other] for other in sorted(others)] for slot, others in found.items()}


def waits_as_terms(process: Process) -> dict[str, list[str]]:
    """The same, without a network."""
    runner = Runner()
    found = waiting(runner.semantics, runner.start(process))
    return {component.name: [other.name for other in others] for component, others in found.items()}


P, Q, R = named("P", a), named("Q", b), named("R", c)


@pytest.mark.parametrize(
    ("process", "expected"),
    [
        pytest.param(interleave(P, Q), {}, id="nobody when everything can happen"),
        pytest.param(share(ab, P, named("Q", b, a)), {"P": ["Q"], "Q": ["P"]}, id="each for the other"),
        pytest.param(share(ab, P, Q), {"P": ["Q"], "Q": ["P"]}, id="for one that will never be ready"),
        pytest.param(share(events(a), P, interleave(Q, R)), {"P": ["Q", "R"]}, id="for a group of which none ever is"),
        pytest.param(
            share(events(a), P, interleave(named("Q", b, a), R)), {"P": ["Q"]}, id="for the one that may be ready later"
        ),
        pytest.param(
            share(events(a), P, interleave(named("Q", b, a), named("R", c, a))),
            {"P": ["Q", "R"]},
            id="for either of two",
        ),
        pytest.param(
            share(events(a), P, interleave(named("Q", b, a), P)), {}, id="not when one of the alternatives is ready"
        ),
        pytest.param(meet((ab, P), (events(b), named("Q", b))), {"Q": ["P"]}, id="in alphabetised parallel"),
        pytest.param(meet((events(b), P), (events(b), Q)), {"Q": ["P"]}, id="not with an event outside its alphabet"),
        pytest.param(LinkedParallel(P, ((a, b),), named("Q", c, b)), {"P": ["Q"]}, id="over a link"),
        pytest.param(LinkedParallel(P, ((a, b),), R), {"P": ["R"]}, id="over a link that nobody holds"),
        pytest.param(
            hidden(share(events(a), P, named("Q", b, a)), a), {"P": ["Q"]}, id="for an event that is hidden outside"
        ),
        pytest.param(
            share(events(d), Rename(P, ((a, d),)), named("Q", b, d)), {"P": ["Q"]}, id="for an event under its new name"
        ),
        pytest.param(
            share(events(b), share(events(a), P, named("Q", b, a)), R),
            {"P": ["Q"], "Q": ["R"]},
            id="through two compositions",
        ),
    ],
)
def test_waits(process: Process, expected: dict[str, list[str]]) -> None:
    assert waits(process) == expected
    assert waits_as_terms(process) == expected


def test_what_one_event_lacks_is_no_matter_where_another_can_happen() -> None:
    """Q offers a, which P is not ready for; that Q can do b instead does not make a possible."""
    two = reference("Q", lambda: choose(then(a, STOP), then(b, STOP)))
    process = share(events(a), named("P", c, a), two)
    assert waits(process) == waits_as_terms(process) == {"Q": ["P"]}


def test_of_components_behind_a_sequence_the_terms_tell_more_than_the_network() -> None:
    process = sequence(share(ab, P, named("Q", b, a)), R)
    assert waits(process) == {}
    assert waits_as_terms(process) == {"P": ["Q"], "Q": ["P"]}


def test_who_has_ended_waits_for_the_others_to_end() -> None:
    done, busy = reference("Done", lambda: SKIP), share(events(a), named("P", a), named("Q", b))
    assert waits_as_terms(interleave(done, busy)) == {"Done": ["P", "Q"], "P": ["Q"]}


def test_who_could_still_do_something_else_keeps_the_others_from_ending() -> None:
    done, more = reference("Done", lambda: SKIP), reference("More", lambda: choose(then(a, STOP), SKIP))
    process = interleave(interleave(done, more), reference("Third", lambda: SKIP))
    assert waits(process) == waits_as_terms(process) == {"Done": ["More"], "Third": ["More"]}


@settings(deadline=None)
@given(compositions(size=5, components=3))
def test_the_terms_tell_who_waits_as_the_network_does(process: Process) -> None:
    network = compile_network(process)
    if network.formats > 1 or len(network.slots) == 1:
        return
    runner = Runner()
    running = runner.start(process)
    components = [component for component, _ in running.components()]
    if len(components) != len(network.slots):
        return  # an operand with parts of its own, which the network leaves whole
    ruled = {move for rule in network.rules for move in rule.moves}
    if any(label and (i, label) not in ruled for i, slot in enumerate(network.slots) for label in slot.lts.alphabet()):
        return  # whom to blame for what can never happen is a matter of taste
    found = waiting(runner.semantics, running)
    numbers = {component: i for i, component in enumerate(components)}
    in_terms = {numbers[c]: {numbers[other] for other in others} for c, others in found.items()}
    by_rules = blocked(process, network, network.initial_format, dict(network.initial))
    assert in_terms == by_rules


def test_nothing_is_made_up_for_a_process_that_was_not_taken_apart() -> None:
    """Under a prefix the components are states of one machine."""
    assert waits(then(d, share(ab, P, Q))) == {}


def test_the_shortest_cycle_and_of_equals_the_earliest() -> None:
    assert shortest_cycle({0: {1}, 1: {2}, 2: {0}}) == (0, 1, 2)
    assert shortest_cycle({0: {1, 3}, 1: {2}, 2: {0}, 3: {0}}) == (0, 3)
    assert shortest_cycle({0: {1}, 1: {2}, 2: {1}, 3: {4}, 4: {3}}) == (1, 2)
    assert shortest_cycle({0: {1}, 1: {2}}) is None
    assert shortest_cycle({}) is None


def test_forever_is_named_by_its_definition() -> None:
    assert waits(share(ab, forever(a, b, name="Left"), forever(b, a, name="Right"))) == {
        "Left": ["Right"],
        "Right": ["Left"],
    }


def test_who_has_too_many_transitions_to_look_at_may_be_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    process = share(events(a), P, interleave(named("Q", b, a), R))
    monkeypatch.setattr(blocked_terms, "TRANSITIONS_LOOKED_AT", 0)
    assert waits_as_terms(process) == {"P": ["Q", "R"]}
