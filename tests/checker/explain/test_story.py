"""Small compositions that are one machine to the engine are told part by part all the same."""

from __future__ import annotations

from hypothesis import given, settings, strategies as st

from cspcheck.checker.check import Checker
from cspcheck.checker.explain.specification_run import specification_run
from cspcheck.checker.verdict import Counterexample
from cspcheck.cspm.process.events import TICK
from cspcheck.cspm.process.terms import SKIP, STOP, Process
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from tests.checker.terms import compositions, layered, processes, reference
from tests.checker.textbook import (
    EVENTS,
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
    perhaps,
    sequence,
    share,
    then,
)

terms = st.one_of(processes(size=8), compositions(size=5, components=3), layered())


def counterexample(process: Process, kind: str = "deadlock free", model: str | None = None) -> Counterexample:
    found = checker().check_property(process, kind, model).counterexample
    assert found is not None
    return found


def named(name: str, *steps: object) -> Process:
    return reference(name, lambda: then(*steps))


class TestParts:
    def test_components_behind_a_sequence_are_told(self) -> None:
        first = share(events(a), named("A", a, SKIP), named("B", a, b, SKIP))
        second = share(events(c, d), named("C", c, d, STOP), named("D", d, c, STOP))
        found = counterexample(sequence(first, second))
        assert found.trace == ("a", "b", "tau")
        assert [(part.name, part.trace, part.state) for part in found.components] == [
            ("A", ("a", None, "tick"), ""),
            ("B", ("a", "b", "tick"), ""),
            ("C", (None, None, None), "c -> d -> STOP"),
            ("D", (None, None, None), "d -> c -> STOP"),
        ]
        assert [part.waiting_for for part in found.components] == [(), (), ("D",), ("C",)]
        assert found.waiting_cycle == ("C", "D")

    def test_what_is_hidden_inside_a_component_is_told(self) -> None:
        found = counterexample(then(a, hidden(then(b, c, STOP), b)))
        assert (found.trace, found.causes) == (("a", "tau", "c"), (None, "b", None))

    def test_the_loop_of_a_divergence_tells_who_takes_part(self) -> None:
        pair = share(events(b, c), forever(b, c, name="Ping"), forever(b, c, name="Pong"))
        found = counterexample(hidden(then(a, pair), b, c), "divergence free")
        assert found.loop == ("b", "c")
        assert found.loop_parts == ((("Ping", "b"), ("Pong", "b")), (("Ping", "c"), ("Pong", "c")))

    def test_equal_components_have_numbers(self) -> None:
        user = forever(a, b, name="User")
        found = counterexample(share(events(a, b), user, forever(b, a, name="Other"), user))
        assert [part.name for part in found.components] == ["User #1", "Other", "User #2"]
        assert found.components[1].waiting_for == ("User #1", "User #2")

    @settings(deadline=None)
    @given(terms)
    def test_what_is_told_fits_together(self, process: Process) -> None:
        found = checker().check_property(process, "deadlock free").counterexample
        if found is None:
            return
        assert len({part.name for part in found.components}) == len(found.components)
        for part in found.components:
            assert len(part.trace) == len(found.trace)
        for step, cause in zip(found.trace, found.causes, strict=True):
            assert cause is None or step == "tau"
        # Where one component alone takes part and nothing is hidden, the whole does what it does.
        for i, step in enumerate(found.trace):
            assert any(part.trace[i] is not None for part in found.components)
            assert step == "tau" or all(part.trace[i] != "tau" for part in found.components)


class TestForbiddenEvents:
    def test_who_performs_them_is_told(self) -> None:
        implementation = share(events(b), forever(a, b, name="Left"), forever(b, c, name="Right"))
        found = checker().check_refinement(then(a, STOP), "T", implementation).counterexample
        assert found is not None
        assert (found.event, found.event_parts) == ("b", (("Left", "b"), ("Right", "b")))


class TestSpecification:
    def test_its_own_taus_are_part_of_its_run(self) -> None:
        specification = perhaps(then(a, hidden(then(c, b, STOP), c)), then(b, STOP))
        run = specification_run(specification, (a, b), EVENTS)
        assert run is not None
        assert run.trace == ("tau", "a", "tau", "b")
        assert run.causes == (None, None, "c", None)
        assert run.states[-1] == "STOP \\ {c}"

    def test_it_ends_in_a_stable_state_if_it_can(self) -> None:
        run = specification_run(then(a, perhaps(STOP, then(b, STOP))), (a,), EVENTS)
        assert run is not None
        assert (run.trace, run.states[-1]) == (("a", "tau"), "STOP")

    def test_it_is_named_where_it_has_a_name(self) -> None:
        run = specification_run(forever(a, b, name="Alternate"), (a, b), EVENTS)
        assert run is not None
        assert run.states == ("Alternate", "b -> Alternate", "Alternate")

    def test_a_trace_that_it_lacks_has_no_run(self) -> None:
        assert specification_run(choose(then(a, STOP), then(b, STOP)), (a, b), EVENTS) is None

    @settings(deadline=None)
    @given(terms, terms)
    def test_it_has_the_visible_events_of_the_counterexample(self, specification: Process, process: Process) -> None:
        found = checker().check_refinement(specification, "T", process).counterexample
        if found is None or found.specification is None:
            return
        assert identifiers(found.specification.trace) == identifiers(found.trace)
        assert all(event != TICK for event in identifiers(found.specification.trace)[:-1])


LIFT = """
class Lift
  chan up : []
  chan go : [f? : 0..2]
  main = go -> main [] up -> main
  state
    at, target : 0..2
    other : 0..1
  init at = 0 and target = 0 and other = 1
  op go
    Delta(target)
    f? : 0..2
  where
    target' = f?
  op up
    Delta(at)
  where
    at < target
    at' = at + 1
end
Once = go?f -> Once [] up -> Stay
Stay = go?f -> Stay
assert Once [T= Lift
"""


def test_a_class_is_called_by_its_name_and_shows_what_changes() -> None:
    loaded = load(Source("lift.csp", LIFT))
    outcome = Checker(loaded).check(loaded.assertions[0].node)

    found = outcome.counterexample
    assert found is not None
    assert found.trace == ("go.2", "up")
    assert found.event == "up"
    main, data = found.components
    assert (main.name, dict(main.variables), main.changes) == ("Lift::main", {}, ())
    assert data.name == "Lift"
    assert data.variables == {"at": "0", "target": "0", "other": "1"}
    assert data.changes == ({"target": "2"}, {"at": "1"})


def test_of_states_that_can_do_the_same_only_what_they_share_is_told() -> None:
    """Which of two such states it is nobody can tell, so what differs in them is not said."""
    text = """
class C
  chan both : []
  main = both -> main
  state x, y : 0..1
  init x = 0 and y = 0
  op both
    Delta(x, y)
  where
    x' = 0
    y' = 0 or y' = 1
end
assert STOP [T= C
"""
    loaded = load(Source("c.csp", text))
    found = Checker(loaded).check(loaded.assertions[0].node).counterexample

    assert found is not None
    (data,) = [part for part in found.components if part.name == "C"]
    assert data.variables == {"x": "0"}


TANK = """
class Tank
  chan fill, drain
  state level : 0..3
  init level = 0
  op fill
    Delta(level)
  where
    level' = level + 1
  op drain
    Delta(level)
  where
    level' = level - 1
end
class Full
  chan fill
  main = fill -> main
  state rest : 0..1
  init rest = 1
  op fill
    Delta(rest)
  where
    rest' = rest - 1
end
"""


def data_of(assertion: str) -> dict[str, tuple[dict[str, str], tuple[dict[str, str], ...]]]:
    loaded = load(Source("tank.csp", f"{TANK}\nassert {assertion}\n"))
    found = Checker(loaded).check(loaded.assertions[0].node).counterexample
    assert found is not None
    return {
        part.name: (dict(part.variables), tuple(dict(new) for new in part.changes))
        for part in found.components
        if part.variables
    }


def test_a_class_that_is_its_data_alone_shows_them() -> None:
    found = data_of("drain -> STOP [] fill -> (drain -> STOP [] fill -> fill -> STOP) [T= Tank")
    assert found == {"Tank": ({"level": "0"}, ({"level": "1"}, {"level": "2"}))}


def test_data_are_shown_of_each_component_of_a_composition() -> None:
    found = data_of("(Tank [| {drain} |] STOP) [| {fill} |] Full :[deadlock free]")
    assert found == {"Tank": ({"level": "0"}, ({"level": "1"},)), "Full": ({"rest": "1"}, ({"rest": "0"},))}
