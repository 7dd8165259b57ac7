"""Recursion: names unfold without a tau, and a recursion without a guard or an end is told as what it is."""

from __future__ import annotations

import pytest

from cspcheck.checker.semantics import head_normal
from cspcheck.checker.semantics.head_normal import HeadNormalForms
from cspcheck.checker.semantics.transitions import LimitReached, Semantics, explore, transitions
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.definitions import Definition
from cspcheck.cspm.process.events import TAU, EventSet
from cspcheck.cspm.process.terms import (
    SKIP,
    STOP,
    ExternalChoice,
    Hide,
    InternalChoice,
    Interrupt,
    Parallel,
    Prefix,
    Process,
    Reference,
    Sequential,
    SlidingChoice,
    Throw,
)
from cspcheck.cspm.source import Source, Span
from tests.checker.terms import reference

a, b, c = 2, 3, 4
SOURCE = Source("x.csp", "P = ...\nQ = ...\nR(n) = ...\n")


def line(number: int) -> Span:
    start = sum(len(text) + 1 for text in SOURCE.text.split("\n")[: number - 1])
    return SOURCE.span(start, start + 1)


class Script:
    """Definitions by name; a call of ``R`` has an argument."""

    def __init__(self, **bodies: object) -> None:
        self.bodies = bodies

    def __call__(self, name: str, *arguments: int) -> Reference:
        lines = {"P": 1, "Q": 2, "R": 3}
        text = f"{name}({', '.join(map(str, arguments))})" if arguments else name
        body = self.bodies[name]
        assert callable(body)
        return Reference((id(self), text), Definition(text, line(lines[name]), lambda: body(*arguments)))


def mistake_in(process: Process) -> Diagnostic:
    with pytest.raises(ScriptError) as failure:
        transitions(process)
    (diagnostic,) = failure.value.diagnostics
    return diagnostic


class TestUnguardedRecursion:
    @pytest.mark.parametrize(
        "around",
        [
            lambda p: p,
            lambda p: ExternalChoice((p, prefix(a, STOP))),
            lambda p: SlidingChoice(p, STOP),
            lambda p: Interrupt(prefix(a, STOP), p),
            lambda p: Throw(p, EventSet.of([a]), STOP),
            lambda p: Sequential(p, SKIP),
            lambda p: Parallel(EventSet(), (STOP, p)),
            lambda p: Hide(p, EventSet.of([a])),
        ],
    )
    def test_a_process_that_calls_itself_first(self, around: object) -> None:
        assert callable(around)
        script = Script(P=lambda: around(script("P")))
        found = mistake_in(script("P"))
        assert found.code == "CSP501"
        assert found.message == "`P` calls itself before any event"
        assert found.span == line(1)
        assert found.annotation == "unguarded recursion"
        assert found.help == "put an event before the recursive call, as in `P = a -> P`"

    def test_through_other_definitions(self) -> None:
        script = Script(
            P=lambda: ExternalChoice((prefix(a, STOP), script("Q"))),
            Q=lambda: Sequential(script("R", 1), STOP),
            R=lambda n: Hide(script("P"), EventSet.of([a])),
        )
        found = mistake_in(script("P"))
        assert found.message == "`P` calls itself before any event, through `Q`, `R(1)`"
        assert [(label.span.line, label.message) for label in found.labels] == [
            (2, "`Q` calls `R(1)` before any event"),
            (3, "`R(1)` calls `P` before any event"),
        ]

    def test_the_cycle_is_told_without_the_way_to_it(self) -> None:
        script = Script(P=lambda: Sequential(script("Q"), STOP), Q=lambda: ExternalChoice((script("Q"), STOP)))
        assert mistake_in(script("P")).message == "`Q` calls itself before any event"

    def test_it_is_found_when_the_process_gets_there(self) -> None:
        script = Script(P=lambda: prefix(a, script("Q")), Q=lambda: script("Q"))
        with pytest.raises(ScriptError, match="`Q` calls itself before any event"):
            explore(script("P"))

    @pytest.mark.parametrize(
        "around",
        [
            lambda p: prefix(a, p),
            lambda p: InternalChoice((p, STOP)),
            lambda p: SlidingChoice(STOP, p),
            lambda p: Sequential(SKIP, p),
        ],
    )
    def test_an_event_or_a_choice_of_its_own_is_a_guard(self, around: object) -> None:
        assert callable(around)
        script = Script(P=lambda: around(script("P")))
        assert explore(script("P")).lts.states <= 2

    def test_two_calls_side_by_side_are_no_cycle(self) -> None:
        script = Script(P=lambda: Parallel(EventSet(), (script("Q"), script("Q"))), Q=lambda: prefix(a, script("Q")))
        assert explore(script("P")).lts.states == 1


class TestEndlessUnfolding:
    def test_ever_new_arguments_without_an_event(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(head_normal, "MAXIMAL_UNFOLDING", 1_000)
        script = Script(R=lambda n: ExternalChoice((prefix(a, STOP), script("R", n + 1))), P=lambda: script("R", 0))
        found = mistake_in(script("P"))
        assert found.code == "CSP502"
        assert found.message == "`R(0)`, `R(1)`, `R(2)`, ... call one another before any event"
        assert found.notes == ("given up after 1,001 nested calls",)
        assert found.span == line(3)

    def test_a_deep_one_that_ends_is_fine(self) -> None:
        script = Script(R=lambda n: script("R", n - 1) if n else prefix(a, STOP))
        assert transitions(script("R", 20_000)) == ((a, STOP),)


class TestDepth:
    """The depth of a term is limited by memory, not by Python's stack."""

    DEPTH = 20_000

    def test_a_long_chain_of_sequential_compositions(self) -> None:
        process = prefix(a, SKIP)
        for _ in range(self.DEPTH):
            process = Sequential(process, prefix(b, SKIP))
        assert [event for event, _ in transitions(process)] == [a]

    def test_a_tick_that_comes_from_far_below(self) -> None:
        process: Process = SKIP
        for _ in range(self.DEPTH):
            process = Hide(Throw(process, EventSet(), STOP), EventSet.of([a]))
        assert len(transitions(process)) == 1

    def test_a_process_that_leaves_something_behind_each_time(self) -> None:
        script = Script(P=lambda: Sequential(prefix(a, script("P")), prefix(b, SKIP)))
        with pytest.raises(LimitReached):
            explore(script("P"), Limits(states=self.DEPTH))


class TestLimit:
    def limit_of(self, process: Process, states: int) -> Diagnostic:
        with pytest.raises(LimitReached) as failure:
            explore(process, Limits(states=states))
        assert failure.value.states == states
        return failure.value.diagnostic

    def test_as_many_states_as_the_limit_are_fine(self) -> None:
        assert explore(prefix(a, prefix(b, STOP)), Limits(states=3)).lts.states == 3

    def test_arguments_that_grow(self) -> None:
        script = Script(R=lambda n: prefix(a, script("R", n + 1)))
        found = self.limit_of(script("R", 0), 1_000)
        assert found.code == "CSP503"
        assert found.message == (
            "more than 1,000 states: `R` is called with 1,000 different arguments: `R(0)`, `R(1)`, `R(2)`, ..."
        )
        assert found.span == line(3)
        assert found.help == "bound the argument, for instance `n < 10 & ...`, or raise the limit with `--max-states`"

    def test_arguments_that_grow_in_a_part(self) -> None:
        script = Script(R=lambda n: prefix(a, script("R", n + 1)), Q=lambda: prefix(b, prefix(c, script("Q"))))
        found = self.limit_of(Parallel(EventSet(), (script("Q"), script("R", 0))), 100)
        assert found.message.startswith("more than 100 states: `R` is called with 51 different arguments: `R(0)`, ")

    def test_a_process_that_grows(self) -> None:
        script = Script(P=lambda: Sequential(prefix(a, script("P")), prefix(b, SKIP)))
        found = self.limit_of(script("P"), 100)
        assert found.code == "CSP504"
        assert found.message == "more than 100 states: `P` keeps growing, `;` is nested 100 deep"
        assert found.help == "let the recursive call be the last thing that happens, outside `;`"

    def test_parallel_copies_without_end(self) -> None:
        script = Script(P=lambda: prefix(a, Parallel(EventSet(), (script("P"), prefix(b, STOP)))))
        assert self.limit_of(script("P"), 1_000).message.startswith(
            "more than 1,000 states: `P` keeps growing, `[| |]` is nested "
        )

    def test_merely_many_states(self) -> None:
        loops = [reference(f"L{i}", lambda: STOP) for i in range(12)]
        many = Parallel(EventSet(), tuple(prefix(a + i, loop) for i, loop in enumerate(loops)))
        script = Script(P=lambda: many)
        found = self.limit_of(script("P"), 1_000)
        assert found.code == "CSP505"
        assert found.message == "more than 1,000 states in `P`"

    def test_the_exploration_can_be_ended_from_outside(self) -> None:
        class Enough(Exception):
            pass

        def poll(states: int) -> None:
            raise Enough(states)

        script = Script(R=lambda n: prefix(a, script("R", n + 1)))
        with pytest.raises(Enough):
            explore(script("R", 0), poll=poll)


class TestHeadNormalForm:
    def test_only_what_runs_is_unfolded(self) -> None:
        script = Script(P=lambda: prefix(a, script("P")), Q=lambda: Sequential(script("P"), script("P")))
        body = prefix(a, script("P"))
        forms = HeadNormalForms()
        assert forms.of(script("Q")) is Sequential(body, script("P"))
        assert forms.of(InternalChoice((script("P"), STOP))) is InternalChoice((script("P"), STOP))
        assert forms.of(prefix(b, script("P"))) is prefix(b, script("P"))

    def test_it_is_its_own_head_normal_form(self) -> None:
        script = Script(P=lambda: prefix(a, script("P")))
        forms = HeadNormalForms()
        found = forms.of(Hide(Parallel(EventSet(), (script("P"), SKIP)), EventSet.of([a])))
        assert forms.of(found) is found

    def test_a_state_is_called_by_the_first_name_met_for_it(self) -> None:
        script = Script(P=lambda: prefix(a, STOP), Q=lambda: script("P"))
        forms = HeadNormalForms()
        state = forms.of(script("Q"))
        assert forms.name(state) is script("P")
        assert forms.name(STOP) is None


def test_transitions_remembered_from_another_exploration_change_nothing() -> None:
    script = Script(
        P=lambda: Prefix(((a, script("Q")), (b, script("P")))), Q=lambda: InternalChoice((script("P"), SKIP))
    )
    process = Sequential(Parallel(EventSet.of([a]), (script("P"), script("Q"))), script("P"))
    semantics = Semantics()
    explore(script("Q"), semantics=semantics)
    shared = explore(process, semantics=semantics)
    fresh = explore(process)
    assert shared.terms == fresh.terms
    assert [list(shared.lts.successors(s)) for s in range(shared.lts.states)] == [
        list(fresh.lts.successors(s)) for s in range(fresh.lts.states)
    ]
    assert TAU in fresh.lts.alphabet()
