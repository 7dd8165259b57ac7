"""From text to verdict: scripts that say what the random processes are, checked as a user would have them checked.

Where the terms are right but this disagrees, the fault is in reading: precedence, names, evaluation, assertions.
"""

from __future__ import annotations

import os
from itertools import islice, permutations

import pytest

from cspcheck.checker.check import Checker
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from tests.differential.engine import said
from tests.differential.families import families
from tests.reference.denotations import Semantics
from tests.reference.text import script
from tests.reference.verdicts import (
    MODELS,
    deadlock,
    divergence,
    nondeterminism,
    refinement,
)

pytestmark = pytest.mark.slow

FAMILIES = max(1, int(os.environ.get("CSPCHECK_TRIPLES", "20000")) // 800)
SEED = int(os.environ.get("CSPCHECK_SEED", "1"))
NAMES = "PQRS"


@pytest.mark.parametrize("number", range(FAMILIES))
def test_scripts_are_judged_as_the_definitions_say(number: int) -> None:
    semantics, members = next(islice(families(SEED * 1_000_000 + 800_000 + number), 1))
    expected = verdicts(dict(zip(NAMES, members, strict=True)), semantics)
    text = script(**dict(zip(NAMES, members, strict=True)))
    text += "".join(f"\nassert {claim}" for claim in expected)
    loaded = load(Source("random.csp", text))
    checker = Checker(loaded, limits=Limits(states=1_000), workers=1)

    assert len(loaded.assertions) == len(expected)
    for assertion, claim in zip(loaded.assertions, expected, strict=True):
        assert said(checker.check(assertion.node)) in (None, expected[claim]), f"{claim}\n{text}"


def verdicts(processes: dict[str, Process], semantics: Semantics) -> dict[str, bool]:
    """Assertions as a script writes them, and whether they hold."""
    trees = {name: semantics.of(process) for name, process in processes.items()}
    found: dict[str, bool] = {}
    for name, tree in trees.items():
        found[f"{name} :[deadlock free [F]]"] = deadlock(tree, "F") is None
        found[f"{name} :[deadlock free]"] = deadlock(tree, "FD") is None
        found[f"{name} :[divergence free]"] = divergence(tree) is None
        found[f"{name} :[deterministic [FD]]"] = nondeterminism(tree, "FD") is None
    for left, right in permutations(NAMES, 2):
        for model in MODELS:
            found[f"{left} [{model}= {right}"] = refinement(trees[left], trees[right], model) is None
    found |= {f"not {claim}": not holds for claim, holds in list(found.items())[::5]}
    return found
