"""``concise``: for editors and ``grep``. One line an assertion, ``file:line: verdict: text``, and one a diagnostic."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.report.diagnostics import concise_diagnostic
from cspcheck.report.sentences import sentence
from cspcheck.report.style import harmless
from cspcheck.result import Result, Summary


class ConciseReport:
    """One line an assertion; behind ``--`` the reason where there is one."""

    carries_diagnostics = True

    def __init__(self, write: Callable[[str], object], verbosity: int = 0) -> None:
        self._write = write
        self._verbosity = verbosity

    def script(self, name: str, printed: Sequence[str] = ()) -> None:
        """Nothing: each line names its file."""

    def diagnostics(self, diagnostics: Iterable[Diagnostic]) -> None:
        """One line each, so that an editor finds errors of scripts where it finds verdicts."""
        for diagnostic in diagnostics:
            self._write(concise_diagnostic(diagnostic) + "\n")

    def result(self, result: Result) -> None:
        """One assertion's answer."""
        if self._verbosity < 0 and result.as_expected:
            return
        words = sentence(result) if not (result and result.as_expected) else ""
        text = f"{result.file}:{result.line}: {result.verdict}: {result.assertion}" + (f" -- {words}" if words else "")
        self._write(" ".join(harmless(text).split()) + "\n")
        self.diagnostics(result.diagnostics)

    def unreached(self, results: Sequence[Result]) -> None:
        """They are unknown."""
        for result in results:
            self.result(result)

    def end(self, summary: Summary, *, interrupted: bool = False) -> None:
        """Nothing: every line stands for itself."""
