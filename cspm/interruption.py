"""Work that is stopped from outside: the exception that arrives in it, and the words for what it was at.

Whoever watches over a piece of work (``checker.guard``) can stop it between any two steps of the program, wherever it
is. Here is what the work itself says of that: nothing but, here and there, what is going on.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import TracebackType

Words = str | Callable[[], str]
"""What is going on, as it stands after *while* (``normalising the specification``), or what tells it when asked."""


class Stopped(BaseException):
    """The work has passed a limit and ends here.

    Not an ``Exception``: it comes in the midst of anything, and who expects a mistake there has nothing to say to it.

    Attributes:
        doing: what was going on, innermost first.
        innermost, outermost: the script's call that was being evaluated, and the one that it all began with.
    """

    def __init__(self) -> None:
        super().__init__()
        self.doing: list[str] = []
        self.innermost: str | None = None
        self.outermost: Callable[[], str] | None = None

    def called(self, text: Callable[[], str]) -> None:
        """Note that a call was being evaluated, from the inside outwards; *text* is asked for only if it is told."""
        if self.doing:
            return
        if self.innermost is None:
            self.innermost = text()
        self.outermost = text


class _Doing(threading.local):
    """What this thread is doing, outermost first."""

    def __init__(self) -> None:
        self.words: list[Words] = []


_doing = _Doing()


class during:  # noqa: N801 (reads as a statement)
    """``with during("normalising the specification"):`` says what goes on in the block.

    *vague*: what goes on inside it says more, if that has words of its own.
    """

    __slots__ = ("_vague", "_words")

    def __init__(self, words: Words, *, vague: bool = False) -> None:
        self._words = words
        self._vague = vague

    def __enter__(self) -> None:
        _doing.words.append(self._words)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if _doing.words:
            _doing.words.pop()
        if isinstance(error, Stopped) and not (self._vague and (error.doing or error.outermost is not None)):
            error.doing.append(told(self._words))


def told(words: Words) -> str:
    """The words themselves."""
    return words if isinstance(words, str) else words()


def doing() -> list[Words]:
    """What this thread is doing, outermost first: a list that goes on changing, for who watches from another thread."""
    return _doing.words
