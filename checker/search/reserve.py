"""Memory for arrays that grow where they are.

A reserve is address space for as much as the machine could ever hold; only what is written to takes memory. An array
at its beginning can be replaced by a longer one that has the same contents, with nothing to copy and nothing to give
back and ask for again, which on some machines costs as much as the search itself.
"""

from __future__ import annotations

import mmap
import os
import sys
from typing import Any

import numpy as np
import numpy.typing as npt

_NO_RESERVE = 0x4000
"""Linux's ``MAP_NORESERVE``, which ``mmap`` does not name before Python 3.13."""


class Reserve:
    """Address space. Its arrays keep it alive."""

    __slots__ = ("_space",)

    def __init__(self, space: mmap.mmap) -> None:
        self._space = space

    def holds(self, nbytes: int) -> bool:
        """Whether an array may be so large."""
        return nbytes <= len(self._space)

    def array(self, count: int, dtype: type[np.signedinteger[Any]]) -> npt.NDArray[Any]:
        """The first *count* entries; zero, where nothing was ever written."""
        return np.frombuffer(self._space, dtype=dtype, count=count)


def reserve() -> Reserve | None:
    """As much address space as there is memory; None where the system cannot do it without taking the memory."""
    if sys.platform != "linux":
        return None
    flags = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | _NO_RESERVE
    try:
        space = mmap.mmap(-1, os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"), flags=flags)
    except (OSError, ValueError, OverflowError):
        # A limit on address space, or an unknown amount of memory.
        return None
    try:
        # Larger pages: a table that is read all over takes more small ones than the processor remembers.
        space.madvise(mmap.MADV_HUGEPAGE)
    except OSError:
        # This kernel has none; the search is slower then and no different.
        return Reserve(space)
    return Reserve(space)
