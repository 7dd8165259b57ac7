"""The trees say what the definitions say, behaviour by behaviour."""

from __future__ import annotations

import random
from collections.abc import Iterator

import pytest
from hypothesis import given, settings

from cspm.events import TICK
from cspm.process import Process
from tests.reference.definitions import Definitions, Failure, TooMany, Trace
from tests.reference.denotations import Denotation, Semantics, events_of
from tests.reference.processes import EVENTS, finite_processes, processes, random_process
from tests.reference.text import script
from tests.reference.verdicts import reachable

LETTERS = 2
ALPHABET = EVENTS[:LETTERS]


def within(tree: Denotation, n: int, trace: Trace = ()) -> Iterator[tuple[Trace, Denotation]]:
    yield trace, tree
    if n:
        for event, below in tree.branches():
            yield from within(below, n - 1, (*trace, event))


def traces(tree: Denotation, n: int) -> set[Trace]:
    return {s for s, _ in within(tree, n)} | {(*s, TICK) for s, below in within(tree, n) if below.root.ticks}


def failures(tree: Denotation, n: int, definitions: Definitions) -> set[Failure]:
    found: set[Failure] = set()
    for s, below in within(tree, n):
        maximal = [frozenset(events_of(x)) for x in below.root.refusals]
        found |= {(s, x) for x in definitions.all_refusals if any(x <= y for y in maximal)}
        if below.root.ticks:
            found |= {((*s, TICK), x) for x in definitions.all_refusals}
    return found


def divergences(tree: Denotation, n: int) -> set[Trace]:
    return {s for s, below in within(tree, n) if below.root.diverges}


def assert_agree(process: Process, n: int, patience: int | None = None) -> None:
    definitions = Definitions(ALPHABET, patience, limit=500)
    tree = Semantics(ALPHABET).of(process)

    assert traces(tree, n) == definitions.traces(process, n), script(P=process)
    assert failures(tree, n, definitions) == definitions.failures(process, n), script(P=process)
    assert divergences(tree, n) == definitions.divergences(process, n), script(P=process)


@given(finite_processes(max_size=5, letters=LETTERS))
@settings(max_examples=300, deadline=None)
def test_trees_are_the_definitions(process: Process) -> None:
    assert_agree(process, 3, patience=4)
