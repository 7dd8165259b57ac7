"""Long searches on disk, so that one that is ended in the midst goes on from there.

A search is written every so often: the states that it has found since the last time behind those in a file, and then,
whole or not at all, a small file that says how many of them count and where the search was. Whatever happens in between
leaves the checkpoint before. A search is found again by the digest of everything that decides what it finds; how many
threads share the work and which limits it has do not count.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from cspcheck.checker.arrays import Int64Array, UInt8Array
from cspcheck.checker.packing.packed import PackedNetwork
from cspcheck.checker.search.pairs import Pairs
from cspcheck.cspm.caches import seal

EVERY = 60.0
"""Seconds between two checkpoints of a search; one that ends before the first is never written."""
PIECE = 1 << 20
"""Words that are read or written at a time."""
MANIFEST = "checkpoint.json"
"""The file that says what a folder of checkpoints belongs to."""
FORMAT = 3


class Mismatch(Exception):
    """A folder holds checkpoints of something else; the message says of what."""


@dataclass(slots=True)
class Position:
    """Where in a level a search is.

    Attributes:
        visible: whether the level is closed under tau, and its visible transitions are being looked at.
        done: taus: the first row that the wave began with.
        first: the first row whose transitions have not been looked at.
        end: where the wave, or the level, ends.
        before: the transitions before the level.
        divergence: whether taus go round in the level.
        moved: which rows of the level have taus.
    """

    visible: bool = False
    done: int = 0
    first: int = 0
    end: int = 0
    before: int = 0
    divergence: bool = False
    moved: UInt8Array = field(default_factory=lambda: np.zeros(0, dtype=np.uint8))


@dataclass(slots=True)
class Tally:
    """What a search has counted so far."""

    known: int
    levels: list[int]
    transitions_at: list[int]
    transitions: int
    deadlocks: int
    violated: int
    branching: bool
    has_tau: bool
    deadlock_level: int | None
    divergence_level: int | None
    violation_level: int | None


class Checkpoints:
    """A folder of checkpoints: those of the searches for one script under one set of options.

    Args:
        folder: where they are.
        belongs: what decides what the searches find, in words: the version, the options, the script by its digest.
        resume: whether the folder must be there already, or must not.
        tell: takes a line about what cannot be written.
        every: seconds between two checkpoints; ``EVERY`` if not given.

    Raises:
        Mismatch: the folder is not there, or is one of something else.
        OSError: it cannot be written.
    """

    def __init__(
        self,
        folder: Path,
        belongs: dict[str, str],
        *,
        resume: bool,
        tell: Callable[[str], None] = lambda line: None,
        every: float | None = None,
    ) -> None:
        self.folder = folder
        self.tell = tell
        self.every = EVERY if every is None else every
        manifest = folder / MANIFEST
        said = {"format": str(FORMAT), **belongs}
        if manifest.exists() and not resume:
            raise Mismatch("it has checkpoints already; `--resume` goes on from them")
        if resume:
            try:
                found = json.loads(manifest.read_text(encoding="utf-8"))
            except FileNotFoundError:
                raise Mismatch("it has no checkpoints") from None
            except ValueError:
                raise Mismatch("its file `checkpoint.json` is damaged") from None
            for key in {**found, **said}:
                if found.get(key) != said.get(key):
                    raise Mismatch(f"its checkpoints are those of another {key}")
            return
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        _replace(manifest, json.dumps(said, indent=2).encode())

    @classmethod
    def beside(cls, folder: Path) -> Checkpoints:
        """A folder that another process looks after."""
        found = cls.__new__(cls)
        found.folder, found.every = folder, EVERY
        found.tell = lambda line: None
        return found

    def search(self, packed: PackedNetwork, pairs: Pairs | None, aims: tuple[int | None, ...]) -> Checkpoint | None:
        """The checkpoint of a search; None for one whose rows mean something in this process only."""
        if pairs is not None and pairs.is_lazy:
            return None
        return Checkpoint(self, _digest(packed, pairs, aims))


class Checkpoint:
    """The checkpoint of one search.

    Attributes:
        runs: of what was written last: how many rows each run of ascending rows has; None where the rows are in no
            order, as those of a search in memory.
    """

    def __init__(self, owner: Checkpoints, key: str) -> None:
        self._owner = owner
        self._key = key
        self._names = f"{key}.rows", f"{key}.sorted"
        self._rows = owner.folder / self._names[0]
        self.runs: list[int] | None = None
        self._state = owner.folder / f"{key}.json"
        self._number = 0
        self._written = 0
        self._sum = 0
        self._found: dict[str, Any] = {}
        self._next = time.monotonic() + owner.every
        self._failed = False

    def load(self, stride: int) -> tuple[Tally, Position] | None:
        """What was written last; None if nothing was, or if it is damaged. :meth:`fill` has the rows."""
        try:
            digest, _, content = self._state.read_bytes().partition(b"\n")
            if digest != sha256(content).hexdigest().encode():
                raise ValueError
            self._found = json.loads(content)
            tally, place = Tally(**self._found["tally"]), self._found["position"]
            self._rows = self._owner.folder / self._names[self._names.index(self._found["rows"])]
            runs = self._found["runs"]
            self.runs = None if runs is None else [int(count) for count in runs]
            number, length = int(self._found["number"]), int(self._found["moved"])
            moved = np.fromfile(self._moved(number), dtype=np.uint8, count=length)
            position = Position(**place, moved=moved)
            sound = len(moved) == length and self._rows.stat().st_size >= 8 * stride * tally.known
            sound = sound and (self.runs is None or sum(self.runs) == tally.known)
            sound = sound and self._found["digest"] == sha256(moved.tobytes()).hexdigest()
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError):
            sound = False
        if not sound:
            self._damaged()
            return None
        self._number = number
        return tally, position

    def fill(self, rows: Int64Array) -> bool:
        """Read the rows that were found before; whether they are those that were written."""
        self._sum = 0
        try:
            with open(self._rows, "rb") as file:
                for first in range(0, len(rows), PIECE):
                    piece = rows[first : first + PIECE]
                    if file.readinto(piece.data.cast("B")) != piece.nbytes:
                        raise ValueError
                    self._sum = _summed(self._sum, piece)
            sound = self._sum == self._found["sum"]
        except (OSError, ValueError, KeyError):
            sound = False
        if not sound:
            self._damaged()
            self._sum = 0
            return False
        self._written = len(rows)
        return True

    @property
    def folder(self) -> Path:
        """Where the checkpoint is."""
        return self._owner.folder

    @property
    def name(self) -> str:
        """What its files are called."""
        return self._key

    @property
    def written(self) -> int:
        """How many words of rows count of what is written."""
        return self._written

    def rows(self, first: int, last: int) -> Iterator[Int64Array]:
        """Words of the rows that were found before, some at a time."""
        with open(self._rows, "rb") as file:
            file.seek(8 * first)
            for place in range(first, last, PIECE):
                yield np.fromfile(file, dtype=np.int64, count=min(PIECE, last - place))

    def take_up(self, length: int, kept: int) -> bool:
        """Whether the first *length* words of the rows are those that were written; the first *kept* count then."""
        total = 0
        try:
            for first, last in ((0, kept), (kept, length)):
                for piece in self.rows(first, last):
                    total = _summed(total, piece)
                if last == kept:
                    self._sum = total
            sound = bool(total == self._found["sum"])
        except (OSError, KeyError):
            sound = False
        if not sound:
            self._damaged()
            self._sum = 0
            return False
        self._written = kept
        return True

    def write_pieces(self, pieces: list[tuple[int, Int64Array]]) -> tuple[int, int]:
        """Write rows at places of the file, while other processes do; the number of what went wrong, and their sum.

        Nothing of it counts before :meth:`settle` says so.
        """
        total = 0
        try:
            handle = os.open(self._rows, os.O_WRONLY | os.O_CREAT, 0o600)
            with open(handle, "wb", closefd=True) as file:
                for place, rows in pieces:
                    file.seek(8 * place)
                    file.write(np.ascontiguousarray(rows).data.cast("B"))
                    total = _summed(total, rows)
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            return error.errno or errno.EIO, 0
        return 0, total - (1 << 64) if total >> 63 else total

    def settle(self, total: int, written: int, tally: Tally, position: Position, *, first: bool) -> None:
        """Have what all processes have written count: their sums, and how many words of rows there are now."""
        self._sum, self._written, self.runs = (self._sum + total) % (1 << 64), written, None
        self._next = time.monotonic() + self._owner.every
        if first:
            try:
                self._commit(tally, position)
            except OSError as error:
                self.give_up(error.strerror or str(error))

    def give_up(self, why: str) -> None:
        """Try no more to write."""
        self._failed = True
        self._owner.tell(f"no more checkpoints: {why} ({self._owner.folder})")

    def _damaged(self) -> None:
        self._owner.tell(f"the checkpoint `{self._state}` is damaged; its search begins anew")

    def is_due(self) -> bool:
        """Whether it is time to write."""
        return not self._failed and time.monotonic() >= self._next

    def write(self, rows: Int64Array, stride: int, tally: Tally, position: Position) -> None:
        """Write where the search is. What cannot be written is told once, and then no more is tried."""
        length = tally.known * stride

        def pieces(begin: int) -> Iterator[Int64Array]:
            for first in range(begin, length, PIECE):
                yield np.ascontiguousarray(rows[first : min(first + PIECE, length)])

        self.write_some(pieces, length, None, tally, position)

    def write_some(
        self,
        pieces: Callable[[int], Iterator[Int64Array]],
        length: int,
        runs: list[int] | None,
        tally: Tally,
        position: Position,
    ) -> None:
        """Write where the search is, whose rows come in pieces.

        Args:
            pieces: the words of the rows from one of them on.
            length: how many words there are.
            runs: as the attribute.
            tally, position: what counts with them.
        """
        try:
            self._write(pieces, length, runs, tally, position)
        except OSError as error:
            self.give_up(error.strerror or str(error))
        self._next = time.monotonic() + self._owner.every

    def in_another_order(self) -> None:
        """The rows are written anew: what was written counts until that is done."""
        self._rows = self._owner.folder / self._names[self._rows.name == self._names[0]]
        self._written = self._sum = 0

    def _write(
        self,
        pieces: Callable[[int], Iterator[Int64Array]],
        length: int,
        runs: list[int] | None,
        tally: Tally,
        position: Position,
    ) -> None:
        total = self._sum
        with open(self._rows, "r+b" if self._rows.exists() else "w+b") as file:
            # What lies behind the rows that count was written by a run that has come to no checkpoint since.
            file.seek(8 * self._written)
            for piece in pieces(self._written):
                file.write(piece.data.cast("B"))
                total = _summed(total, piece)
            file.truncate()
            file.flush()
            os.fsync(file.fileno())
        self._written, self._sum, self.runs = length, total, runs
        self._commit(tally, position)
        with contextlib.suppress(OSError):
            (self._owner.folder / self._names[self._rows.name == self._names[0]]).unlink()

    def _commit(self, tally: Tally, position: Position) -> None:
        """Say what counts from now on, whole or not at all."""
        number = self._number + 1
        moved = position.moved.tobytes()
        _replace(self._moved(number), moved)
        state = {
            "number": number,
            "moved": len(moved),
            "digest": sha256(moved).hexdigest(),
            "sum": self._sum,
            "rows": self._rows.name,
            "runs": self.runs,
            "tally": asdict(tally),
            "position": {name: getattr(position, name) for name in position.__slots__ if name != "moved"},
        }
        _replace(self._state, seal(json.dumps(state).encode()))
        with contextlib.suppress(OSError):
            self._moved(self._number).unlink()
        self._number = number

    def _moved(self, number: int) -> Path:
        return self._owner.folder / f"{self._key}.{number}.moved"


def _summed(total: int, rows: Int64Array) -> int:
    """A sum over all words so far: it tells damaged files, and costs little beside finding them."""
    with np.errstate(over="ignore"):
        return (total + int(np.sum(rows ^ (rows >> 17) * 7, dtype=np.int64))) % (1 << 64)


def _replace(path: Path, content: bytes) -> None:
    """Write a file whole or not at all, and see that it is on the disk."""
    temporary = path.with_name(f".{path.name}.tmp")
    with open(temporary, "wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(temporary, path)


def _digest(packed: PackedNetwork, pairs: Pairs | None, aims: tuple[int | None, ...]) -> str:
    """What tells searches apart: what their rows mean, their transitions, and when they end."""
    digest = sha256(repr((FORMAT, packed.words, packed.participants, aims)).encode())
    arrays: list[Any] = [packed.events, packed.initial, packed.terminated, packed.causes]
    for table in (packed.rules, packed.tau, packed.visible, packed.cycling):
        arrays.extend(table)
    if pairs is not None:
        digest.update(repr((pairs.stride, pairs.root)).encode())
        arrays.extend(pairs.guide)
    for array in _leaves(arrays):
        values = np.ascontiguousarray(array)
        digest.update(f"{values.dtype}{values.shape}".encode())
        digest.update(values.tobytes())
    return digest.hexdigest()[:24]


def _leaves(value: Any) -> Iterator[Any]:
    """The arrays and numbers in tuples of tuples."""
    if isinstance(value, (tuple, list)):
        for part in value:
            yield from _leaves(part)
    elif value is not None:
        yield value
