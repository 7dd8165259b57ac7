"""What is decided for all values against the search, on random small classes whose types are finite."""

from __future__ import annotations

from collections.abc import Sequence

from hypothesis import event, given, settings, strategies as st

from cspcheck.checker.check import Checker
from cspcheck.checker.proof.unbounded.answering import for_all_values
from cspcheck.checker.verdict import Verdict
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from tests.checker.proof.small_classes import Small, small_classes, variants
from tests.examples import examples

MAINS = (
    "take -> main [] give -> main",
    "take -> give -> main",
    "take -> main |~| give -> main",
    "take -> (give -> main [] take -> SKIP)",
    "(take -> SKIP ||| give -> SKIP) ; main",
    "give -> main",
    "",
)
ASSERTIONS = (
    "A :[deadlock free]",
    "A :[deadlock free [F]]",
    "A [T= B",
    "A [F= B",
    "A [FD= B",
    "A || C :[deadlock free]",
    "A [| {| take |} |] C :[deadlock free [F]]",
    "B [T= A || C",
)
C = """class C
  chan take : [i? : 0..1]
  chan give : [o? : 0..1]
  state k : 0..1
  init k = 0
  op take Delta(k) i? : 0..1 where k' = i?
  op give o? : 0..1 where o? = k
end
"""


@st.composite
def scripts(draw: st.DrawFn) -> str:
    """Two classes that are alike, and a third that restricts them."""
    one = draw(small_classes())
    other = draw(variants(one, "B"))
    return _with_main(draw, one) + _with_main(draw, other) + C


def _with_main(draw: st.DrawFn, small: Small) -> str:
    main = draw(st.sampled_from(MAINS))
    kind = draw(st.sampled_from(["chan", "chan", "chan", "method"]))
    text = small.text().replace("  main = take -> main [] give -> main\n", f"  main = {main}\n" if main else "")
    return text.replace("chan give", f"{kind} give")


@settings(max_examples=examples(3), deadline=None)
@given(scripts(), st.lists(st.sampled_from(ASSERTIONS), min_size=2, max_size=2, unique=True))
def test_what_is_decided_for_all_values_is_what_the_search_finds(text: str, assertions: list[str]) -> None:
    compare(text, assertions)


def compare(text: str, assertions: Sequence[str] = ASSERTIONS) -> None:
    """Hold the assertions that both decide against each other."""
    script = load(Source("test.csp", text))
    searched = Checker(load(Source("test.csp", text)))
    for assertion in assertions:
        proved = for_all_values(script.assertion(assertion).node, script)
        assert proved is not None
        event(f"{assertion}: {proved.verdict.value}")
        if proved.verdict is Verdict.UNKNOWN:
            continue
        try:
            found = searched.check(searched._script.assertion(assertion).node)
        except ScriptError:
            continue  # a predicate without a truth value ends a search
        assert found.verdict in (proved.verdict, Verdict.UNKNOWN), assertion
