"""How many examples a property is tried on: fewer in the test command, many in a night."""

from __future__ import annotations

import math
import os

USUAL = 40
"""The number of examples of a property that does not set its own, where the numbers are those that the tests name."""

ASKED = int(os.environ.get("CSPCHECK_EXAMPLES", "16"))
"""The number of examples of such a property in this run."""

ANEW = "CSPCHECK_EXAMPLES" in os.environ
"""Whether other examples are looked for in each run; else they are the same every time."""

FEW = 5


def examples(number: int) -> int:
    """The examples in this run of a property for which *number* is usual, at least a few."""
    return max(min(number, FEW), math.ceil(number * ASKED / USUAL))
