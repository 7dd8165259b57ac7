"""Recorders: what happened, event by event, in the order in which it happened.

A record is one event; as JSON it is one line::

    {"n": 0, "time": 0.1, "event": "pc.3", "channel": "pc", "values": [3], "tasks": ["P", "C"], "hidden": false}

``event`` is the event as the specification writes it; it is what ``cspcheck trace`` reads. At the end of a program all
of whose tasks have ended stands ``tick``, with ``terminated`` true, since a specification may have an event of this
name. ``inner`` stands there, true, where a part of the composition hides the
event and not the whole. ``values`` are for other readers.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from enum import Enum
from typing import IO, Any, NamedTuple, Protocol

from .data import Tagged


class Record(NamedTuple):
    """One event of a run."""

    number: int
    time: float
    event: str
    channel: str
    values: tuple[Any, ...]
    tasks: tuple[str, ...]
    hidden: bool
    inner: bool = False
    terminated: bool = False

    def to_json(self) -> str:
        """The record as one line of JSON."""
        return json.dumps(
            {
                "n": self.number,
                "time": round(self.time, 6),
                "event": self.event,
                "channel": self.channel,
                "values": [_plain(value) for value in self.values],
                "tasks": list(self.tasks),
                "hidden": self.hidden,
                **({"inner": True} if self.inner else {}),
                **({"terminated": True} if self.terminated else {}),
            }
        )


class Recorder(Protocol):
    """What a program tells its events to. Called under the program's lock, so one after the other: be quick."""

    def record(self, record: Record) -> None:
        """An event has happened. What this raises stops the program."""

    def close(self) -> None:
        """The program has ended."""


class Nothing:
    """Keeps nothing: what a program has that runs for years."""

    def record(self, record: Record) -> None:
        """Forget it."""

    def close(self) -> None:
        """Nothing is left to do."""


class Memory:
    """Keeps the records in a list, all of them: for tests."""

    def __init__(self) -> None:
        self.records: list[Record] = []

    def record(self, record: Record) -> None:
        """Keep it."""
        self.records.append(record)

    def close(self) -> None:
        """Nothing is left to do."""

    def trace(self, *, hidden: bool = False) -> list[str]:
        """The events; the hidden ones among them if wanted."""
        return [record.event for record in self.records if hidden or not record.hidden]


class JsonLines:
    """Writes a line of JSON an event to a file.

    Lines are complete whenever the file can be seen to have them: after at most ``every`` events, and at the end.
    """

    def __init__(self, target: str | os.PathLike[str] | IO[str], *, every: int = 64) -> None:
        self._owned = isinstance(target, (str, os.PathLike))
        self._file: IO[str] = open(target, "w", encoding="utf-8") if isinstance(target, (str, os.PathLike)) else target  # noqa: SIM115
        self._every = every
        self._lines: list[str] = []

    def record(self, record: Record) -> None:
        """Write it, or keep it until there are some more."""
        self._lines.append(record.to_json())
        if len(self._lines) >= self._every:
            self._flush()

    def close(self) -> None:
        """Write what is left; close the file if it was opened here."""
        self._flush()
        if self._owned:
            self._file.close()

    def _flush(self) -> None:
        if self._lines:
            self._file.write("\n".join(self._lines) + "\n")
            self._lines.clear()
        self._file.flush()


class Several:
    """Tells several recorders."""

    def __init__(self, recorders: Iterable[Recorder]) -> None:
        self._recorders = tuple(recorders)

    def record(self, record: Record) -> None:
        """Tell all of them, in order."""
        for recorder in self._recorders:
            recorder.record(record)

    def close(self) -> None:
        """Close all of them."""
        for recorder in self._recorders:
            recorder.close()


def _plain(value: Any) -> Any:
    """A value as JSON has it."""
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, Tagged):
        return [value.name, *map(_plain, value.fields)] if value.fields else value.name
    if isinstance(value, frozenset):
        return sorted(map(_plain, value), key=repr)
    if isinstance(value, tuple):
        return list(map(_plain, value))
    return value
