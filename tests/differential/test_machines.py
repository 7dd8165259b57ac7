"""Machines inside terms and reduction by itself, against the transitions of the term: same verdicts.

Random nested terms get compressions, priorities and the other built-in functions at random places; every threshold is
at its least, so that whatever can become a machine does and whatever can be reduced is. What is expected comes from
the machine of the term alone, by plain sets.
"""

from __future__ import annotations

import os
import random
from collections import Counter
from collections.abc import Iterator

import pytest

from cspcheck.checker.semantics.transitions import LimitReached, explore
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import (
    AlphabetisedParallel,
    Compressed,
    External,
    Hide,
    InternalChoice,
    Parallel,
    Prioritised,
    Process,
    Sequential,
)
from tests.checker.explicit import (
    Rows,
    first_deadlock,
    first_divergence,
    first_nondeterminism,
    refinement_violation,
)
from tests.checker.exploring import rows_of
from tests.differential.engine import checker, said
from tests.differential.forcing import NEUTRAL, SLOTS, least_thresholds
from tests.reference.processes import EVENTS, random_process
from tests.reference.surgery import positions, relative

CASES = int(os.environ.get("CSPCHECK_EXAMPLES", "24"))
SEED = int(os.environ.get("CSPCHECK_SEED", "1"))
STATES = 120
"""Terms with more states than this are left out: the plain sets would take too long."""

WAYS: tuple[dict[str, bool], ...] = ({}, {"as_written": True}, {}, {"full": True})
FOLLOWING = ("chase", "deter")


def wrapped(process: Process, rng: random.Random, letters: int) -> Process:
    """A process with one more function somewhere around a part of it, or in company that makes a priority matter."""
    part, put = rng.choice(list(positions(process)))
    pick = rng.randrange(12)
    some = EventSet.of(event for event in EVENTS[:letters] if rng.random() < 0.5)
    other = EventSet.of(event for event in EVENTS[:letters] if rng.random() < 0.5)
    if pick < 5:
        return put(Compressed(rng.choice(NEUTRAL), part))
    if pick < 7:
        return put(Prioritised(part, rng.choice(((some, other), (EventSet(), some), (some,)))))
    if pick == 7:
        pairs = rng.choice(([], [EVENTS[:2]], [EVENTS[1::-1]], [EVENTS[:2], EVENTS[1:3], EVENTS[::2]]))
        order = (EventSet.of(EVENTS), frozenset(pairs), some if rng.random() < 0.3 else EventSet())
        return put(External("prioritisepo", part, order))
    if pick == 8:
        return put(External(rng.choice(FOLLOWING), part, ()))
    company = random_process(rng, 2, letters)
    if pick == 9:
        return put(Parallel(some, (part, Compressed(rng.choice(NEUTRAL), company))))
    if pick == 10:
        return put(Sequential(Compressed(rng.choice(NEUTRAL), part), company))
    return put(Hide(AlphabetisedParallel((some, other), (part, Compressed(rng.choice(NEUTRAL), company))), some))


def cases(seed: int) -> Iterator[tuple[Process, Process]]:
    """Endlessly many pairs of related processes with functions inside, the same for the same seed."""
    rng = random.Random(seed)
    while True:
        letters = rng.choice((2, 3))
        one = random_process(rng, rng.randrange(3, 10), letters)
        other = relative(one, rng, letters) if rng.random() < 0.7 else InternalChoice((one, one))
        for _ in range(rng.randrange(1, 5)):
            one = wrapped(one, rng, letters)
        for _ in range(rng.randrange(4)):
            other = wrapped(other, rng, letters)
        yield one, other


def plain(process: Process) -> Rows | None:
    """The machine of a term as the operators say; None if it is large, has no end, or no transitions."""
    try:
        return rows_of(explore(process, Limits(states=STATES)).lts)
    except (LimitReached, ScriptError):
        return None


def expected(one: Rows, other: Rows) -> dict[str, bool]:
    """What holds of two machines, by plain sets."""
    found = {}
    for name, rows in (("P", one), ("Q", other)):
        diverges = first_divergence(rows) is not None
        found[f"{name} deadlock free F"] = first_deadlock(rows) is None
        found[f"{name} divergence free FD"] = not diverges
        found[f"{name} deterministic FD"] = not diverges and first_nondeterminism(rows) is None
    for model in ("T", "F", "FD"):
        found[f"P {model} Q"] = refinement_violation(one, other, model) is None
        found[f"Q {model} P"] = refinement_violation(other, one, model) is None
    return found


def answers(one: Process, other: Process, **options: bool) -> Iterator[tuple[str, bool | None]]:
    """What the engine says, with the wording of :func:`expected`."""
    engine = checker(states=100_000, **options)
    for name, process in (("P", one), ("Q", other)):
        for kind, model in (("deadlock free", "F"), ("divergence free", "FD"), ("deterministic", "FD")):
            yield f"{name} {kind} {model}", said(engine.check_property(process, kind, model))  # type: ignore[arg-type]
    for model in ("T", "F", "FD"):
        yield f"P {model} Q", said(engine.check_refinement(one, model, other))  # type: ignore[arg-type]
        yield f"Q {model} P", said(engine.check_refinement(other, model, one))  # type: ignore[arg-type]


@pytest.mark.parametrize("slots", SLOTS)
def test_verdicts_are_those_of_the_term(slots: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """With components that are large at once (formats, single components), and with none that is."""
    least_thresholds(monkeypatch, slots)
    told: Counter[bool | None] = Counter()
    functions: Counter[str] = Counter()
    compared = 0
    for one, other in cases(SEED * 1_000 + slots):
        if compared == CASES // 2:
            break
        rows = plain(one), plain(other)
        if rows[0] is None or rows[1] is None:
            continue
        compared += 1
        for process in (one, other):
            functions.update(part.function for part, _ in positions(process) if isinstance(part, Compressed | External))
        right = expected(rows[0], rows[1])
        options = WAYS[compared % len(WAYS)]
        for question, answer in answers(one, other, **options):
            told[answer] += 1
            assert answer in (None, right[question]), f"{question} with {options}\n{one!r}\n{other!r}"
    assert told[None] < told.total() / 20, told
    assert min(told[True], told[False]) > told.total() / 10, told
    if CASES >= 200:
        assert {*NEUTRAL, *FOLLOWING, "prioritisepo"} <= set(functions), functions
