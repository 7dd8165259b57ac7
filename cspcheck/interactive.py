"""Python with a person in front of it: how far a check is, and mistakes with the lines that they are about."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import TYPE_CHECKING, Any

from cspcheck.cspm.diagnostics import Diagnostic

if TYPE_CHECKING:
    from cspcheck.checker.search.exploration import Progress
    from cspcheck.cli.progress import ProgressLine


def in_notebook() -> bool:
    """Whether this is the kernel of a notebook."""
    ipython = sys.modules.get("IPython")
    return ipython is not None and hasattr(ipython.get_ipython(), "kernel")


def show_diagnostics(diagnostics: Iterable[Diagnostic]) -> str:
    """What is wrong, as the command line shows it."""
    from cspcheck.report.diagnostics import render_diagnostics
    from cspcheck.report.style import style_for

    return render_diagnostics(diagnostics, style_for(sys.stderr, "auto")).rstrip("\n")


class Shown:
    """The progress of checks, while it is shown (:meth:`during`): a line on standard error, or one in a notebook."""

    def __init__(self) -> None:
        self._line: ProgressLine | None = None

    @contextmanager
    def during(self, shown: bool) -> Iterator[None]:
        """Show progress, if *shown*, until the end of a block."""
        if not shown:
            yield
            return
        from cspcheck.cli.progress import Heartbeat, ProgressLine
        from cspcheck.report.style import is_terminal, style_for

        notebook = in_notebook()
        write = _Cell().write if notebook else sys.stderr.write
        style = style_for(sys.stderr, "never")
        self._line = ProgressLine(write, style, live=notebook or is_terminal(sys.stderr))
        try:
            with Heartbeat(self._line.beat):
                yield
        finally:
            self._line.done()
            self._line = None

    def begin(self, what: str) -> None:
        """A check starts."""
        if self._line is not None:
            self._line.begin(what)

    def progress(self, progress: Progress) -> None:
        """Where the search is."""
        if self._line is not None:
            self._line.progress(progress)

    def notify(self, line: str) -> None:
        """Something that takes a while and happens once."""
        if self._line is not None:
            self._line.notify(line)

    def done(self) -> None:
        """The check has ended."""
        if self._line is not None:
            self._line.done()


class _Cell:
    """A line below the cell of a notebook that is being run; each text takes the place of the one before."""

    def __init__(self) -> None:
        self._shown: Any = None

    def write(self, text: str) -> None:
        """Show a text, which may begin with the sign that erases a line of a terminal."""
        data = {"text/plain": text.removeprefix("\r\x1b[K").rstrip("\n")}
        if self._shown is None:
            display: Any = import_module("IPython.display").display  # a notebook has it
            self._shown = display(data, raw=True, display_id=True)
        else:
            self._shown.update(data, raw=True)
