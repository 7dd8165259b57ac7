"""The process equations of classes, as far as they can be looked at without evaluating anything."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar

from cspcheck.cspm.diagnostics import DiagnosticSink
from cspcheck.cspm.oz import core, syntax as s
from cspcheck.cspm.oz.typing import messages as messages
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax

N = TypeVar("N", bound=syntax.Node)


def names_in(node: object) -> Iterator[syntax.Name]:
    """All plain names in a tree of CSPm, in the order of the text."""
    stack: list[object] = [node]
    while stack:
        part = stack.pop()
        if isinstance(part, syntax.Name):
            yield part
        elif isinstance(part, tuple):
            stack.extend(reversed(part))
        elif isinstance(part, syntax.Node) and is_dataclass(part):
            stack.extend(getattr(part, f.name) for f in reversed(fields(part)) if f.name != "span")


def defined_name(declaration: syntax.Declaration) -> tuple[str, Span] | None:
    """The name that a process equation defines."""
    match declaration:
        case syntax.PatternDefinition(pattern=syntax.NamePattern() as pattern):
            return pattern.text, pattern.span
        case syntax.FunctionDefinition():
            return declaration.name, declaration.span
    return None


def events_of(parts: Sequence[core.ProcessPart], channels: Mapping[str, core.Channel]) -> set[str]:
    """The channels that process equations mention."""
    return {name.parts[0] for part in parts for name in names_in(part.equations) if name.parts[0] in channels}


def check_equations(
    tree: s.Class,
    channels: Mapping[str, core.Channel],
    processes: Sequence[core.ProcessPart],
    own: Mapping[str, core.Operation],
    report: DiagnosticSink,
) -> None:
    """DiagnosticSink equations that `main` never leads to, and events that equations and schemas do not agree on."""
    equations: dict[str, tuple[syntax.Declaration, Span]] = {}
    for declaration in tree.equations:
        found = defined_name(declaration)
        if found is not None:
            equations.setdefault(found[0], (declaration, found[1]))
    if equations and "main" not in equations:
        near = [name for name in equations if name.lower() == "main"]
        report(messages.no_main(tree.name, near, next(iter(equations.values()))[1]))
    elif equations:
        reached, pending = {"main"}, ["main"]
        while pending:
            for name in names_in(equations[pending.pop()][0]):
                if name.parts[0] in equations and name.parts[0] not in reached:
                    reached.add(name.parts[0])
                    pending.append(name.parts[0])
        for equation, (_, span) in equations.items():
            if equation not in reached:
                report(messages.unreachable_equation(equation, tree.name, span))
    mentioned = events_of(processes, channels)
    for channel in channels.values():
        if channel.owner != tree.name:
            continue
        operation = own.get(channel.name)
        outputs = [p.name for p in channel.parameters if p.kind == "output"]
        if operation is None and outputs and channel.name in mentioned:
            report(messages.output_without_schema(channel.name, outputs, tree.name, channel.span))
        elif operation is None and processes and channel.name not in mentioned:
            report(messages.unused_channel(channel.name, tree.name, channel.span))
    for operation in own.values():
        if processes and operation.name not in mentioned and operation.spans:
            schema = next(o.name for o in tree.operations if o.span == operation.spans[0])
            report(messages.schema_not_in_main(schema, operation.name, tree.name, operation.spans[0]))


def renamed_equations(part: core.ProcessPart, names: Mapping[str, str]) -> core.ProcessPart:
    """Process equations with channels called otherwise."""
    return replace(part, equations=tuple([_renamed(equation, names) for equation in part.equations]))


def _renamed(node: N, names: Mapping[str, str]) -> N:
    if isinstance(node, syntax.Name):
        if len(node.parts) == 1 and node.parts[0] in names:
            return replace(node, parts=(names[node.parts[0]],))
        return node
    if not is_dataclass(node):
        return node
    changes: dict[str, Any] = {}
    for f in fields(node):
        value = getattr(node, f.name)
        new = _renamed_value(value, names)
        if new is not value:
            changes[f.name] = new
    return replace(node, **changes) if changes else node


def _renamed_value(value: Any, names: Mapping[str, str]) -> Any:
    if isinstance(value, syntax.Node):
        return _renamed(value, names)
    if isinstance(value, tuple):
        items = tuple([_renamed_value(item, names) for item in value])
        return value if all(a is b for a, b in zip(value, items, strict=True)) else items
    return value
