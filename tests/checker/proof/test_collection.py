"""A cheap part of the collection of ``tests/benchmarks/bench_proof.py``: what is proved, and faults that are found."""

from __future__ import annotations

from collections import Counter

import pytest

from tests.benchmarks.bench_proof import FAULTS, findings, text_of, with_fault


@pytest.mark.parametrize(("owner", "obligations"), [("Tickets", 23), ("History", 29), ("Divider", 23)])
def test_all_of_a_class_is_proved(owner: str, obligations: int) -> None:
    found = findings("".join(text_of(owner)), None, owner)
    assert Counter(finding.status for finding in found) == {"proved": obligations}


@pytest.mark.parametrize("owner", ["Tickets", "Parking", "Stack"])
def test_a_fault_is_refuted(owner: str) -> None:
    (old, new) = next((old, new) for name, old, new in FAULTS if name == owner)
    found = findings(with_fault(owner, old, new), ("invariant preserved", "carrier kept"), owner)
    assert any(finding.status == "refuted" and finding.severity != "info" for finding in found)
