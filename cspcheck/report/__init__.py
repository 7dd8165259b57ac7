"""Results and diagnostics as text, one renderer a file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Literal, Protocol, get_args

if TYPE_CHECKING:
    from cspcheck.cspm.diagnostics import Diagnostic
    from cspcheck.report.style import Style
    from cspcheck.result import Result, Summary

Format = Literal["full", "concise", "json", "jsonl", "junit", "github", "sarif", "html"]
FORMATS: tuple[Format, ...] = get_args(Format)


class Report(Protocol):
    """What a run tells a renderer, in this order: for each script its results, at last the end.

    ``carries_diagnostics``: whether diagnostics, those of results included, are part of the output; if not, they go to
    standard error.
    """

    carries_diagnostics: bool

    def script(self, name: str, printed: Sequence[str] = ()) -> None:
        """A script has been loaded; its results follow. *printed* is what its ``print`` lines say."""

    def diagnostics(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Errors and warnings."""

    def result(self, result: Result) -> None:
        """One assertion's answer."""

    def unreached(self, results: Sequence[Result]) -> None:
        """The run is interrupted; these are what it would have answered, as unknown."""

    def end(self, summary: Summary, *, interrupted: bool = False) -> None:
        """Nothing follows."""


def _unobeyed(write: Callable[[str], object]) -> Callable[[str], object]:
    """Writes the same, without lines that a build server would obey."""
    from cspcheck.report.style import unobeyed

    return lambda text: write(unobeyed(text))


def scripts_report(form: Format, write: Callable[[str], object], style: Style, verbosity: int = 0) -> Report:
    """The renderer of a format for a run that loads scripts and checks nothing."""
    if form == "full":
        from cspcheck.report.scripts import ScriptsReport

        return ScriptsReport(_unobeyed(write), style, verbosity)
    if form == "concise":
        from cspcheck.report.scripts import ConciseScriptsReport

        return ConciseScriptsReport(_unobeyed(write))
    return report(form, write, style, verbosity)


def report(form: Format, write: Callable[[str], object], style: Style, verbosity: int = 0) -> Report:
    """The renderer of a format. Only its own module is imported."""
    match form:
        case "full":
            from cspcheck.report.full import FullReport

            return FullReport(_unobeyed(write), style, verbosity)
        case "concise":
            from cspcheck.report.concise import ConciseReport

            return ConciseReport(_unobeyed(write), verbosity)
        case "json":
            from cspcheck import __version__
            from cspcheck.report.json import JsonReport

            return JsonReport(write, __version__)
        case "jsonl":
            from cspcheck.report.json import JsonLinesReport

            return JsonLinesReport(write)
        case "junit":
            from cspcheck.report.junit import JunitReport

            return JunitReport(_unobeyed(write))
        case "html":
            from cspcheck import __version__
            from cspcheck.report.html import HtmlReport

            return HtmlReport(write, __version__)
        case "github":
            from cspcheck.report.github import GithubReport

            return GithubReport(write)
        case "sarif":
            from cspcheck import __version__
            from cspcheck.report.sarif import SarifReport

            return SarifReport(write, __version__)
