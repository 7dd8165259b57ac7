"""What names mean where a document is read with objects as references."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from cspcheck.cspm.oz.objects.types import ObjectZType
from cspcheck.cspm.source import Span


@dataclass(frozen=True, slots=True)
class Value:
    """A value of a type; *generics* are the given types in it that stand for parameters."""

    type: ObjectZType
    span: Span | None = None
    generics: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ClassName:
    """A class, which is the set of its objects."""

    name: str
    span: Span


@dataclass(frozen=True, slots=True)
class Deferred:
    """A paragraph of the document whose type is found when it is asked for."""

    make: Callable[[], Value | None]
    span: Span | None


Entry: TypeAlias = Value | ClassName | Deferred


class Scope:
    """Names with their strokes, and what they mean; what is not here is looked up around it."""

    __slots__ = ("_around", "names")

    def __init__(self, around: Scope | None = None, names: Mapping[str, Entry] | None = None) -> None:
        self._around = around
        self.names: dict[str, Entry] = dict(names or {})

    def find(self, name: str) -> Entry | None:
        """What a name means; None for nothing."""
        scope: Scope | None = self
        while scope is not None:
            entry = scope.names.get(name)
            if entry is not None:
                return entry
            scope = scope._around
        return None

    def known(self) -> list[str]:
        """All names, the innermost first."""
        found: list[str] = []
        scope: Scope | None = self
        while scope is not None:
            found += scope.names
            scope = scope._around
        return found
