"""Model checking for concurrent systems specified in CSPm and CSP-OZ.

>>> import cspcheck
>>> script = cspcheck.load("rov.csp")
>>> for result in script.check():
...     assert result, result.explain()

Importing this package registers the notation of classes and imports nothing else; its names are looked up when they
are first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import cspcheck.cspm.oz  # noqa: F401  (every way in comes by here, so scripts may have classes whoever loads them)

if TYPE_CHECKING:
    from cspcheck.api import Machine as Machine, Process as Process, Script as Script, load as load, loads as loads
    from cspcheck.checker.budget import Incomplete as Incomplete
    from cspcheck.checker.verdict import (
        ComponentBehaviour as ComponentBehaviour,
        Counterexample as Counterexample,
        Verdict as Verdict,
    )
    from cspcheck.cspm.diagnostics import Diagnostic as Diagnostic, ScriptError as ScriptError
    from cspcheck.result import Result as Result

__version__ = "0.1.0"

_HOMES = {
    "ComponentBehaviour": "cspcheck.checker.verdict",
    "Counterexample": "cspcheck.checker.verdict",
    "Diagnostic": "cspcheck.cspm.diagnostics",
    "Incomplete": "cspcheck.checker.budget",
    "Machine": "cspcheck.api",
    "Process": "cspcheck.api",
    "Result": "cspcheck.result",
    "Script": "cspcheck.api",
    "ScriptError": "cspcheck.cspm.diagnostics",
    "Verdict": "cspcheck.checker.verdict",
    "load": "cspcheck.api",
    "loads": "cspcheck.api",
}

__all__ = [
    "ComponentBehaviour",
    "Counterexample",
    "Diagnostic",
    "Incomplete",
    "Machine",
    "Process",
    "Result",
    "Script",
    "ScriptError",
    "Verdict",
    "__version__",
    "load",
    "loads",
]


def __getattr__(name: str) -> Any:
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(home), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
