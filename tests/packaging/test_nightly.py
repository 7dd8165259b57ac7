"""The night of random inputs says how far it came, what to do again, and ends when it is told to."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests import __main__ as night

TEST = """
import os, signal, time

def test_it():
    seed, inputs = os.environ["CSPCHECK_SEED"], os.environ["CSPCHECK_FUZZ"]
    if (seed, inputs) == ("7+2", "5"):
        os.kill(os.getppid(), signal.SIGTERM)
        time.sleep(60)
    assert (seed, inputs) == ("7", "20")
"""


def test_a_round_without_findings_one_with_and_one_that_is_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    test, settings = tmp_path / "test_it.py", tmp_path / "pytest.ini"
    test.write_text(TEST)
    settings.write_text("[pytest]\n")
    monkeypatch.setenv("CSPCHECK_FUZZ", "45")
    monkeypatch.setenv("CSPCHECK_SEED", "7")
    monkeypatch.setattr(night, "ROUND", 20)
    monkeypatch.setattr(night, "NIGHTLY", (str(test),))
    monkeypatch.setattr(night.time, "monotonic", lambda: 0.0)

    assert night.nightly(["-n", "0", "-c", str(settings), "-p", "no:cacheprovider"]) == 1

    again = "   this round again: CSPCHECK_SEED={} CSPCHECK_FUZZ={} python -m tests --nightly"
    assert capsys.readouterr().out.splitlines() == [
        "== 20 of 45 inputs tried in 0.0 min, 0 of 1 rounds with findings",
        again.format("7+1", 20),
        "== 40 of 45 inputs tried in 0.0 min, 1 of 2 rounds with findings",
        again.format("7+2", 5),
        "== 40 of 45 inputs tried in 0.0 min, 1 of 2 rounds with findings; ended before its time",
    ]
