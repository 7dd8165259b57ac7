"""The verdicts on trees are those of the definitions: inclusion of sets, and what the sets contain."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator
from math import inf

import pytest

from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.events import TICK
from cspcheck.cspm.process.terms import DIV, SKIP, STOP, ExternalChoice, InternalChoice, Process
from tests.reference.behaviours import Trace, ticked
from tests.reference.definitions import Definitions, TooMany
from tests.reference.denotations import Semantics
from tests.reference.processes import EVENTS, A, B, C, Generator, Scope
from tests.reference.surgery import relative
from tests.reference.text import script
from tests.reference.verdicts import (
    MODELS,
    Difference,
    Model,
    deadlock,
    divergence,
    has_trace,
    nondeterminism,
    refinement,
)

LETTERS = 2
ALPHABET = EVENTS[:LETTERS]
LONGEST = 5


class Sets:
    """All that a process without recursion can do."""

    def __init__(self, definitions: Definitions, process: Process) -> None:
        self.everything = frozenset(definitions.alphabet | {TICK})
        self.traces = definitions.traces(process, LONGEST)
        self.failures = definitions.failures(process, LONGEST)
        self.divergences = definitions.divergences(process, LONGEST)

    def diverged(self, trace: Trace) -> bool:
        return any(trace[:length] in self.divergences for length in range(len(trace) + 1))

    def refined_by(self, impl: Sets, model: Model) -> bool:
        if model == "T":
            return impl.traces <= self.traces
        if model == "F":
            return impl.traces <= self.traces and impl.failures <= self.failures
        return all(self.diverged(s) for s in impl.divergences) and all(
            failure in self.failures or self.diverged(failure[0]) for failure in impl.failures
        )

    def deadlock_free(self, model: Model) -> bool:
        stuck = any(refused == self.everything and not ticked(s) for s, refused in self.failures)
        return not stuck and not (model == "FD" and self.divergences)

    def deterministic(self, model: Model) -> bool:
        undecided = any(
            (*s, e) in self.traces and (s, frozenset({e})) in self.failures
            for s in self.traces
            for e in self.everything
        )
        return not undecided and not (model == "FD" and self.divergences)

    def has_trace(self, trace: Trace, model: Model) -> bool:
        steps = [(trace[:i], event) for i, event in enumerate(trace)]
        if model == "FD" and any(self.diverged(s) for s, _ in steps):
            return False
        return trace in self.traces and not (
            model != "T" and any((s, frozenset({event})) in self.failures for s, event in steps)
        )


def finite_pairs(number: int) -> Iterator[tuple[Process, Process]]:
    """Related processes without recursion whose traces are short."""
    rng = random.Random(11)
    measure = Definitions(ALPHABET)
    while number:
        process = Generator(rng.randrange, LETTERS).term(rng.randrange(1, 7), Scope())
        other = relative(process, rng, LETTERS)
        if max(measure.longest(process), measure.longest(other)) <= LONGEST < inf:
            number -= 1
            yield process, other


def test_verdicts_are_inclusions_of_sets() -> None:
    answers: Counter[tuple[str, bool]] = Counter()
    rng = random.Random(12)
    for process, other in finite_pairs(400):
        definitions, semantics = Definitions(ALPHABET, limit=2_000), Semantics(ALPHABET)
        try:
            sets, others = Sets(definitions, process), Sets(definitions, other)
        except TooMany:
            continue
        tree, other_tree = semantics.of(process), semantics.of(other)
        trace = rng.choice([s for s in sets.traces | others.traces if not ticked(s)])
        expected = {
            **{f"refinement {m}": sets.refined_by(others, m) for m in MODELS},
            **{f"refinement the other way {m}": others.refined_by(sets, m) for m in MODELS},
            **{f"deadlock {m}": sets.deadlock_free(m) for m in ("F", "FD")},
            "divergence": not sets.divergences,
            **{f"determinism {m}": sets.deterministic(m) for m in ("F", "FD")},
            **{f"trace {m}": sets.has_trace(trace, m) for m in MODELS},
        }
        found = {
            **{f"refinement {m}": refinement(tree, other_tree, m) is None for m in MODELS},
            **{f"refinement the other way {m}": refinement(other_tree, tree, m) is None for m in MODELS},
            **{f"deadlock {m}": deadlock(tree, m) is None for m in ("F", "FD")},
            "divergence": divergence(tree) is None,
            **{f"determinism {m}": nondeterminism(tree, m) is None for m in ("F", "FD")},
            **{f"trace {m}": has_trace(tree, trace, m) for m in MODELS},
        }
        answers.update(expected.items())

        assert found == expected, script(P=process, Q=other)

    for question in {question for question, _ in answers}:
        assert min(answers[question, True], answers[question, False]) > 20, (question, answers)


ABC = Semantics(EVENTS)
a_stop, b_stop = prefix(A, STOP), prefix(B, STOP)


@pytest.mark.parametrize(
    ("spec", "impl", "model", "difference"),
    [
        (a_stop, b_stop, "T", Difference((), event=B)),
        (a_stop, ExternalChoice((a_stop, SKIP)), "T", Difference((), event=TICK)),
        (a_stop, prefix(A, SKIP), "T", Difference((A,), event=TICK)),
        (a_stop, STOP, "T", None),
        (a_stop, STOP, "F", Difference((), refusal=ABC.everything)),
        (a_stop, DIV, "F", None),
        (a_stop, DIV, "FD", Difference((), diverges=True)),
        (prefix(A, DIV), prefix(A, prefix(C, b_stop)), "FD", None),
        (prefix(A, DIV), prefix(A, prefix(C, b_stop)), "T", Difference((A,), event=C)),
        # The shortest trace, then the first in the order of events, then an event before a refusal before divergence.
        (
            ExternalChoice((prefix(A, STOP), prefix(B, STOP))),
            ExternalChoice((prefix(B, a_stop), prefix(A, b_stop))),
            "T",
            Difference((A,), event=B),
        ),
        (a_stop, InternalChoice((STOP, prefix(A, a_stop), prefix(C, STOP))), "F", Difference((), event=C)),
        (a_stop, InternalChoice((STOP, DIV)), "FD", Difference((), refusal=ABC.everything)),
    ],
)  # fmt: skip
def test_the_first_difference(spec: Process, impl: Process, model: Model, difference: Difference | None) -> None:
    assert refinement(ABC.of(spec), ABC.of(impl), model) == difference
