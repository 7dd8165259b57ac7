"""Where this user's caches are, and when they can be trusted.

What is read from a cache can make the program do anything (machine code lies in one), so a folder counts only if
nobody else can write there. A cache is never needed: what is damaged, foreign or has no room is made anew, with a line
on standard error for what went wrong.
"""

from __future__ import annotations

import contextlib
import logging
import os
import sys
import tempfile
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path

_log = logging.getLogger("cspcheck")
"""Without a program that wants something else, its warnings are lines on standard error."""

_told: set[str] = set()


def cache_folder() -> Path | None:
    """Where this user's caches are kept by the custom of the operating system; None for a user without a home."""
    try:
        if sys.platform == "win32":
            return Path(os.environ.get("LOCALAPPDATA") or str(Path.home() / "AppData" / "Local")) / "cspcheck" / "cache"
        if sys.platform == "darwin":
            return Path.home() / "Library" / "Caches" / "cspcheck"
        return Path(os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")) / "cspcheck"
    except RuntimeError:
        return None


def usable(folder: Path) -> bool:
    """Whether a cache can be kept in a folder, which is made if it is not there: it is ours, and ours alone to write.

    Why not is told once.
    """
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = folder.stat()
    except OSError:
        return False
    if hasattr(os, "geteuid"):
        if found.st_uid != os.geteuid():
            tell(f"the cache `{folder}` belongs to another user and is not used")
            return False
        if found.st_mode & 0o002:
            tell(f"the cache `{folder}` can be written by everybody and is not used")
            return False
    return os.access(folder, os.W_OK)


def tell(line: str) -> None:
    """Say something about a cache, once."""
    if line not in _told:
        _told.add(line)
        _log.warning("%s", line)


def seal(content: bytes) -> bytes:
    """A file that knows its own contents: a line with their digest in front."""
    return sha256(content).hexdigest().encode() + b"\n" + content


def unsealed(path: Path, many: Path | None = None) -> bytes | None:
    """What was sealed in a file; None if there is none, or if it is damaged, which is told.

    *many*: the folder, of a cache of many files: that some of them are damaged is told once for all.
    """
    try:
        digest, _, content = path.read_bytes().partition(b"\n")
    except OSError:
        return None
    if sha256(content).hexdigest().encode() == digest:
        return content
    if many is None:
        tell(f"the cache file `{path}` was damaged and is made anew")
    else:
        tell(f"the cache `{many}` has damaged files, which are made anew")
    return None


def store(path: Path, content: bytes) -> bool:
    """Write a file whole or not at all; whether it is there. That it cannot be written is no mistake."""
    try:
        number, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError:
        return False
    try:
        with os.fdopen(number, "wb") as file:
            file.write(content)
        os.replace(temporary, path)
    except OSError:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        return False
    return True


def digests(folder: Path, apart: str) -> Mapping[str, str]:
    """The digest of every file below a folder, by its name there; the file *apart* does not count."""
    return {
        str(path.relative_to(folder)): sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != apart
    }
