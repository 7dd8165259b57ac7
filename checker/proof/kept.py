"""Answers of the solver that are kept from run to run, in the user's cache.

An answer is named after everything that it depends on: the question, what of the specification it can speak of, the
versions of the solver and of this program, and how hard the solver was to try, unless it has proved something, which
holds for good. Places in the text are no part of it, so a moved class has its answers still. Only what the solver
itself came to is kept, never that it was ended.
"""

from __future__ import annotations

import contextlib
import os
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from cspcheck.checker.proof.channel import ForeignValue, Sources, TooDeep, packed, unpacked
from cspcheck.checker.proof.question import Constraint, Found, Impossible, Request
from cspcheck.cspm.caches import cache_folder, seal, store, unsealed, usable
from cspcheck.cspm.oz import core
from cspcheck.cspm.recursion import deep_recursion

MOST_BYTES = 64 << 20
"""When all answers together are larger, those that were used longest ago go."""
_TIDY = 128
"""One in so many new answers looks at how large all are: which, their names say, however many runs they come from."""


@dataclass(frozen=True, slots=True)
class Kept:
    """An answer that was there."""

    value: Any


class KeptAnswers:
    """The answers to questions about one class of one specification."""

    def __init__(self, specification: core.Specification, model: core.ClassModel | None) -> None:
        self._subject = (specification, model)
        self._digest: str | None = None

    def keys(self, request: Request) -> tuple[str, str] | None:
        """The names of the answer to a request: of one that holds for good, and of one that more work might change.

        None where nothing can be kept.
        """
        if _folder() is None:
            return None
        if self._digest is None:
            self._digest = _digest(self._subject)
        asked = (request.verb, request.what, request.scopes, request.seed)
        key = _digest((_versions(), self._digest, asked))
        return key, _digest((key, request.seconds))

    def find(self, keys: tuple[str, str], parts: tuple[Constraint, ...]) -> Kept | None:
        """The answer with one of the names. What it says of the parts of the question is said of *parts*."""
        return self._found(keys[0], parts) or self._found(keys[1], parts)

    def _found(self, key: str, parts: tuple[Constraint, ...]) -> Kept | None:
        folder = _folder()
        path = None if folder is None else _path(folder, key)
        content = None if path is None else unsealed(path, folder)
        if content is None or path is None:
            return None
        try:
            answer = unpacked(content, Sources())
        except ForeignValue:
            return None
        with contextlib.suppress(OSError):
            os.utime(path)
        return Kept(_placed(answer, parts))

    def keep(self, keys: tuple[str, str], answer: Any, parts: tuple[Constraint, ...]) -> None:
        """Keep an answer under its name."""
        # With more work other values may be found, and those are shown.
        key = keys[0] if isinstance(answer, Impossible) else keys[1]
        folder = _folder()
        if folder is None:
            return
        path = _path(folder, key)
        try:
            content = packed(_numbered(answer, parts), Sources())
            path.parent.mkdir(mode=0o700, exist_ok=True)
        except (TooDeep, OSError):
            return
        store(path, seal(content))
        if int(key[:8], 16) % _TIDY == 0:
            tidy(folder)


def tidy(folder: Path, most: int = MOST_BYTES) -> None:
    """Let the oldest answers go if all together are too large."""
    found = []
    for path in folder.glob("??/*"):
        with contextlib.suppress(OSError):
            state = path.stat()
            found.append((state.st_mtime, state.st_size, path))
    total = sum(size for _, size, _ in found)
    for _, size, path in sorted(found):
        if total <= most:
            return
        with contextlib.suppress(OSError):
            path.unlink()
        total -= size


def _numbered(answer: Any, parts: tuple[Constraint, ...]) -> Any:
    """An answer with the numbers of parts for the parts, and no places of its own."""
    places = {id(part): number for number, part in enumerate(parts)}

    def number(part: Constraint) -> int:
        return places.get(id(part), next((n for n, other in enumerate(parts) if other == part), -1))

    if isinstance(answer, Found):
        return ("found", tuple(answer.values.items()), tuple(map(number, answer.vouched)))
    if isinstance(answer, tuple):
        return ("parts", tuple(map(number, answer)))
    return ("other", answer)


def _placed(answer: Any, parts: tuple[Constraint, ...]) -> Any:
    match answer:
        case ("found", items, vouched):
            return Found(dict(items), tuple(parts[number] for number in vouched))
        case ("parts", numbers):
            return tuple(parts[number] for number in numbers)
        case (_, value):
            return value
    raise AssertionError(answer)


def _digest(value: Any) -> str:
    """What tells values apart; their places do not count, and no order that differs from run to run."""
    with deep_recursion():
        return sha256(_text(value).encode("utf-8", "surrogatepass")).hexdigest()


def _text(value: Any) -> str:
    out: list[str] = []
    todo = [value]
    while todo:
        one = todo.pop()
        if isinstance(one, _Mark):
            out.append(one.text)
            continue
        fields = getattr(type(one), "__dataclass_fields__", None)
        if fields is not None:
            out.append(f"{type(one).__name__}(")
            todo.append(_Mark(")"))
            todo.extend(getattr(one, name) for name, field in reversed(fields.items()) if field.repr and name != "span")
        elif isinstance(one, (tuple, list)):
            out.append("(")
            todo.append(_Mark(")"))
            todo.extend(reversed(one))
        elif isinstance(one, (set, frozenset)):
            out.append("{" + ",".join(sorted(_text(item) for item in one)) + "}")
        elif isinstance(one, dict) or hasattr(one, "items"):
            out.append("[")
            todo.append(_Mark("]"))
            for item in reversed(list(one.items())):
                todo.extend((item[1], item[0]))
        else:
            out.append(f"{type(one).__name__}:{one!r};")
    return "".join(out)


class _Mark:
    """The end of something."""

    def __init__(self, text: str) -> None:
        self.text = text


@cache
def _versions() -> tuple[str, ...]:
    """The versions of everything that an answer depends on; for this program, of its very text."""
    try:
        solver = version("z3-solver")
    except PackageNotFoundError:
        solver = "unknown"
    own = sha256()
    proof = Path(__file__).parent
    for folder in (proof, Path(core.__file__).parent, Path(core.__file__).parent / "values"):
        for path in sorted(folder.glob("*.py")):
            own.update(path.read_bytes())
    return (solver, own.hexdigest())


def _folder() -> Path | None:
    base = cache_folder()
    if os.environ.get("CSPCHECK_PROOFS") == "new" or base is None:
        return None
    folder = base / "proofs"
    return folder if usable(base) and usable(folder) else None


def _path(folder: Path, key: str) -> Path:
    return folder / key[:2] / key[2:]
