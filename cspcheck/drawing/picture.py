"""A graph with words on it: what all formats of a picture are made from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

NodeKind = Literal["state", "initial", "deadlock", "terminated", "component", "junction"]
EdgeKind = Literal["event", "tau", "channel", "flow"]


@dataclass(frozen=True, slots=True)
class PictureNode:
    """A box or circle with a label; ``hint`` is shown where the format can show more (a tooltip).

    ``details`` are further lines inside a box, in smaller print.
    """

    label: str
    kind: NodeKind = "state"
    hint: str = ""
    details: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Edge:
    """An arrow with the labels on it; a line for ``channel``, where it is not known who gives and who takes."""

    source: int
    target: int
    labels: tuple[str, ...]
    kind: EdgeKind = "event"


@dataclass(frozen=True, slots=True)
class Picture:
    """A titled graph; node 0 is where reading starts."""

    title: str
    nodes: tuple[PictureNode, ...]
    edges: tuple[Edge, ...]


def folded(labels: Sequence[str], most: int = 3) -> list[str]:
    """The lines of an edge's label: the first few, and how many more there are."""
    if len(labels) <= most + 1:
        return list(labels)
    return [*labels[:most], f"and {len(labels) - most} more"]
