"""The engine's refinement checks against the definitions: many random pairs of related processes, in all models.

The reference is exact, so each disagreement is a fault of one of the two. ``CSPCHECK_TRIPLES`` says how many triples
(process, process, model) there are; ``CSPCHECK_SEED`` gives others.
"""

from __future__ import annotations

import os
import random
from collections import Counter
from itertools import permutations

import pytest

from cspcheck.checker.check import Checker
from cspcheck.cspm.process.terms import Process
from tests.differential.engine import checker, refutes_refinement, said, visible
from tests.differential.families import EXPRESSIONS, families, smallest
from tests.differential.forcing import SLOTS, compressed, least_thresholds
from tests.reference.denotations import Semantics
from tests.reference.processes import EVENTS
from tests.reference.text import script
from tests.reference.verdicts import MODELS, Model, refinement

pytestmark = pytest.mark.slow

TRIPLES = int(os.environ.get("CSPCHECK_TRIPLES", "20000"))
SEED = int(os.environ.get("CSPCHECK_SEED", "1"))
BATCH = 1_000


class Compared:
    """One check by the engine beside what the definitions say.

    ``verdict`` is the engine's (None where it gave up), ``problem`` what is wrong with its answer.
    """

    def __init__(
        self,
        spec: Process,
        impl: Process,
        model: Model,
        semantics: Semantics,
        engine: Checker,
        asked: tuple[Process, Process] | None = None,
    ) -> None:
        """*asked*: processes with the same meaning that the engine gets in their place."""
        left, right = semantics.of(spec), semantics.of(impl)
        difference = refinement(left, right, model)
        outcome = engine.check_refinement((asked or (spec, impl))[0], model, (asked or (spec, impl))[1])
        found = outcome.counterexample
        self.verdict = said(outcome)
        self.problem: str | None = None
        if self.verdict is None:
            return
        if self.verdict != (difference is None):
            self.problem = f"the engine says {outcome.verdict}, the definitions give {difference}"
        elif difference is None:
            self.problem = None if found is None else f"it holds, so this refutes nothing: {found}"
        elif found is None:
            self.problem = "a failure without a counterexample"
        elif not refutes_refinement(found, left, right, model):
            self.problem = f"this refutes nothing: {found}"
        elif visible(found.trace) != difference.trace:
            self.problem = f"{found} is not the first counterexample, which is {difference}"


@pytest.mark.parametrize("batch", range(max(1, TRIPLES // BATCH)))
def test_refinement_is_what_the_definitions_say(batch: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of the batches as users have it, the others with machines and reduction everywhere; all with and without."""
    forced = batch % 2 == 1
    rng = random.Random(SEED * 1_000_000 + batch)
    if forced:
        least_thresholds(monkeypatch, SLOTS[batch // 2 % len(SLOTS)])
    verdicts: Counter[tuple[Model, bool | None]] = Counter()
    for number, (semantics, members) in enumerate(families(SEED * 1_000_000 + batch)):
        full = number % 3 == 0
        engine = checker(full=full)
        told = [compressed(member, rng) if forced else member for member in members]
        for (spec, left), (impl, right) in permutations(zip(members, told, strict=True), 2):
            for model in MODELS:
                compared = Compared(spec, impl, model, semantics, engine, (left, right))
                if compared.problem is not None:
                    pytest.fail(report(left, right, model, full=full))
                verdicts[model, compared.verdict] += 1
        if verdicts.total() >= BATCH:
            break

    for model in MODELS:  # the comparison is worth something only if both answers are common
        decided = verdicts[model, True] + verdicts[model, False]
        assert verdicts[model, True] > decided / 5, verdicts
        assert verdicts[model, False] > decided / 10, verdicts
        assert verdicts[model, None] < decided / 8, verdicts


def report(spec: Process, impl: Process, model: Model, *, full: bool) -> str:
    """The disagreement on processes that are as small as can be found."""

    def problem(left: Process, right: Process) -> str | None:
        return Compared(left, right, model, Semantics(EVENTS, EXPRESSIONS), checker(full=full)).problem

    alone = problem(spec, impl)
    if alone is None:
        return f"Spec [{model}= Impl is wrong only after other checks, full={full}\n{script(Spec=spec, Impl=impl)}"
    spec, impl = smallest((spec, impl), problem)
    return f"Spec [{model}= Impl, full={full}: {problem(spec, impl)}\n{script(Spec=spec, Impl=impl)}"
