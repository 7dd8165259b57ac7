"""FDR4's Python names, for programs that were written for its API: ``from cspcheck import fdr``.

A session loads one file and has its assertions, which are executed and then say whether they passed and what
counterexamples there are. What FDR4 has for walking about in its own data structures (``DebugContext``, machines,
compiled events) is not there: a counterexample is a :class:`cspcheck.Counterexample`, with its texts at hand.

A process that has terminated is a deadlock to ``deadlock free``, as it is in FDR4.
"""

from __future__ import annotations

import os
from typing import Any

import cspcheck
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.result import Result


class Error(Exception):
    """A request that cannot be met; the message says why."""


class FileLoadError(Error):
    """A file cannot be read, or there is an error in it."""


class InputFileError(Error):
    """An expression, or an assertion, has an error in it, or its evaluation has met one."""


def library_init() -> None:
    """Nothing: there is no library to be prepared."""


def library_exit() -> None:
    """Nothing."""


def version() -> str:
    """The version of cspcheck."""
    return cspcheck.__version__


class Assertion:
    """One assertion of a session. FDR4 gives each kind a class of its own; here the text tells them apart."""

    def __init__(self, script: cspcheck.Script, text: str) -> None:
        self._script = script
        self._text = text
        self._result: Result | None = None

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"<cspcheck.fdr.Assertion {self._text!r}>"

    def to_string(self) -> str:
        """The text of the assertion, without the word ``assert``."""
        return self._text

    def execute(self, canceller: object = None) -> None:
        """Check the assertion. *canceller* is not looked at: Ctrl-C ends a check.

        Raises:
            InputFileError: what it speaks of cannot be evaluated.
            Error: a limit was reached, so that it neither passes nor fails.
        """
        try:
            result = self._script.check(self._text, termination="deadlock")
        except ScriptError as error:
            raise InputFileError(str(error)) from None
        self._result = result
        if result.verdict == "error":
            raise InputFileError(result.reason or self._text)
        if result.verdict == "unknown":
            raise Error(result.reason or self._text)

    def passed(self) -> bool:
        """Whether it holds.

        Raises:
            Error: it has not been executed.
        """
        return self.result.verdict == "pass"

    def counterexamples(self) -> list[cspcheck.Counterexample]:
        """Why it does not hold: one counterexample, or none.

        Raises:
            Error: it has not been executed.
        """
        found = self.result.counterexample
        return [] if found is None else [found]

    @property
    def result(self) -> Result:
        """All that is known of it.

        Raises:
            Error: it has not been executed.
        """
        if self._result is None:
            raise Error(f"`{self._text}` has not been executed")
        return self._result


class Session:
    """A file that is loaded, and what can be asked of it."""

    def __init__(self) -> None:
        self._script: cspcheck.Script | None = None

    def load_file(self, path: str | os.PathLike[str]) -> None:
        """Load a script, in the place of one that was loaded before.

        Raises:
            FileLoadError: it cannot be read, or there is an error in it.
        """
        try:
            self._script = cspcheck.load(path)
        except ScriptError as error:
            raise FileLoadError(str(error)) from None

    def assertions(self) -> list[Assertion]:
        """The assertions of the file, in its order.

        Raises:
            Error: no file is loaded.
        """
        script = self._loaded()
        return [Assertion(script, text) for text in script.assertions]

    def parse_assertion(self, text: str) -> Assertion:
        """An assertion about what the file defines; what is wrong with it is told when it is executed.

        Raises:
            Error: no file is loaded.
        """
        return Assertion(self._loaded(), text.removeprefix("assert ").strip())

    def evaluate_expression(self, text: str, canceller: object = None) -> Any:
        """The value of an expression, as a Python value; FDR4 gives its text.

        Raises:
            Error: no file is loaded.
            InputFileError: it has no value.
        """
        try:
            return self._loaded().evaluate(text)
        except ScriptError as error:
            raise InputFileError(str(error)) from None

    def print_statements(self) -> list[str]:
        """What the ``print`` lines of the file say.

        Raises:
            Error: no file is loaded.
        """
        return list(self._loaded().printed)

    def _loaded(self) -> cspcheck.Script:
        if self._script is None:
            raise Error("no file is loaded")
        return self._script
