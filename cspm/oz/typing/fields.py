"""The fields of the events of classes: which are there, and how process equations are completed with the others.

In a class an event's name alone means the event with any values: ``put -> main`` is ``put?_ -> main``. In the control
view the data is dropped: a parameter with a decoration is no field of the event any more, unless some process
equation goes on to use what it received there. Simple parameters are addresses and stay.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

from cspcheck.cspm.naming.patterns import variables
from cspcheck.cspm.oz import core, syntax as oz
from cspcheck.cspm.oz.typing.equations import names_in
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.syntax.tree import Declaration, Expr, Field, Name, Node, Prefix

N = TypeVar("N", bound=Node)


@dataclass(frozen=True, slots=True)
class _Occurrence:
    """A prefix on a channel: ``channel.a!b?x -> body`` with its fields one by one."""

    node: Prefix
    channel: Name
    fields: tuple[Field, ...]


def occurrence(node: Prefix) -> _Occurrence | None:
    """A prefix taken apart; None if it does not begin with a plain name."""
    parts: list[Expr] = []
    rest = node.channel
    while isinstance(rest, syntax.Dot):
        parts.append(rest.left)
        rest = rest.right
    parts.append(rest)
    first = parts[0]
    if not isinstance(first, Name):
        return None
    dotted = [Field(span=part.span, kind="!", expression=part) for part in parts[1:]]
    return _Occurrence(node, first, (*dotted, *node.fields))


class Fields:
    """Which fields the events of classes have."""

    def __init__(self, dropped: Mapping[str, frozenset[int]]) -> None:
        self._dropped = dropped

    def kept(self, channel: str, parameters: int) -> list[int]:
        """The positions of the parameters that are fields of the channel's events."""
        dropped = self._dropped.get(channel, frozenset())
        return [position for position in range(parameters) if position not in dropped]

    def rewritten(self, node: N, channels: Mapping[str, core.Channel]) -> N:
        """A process equation with the fields of its events completed; all its nodes are new."""
        changes: dict[str, Any] = {}
        for f in fields(node):
            if f.name != "span":
                changes[f.name] = self._value(getattr(node, f.name), channels)
        copied = replace(node, **changes)
        if isinstance(copied, Prefix):
            return self._completed(copied, channels)  # type: ignore[return-value]
        return copied

    def _value(self, value: Any, channels: Mapping[str, core.Channel]) -> Any:
        if isinstance(value, Node):
            return self.rewritten(value, channels)
        if isinstance(value, tuple):
            return tuple([self._value(item, channels) for item in value])
        return value

    def _completed(self, node: Prefix, channels: Mapping[str, core.Channel]) -> Prefix:
        found = occurrence(node)
        if found is None or found.channel.text not in channels:
            return node
        channel = channels[found.channel.text]
        count = len(channel.parameters)
        kept = self.kept(channel.name, count)
        given = found.fields
        takes_rest = bool(given) and given[-1].kind != "!" and len(given) < count
        if len(given) > count or (takes_rest and len(kept) == count):
            return node
        if len(kept) == count:
            if len(given) == count:
                return node
            wildcard = _wildcard(found.channel.span)
            return replace(node, fields=(*node.fields, wildcard))
        chosen = [given[position] for position in kept if position < len(given)]
        if len(chosen) < len(kept):
            chosen.append(_wildcard(found.channel.span))
        return replace(node, channel=found.channel, fields=tuple(chosen))


def _wildcard(span: Span) -> Field:
    return Field(span=span, kind="?", pattern=syntax.Wildcard(span=span))


def kept_fields(tree: syntax.Script, models: Sequence[core.ClassModel], *, control: bool) -> Fields:
    """Which fields events have: all, or in the control view those that are more than data."""
    if not control:
        return Fields({})
    channels: dict[str, list[core.Channel]] = {}
    for model in models:
        for channel in model.channels.values():
            channels.setdefault(channel.name, []).append(channel)
    kept: dict[str, set[int]] = {name: set() for name in channels}
    for name, users in channels.items():
        for channel in users:
            kept[name] |= {i for i, p in enumerate(channel.parameters) if p.kind == "simple"}
    for declaration in tree.declarations:
        _outside(declaration, kept, channels)
    for model in models:
        for part in model.processes:
            for prefix in _prefixes(part.equations):
                found = occurrence(prefix)
                if found is not None and found.channel.text in channels:
                    _inside(found, len(channels[found.channel.text][0].parameters), kept[found.channel.text])
    return Fields(
        {name: frozenset(range(max(len(c.parameters) for c in users))) - kept[name] for name, users in channels.items()}
    )


def _inside(found: _Occurrence, count: int, kept: set[int]) -> None:
    """Keep the fields whose values a process equation goes on to use."""
    used = {name.parts[0] for name in names_in(found.node.body)}
    for position, given in enumerate(found.fields):
        later = {
            name.parts[0]
            for other in found.fields[position + 1 :]
            for name in names_in((other.expression, other.restriction))
        }
        if given.pattern is not None:
            bound = {name.text for name in variables(given.pattern)}
            if bound & (used | later) or not isinstance(given.pattern, syntax.NamePattern | syntax.Wildcard):
                kept |= set(range(position, count)) if position == len(found.fields) - 1 else {position}


def _outside(
    declaration: Declaration, kept: dict[str, set[int]], channels: Mapping[str, Sequence[core.Channel]]
) -> None:
    """Keep all fields of the channels of which the CSPm part of the script writes events with fields."""
    if isinstance(declaration, oz.Class):
        return
    stack: list[Any] = [declaration]
    while stack:
        node = stack.pop()
        if isinstance(node, tuple):
            stack.extend(node)
            continue
        if not isinstance(node, Node):
            continue
        name: str | None = None
        if isinstance(node, Prefix):
            found = occurrence(node)
            name = found.channel.parts[-1] if found is not None and found.fields else None
        elif isinstance(node, syntax.Dot) and isinstance(node.left, Name):
            name = node.left.parts[-1]  # of `C::put.1` as well
        if name is not None and name in channels:
            kept[name] |= set(range(len(channels[name][0].parameters)))
        stack.extend(getattr(node, f.name) for f in fields(node) if f.name != "span")


def _prefixes(value: Any) -> Iterator[Prefix]:
    stack: list[Any] = [value]
    while stack:
        node = stack.pop()
        if isinstance(node, tuple):
            stack.extend(node)
        elif isinstance(node, Node):
            if isinstance(node, Prefix):
                yield node
            stack.extend(getattr(node, f.name) for f in fields(node) if f.name != "span")
