"""What stands behind a named process: its text, its place in the script, and the term that it stands for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from cspcheck.cspm.source import Span

if TYPE_CHECKING:
    from cspcheck.cspm.process.terms import Menu, Process


class Definition:
    """What a new reference needs beside its key; equal to every other so that only keys identify references."""

    __slots__ = ("_evaluate", "_text", "span")

    def __init__(self, text: str | Callable[[], str], span: Span | None, evaluate: Callable[[], Process]) -> None:
        self._text = text
        self.span = span
        self._evaluate = evaluate

    def evaluate(self) -> Process:
        """The term that a reference of this definition stands for."""
        return self._evaluate()

    def menu(self) -> Menu | None:
        """What the process offers, if that is known without its term."""
        return None

    @property
    def text(self) -> str:
        """How a person would write the reference; made when first asked for."""
        text = self._text
        if not isinstance(text, str):
            text = self._text = text()
        return text

    @property
    def name(self) -> str:
        """What is called so whatever its state is: the text, where nothing else is said."""
        return self.text

    @property
    def variables(self) -> Mapping[str, str]:
        """The variables of the state that the reference is, with their values as a person would write them."""
        return {}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Definition)

    def __hash__(self) -> int:
        return 0
