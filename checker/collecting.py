"""Python's collector of cycles, held back while millions of objects are made that stay."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

YOUNG = 1_000_000
"""So many objects are made before the young ones are looked through: what an exploration makes mostly stays."""
OLDER = 50
"""So many times the young ones, before those that have survived once are looked through, and so on."""


@contextmanager
def seldom() -> Iterator[None]:
    """Look for cycles seldom inside: an exploration of 10^5 terms spends half of its time in the collector otherwise.

    What an evaluation leaves behind is still found among the young. Who has turned the collector off, or set it to
    look more seldom still, keeps that.
    """
    young, older, oldest = before = gc.get_threshold()
    if young:
        gc.set_threshold(max(young, YOUNG), max(older, OLDER), oldest)
    try:
        yield
    finally:
        if young:
            gc.set_threshold(*before)
