"""What is claimed of every size of a type, held against checks at several sizes."""

from __future__ import annotations

import re
from collections import Counter

from hypothesis import given, settings, strategies as st

from cspcheck.checker.check import Checker
from cspcheck.checker.verdict import EverySize, Limits, Outcome, Verdict
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax.tree import Assertion
from tests.examples import examples

MOST = 6
"""The largest size that is tried."""


def checked(text: str, size: int) -> list[Outcome]:
    """The answers to the assertions of a script whose type ``T`` has a size."""
    values = " | ".join(f"t{number}" for number in range(size))
    given_set = "reading T = SIZE" in text
    whole = text.replace("SIZE", str(size)) if given_set else f"datatype T = {values}\n{text}"
    script = load(Source("sizes.csp", whole))
    checker = Checker(script, workers=1, limits=Limits(states=3_000))
    return [answered(checker, assertion.node) for assertion in script.assertions]


def answered(checker: Checker, assertion: Assertion) -> Outcome:
    """The answer to an assertion, unknown where a value is undefined."""
    try:
        return checker.check(assertion)
    except ScriptError as error:
        return Outcome(Verdict.UNKNOWN, str(error), 0, 0, 0, 0)


def claimed(text: str, size: int) -> list[EverySize | None]:
    """What is said of the sizes of ``T``, by assertion."""
    return [next(iter(outcome.every_size), None) for outcome in checked(text, size)]


def held(text: str, seen: Counter[str], most: int = MOST) -> None:
    """Hold what is claimed at each size against the verdicts at the others, a script whose type ``T`` is open."""
    by_size = {size: checked(text, size) for size in range(1, most + 1)}
    for index in range(len(by_size[1])):
        for size, outcomes in by_size.items():
            claim = next(iter(outcomes[index].every_size), None)
            if claim is None:
                continue
            assert claim.size == size
            if not claim.tells:
                continue
            seen[f"{outcomes[index].verdict}, {'tested' if claim.tests else 'passed on'}"] += 1
            for other in range(claim.least, most + 1):
                verdict = by_size[other][index].verdict
                assert verdict in (outcomes[index].verdict, Verdict.UNKNOWN), (text, index, claim, other)


# --- random processes -----------------------------------------------------------------------------------------------

CHANNELS = ("a", "b", "c")


@st.composite
def bodies(
    draw: st.DrawFn, scope: tuple[str, ...], arities: dict[str, int], depth: int, tests: bool, wide: bool
) -> str:
    """A process with some variables of type T in scope."""
    value = st.sampled_from(scope) if scope else None
    kinds = ["input", "input", "signal", "choice", "stop", "call", "call", "nondeterministic"]
    kinds += ["two"] if wide else []
    if value is not None:
        kinds += ["output"] * 4
        kinds += ["if", "if", "guard"] if tests else []
    kinds += ["any"]
    kind = draw(st.sampled_from(kinds)) if depth else draw(st.sampled_from(["stop", "call", "call"]))
    if kind == "call":
        name = draw(st.sampled_from(sorted(n for n in arities if arities[n] == 0 or scope)))
        arguments = [draw(st.sampled_from(scope)) for _ in range(arities[name])]
        return f"d -> {name}({', '.join(arguments)})" if arguments else f"d -> {name}"
    if kind == "stop":
        return "STOP"
    inner = lambda more=(): draw(bodies((*scope, *more), arities, depth - 1, tests, wide))  # noqa: E731
    channel = draw(st.sampled_from(CHANNELS))
    fresh = f"v{len(scope)}"
    match kind:
        case "input":
            return f"{channel}?{fresh} -> {inner((fresh,))}"
        case "output":
            assert value is not None
            return f"{channel}!{draw(value)} -> {inner()}"
        case "signal":
            return f"d -> {inner()}"
        case "two":
            first = draw(st.sampled_from(scope)) if scope else None
            return f"e?{fresh}" + (f"!{first}" if first else f"?{fresh}x") + f" -> {inner((fresh,))}"
        case "choice":
            return f"({inner()} [] {inner()})"
        case "nondeterministic":
            return f"({inner()} |~| {inner()})"
        case "any":
            operator = draw(st.sampled_from(["|~|", "[]"]))
            return f"({operator} {fresh} : T @ {channel}!{fresh} -> {inner((fresh,))})"
        case "if":
            left, right = draw(st.sampled_from(scope)), draw(st.sampled_from(scope))
            operator = draw(st.sampled_from(["==", "!="]))
            return f"(if {left} {operator} {right} then {inner()} else {inner()})"
    left, right = draw(st.sampled_from(scope)), draw(st.sampled_from(scope))
    return f"({left} == {right} & {inner()})"


@st.composite
def scripts(draw: st.DrawFn) -> str:
    """A script with two composed processes and assertions about them."""
    tests, wide = draw(st.booleans()), draw(st.sampled_from([False, False, False, True]))
    arities = {"P": 0, "Q": 1, "R": 2}
    lines = ["channel a, b, c : T", "channel d", *["channel e : T.T"] * wide]
    for name, arity in arities.items():
        parameters = tuple([f"p{i}" for i in range(arity)])
        head = f"{name}({', '.join(parameters)})" if parameters else name
        lines.append(f"{head} = {draw(bodies(parameters, arities, 3, tests, wide))}")
    lines.append(f"S = {draw(bodies((), {'S': 0}, 3, tests, wide))}")
    first, second = (draw(st.sampled_from(["P", "S", "P [[ a <- b ]]", "P [[ a <- b, b <- c ]]"])) for _ in range(2))
    shared = ", ".join(sorted(draw(st.sets(st.sampled_from(["a", "b", "c", "d", *["e"] * wide]), max_size=3))))
    hidden = ", ".join(sorted(draw(st.sets(st.sampled_from(["a", "b", "c", "d"]), max_size=2))))
    whole = draw(st.sampled_from([f"({first}) [| {{| {shared} |}} |] ({second})", "P", "P", f"({first}) ||| S"]))
    lines.append(f"W = ({whole}) \\ {{| {hidden} |}}")
    lines += [f"assert S [{model}= W" for model in ("T", "F", "FD")]
    lines += [f"assert W :[{kind}]" for kind in ("deadlock free", "divergence free", "deterministic")]
    lines += ["assert P [F= W", "assert S :[deterministic]"]
    return "\n".join(lines)


SEEN: Counter[str] = Counter()


@settings(max_examples=examples(16), deadline=None)
@given(scripts())
def test_what_is_claimed_of_other_sizes_is_so(text: str) -> None:
    held(text, SEEN)


# --- random classes -------------------------------------------------------------------------------------------------

STATE = {"a": "T", "b": "T", "s": "seq T", "k": "power T"}
VALUES = [
    *(("T", "a"), ("T", "b"), ("T", "head s"), ("T", "last s"), ("T", "x?")),
    *(("seq T", "<>"), ("seq T", "s"), ("seq T", "tail s"), ("seq T", "<a, b>"), ("seq T", "s ^ <x?>")),
    *(("power T", "k"), ("power T", "{a}"), ("power T", "k union {x?}"), ("power T", "k \\ {b}")),
]
"""What a variable of a type may become."""
LENGTHS = ["s /= <>", "#s < 2", "#s > 0"]
TESTS = ["a = b", "a /= b", "a in k", "b notin k", "#k < 2", "head s = a", "a in ran s", "x? = a", "x? notin k"]
"""What a guard may say, without and with a comparison."""


def usable(text: str, known: list[str]) -> bool:
    """Whether a text speaks of known variables only."""
    return set(re.findall(r"\b[abskx]\b", text)) <= set(known)


@st.composite
def operations(draw: st.DrawFn, state: list[str], tests: bool) -> tuple[str, str]:
    """The parameters of an operation, and the rest: of some variables it says what they become, not of others."""
    asked, told = draw(st.booleans()), draw(st.booleans())
    known = [*state, *["x"] * asked]
    changed = draw(st.lists(st.sampled_from(state), unique=True))
    lines = []
    for variable, kind in [*[(f"{v}'", STATE[v]) for v in changed], *[("y!", "T")] * told]:
        values = [value for type_, value in VALUES if type_ == kind and usable(value, known)]
        if values and draw(st.integers(0, 5)):
            lines.append(f"{variable} = {draw(st.sampled_from(values))}")
    guards = [guard for guard in [*LENGTHS, *TESTS * tests] if usable(guard, known)]
    if guards and draw(st.booleans()):
        lines.append(draw(st.sampled_from(guards)))
    if len(lines) > 1 and draw(st.integers(0, 3)) == 0:
        lines = [f"{lines[0]} or {lines[1]}", *lines[2:]]
    lines += ["#s' <= 2"] * ("s" in changed)
    parameters = "; ".join(["x? : T"] * asked + ["y! : T"] * told)
    where = " and ".join(f"({line})" for line in lines) or "true"
    return parameters, f"Delta({', '.join(changed)}) {parameters} where {where}"


@st.composite
def class_scripts(draw: st.DrawFn) -> str:
    """A script with two classes and assertions about them."""
    lines = ["given T", "reading T = SIZE", "reading seq T = 2"]
    for name in ("A", "C"):
        tests = draw(st.booleans())
        state = sorted(draw(st.sets(st.sampled_from(["a", "b", "s", *["k"] * tests]), min_size=1)))
        found = {}
        for event in ("p", "q"):
            parameters, rest = draw(operations(state, tests))
            shared = parameters.count(":") == 1
            found[event if shared else f"{event}{name}"] = parameters, rest
        lines.append(f"class {name}")
        lines += [f"  chan {event} : [{p}]" if p else f"  chan {event}" for event, (p, _) in found.items()]
        lines.append("  state " + "; ".join(f"{v} : {STATE[v]}" for v in state))
        initial = [f"{v} = {'<>' if v == 's' else '{}'}" for v in state if v in "sk"]
        initial += ["a = b"] if {"a", "b"} <= set(state) and draw(st.booleans()) else []
        lines.append("  init " + (" and ".join(initial) or "true"))
        lines += [f"  op com_{event} {rest}" for event, (_, rest) in found.items()]
        lines.append("end")
    lines += [
        "assert A [F= C",
        "assert C :[deadlock free]",
        "assert C :[deterministic]",
        "assert A || C :[deadlock free]",
    ]
    return "\n".join(lines)


@settings(max_examples=examples(10), deadline=None)
@given(class_scripts())
def test_what_is_claimed_of_classes_is_so(text: str) -> None:
    held(text, SEEN, 4)
