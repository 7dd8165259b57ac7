"""The same script, the same document: what an assertion is answered does not depend on those that were checked before.

Names that the tool has for itself are none that a script can have.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import cspcheck
from cspcheck import testing
from cspcheck.report.json import result_object

INFINITE = """
channel n : Int
channel a
channel m : {0..2}.Seq({0,1}).Bool
channel huge : {1..1000000000000}.{1..1000000000000}
Q = m.1.<1,0>.true -> m!1!<>!false -> huge.7.7 -> n!9 -> n!12345678901234567890 -> n.(-12345678901234567890) -> Q
P = n!5 -> STOP [] n!1 -> STOP [] n.(-5) -> STOP [] n.(-99999999999999999999) -> STOP
Inner = m.1.<1,0>.true -> STOP [] m.1.<>.true -> STOP [] m.2.<>.false -> STOP [] m.0.<1>.true -> STOP
Wide = huge.7.8 -> STOP [] huge.7.7 -> STOP [] huge.6.9 -> STOP
assert Q :[deadlock free]
assert P :[deadlock free]
assert Inner :[deadlock free]
assert Wide :[deadlock free]
assert Q [T= P
assert P [FD= Q
assert n!1 -> n!5 -> STOP [F= n!5 -> STOP [] n!1 -> STOP
"""

OWN_NAMES = """
channel tick, tau, main, visible
P = tick -> tau -> main -> P
T = tick -> tau -> SKIP
Both = P \\ {tau}
assert Both [T= T \\ {tau}
assert P :[deadlock free]
"""


def told(result: cspcheck.Result) -> dict[str, object]:
    return result_object(result) | {"seconds": 0, "peak_memory_bytes": 0}


@pytest.mark.parametrize("name", ["infinite", "choices", "linked", "loops", "renamed", "ring", "timed"])
def test_an_assertion_is_answered_as_if_it_was_alone(name: str) -> None:
    text = INFINITE
    if name != "infinite":
        text = (Path(__file__).parent / "failing" / f"{name}.csp").read_text(encoding="utf-8")
    together = [told(result) for result in cspcheck.loads(text).check()]
    texts = [str(result["assertion"]) for result in together]
    backwards = cspcheck.loads(text)
    for assertion, expected in reversed(list(zip(texts, together, strict=True))):
        for script in (backwards, cspcheck.loads(text)):
            found = told(script.check(assertion))
            assert found["counterexample"] == expected["counterexample"]
            assert found["verdict"] == expected["verdict"]


def test_the_smallest_value_comes_first() -> None:
    traces = [result.counterexample.trace for result in cspcheck.loads(INFINITE).check()[1:4] if result.counterexample]
    assert traces == [("n.-99999999999999999999",), ("m.0.<1>.true",), ("huge.6.9",)]


class TestOwnNames:
    def test_a_channel_called_tick_is_followed(self, tmp_path: Path) -> None:
        script = cspcheck.loads(OWN_NAMES)
        follower = testing.follow(script, "P")._follower
        assert [follower.step(event) for event in ("tick", "tau", "main", "tick")] == [None] * 4
        follower = testing.follow(script, "T")._follower
        assert [follower.step(event) for event in ("tick", "tau")] == [None] * 2
        assert follower.allowed() == ("✓",)
        assert follower.step("tick") is not None
        assert follower.step("tick", terminated=True) is None

    def test_the_trace_command_tells_them_apart(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        from cspcheck.cli import run

        script, record = tmp_path / "own.csp", tmp_path / "run.jsonl"
        script.write_text(OWN_NAMES)
        lines = [{"event": "tick"}, {"event": "tau"}, {"event": "tick", "terminated": True}]
        record.write_text("".join(json.dumps(line) + "\n" for line in lines))
        assert run(["trace", str(script), "--process", "T", str(record)]) == 0
        assert run(["trace", str(script), "--process", "P", str(record)]) == 1
        record.write_text('"tick"\n"tau"\n"main"\n"tick"\n')
        assert run(["trace", str(script), "--process", "P", str(record)]) == 0
        assert run(["trace", str(script), "--process", "T", str(record)]) == 1
        capsys.readouterr()

    def test_what_is_internal_is_not_called_like_a_channel(self) -> None:
        result, other = cspcheck.loads(OWN_NAMES).check()
        assert other
        assert result.counterexample is not None
        assert (result.counterexample.trace, result.counterexample.causes) == (("tick", "τ"), (None, "tau"))
        assert result.counterexample.event == "✓"
        assert "after 1 event and 1 internal step" in result.explain()
        assert "τ (tau)" in result.explain()

    def test_a_channel_called_tau_is_an_event(self) -> None:
        result = cspcheck.loads("channel tau\nassert tau -> STOP :[deadlock free]").check()[0]
        assert result.counterexample is not None
        assert result.counterexample.trace == ("tau",)
        assert "after 1 event:" in result.explain()

    def test_where_no_channel_has_the_names_they_are_words(self) -> None:
        text = "channel a, b\nassert STOP [T= (a -> SKIP) \\ {a}"
        (result,) = cspcheck.loads(text).check()
        assert result.counterexample is not None
        assert (result.counterexample.trace, result.counterexample.event) == (("tau",), "tick")


def test_drawn_traces_do_not_end_at_a_channel_called_tick() -> None:
    from hypothesis import find

    script = cspcheck.loads(OWN_NAMES)
    assert find(testing.traces(script, "P"), lambda trace: len(trace) == 2) == ["tick", "tau"]
    assert find(testing.traces(script, "T"), lambda trace: "✓" in trace) == ["tick", "tau", "✓"]
