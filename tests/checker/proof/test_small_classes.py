"""Obligations against going through all values, and proved refinements against the search, on random small classes."""

from __future__ import annotations

from collections import defaultdict

from hypothesis import assume, event, given, settings, strategies as st

from cspcheck.checker.check import Checker
from cspcheck.checker.proof.obligations import discharge
from cspcheck.checker.proof.prover import Prover
from cspcheck.checker.proof.simulation import refinement, retrieve
from cspcheck.checker.verdict import Verdict
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from tests.checker.proof.classes import specification
from tests.checker.proof.small_classes import WIDE, Enumerated, Small, predicates, small_classes, variants
from tests.examples import examples


def expected(small: Enumerated) -> dict[tuple[str, str], bool]:
    """Which obligations hold, by name and operation."""
    holds: dict[tuple[str, str], bool] = {
        ("state inhabited", ""): bool(small.states),
        ("initialisation", ""): bool(small.initial),
    }
    for name, operation in small.model.operations.items():
        steps = small.steps(operation)
        output = operation.parameters[0].kind == "output"
        holds["feasible", name] = bool(steps)
        raw = list(small.raw(operation, range(3)))
        outcomes: dict[object, list[bool]] = defaultdict(list)
        for before, parameter, state in raw:
            outcomes[before if output else (before, parameter)].append(small.invariant(state))
        holds["invariant preserved", name] = all(map(any, outcomes.values()))
        after: dict[object, set[object]] = defaultdict(set)
        for before, parameter, state in steps:
            key = before if output else (before, parameter)
            after[key].add((parameter, state) if output else state)
        holds["deterministic operation", name] = all(len(states) <= 1 for states in after.values())
        if not output and steps:
            holds["inputs usable", name] = {parameter for _, parameter, _ in steps} == {0, 1}
        if operation.form in ("guarded", "effect"):
            enabled = [
                (s, i) for s in small.states for i in ((0,) if output else (0, 1)) if small.guard(operation, s, i)
            ]
            possible = {(s, 0 if output else i) for s, i, _ in steps}
            holds["guard covers effect", name] = all(pair in possible for pair in enabled)
        if steps:
            for position, variable in enumerate(("n", "b")):
                if variable in operation.delta:
                    changes = any(b[position] != a[position] for b, _, a in steps)
                    holds["delta changes", f"{name} `{variable}`"] = changes
        holds["carrier kept", name] = kept(small, name)
    return holds


def kept(small: Enumerated, name: str) -> bool:
    """Whether no raw step needs a value outside a carrier, everything else being equal."""
    operation = small.model.operations[name]
    output = operation.parameters[0].kind == "output"
    raw = set(small.raw(operation, WIDE))
    for before, parameter, after in raw:
        if not any((before, parameter, (n, after[1])) in raw for n in range(3)):
            return False
        if output and not any((before, o, after) in raw for o in range(2)):
            return False
    return True


def _spoken(small: Enumerated, name: str) -> bool:
    """Whether the effect speaks of a value that has a carrier."""
    from cspcheck.checker.proof.terms import variables_of

    operation = small.model.operations[name]
    spoken = variables_of(operation.effect)
    return ("n", "after") in spoken or any(
        p.kind == "output" and (p.name, "output") in spoken for p in operation.parameters
    )


@settings(max_examples=examples(20))
@given(small_classes())
def test_obligations_are_what_going_through_all_values_says(drawn: Small) -> None:
    spec = specification(drawn.text())
    model = spec.classes["A"]
    found: dict[tuple[str, str], bool] = {}
    for finding in discharge(Prover(spec, model)):
        assert finding.status in ("proved", "refuted"), finding
        place = finding.place if finding.obligation == "delta changes" else finding.operation or ""
        key = (finding.obligation, place)
        found[key] = found.get(key, True) and finding.status == "proved"

    for key, holds in expected(Enumerated(spec, model)).items():
        event(f"{key[0]}: {holds}")
        assert found.get(key, True) == holds, (key, drawn.text())


RELATIONS = ("A.n = C.n\n  A.b = C.b", "A.n = C.n", "A.b = C.b", "A.n <= C.n")


@settings(max_examples=examples(20))
@given(st.data(), small_classes(), st.booleans())
def test_a_proved_simulation_is_a_refinement(data: st.DataObject, abstract: Small, upward: bool) -> None:
    """What the rules prove is never contradicted by the search for failures and divergences."""
    concrete = data.draw(variants(abstract, "C"))
    relation = data.draw(st.sampled_from(RELATIONS) | predicates(("A.n", "C.n"), ("A.b", "C.b")))
    text = f"{abstract.text()}{concrete.text()}retrieve R between A and C where\n  {relation}\nend\nassert A [FD= C\n"
    spec = specification(text)
    proved = all(
        finding.status == "proved" or finding.severity != "error"
        for finding in refinement(spec, retrieve(spec.retrieves["R"]), upward=upward)
    )
    event(f"proved: {proved}, upward: {upward}")
    assume(proved)
    try:
        script = load(Source("test.csp", text))
        outcome = Checker(script, workers=1).check(script.assertions[0].node)
    except ScriptError as error:  # a class without an initial state
        event(error.diagnostics[0].code)
        return
    event(f"search: {outcome.verdict}")

    assert outcome.verdict is Verdict.PASS, text
