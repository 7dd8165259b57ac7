"""Terms as text: what is written is read back as the same term, and long terms are folded."""

from __future__ import annotations

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.cspm.process.text import describe, describe_events
from cspcheck.cspm.script import load
from cspcheck.cspm.source import Source
from tests.examples import examples

SCRIPT = load(
    Source(
        "text.csp",
        """
channel a, b, c
channel d : {0..2}
P = a -> P
Q(n) = d!n -> Q((n + 1) % 3)
""",
    )
)

LEAVES = ["STOP", "SKIP", "DIV", "P", "Q(1)", "RUN({a, b})", "CHAOS({| d |})", "a -> STOP", "d?x:{1} -> P"]
SETS = ["{}", "{a}", "{a, b}", "{| d |}", "{d.0, c}"]
BINARY = ["[]", "|~|", "[>", "/\\", ";", "|||"]
SYNCHRONISED = [("[| {} |]", "[|"), ("[+ {} +]", "[+"), ("/+ {} +\\", "/+"), ("[| {} |>", "|>")]

processes = st.recursive(
    st.sampled_from(LEAVES),
    lambda inner: st.one_of(
        st.builds(lambda e, p: f"{e} -> ({p})", st.sampled_from(["a", "b", "d.1"]), inner),
        st.builds(lambda p, o, q: f"({p}) {o} ({q})", inner, st.sampled_from(BINARY), inner),
        st.builds(
            lambda p, o, s, q: f"({p}) {o[0].format(s)} ({q})",
            inner,
            st.sampled_from(SYNCHRONISED),
            st.sampled_from(SETS),
            inner,
        ),
        st.builds(lambda p, s, t, q: f"({p}) [ {s} || {t} ] ({q})", inner, *[st.sampled_from(SETS)] * 2, inner),
        st.builds(lambda p, q: f"({p}) [ a <-> b, d.0 <-> c ] ({q})", inner, inner),
        st.builds(lambda p, o, s: f"({p}) {o} {s}", inner, st.sampled_from(["\\", "|\\"]), st.sampled_from(SETS)),
        st.builds(lambda p: f"({p})[[a <- b, d.1 <- c]]", inner),
    ),
    max_leaves=6,
)


@settings(max_examples=examples(150), deadline=None)
@given(processes)
def test_a_described_term_is_read_back_as_the_same_term(text: str) -> None:
    term = SCRIPT.process(text)
    described = describe(term, SCRIPT.events, width=10_000)
    assert SCRIPT.process(described) is term


@given(processes, st.integers(10, 60))
@settings(max_examples=examples(50), deadline=None)
def test_a_long_term_is_folded(text: str, width: int) -> None:
    described = describe(SCRIPT.process(text), SCRIPT.events, width=width)
    assert len(described) <= width + 3


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a -> b -> P", "a -> b -> P"),
        ("a -> (b -> P [] c -> SKIP)", "a -> (b -> P [] c -> SKIP)"),
        ("(P [] Q(0)); SKIP", "(P [] Q(0)); SKIP"),
        ("a -> SKIP [| {a} |] (STOP [| {a} |] SKIP)", "(a -> SKIP [| {a} |] STOP) [| {a} |] SKIP"),
        ("SKIP ||| (STOP ||| SKIP)", "SKIP ||| STOP ||| SKIP"),
        ("P ||| (Q(1) [| {| d |} |] STOP)", "P ||| (Q(1) [| {| d |} |] STOP)"),
        ("(P |~| SKIP) \\ {a, d.1}", "P |~| SKIP \\ {a, d.1}"),
        ("d?x -> SKIP", "d.0 -> SKIP [] d.1 -> SKIP [] d.2 -> SKIP"),
    ],
)
def test_terms_look_as_people_write_them(text: str, expected: str) -> None:
    assert describe(SCRIPT.process(text), SCRIPT.events) == expected


def test_a_chain_of_ten_thousand_events_is_folded_at_once() -> None:
    term = SCRIPT.process(" -> ".join(["a"] * 10_000) + " -> STOP")
    assert describe(term, SCRIPT.events, width=20) == "a -> a -> a -> a ->..."


def test_sets_of_events() -> None:
    def shown(text: str) -> str:
        return describe_events(SCRIPT.event_set(text), SCRIPT.events)

    assert shown("{}") == "{}"
    assert shown("{c, a}") == "{a, c}"
    assert shown("{| d |}") == "{| d |}"
    assert shown("union({| d |}, {b})") == "{| d, b |}"
    assert shown("{d.0, d.2}") == "{d.0, d.2}"
