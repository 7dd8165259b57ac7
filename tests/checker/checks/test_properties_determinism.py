"""Determinism: no event is ever both possible and refusable."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.checker.budget import Budget
from cspcheck.checker.checks import choosing, determinism, state_sets
from cspcheck.checker.checks.state_sets import StateSets
from cspcheck.checker.checks.store import Machines
from cspcheck.checker.search.spill import Spill
from cspcheck.checker.specification.acceptances import divergent_states
from cspcheck.checker.specification.normal_form import FailuresModel
from cspcheck.checker.verdict import Limits, Outcome, Verdict
from cspcheck.cspm.process.terms import DIV, SKIP, STOP, Chaos, Process, Rename, Run
from tests.checker import explicit
from tests.checker.explicit import lts
from tests.checker.terms import BASIC, STATIC, compositions, processes
from tests.checker.textbook import (
    a,
    b,
    c,
    checker,
    choose,
    d,
    events,
    forever,
    hidden,
    identifiers,
    interleave,
    perhaps,
    rows_of,
    sequence,
    share,
    then,
    timeout,
)

ab = events(a, b)
terms = st.one_of(processes(size=8), compositions(size=5, components=3))
nearly_deterministic = compositions(operators=BASIC, static=STATIC, size=6, components=3)
"""Prefixes in parallel, hidden and renamed: often deterministic, often with taus."""
mostly_divergent = st.one_of(
    nearly_deterministic.map(lambda process: choose(process, then(a, b, DIV))),
    nearly_deterministic.map(lambda process: interleave(process, then(c, hidden(forever(d, d), d)))),
    processes(size=5).map(lambda process: hidden(interleave(process, then(c, forever(d))), d)),
)


def holds(outcome: Outcome) -> bool:
    assert outcome.verdict in (Verdict.PASS, Verdict.FAIL)
    return outcome.verdict is Verdict.PASS


@pytest.mark.parametrize(
    ("process", "in_f", "in_fd"),
    [
        pytest.param(STOP, True, True, id="STOP"),
        pytest.param(SKIP, True, True, id="SKIP"),
        pytest.param(DIV, True, False, id="DIV refuses nothing in F"),
        pytest.param(Run(ab), True, True, id="RUN"),
        pytest.param(Chaos(ab), False, False, id="CHAOS"),
        pytest.param(choose(then(a, STOP), then(b, STOP)), True, True, id="external choice"),
        pytest.param(choose(then(a, STOP), then(a, b, STOP)), False, False, id="one event, two branches"),
        pytest.param(choose(then(a, b, STOP), then(a, b, STOP)), True, True, id="the same branch twice"),
        pytest.param(perhaps(then(a, STOP), then(b, STOP)), False, False, id="internal choice"),
        pytest.param(perhaps(then(a, STOP), then(a, STOP)), True, True, id="internal choice between equals"),
        pytest.param(timeout(then(a, STOP), then(b, STOP)), False, False, id="timeout"),
        pytest.param(choose(SKIP, then(a, STOP)), False, False, id="termination beside an event"),
        pytest.param(perhaps(SKIP, STOP), False, False, id="termination or not"),
        pytest.param(sequence(then(a, SKIP), then(b, STOP)), True, True, id="the tau of a termination"),
        pytest.param(interleave(forever(a), forever(b)), True, True, id="interleaving of different events"),
        pytest.param(
            interleave(forever(a, b), forever(a, c)), False, False, id="interleaving of the same event, who knows whose"
        ),
        pytest.param(interleave(forever(a, b), forever(a, b)), True, True, id="interleaving of equals"),
        pytest.param(
            hidden(share(events(c), forever(a, c), forever(c, b)), c),
            True,
            True,
            id="hand-over between cells",
        ),
        pytest.param(hidden(choose(then(a, c, STOP), then(b, d, STOP)), a, b), False, False, id="hidden choice"),
        pytest.param(Rename(choose(then(a, c, STOP), then(b, d, STOP)), ((b, a),)), False, False, id="renamed choice"),
        pytest.param(choose(then(a, STOP), DIV), True, False, id="an event beside a divergence, in F"),
        pytest.param(
            choose(then(a, then(b, STOP)), then(a, DIV)), True, False, id="an event into a divergence or a stable state"
        ),
        pytest.param(
            choose(then(a, choose(then(b, STOP), DIV)), then(a, c, STOP)), False, False, id="refused elsewhere, in F"
        ),
    ],
)
def test_textbook(process: Process, in_f: bool, in_fd: bool) -> None:
    assert holds(checker().check_property(process, "deterministic", "F")) == in_f
    assert holds(checker().check_property(process, "deterministic", "FD")) == in_fd
    assert holds(checker().check_property(process, "deterministic")) == in_fd


@settings(deadline=None)
@given(st.one_of(terms, nearly_deterministic), st.booleans())
def test_in_f_the_first_trace_and_event(process: Process, full: bool) -> None:
    outcome = checker(full=full).check_property(process, "deterministic", "F")
    rows = rows_of(process)
    expected = explicit.first_nondeterminism(rows)
    assert holds(outcome) == (expected is None)
    found = outcome.counterexample
    if found is not None and expected is not None:
        trace, event = expected
        assert found.kind == "nondeterminism"
        assert identifiers(found.trace) == trace
        assert identifiers([found.event or ""]) == (event,)
        assert found.alternative is not None
        assert identifiers(found.alternative) == (*trace, event)


@settings(deadline=None)
@given(st.one_of(terms, nearly_deterministic, mostly_divergent), st.booleans())
def test_in_fd_what_comes_after_the_first_trace_is_told_and_divergence_before_nondeterminism(
    process: Process, full: bool
) -> None:
    outcome = checker(full=full).check_property(process, "deterministic", "FD")
    rows = rows_of(process)
    divergence = explicit.first_divergence(rows)
    expected = explicit.first_nondeterminism(rows)
    assert holds(outcome) == (divergence is None and expected is None)
    found = outcome.counterexample
    if found is not None:
        wrong = [(divergence, "divergence")] if divergence is not None else []
        wrong += [(expected[0], "nondeterminism")] if expected is not None else []
        assert (identifiers(found.trace), found.kind) == min(wrong, key=lambda what: (len(what[0]), *what))


@settings(deadline=None)
@given(st.one_of(terms, nearly_deterministic))
def test_a_deterministic_process_is_equivalent_to_its_candidate(process: Process) -> None:
    """The states that the candidate chooses have all the failures of the process, which has no others."""
    rows = rows_of(process)
    machine = lts(rows)
    if divergent_states(machine).any() or explicit.first_nondeterminism(rows) is not None:
        return
    from cspcheck.checker.checks.determinism import candidate

    chosen = candidate(machine)
    for trace in explicit.traces(rows, 4):
        node = chosen.along(trace)
        assert node is not None
        states = explicit.after(rows, trace)
        assert set(chosen.allowed(node)) == explicit.events(rows, states)
        assert {frozenset(acceptance) for acceptance in chosen.acceptances(node)} == explicit.acceptances(rows, states)


@settings(deadline=None)
@given(
    st.one_of(terms, nearly_deterministic, mostly_divergent),
    st.sampled_from((0, 1, 2, 3, 9_999)),
    st.sampled_from(("F", "FD")),
)
def test_larger_than_memory_it_is_told_as_in_memory(
    tmp_path_factory: pytest.TempPathFactory, process: Process, rows: int, model: FailuresModel
) -> None:
    expected = checker(full=True).check_property(process, "deterministic", model)
    place = Spill(tmp_path_factory.getbasetemp() / "spilled", rows)
    with pytest.MonkeyPatch.context() as patch:
        # A few states and sets at a time.
        patch.setattr(state_sets, "BATCH", rows)
        patch.setattr(state_sets, "CHUNK", rows + 1)
        patch.setattr(choosing, "CHUNK", rows + 1)
        # What is explored in memory need not have room to be listed.
        patch.setattr(determinism, "LISTED", 1 << 50)
        found = checker(full=True, beyond=place, memory_bytes=1 << 50).check_property(process, "deterministic", model)
    assert replace(found, seconds=0, peak_memory_bytes=0) == replace(expected, seconds=0, peak_memory_bytes=0)


@settings(deadline=None)
@given(st.one_of(terms, mostly_divergent))
def test_sets_of_states_of_which_hashes_tell_nothing(process: Process) -> None:
    packed = Machines().packed(process, Budget(Limits()))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(state_sets, "_mixed", np.zeros_like)
        found = StateSets(packed, Budget(Limits()), None).first_nondeterminism()
    expected = explicit.first_nondeterminism(rows_of(process))
    assert found == (None if expected is None else expected[0])


def test_both_runs_are_told() -> None:
    process = then(a, perhaps(then(b, STOP), then(c, STOP)))
    found = checker().check_property(process, "deterministic").counterexample
    assert found is not None
    assert (found.kind, found.trace, found.event, found.refusal) == ("nondeterminism", ("a", "tau"), "b", ("b",))
    assert found.alternative == ("a", "tau", "b")
