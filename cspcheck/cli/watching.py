"""``cspcheck check --watch``: check again what has changed."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence

from cspcheck.result import Exit
from cspcheck.selection import EmptyFolder, Target, included_files

INTERVAL = 0.3
"""Seconds between two looks at the files."""

Stamp = tuple[int, int, int] | None
Goal = Target | EmptyFolder


def stamp(path: str) -> Stamp:
    """What changes with the content of a file: time, size, and which file it is; None where there is none."""
    try:
        status = os.stat(path)
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size, status.st_ino


def stamps(goal: Goal) -> dict[str, Stamp]:
    """The stamps of a script and of all that it includes."""
    return {path: stamp(path) for path in (goal.path, *included_files(goal.path))}


def is_changed(old: Mapping[str, Stamp], new: Mapping[str, Stamp]) -> bool:
    """Whether there is something new to be checked. A file that is gone is not: editors write a new one first."""
    return any(new[path] is not None and new[path] != old.get(path) for path in new)


def watch(
    find: Callable[[], Iterable[Goal]],
    check: Callable[[Sequence[Goal]], Exit],
    notify: Callable[[str], object],
    wait: Callable[[float], object] = time.sleep,
) -> Exit:
    """Check all goals, then those that have changed, until Ctrl-C.

    Args:
        find: the goals as they are now; a folder may have new scripts.
        check: checks some of them.
        notify: is told what goes on, in lines.
        wait: lets a time in seconds pass.

    Returns:
        The exit code of the last check; that of an interrupted one where the interrupt fell into a check.
    """
    known: dict[str, dict[str, Stamp]] = {}
    code = Exit.OK
    try:
        while True:
            goals = list(find())
            now = {goal.path: stamps(goal) for goal in goals}
            changed = [goal for goal in goals if goal.path not in known or is_changed(known[goal.path], now[goal.path])]
            known = {path: _merged(known.get(path, {}), new) for path, new in now.items()}
            if changed:
                code = check(changed)
                if code is Exit.INTERRUPTED:
                    return code
                files = len({path for goal in known.values() for path in goal})
                notify(f"watching {files} {'file' if files == 1 else 'files'}; Ctrl-C ends")
            else:
                wait(INTERVAL)
    except KeyboardInterrupt:
        return code


def _merged(old: Mapping[str, Stamp], new: Mapping[str, Stamp]) -> dict[str, Stamp]:
    """The new stamps, with the old one of a file that is away for a moment."""
    return {path: old.get(path) if mark is None else mark for path, mark in new.items()}
