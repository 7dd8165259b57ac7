"""An evaluation that went wrong, on its way out of the script: the diagnostic and the calls that led to it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.source import Span

INNERMOST = 8
OUTERMOST = 3
"""So many calls of the script's stack are shown from either end."""


class Failure(ScriptError):
    """Raised while a script is evaluated; each call that it passes adds itself.

    ``is_limit`` tells a failure of ours to go on (too deep, too large) from a mistake in the script: only a
    mistake is a value like any other that is never asked for.
    """

    def __init__(self, diagnostic: Diagnostic, *, is_limit: bool = False) -> None:
        super().__init__(diagnostic)
        self.diagnostic = diagnostic
        self.is_limit = is_limit
        self._inner: list[tuple[Callable[[], str], Span | None]] = []
        self._outer: deque[tuple[Callable[[], str], Span | None]] = deque(maxlen=OUTERMOST)
        self._passed = 0
        self._reached: Span | None = None

    def at(self, span: Span | None) -> Failure:
        """Give the diagnostic a place if it has none yet."""
        if self.diagnostic.span is None and span is not None:
            self.diagnostic = replace(self.diagnostic, span=span)
        return self

    def called(self, text: Callable[[], str], span: Span | None) -> None:
        """Passed out of a call that is written at *span*; *text* says which, when asked.

        As in other languages' stacks, a line tells where its call had come to: the innermost to the mistake itself.
        """
        self.at(span)
        reached = self._reached if self._passed else self.diagnostic.span
        self._reached = span
        self._passed += 1
        if len(self._inner) < INNERMOST:
            self._inner.append((text, reached))
        else:
            self._outer.append((text, reached))

    def finished(self) -> ScriptError:
        """The error that leaves the evaluator, with the script's call stack as notes."""
        notes = [_note(text, span) for text, span in self._inner]
        hidden = self._passed - len(self._inner) - len(self._outer)
        if hidden:
            notes.append(f"... {hidden:,} more calls")
        notes.extend(_note(text, span) for text, span in self._outer)
        return ScriptError(self.diagnostic.with_notes(*notes))


def _note(text: Callable[[], str], span: Span | None) -> str:
    return f"in {text()}" if span is None else f"in {text()}, line {span.line}"
