"""Which scripts and which of their assertions are meant: ``FILE``, ``FILE:LINE``, ``FOLDER``, ``--assert PATTERN``."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cspcheck.quantities import MOST, whole_number

if TYPE_CHECKING:
    from cspcheck.cspm.script import Assertion

STDIN = "-"
SUFFIX = ".csp"
_INCLUDE = re.compile(rb'^\s*include\s*"([^"\r\n]+)"', re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Target:
    """A script to check.

    Attributes:
        path: as the user wrote it, or as it was found below a folder; ``-`` is standard input.
        lines: the lines whose assertions are meant; None: all of them.
        named: whether the user named this very file (a folder's scripts are not).
    """

    path: str
    lines: frozenset[int] | None = None
    named: bool = True


@dataclass(frozen=True, slots=True)
class EmptyFolder:
    """A folder without scripts."""

    path: str


def targets(arguments: Iterable[str]) -> list[Target | EmptyFolder]:
    """What the arguments stand for, each script once, in the order of its first mention.

    ``x.csp:12`` means line 12 of ``x.csp``, unless there is a file of that very name. A folder stands for the scripts
    below it (:func:`scripts_below`).
    """
    found: dict[str, Target | EmptyFolder] = {}
    for argument in arguments:
        for target in _targets(argument):
            key = target.path if target.path == STDIN else os.path.normpath(target.path)
            known = found.get(key)
            if isinstance(known, Target) and isinstance(target, Target):
                lines = None if known.lines is None or target.lines is None else known.lines | target.lines
                target = Target(known.path, lines, known.named or target.named)
            found[key] = target
    return list(found.values())


def _targets(argument: str) -> Iterator[Target | EmptyFolder]:
    if argument == STDIN:
        yield Target(STDIN)
        return
    if os.path.isdir(argument):
        scripts = scripts_below(argument)
        if not scripts:
            yield EmptyFolder(argument)
        yield from (Target(script, named=False) for script in scripts)
        return
    match = re.fullmatch(r"(.+):(\d+)", argument)
    if match and not os.path.exists(argument):
        line = whole_number(match[2])
        yield Target(match[1], frozenset({line if line is not None else MOST}))
        return
    yield Target(argument)


def all_below(folder: str) -> list[str]:
    """The ``.csp`` files below a folder, sorted, without hidden folders."""
    found: list[str] = []
    for root, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        found.extend(os.path.join(root, name) for name in sorted(files) if name.endswith(SUFFIX))
    return found


def scripts_below(folder: str) -> list[str]:
    """The ``.csp`` files below a folder (:func:`all_below`), without those that another one of them includes.

    An included file is checked as a part of the script that includes it; on its own it need not make sense.
    """
    found = all_below(folder)
    waiting = {script: {os.path.realpath(path) for path in included_files(script)} for script in found}
    real = {script: os.path.realpath(script) for script in waiting}
    chosen: set[str] = set()
    while waiting:
        # What nobody includes stands for itself and brings what it includes. Only then it is known what the rest
        # includes: paths count from the folder of the script that all begins with.
        times = Counter(path for paths in waiting.values() for path in paths)
        firsts = {script for script, paths in waiting.items() if times[real[script]] == (real[script] in paths)}
        firsts = firsts or set(waiting)  # they include each other
        chosen |= firsts
        brought = {path for script in firsts for path in waiting[script]}
        waiting = {s: paths for s, paths in waiting.items() if s not in firsts and real[s] not in brought}
    return [script for script in found if script in chosen]


def included_files(script: str) -> list[str]:
    """All files that a script includes, and those that they include, as far as they are below its folder.

    Paths count from the folder of the script, as they do where it is read. It need not be a good script.
    """
    root = os.path.dirname(script)
    found: dict[str, None] = {}
    pending = [script]
    while pending:
        try:
            content = Path(pending.pop()).read_bytes()
        except OSError:
            continue
        for match in _INCLUDE.finditer(content):
            path = os.path.join(root, os.fsdecode(match[1]))
            if path not in found:
                found[path] = None
                pending.append(path)
    return list(found)


@dataclass(frozen=True, slots=True)
class AssertionPattern:
    """A pattern for the text of assertions.

    It matches where it occurs in the text. ``*`` stands for any characters; blanks do not count, so that
    ``SPEC[T=IMPL`` finds ``SPEC [T= IMPL``; everything else stands for itself, brackets included.
    """

    text: str

    def matches(self, assertion: str) -> bool:
        """Whether the pattern occurs in the text of an assertion."""
        parts = "".join(self.text.split()).split("*")
        return re.search(".*".join(map(re.escape, parts)), "".join(assertion.split())) is not None


def select(
    assertions: Sequence[Assertion], lines: frozenset[int] | None, patterns: Sequence[AssertionPattern]
) -> list[Assertion]:
    """The assertions that stand on one of *lines* (all for None) and match one of *patterns* (all for none)."""
    return [
        assertion
        for assertion in assertions
        if (lines is None or any(assertion.span.line <= line <= assertion.span.end_line for line in lines))
        and (not patterns or any(pattern.matches(assertion.text) for pattern in patterns))
    ]
