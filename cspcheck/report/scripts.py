"""``typecheck`` in ``full`` and ``concise``: the diagnostics are the result."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.quantities import count
from cspcheck.report.diagnostics import concise_diagnostic, render_diagnostic
from cspcheck.report.style import PLAIN, Style, harmless
from cspcheck.result import Result, Summary


class ScriptsReport:
    """Diagnostics with excerpts, a line for each script without an error, and how many there were."""

    carries_diagnostics = True

    def __init__(self, write: Callable[[str], object], style: Style = PLAIN, verbosity: int = 0) -> None:
        self._write = write
        self._style = style
        self._verbosity = verbosity
        self._good = 0

    def script(self, name: str, printed: Sequence[str] = ()) -> None:
        """A script without an error."""
        self._good += 1
        if self._verbosity >= 0:
            mark = self._style.paint("✓" if self._style.unicode else "+", "bold", "green")
            self._write(f"{mark} {harmless(name)}\n")

    def diagnostics(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Errors and warnings of a script."""
        for diagnostic in diagnostics:
            self._write(render_diagnostic(diagnostic, self._style) + "\n\n")

    def result(self, result: Result) -> None:
        """Nothing: no assertion is checked."""

    def unreached(self, results: Sequence[Result]) -> None:
        """Nothing: no assertion is checked."""

    def end(self, summary: Summary, *, interrupted: bool = False) -> None:
        """How many scripts there were."""
        if self._verbosity < 0:
            return
        bad = summary.verdicts["error"]
        text = count(self._good, "script") + " without errors"
        if bad:
            text += ", " + self._style.paint(count(bad, "script") + " with errors", "red")
        self._write(f"{'interrupted; until then: ' if interrupted else ''}{text}\n")


class ConciseScriptsReport:
    """One line a diagnostic: ``file:line:column: error[CSP201]: message``."""

    carries_diagnostics = True

    def __init__(self, write: Callable[[str], object]) -> None:
        self._write = write

    def script(self, name: str, printed: Sequence[str] = ()) -> None:
        """Nothing: only diagnostics are told."""

    def diagnostics(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Errors and warnings of a script."""
        for diagnostic in diagnostics:
            self._write(concise_diagnostic(diagnostic) + "\n")

    def result(self, result: Result) -> None:
        """Nothing: no assertion is checked."""

    def unreached(self, results: Sequence[Result]) -> None:
        """Nothing: no assertion is checked."""

    def end(self, summary: Summary, *, interrupted: bool = False) -> None:
        """Nothing: every line stands for itself."""
