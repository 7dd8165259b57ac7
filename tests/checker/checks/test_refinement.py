"""Refinement: the specification can do all that the implementation does, in the sense of the model."""

from __future__ import annotations

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.checker.verdict import Verdict
from cspcheck.cspm.process.events import TICK
from cspcheck.cspm.process.terms import DIV, SKIP, STOP, Buffer, Chaos, Process, Rename, Run
from tests.checker import explicit
from tests.checker.terms import compositions, processes
from tests.checker.textbook import (
    a,
    b,
    c,
    checker,
    choose,
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

MODELS = ("T", "F", "FD")
ab = events(a, b)
either = choose(then(a, STOP), then(b, STOP))
one_of = perhaps(then(a, STOP), then(b, STOP))


def buffer(capacity: int) -> Process:
    return Buffer("BUFFER", capacity, (), ((a, b),), ())


two_cells = hidden(share(events(c), forever(a, c), forever(c, b)), c)
"""Two places for one kind of message, joined by c."""


class TestTextbook:
    """In which of the models ``P [X= Q`` holds."""

    @pytest.mark.parametrize(
        ("specification", "implementation", "models"),
        [
            # STOP has the least traces, and refuses the most.
            pytest.param(either, STOP, "T", id="a -> STOP [] b -> STOP by STOP"),
            pytest.param(STOP, then(a, STOP), "", id="STOP by a -> STOP"),
            # Internal choice has the traces of external choice and more refusals.
            pytest.param(one_of, either, "T F FD", id="internal by external choice"),
            pytest.param(either, one_of, "T", id="external by internal choice"),
            pytest.param(perhaps(then(a, STOP), STOP), then(a, STOP), "T F FD", id="choice of STOP by none"),
            pytest.param(then(a, STOP), perhaps(then(a, STOP), STOP), "T", id="prefix by choice of STOP"),
            # A timeout is an internal choice whose first part can be seen.
            pytest.param(timeout(then(a, STOP), then(b, STOP)), then(b, STOP), "T F FD", id="timeout by its second"),
            pytest.param(
                timeout(then(a, STOP), then(b, STOP)), then(a, STOP), "T", id="timeout by its first, which never ends"
            ),
            pytest.param(timeout(then(a, STOP), then(b, STOP)), either, "T F FD", id="timeout by external choice"),
            # RUN and CHAOS are the ends of the scale for divergence-free processes.
            pytest.param(Run(ab), either, "T", id="RUN by something that stops"),
            pytest.param(Chaos(ab), either, "T F FD", id="CHAOS by something without divergence"),
            pytest.param(Chaos(ab), STOP, "T F FD", id="CHAOS by STOP"),
            pytest.param(Chaos(ab), SKIP, "", id="CHAOS does not terminate"),
            pytest.param(Chaos(ab), then(c, STOP), "", id="CHAOS of other events"),
            # Divergence: nothing in T and F, everything in FD.
            pytest.param(STOP, DIV, "T F", id="STOP by DIV"),
            pytest.param(DIV, STOP, "T FD", id="DIV by STOP"),
            pytest.param(DIV, then(a, STOP), "FD", id="DIV by a -> STOP"),
            pytest.param(then(a, DIV), then(a, b, c, STOP), "FD", id="after a divergence anything goes"),
            pytest.param(Chaos(ab), hidden(forever(a), a), "T F", id="CHAOS by a divergence from hiding"),
            pytest.param(then(b, STOP), hidden(then(a, b, STOP), a), "T F FD", id="hiding a first event"),
            pytest.param(hidden(either, a), then(b, STOP), "T F FD", id="hiding one branch makes the other optional"),
            pytest.param(then(b, STOP), hidden(either, a), "T", id="and so it may be refused"),
            # Termination is signalled: a process that may terminate can be relied on for nothing else.
            pytest.param(SKIP, choose(SKIP, then(a, STOP)), "", id="SKIP by SKIP [] a -> STOP"),
            pytest.param(choose(SKIP, then(a, STOP)), SKIP, "T F FD", id="SKIP [] a -> STOP by SKIP"),
            pytest.param(choose(SKIP, then(a, STOP)), then(a, STOP), "T", id="SKIP [] a -> STOP by a -> STOP"),
            pytest.param(
                choose(SKIP, then(a, STOP)), timeout(then(a, STOP), SKIP), "T F FD", id="SKIP [] P is P [> SKIP"
            ),
            pytest.param(STOP, SKIP, "", id="STOP by SKIP"),
            pytest.param(SKIP, STOP, "T", id="SKIP by STOP"),
            pytest.param(then(a, STOP), sequence(then(a, SKIP), STOP), "T F FD", id="SKIP ; STOP"),
            pytest.param(
                interleave(then(a, SKIP), then(b, SKIP)),
                choose(then(a, b, SKIP), then(b, a, SKIP)),
                "T F FD",
                id="interleaving as choice",
            ),
            pytest.param(
                choose(then(a, b, SKIP), then(b, a, SKIP)),
                interleave(then(a, SKIP), then(b, SKIP)),
                "T F FD",
                id="choice as interleaving",
            ),
            # Buffers.
            pytest.param(buffer(2), two_cells, "T F FD", id="a buffer of two by two cells"),
            pytest.param(two_cells, buffer(2), "T F FD", id="two cells by a buffer of two"),
            pytest.param(buffer(2), buffer(1), "T", id="a smaller buffer refuses input"),
            pytest.param(buffer(1), buffer(2), "", id="a larger buffer has more traces"),
            # Renaming two events into one makes what follows unclear.
            pytest.param(
                Rename(choose(then(a, a, STOP), then(b, STOP)), ((b, a),)),
                then(a, STOP),
                "T F FD",
                id="renaming by the shorter branch",
            ),
        ],
    )
    def test_holds_in(self, specification: Process, implementation: Process, models: str) -> None:
        found = [
            model
            for model in MODELS
            if checker().check_refinement(specification, model, implementation).verdict is Verdict.PASS
        ]
        assert found == models.split()


terms = st.one_of(processes(size=6), compositions(size=4, components=2))


class TestAgainstSetsOfTraces:
    """The verdict and the counterexample are those that the definitions give."""

    @settings(deadline=None)
    @given(terms, st.sampled_from(MODELS), terms, st.booleans())
    def test_verdict_trace_kind_and_event(self, spec: Process, model: str, impl: Process, full: bool) -> None:
        outcome = checker(full=full).check_refinement(spec, model, impl)
        expected = explicit.refinement_violation(rows_of(spec), rows_of(impl), model)
        if expected is None:
            assert outcome.verdict is Verdict.PASS
            assert outcome.counterexample is None
            return
        trace, kinds = expected
        found = outcome.counterexample
        assert outcome.verdict is Verdict.FAIL
        assert found is not None
        assert identifiers(found.trace) == trace
        assert found.kind == next(kind for kind in ("trace", "refusal", "divergence") if kind in kinds)
        allowed = explicit.after(rows_of(spec), trace)
        actual = explicit.after(rows_of(impl), trace)
        if found.kind == "trace":
            forbidden = explicit.events(rows_of(impl), actual) - explicit.events(rows_of(spec), allowed)
            assert identifiers([found.event or ""]) == (min(forbidden),)

    @settings(deadline=None)
    @given(terms, st.sampled_from(("F", "FD")), terms)
    def test_a_refusal_is_one_of_the_implementation_and_none_of_the_specification(
        self, spec: Process, model: str, impl: Process
    ) -> None:
        found = checker().check_refinement(spec, model, impl).counterexample
        if found is None or found.kind != "refusal":
            return
        assert found.refusal is not None
        assert found.allowed is not None
        trace, refusal = identifiers(found.trace), set(identifiers(found.refusal))
        allowed, actual = explicit.after(rows_of(spec), trace), explicit.after(rows_of(impl), trace)
        assert any(not refusal & offer for offer in explicit.acceptances(rows_of(impl), actual))
        assert all(refusal & offer for offer in explicit.acceptances(rows_of(spec), allowed))
        assert {frozenset(identifiers(offer)) for offer in found.allowed} == explicit.minimal(
            explicit.acceptances(rows_of(spec), allowed)
        )

    @settings(deadline=None)
    @given(terms, st.sampled_from(MODELS))
    def test_every_process_refines_itself(self, process: Process, model: str) -> None:
        assert checker().check_refinement(process, model, process).verdict is Verdict.PASS

    @settings(deadline=None)
    @given(terms, st.sampled_from(MODELS), terms)
    def test_merging_nodes_of_the_normal_form_changes_no_counterexample(
        self, spec: Process, model: str, impl: Process
    ) -> None:
        merged = checker().check_refinement(spec, model, impl)
        plain = checker(full=True).check_refinement(spec, model, impl)
        assert merged.counterexample == plain.counterexample


class TestWhatIsSaid:
    """The counterexample in the words of the script."""

    def test_an_event_that_is_not_allowed(self) -> None:
        outcome = checker().check_refinement(then(a, b, STOP), "T", then(a, choose(then(b, STOP), then(c, STOP))))
        found = outcome.counterexample
        assert found is not None
        assert (found.kind, found.trace, found.event, found.allowed) == ("trace", ("a",), "c", (("b",),))
        assert found.specification_trace == ("a",)

    def test_a_refusal(self) -> None:
        outcome = checker().check_refinement(then(a, either), "F", then(a, one_of))
        found = outcome.counterexample
        assert found is not None
        assert (found.kind, found.trace) == ("refusal", ("a", "tau"))
        assert found.refusal == ("b",)
        assert found.allowed == (("a", "b"),)

    def test_a_hidden_event_is_told_as_the_cause_of_its_tau(self) -> None:
        found = checker().check_refinement(then(b, STOP), "T", hidden(then(a, b, c, STOP), a)).counterexample
        assert found is not None
        assert found.trace == ("tau", "b")
        assert found.causes == ("a", None)
        assert found.specification_trace == ("b",)

    def test_a_divergence_is_told_with_its_loop(self) -> None:
        loop = hidden(then(b, forever(a, c)), a, c)
        found = checker().check_refinement(Chaos(ab), "FD", loop).counterexample
        assert found is not None
        assert (found.kind, found.trace, found.loop) == ("divergence", ("b",), ("a", "c"))

    def test_termination_that_is_not_allowed(self) -> None:
        found = checker().check_refinement(then(a, STOP), "T", then(a, SKIP)).counterexample
        assert found is not None
        assert (found.trace, found.event) == (("a",), "tick")
        assert TICK == 1
