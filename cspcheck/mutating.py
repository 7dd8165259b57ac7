"""Checking the mutants of scripts: which changes does some assertion notice?"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from hashlib import sha256
from typing import TYPE_CHECKING, Literal

from cspcheck import checking
from cspcheck.checker.verdict import Verdict
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.parsing.reading import parse
from cspcheck.equivalence import MOST_STATES, Version, equivalent, subjects
from cspcheck.mutation import Change, Reach, mutants
from cspcheck.selection import AssertionPattern, select

if TYPE_CHECKING:
    from cspcheck.cspm.script import Assertion, Script
    from cspcheck.cspm.syntax import tree as syntax

Fate = Literal["noticed", "unnoticed", "equivalent", "undecided", "invalid"]
SLOWER = 10.0
"""An assertion may take so many times as long as it took before the change, and ``LEAST`` seconds in any case."""
LEAST = 5.0
PROOF = 4.0
LONGEST_PROOF = 20.0
"""Seconds for each question whether the predicates of two versions say the same: of the solver's work, and of time."""
GIVEN_UP = 3
"""After so many assertions that are not decided the others of a mutant are not asked."""


@dataclass(frozen=True, slots=True)
class Mutant:
    """What came of one change.

    Attributes:
        change: what is different.
        fate: ``noticed`` if the verdict of some assertion is another one; ``equivalent`` if none is, and it is shown
            that nothing that they speak of is another one; ``unnoticed`` if all verdicts are the same otherwise;
            ``undecided`` if none differs as far as limits allow to tell; ``invalid`` if it is no script any more.
        by: the assertion that noticed it.
    """

    change: Change
    fate: Fate
    by: str | None = None


class NothingToNotice(Exception):
    """There is no assertion to notice anything; or none of those meant is decided."""


class _Judge:
    """One script, and the assertions of it that are asked about its mutants.

    Raises:
        ScriptError: the script itself is wrong, or an assertion of it cannot be evaluated.
    """

    def __init__(
        self,
        path: str,
        settings: checking.Settings,
        lines: frozenset[int] | None,
        patterns: Sequence[AssertionPattern],
        watch: checking.Watch,
    ) -> None:
        self.tree = parse(checking.read(path))
        self._settings = settings
        self._watch = watch
        script = self._load(self.tree)
        self._original_control: Version | None = None
        self._original = Version(script, self._within(20.0, MOST_STATES))
        asked = select(script.assertions, lines, patterns)
        numbers = [script.assertions.index(assertion) for assertion in asked]
        checker = checking.checker_for(script, settings, watch)
        self.verdicts: dict[int, Verdict] = {}
        seconds: dict[int, float] = {}
        for number in numbers:
            watch.begin(script.assertions[number].text)
            result = checking.check(checker, script.assertions[number])
            if result.diagnostics:
                raise ScriptError(*result.diagnostics)
            if result.verdict in (Verdict.PASS, Verdict.FAIL):
                self.verdicts[number] = result.verdict
                seconds[number] = result.seconds
        # The quick ones first: most changes are noticed by one of these.
        self._order = sorted(self.verdicts, key=seconds.__getitem__)
        self._seconds = {number: max(LEAST, SLOWER * spent) for number, spent in seconds.items()}
        self.reach = Reach(self.tree)
        self.checked = self.reach.checked()
        self._reached = {number: self.reach.reached(script.assertions[number].node) for number in self.verdicts}

    def _load(self, tree: syntax.Script, view: Literal["control"] | None = None) -> Script:
        from cspcheck.cspm import notation, script

        return script.load(
            tree,
            overrides=self._settings.definitions,
            typecheck=self._settings.typecheck,
            semantics=notation.ClassReading(view or self._settings.view, self._settings.outputs),
        )

    def _within(self, seconds: float, states: int | None = None) -> checking.Settings:
        given = self._settings.limits
        seconds = seconds if given.seconds is None else min(given.seconds, seconds)
        states = given.states if states is None or given.states is not None else states
        return replace(self._settings, limits=replace(given, seconds=seconds, states=states))

    def asks(self, change: Change) -> bool:
        """Whether what is changed stands behind one of the assertions, as far as names tell."""
        holding = self.reach.holding(change)
        return holding is None or any(holding in reached for reached in self._reached.values())

    def judged(self, change: Change, tree: syntax.Script) -> Mutant:
        """What becomes of a change of this script."""
        holding = self.reach.holding(change)
        # Where the change cannot be meant every verdict stays as it is.
        order = [number for number in self._order if holding is None or holding in self._reached[number]]
        try:
            script = self._load(tree)
        except ScriptError:
            return Mutant(change, "invalid")
        checkers: dict[float, checking.GuardedChecker] = {}
        broken, undecided = False, 0
        for number in order:
            assertion: Assertion = script.assertions[number]
            seconds = self._seconds[number]
            if seconds not in checkers:
                checkers[seconds] = checking.checker_for(script, self._within(seconds), self._watch)
            result = checking.check(checkers[seconds], assertion)
            if result.verdict is Verdict.ERROR:
                broken = True
            elif result.verdict is Verdict.UNKNOWN:
                undecided += 1
                if undecided == GIVEN_UP:
                    break
            elif result.verdict is not self.verdicts[number]:
                return Mutant(change, "noticed", assertion.text)
        # A process that cannot be evaluated any more is noticed whenever the script is checked.
        if broken or undecided:
            return Mutant(change, "invalid" if broken else "undecided")
        return Mutant(change, "equivalent" if self._is_equivalent(change, tree, script, order) else "unnoticed")

    def _is_proved_equivalent(self, change: Change, script: Script) -> bool:
        """Whether a change is in the data of a class, and means the same for all values there."""
        if not self.reach.is_in_class(change) or self.reach.is_control(change):
            return False
        from cspcheck.checker.proof.answer import specification_of
        from cspcheck.checker.proof.question import SolverSettings
        from cspcheck.checker.proof.sameness import mean_the_same

        settings = SolverSettings(seconds=PROOF, limit=LONGEST_PROOF)
        return mean_the_same(specification_of(self._original.script), specification_of(script), settings)

    def _is_equivalent(self, change: Change, tree: syntax.Script, script: Script, numbers: Sequence[int]) -> bool:
        classes = script.classes
        if classes is not None and classes.control and change.kind in ("predicate", "constant"):
            return False  # data, which this script does not look at
        if self.reach.is_axiom(change):
            return False  # the constants that it leaves open are looked at for some values only
        if self._is_proved_equivalent(change, script):
            return True
        settings = self._within(20.0, MOST_STATES)
        version = Version(script, settings)

        @cache
        def without_data() -> tuple[Version, Version] | None:
            try:
                if self._original_control is None:
                    self._original_control = Version(self._load(self.tree, "control"), settings)
                return self._original_control, Version(self._load(tree, "control"), settings)
            except ScriptError:  # it speaks of values that events have
                return None

        control = without_data if classes is not None and self.reach.is_control(change) else None
        # The same ones again and again: each is looked at once.
        expressions = dict.fromkeys(part for number in numbers for part in subjects(script.assertions[number].node))
        return equivalent(self._original, version, list(expressions), control)


class Mutation:
    """The mutants of some scripts and the assertions that are asked about them.

    A change in a file that several of the scripts include is tried in each of them: one that notices it is enough, and
    it is equivalent where no script tells it from what was there.

    Args:
        paths: the scripts, and of each the lines whose assertions are asked; None: all.
        settings: as for a check.
        patterns: which assertions are asked; all by default.
        kinds: which changes are made; all by default.
        system: whether only what is checked is changed, and not what is required (:meth:`.Reach.checked`).

    Raises:
        ScriptError: a script itself is wrong, or an assertion of it cannot be evaluated.
        Nothing: no assertion has a verdict.
    """

    def __init__(
        self,
        paths: Sequence[tuple[str, frozenset[int] | None]],
        settings: checking.Settings,
        *,
        patterns: Sequence[AssertionPattern] = (),
        kinds: Sequence[str] = (),
        system: bool = False,
        watch: checking.Watch | None = None,
    ) -> None:
        self._watch = watch or checking.NoWatch()
        self._kinds = frozenset(kinds)
        self._system = system
        self._judges = [_Judge(path, settings, lines, patterns, self._watch) for path, lines in paths]
        if not any(judge.verdicts for judge in self._judges):
            raise NothingToNotice

    def changes(self) -> list[Trial]:
        """The mutants to be tried, in the order of the texts."""
        found: dict[tuple[str, int, int, str], Trial] = {}
        for judge in self._judges:
            for change, tree in mutants(judge.tree):
                if self._kinds and change.kind not in self._kinds:
                    continue
                span = change.span
                key = os.path.realpath(span.source.name), span.start, span.end, change.text
                trial = found.setdefault(key, Trial(change, [], []))
                trial.scripts.append((judge, tree))
                holding = judge.reach.holding(change)
                trial.checked.append(holding is None or holding in judge.checked)
        chosen = [trial for trial in found.values() if not self._system or any(trial.checked)]
        return sorted(chosen, key=lambda trial: (trial.change.span.source.name, trial.change.span.start))

    def tried(self, trials: Sequence[Trial]) -> Iterator[Mutant]:
        """What becomes of each change."""
        for i, trial in enumerate(trials, 1):
            self._watch.begin(f"{i:,} of {len(trials):,} changes: {trial.change.text}")
            yield trial.judged()

    def sample(self, number: int, seed: int) -> Iterator[Mutant]:
        """What becomes of a number of changes drawn by chance, without those after which there is no script any more.

        Each change has a lot of its own, so that a draw stays as it is when the scripts change elsewhere.
        """
        trials = sorted(self.changes(), key=lambda trial: _lot(trial.change, seed))
        found = 0
        for trial in trials:
            if found == number:
                return
            self._watch.begin(f"{found + 1:,} of {number:,} changes: {trial.change.text}")
            mutant = trial.judged()
            if mutant.fate != "invalid":
                found += 1
                yield mutant


def _lot(change: Change, seed: int) -> bytes:
    span = change.span
    line = " ".join(span.source.line_text(span.line).split())
    text = "\n".join([str(seed), os.path.basename(span.source.name), line, str(span.column), change.text])
    return sha256(text.encode("utf-8", "surrogatepass")).digest()


@dataclass(frozen=True, slots=True)
class Trial:
    """A change and the scripts that it is tried in.

    Attributes:
        change: what is different.
        scripts: each script with its mutant.
        checked: for each, whether the change is one of what is checked there.
    """

    change: Change
    scripts: list[tuple[_Judge, syntax.Script]]
    checked: list[bool]

    def judged(self) -> Mutant:
        """What becomes of the change."""
        told: list[Mutant] = []
        for judge, tree in self.scripts:
            mutant = judge.judged(self.change, tree)
            if mutant.fate == "noticed":
                return mutant
            told.append(mutant)
        # A script that does not use what is changed says nothing about it.
        worst: list[Fate] = ["invalid", "undecided", "unnoticed"]
        asked = [m for m, (judge, _) in zip(told, self.scripts, strict=True) if judge.asks(self.change)] or told
        for fate in worst:
            if any(mutant.fate == fate for mutant in asked):
                return Mutant(self.change, fate)
        return asked[0]
