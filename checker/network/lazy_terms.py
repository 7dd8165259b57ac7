"""Terms of states that are told apart without them, each put together when someone asks for it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import overload

from cspcheck.cspm.process.terms import Process


class LazyTerms(Sequence[Process]):
    """The terms of many states, each put together when it is asked for."""

    def __init__(self, count: int, term: Callable[[int], Process]) -> None:
        self._count = count
        self._term = term
        self._known: dict[int, Process] = {}

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> Process: ...
    @overload
    def __getitem__(self, index: slice) -> list[Process]: ...

    def __getitem__(self, index: int | slice) -> Process | list[Process]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(self._count))]
        if not -self._count <= index < self._count:
            raise IndexError(index)
        index %= self._count
        found = self._known.get(index)
        if found is None:
            found = self._known[index] = self._term(index)
        return found

    def __iter__(self) -> Iterator[Process]:
        return (self[i] for i in range(self._count))
