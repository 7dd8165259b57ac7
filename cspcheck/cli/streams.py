"""Where output goes: standard streams that never break the run, and files that are written whole or not at all."""

from __future__ import annotations

import contextlib
import os
import stat
import sys
from types import TracebackType
from typing import Protocol, Self, TextIO

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.messages import cannot_write
from cspcheck.report.style import unobeyed


class Output(Protocol):
    """A place for the result."""

    stream: TextIO

    def write(self, text: str) -> None:
        """Add some text."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


def prepare_standard_streams() -> None:
    """Let characters that a stream cannot show come out as escapes instead of ending the program."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by the shell, as in `cspcheck x.csp >&-`
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 (open as long as the program runs)
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="backslashreplace")


def output_to(path: str | None) -> Output:
    """Standard output for None and ``-``; else the file at *path*, which is checked to be writable now.

    Raises:
        ScriptError: the file cannot be written.
    """
    if path is None or path == "-":
        return StandardOutput()
    try:
        mode = os.stat(path).st_mode
    except FileNotFoundError:
        mode = stat.S_IFREG
    except OSError as error:
        raise ScriptError(cannot_write(path, error.strerror or str(error))) from None
    try:
        return WholeFile(path) if stat.S_ISREG(mode) else Device(path)
    except OSError as error:
        raise ScriptError(cannot_write(path, error.strerror or str(error))) from None


class ReaderGone(BaseException):
    """Whoever read our output has left. Not an ``Exception``: nothing that is told of those can be told any more."""


class OutputLost(BaseException):
    """The result cannot be written (the disk is full, say). Not an ``Exception``: no mistake of a script or of ours.

    Attributes:
        diagnostic: says so.
    """

    def __init__(self, name: str, error: OSError) -> None:
        super().__init__(name)
        self.diagnostic = cannot_write(name, error.strerror or str(error))


STANDARD_OUTPUT = "standard output"


class StandardOutput:
    """Standard output, flushed with every piece so that it keeps its order with standard error."""

    def __init__(self) -> None:
        self.stream = sys.stdout

    def write(self, text: str) -> None:
        """Write some text at once.

        Raises:
            ReaderGone: nobody reads any more.
            OutputLost: it cannot be written.
        """
        try:
            self.stream.write(text)
            self.stream.flush()
        except BrokenPipeError:
            raise ReaderGone from None
        except OSError as error:
            raise OutputLost(STANDARD_OUTPUT, error) from None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Nothing: the stream is not ours to close."""


class Remarks:
    """Standard error, flushed with every piece. What nobody reads is dropped: it must not stop the work."""

    def __init__(self) -> None:
        self.stream = sys.stderr

    def write(self, text: str) -> None:
        """Write some text at once, if it can be written; no line of it is one that a build server obeys."""
        text = unobeyed(text)
        with contextlib.suppress(OSError, ValueError):
            self.stream.write(text)
            self.stream.flush()


class Device:
    """Something that is not a file (``/dev/null``, a pipe): written as it comes."""

    def __init__(self, path: str) -> None:
        self._path = path
        self.stream: TextIO = open(path, "w", encoding="utf-8", errors="backslashreplace")  # noqa: SIM115 (closed in __exit__)

    def write(self, text: str) -> None:
        """Write some text.

        Raises:
            ReaderGone: nobody reads any more.
            OutputLost: it cannot be written.
        """
        try:
            self.stream.write(text)
            self.stream.flush()
        except BrokenPipeError:
            raise ReaderGone from None
        except OSError as error:
            raise OutputLost(self._path, error) from None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        # What could not be written has been told; it is not tried again.
        with contextlib.suppress(OSError):
            self.stream.close()


class WholeFile:
    """A file that appears with all of its text when the block ends, and stays as it was if the block fails.

    The text goes to a new file beside it, which takes its place by renaming. A link is followed: the file that it
    points to is replaced, not the link.
    """

    def __init__(self, path: str, encoding: str = "utf-8") -> None:
        self._path = os.path.realpath(path)
        folder, name = os.path.split(self._path)
        if os.path.exists(self._path) and not os.access(self._path, os.W_OK):
            raise PermissionError(13, "Permission denied", path)
        import tempfile  # with its random numbers and archives too much for the help

        number, self._temporary = tempfile.mkstemp(prefix=f".{name}.", suffix=".tmp", dir=folder)
        self.stream: TextIO = os.fdopen(number, "w", encoding=encoding, errors="backslashreplace", newline="")

    def write(self, text: str) -> None:
        """Add some text.

        Raises:
            OutputLost: it cannot be written.
        """
        try:
            self.stream.write(text)
        except OSError as error:
            raise OutputLost(self._path, error) from None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None:
            self._drop()
            return
        try:
            self.stream.flush()
            os.fsync(self.stream.fileno())
            self.stream.close()
            os.chmod(self._temporary, _mode_for(self._path))
            os.replace(self._temporary, self._path)
        except OSError as lost:
            self._drop()
            raise OutputLost(self._path, lost) from None

    def _drop(self) -> None:
        """Leave nothing behind."""
        for end in (self.stream.close, lambda: os.unlink(self._temporary)):
            with contextlib.suppress(OSError):
                end()


def _mode_for(path: str) -> int:
    """The permissions of the file at *path*, or those that a new file gets."""
    try:
        return stat.S_IMODE(os.stat(path).st_mode)
    except OSError:
        mask = os.umask(0)
        os.umask(mask)
        return 0o666 & ~mask


def replace_text(path: str, text: str, encoding: str = "utf-8") -> None:
    """Write *text* to the file at *path*, whole or not at all.

    Raises:
        ScriptError: the file cannot be written.
    """
    try:
        with WholeFile(path, encoding) as file:
            file.write(text)
    except OutputLost as lost:
        raise ScriptError(lost.diagnostic) from None
    except OSError as error:
        raise ScriptError(cannot_write(path, error.strerror or str(error))) from None
