"""What is said when the mistake is ours: enough to report it, and no traceback in the user's face."""

from __future__ import annotations

import platform
import shlex
import tempfile
import traceback
from collections.abc import Sequence

from cspcheck import __version__
from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.messages import internal_error

_REQUEST = "this is a mistake in cspcheck, not in your script: please report it with the script and the traceback"


class InternalErrors:
    """The exceptions of one run that nobody expected.

    Their tracebacks go to one file in the folder for temporary files, or with *verbose* into the notes. Version,
    platform and arguments are told once.
    """

    def __init__(self, arguments: Sequence[str], *, verbose: bool = False) -> None:
        self._facts = (
            f"cspcheck {__version__}, Python {platform.python_version()}, {platform.platform()}\n"
            f"arguments: {shlex.join(arguments)}"
        )
        self._verbose = verbose
        self._told = False
        self._file: str | None = None

    def report(self, error: BaseException, doing: str) -> Diagnostic:
        """What to say of *error*, which was met while *doing* something."""
        trace = "".join(traceback.format_exception(error)).rstrip()
        lines = str(error).splitlines()
        notes = [trace] if self._verbose else [self._keep(doing, trace)]
        if not self._told:
            notes = [self._facts, *notes, _REQUEST]
            self._told = True
        return internal_error(type(error).__name__, lines[0] if lines else "", doing).with_notes(*notes)

    def _keep(self, doing: str, trace: str) -> str:
        """Add a traceback to the file; where it is, in words."""
        try:
            if self._file is None:
                with tempfile.NamedTemporaryFile(
                    "w", prefix="cspcheck-error-", suffix=".txt", encoding="utf-8", delete=False
                ) as file:
                    file.write(self._facts + "\n")
                    self._file = file.name
            with open(self._file, "a", encoding="utf-8", errors="backslashreplace") as file:
                file.write(f"\n{doing}\n{trace}\n")
        except OSError:
            return "`-v` shows the traceback"
        return f"the traceback is in {self._file}"
