"""What never happens in a check that passes is told, and nothing that does happen is."""

from collections.abc import Iterator

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck import checking
from cspcheck.checker.checks.coverage import happened
from cspcheck.checker.network.compiler import compile_network
from cspcheck.checker.packing.packed import pack
from cspcheck.checker.search.exploration import explore as explore_packed
from cspcheck.checker.semantics.transitions import LimitReached, Semantics, explore
from cspcheck.coverage import Coverage
from cspcheck.cspm import script as scripts
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.process.events import TAU, TICK
from cspcheck.cspm.process.terms import Prefix, Process
from cspcheck.cspm.source import Source
from tests.examples import examples

SYSTEM = """\
channel a, b, crash, reset
channel c : {0..2}
P(n) = n < 2 & a -> P(n + 1) [] n == 2 & b -> P(0)
    [] crash -> reset -> P(0)
    [] c?x -> (if x > 2 then b -> STOP else P(n))
Q = a -> Q [] b -> Q [] c.0 -> Q
SYSTEM = P(0) [| {| a, b, c, crash, reset |} |] Q
assert SYSTEM :[deadlock free]
SPEC = a -> SPEC [] b -> SPEC [] c?x -> SPEC [] reset -> SPEC
assert SPEC [T= SYSTEM
"""


def of(text: str, number: int = 0) -> Coverage:
    script = scripts.load(Source("x.csp", text), recording=True)
    checker = checking.checker_for(script, checking.Settings(), checking.NoWatch())
    assertion = script.assertions[number]
    assert checking.check(checker, assertion)
    found = checker.coverage(assertion)
    assert found is not None
    return found


def told(text: str, number: int = 0) -> list[tuple[str, str, int]]:
    return [(never.kind, never.text, never.line) for never in of(text, number).never]


def test_what_is_offered_in_vain_and_what_is_never_reached() -> None:
    found = of(SYSTEM)
    assert (found.prefixes, found.performed) == (9, 6)
    assert [(n.kind, n.text, n.why, n.line) for n in found.never] == [
        ("prefix", "crash -> …", "is offered, and never taken up", 4),
        ("branch", "b -> STOP", "is never taken", 5),
        ("event", "crash, reset, c.1, c.2", "some component could perform it, and the others never let it", 0),
    ]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        pytest.param("channel a\nP = true & a -> P\nassert P :[deadlock free]\n", [("guard", "true", 2)], id="guard"),
        pytest.param(
            "channel a, b\nP = false & a -> P [] b -> P\nassert P :[deadlock free]\n",
            [("branch", "false & a -> P", 2)],
            id="guard never true",
        ),
        pytest.param(
            "channel a, b\nL = a -> L\nR = b -> R\nassert L ; R :[deadlock free]\n",
            [("definition", "R", 4)],
            id="after ;",
        ),
        pytest.param(
            "channel a, b\nP(0) = a -> P(0)\nP(1) = b -> P(0)\nassert P(0) :[deadlock free]\n",
            [("branch", "b -> P(0)", 3)],
            id="clause",
        ),
        pytest.param(
            "channel a, b\nP = a -> P\nQ = b -> Q\nassert P [| {b} |] (Q [| {b} |] STOP) :[deadlock free]\n",
            [("prefix", "b -> …", 3), ("component", "Q", 3), ("component", "part 1", 0), ("event", "b", 0)],
            id="component",
        ),
        pytest.param(
            "channel a, b\nP = a -> P [] b -> P\nassert P [[a <- b]] \\ {b} ||| RUN({a}) :[deadlock free [F]]\n",
            [],
            id="renamed and hidden",
        ),
        pytest.param(
            "channel tock, a, b\nTimed { P = a -> P [] b -> STOP\n Q = a -> Q }\n"
            "assert P [| {a, b, tock} |] Q :[deadlock free]\n",
            [("prefix", "b -> …", 2), ("event", "b", 0)],
            id="timed",
        ),
    ],
)
def test_kinds(text: str, expected: list[tuple[str, str, int]]) -> None:
    assert told(text) == expected


def test_what_a_specification_allows_and_never_happens() -> None:
    found = of("channel a, b\nP = a -> P\nassert RUN({a, b}) [T= P\n")
    assert [(n.kind, n.text, n.why) for n in found.never] == [
        ("event", "b", "the specification allows it, and it never happens")
    ]


def test_a_verdict_that_is_no_pass_has_none() -> None:
    script = scripts.load(Source("x.csp", "channel a\nassert a -> STOP :[deadlock free]\n"), recording=True)
    checker = checking.checker_for(script, checking.Settings(), checking.NoWatch())
    result = checking.check(checker, script.assertions[0])
    assert checking.covered(checker, script.assertions[0], result).coverage is None


EVENTS = ("a", "b", "c")
atoms = st.sampled_from(["STOP", "SKIP", "P", "Q"])
processes = st.recursive(
    atoms,
    lambda inner: st.one_of(
        st.tuples(st.sampled_from(EVENTS), inner).map(lambda t: f"{t[0]} -> ({t[1]})"),
        st.tuples(inner, st.sampled_from(["[]", "|~|", ";", "[> ", "/\\"]), inner).map(
            lambda t: f"({t[0]}) {t[1]} ({t[2]})"
        ),
        inner.map(lambda p: f"({p}) [[a <- b]]"),
        inner.map(lambda p: f"({p}) \\ {{c}}"),
    ),
    max_leaves=5,
)


@settings(max_examples=examples(15), deadline=None)
@given(processes, processes, processes, st.sets(st.sampled_from(EVENTS)))
def test_what_a_machine_cannot_do_without_is_performed(p: str, q: str, r: str, shared: set[str]) -> None:
    events = "{" + ", ".join(sorted(shared)) + "}"
    text = f"channel a, b, c\nP = a -> ({p})\nQ = b -> ({q})\nS = (P [| {events} |] Q) [| {events} |] (c -> ({r}))\n"
    script = scripts.load(Source("x.csp", text))
    term = script.process("S")
    try:
        machine, terms = explore(term, checking.limits(states=100))
    except (LimitReached, ScriptError):  # an endless one, or one that calls itself before any event
        return
    found = happened(explore_packed(pack(compile_network(term))))
    assert found.visible == set(machine.alphabet()) - {TAU, TICK}
    # A prefix is performed exactly if the machine loses a transition when the prefix alone is taken away.
    everywhere = {leaf for state in terms for leaf in leaves(state)}
    for leaf, event in found.performed | found.offered:
        assert leaf in everywhere
        lost = any(
            set(semantics_without(leaf, event).transitions(state)) != set(Semantics().transitions(state))
            for state in terms
        )
        if lost:
            assert (leaf, event) in found.performed


def leaves(state: Process) -> Iterator[Process]:
    if isinstance(state, Prefix):
        yield state
    for operand in state.active():
        yield from leaves(operand)


def semantics_without(leaf: Process, event: int) -> Semantics:
    semantics = Semantics()
    semantics._known[leaf] = tuple(step for step in Semantics().transitions(leaf) if step[0] != event)
    return semantics
