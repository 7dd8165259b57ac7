"""Which workloads of a benchmark are meant."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable


def measure_chosen(workloads: Iterable[str], measured: Callable[[str], None]) -> None:
    """Measure the workloads whose names contain the pattern of the command line; without one, all."""
    pattern = sys.argv[1] if len(sys.argv) > 1 else ""
    for name in workloads:
        if pattern in name:
            measured(name)
