"""Taking terms apart and putting them together changes nothing by itself; shrinking ends, and ends small."""

from __future__ import annotations

import random

from hypothesis import given, settings

from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.terms import Process
from tests.examples import examples
from tests.reference.denotations import Semantics, TooLarge, Unguarded
from tests.reference.processes import EVENTS, A, B, processes, random_process, recursive
from tests.reference.surgery import parts, positions, rebuilt, references, relative, smaller, with_body
from tests.reference.text import script
from tests.reference.verdicts import MODELS, divergence, reachable, refinement


@given(processes())
@settings(max_examples=examples(50), deadline=None)
def test_rebuilding_from_its_own_parts_gives_the_term_itself(process: Process) -> None:
    assert rebuilt(process, parts(process)) is process
    assert all(put(subterm) is process for subterm, put in positions(process))


@given(processes(max_size=4))
@settings(max_examples=examples(50), deadline=None)
def test_defining_all_names_anew_means_the_same(process: Process) -> None:
    names = references(process)
    if not names:
        return
    anew = with_body(process, names[0], names[0].body())
    semantics = Semantics(EVENTS, 2_000)

    assert not set(references(anew)) & set(names)
    try:
        for model in MODELS:
            assert refinement(semantics.of(process), semantics.of(anew), model) is None
            assert refinement(semantics.of(anew), semantics.of(process), model) is None
    except TooLarge:
        pass


def test_relatives_differ_but_not_by_much() -> None:
    rng = random.Random(3)
    equal = 0
    for _ in range(200):
        process = random_process(rng, 4)
        other = relative(process, rng)
        semantics = Semantics(EVENTS, 1_000)
        try:
            equal += refinement(semantics.of(process), semantics.of(other), "F") is None
        except (TooLarge, Unguarded):
            continue

    assert 40 < equal < 160


def test_shrinking_ends_at_the_smallest_process_that_diverges_after_an_event() -> None:
    """From any process that does so to one with a single event before a divergence."""
    rng = random.Random(4)

    def diverges_later(process: Process) -> bool:
        try:
            found = divergence(Semantics(EVENTS, 500).of(process))
        except Exception:
            return False
        return found is not None and len(found.trace) > 0

    shrunk = 0
    while shrunk < 5:
        process = random_process(rng, 7)
        if not diverges_later(process):
            continue
        while (simpler := next(filter(diverges_later, smaller(process)), None)) is not None:
            process = simpler
        assert len(script(P=process).splitlines()) == 2, script(P=process)
        assert len(list(reachable(Semantics(EVENTS).of(process)))) == 2, script(P=process)
        shrunk += 1


def test_random_processes_are_the_same_for_the_same_seed() -> None:
    first, second = (random_process(random.Random(7), 8) for _ in range(2))
    semantics = Semantics(EVENTS)

    assert refinement(semantics.of(first), semantics.of(second), "FD") is None
    assert refinement(semantics.of(second), semantics.of(first), "FD") is None


def test_a_name_is_written_with_its_definition() -> None:
    loop = recursive(lambda again: prefix(A, again))

    assert script(P=prefix(B, loop)) == f"channel a, b, c\nP = b -> {loop.text}\n{loop.text} = a -> {loop.text}"
