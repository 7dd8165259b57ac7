"""The trees say what the definitions say, behaviour by behaviour."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator

import pytest
from hypothesis import given, reject, settings

from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.events import TICK, EventSet
from cspcheck.cspm.process.terms import (
    DIV,
    SKIP,
    STOP,
    ExternalChoice,
    Hide,
    InternalChoice,
    Parallel,
    Process,
    Sequential,
    SlidingChoice,
)
from tests.examples import examples
from tests.reference.behaviours import Failure, Trace
from tests.reference.definitions import Definitions, TooMany
from tests.reference.denotations import (
    Denotation,
    Root,
    Semantics,
    TooLarge,
    Unguarded,
    events_of,
    mask,
)
from tests.reference.processes import EVENTS, A, B, finite_processes, random_process, recursive
from tests.reference.text import script
from tests.reference.verdicts import reachable

LETTERS = 2
ALPHABET = EVENTS[:LETTERS]
DEPTH = 3


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


def compare(process: Process, n: int) -> None:
    """Raises TooMany or TooLarge where the sets are too large to be compared."""
    semantics = Semantics(ALPHABET, limit=300)
    tree = semantics.of(process)
    found = traces(tree, n)
    patience = max((sum(1 for _ in reachable(hidden)) for hidden in semantics.hidden()), default=1)
    definitions = Definitions(ALPHABET, patience, limit=200)

    assert found == definitions.traces(process, n), script(P=process)
    assert divergences(tree, n) == definitions.divergences(process, n), script(P=process)
    assert failures(tree, n, definitions) == definitions.failures(process, n), script(P=process)


@given(finite_processes(max_size=6, letters=LETTERS))
@settings(max_examples=examples(150), deadline=None)
def test_processes_without_names(process: Process) -> None:
    try:
        compare(process, DEPTH)
    except (TooMany, TooLarge):
        reject()


def test_recursive_processes_hidden_ones_too() -> None:
    rng = random.Random(5)
    compared: Counter[bool] = Counter()
    for _ in range(800):
        process = random_process(rng, rng.randrange(2, 6), LETTERS)
        try:
            compare(process, DEPTH - 1)
        except (TooMany, TooLarge):
            continue
        compared["\\" in script(P=process)] += 1

    assert compared[True] > 100, compared
    assert compared[False] > 300, compared


# -- and what that is, in cases small enough to be known by heart


ABC = Semantics(EVENTS)
TERMINATES = Root(True, 0, frozenset({ABC.all_but_tick}), diverges=False)
DIVERGES = Root(False, 0, frozenset(), diverges=True)
LOOP = recursive(lambda again: prefix(A, again))
LOOP_WITH_EXIT = recursive(lambda again: ExternalChoice((prefix(A, again), prefix(B, STOP))))
a_stop, b_stop = prefix(A, STOP), prefix(B, STOP)
a_or_skip = ExternalChoice((SKIP, a_stop))
only_a = EventSet.of([A])


def offers(*events: int) -> Root:
    """Stable, and refuses nothing but what is not offered."""
    return Root(False, mask(events), frozenset({ABC.everything & ~mask(events)}), diverges=False)


def one_of(*roots: Root) -> Root:
    return Root(
        any(root.ticks for root in roots),
        mask({event for root in roots for event in events_of(root.initials)}),
        frozenset({refusal for root in roots for refusal in root.refusals}),
        any(root.diverges for root in roots),
    )


@pytest.mark.parametrize(
    ("process", "root"),
    [
        (STOP, offers()),
        (SKIP, TERMINATES),
        (DIV, DIVERGES),
        (a_stop, offers(A)),
        (ExternalChoice((a_stop, b_stop)), offers(A, B)),
        (InternalChoice((a_stop, b_stop)), one_of(offers(A), offers(B))),
        (SlidingChoice(a_stop, b_stop), offers(B)._replace(initials=mask([A, B]))),
        # Termination is the process's own choice: everything else can be refused ...
        (a_or_skip, TERMINATES._replace(initials=mask([A]))),
        # ... even where no stable state offers it.
        (ExternalChoice((SKIP, DIV)), one_of(TERMINATES, DIVERGES)),
        (SlidingChoice(SKIP, b_stop), one_of(TERMINATES, offers(B))),
        (Hide(ExternalChoice((SKIP, prefix(A, b_stop))), only_a), one_of(TERMINATES, offers(B))),
        # The tick of the first part of a sequence is not seen.
        (Sequential(a_or_skip, b_stop), offers(B)._replace(initials=mask([A, B]))),
        # A terminated operand waits for the others, and refuses what is shared.
        (Parallel(only_a, (SKIP, a_stop)), offers()),
        (Parallel(EventSet(), (SKIP, a_stop)), offers(A)),
        (Parallel(EventSet(), (SKIP, SKIP)), TERMINATES),
        # A loop of hidden events diverges and is never stable, even if it can be left.
        (Hide(LOOP, only_a), DIVERGES),
        (Hide(LOOP_WITH_EXIT, only_a), DIVERGES._replace(initials=mask([B]))),
        (Hide(prefix(A, a_stop), only_a), offers()),
    ],
    ids=lambda value: "" if isinstance(value, Root) else script(P=value).partition("P = ")[2].partition("\n")[0],
)
def test_known_roots(process: Process, root: Root) -> None:
    assert ABC.of(process).root == root


def test_a_loop_is_one_expression() -> None:
    tree = ABC.of(LOOP.body())

    assert [trace for trace, _ in reachable(tree)] == [(), (A,)]
    assert tree.after(A).after(A) is tree.after(A)


def test_recursion_without_a_guard_has_no_meaning() -> None:
    with pytest.raises(Unguarded):
        _ = ABC.of(recursive(lambda again: ExternalChoice((again, prefix(A, STOP))))).root
