"""Room for deep recursion: scripts may nest far deeper than Python's default limit allows.

From CPython 3.11 on, calls between Python functions take no C stack. Functions written in C that call Python ones do
(``any``, ``sorted``, comparing and hashing values that have such methods), half a kilobyte or so each: the usual eight
megabytes would be used up before the limit is reached, and the process would end by a signal. So the stack of the main
thread may become so large that the limit comes first. The system gives memory only to the part of it that is used.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache

try:
    import resource
except ImportError:  # there is no such limit
    resource = None  # type: ignore[assignment]

FRAMES = 700_000
"""Nested Python calls that a phase may use; about 160 bytes each."""
STACK = 1 << 29
"""Bytes that the stack of the main thread may have. ``sorted`` with a key takes five kilobytes, all others far less."""
USUAL_STACK = None if resource is None else resource.getrlimit(resource.RLIMIT_STACK)
"""What it may have outside, which is what other processes should get: they size the stacks of their threads by it."""


@cache
def enlarge_stack() -> None:
    """Let the stack of the main thread become as large as deep recursion needs, where the system allows that."""
    if resource is None or USUAL_STACK is None:
        return
    soft, hard = USUAL_STACK
    wanted = STACK if hard == resource.RLIM_INFINITY else min(STACK, hard)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        with suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_STACK, (wanted, hard))


@contextmanager
def deep_recursion() -> Iterator[None]:
    """Raise the recursion limit inside the block and restore it behind. Nesting is free."""
    before = sys.getrecursionlimit()
    if before >= FRAMES:
        yield
        return
    enlarge_stack()
    sys.setrecursionlimit(FRAMES)
    try:
        yield
    finally:
        sys.setrecursionlimit(before)
