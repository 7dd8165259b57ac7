"""Recorded runs: files with a record of each event, a line of JSON each, as generated programs write them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.following import Departure, Follower, at
from cspcheck.messages import wrong_record


@dataclass(frozen=True, slots=True)
class RecordedEvent:
    """An event of a recorded run; ``time`` and ``tasks`` are None where the record does not say."""

    event: str
    hidden: bool
    time: float | None
    tasks: tuple[str, ...] | None
    inner: bool = False
    terminated: bool = False


@dataclass(frozen=True, slots=True)
class RunVerdict:
    """What following a run came to.

    ``departure`` is None if it is a trace; ``line`` is that of the departure in the file; ``events`` counts all events
    up to there, ``followed`` those that were followed.
    """

    departure: Departure | None
    line: int | None
    record: RecordedEvent | None
    events: int
    followed: int


def read_records(lines: Iterable[str], name: str) -> Iterator[tuple[int, RecordedEvent]]:
    """The records in the lines of a file, with the numbers of their lines. Empty lines do not count.

    Raises:
        ScriptError: a line is no record.
    """
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            found: Any = json.loads(line)
        except (ValueError, RecursionError):
            raise ScriptError(wrong_record(name, number, "it is no JSON")) from None
        if isinstance(found, str):
            yield number, RecordedEvent(found, False, None, None)
        elif isinstance(found, dict) and isinstance(found.get("event"), str):
            tasks = found.get("tasks")
            time = found.get("time")
            yield (
                number,
                RecordedEvent(
                    found["event"],
                    bool(found.get("hidden", False)),
                    _seconds(time),
                    tuple(map(str, tasks)) if isinstance(tasks, list) else None,
                    bool(found.get("inner", False)),
                    bool(found.get("terminated", False)),
                ),
            )
        else:
            raise ScriptError(wrong_record(name, number, "it has no text `event`"))


def _seconds(time: object) -> float | None:
    """A time as a record says it; None where it says none, or one that no clock shows."""
    if isinstance(time, bool) or not isinstance(time, (int, float)):
        return None
    try:
        return float(time)
    except OverflowError:
        return None


def follow(follower: Follower, records: Iterable[tuple[int, RecordedEvent]]) -> RunVerdict:
    """Follow a run to its end, or to where it leaves the process.

    Events that were hidden when they were recorded are left out, unless the follower follows those too.
    """
    count = 0
    for line, record in records:
        if follower.follows(record.event, record.hidden, record.inner):
            departure = follower.step(record.event, terminated=record.terminated)
            if departure is not None:
                return RunVerdict(at(departure, count), line, record, count, follower.followed)
        count += 1
    return RunVerdict(None, None, None, count, follower.followed)
