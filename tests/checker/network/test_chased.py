"""What is chased is worked out on tuples and in turns with its company: the same as its rule says of terms."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any
from unittest.mock import patch

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.checker.network import chased, compiler
from cspcheck.checker.network.compiler import Compiler, compile_network
from cspcheck.checker.network.lazily import LazyComposition, is_chased
from cspcheck.checker.network.network import Network
from cspcheck.checker.packing.packed import pack
from cspcheck.checker.search import exploration as search
from cspcheck.checker.search.company import together
from cspcheck.checker.semantics.transitions import Explored, LimitReached, Poll, Semantics, explore
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import (
    STOP,
    AlphabetisedParallel,
    Compressed,
    External,
    ExternalChoice,
    Hide,
    InternalChoice,
    LinkedParallel,
    Parallel,
    Prefix,
    Process,
    Project,
    Rename,
    SlidingChoice,
)
from tests.checker.exploring import interpreted
from tests.checker.network.test_composition import assert_same_machine
from tests.checker.terms import reference
from tests.checker.textbook import a, b, c, choose, interleave, perhaps, share, then
from tests.examples import examples

MANY = settings(max_examples=examples(80))
EVENTS = st.integers(2, 4)
SETS = st.sets(EVENTS, min_size=1).map(EventSet.of)
Draw = Callable[[st.SearchStrategy[Any]], Any]


@st.composite
def components(draw: Draw) -> Process:
    """A process of a few states that never ends: choices between events, and taus."""
    states = draw(st.integers(1, 3))
    rows = []
    for _ in range(states):
        moves = st.lists(st.tuples(EVENTS, st.integers(0, states - 1)), min_size=1, max_size=3)
        rows.append((draw(st.sampled_from(("[]", "|~|", "[>"))), draw(moves)))
    names: list[Process] = []

    def body(number: int) -> Callable[[], Process]:
        def made() -> Process:
            operator, moves = rows[number]
            steps = tuple(Prefix(((event, names[target]),)) for event, target in moves)
            if len(steps) == 1:
                return steps[0]
            if operator == "[]":
                return ExternalChoice(steps)
            return (
                InternalChoice(steps)
                if operator == "|~|"
                else SlidingChoice(steps[0], ExternalChoice((STOP, *steps[1:])))
            )

        return made

    names.extend(reference(f"S{number}", body(number)) for number in range(states))
    return names[0]


@st.composite
def skeletons(draw: Draw, leaves: st.SearchStrategy[Process], depth: int = 3) -> Process:
    """Parallel operators, hiding and renaming over *leaves*."""
    kind = draw(st.integers(0, 6 if depth else 0))
    if kind == 0:
        return draw(leaves)
    below = skeletons(leaves, depth - 1)
    if kind in (1, 2):
        return Parallel(draw(SETS), tuple(draw(st.lists(below, min_size=2, max_size=3))))
    if kind == 3:
        operands = draw(st.lists(below, min_size=2, max_size=3))
        return AlphabetisedParallel(tuple(draw(SETS) for _ in operands), tuple(operands))
    if kind == 4:
        links = draw(st.lists(st.tuples(EVENTS, EVENTS), min_size=1, max_size=2, unique=True))
        return LinkedParallel(draw(below), tuple(links), draw(below))
    if kind == 5:
        hiding = draw(st.sampled_from((Hide, Project)))
        return hiding(draw(below), draw(SETS))  # type: ignore[no-any-return]
    pairs = draw(st.lists(st.tuples(EVENTS, EVENTS), min_size=1, max_size=3, unique=True))
    return Rename(draw(below), tuple(pairs))


def chase(process: Process) -> External:
    return External("chase", process, ())


def machine(process: Process, semantics: Semantics) -> Explored:
    return explore(process, Limits(states=400), semantics=semantics)


@pytest.mark.parametrize("kernel", ["none", "interpreted", "compiled"])
@MANY
@given(skeletons(components()))
def test_states_and_transitions_are_those_of_the_rule_term_by_term(kernel: str, process: Process) -> None:
    try:
        expected = machine(chase(process), Semantics())
    except LimitReached:
        return
    with (
        patch.object(chased, "FOLLOWED", chased.FOLLOWED if kernel == "none" else 0),
        patch.object(chased, "COMPILED", kernel == "compiled"),
    ):
        found = machine(chase(process), Compiler().semantics)
    assert tuple(found.terms) == tuple(expected.terms)
    assert [list(found.lts.successors(s)) for s in range(found.lts.states)] == [
        list(expected.lts.successors(s)) for s in range(expected.lts.states)
    ]


@MANY
@given(skeletons(st.one_of(components(), skeletons(components(), 2).map(chase)), 2))
def test_a_composition_with_chased_parts_is_what_its_terms_are(process: Process) -> None:
    assert_same_machine(process)
    try:
        expected = machine(process, Semantics())
    except LimitReached:
        return
    network = compile_network(process)
    if len(network.slots) == 1 and network.slots[0].terms[0] is expected.terms[0]:
        assert set(network.slots[0].terms) == set(expected.terms)


def in_company(composition: LazyComposition, limits: Limits, poll: Poll | None, *, compiled: bool = False) -> Network:
    """The network of a composition in which something is chased."""

    def room(states: int, size: int) -> bool:
        return limits.states is None or states <= limits.states

    return together(composition, room, poll, compiled=compiled)


@MANY
@given(skeletons(st.one_of(components(), skeletons(components(), 2).map(chase)), 2))
def test_as_much_of_what_is_chased_as_the_whole_gets_to_see_is_enough(process: Process) -> None:
    def compiled(process: Process) -> Network:
        return Compiler(company=in_company).network(process, Limits(states=5_000))

    with patch.object(compiler, "LISTED_IN_COMPANY", 1):
        assert_same_machine(process, compiled)


def endless_eavesdropper(facts: int) -> Process:
    """Learns facts in any order: all sets of facts are states of it."""
    base = 10

    def knows(fact: int) -> Process:
        return then(base + facts + fact, again(fact))

    names: dict[int, Process] = {}

    def again(fact: int) -> Process:
        if fact not in names:
            names[fact] = reference(f"Knows{fact}", lambda: knows(fact))
        return names[fact]

    return chase(interleave(*(then(base + fact, again(fact)) for fact in range(facts))))


def test_a_part_that_is_large_by_itself_is_explored_no_further_than_its_company_gets() -> None:
    facts = 40
    spy = endless_eavesdropper(facts)
    said = EventSet.of(range(10, 10 + 2 * facts))
    system = share(said, then(10, 10 + facts, STOP), spy)
    assert is_chased(system)
    assert len(interpreted(compile_network(system, Limits(states=50)))) == 3


def test_a_whole_that_is_too_large_says_so() -> None:
    with pytest.raises(LimitReached) as reached:
        compile_network(endless_eavesdropper(12), Limits(states=100))
    assert reached.value.states == 100


def test_compressions_around_what_is_chased_are_looked_through() -> None:
    spy = chase(Hide(share(EventSet.of([a]), then(a, b, STOP), choose(then(a, STOP), then(c, STOP))), EventSet.of([a])))
    assert_same_machine(interleave(Compressed("sbisim", spy), then(b, STOP)))


def test_the_first_tau_is_that_of_the_first_operand() -> None:
    process = chase(interleave(perhaps(then(a, STOP), then(b, STOP)), perhaps(then(b, STOP), then(c, STOP))))
    assert [event for event, _ in Compiler().semantics.transitions(Compiler().semantics.state(process))] == [a, b]


def test_a_whole_that_is_large_for_its_other_parts_is_a_network() -> None:
    spy = endless_eavesdropper(2)
    others = [reference(f"L{i}", lambda i=i: then(30 + i, then(40 + i, others[i]))) for i in range(6)]
    system = interleave(spy, *others)
    network = compile_network(system, Limits(states=50))
    assert len(network.slots) == 7
    assert len(interpreted(network)) == len(interpreted(compile_network(system))) == 4 * 2**6


def test_what_is_asked_of_a_large_composition_is_worked_out_in_kernels() -> None:
    facts, others = 12, 9
    said = EventSet.of(range(10, 10 + 2 * facts))
    user = then(10, 11, 12, 10 + facts, 11 + facts, STOP)
    loops = [reference(f"L{i}", lambda i=i: then(50 + i, 60 + i, loops[i])) for i in range(others)]
    system = share(said, user, endless_eavesdropper(facts))
    network = Compiler(company=partial(in_company, compiled=True)).network(
        interleave(system, *loops), Limits(states=50_000)
    )
    sizes = [slot.lts.states for slot in network.slots]
    assert sizes == [6, 4] + [2] * others
    exploration = search.explore(pack(network))
    assert exploration.complete
    assert exploration.levels[-1] == 6 * 2**others
