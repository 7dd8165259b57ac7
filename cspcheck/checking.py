"""From files to results: load a script, check its assertions, one after the other."""

from __future__ import annotations

import gc
import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Protocol

from cspcheck.checker.budget import OUT_OF_MEMORY, why
from cspcheck.checker.guard import Guard, machine_memory
from cspcheck.checker.verdict import Limits, Outcome, Termination, Verdict
from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.interruption import Stopped
from cspcheck.cspm.source import Source
from cspcheck.messages import cannot_write, too_much_to_read, unsuited_checkpoint
from cspcheck.result import INTERRUPTED, Result, answer
from cspcheck.selection import STDIN

if TYPE_CHECKING:
    from cspcheck.checker.check import Checker
    from cspcheck.checker.lts import Lts
    from cspcheck.checker.search.beyond import Beyond
    from cspcheck.checker.search.checkpoint import Checkpoints
    from cspcheck.checker.search.exploration import Progress
    from cspcheck.coverage import Coverage
    from cspcheck.cspm.process.terms import Process
    from cspcheck.cspm.script import Assertion, Script
    from cspcheck.cspm.syntax import tree as syntax

SMALL = 30
"""The states of a machine that is drawn beside its verdict."""
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
        as_written: only the reductions that the script itself asks for.
        termination: what a process that has terminated is to ``deadlock free``: a ``success``, or a ``deadlock``.
        definitions: top-level constants of the script to override, as CSPm text.
        typecheck: whether types are checked before evaluation.
        view: classes with their ``data``, or in the ``control`` view without; None: as the script says.
        outputs: who chooses the outputs of classes: ``demonic`` (the class) or ``angelic`` (its environment).
        include_roots: folders, beside that of each script, from below which files may be included.
        checkpoint: the folder in which long searches are written down; None: nowhere.
        resume: whether to go on from what that folder has.
        spill: the folder in which searches go on that are larger than memory; None: nowhere.
        cluster: whether the processes that ``mpiexec`` has started search together.
        coverage: whether what never happens in a check that passes is looked for.
        machines: whether results have pictures of machines that are small.
    """

    limits: Limits = field(default_factory=Limits)
    workers: int | None = None
    full: bool = False
    as_written: bool = False
    termination: Termination = "success"
    definitions: Mapping[str, str] = field(default_factory=dict)
    typecheck: bool = True
    view: Literal["data", "control"] | None = None
    outputs: Literal["demonic", "angelic"] = "demonic"
    include_roots: tuple[str, ...] = ()
    checkpoint: str | None = None
    resume: bool = False
    spill: str | None = None
    cluster: bool = False
    coverage: bool = False
    machines: bool = False


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


def default_memory_limit() -> int | None:
    """The memory limit where none is given: four fifths of the machine's memory; None where that is not known.

    Should others need so much of it that none is left, the check that has the most in hand ends all the same.
    """
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
    from cspcheck.cspm.notation import ClassReading

    settle()
    guard = Guard(settings.limits.seconds, settings.limits.memory_bytes)
    try:
        with guard:
            return script.load(
                read(path),
                overrides=settings.definitions,
                typecheck=settings.typecheck,
                semantics=ClassReading(settings.view, settings.outputs),
                include_roots=settings.include_roots,
                recording=settings.coverage,
            )
    except Stopped as stopped:
        raise ScriptError(too_much_to_read(path, why(guard, settings.limits, stopped))) from None
    except MemoryError:
        raise ScriptError(too_much_to_read(path, OUT_OF_MEMORY)) from None


class GuardedChecker:
    """A checker whose limits hold whatever it is doing. Create with :func:`checker_for`.

    A check that had to be stopped in the midst of something leaves nothing behind: for the next one the script is
    loaded anew.
    """

    def __init__(self, script: Script, settings: Settings, watch: Watch) -> None:
        # Imported here: on a busy machine that takes a while, which is none of an assertion's time.
        from cspcheck.checker.check import Checker

        self._checker_class = Checker
        self._script = script
        self._own = script
        self._settings = settings
        self._watch = watch
        self._checker: Checker | None = None
        self._checkpoints = _checkpoints(script, settings, watch)
        self._beyond = _beyond(settings)
        self._used = False

    def check(self, assertion: syntax.Assertion) -> Outcome:
        """The answer to an assertion of the script.

        Raises:
            ScriptError: what the assertion speaks of cannot be evaluated.
        """
        settle()
        limits = self._settings.limits
        guard = Guard(limits.seconds, limits.memory_bytes)
        start = time.perf_counter()
        try:
            with guard:
                return self._ready().check(self._here(assertion))
        except Stopped as stopped:
            reason = why(guard, limits, stopped)
        except MemoryError:
            reason = OUT_OF_MEMORY
        seconds = time.perf_counter() - start
        sure = None if self._checker is None else self._checker.ended(self._here(assertion), reason)
        self._given_up()
        return _nothing(Verdict.UNKNOWN, reason, seconds) if sure is None else replace(sure, seconds=seconds)

    def coverage(self, assertion: Assertion) -> Coverage | None:
        """What never happened in a check that passed; None where that takes more than the limits allow."""
        from cspcheck.coverage import coverage

        settle()
        try:
            with Guard(self._settings.limits.seconds, self._settings.limits.memory_bytes):
                return coverage(self._own, self._ready(), replace(assertion, node=self._here(assertion.node)))
        except (Stopped, MemoryError):
            self._given_up()
            return None

    def lts(self, process: Process) -> Lts:
        """The explicit machine of a process: see :meth:`cspcheck.checker.check.Checker.lts`.

        Raises:
            Incomplete: a limit was reached.
            ScriptError: a definition cannot be evaluated.
        """
        from cspcheck.checker.budget import Incomplete

        settle()
        guard = Guard(self._settings.limits.seconds, self._settings.limits.memory_bytes)
        try:
            with guard:
                return self._ready().lts(process)
        except Stopped as stopped:
            reason = why(guard, self._settings.limits, stopped)
        except MemoryError:
            reason = OUT_OF_MEMORY
        self._given_up()
        raise Incomplete(reason)

    def _given_up(self) -> None:
        """Leave what was half done behind."""
        self._checker = None
        _Debt.memory = True

    def _ready(self) -> Checker:
        if self._checker is None:
            if self._own is not self._script or self._used:
                self._own = self._script.again()
            self._used = True
            self._checker = self._checker_class(
                self._own,
                limits=self._settings.limits,
                workers=self._settings.workers,
                full=self._settings.full,
                as_written=self._settings.as_written,
                termination=self._settings.termination,
                progress=self._watch.progress,
                notify=self._watch.notify,
                checkpoints=self._checkpoints,
                beyond=self._beyond,
            )
        return self._checker

    def _here(self, assertion: syntax.Assertion) -> syntax.Assertion:
        """The same assertion in the script as it is loaded now."""
        if self._own is self._script:
            return assertion
        for old, new in zip(self._script.assertions, self._own.assertions, strict=True):
            if old.node is assertion:
                return new.node
        from cspcheck.cspm.printing.printer import print_assertion

        return self._own.assertion(print_assertion(assertion)).node


def _checkpoints(script: Script, settings: Settings, watch: Watch) -> Checkpoints | None:
    """Where the searches for a script are written down.

    Raises:
        ScriptError: the folder is one of something else, or cannot be written.
    """
    if settings.checkpoint is None:
        return None
    from cspcheck import __version__
    from cspcheck.checker.search.checkpoint import Checkpoints, Mismatch

    # One folder for each script: a run may be about several.
    folder = Path(settings.checkpoint) / sha256(script.source.name.encode()).hexdigest()[:16]
    belongs = {
        "version": __version__,
        "script": script_digest(script),
        "set of options": repr((sorted(settings.definitions.items()), settings.full, settings.view, settings.outputs)),
    }
    try:
        return Checkpoints(folder, belongs, resume=settings.resume, tell=watch.notify)
    except Mismatch as mismatch:
        raise ScriptError(unsuited_checkpoint(settings.checkpoint, script.source.name, str(mismatch))) from None
    except OSError as error:
        raise ScriptError(cannot_write(settings.checkpoint, error.strerror or str(error))) from None


def _beyond(settings: Settings) -> Beyond | None:
    """Where searches go on, or are done, that may be too large for this process.

    Raises:
        ScriptError: the folder cannot be written.
    """
    if settings.cluster:
        from cspcheck.checker.search.cluster import world

        return world()
    if settings.spill is None:
        return None
    from cspcheck.checker.search.spill import Spill

    try:
        return Spill(Path(settings.spill))
    except OSError as error:
        raise ScriptError(cannot_write(settings.spill, error.strerror or str(error))) from None


def script_digest(script: Script) -> str:
    """What tells texts apart: of a script with all that it includes."""
    digest = sha256()
    sources: dict[int, Source] = {id(script.source): script.source}
    waiting: list[syntax.Declaration] = list(script.tree.declarations)
    while waiting:
        declaration = waiting.pop()
        sources.setdefault(id(declaration.span.source), declaration.span.source)
        waiting += getattr(declaration, "declarations", ())
    for text in sorted(source.text for source in sources.values()):
        digest.update(sha256(text.encode("utf-8", "surrogatepass")).digest())
    return digest.hexdigest()


class _Debt:
    """Whether a check was given up whose memory has not been given back yet.

    A million terms are taken apart in seconds. Nobody waits for that who only wants to hear that a limit was reached:
    it is done before the next check begins, if there is one.
    """

    memory = False


def settle() -> None:
    """Give back what checks that were given up have left in memory, before something else needs it."""
    if _Debt.memory:
        _Debt.memory = False
        release_memory()


def release_memory() -> None:
    """Give memory that nobody uses any more back to the system, as far as it takes it."""
    gc.collect()
    try:
        import ctypes

        ctypes.CDLL(None).malloc_trim(0)
    except (OSError, AttributeError, TypeError):  # a C library that has no such function
        pass


def checker_for(script: Script, settings: Settings, watch: Watch) -> GuardedChecker:
    """A checker for the assertions of one script, which share their machines."""
    return GuardedChecker(script, settings, watch)


def check(checker: GuardedChecker, assertion: Assertion, clock: Callable[[], float] = time.perf_counter) -> Result:
    """The answer to an assertion. What a script does wrong becomes the verdict ``error``, with its diagnostics."""
    start = clock()
    try:
        return answer(assertion, checker.check(assertion.node))
    except ScriptError as error:
        return unanswered(assertion, error.diagnostics, clock() - start)
    except MemoryError:
        return answer(assertion, _nothing(Verdict.UNKNOWN, OUT_OF_MEMORY, clock() - start))


def covered(checker: GuardedChecker, assertion: Assertion, result: Result) -> Result:
    """The result with what never happened in it, where its verdict is ``pass`` and the script was loaded for that."""
    if result.verdict is not Verdict.PASS:
        return result
    return replace(result, coverage=checker.coverage(assertion))


def drawn(script: Script, result: Result) -> Result:
    """The result with a picture of the machine of its process, if that has no more than ``SMALL`` states."""
    if not result.process or not 0 < result.states <= SMALL:
        return result
    from cspcheck.drawing import parts, svg

    try:
        picture = parts.machine(result.process, script.process(result.process), script.events, SMALL)
    except ScriptError:
        return result
    return replace(result, machine=svg.render(picture))


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
