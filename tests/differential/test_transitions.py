"""The operational semantics gives each process the traces, failures and divergences of the denotational one."""

from __future__ import annotations

import os
from itertools import islice

import pytest

from cspcheck.checker.semantics.transitions import LimitReached, explore
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.process.terms import Process
from tests.differential.families import EXPRESSIONS, families, smallest
from tests.differential.operational import difference
from tests.reference.denotations import Semantics
from tests.reference.processes import EVENTS
from tests.reference.text import script

pytestmark = pytest.mark.slow

FAMILIES = int(os.environ.get("CSPCHECK_TRIPLES", "20000")) // 80
SEED = int(os.environ.get("CSPCHECK_SEED", "1"))
BATCH = 250


def problem(process: Process, semantics: Semantics) -> object:
    return difference(explore(process, Limits(states=1_000)).lts, semantics.of(process), semantics)


@pytest.mark.parametrize("batch", range(max(1, FAMILIES // BATCH)))
def test_transitions_mean_what_the_definitions_say(batch: int) -> None:
    too_large = 0
    for semantics, members in islice(families(SEED * 1_000_000 + 900_000 + batch), BATCH):
        for process in members:
            try:
                wrong = problem(process, semantics)
            except LimitReached:
                too_large += 1
                continue
            if wrong:
                pytest.fail(report(process))

    assert too_large < BATCH / 20


def report(process: Process) -> str:
    (process,) = smallest((process,), lambda candidate: problem(candidate, Semantics(EVENTS, EXPRESSIONS)))
    return f"{problem(process, Semantics(EVENTS, EXPRESSIONS))}\n{script(P=process)}"
