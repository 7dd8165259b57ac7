"""What the rules of the operational semantics are written in."""

from __future__ import annotations

from collections.abc import Callable

from cspcheck.cspm.process.terms import Process

Step = tuple[int, Process]
"""An event and the state after it."""
Row = tuple[Step, ...]
"""The transitions of one state: distinct, ascending by event."""
Normalise = Callable[[Process], Process]
"""Brings what follows a step, and has not run before, to head normal form."""
