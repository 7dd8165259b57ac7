"""What cannot be compiled to its end says where, and what only looks endless is compiled all the same."""

from __future__ import annotations

import pytest

from cspcheck.checker.network import actions
from cspcheck.checker.network.compiler import Compiler, compile_network
from cspcheck.checker.semantics.transitions import LimitReached
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.process.construction import prefix
from cspcheck.cspm.process.definitions import Definition
from cspcheck.cspm.process.events import EventSet
from cspcheck.cspm.process.terms import (
    SKIP,
    STOP,
    ExternalChoice,
    Hide,
    Parallel,
    Prefix,
    Process,
    Reference,
    Rename,
    Sequential,
)
from tests.checker.exploring import interpreted
from tests.checker.network.test_composition import assert_same_machine, loop
from tests.checker.terms import reference

a, b, c = 2, 3, 4
NOTHING = EventSet()


def count(n: int) -> Process:
    """``Count(n) = a -> Count(n + 1)``."""
    return Reference(("Count", n), Definition(f"Count({n})", None, lambda: prefix(a, count(n + 1))))


def counter(n: int) -> Process:
    """``Counter(n) = a -> Counter(n + 1) [] n > 0 & b -> Counter(n - 1)``."""

    def body() -> Process:
        up = prefix(a, counter(n + 1))
        return ExternalChoice((up, prefix(b, counter(n - 1)))) if n else up

    return Reference(("Counter", n), Definition(f"Counter({n})", None, body))


def limit_of(process: Process, limits: Limits) -> Diagnostic:
    with pytest.raises(LimitReached) as failure:
        compile_network(process, limits)
    return failure.value.diagnostic


class TestEndlessComponents:
    @pytest.mark.parametrize(
        "around",
        [
            lambda p: p,
            lambda p: Parallel(NOTHING, (loop(5), Hide(p, EventSet.of([a])))),
            lambda p: Parallel(NOTHING, (loop(5), prefix(b, p))),
        ],
    )
    def test_arguments_that_grow_are_told(self, around: object) -> None:
        assert callable(around)
        found = limit_of(around(count(0)), Limits(states=3_000))
        assert found.code == "CSP503"
        assert found.message.startswith("more than 3,000 states: `Count` is called with ")
        assert "different arguments: `Count(0)`, `Count(1)`, `Count(2)`, ..." in found.message

    def test_a_memory_limit_is_a_limit_on_terms(self) -> None:
        found = limit_of(count(0), Limits(memory_bytes=1_500_000))
        assert found.message.startswith("more than 1,000 states: ")

    def test_parallel_copies_without_end(self) -> None:
        copies = reference("Copies", lambda: prefix(a, Parallel(NOTHING, (copies, prefix(b, STOP)))))
        found = limit_of(copies, Limits(states=3_000))
        assert found.code == "CSP504"
        assert found.message.startswith("more than 3,000 states: `Copies` keeps growing, `[| |]` is nested ")

    def test_a_component_that_its_partners_keep_in_bounds_is_compiled(self) -> None:
        """Alone the counter has no end; the other allows five more ups than downs."""

        def bound(n: int) -> Process:
            branches = [(a, n + 1)] * (n < 5) + [(b, n - 1)] * (n > 0)
            return Reference(
                ("Bound", n),
                Definition(f"Bound({n})", None, lambda: Prefix(tuple((event, bound(m)) for event, m in branches))),
            )

        both = Parallel(EventSet.of([a, b]), (counter(0), bound(0)))
        assert len(interpreted(compile_network(both, slot_states=500))) == 6

    def test_a_large_component_is_compiled(self) -> None:
        """More states than a component is first given."""
        process = Parallel(NOTHING, (loop(5), _cycle(3_000)))
        network = compile_network(process, slot_states=500)
        assert [slot.lts.states for slot in network.slots] == [3, 3_000]


def _cycle(length: int) -> Process:
    def at(n: int) -> Process:
        text = f"Cycle({n})"
        return Reference(("Cycle", length, n), Definition(text, None, lambda: prefix(a, at((n + 1) % length))))

    return at(0)


class TestPolling:
    class Enough(Exception):
        pass

    def test_what_poll_raises_ends_the_work_and_leaves_the_compiler_as_it_was(self) -> None:
        def poll(states: int) -> None:
            raise self.Enough

        compiler = Compiler()
        with pytest.raises(self.Enough):
            compiler.network(count(0), poll=poll)
        assert len(interpreted(compiler.network(loop(2)))) == 3

    def test_it_is_told_how_far_the_work_is(self) -> None:
        told: list[int] = []
        compile_network(_cycle(5_000), poll=told.append)
        assert told
        assert all(0 < states <= 5_000 for states in told)


class TestRulesThatAreTooMany:
    def test_are_not_written_down(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Each of four takes part in d by any of three events: 81 rules, or one component."""
        pairs = ((a, 9), (b, 9), (c, 9))
        choice = Prefix(((a, STOP), (b, SKIP), (c, prefix(a, STOP))))
        process = Parallel(EventSet.of([9]), tuple(Rename(choice, pairs) for _ in range(4)))
        network = compile_network(process)
        assert len(network.slots) == 4
        assert sum(len(rule.moves) == 4 and rule.result == 9 for rule in network.rules) == 81
        assert_same_machine(process)
        monkeypatch.setattr(actions, "MOST_ACTIONS", 80)
        assert len(compile_network(process).slots) == 1
        assert_same_machine(process)


class TestScriptErrors:
    def test_a_composition_that_calls_itself(self) -> None:
        process = reference("P", lambda: Parallel(NOTHING, (process, STOP)))
        with pytest.raises(ScriptError, match="`P` calls itself before any event"):
            compile_network(process)

    def test_a_component_that_calls_itself_later(self) -> None:
        process = reference("P", lambda: Sequential(process, STOP))
        with pytest.raises(ScriptError, match="`P` calls itself before any event"):
            compile_network(Parallel(NOTHING, (STOP, prefix(a, process))))
