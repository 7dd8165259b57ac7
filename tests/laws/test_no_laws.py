"""What is no law: equations that look like one, or are one in a weaker model only, with what refutes them.

Each is ``spec [model= impl``; the engine must refute it with this very behaviour, and accept it in the models that
are named as seeing no difference.
"""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import DIV, SKIP, STOP, Chaos, Process
from tests.differential.engine import checker, said, visible
from tests.laws.notation import (
    external,
    hide,
    interleave,
    internal,
    interrupt,
    parallel,
    rename,
    sequence,
    sliding,
)
from tests.reference.denotations import Semantics
from tests.reference.processes import EVENTS, SIGMA, TABLE, A, B, C
from tests.reference.verdicts import Difference, Model, Trace, refinement

a_stop, b_stop, c_stop = (prefix(event, STOP) for event in EVENTS)
a_b_stop = prefix(A, b_stop)
only_a = EventSet.of([A])
either = internal(a_stop, b_stop)


@dataclass(frozen=True)
class NoLaw:
    """``spec [model= impl`` fails after ``trace``, by an event, a refusal, or (neither given) divergence."""

    name: str
    spec: Process
    impl: Process
    model: Model
    trace: Trace = ()
    event: str | None = None
    refusal: tuple[str, ...] | None = None
    holds_in: tuple[Model, ...] = ()


NO_LAWS = [
    NoLaw(
        "P |~| Q = P [] Q",
        external(a_stop, b_stop),
        either,
        "F",
        refusal=("b",),
        holds_in=("T",),
    ),
    NoLaw(
        "a -> P [] a -> Q = a -> (P [] Q)",
        prefix(A, external(a_stop, b_stop)),
        external(prefix(A, a_stop), prefix(A, b_stop)),
        "F",
        trace=(A,),
        refusal=("b",),
        holds_in=("T",),
    ),
    NoLaw("P [> Q = Q [> P", sliding(b_stop, a_stop), sliding(a_stop, b_stop), "F", refusal=("a",), holds_in=("T",)),
    NoLaw("P [] SKIP = P |~| SKIP, on the side of P", a_stop, external(a_stop, SKIP), "T", event="tick"),
    NoLaw("P [|Events|] P = P", either, parallel(either, SIGMA, either), "F", refusal=("a", "b"), holds_in=("T",)),
    NoLaw("P ||| P = P", a_stop, interleave(a_stop, a_stop), "T", trace=(A,), event="a"),
    NoLaw("P ||| STOP = P", interleave(SKIP, STOP), SKIP, "T", event="tick"),
    NoLaw(
        "(P [] Q) \\ X = (P \\ X) [] (Q \\ X)",
        external(hide(a_stop, only_a), hide(b_stop, only_a)),
        hide(external(a_stop, b_stop), only_a),
        "F",
        refusal=("b",),
        holds_in=("T",),
    ),
    NoLaw(
        "(P /\\ Q) \\ X = (P \\ X) /\\ (Q \\ X)",
        interrupt(hide(b_stop, only_a), hide(a_stop, only_a)),
        hide(interrupt(b_stop, a_stop), only_a),
        "F",
        refusal=("b",),
        holds_in=("T",),
    ),
    NoLaw(
        "(P [|X|] Q) \\ X = (P \\ X) [|X|] (Q \\ X)",
        hide(parallel(a_b_stop, only_a, STOP), only_a),
        parallel(hide(a_b_stop, only_a), only_a, hide(STOP, only_a)),
        "T",
        event="b",
    ),
    NoLaw(
        "(P [|X|] Q)[[R]] = P[[R]] [|R(X)|] Q[[R]] for R that is not injective",
        rename(parallel(a_stop, EventSet.of([A, B]), b_stop), ((A, C), (B, C))),
        parallel(rename(a_stop, ((A, C),)), EventSet.of([C]), rename(b_stop, ((B, C),))),
        "T",
        event="c",
    ),
    NoLaw(
        "(P [] Q) ; R = (P ; R) [] (Q ; R)",
        external(sequence(SKIP, b_stop), sequence(a_stop, b_stop)),
        sequence(external(SKIP, a_stop), b_stop),
        "F",
        refusal=("a",),
        holds_in=("T",),
    ),
    NoLaw(
        "P /\\ Q = Q /\\ P",
        interrupt(a_b_stop, c_stop),
        interrupt(c_stop, a_b_stop),
        "T",
        trace=(C,),
        event="a",
    ),
    NoLaw("P |~| DIV = P", a_stop, internal(a_stop, DIV), "FD", holds_in=("T", "F")),
    NoLaw("P ; DIV = DIV ; P", sequence(a_stop, SKIP), sequence(prefix(A, SKIP), DIV), "FD", (A,), holds_in=("T",)),
    NoLaw("CHAOS is refined by everything", Chaos(SIGMA), prefix(A, DIV), "FD", (A,), holds_in=("T", "F")),
    NoLaw("STOP = SKIP", SKIP, STOP, "F", refusal=("tick",), holds_in=("T",)),
    NoLaw("DIV = STOP", DIV, STOP, "F", refusal=(), holds_in=("T", "FD")),
]  # fmt: skip


@pytest.mark.parametrize("no_law", NO_LAWS, ids=lambda no_law: no_law.name)
def test_it_is_refuted(no_law: NoLaw) -> None:
    outcome = checker().check_refinement(no_law.spec, no_law.model, no_law.impl)
    found = outcome.counterexample

    assert said(outcome) is False
    assert found is not None
    assert visible(found.trace) == no_law.trace
    if no_law.event is not None:
        assert (found.kind, found.event) == ("trace", no_law.event)
    elif no_law.refusal is not None:
        assert (found.kind, found.refusal) == ("refusal", no_law.refusal)
    else:
        assert found.kind == "divergence"


@pytest.mark.parametrize("no_law", NO_LAWS, ids=lambda no_law: no_law.name)
def test_it_is_refuted_by_the_definitions_in_the_same_way(no_law: NoLaw) -> None:
    semantics = Semantics(EVENTS)
    difference = refinement(semantics.of(no_law.spec), semantics.of(no_law.impl), no_law.model)

    assert difference is not None
    assert difference.trace == no_law.trace
    assert describe(difference) == no_law.event
    assert (difference.refusal is not None) == (no_law.refusal is not None)
    assert difference.diverges == (no_law.event is None and no_law.refusal is None)


@pytest.mark.parametrize(
    ("no_law", "model"), [(n, m) for n in NO_LAWS for m in n.holds_in], ids=lambda value: getattr(value, "name", value)
)
def test_the_weaker_model_does_not_see_it(no_law: NoLaw, model: Model) -> None:
    assert said(checker().check_refinement(no_law.spec, model, no_law.impl)) is True


def describe(difference: Difference) -> str | None:
    return None if difference.event is None else TABLE.name(difference.event)
