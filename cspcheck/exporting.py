"""Scripts as plain CSPm: the language writes them, the checker finds which states the classes have."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from cspcheck.checker.checks.readings import left_in
from cspcheck.checker.semantics.transitions import LimitReached, explore
from cspcheck.checker.verdict import Limits
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.script import Script

if TYPE_CHECKING:
    from cspcheck.cspm.oz.writing.exporting import Exported

MOST_STATES = 200_000
"""A class with more states is no script that anyone would load."""


def plain_text(script: Script) -> Exported:
    """The script with its classes written out, and without what is ours alone.

    Raises:
        ScriptError: a class has too many states, leaves its finite readings, or cannot be evaluated.
    """
    from cspcheck.cspm.oz.writing.exporting import plain

    def visit(process: Process) -> str | None:
        try:
            explored = explore(process, Limits(states=MOST_STATES))
        except LimitReached as reached:
            raise ScriptError(reached.diagnostic) from None
        return next((left.report for term in explored.terms if (left := left_in(term)) is not None), None)

    return plain(script, visit, title=os.path.basename(script.source.name))
