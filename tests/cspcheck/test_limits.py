"""Limits hold wherever the work is: evaluating, printing, compressing, exploring a component, reading a script.

Each script here keeps some part of the program busy that has no search to look at the limit. What is held is not a
time (machines are busy at times) but that the work ends, says which limit and what went on, and that what comes after
it is answered as if nothing had happened.
"""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

import cspcheck
from cspcheck.checker.guard import Guard, afford, process_memory
from cspcheck.checker.kernels import jit
from cspcheck.checker.specification.normaliser import _at_least
from cspcheck.cspm.interruption import Stopped, during

FIBONACCI = "fib(n) = if n < 2 then n else fib(n - 1) + fib(n - 2)\n"

BUSY = {
    "an assertion that is evaluated": (FIBONACCI, "fib(60) == 3", "evaluating `fib(60)`"),
    "a process that is evaluated": (
        FIBONACCI + "channel a\nP = if fib(60) == 3 then STOP else a -> P",
        "P :[deadlock free]",
        "evaluating `fib(60)`",
    ),
    "a normal form": (
        """
        transparent normal
        channel a, b
        P = a -> P [] b -> P [] a -> Q(60)
        Q(n) = if n == 0 then STOP else (a -> Q(n - 1) [] b -> Q(n - 1))
        """,
        "normal(P) :[deadlock free]",
        "applying `normal` to a component of 62 states",
    ),
    "a chase": (
        """
        external chase
        channel a, b, c : {0..30}
        P(i) = a.i -> b.i -> c.i -> P(i)
        """,
        "chase((||| i : {0..30} @ P(i)) \\ {| b |}) :[deadlock free]",
        "building the machine of the process",
    ),
    "a wait": (
        """
        channel coin, tea, tock
        Timed(\\x @ 1) {
        M = coin -> WAIT(2147483647) ; tea -> M
        }
        """,
        "M :[deadlock free]",
        "",
    ),
    "a component without end": (
        "channel a\nP(n) = a -> P(n + 1)",
        "P(0) :[deadlock free]",
        "`P` is called with ever new arguments (`P(0)`, `P(1)`, `P(2)`, ...)",
    ),
    "a component that grows": (
        "channel a, b, c\nM = a -> M [] b -> M /\\ c -> M",
        "M :[deadlock free]",
        "it keeps growing, `/\\` is nested",
    ),
    "an unfolding of growing numbers": (
        "channel a\nP(n) = if n == 1 then a -> P(1) else P((8 * n - 1) / 2)",
        "P(45) :[deadlock free]",
        "evaluating `P(",
    ),
}


@pytest.fixture(scope="module")
def _compiled() -> None:
    """Kernels that are compiled for the first time are not what the time is to be over in."""
    jit.kernels(True)


@pytest.mark.usefixtures("_compiled")
@pytest.mark.parametrize("busy", BUSY)
def test_the_time_limit_holds(busy: str) -> None:
    text, assertion, said = BUSY[busy]
    script = cspcheck.loads(text + "\nchannel calm\nCALM = calm -> CALM\n")
    for seconds in ("0.5", "4"):
        result = script.check(assertion, timeout=float(seconds))
        assert result.verdict == "unknown"
        assert result.reason is not None
        assert result.reason.startswith(f"time limit of {seconds} s (`--timeout`) reached while ")
        if said in result.reason:  # on a busy machine the time may be over before the work that is meant has begun
            break
    assert said in result.reason
    assert script.check("CALM :[deadlock free]", timeout="5m").verdict == "pass"


def test_the_assertions_after_one_that_was_stopped_are_answered_as_without_it() -> None:
    text = """
    channel n : {0..9}
    P(i) = n.i -> P((i + 1) % 10) [] i == 7 & n!9 -> STOP
    endless(s) = endless(<1..1000> ^ s)
    assert length(endless(<>)) == 3
    assert P(0) :[deadlock free]
    assert STOP [T= P(0)
    """
    stopped = cspcheck.loads(text).check(max_memory=(process_memory() or 0) + (64 << 20))
    calm = cspcheck.loads(text.replace("endless(<1..1000> ^ s)", "s")).check()

    assert [result.verdict for result in stopped] == ["unknown", "fail", "fail"]
    for one, other in zip(stopped[1:], calm[1:], strict=True):
        assert (one.states, one.transitions, one.counterexample) == (
            other.states,
            other.transitions,
            other.counterexample,
        )


@pytest.mark.parametrize("busy", ["a normal form", "a wait", "a component that grows"])
def test_the_memory_limit_is_that_of_the_process(busy: str) -> None:
    text, assertion, _ = BUSY[busy]
    before = process_memory()
    if before is None:
        pytest.skip("this system does not tell the memory of a process")
    script = cspcheck.loads(text + "\nchannel calm\nCALM = calm -> CALM\n")
    limit = before + (48 << 20)
    result = script.check(assertion, max_memory=limit, timeout="5m")

    assert result.verdict == "unknown"
    assert result.reason is not None
    assert result.reason.startswith("memory limit of ")
    assert script.check("CALM :[deadlock free]").verdict == "pass"


@pytest.mark.parametrize(
    "text",
    [
        FIBONACCI + "print fib(60)",
        "channel c : {1..1000000000000}.{1..64}\nprint {| c |}",
    ],
)
def test_reading_a_script_has_the_limits_of_an_assertion(text: str, tmp_path) -> None:
    from cspcheck.checker.verdict import Limits
    from cspcheck.checking import Settings, load

    path = tmp_path / "x.csp"
    path.write_text(text)
    with pytest.raises(cspcheck.ScriptError) as caught:
        load(str(path), Settings(limits=Limits(None, 0.5, None)))

    assert caught.value.diagnostics[0].code in ("CSP920", "CSP425")


def test_a_reading_of_more_names_than_a_script_can_have_is_refused() -> None:
    text = "given M\nreading M = {}\nclass C\n  chan a : [x : M]\nend"
    with pytest.raises(cspcheck.ScriptError) as caught:
        cspcheck.loads(text.format(2147483647))
    assert [diagnostic.code for diagnostic in caught.value.diagnostics] == ["CSP682"]
    assert "`reading M = 2147483647` has more than 20,000 elements" in str(caught.value)
    cspcheck.loads(text.format(3))


def test_products_do_not_grow_beyond_what_one_step_can_work_with() -> None:
    script = cspcheck.loads("power(n) = if n == 0 then 2 else power(n - 1) * power(n - 1)\nsquare(n) = n * n")
    for text in ("power(40)", "square(square(square(square(power(18)))))"):
        with pytest.raises(cspcheck.ScriptError) as caught:
            script.evaluate(text)
        assert caught.value.diagnostics[0].code == "CSP440"
    assert script.evaluate("power(10)") == 2**1024


def test_out_of_memory_is_unknown(monkeypatch) -> None:
    script = cspcheck.loads("channel a\nP = a -> P")
    from cspcheck.checker.check import Checker

    def fail(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(Checker, "check", fail)
    result = script.check("P :[deadlock free]")

    assert (result.verdict, result.reason) == ("unknown", "out of memory")


def endless() -> None:
    while True:
        time.sleep(0.01)


class TestGuard:
    def test_nothing_arrives_behind_its_end(self) -> None:
        for _ in range(8):
            try:
                with Guard(seconds=0.0):
                    time.sleep(0.2)
            except Stopped:
                pass
            total = sum(range(1000))
        time.sleep(0.1)
        assert total == 499500

    def test_what_drops_the_exception_is_told_again(self) -> None:
        dropped = 0
        with Guard(seconds=0.1):
            while dropped < 2:
                try:
                    endless()
                except Stopped:
                    dropped += 1
        assert dropped == 2

    def test_what_would_be_too_much_is_not_taken(self) -> None:
        """An array that is doubled would be over the limit before anybody looks again."""
        before = process_memory()
        if before is None:
            pytest.skip("this system does not tell the memory of a process")
        guard = Guard(None, before + (64 << 20))
        with guard:
            afford(8 << 20)
        assert guard.reached is None
        with pytest.raises(Stopped), guard:
            _at_least(np.zeros(32 << 20, dtype=np.int32), (32 << 20) + 1)
        assert guard.reached == "memory"
        afford(1 << 50)  # nobody limits it

    def test_it_guards_its_own_thread(self) -> None:
        found: list[str] = []

        def work() -> None:
            try:
                with Guard(seconds=0.1):
                    endless()
            except Stopped:
                found.append("stopped")

        thread = threading.Thread(target=work)
        thread.start()
        thread.join()
        assert found == ["stopped"]

    def test_the_innermost_words_are_told(self) -> None:
        with pytest.raises(Stopped) as caught, Guard(seconds=0.0), during("baking"), during(lambda: "mixing"):
            endless()
        assert caught.value.doing == ["mixing", "baking"]
