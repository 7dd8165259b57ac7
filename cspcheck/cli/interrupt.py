"""Ctrl-C that is never lost, and the signal that asks a program to end, which is told in the same way.

Python raises ``KeyboardInterrupt`` wherever the program happens to be. Where that is a callback from machine code (the
compiler of the kernels has some), the exception is printed and dropped, and the program goes on. Here the wish is
remembered, and told again at the next chance.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import Any, Self


class Interrupts:
    """While this is entered, an interrupt is remembered until :meth:`poll` or the end of the block tells it."""

    def __init__(self) -> None:
        self._asked: int | None = None
        self._holding = False
        self._handlers: dict[signal.Signals, Any] = {}
        self._hook = sys.unraisablehook

    def __enter__(self) -> Self:
        for number in (signal.SIGINT, signal.SIGTERM):
            try:
                self._handlers[number] = signal.signal(number, self._interrupt)
            except ValueError:  # not the main thread, which alone gets signals
                break
        self._hook = sys.unraisablehook
        sys.unraisablehook = self._unraisable
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        sys.unraisablehook = self._hook
        for number, handler in self._handlers.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        self._handlers = {}

    def poll(self) -> None:
        """A chance to stop.

        Raises:
            KeyboardInterrupt: there was an interrupt.
        """
        if self._asked is not None:
            raise KeyboardInterrupt(self._asked)

    @contextmanager
    def held(self) -> Iterator[None]:
        """While this is entered nothing is interrupted: what belongs together is done whole, or not begun."""
        self.poll()
        self._holding = True
        try:
            yield
        finally:
            self._holding = False
        self.poll()

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        self._asked = number
        if not self._holding:
            raise KeyboardInterrupt(number)

    def _unraisable(self, unraisable: Any) -> None:
        if not (self._asked is not None and unraisable.exc_type is KeyboardInterrupt):
            self._hook(unraisable)


def goes_on(interrupt: KeyboardInterrupt) -> None:
    """Ctrl-C ends what a prompt is doing, not the prompt. Who is asked to end does that: it is raised again.

    Raises:
        KeyboardInterrupt: it stands for the signal to end.
    """
    if signal.SIGTERM in interrupt.args:
        raise interrupt
