"""The exhibits: every script in specs/ gives the verdicts that it announces, with these very counts."""

from __future__ import annotations

from pathlib import Path

import pytest

import cspcheck
from checker.transitions import explore

SPECS = Path(__file__).resolve().parents[2] / "specs"
SCRIPTS = sorted(SPECS.rglob("*.csp"))

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
}


def name(script: Path) -> str:
    return script.relative_to(SPECS).as_posix()


@pytest.mark.parametrize("path", SCRIPTS, ids=name)
def test_every_assertion_has_the_verdict_that_the_script_expects(path: Path) -> None:
    for result in cspcheck.load(path).check():
        assert str(result.verdict) == (result.expected or "pass"), result.explain()


@pytest.mark.parametrize(("script", "process"), WHOLE_MACHINES, ids=lambda part: str(part))
def test_the_whole_machine_has_these_states_and_transitions(script: str, process: str) -> None:
    machine = cspcheck.load(SPECS / script).process(process).lts()

    assert (machine.states, machine.transitions) == WHOLE_MACHINES[script, process]


def test_the_vehicle_has_the_states_and_transitions_that_were_found_in_2009() -> None:
    results = cspcheck.load(SPECS / "rov" / "rov.csp").check(full=True)

    assert [str(result.verdict) for result in results] == ["pass"] * 3
    assert {(result.states, result.transitions) for result in results} == {(2_519_424, 23_549_616)}


@pytest.mark.parametrize(("script", "process"), WHOLE_MACHINES, ids=lambda part: str(part))
def test_exploring_the_terms_themselves_gives_the_same_counts(script: str, process: str) -> None:
    loaded = cspcheck.load(SPECS / script)
    machine, _ = explore(loaded.process(process)._term)

    assert (machine.states, machine.transitions) == WHOLE_MACHINES[script, process]
