"""The vehicle's classes as the thesis prints them are refused: each slip has its message."""

from __future__ import annotations

from pathlib import Path

import pytest

import cspcheck
from cspcheck.checker.proof.answer import specification_of

PRINTED = Path(__file__).resolve().parents[2] / "specs" / "rov" / "as_printed.oz"


def test_every_slip_of_the_printed_classes_is_told() -> None:
    with pytest.raises(cspcheck.ScriptError) as refused:
        cspcheck.load(PRINTED)

    told = [(d.code, d.message) for d in refused.value.diagnostics if d.severity == "error"]
    assert told == [
        ("CSP632", "a value of type `SONAR_TYPE` cannot be applied"),
        ("CSP646", "the channel `autonomous_s1` has no parameter `remoteData`"),
        ("CSP630", "`s1Data'` is not known here"),
        ("CSP630", "`Blackboard` is not known here"),
        ("CSP635", "a value of type `real` has no INIT"),
        ("CSP637", "`BlackBoard` is a class, not a type of values"),
        ("CSP635", "a value of type `real` has no INIT"),
        ("CSP630", "`actuationData` is not known here"),
        ("CSP640", "`dangerLevel'` is used, but `dangerLevel` is not in the Delta-list"),
        ("CSP632", "a number is needed here, not a value of type `ControlData`"),
        ("CSP637", "`BlackBoard` is a class, not a type of values"),
        ("CSP630", "`structureToMessage` is not known here"),
        ("CSP630", "`SONAR` is not known here"),
        ("CSP635", "a value of type `STATUS` has no INIT"),
        ("CSP630", "`sonarData` is not known here"),
        ("CSP631", "the types `ControlData` and `STATUS` differ"),
        (
            "CSP650",
            "`avoidCollisionData` of the channel `avoid_move` is of type `ControlData` in `AvoidCollision` "
            "and `STATUS` in `Move`",
        ),
    ]


def test_channels_that_do_not_meet_are_warned_about() -> None:
    with pytest.raises(cspcheck.ScriptError) as refused:
        cspcheck.load(PRINTED)

    alone = {d.message for d in refused.value.diagnostics if d.code == "CSP652"}
    assert alone == {
        "only `BaseReader` declares the channel `baseReader_autonomo`",
        "only `Autonomous` declares the channel `ethReader_autonomous`",
        "only `Autonomous` declares the channel `sensor_autonomous`",
        "only `S1` declares the channel `s1_moveToGoal`",
        "only `Move` declares the channel `s1_move`",
        "only `Actuator` declares the channel `generateSetpoints`",
    }


DOCUMENTS = sorted(PRINTED.parents[1].glob("*/*.tex"))


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_classes_in_latex_are_those_in_text(document: Path) -> None:
    """What a specification is does not depend on the notation."""
    text = specification_of(cspcheck.load(document.with_suffix(".csp"))._script)
    assert text is not None
    assert text == specification_of(cspcheck.load(document)._script)
