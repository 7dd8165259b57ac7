"""The way down a tree, from each node to those directly inside it."""

from __future__ import annotations

from dataclasses import fields

from cspcheck.cspm.syntax.nodes import Node

_CHILDLESS = frozenset({"Span", "str", "str | None", "int", "bool", "tuple[str, ...]"})
"""How the types of fields are written in which no node can be."""

_fields: dict[type[Node], tuple[str, ...]] = {}


def children(node: Node) -> list[Node]:
    """The nodes directly inside *node*, in the order of its fields, which is that of the text."""
    kind = type(node)
    names = _fields.get(kind)
    if names is None:
        names = _fields[kind] = tuple([f.name for f in fields(kind) if f.type not in _CHILDLESS])
    found: list[Node] = []
    for name in names:
        value = getattr(node, name)
        if isinstance(value, Node):
            found.append(value)
        elif type(value) is tuple and value:
            _add(found, value)
    return found


def _add(found: list[Node], items: tuple[object, ...]) -> None:
    for item in items:
        if isinstance(item, Node):
            found.append(item)
        elif type(item) is tuple:
            _add(found, item)
