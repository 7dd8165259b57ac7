"""From files to results: load a script, check its assertions, one after the other."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal, Protocol

from cspcheck.checker.verdict import Limits, Outcome, Verdict
from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.source import Source
from cspcheck.result import INTERRUPTED, Result, answer
from cspcheck.selection import STDIN

if TYPE_CHECKING:
    from cspcheck.checker.check import Checker
    from cspcheck.checker.search.exploration import Progress
    from cspcheck.cspm.script import Assertion, Script

STDIN_NAME = "<stdin>"
_NOT_SCRIPTS = (".pdf", ".json", ".xml", ".md", ".py")
MEMORY_SHARE = 0.8
"""The part of the machine's memory that the engine may use when nothing else is said."""


@dataclass(frozen=True, slots=True)
class Settings:
    """How scripts are loaded and checked.

    Attributes:
        limits: where a check gives up, each assertion on its own.
        workers: search threads; None: the machine's cores.
        full: explore the whole state space, without reductions.
        definitions: top-level constants of the script to override, as CSPm text.
        typecheck: whether types are checked before evaluation.
        view: classes with their ``data``, or in the ``control`` view without; None: as the script says.
        outputs: who chooses the outputs of classes: ``demonic`` (the class) or ``angelic`` (its environment).
        coverage: whether what never happens in a check that passes is looked for.
    """

    limits: Limits = field(default_factory=Limits)
    workers: int | None = None
    full: bool = False
    definitions: Mapping[str, str] = field(default_factory=dict)
    typecheck: bool = True
    view: Literal["data", "control"] | None = None
    outputs: Literal["demonic", "angelic"] = "demonic"
    coverage: bool = False


class Watch(Protocol):
    """Who is told how a check goes on."""

    def begin(self, what: str) -> None:
        """A check starts."""

    def progress(self, progress: Progress) -> None:
        """Where the search is; called a few times a second."""

    def notify(self, line: str) -> None:
        """Something that takes a while and happens once."""

    def done(self) -> None:
        """The check has ended."""


class NoWatch:
    """Nobody looks."""

    def begin(self, what: str) -> None:
        """Nothing."""

    def progress(self, progress: Progress) -> None:
        """Nothing."""

    def notify(self, line: str) -> None:
        """Nothing."""

    def done(self) -> None:
        """Nothing."""


def machine_memory() -> int | None:
    """Bytes of memory that this process may use: the machine's, or less where a control group says so."""
    try:
        size = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return None
    for path in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        try:
            with open(path, encoding="ascii") as file:
                size = min(size, int(file.read()))
        except (OSError, ValueError):
            continue
    return size


def default_memory_limit() -> int | None:
    """The memory limit where none is given: four fifths of the machine's memory; None where that is not known."""
    size = machine_memory()
    return None if size is None else int(size * MEMORY_SHARE)


def limits(states: int | None = None, seconds: float | None = None, memory_bytes: int | None = None) -> Limits:
    """Limits with the default for the memory."""
    return Limits(states, seconds, default_memory_limit() if memory_bytes is None else memory_bytes)


def read(path: str) -> Source:
    """The text of a script; ``-`` is standard input.

    Raises:
        ScriptError: there is no such file, it cannot be read, or it is not a script.
    """
    from cspcheck.cspm.parsing.reading import decode, read_source

    if path == STDIN:
        return decode(STDIN_NAME, sys.stdin.buffer.read())
    suffix = os.path.splitext(path)[1].lower()
    if suffix in _NOT_SCRIPTS:
        from cspcheck.messages import unknown_kind

        raise ScriptError(unknown_kind(path, suffix))
    return read_source(path)


def load(path: str, settings: Settings) -> Script:
    """A script, ready to be checked.

    Raises:
        ScriptError: it cannot be read, or there is an error in it.
    """
    from cspcheck.cspm import script
    from cspcheck.cspm.notation import Semantics

    return script.load(
        read(path),
        overrides=settings.definitions,
        typecheck=settings.typecheck,
        semantics=Semantics(settings.view, settings.outputs),
        recording=settings.coverage,
    )


def checker_for(script: Script, settings: Settings, watch: Watch) -> Checker:
    """A checker for the assertions of one script, which share their machines."""
    from cspcheck.checker.check import Checker

    return Checker(
        script,
        limits=settings.limits,
        workers=settings.workers,
        full=settings.full,
        progress=watch.progress,
        notify=watch.notify,
    )


def check(checker: Checker, assertion: Assertion, clock: Callable[[], float] = time.perf_counter) -> Result:
    """The answer to an assertion. What a script does wrong becomes the verdict ``error``, with its diagnostics."""
    start = clock()
    try:
        return answer(assertion, checker.check(assertion.node))
    except ScriptError as error:
        return unanswered(assertion, error.diagnostics, clock() - start)
    except MemoryError:
        return answer(assertion, _nothing(Verdict.UNKNOWN, "the machine is out of memory", clock() - start))


def covered(script: Script, checker: Checker, assertion: Assertion, result: Result) -> Result:
    """The result with what never happened in it, where its verdict is ``pass`` and the script was loaded for that."""
    if result.verdict is not Verdict.PASS:
        return result
    from cspcheck.coverage import coverage

    return replace(result, coverage=coverage(script, checker, assertion))


def unanswered(assertion: Assertion, diagnostics: Sequence[Diagnostic], seconds: float = 0.0) -> Result:
    """The result with the verdict ``error`` for an assertion that could not be checked."""
    return answer(assertion, _nothing(Verdict.ERROR, diagnostics[0].message, seconds), diagnostics)


def unreached(assertion: Assertion, progress: Progress | None = None, seconds: float = 0.0) -> Result:
    """The result for an assertion that a run was interrupted before, or in the middle of, with its *progress*."""
    if progress is None:
        return answer(assertion, _nothing(Verdict.UNKNOWN, INTERRUPTED, seconds))
    remark = f"{progress.states:,} states were explored, to depth {progress.depth:,}"
    outcome = Outcome(
        Verdict.UNKNOWN, INTERRUPTED, progress.states, 0, seconds, progress.memory_bytes, remarks=(remark,)
    )
    return answer(assertion, outcome)


def outline(path: str) -> tuple[Assertion, ...]:
    """The assertions of a script as its text has them, without loading it.

    Raises:
        ScriptError: it cannot be read.
    """
    from cspcheck.cspm.script import outline as assertions_of

    return assertions_of(read(path))


def _nothing(verdict: Verdict, reason: str, seconds: float) -> Outcome:
    return Outcome(verdict, reason, 0, 0, seconds, 0)
