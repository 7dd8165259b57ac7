"""Scripts as text, with every threshold of the engine at its least: small processes go the ways of large ones.

A random process is nearly always small enough to be listed as terms, and then networks of formats, specifications that
grow with the search, and compiled kernels are never reached. Here nothing is small enough.
"""

from __future__ import annotations

import os
import random
from collections import Counter
from functools import partial
from itertools import islice, permutations

import pytest

from cspcheck.checker.check import Checker
from cspcheck.checker.checks import machine_terms, store
from cspcheck.checker.kernels import jit
from cspcheck.checker.network import compiler, formats
from cspcheck.checker.network.compiler import Compiler
from cspcheck.checker.search import levels
from cspcheck.checker.semantics.transitions import LimitReached, explore
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from tests.checker.checks.test_observed_refinement import DEPTH, violated
from tests.checker.exploring import rows_of
from tests.differential.engine import said
from tests.differential.families import families
from tests.differential.test_scripts import NAMES, verdicts
from tests.reference.processes import random_process
from tests.reference.surgery import relative
from tests.reference.text import script

FAMILIES = max(1, int(os.environ.get("CSPCHECK_TRIPLES", "20000")) // 5_000)
SEED = int(os.environ.get("CSPCHECK_SEED", "1"))
WAYS = ("compiled", "interpreted")


def without_thresholds(monkeypatch: pytest.MonkeyPatch, way: str) -> Counter[int]:
    """Nothing is small any more; the numbers of formats of the networks that are made will be counted."""
    counted: Counter[int] = Counter()
    made = Compiler.network

    def network(self: Compiler, *arguments: object, **named: object) -> object:
        found = made(self, *arguments, **named)  # type: ignore[arg-type]
        counted[found.formats] += 1
        return found

    monkeypatch.setattr(Compiler, "network", network)
    monkeypatch.setattr(machine_terms, "Compiler", partial(Compiler, slot_states=2))
    monkeypatch.setattr(compiler, "SMALL", 1)
    monkeypatch.setattr(formats, "MOST_INSIDE", 0)
    monkeypatch.setattr(store, "WHOLE_NORMAL_FORM", 0)
    monkeypatch.setattr(levels, "INTERPRETED_TRANSITIONS", 0 if way == "compiled" else 1 << 60)
    monkeypatch.setattr(levels, "INTERPRETED_ROWS", 1)
    if way == "interpreted":
        monkeypatch.setattr(jit, "is_loaded", lambda: False)
    return counted


@pytest.mark.parametrize("way", WAYS)
def test_verdicts_are_what_the_definitions_say(monkeypatch: pytest.MonkeyPatch, way: str) -> None:
    counted = without_thresholds(monkeypatch, way)
    told: Counter[bool | None] = Counter()
    for number in range(FAMILIES):
        seed = SEED * 1_000_000 + 850_000 + 1_000 * WAYS.index(way) + number
        semantics, members = next(islice(families(seed), 1))
        named = dict(zip(NAMES, members, strict=True))
        expected = verdicts(named, semantics)
        text = script(**named) + "".join(f"\nassert {claim}" for claim in expected)
        loaded = load(Source("random.csp", text))
        checker = Checker(loaded, limits=Limits(states=1_000), workers=1)
        for assertion, claim in zip(loaded.assertions, expected, strict=True):
            answer = said(checker.check(assertion.node))
            told[answer] += 1
            assert answer in (None, expected[claim]), f"{claim}\n{text}"

    assert told[None] < told.total() / 8
    assert sum(number for shapes, number in counted.items() if shapes > 1) > counted.total() / 20, counted


@pytest.mark.parametrize("way", WAYS)
def test_what_is_observed_beside_failures(monkeypatch: pytest.MonkeyPatch, way: str) -> None:
    """The models of revivals and of refusal testing, termination included, against all short observations."""
    without_thresholds(monkeypatch, way)
    rng = random.Random(SEED * 1_000_000 + WAYS.index(way))
    told: Counter[bool] = Counter()
    while told.total() < 20 * FAMILIES:
        one = random_process(rng, rng.randrange(2, 7), 2)
        members: dict[str, Process] = {"P": one, "Q": relative(one, rng, 2)}
        try:
            rows = {name: rows_of(explore(member, Limits(states=12)).lts) for name, member in members.items()}
        except LimitReached:
            continue
        text = script(**members)
        checker = Checker(load(Source("random.csp", text)), workers=1)
        for left, right in permutations("PQ"):
            for model in ("V", "VD", "R", "RD"):
                outcome = checker.check_refinement(members[left], model, members[right])  # type: ignore[arg-type]
                wrong = violated(rows[left], rows[right], model)
                found = outcome.counterexample
                if found is None:
                    assert not wrong, f"{left} [{model}= {right}\n{text}"
                elif sum(event != found.tau for event in found.trace) < DEPTH:
                    assert wrong, f"{left} [{model}= {right}: {found}\n{text}"
                told[found is None] += 1

    assert min(told[True], told[False]) > 0, told
