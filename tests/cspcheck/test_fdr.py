"""The names of FDR4's Python API, as programs that were written for it use them."""

from __future__ import annotations

from pathlib import Path
from types import FunctionType

import pytest

from cspcheck import fdr

SCRIPT = """
channel a, b
N = 3
A = a -> STOP
B = b -> STOP
P = a -> b -> P
Q = a -> SKIP
print N + 1
assert P :[deadlock free]
assert P [T= a -> a -> STOP
assert Q :[deadlock free]
"""


@pytest.fixture
def session(tmp_path: Path) -> fdr.Session:
    (tmp_path / "s.csp").write_text(SCRIPT)
    fdr.library_init()
    opened = fdr.Session()
    opened.load_file(tmp_path / "s.csp")
    return opened


def test_the_loop_of_every_program(session: fdr.Session) -> None:
    answers = {}
    for assertion in session.assertions():
        assertion.execute(None)
        answers[str(assertion)] = (assertion.passed(), [each.found.kind for each in assertion.counterexamples()])
    fdr.library_exit()

    assert list(answers.values()) == [(True, []), (False, ["trace"]), (False, ["deadlock"])]
    assert next(iter(answers)).startswith("P :[deadlock free")
    assert session.assertions()[1].to_string() == "P [T= a -> a -> STOP"


def test_further_assertions_and_expressions(session: fdr.Session) -> None:
    assertion = session.parse_assertion("assert a -> STOP [T= P").result()
    assertion.execute(None)
    assert not assertion.passed()
    assert assertion.counterexamples()[0].found.event == "b"
    assert session.evaluate_expression("<N * 2>", None).result() == "<6>"
    assert session.print_statements() == ["4"]
    assert fdr.version()
    assert fdr.has_valid_license()


def described(session: fdr.Session, context: fdr.DebugContext, behaviour: fdr.Behaviour) -> list[str]:
    """A behaviour and those of its parts, a line each, as FDR4's example program walks about in them."""
    names = ["-" if event == fdr.INVALID_EVENT else str(session.uncompile_event(event)) for event in behaviour.trace()]
    last = behaviour.node_path()[-1]
    words = [type(behaviour).__name__, str(behaviour.machine()), *names]
    if isinstance(behaviour, fdr.TraceBehaviour) and behaviour.error_event() != fdr.INVALID_EVENT:
        words.append(f"then {session.uncompile_event(behaviour.error_event())}")
    elif isinstance(behaviour, fdr.MinAcceptanceBehaviour):
        words.append(f"offers {[str(session.uncompile_event(event)) for event in behaviour.min_acceptance()]}")
    elif isinstance(behaviour, fdr.LoopBehaviour):
        words.append(f"from {behaviour.loop_index()}")
    if last is not None:
        words.append(f"in {session.machine_node_name(behaviour.machine(), last)}")
    children = [line for child in context.behaviour_children(behaviour) for line in described(session, context, child)]
    return [" ".join(words), *children]


@pytest.mark.parametrize(
    ("assertion", "kind", "lines"),
    [
        (
            "A [T= A ||| B",
            fdr.TraceCounterexample,
            ["TraceBehaviour A in A", "TraceBehaviour A ||| B then b", "TraceBehaviour A", "TraceBehaviour B"],
        ),
        (
            "P [F= P |~| STOP",
            fdr.MinAcceptanceCounterexample,
            ["MinAcceptanceBehaviour P - offers [] in P", "MinAcceptanceBehaviour P |~| STOP τ offers []"],
        ),
        (
            "P \\ {a, b} :[divergence free]",
            fdr.DivergenceCounterexample,
            ["IrrelevantBehaviour CHAOS(Events)", "LoopBehaviour P \\ {a, b} τ τ from 0"],
        ),
        (
            "P [| {a, b} |] A :[deadlock free]",
            fdr.DeadlockCounterexample,
            [
                "MinAcceptanceBehaviour P [| {a, b} |] A a offers []",
                "TraceBehaviour P a",
                "TraceBehaviour A a",
            ],
        ),
        (
            "P |~| STOP :[deterministic [F]]",
            fdr.DeterminismCounterexample,
            ["MinAcceptanceBehaviour P |~| STOP τ offers []"],
        ),
    ],
)
def test_behaviours(session: fdr.Session, assertion: str, kind: type[fdr.Counterexample], lines: list[str]) -> None:
    asked = session.parse_assertion(assertion).result()
    asked.execute(None)
    (counterexample,) = asked.counterexamples()
    assert type(counterexample) is kind
    context = fdr.DebugContext(counterexample, False)
    context.initialise(None)
    told = [line for behaviour in context.root_behaviours() for line in described(session, context, behaviour)]
    assert told == lines


def test_events_of_a_counterexample(session: fdr.Session) -> None:
    asked = session.assertions()[1]
    asked.execute(None)
    (counterexample,) = asked.counterexamples()
    assert isinstance(counterexample, fdr.TraceCounterexample)
    events = [*counterexample.implementation_behaviour().trace(), counterexample.error_event()]
    assert [session.uncompile_event(event).to_string() for event in events] == ["a", "a"]


def test_a_machine_is_walked_through(session: fdr.Session) -> None:
    machine = session.evaluate_process("(a -> Q) \\ {b}", fdr.SemanticModel_Traces, None).result()
    assert [str(session.uncompile_event(event)) for event in machine.alphabet(False)] == ["✓", "a"]
    seen, waiting, steps = set[int](), [machine.root_node()], []
    while waiting:
        node = waiting.pop()
        if node.hash_code() in seen:
            continue
        seen.add(node.hash_code())
        for step in machine.transitions(node):
            steps.append(str(session.uncompile_event(step.event())))
            waiting.append(step.destination())
    assert (len(seen), steps) == (4, ["a", "a", "✓"])


def test_what_is_wrong(session: fdr.Session, tmp_path: Path) -> None:
    with pytest.raises(fdr.Error, match="no file is loaded"):
        fdr.Session().assertions()
    with pytest.raises(fdr.FileLoadError, match="no such file"):
        session.load_file(tmp_path / "none.csp")
    (tmp_path / "bad.csp").write_text("P = nobody -> P\n")
    with pytest.raises(fdr.FileLoadError, match="nobody"):
        fdr.Session().load_file(tmp_path / "bad.csp")
    with pytest.raises(fdr.InputFileError, match="nobody"):
        session.parse_assertion("P [T= nobody").result().execute(None)
    with pytest.raises(fdr.InputFileError):
        session.evaluate_expression("1 +", None)
    with pytest.raises(fdr.Error, match="has not been executed"):
        session.assertions()[0].passed()


def test_events_and_steps_by_their_numbers(session: fdr.Session) -> None:
    number = session.compile_event("b")
    event = session.uncompile_event(number)
    assert isinstance(event, fdr.CompiledEvent)
    assert event.to_string() == str(event) == "b"
    assert session.compile_event("a") != number

    evaluated = session.evaluate_process("b -> STOP", fdr.SemanticModel_Traces, None)
    assert isinstance(evaluated, fdr.Evaluated)
    assert evaluated.warnings() == []
    machine = evaluated.result()
    (step,) = machine.transitions(machine.root_node())
    assert isinstance(step, fdr.Transition)
    assert step.event() == number
    assert machine.transitions(step.destination()) == []


def test_kinds_of_counterexamples(session: fdr.Session) -> None:
    """What programs tell them apart by."""
    refinement, deadlock = session.assertions()[1:]
    for assertion, kind in ((refinement, fdr.RefinementCounterexample), (deadlock, fdr.PropertyCounterexample)):
        assertion.execute(None)
        for counterexample in assertion.counterexamples():
            assert isinstance(counterexample, kind)
            behaviour = counterexample.implementation_behaviour()
            assert not isinstance(behaviour, (fdr.SegmentedBehaviour, fdr.ExplicitDivergenceBehaviour))
    assert issubclass(fdr.SegmentedBehaviour, fdr.Behaviour)


def test_the_page_names_all_names() -> None:
    page = (Path(__file__).parents[2] / "docs" / "coming-from-fdr.md").read_text(encoding="utf-8")
    public = [each for each in vars(fdr).values() if isinstance(each, (type, FunctionType))]
    public = [each for each in public if each.__module__ == fdr.__name__]
    names = {each.__name__ for each in public}
    for kind in public:
        if isinstance(kind, type):
            names |= {
                name for name in vars(kind) if callable(getattr(kind, name)) or isinstance(vars(kind)[name], property)
            }
    missing = {name for name in names if not name.startswith("_") and f"`{name}`" not in page}

    assert missing == set()
