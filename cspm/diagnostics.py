"""One value for everything that is said about a script, and the register of the mistakes that can be made.

A diagnostic knows nothing about output; ``cspcheck.report`` renders it. Every mistake has one builder, a
function decorated with :func:`mistake` in the module of the phase that understands it (``cspcheck.cspm.messages``).
The decorator keeps what ``cspcheck explain CODE`` and the list of codes in the documentation print.

Codes by hundreds: 0 files and characters, 1 syntax, 2 names, 3 types, 4 evaluation, 5 processes and their
machines, 6 classes (CSP-OZ), 7 proof, 8 generated programs, 9 the tool itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TYPE_CHECKING, ClassVar, ParamSpec

if TYPE_CHECKING:
    from cspcheck.cspm.source import Span

P = ParamSpec("P")


class Severity(StrEnum):
    """How much a diagnostic matters: an error stops the script from being checked, a warning does not."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, slots=True)
class Label:
    """A secondary place with a few words about its part in the mistake ("first defined here")."""

    span: Span
    message: str


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """Something a user should know about a script.

    ``message`` is one terse sentence, lower case, no full stop, user input in backticks; if only one thing can
    be shown it is this. ``annotation`` is the few words beside the caret. ``notes`` add facts (the call stack of
    the script, innermost first); ``help`` says what to try.
    """

    code: str
    message: str
    span: Span | None = None
    severity: Severity = Severity.ERROR
    annotation: str = ""
    labels: tuple[Label, ...] = ()
    notes: tuple[str, ...] = ()
    help: str | None = None

    def with_notes(self, *notes: str) -> Diagnostic:
        """The same diagnostic with further notes at the end."""
        return replace(self, notes=self.notes + notes)


DiagnosticSink = Callable[[Diagnostic], None]
"""Takes diagnostics as they are found."""


class ScriptError(Exception):
    """A script that cannot be used as it stands; ``diagnostics`` has at least one error."""

    shown: ClassVar[Callable[[Iterable[Diagnostic]], str] | None] = None
    """How an interactive session is shown diagnostics with the lines that they are about; set by who can write them."""

    def __init__(self, *diagnostics: Diagnostic) -> None:
        self.diagnostics: tuple[Diagnostic, ...] = diagnostics
        super().__init__("; ".join(f"{d.code}: {d.message}" for d in diagnostics))

    def _render_traceback_(self) -> list[str]:
        """What IPython and notebooks show in the place of a traceback."""
        show = type(self).shown
        return [str(self) if show is None else show(self.diagnostics)]


@dataclass(frozen=True, slots=True)
class Mistake:
    """What the documentation says of one code.

    ``example`` is a script that makes the mistake, ``repair`` the same script put right (or prose where the
    mistake is not one of a script).
    """

    code: str
    title: str
    explanation: str
    example: str
    repair: str


MISTAKES: dict[str, Mistake] = {}


def mistake(
    code: str, title: str, *, explanation: str, example: str, repair: str
) -> Callable[[Callable[P, Diagnostic]], Callable[P, Diagnostic]]:
    """Register the builder of a diagnostic under its code.

    Raises:
        ValueError: the code is taken.
    """

    def register(builder: Callable[P, Diagnostic]) -> Callable[P, Diagnostic]:
        if code in MISTAKES:
            raise ValueError(f"{code} is registered twice")
        MISTAKES[code] = Mistake(code, title, explanation, example, repair)
        return builder

    return register
