"""The engine's property checks against the definitions, on many random processes."""

from __future__ import annotations

import os
import random
from collections import Counter

import pytest

from cspcheck.checker.verdict import Outcome
from cspcheck.cspm.process.terms import Process
from tests.differential.engine import Kind, checker, refutes_property, refutes_trace, said, visible
from tests.differential.families import EXPRESSIONS, families, smallest
from tests.reference import text
from tests.reference.denotations import Denotation, Semantics
from tests.reference.processes import EVENTS
from tests.reference.verdicts import (
    MODELS,
    Difference,
    Model,
    Trace,
    deadlock,
    divergence,
    has_trace,
    nondeterminism,
)

CHECKS = int(os.environ.get("CSPCHECK_TRIPLES", "20000")) // 20
SEED = int(os.environ.get("CSPCHECK_SEED", "1"))
BATCH = 500

PROPERTIES: list[tuple[Kind, Model]] = [
    ("deadlock free", "F"),
    ("deadlock free", "FD"),
    ("divergence free", "FD"),
    ("deterministic", "F"),
    ("deterministic", "FD"),
]


def violation(tree: Denotation, kind: Kind, model: Model) -> Difference | None:
    match kind:
        case "deadlock free":
            return deadlock(tree, model)
        case "divergence free":
            return divergence(tree)
        case "deterministic":
            return nondeterminism(tree, model)


def problem(process: Process, kind: Kind, model: Model, semantics: Semantics, outcome: Outcome) -> str | None:
    """What is wrong with the engine's answer."""
    tree = semantics.of(process)
    expected, found = violation(tree, kind, model), outcome.counterexample
    if said(outcome) != (expected is None):
        return f"the engine says {outcome.verdict}, the definitions give {expected}"
    if expected is None:
        return None if found is None else f"it holds, so this refutes nothing: {found}"
    if found is None or not refutes_property(found, tree, kind, model):
        return f"this refutes nothing: {found}"
    if visible(found.trace) != expected.trace:
        return f"{found} is not the first counterexample, which is {expected}"
    return None


@pytest.mark.parametrize("batch", range(max(1, CHECKS // BATCH)))
def test_properties_are_what_the_definitions_say(batch: int) -> None:
    verdicts: Counter[tuple[Kind, Model, bool | None]] = Counter()
    for number, (semantics, members) in enumerate(families(SEED * 1_000_000 + 500_000 + batch)):
        engine = checker(full=number % 3 == 0)
        for process in members:
            for kind, model in PROPERTIES:
                outcome = engine.check_property(process, kind, model)
                if said(outcome) is not None and problem(process, kind, model, semantics, outcome):
                    pytest.fail(report(process, kind, model, full=number % 3 == 0))
                verdicts[kind, model, said(outcome)] += 1
        if verdicts.total() >= BATCH:
            break

    for kind, model in PROPERTIES:
        told = verdicts[kind, model, True] + verdicts[kind, model, False]
        assert verdicts[kind, model, True] > told / 40, verdicts
        assert verdicts[kind, model, False] > told / 40, verdicts
        assert verdicts[kind, model, None] < told / 8, verdicts


def report(process: Process, kind: Kind, model: Model, *, full: bool) -> str:
    def wrong(candidate: Process) -> str | None:
        outcome = checker(full=full).check_property(candidate, kind, model)
        if said(outcome) is None:
            return None
        return problem(candidate, kind, model, Semantics(EVENTS, EXPRESSIONS), outcome)

    if not wrong(process):
        return f"{kind} [{model}] is wrong only after other checks, full={full}\n{text.script(P=process)}"
    (process,) = smallest((process,), wrong)
    return f"P :[{kind} [{model}]], full={full}: {wrong(process)}\n{text.script(P=process)}"


@pytest.mark.parametrize("batch", range(max(1, CHECKS // BATCH // 2)))
def test_traces_are_what_the_definitions_say(batch: int) -> None:
    rng = random.Random(SEED * 1_000_000 + batch)
    verdicts: Counter[tuple[Model, bool | None]] = Counter()
    for semantics, members in families(SEED * 1_000_000 + 700_000 + batch):
        engine = checker()
        for process in members:
            trace = walk(semantics.of(process), rng)
            for model in MODELS:
                outcome = engine.check_property(process, "has trace", model, trace)
                verdicts[model, said(outcome)] += 1
                wrong = said(outcome) is not None and trace_problem(semantics.of(process), trace, model, outcome)
                assert not wrong, f"{model} {text.trace(trace)}: {wrong}\n{text.script(P=process)}"
        if verdicts.total() >= BATCH:
            break

    for model in MODELS:
        told = verdicts[model, True] + verdicts[model, False]
        assert verdicts[model, True] > told / 40, verdicts
        assert verdicts[model, False] > told / 40, verdicts
        assert verdicts[model, None] < told / 8, verdicts


def walk(tree: Denotation, rng: random.Random) -> Trace:
    """A trace of the process, often with one event too many."""
    trace: list[int] = []
    while tree.root.initials and rng.random() < 0.8:
        event = rng.choice([e for e, _ in tree.branches()])
        tree = tree.after(event)
        trace.append(event)
    if rng.random() < 0.3:
        trace.append(rng.choice(EVENTS))
    return tuple(trace)


def trace_problem(tree: Denotation, trace: Trace, model: Model, outcome: Outcome) -> str | None:
    expected, found = has_trace(tree, trace, model), outcome.counterexample
    if said(outcome) != expected:
        return f"the engine says {outcome.verdict}, the definitions {expected}"
    if expected:
        return None if found is None else f"it holds, so this refutes nothing: {found}"
    if found is None or not refutes_trace(found, tree, trace, model):
        return f"this refutes nothing: {found}"
    return None
