"""Checking the mutants of a script: which changes does some assertion notice?"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from cspcheck import checking
from cspcheck.checker.verdict import Verdict
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.parsing.reading import parse
from cspcheck.mutation import Change, mutants
from cspcheck.selection import Pattern, select

if TYPE_CHECKING:
    from cspcheck.cspm.script import Assertion, Script
    from cspcheck.cspm.syntax import tree as syntax

Fate = Literal["noticed", "unnoticed", "undecided", "invalid"]
SLOWER = 10.0
"""A mutant may take so many times as long as the script itself, and ``LEAST`` seconds in any case."""
LEAST = 5.0


@dataclass(frozen=True, slots=True)
class Mutant:
    """What came of one change.

    Attributes:
        change: what is different.
        fate: ``noticed`` if the verdict of some assertion is another one; ``unnoticed`` if all are the same;
            ``undecided`` if none differs as far as limits allow to tell; ``invalid`` if it is no script any more.
        by: the assertion that noticed it.
    """

    change: Change
    fate: Fate
    by: str | None = None


class Nothing(Exception):
    """The script has no assertion to notice anything; or none of those meant is decided."""


class Mutation:
    """The mutants of one script and the assertions that are asked about them.

    Args:
        path: the script.
        settings: as for a check.
        patterns, lines: which assertions are asked; all by default.
        kinds: which changes are made; all by default.

    Raises:
        ScriptError: the script itself is wrong, or an assertion of it cannot be evaluated.
        Nothing: no assertion has a verdict.
    """

    def __init__(
        self,
        path: str,
        settings: checking.Settings,
        *,
        lines: frozenset[int] | None = None,
        patterns: Sequence[Pattern] = (),
        kinds: Sequence[str] = (),
        watch: checking.Watch | None = None,
    ) -> None:
        self.tree = parse(checking.read(path))
        self._settings = settings
        self._watch = watch or checking.NoWatch()
        self._kinds = frozenset(kinds)
        script = self._load(self.tree)
        asked = select(script.assertions, lines, patterns)
        numbers = [script.assertions.index(assertion) for assertion in asked]
        checker = checking.checker_for(script, settings, self._watch)
        self.verdicts: dict[int, Verdict] = {}
        seconds: dict[int, float] = {}
        for number in numbers:
            self._watch.begin(script.assertions[number].text)
            result = checking.check(checker, script.assertions[number])
            if result.diagnostics:
                raise ScriptError(*result.diagnostics)
            if result.verdict in (Verdict.PASS, Verdict.FAIL):
                self.verdicts[number] = result.verdict
                seconds[number] = result.seconds
        if not self.verdicts:
            raise Nothing
        # The quick ones first: most changes are noticed by one of these.
        self._order = sorted(self.verdicts, key=seconds.__getitem__)
        self._seconds = max(LEAST, SLOWER * max(seconds.values()))
        self.names = [script.assertions[number].text for number in self.verdicts]

    def _load(self, tree: syntax.Script) -> Script:
        from cspcheck.cspm import notation, script

        return script.load(
            tree,
            overrides=self._settings.definitions,
            typecheck=self._settings.typecheck,
            semantics=notation.ClassReading(self._settings.view, self._settings.outputs),
        )

    def changes(self) -> list[tuple[Change, syntax.Script]]:
        """The mutants to be tried, in the order of the text."""
        made = [(change, tree) for change, tree in mutants(self.tree) if not self._kinds or change.kind in self._kinds]
        return sorted(made, key=lambda pair: (pair[0].span.source.name, pair[0].span.start))

    def tried(self, changes: Sequence[tuple[Change, syntax.Script]]) -> Iterator[Mutant]:
        """What becomes of each change."""
        for i, (change, tree) in enumerate(changes, 1):
            self._watch.begin(f"{i:,} of {len(changes):,} changes: {change.text}")
            yield self._try(change, tree)

    def _try(self, change: Change, tree: syntax.Script) -> Mutant:
        try:
            script = self._load(tree)
        except ScriptError:
            return Mutant(change, "invalid")
        given = self._settings.limits
        seconds = self._seconds if given.seconds is None else min(given.seconds, self._seconds)
        settings = replace(self._settings, limits=replace(given, seconds=seconds))
        checker = checking.checker_for(script, settings, self._watch)
        undecided = broken = False
        for number in self._order:
            assertion: Assertion = script.assertions[number]
            result = checking.check(checker, assertion)
            if result.verdict is Verdict.ERROR:
                broken = True
            elif result.verdict is Verdict.UNKNOWN:
                undecided = True
            elif result.verdict is not self.verdicts[number]:
                return Mutant(change, "noticed", assertion.text)
        # A process that cannot be evaluated any more is noticed whenever the script is checked.
        return Mutant(change, "invalid" if broken else "undecided" if undecided else "unnoticed")
