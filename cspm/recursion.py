"""Room for deep recursion: scripts may nest far deeper than Python's default limit allows.

From CPython 3.11 on, calls between Python functions take no C stack, so a high limit is safe as long as no
function written in C stands between them. The phases that walk trees or evaluate keep to that.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

FRAMES = 700_000
"""Nested Python calls that a phase may use; about 160 bytes each."""


@contextmanager
def deep_recursion() -> Iterator[None]:
    """Raise the recursion limit inside the block and restore it behind. Nesting is free."""
    before = sys.getrecursionlimit()
    if before >= FRAMES:
        yield
        return
    sys.setrecursionlimit(FRAMES)
    try:
        yield
    finally:
        sys.setrecursionlimit(before)
