"""Every process that the language has built in, held against the equation that defines it.

The two are strongly bisimilar, tau for tau: then no model tells them apart, and no priority, in whatever surroundings.
That the engine thinks so too, in all models and under the priority functions, is asked beside it, as a user would.
"""

from __future__ import annotations

import re
from itertools import product

import pytest

from cspcheck.checker.check import Checker
from cspcheck.checker.network.compiler import Compiler
from cspcheck.checker.semantics.transitions import explore
from cspcheck.checker.verdict import Limits, Verdict
from cspcheck.cspm.script import Script, load
from cspcheck.cspm.source import Source
from tests.checker.exploring import interpreted, rows_of, strongly_bisimilar

EQUATIONS = {
    "run": ("RUN({a, b})", "E_run = a -> E_run [] b -> E_run"),
    "run_of_nothing": ("RUN({})", "E_run_of_nothing = STOP"),
    "chaos": ("CHAOS({a, b})", "E_chaos = STOP |~| ([] x : {a, b} @ x -> E_chaos)"),
    "chaos_of_nothing": ("CHAOS({})", "E_chaos_of_nothing = STOP |~| STOP"),
    "chaos_of_time": (
        "CHAOS({tock, a})",
        "E_chaos_of_time = STOP |~| (tock -> E_chaos_of_time [] a -> E_chaos_of_time)",
    ),
    "div": ("DIV", "Spin = a -> Spin\nE_div = Spin \\ {a}"),
    "choice_of_div": ("DIV", "E_choice_of_div = E_choice_of_div |~| E_choice_of_div"),
    "loop": ("loop(a -> SKIP [] b -> SKIP)", "E_loop = (a -> SKIP [] b -> SKIP) ; E_loop"),
    "buffer": (
        "BUFFER(2, {(in.v, out.v) | v <- {0, 1}})",
        """E_buffer = Fifo(<>)
Fifo(s) = #s < 2 & in?v -> Fifo(s ^ <v>) [] not null(s) & out!head(s) -> Fifo(tail(s))""",
    ),
    "weak_buffer": (
        "WEAK_BUFFER(2, b, {(in.v, out.v) | v <- {0, 1}})",
        """E_weak_buffer = Weak(<>)
Weak(s) = in?v -> (if #s < 2 then Weak(s ^ <v>) else b -> STOP) [] not null(s) & out!head(s) -> Weak(tail(s))""",
    ),
    "signal_buffer": (
        "SIGNAL_BUFFER(2, a, b, {(in.v, out.v) | v <- {0, 1}})",
        """E_signal_buffer = Signal(<>)
Signal(s) = #s < 2 & in?v -> Signal(s ^ <v>) [] not null(s) & out!head(s) -> Signal(tail(s))
  [] #s == 2 & a -> Signal(s) [] null(s) & b -> Signal(s)""",
    ),
    "trace_watchdog": (
        "trace_watchdog(a -> b -> STOP, {a, b}, bark)",
        """E_trace_watchdog = a -> (b -> Barks [] a -> bark -> STOP) [] b -> bark -> STOP
Barks = a -> bark -> STOP [] b -> bark -> STOP""",
    ),
    "failure_watchdog": (
        "failure_watchdog(a -> STOP, {a, b}, bark)",
        """E_failure_watchdog = (a -> Sated [] b -> bark -> STOP) [> a -> Sated
Sated = (a -> bark -> STOP [] b -> bark -> STOP) [> Sated""",
    ),
    "timed_stop": ("T_stop", "E_timed_stop = tock -> E_timed_stop"),
    "timed_skip": ("T_skip", "E_timed_skip = tock -> E_timed_skip [] SKIP"),
    "wait": ("T_wait(2)", "E_wait = tock -> tock -> E_timed_skip"),
    "wait_for_nothing": ("T_wait(0)", "E_wait_for_nothing = E_timed_skip"),
    "timed_prefix": ("T_prefix", "E_timed_prefix = tock -> E_timed_prefix [] a -> tock -> E_timed_stop"),
    "instant_prefix": ("I_prefix", "E_instant_prefix = tock -> E_instant_prefix [] a -> E_timed_skip"),
    "timed_guard": ("T_guard", "E_timed_guard = E_timed_stop"),
    "timed_choice": ("T_choice", "E_timed_choice = E_timed_prefix [+ {tock} +] E_other"),
    "timed_interleaving": ("T_interleaving", "E_timed_interleaving = E_timed_prefix [| {tock} |] E_other"),
    "timed_interrupt": ("T_interrupt", "E_timed_interrupt = E_timed_prefix /+ {tock} +\\ E_other"),
    "timed_parallel": ("T_parallel", "E_timed_parallel = E_timed_prefix [| {a, tock} |] E_timed_prefix"),
    "timed_alphabets": ("T_alphabets", "E_timed_alphabets = E_timed_prefix [{a, tock} || {b, tock}] E_other"),
    "timed_nothing": ("T_nothing", "E_timed_nothing = E_timed_stop"),
    "timed_empty_sequence": ("T_empty_sequence", "E_timed_empty_sequence = E_timed_skip"),
    "timed_priority": (
        "T_priority",
        "E_timed_priority = prioritise(E_wait [| {tock} |] E_chaos_of_time, <{}, {tock}>)",
    ),
}
"""For each name a process as the language has it, and what it is by definition, called ``E_name``."""

SETTING = r"""channel a, b, bark, tock
channel in, out : {0, 1}
external prioritise, prioritisepo, loop, trace_watchdog, failure_watchdog
Timed {
  T_stop = STOP
  T_skip = SKIP
  T_wait(n) = WAIT(n)
  T_prefix = a -> STOP
  T_other = b -> SKIP
  T_guard = false & a -> STOP
  T_choice = T_prefix [] T_other
  T_interleaving = T_prefix ||| T_other
  T_interrupt = T_prefix /\ T_other
  T_parallel = T_prefix [| {a} |] T_prefix
  T_alphabets = T_prefix [{a} || {b}] T_other
  T_nothing = ||| x : {} @ a -> SKIP
  T_empty_sequence = ; x : <> @ a -> SKIP
  T_priority = timed_priority(E_wait [| {} |] CHAOS({tock, a}))
}
instant(_) = 0
Timed(instant) {
  I_prefix = a -> SKIP
}
E_other = tock -> E_other [] b -> tock -> E_timed_skip
"""
CONTEXTS = {
    "alone": "{}",
    "by levels": "prioritise({}, <{{a}}, {{tock, b}}>)",
    "time last": "prioritise({}, <{{}}, {{tock, in.0}}>)",
    "by an order": "prioritisepo({}, {{a, b, tock}}, {{(b, a), (a, tock)}}, {{b}})",
    "hidden": "({}) \\ {{a}}",
    "in company": "({} [| {{a, tock}} |] (a -> tock -> STOP [] tock -> SKIP)) ; b -> STOP",
}
MODELS = ("T", "F", "FD", "V", "VD", "R", "RD")


@pytest.fixture(scope="module")
def script() -> Script:
    return load(Source("builtins.csp", SETTING + "\n".join(equation for _, equation in EQUATIONS.values())))


@pytest.mark.parametrize("name", EQUATIONS)
def test_it_takes_the_same_steps(script: Script, name: str) -> None:
    built_in, defined = (explore(script.process(text)) for text in (EQUATIONS[name][0], f"E_{name}"))

    assert strongly_bisimilar(rows_of(built_in.lts), rows_of(defined.lts))


@pytest.mark.parametrize("name", EQUATIONS)
@pytest.mark.parametrize("context", CONTEXTS.values(), ids=list(CONTEXTS))
def test_networks_take_the_same_steps(script: Script, name: str, context: str) -> None:
    """Whatever is around, and however little is listed as terms."""
    built_in = script.process(context.format(EQUATIONS[name][0]))
    defined = script.process(context.format(f"E_{name}"))

    network = Compiler(slot_states=2).network(built_in, Limits(states=1_000))
    assert strongly_bisimilar(interpreted(network), rows_of(explore(defined).lts))


@pytest.mark.parametrize("name", EQUATIONS)
def test_no_model_tells_them_apart(script: Script, name: str) -> None:
    checker = Checker(script, workers=1)
    other = list(CONTEXTS.values())[1 + list(EQUATIONS).index(name) % (len(CONTEXTS) - 1)]
    for context, model in product((CONTEXTS["alone"], other), MODELS):
        sides = [f"({context.format(text)})" for text in (EQUATIONS[name][0], f"E_{name}")]
        for left, right in (sides, reversed(sides)):
            claim = f"{left} [{model}= {right}"
            assert checker.check(script.assertion(claim).node).verdict is Verdict.PASS, claim


def test_every_process_that_is_built_in_has_an_equation() -> None:
    from cspcheck.cspm.typing.builtins import SIGNATURES

    processes = {name for name, kind in SIGNATURES.items() if kind.endswith("Proc") and "(Proc" not in kind}
    assert processes - {"STOP", "SKIP", "WAIT"} <= set(
        re.findall(r"\w+", " ".join(text for text, _ in EQUATIONS.values()))
    )
