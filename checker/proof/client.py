"""Asking the solver, which is a process of its own: it can be ended, and is started again when it is needed.

How long a question may take is counted in the solver's own steps, so an answer does not depend on how busy the machine
is. Time counts where a user has set a limit, and where the solver does not come back at all.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

from cspcheck.checker.guard import machine_memory
from cspcheck.checker.proof.channel import ForeignValue, Incoming, Sources, TooDeep, framed, packed, unpacked
from cspcheck.checker.proof.definedness import Definedness
from cspcheck.checker.proof.kept import KeptAnswers
from cspcheck.checker.proof.question import (
    Answer,
    Constraint,
    Failed,
    Horn,
    Impossible,
    Question,
    Request,
    Solution,
    SolverSettings,
    Unanswered,
)
from cspcheck.checker.proof.terms import is_false
from cspcheck.cspm.interruption import during
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Term
from cspcheck.cspm.recursion import USUAL_STACK

T = TypeVar("T")

NO_ANSWER = "the solver did not answer"
CRASHED = "the solver crashed"
PATIENCE = 0.2
"""Seconds that the solver may take beyond a user's limit to come back by itself."""
OVERWORK = 5
"""The solver is ended when it has worked so many times as long as it should have taken; it has lost count then."""
LEAST = 10.0
"""Seconds of the processor's time that the solver may always have."""
IDLE = 600.0
"""Seconds after which a solver is ended that neither works nor answers."""
MOST_SUBJECTS = 100
"""A process that has been told of so many classes gives way to a new one."""
MOST_LOST = 2
"""An obligation is given up when the solver has lost count of its steps in so many of its questions."""
_LOOK = 0.05


class SolverGone(Exception):
    """The solver has not answered; the message says why, as a reason for ``unknown``."""


class LostCount(SolverGone):
    """The solver has worked far longer than it should have, by its own steps."""


class SolverProcess:
    """The process of the solver; started when it is first asked something."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._owner = 0
        self._sources = Sources()
        self._subjects: dict[tuple[int, int], tuple[int, object, object]] = {}

    def ask(self, request: Request, subject: tuple[Any, Any], seconds: float | None, overwork: float = OVERWORK) -> Any:
        """What the solver answers.

        Args:
            request: without its subject.
            subject: the specification and the class that it is about.
            seconds: when to give up, whatever the solver is doing; None: when it has worked far too long.
            overwork: how many times as long as it should take it may work.

        Raises:
            SolverGone: it has been ended, or has ended by itself.
        """
        if len(self._subjects) >= MOST_SUBJECTS:
            self.end()
        process = self._running()
        key = (id(subject[0]), id(subject[1]))
        if key not in self._subjects:
            self._subjects[key] = (len(self._subjects), *subject)
            request.specification, request.model = subject
        request.subject = self._subjects[key][0]
        try:
            content = packed(request, self._sources)
        except TooDeep:
            self.end()
            raise SolverGone("the question is nested too deeply") from None
        try:
            with during("waiting for the solver"):
                reply = self._exchanged(process, framed(content), max(LEAST, overwork * request.seconds), seconds)
            answer = unpacked(reply, self._sources)
        except ForeignValue:
            self.end()
            raise SolverGone(CRASHED) from None
        except BaseException:
            self.end()
            raise
        if isinstance(answer, Failed):
            if answer.ours:
                raise RuntimeError(f"in the process of the solver:\n{answer.reason}")
            raise SolverGone(answer.reason)
        return answer

    def end(self) -> None:
        """End the process, whatever it is doing. The next question starts another."""
        process, self._process = self._process, None
        self._sources, self._subjects = Sources(), {}
        if process is not None and self._owner == os.getpid():
            process.kill()
            for stream in (process.stdin, process.stdout):
                if stream is not None:
                    with contextlib.suppress(OSError):  # what was not read yet goes nowhere
                        stream.close()
            process.wait()

    def _running(self) -> subprocess.Popen[bytes]:
        if self._process is None or self._owner != os.getpid() or self._process.poll() is not None:
            self.end()
            self._owner = os.getpid()
            self._process = subprocess.Popen(
                [sys.executable, "-c", f"from cspcheck.checker.proof.worker import serve; serve({_own_number()})"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                bufsize=0,
                # An interrupt at the terminal is ours alone: it is we who end the solver.
                start_new_session=True,
                preexec_fn=_bounded if hasattr(os, "fork") else None,
            )
        return self._process

    def _exchanged(self, process: subprocess.Popen[bytes], content: bytes, most: float, seconds: float | None) -> bytes:
        """Send a request and wait for its answer; the solver may work *most* seconds."""
        assert process.stdin is not None
        assert process.stdout is not None
        started = time.monotonic()
        worked = _processor_seconds(process.pid)
        incoming = Incoming()
        view = memoryview(content)
        with selectors.DefaultSelector() as selector:
            selector.register(process.stdout, selectors.EVENT_READ)
            selector.register(process.stdin, selectors.EVENT_WRITE)
            os.set_blocking(process.stdin.fileno(), False)
            while True:
                for key, _ in selector.select(_LOOK):
                    if key.fileobj is process.stdin:
                        try:
                            view = view[os.write(process.stdin.fileno(), view[:65536]) :]
                        except BlockingIOError:
                            continue
                        except OSError:
                            raise SolverGone(CRASHED) from None
                        if not view:
                            selector.unregister(process.stdin)
                    else:
                        some = os.read(process.stdout.fileno(), 1 << 16)
                        if not some:
                            raise SolverGone(_ended(process))
                        whole = incoming.add(some)
                        if whole is not None:
                            return whole
                passed = time.monotonic() - started
                if seconds is not None and passed > seconds + PATIENCE:
                    raise SolverGone(f"{NO_ANSWER} within {seconds:.3g} s")
                now = _processor_seconds(process.pid)
                if now is None or worked is None:
                    if passed > IDLE:
                        raise SolverGone(NO_ANSWER)
                elif now - worked > most:
                    raise LostCount(NO_ANSWER)
                elif passed > IDLE + 100 * (now - worked):
                    raise SolverGone(NO_ANSWER)


def _halved(effort: float, most: float) -> float:
    """Where time counts, the solver should come back by itself before it is up, after one of a few efforts.

    The next run, which is not as far at the same moment, asks the same then.
    """
    while effort > most and effort > 0.01:
        effort /= 2
    return effort


def _own_number() -> int | None:
    """This process's number, where those that it starts see when it has ended."""
    return os.getpid() if hasattr(os, "fork") else None


def _ended(process: subprocess.Popen[bytes]) -> str:
    try:
        code = process.wait(1.0)
    except subprocess.TimeoutExpired:
        return CRASHED
    if code < 0:
        try:
            return f"{CRASHED} ({signal.Signals(-code).name})"
        except ValueError:
            pass
    return CRASHED


def _bounded() -> None:
    """Let the process of the solver have half of the machine's memory. Called in it before it begins."""
    import resource

    if USUAL_STACK is not None:  # its threads would take as much each
        resource.setrlimit(resource.RLIMIT_STACK, USUAL_STACK)
    size = machine_memory()
    if size is not None:
        resource.setrlimit(resource.RLIMIT_DATA, (size // 2, size // 2))


def _processor_seconds(process: int) -> float | None:
    """How long a process has worked; None where the system does not tell."""
    try:
        with open(f"/proc/{process}/stat", encoding="ascii", errors="replace") as file:
            fields = file.read().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    except (OSError, ValueError, IndexError):
        return None


_shared = SolverProcess()
atexit.register(_shared.end)


class SolverClient:
    """Answers questions about one specification.

    Args:
        specification: that the questions are about.
        model: the class whose constants they may speak of.
        settings: how hard to try.
        clock: tells the seconds.
        process: of the solver; by default the one that all share.
    """

    def __init__(
        self,
        specification: core.Specification,
        model: core.ClassModel | None = None,
        settings: SolverSettings | None = None,
        clock: Callable[[], float] = time.monotonic,
        process: SolverProcess | None = None,
    ) -> None:
        self.specification = specification
        self.model = model
        self.settings = settings or SolverSettings()
        self.definedness = Definedness(specification.frees)
        self.name = "query"
        """What queries are called when they are written out."""
        self._clock = clock
        self._process = process or _shared
        self._begun: float | None = None
        self._lost = 0
        self._kept = KeptAnswers(specification, model) if self.settings.smtlib is None else None

    def begin(self) -> None:
        """Another obligation begins: its time counts from now, and the solver has not lost itself in it yet.

        Without this, each question has the time that an obligation may take.
        """
        self._begun = self._clock()
        self._lost = 0

    def one_after_another(self, findings: Iterable[T]) -> Iterator[T]:
        """Findings that are made when they are asked for, each an obligation with a time of its own."""
        self.begin()
        for finding in findings:
            yield finding
            self.begin()

    @property
    def is_late(self) -> bool:
        """Whether nothing more can be asked for this obligation."""
        left = self._left()
        return self._lost >= MOST_LOST or (left is not None and left <= 0)

    def ask(self, question: Question) -> Answer:
        """Whether there are values that satisfy all parts of a question."""
        if any(is_false(part.term) for part in question.parts):
            return Impossible()
        answer: Answer = self._answer("ask", question, question.parts)
        return answer

    def conflict(self, parts: Iterable[Constraint]) -> tuple[Constraint, ...]:
        """A smallest set of parts that cannot hold together, of parts that cannot.

        Parts without a line of their own are left out of the result, and removed last. Where the solver does not
        answer, all parts.
        """
        parts = tuple(parts)
        answer = self._answer("conflict", parts, parts)
        return parts if isinstance(answer, Unanswered) else answer

    def core(self, parts: Iterable[Constraint]) -> tuple[Constraint, ...]:
        """Parts that cannot hold together already, of parts that cannot; all of them where the solver cannot tell."""
        parts = tuple(parts)
        answer = self._answer("core", parts, parts)
        return parts if isinstance(answer, Unanswered) else answer

    def needed(self, question: Question) -> tuple[Constraint, ...] | None:
        """Parts of a question that has no answer that have none already; None where the solver cannot tell."""
        answer = self._answer("needed", question, question.parts)
        return None if isinstance(answer, Unanswered) else answer

    def eliminate(self, term: Term, seconds: float) -> Term | None:
        """A term that says the same without quantifiers; None where the solver cannot tell."""
        answer = self._answer("eliminate", term, (), seconds)
        return None if isinstance(answer, Unanswered) else answer

    def solve(self, horn: Horn, seconds: float) -> Solution | None:
        """Predicates that are said to satisfy clauses; None where none are found."""
        answer = self._answer("solve", horn, (), seconds)
        return None if isinstance(answer, Unanswered) else answer

    def _answer(self, verb: str, what: Any, parts: tuple[Constraint, ...], effort: float | None = None) -> Any:
        settings = self.settings
        effort = settings.seconds if effort is None else effort
        left = self._left()
        if left is not None and left <= 0:
            return Unanswered("the time limit was reached")
        if self._lost >= MOST_LOST:
            return Unanswered(NO_ANSWER)
        request = Request(
            verb,
            what,
            effort if left is None else _halved(effort, 0.5 * left),
            settings.scopes,
            settings.seed,
            name=self.name,
            smtlib=settings.smtlib is not None,
            first_query=len(settings.smtlib or ()),
        )
        keys = None if self._kept is None else self._kept.keys(request)
        if self._kept is not None and keys is not None:
            found = self._kept.find(keys, parts)
            if found is not None:
                return found.value
        try:
            overwork = 1 if self._lost else OVERWORK
            answer, texts = self._process.ask(request, (self.specification, self.model), left, overwork)
        except LostCount as lost:
            self._lost += 1
            return Unanswered(str(lost))
        except SolverGone as gone:
            return Unanswered(str(gone))
        if settings.smtlib is not None and texts:
            settings.smtlib.extend(texts)
        if self._kept is not None and keys is not None and answer is not None:
            self._kept.keep(keys, answer, parts)
        return answer

    def _left(self) -> float | None:
        """The time that a user's limits leave for a question; None: there are none."""
        limits = []
        if self.settings.limit is not None:
            limits.append(self.settings.limit - (0 if self._begun is None else self._clock() - self._begun))
        if self.settings.deadline is not None:
            limits.append(self.settings.deadline - self._clock())
        return min(limits, default=None)
