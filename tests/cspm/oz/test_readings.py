"""A verdict under finite readings is never wrong: it is that of the class without them, or there is none."""

from __future__ import annotations

from hypothesis import event, given, settings, strategies as st

from cspcheck.checker.check import Checker
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from tests.examples import examples

CONJUNCTS = [
    "n' = n + 1",
    "n' = n - 1",
    "n' = n + m",
    "n' = m and m' = n",
    "n' > n",
    "n' < n",
    "n' = 2 * m",
    "m' = m + 1",
    "m' = 0",
    "m' /= m",
    "m' <= n",
    "n < 3",
    "n > 0",
    "m = 1 or n = 2",
    "n' + m' = n + m",
    "n > 1 => n' = 0",
    "if m = 0 then n' = 3 else n' = m - 1",
    "exists k : nat | k < n @ m' = k + 1",
]
OUTPUTS = ["v! = n", "v! = n + m", "v! <= n", "v! > n and v! <= 4", "v! + m = 4"]


@st.composite
def bodies(draw: st.DrawFn) -> str:
    """The inside of a class over two naturals that its invariant bounds."""
    lines = [
        "  state n, m : nat where n <= 4 and m <= 4",
        f"  init {draw(st.sampled_from(['n = 0 and m = 1', 'n + m = 1']))}",
    ]
    for name in "ab":
        delta = draw(st.sampled_from(["n", "m", "n, m"]))
        effect = " and ".join(draw(st.lists(st.sampled_from(CONJUNCTS), min_size=1, max_size=2, unique=True)))
        changed = {variable.strip() for variable in delta.split(",")}
        if ("n'" in effect and "n" not in changed) or ("m'" in effect and "m" not in changed):
            delta = "n, m"
        lines.append(f"  op com_{name} Delta({delta}) where {effect}")
    lines.append(f"  op com_get v! : nat where {draw(st.sampled_from(OUTPUTS))}")
    return "\n".join(lines)


CLAIMS = [
    "A :[deadlock free]",
    "A :[divergence free]",
    "A \\ {| b |} :[divergence free]",
    "A :[deterministic]",
    "A [T= B",
    "A [F= B",
    "A [FD= B",
    "A [| {| a, b |} |] B :[deadlock free [F]]",
    "A :[has trace]: <a, b, a>",
    "A :[has trace [FD]]: <a, a>",
    "A [| {| a |} |] (a -> STOP) :[deadlock free]",
]


@settings(max_examples=examples(15))
@given(bodies(), bodies())
def test_a_verdict_under_a_reading_is_that_without_it(first: str, second: str) -> None:
    classes = "".join(
        f"class {name}\n  chan a, b\n  chan get : [v! : nat]\n{body}\nend\n"
        for name, body in (("A", first), ("B", second))
    )
    # The whole of it: no event or state is above eight.
    whole = load(Source("whole.csp", "reading nat = 0..8\n" + classes))
    small = load(Source("small.csp", "reading nat = 0..2\n" + classes))
    right, cut = Checker(whole), Checker(small)
    for claim in CLAIMS:
        expected = right.check(whole.assertion(claim).node)
        found = cut.check(small.assertion(claim).node)
        assert expected.verdict in ("pass", "fail"), (claim, expected.reason, classes)
        event(f"decided: {found.verdict != 'unknown'}")
        assert found.verdict in (expected.verdict, "unknown"), (claim, classes)
