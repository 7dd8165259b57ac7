"""What is wrong with the fields behind a channel or constructor: a wrong one, too many, or too few."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic, Label
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.typing import messages as messages
from cspcheck.cspm.typing.types import (
    EVENT,
    Atom,
    Datatype,
    Dot,
    Dotable,
    Extendable,
    Rigid,
    Row,
    Type,
    TypeWriter,
    Variable,
    components,
    parts,
    resolve,
    spread,
)

OPERANDS = ("the left operand of", "the right operand of")
"""How the roles of operands begin. A constructor without its fields is often the end of ``x == A.1``."""


def field_mistake(
    node: syntax.Node, expected: Type, actual: Type, role: str, labels: Sequence[Label], writer: TypeWriter
) -> Diagnostic | None:
    """The mistake in the fields of *node*, whose dotted type *actual* should be *expected*; None if it is another one.

    Goes through the fields as absorption does (see :mod:`cspcheck.cspm.typing.unification`), but binds nothing.
    """
    items = parts(actual)
    nodes = _dotted_nodes(node)
    known = len(nodes) == len(items)
    fields, result = spread(items[0])
    if result is not EVENT and type(result) is not Datatype:
        return None
    name = head_name(nodes[0]) if known else head_name(node)
    # What is still wanted: the type, and the name and number of the field.
    wanted: list[tuple[Type, str | None, int]] = [(field, name, i) for i, field in enumerate(fields, 1)]
    for k, item in enumerate(items[1:], 1):
        if not wanted:
            shown = [writer.write(field) for field in fields]
            return messages.surplus_fields(node.span, name, shown, len(items) - 1, labels)
        want, owner, number = wanted.pop(0)
        given: Type = item
        inner: list[Type] = []
        if type(item) is Extendable or type(want) is Rigid:
            return None
        if type(item) is Variable and k == len(items) - 1:
            return None
        if type(item) is Dotable and type(want) is not Dotable:
            inner, given = spread(item)
        if _differ(want, given):
            place = nodes[k] if known else node
            return messages.field_type(place.span, owner, number, writer.write(want), writer.write(given), labels)
        inner_name = head_name(nodes[k]) if known else None
        wanted[0:0] = [(field, inner_name, i) for i, field in enumerate(inner, 1)]
    if wanted and resolve(expected) is result:
        return missing(node, result, [want for want, _, _ in wanted], role, labels, writer)
    return None


def missing(
    node: syntax.Node,
    result: Type,
    fields: Sequence[Type],
    role: str,
    labels: Sequence[Label],
    writer: TypeWriter,
    *,
    in_set: bool = False,
) -> Diagnostic:
    """*node* would be a *result* with some more *fields*; *in_set* tells that it is to be an element of a set."""
    if role.startswith(OPERANDS):
        help_line = "`.` binds more loosely than any operator on values: put brackets around the dotted value"
    elif in_set and result is EVENT:
        help_line = "write `{| ... |}` for all events of a channel"
    elif result is EVENT:
        help_line = "give it its fields, as in `c.x`, `c!x` or `c?x`"
    else:
        help_line = "give the constructor its fields"
    shown = [writer.write(field) for field in fields]
    return messages.missing_fields(node.span, writer.write(result), shown, role, labels, help_line)


def head_name(node: syntax.Node) -> str | None:
    """The name in front of the dots, fields or arguments of *node*, if there is one."""
    while True:
        match node:
            case syntax.Name() | syntax.NamePattern():
                return node.text
            case syntax.Dot() | syntax.DotPattern():
                node = node.left
            case syntax.Prefix():
                node = node.channel
            case syntax.Paren():
                node = node.inner
            case syntax.ParenPattern():
                node = node.inner
            case syntax.Apply():
                node = node.function
            case _:
                return None


def _dotted_nodes(node: syntax.Node) -> list[syntax.Node]:
    """What stands between the dots and field marks of *node*, in order."""
    found: list[syntax.Node] = []
    waiting: list[syntax.Node] = [node]
    while waiting:
        part = waiting.pop()
        match part:
            case syntax.Dot() | syntax.DotPattern():
                waiting += [part.right, part.left]
            case syntax.Paren():
                waiting.append(part.inner)
            case syntax.ParenPattern():
                waiting.append(part.inner)
            case syntax.Prefix():
                communicated = [field.expression or field.pattern for field in part.fields]
                waiting += [field for field in reversed(communicated) if field is not None]
                waiting.append(part.channel)
            case _:
                found.append(part)
    return found


def _differ(one: Type, other: Type) -> bool:
    """Whether two types can be told apart without binding anything."""
    waiting = [(one, other)]
    while waiting:
        left, right = (resolve(type_) for type_ in waiting.pop())
        if left is right or type(left) in _UNSURE or type(right) in _UNSURE:
            continue
        if type(left) is not type(right) or type(left) in (Atom, Datatype):
            return True
        below, other_below = components(left), components(right)
        if len(below) != len(other_below):
            return True
        waiting.extend(zip(below, other_below, strict=True))
    return False


_UNSURE = (Variable, Rigid, Dot, Dotable, Extendable, Row)
