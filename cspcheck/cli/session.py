"""One run of the command over scripts: what is loaded and checked, where it is told, and what the exit code will be."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from cspcheck.cli.interrupt import Interrupts
from cspcheck.cli.progress import Heartbeat, ProgressLine
from cspcheck.cli.streams import Remarks
from cspcheck.cspm.diagnostics import Diagnostic, ScriptError, Severity
from cspcheck.failure import InternalErrors
from cspcheck.messages import empty_folder, no_assertions, nothing_selected
from cspcheck.report.style import ColorChoice, is_terminal, style_for
from cspcheck.result import Exit, Result, Summary, exit_of, worst
from cspcheck.selection import STDIN, AssertionPattern, EmptyFolder, Target, select

if TYPE_CHECKING:
    from cspcheck.checking import Settings
    from cspcheck.cspm.script import Assertion, Script
    from cspcheck.report import Report


class Session:
    """The scripts of one command, one after the other. A bad one does not keep the others from being checked."""

    def __init__(
        self,
        settings: Settings,
        report: Report,
        *,
        patterns: Sequence[AssertionPattern] = (),
        color: ColorChoice = "auto",
        verbosity: int = 0,
        label: str = "",
    ) -> None:
        self._label = f"{label}: " if label else ""
        self._settings = settings
        self._report = report
        self._patterns = patterns
        self._verbosity = verbosity
        self._remarks = Remarks()
        self._interrupts = Interrupts()
        self._style = style_for(sys.stderr, color)
        self.progress = ProgressLine(
            self._remarks.write,
            self._style,
            live=is_terminal(sys.stderr),
            quiet=verbosity < 0,
            poll=self._interrupts.poll,
        )
        self.summary = Summary.empty()
        self._start = time.perf_counter()
        self._codes: list[Exit] = []
        self._opened: Target | None = None
        self._missed: list[Result] = []
        self._internal_errors = InternalErrors(sys.argv[1:], verbose=verbosity > 0)

    def check(self, targets: Iterable[Target | EmptyFolder]) -> Exit:
        """Check the selected assertions of all targets."""
        selected = 0
        missed: list[tuple[Target, Script]] = []

        def check_one(target: Target) -> None:
            nonlocal selected
            script = self._load(target)
            if script is None:
                return
            chosen = select(script.assertions, target.lines, self._patterns)
            selected += len(chosen)
            self._opened = target
            if not chosen:
                missed.append((target, script))
                return
            self._report.script(script.source.name, script.printed)
            self._check(script, chosen)

        interrupted, left = self._each(targets, check_one)
        if interrupted:
            self._tell_unreached(left)
        else:
            self._explain_missed(missed, selected)
            if not selected:
                self._codes.append(Exit.NOTHING)
        return self._end(interrupted)

    def typecheck(self, targets: Iterable[Target | EmptyFolder]) -> Exit:
        """Load all targets and say what is wrong with them, without checking an assertion."""

        def load_one(target: Target) -> None:
            script = self._load(target)
            if script is not None:
                self._report.script(script.source.name)

        return self._end(self._each(targets, load_one)[0])

    def say(self, diagnostics: Sequence[Diagnostic]) -> None:
        """Diagnostics, into the report if it carries them, else to standard error. Warnings are not for the quiet."""
        if self._verbosity < 0:
            diagnostics = [d for d in diagnostics if d.severity is Severity.ERROR]
        if not diagnostics:
            return
        self.summary.errors += sum(d.severity is Severity.ERROR for d in diagnostics)
        self._report.diagnostics(diagnostics)
        if not self._report.carries_diagnostics:
            self._remark(diagnostics)

    def _remark(self, diagnostics: Sequence[Diagnostic]) -> None:
        """Diagnostics to standard error."""
        from cspcheck.report.diagnostics import render_diagnostics

        self.progress.erase()
        self._remarks.write(render_diagnostics(diagnostics, self._style))

    def _each(
        self, targets: Iterable[Target | EmptyFolder], do: Callable[[Target], None]
    ) -> tuple[bool, list[Target | EmptyFolder]]:
        """Do something with each target; whether it was interrupted, and the targets from that one on."""
        listed = list(targets)
        position = 0
        try:
            with self._interrupts, Heartbeat(self.progress.beat):
                for position, target in enumerate(listed):  # noqa: B007
                    self._interrupts.poll()
                    if isinstance(target, EmptyFolder):
                        self.say([empty_folder(target.path)])
                        continue
                    try:
                        do(target)
                    except Exception as error:
                        self._codes.append(Exit.INTERNAL)
                        self.summary.add_broken_script()
                        self.say([self._internal_errors.report(error, f"reading `{target.path}`")])
        except KeyboardInterrupt:
            self.progress.erase()
            return True, listed[position:]
        return False, []

    def _load(self, target: Target) -> Script | None:
        from cspcheck.checking import load

        self.progress.begin(f"{self._label}reading {target.path}")
        try:
            script = load(target.path, self._settings)
        except ScriptError as error:
            self.summary.add_broken_script()
            self._codes.append(Exit.NOT_RUN)
            self.say(error.diagnostics)
            return None
        finally:
            self.progress.done()
        self.say(script.warnings)
        return script

    def _check(self, script: Script, assertions: Sequence[Assertion]) -> None:
        from cspcheck.checking import check, checker_for, covered, drawn, unanswered, unreached

        try:
            checker = checker_for(script, self._settings, self.progress)
        except ScriptError as error:
            self.summary.add_broken_script()
            self._codes.append(Exit.NOT_RUN)
            self.say(error.diagnostics)
            return
        for position, assertion in enumerate(assertions):
            started = time.perf_counter()
            try:
                self._interrupts.poll()
                self.progress.begin(self._label + assertion.text)
                try:
                    result = check(checker, assertion)
                    if self._settings.coverage:
                        result = covered(checker, assertion, result)
                    if self._settings.machines:
                        result = drawn(script, result)
                    code = exit_of(result)
                except Exception as error:
                    report = self._internal_errors.report(error, f"checking `{assertion.text}`")
                    result, code = unanswered(assertion, [report]), Exit.INTERNAL
                finally:
                    self.progress.done()
            except KeyboardInterrupt:
                here = unreached(assertion, self.progress.latest, time.perf_counter() - started)
                self._take(here, Exit.INTERRUPTED)
                self._missed = [unreached(other) for other in assertions[position + 1 :]]
                raise
            with self._interrupts.held():
                self._missed = [unreached(other) for other in assertions[position + 1 :]]
                self._take(result, code)

    def _tell_unreached(self, targets: Sequence[Target | EmptyFolder]) -> None:
        """Tell the assertions that an interrupted run has not come to: those of *targets*, the first maybe in part.

        Scripts that were not opened are only parsed for it; a second interrupt is enough of that.
        """
        from cspcheck.checking import outline, unreached

        missed = self._missed
        with suppress(KeyboardInterrupt):
            for target in targets:
                if isinstance(target, EmptyFolder) or target is self._opened or target.path == STDIN:
                    continue
                try:
                    chosen = select(outline(target.path), target.lines, self._patterns)
                except (ScriptError, RecursionError):
                    continue  # which is told when it is checked
                missed.extend(map(unreached, chosen))
        for result in missed:
            self.summary.add(result)
        self._report.unreached(missed)

    def _take(self, result: Result, code: Exit) -> None:
        self.summary.add(result)
        self.summary.errors += sum(d.severity is Severity.ERROR for d in result.diagnostics)
        self._codes.append(code)
        self._report.result(result)
        if result.diagnostics and not self._report.carries_diagnostics:
            self._remark(result.diagnostics)

    def _explain_missed(self, missed: Sequence[tuple[Target, Script]], selected: int) -> None:
        """Say why scripts that the user named had nothing to check."""
        for target, script in missed:
            if not script.assertions:
                if target.named:
                    self.say([no_assertions(script.source.name)])
            elif not selected or target.lines is not None:
                places = [f"{script.source.name}:{line}" for line in sorted(target.lines or ())]
                texts = [f"{a.span.source.name}:{a.span.line}: {a.text}" for a in script.assertions]
                self.say([nothing_selected([*places, *(p.text for p in self._patterns)], texts)])

    def _end(self, interrupted: bool) -> Exit:
        self.summary.seconds = time.perf_counter() - self._start
        self._report.end(self.summary, interrupted=interrupted)
        return Exit.INTERRUPTED if interrupted else worst(self._codes)
