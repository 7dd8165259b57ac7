"""The exhibits: every script in specs/ gives the verdicts that it announces, with these very counts."""

from __future__ import annotations

from pathlib import Path

import pytest

import cspcheck
from cspcheck.checker.semantics.transitions import explore
from cspcheck.cspm.oz.processes.classes import specification_of
from tests.specs.table import BEGIN, SPECS, as_it_should_be, results, scripts, systems, without_times

pytestmark = pytest.mark.slow

WHOLE_MACHINES = {
    ("rov/rov.csp", "BaseReader"): (3, 3),
    ("rov/rov.csp", "S1"): (2, 3),
    ("rov/rov.csp", "Stop"): (3, 4),
    ("producer_consumer/producer_consumer.csp", "SYSTEM"): (4, 5),
    ("producer_consumer/producer_consumer.csp", "Repaired"): (4, 4),
    ("classics/philosophers.csp", "Symmetric"): (18_335, 83_675),
    ("classics/philosophers.csp", "Asymmetric"): (17_088, 77_840),
    ("classics/milner.csp", "Scheduler"): (96, 240),
    ("classics/milner.csp", "WrongScheduler"): (64, 144),
    ("classics/abp.csp", "Protocol"): (1_290, 3_752),
    ("classics/token_ring.csp", "Ring"): (240, 720),
    ("classics/buffer_chain.csp", "Chain"): (27, 48),
    ("classics/buffer_chain.csp", "Buffer(<>)"): (15, 28),
    ("classics/crossing.csp", "System(DOWN, DOWN)"): (23, 30),
    ("classics/peterson.csp", "System"): (48, 96),
    ("classics/election.csp", "Election"): (15, 22),
    ("freertps/freertps.csp", "Original({})"): (84, 267),
    ("freertps/freertps.csp", "Discovering"): (256, 768),
    ("freertps/reliability.csp", "Channel(Writer(0, <>), Network(EachKind, 1))"): (2550, 3780),
    ("freertps/scheduling.csp", "Board(PID_FIRST, 5, PUBLICATION)"): (44, 44),
    ("microautoware/microautoware.csp", "Required(SIGNALS)"): (234, 1229),
    ("microautoware/microautoware.csp", "Thread(SIGNALS, false)"): (1400, 9256),
    ("microautoware/tasks.csp", "Sharing(Behind)"): (1272, 2516),
    ("microautoware/tasks.csp", "Modes(AUTOWARE)"): (1954, 8204),
    ("microautoware/service.csp", "Service(Numbered(1, 0), Slow)"): (344, 576),
    ("microautoware/serial.csp", "Serial(PLAIN, Line(1), false)"): (65, 73),
    ("robot_soccer/robot_soccer.csp", "Team(MIROSOT, {1..3})"): (82, 117),
    ("robot_soccer/robot_soccer.csp", "Link(MIROSOT, ANY, 1, 1)"): (448, 592),
    ("robot_soccer/robot_soccer.csp", "Late(F180, ANY, 0, 1)"): (4181, 5248),
    ("robot_soccer/check_bits.csp", "Game(Parity, 1)"): (6606, 15_933),
}


def name(script: Path) -> str:
    return script.relative_to(SPECS).as_posix()


@pytest.mark.parametrize("system", systems(), ids=name)
def test_every_assertion_has_the_verdict_that_its_script_expects_and_its_table_shows(system: Path) -> None:
    """Both in one test: the results are found once, whichever process runs it."""
    for path in scripts(system):
        for result in results(path):
            assert result.verdict == result.expected, result.explain()
    assert_the_table_is_true(system / "README.md")


def test_the_table_of_all_systems_sums_theirs_up() -> None:
    assert_the_table_is_true(SPECS / "README.md")


def assert_the_table_is_true(readme: Path) -> None:
    assert without_times(readme.read_text(encoding="utf-8")) == without_times(as_it_should_be(readme)), (
        f"{name(readme)} is out of date: python -m tests.specs.table"
    )


@pytest.mark.parametrize(("script", "process"), WHOLE_MACHINES, ids=lambda part: str(part))
def test_the_whole_machine_has_these_states_and_transitions(script: str, process: str) -> None:
    machine = cspcheck.load(SPECS / script).process(process).lts()

    assert (machine.states, machine.transitions) == WHOLE_MACHINES[script, process]


def test_the_vehicle_has_the_states_and_transitions_that_were_found_in_2009() -> None:
    found = results(SPECS / "rov" / "rov.csp")

    assert [str(result.verdict) for result in found] == ["pass"] * 3
    assert {(result.states, result.transitions) for result in found} == {(2_519_424, 23_549_616)}


def test_the_classes_of_the_vehicle_have_the_same_control_part() -> None:
    found = results(SPECS / "rov" / "control_view.csp")[:3]

    assert [str(result.verdict) for result in found] == ["pass"] * 3
    assert {(result.states, result.transitions) for result in found} == {(2_519_424, 23_549_616)}


@pytest.mark.parametrize("system", systems(), ids=name)
def test_every_system_has_a_table(system: Path) -> None:
    assert BEGIN in (system / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(("script", "process"), WHOLE_MACHINES, ids=lambda part: str(part))
def test_exploring_the_terms_themselves_gives_the_same_counts(script: str, process: str) -> None:
    loaded = cspcheck.load(SPECS / script)
    machine, _ = explore(loaded.process(process)._term)

    assert (machine.states, machine.transitions) == WHOLE_MACHINES[script, process]


@pytest.mark.parametrize("name", ["producer_consumer/classes", "stack/stack"])
def test_both_notations_of_a_system_say_the_same(name: str) -> None:
    text, printed = (cspcheck.load(SPECS / f"{name}.{suffix}") for suffix in ("csp", "tex"))

    assert specification_of(text._script) == specification_of(printed._script)
    assert text.assertions == printed.assertions
