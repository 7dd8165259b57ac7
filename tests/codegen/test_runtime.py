"""Channels, alternation and tasks: every event is exactly one commit of all who take part."""

from __future__ import annotations

import itertools
import json
import random
import threading
import tracemalloc
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings, strategies as st

from cspcheck.codegen.runtime import (
    ANY,
    Channel,
    Deadlock,
    InOrder,
    Integers,
    JsonLines,
    Memory,
    NobodyDecides,
    OutOfRange,
    Program,
    Randomly,
    Record,
    Runner,
    Stopped,
    Task,
    VirtualClock,
    WrongOffer,
    one_of,
    program,
)
from tests.codegen.automata import Design, designs
from tests.examples import examples

RUNNERS: tuple[Runner, ...] = ("threads", "asyncio", "loop")
runners = pytest.mark.parametrize("runner", RUNNERS)


class Doing(Task):
    """A task made of a function."""

    def __init__(self, name: str, do: Any, **settings: Any) -> None:
        super().__init__(name, **settings)
        self.do = do

    async def run(self) -> None:
        await self.do(self)


def trace(*tasks: Task, runner: Runner = "loop", **settings: Any) -> list[str]:
    """The events of a run of some tasks."""
    memory = Memory()
    Program(tasks).run(runner, recorder=memory, **settings)
    return memory.trace(hidden=True)


class TestChannels:
    @runners
    def test_a_value_passes_when_both_are_there(self, runner: Runner) -> None:
        c = Channel("c", [Integers(0, 9)], parties=[tuple("PC")])
        received = []

        async def put(task: Task) -> None:
            for i in range(5):
                await task.perform(c.put(i))

        async def get(task: Task) -> None:
            for _ in range(5):
                received.extend(await task.perform(c.get()))

        assert trace(Doing("P", put), Doing("C", get), runner=runner) == ["c.0", "c.1", "c.2", "c.3", "c.4", "tick"]
        assert received == [0, 1, 2, 3, 4]

    @runners
    def test_three_parties_meet_at_once(self, runner: Runner) -> None:
        c = Channel("c", [Integers(0, 9)] * 3, parties=[tuple("ABC")])
        seen = {}

        async def do(task: Task) -> None:
            fields = [ANY, ANY, ANY]
            fields["ABC".index(task.name)] = "ABC".index(task.name) + 5
            seen[task.name] = await task.perform(c.offer(*fields))

        assert trace(*[Doing(name, do) for name in "ABC"], runner=runner) == ["c.5.6.7", "tick"]
        assert seen == dict.fromkeys("ABC", (5, 6, 7))

    def test_one_of_several_groups_performs_an_event(self) -> None:
        c = Channel("c", [Integers(0, 9)], parties=[tuple("PR"), tuple("QR")])
        memory = Memory()

        async def put(task: Task) -> None:
            await task.perform(c.put("PQ".index(task.name)))

        async def get(task: Task) -> None:
            for _ in range(2):
                await task.perform(c.get())

        Program([Doing("P", put), Doing("Q", put), Doing("R", get)]).run("loop", recorder=memory)
        assert [(r.event, r.tasks) for r in memory.records] == [
            ("c.0", ("P", "R")),
            ("c.1", ("Q", "R")),
            ("tick", ()),
        ]

    def test_who_takes_part_may_depend_on_the_values(self) -> None:
        c = Channel("c", [Integers(0, 2)], parties={(0,): ["P"], (1,): [tuple("PQ")]})
        memory = Memory()

        async def both(task: Task) -> None:
            await task.perform(c.put(0))
            await task.perform(c.put(1))

        async def one(task: Task) -> None:
            await task.perform(c.get())

        with pytest.raises(Deadlock):
            Program([Doing("P", lambda t: t.perform(c.put(2))), Doing("Q", one)]).run("loop")
        Program([Doing("P", both), Doing("Q", one)]).run("loop", recorder=memory)
        assert [(r.event, r.tasks) for r in memory.records[:2]] == [("c.0", ("P",)), ("c.1", ("P", "Q"))]

    def test_a_guard_on_values_waits_for_the_right_one(self) -> None:
        c = Channel("c", [Integers(0, 9), Integers(0, 9)], parties=[tuple("PC")])
        seen = []

        async def put(task: Task) -> None:
            await task.select(c.put(1, 2), c.put(4, 3), c.put(5, 5))

        async def get(task: Task) -> None:
            seen.append(await task.perform(c.offer(one_of([1, 4]), ANY, accept=lambda x, y: x > y)))

        assert trace(Doing("P", put), Doing("C", get)) == ["c.4.3", "tick"]
        assert seen == [(4, 3)]

    def test_where_no_task_gives_a_value_the_policy_does(self) -> None:
        c = Channel("c", [Integers(0, 2)], parties=[tuple("PC")])

        async def get(task: Task) -> None:
            for _ in range(4):
                await task.perform(c.offer(one_of([1, 2])))

        assert trace(Doing("P", get), Doing("C", get)) == ["c.1", "c.2", "c.1", "c.2", "tick"]

    def test_where_nobody_can_give_a_value_it_says_so(self) -> None:
        c = Channel("c", [Integers()], parties=[tuple("PC")])
        with pytest.raises(NobodyDecides, match="no task gives the value of field 1 of c, and the integers cannot"):
            trace(*[Doing(name, lambda t: t.perform(c.get())) for name in "PC"])

    def test_offers_are_checked(self) -> None:
        c = Channel("c", [Integers(0, 9)], parties=[tuple("PC")])
        with pytest.raises(WrongOffer, match="Q takes no part in c, which joins C, P"):
            trace(Doing("Q", lambda t: t.perform(c.put(1))))
        with pytest.raises(WrongOffer, match="c has 1 fields, P offers 2"):
            trace(Doing("P", lambda t: t.perform(c.put(1, 2))))

    @runners
    def test_a_value_outside_its_range_is_an_error_where_it_is_sent(self, runner: Runner) -> None:
        c = Channel("c", [Integers(0, 10, "DATA")], parties=[tuple("PC")])
        with pytest.raises(OutOfRange) as raised:
            trace(Doing("P", lambda t: t.perform(c.put(11))), Doing("C", lambda t: t.perform(c.get())), runner=runner)
        assert str(raised.value) == "P: c = 11 is outside DATA = 0..10"
        assert raised.value.__notes__ == ["in the task P"]

    def test_a_task_can_mend_a_wrong_offer(self) -> None:
        c = Channel("c", [Integers(0, 10)], parties=["P"])

        async def put(task: Task) -> None:
            try:
                await task.perform(c.put(11))
            except OutOfRange:
                await task.perform(c.put(10))

        for runner in RUNNERS:
            assert trace(Doing("P", put), runner=runner) == ["c.10", "tick"]


class TestAlternation:
    @runners
    def test_output_guards_commit_exactly_one(self, runner: Runner) -> None:
        """Two tasks that each would send to the other or receive from it: every event is agreed on."""
        ab = Channel("ab", [Integers(0, 999)], parties=[tuple("AB")])
        ba = Channel("ba", [Integers(0, 999)], parties=[tuple("AB")])
        logs: dict[str, list[tuple[int, int]]] = {"A": [], "B": []}

        async def do(task: Task) -> None:
            for i in range(1000):
                mine = ab.put(i) if task.name == "A" else ab.get()
                other = ba.get() if task.name == "A" else ba.put(i)
                choice = await task.select(mine, other)
                logs[task.name].append((choice.taken, choice.values[0]))

        events = trace(Doing("A", do), Doing("B", do), runner=runner)
        assert logs["A"] == logs["B"]
        assert events[:-1] == [f"{('ab', 'ba')[taken]}.{value}" for taken, value in logs["A"]]

    def test_a_false_guard_is_no_offer(self) -> None:
        a = Channel("a", parties=["P"])
        b = Channel("b", parties=["P"])

        async def do(task: Task) -> None:
            choice = await task.select(None, a.put() if False else None, b.put())
            assert choice.taken == 2

        assert trace(Doing("P", do)) == ["b", "tick"]

    def test_the_event_of_the_most_urgent_task_happens_first(self) -> None:
        a, b = Channel("a", parties=["A"]), Channel("b", parties=["B"])
        tasks = [
            Doing("A", lambda t: t.perform(a.put()), priority=1),
            Doing("B", lambda t: t.perform(b.put()), priority=2),
        ]
        assert trace(*tasks) == ["b", "a", "tick"]
        tasks[0].priority = 3
        assert trace(*tasks) == ["a", "b", "tick"]

    def test_a_fair_policy_starves_nobody(self) -> None:
        left, right = Channel("left", parties=["S"]), Channel("right", parties=["S"])

        async def do(task: Task) -> None:
            while True:
                await task.select(left.put(), right.put())

        assert trace(Doing("S", do), events=6) == ["left", "right"] * 3
        assert trace(Doing("S", do), events=3, policy=InOrder()) == ["left"] * 3

    def test_a_method_gives_the_values_of_its_event(self) -> None:
        m = Channel("m", [Integers(0, 9)] * 2, parties=["P"])
        other = Channel("other", parties=[tuple("PQ")])
        calls = []

        def body(x: int) -> int:
            calls.append(x)
            return x + 1

        async def do(task: Task) -> None:
            choice = await task.select(other.put(), m.own(body, 4, ANY))
            assert choice == (1, (4, 5))

        with pytest.raises(Deadlock):
            trace(Doing("P", do), Doing("Q", lambda t: t.stop()))
        assert calls == [4]
        with pytest.raises(OutOfRange, match="P: m, field 2 = 10 is outside"):
            trace(Doing("P", lambda t: t.perform(m.own(body, 9, ANY))))

    def test_a_method_of_an_event_that_needs_others_is_not_performed_alone(self) -> None:
        m = Channel("m", [Integers(0, 9)], parties={(1,): ["P"], (0,): [("P", "Q")]}, never=["Q"])
        assert trace(Doing("P", lambda t: t.select(m.own(lambda x: None, 0), m.own(lambda x: None, 1)))) == [
            "m.1",
            "tick",
        ]
        with pytest.raises(Deadlock):
            trace(Doing("P", lambda t: t.perform(m.own(lambda x: None, 0))))
        with pytest.raises(Deadlock):
            trace(Doing("P", lambda t: t.perform(m.own(lambda: 1, one_of([0])))))
        with pytest.raises(WrongOffer, match=r"P: the method m gave \(0,\), which cannot happen"):
            trace(Doing("P", lambda t: t.perform(m.own(lambda: 0, ANY))))

    @settings(max_examples=examples(80))
    @given(designs(), st.integers(0, 2**16), st.sampled_from(RUNNERS))
    def test_every_run_is_a_run_of_the_design(self, design: Design, seed: int, runner: Runner) -> None:
        """And if it ends in a deadlock, then nothing was possible any more."""
        _, tasks = design.program()
        memory = Memory()
        try:
            Program(tasks).run(runner, recorder=memory, policy=Randomly(seed), events=60)
        except Deadlock:
            assert not design.possible(tuple(task.state for task in tasks))  # type: ignore[attr-defined]
        else:
            assert len(memory.records) == 60
        design.judge(memory.records)
        for task in tasks:
            seen = [(r.channel, r.values[0]) for r in memory.records if task.name in r.tasks]
            # The last event may have come when the task was being stopped already.
            assert task.log == seen[: len(task.log)]  # type: ignore[attr-defined]
            assert len(seen) - len(task.log) <= 1  # type: ignore[attr-defined]

    @settings(max_examples=examples(30))
    @given(designs(), st.integers(0, 2**16))
    def test_whoever_carries_a_serial_run_it_is_the_same(self, design: Design, seed: int) -> None:
        runs = []
        for runner in RUNNERS:
            _, tasks = design.program()
            memory = Memory()
            try:
                Program(tasks).run(
                    runner, recorder=memory, policy=Randomly(seed), events=30, clock=VirtualClock(), serial=True
                )
            except Deadlock as deadlock:
                runs.append((memory.records, str(deadlock)))
            else:
                runs.append((memory.records, ""))
        assert runs[0] == runs[1] == runs[2]

    @pytest.mark.parametrize("runner", ["threads", "asyncio"])
    def test_stress_many_tasks_on_few_channels(self, runner: Runner) -> None:
        """Eight tasks, all pairs joined, everybody sends and receives at once: nothing is lost, nothing comes twice."""
        names = "ABCDEFGH"
        pairs = list(itertools.permutations(names, 2))
        channels = {pair: Channel("_".join(pair), [Integers(0)], parties=[pair]) for pair in pairs}
        sent: dict[tuple[str, str], list[int]] = {pair: [] for pair in pairs}
        received: dict[tuple[str, str], list[int]] = {pair: [] for pair in pairs}

        async def do(task: Task) -> None:
            rng = random.Random(task.name)
            for i in itertools.count():
                mine = [pair for pair in pairs if task.name in pair and rng.random() < 0.6]
                offers = [channels[p].put(i) if p[0] == task.name else channels[p].get() for p in mine]
                if not offers:
                    continue
                choice = await task.select(*offers)
                pair = mine[choice.taken]
                (sent if pair[0] == task.name else received)[pair].append(choice.values[0])

        memory = Memory()
        try:
            Program([Doing(name, do) for name in names]).run(runner, recorder=memory, events=20_000)
        except Deadlock:  # possible: everybody may happen to offer what nobody else does
            assert len(memory.records) > 0
        for pair in pairs:
            happened = [r.values[0] for r in memory.records if r.channel == "_".join(pair)]
            assert happened[: len(sent[pair])] == sent[pair]
            assert happened[: len(received[pair])] == received[pair]
            assert len(happened) - min(len(sent[pair]), len(received[pair])) <= 1


class TestEnds:
    @runners
    def test_a_deadlock_is_found_and_explained(self, runner: Runner) -> None:
        left, right = (Channel(name, [Integers(0, 3)], parties=[tuple("PQ")]) for name in ("left", "right"))
        tick = Channel("clock", parties=["R"])
        tasks = [
            Doing("P", lambda t: t.perform(left.put(1))),
            Doing("Q", lambda t: t.perform(right.offer(one_of([1, 2])))),
            Doing("R", lambda t: t.perform(tick.put())),
            Doing("S", lambda t: t.stop()),
        ]
        with pytest.raises(Deadlock) as raised:
            trace(*tasks, runner=runner)
        lines = str(raised.value).splitlines()
        assert lines[0] == "deadlock: every task waits for ever"
        assert sorted(lines[1:4]) == [
            "  P offers left.1; it waits for Q",
            "  Q offers right?{1, 2}; it waits for P",
            "  S offers nothing (it has stopped)",
        ]
        assert lines[4] == "  ended: R"
        assert lines[5] in ("  P -> Q -> P", "  Q -> P -> Q")

    @runners
    def test_a_failing_task_stops_the_others(self, runner: Runner) -> None:
        c = Channel("c", parties=[tuple("PC")])
        ends = []

        async def fails(task: Task) -> None:
            await task.perform(c.put())
            raise ZeroDivisionError

        async def waits(task: Task) -> None:
            try:
                while True:
                    await task.perform(c.put())
            finally:
                ends.append(task.name)

        with pytest.raises(ZeroDivisionError) as raised:
            trace(Doing("P", fails), Doing("C", waits), runner=runner)
        assert raised.value.__notes__ == ["in the task P"]
        assert ends == ["C"]

    @runners
    def test_a_program_can_be_stopped_from_inside_and_by_count(self, runner: Runner) -> None:
        c, d = Channel("c", parties=[tuple("PC")]), Channel("d", parties=["D"])
        cleaned = []

        async def forever(task: Task) -> None:
            try:
                while True:
                    await task.perform(c.put())
            except Stopped:
                cleaned.append(task.name)
                raise

        assert trace(Doing("P", forever), Doing("C", forever), runner=runner, events=7) == ["c"] * 7
        assert sorted(cleaned) == ["C", "P"]

        async def stops(task: Task) -> None:
            await task.perform(d.put())
            program.stop()
            await task.perform(d.put())

        program = Program([Doing("P", forever), Doing("C", forever), Doing("D", stops)])
        memory = Memory()
        summary = program.run(runner, recorder=memory)
        assert not summary.terminated
        assert summary.lingering == ()
        assert memory.trace().count("d") == 1

    def test_what_the_recorder_refuses_stops_the_program(self) -> None:
        class Refusing:
            def record(self, record: Record) -> None:
                if record.number == 3:
                    raise AssertionError("departed")

            def close(self) -> None:
                pass

        c = Channel("c", parties=["P"])

        async def forever(task: Task) -> None:
            while True:
                await task.perform(c.put())

        for runner in RUNNERS:
            with pytest.raises(AssertionError, match="departed"):
                Program([Doing("P", forever)]).run(runner, recorder=Refusing())

    def test_records_are_lines_of_json(self, tmp_path: Path) -> None:
        c = Channel("c", [Integers(0, 9)], parties=[tuple("PC")], hidden=True)
        file = tmp_path / "run.jsonl"
        tasks = [Doing("P", lambda t: t.perform(c.put(3))), Doing("C", lambda t: t.perform(c.get()))]
        Program(tasks).run("loop", recorder=JsonLines(file), clock=VirtualClock())
        first, last = map(json.loads, file.read_text().splitlines())
        assert first == {
            "n": 0,
            "time": 0.0,
            "event": "c.3",
            "channel": "c",
            "values": [3],
            "tasks": ["C", "P"],
            "hidden": True,
        }
        assert last["event"] == "tick"


class TestBodiesThatBlock:
    @runners
    def test_a_body_that_never_comes_back_is_left_behind(self, runner: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(program, "PATIENCE", 0.05)
        forever = threading.Event()
        c, d = Channel("c", parties=["Stuck"]), Channel("d", parties=["Free"])

        async def stuck(task: Task) -> None:
            await task.perform(c.own(forever.wait))

        async def free(task: Task) -> None:
            await task.perform(d.meet())
            await task.stop()

        try:
            summary = Program([Doing("Free", free), Doing("Stuck", stuck)]).run(runner, seconds=0.05)
        finally:
            forever.set()
        assert summary.lingering == ("Stuck",)

    @runners
    def test_what_a_body_raises_is_told_once(self, runner: Runner) -> None:
        c = Channel("c", parties=["T"])

        def wrong() -> None:
            raise error

        error = ValueError("no")
        for _ in range(3):
            with pytest.raises(ValueError, match="no") as raised:
                Program([Doing("T", lambda task: task.perform(c.own(wrong)))]).run(runner)
        assert raised.value.__notes__ == ["in the task T"]


def test_without_a_recorder_no_event_is_kept() -> None:
    """A program that runs for years must not grow."""
    c = Channel("c", parties=["T"])

    async def forever(task: Task) -> None:
        while True:
            await task.perform(c.meet())

    def growth(events: int) -> int:
        tracemalloc.start()
        try:
            Program([Doing("T", forever)]).run("loop", events=events)
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    growth(10)
    assert growth(5_000) < growth(50) + 10_000
