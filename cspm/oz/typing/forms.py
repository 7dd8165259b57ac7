"""Forms of terms that typing looks for: rows of one operator, intervals, constructors, schemas, open types."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any

from cspcheck.cspm.oz import core, syntax as s
from cspcheck.cspm.oz.core import INT, Apply, Binder, Constant, SetType, Term, Variable
from cspcheck.cspm.oz.typing import type_messages as messages
from cspcheck.cspm.oz.typing.fitting import unknown_in
from cspcheck.cspm.oz.typing.scopes import ConstructorEntry, TypingScope
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.syntax.tree import Node


def row(node: s.Operator, name: str) -> list[s.Term]:
    """The operands of a chain of one operator, from left to right, however long."""
    found: list[s.Term] = []
    stack: list[s.Term] = [node]
    while stack:
        term = stack.pop()
        if isinstance(term, s.Operator) and term.name == name:
            stack.extend(reversed(term.operands))
        else:
            found.append(term)
    return found


def sets_of_one_range(node: Node) -> Iterator[tuple[s.Display, s.Operator]]:
    """The sets ``{m..n}`` from which declarations below a node take their values, each with the range in it."""
    stack: list[Any] = [node]
    while stack:
        found = stack.pop()
        if isinstance(found, tuple):
            stack.extend(reversed(found))
        elif isinstance(found, Node):
            if isinstance(found, s.Declare):
                match found.carrier:
                    case s.Display(kind="set", items=(s.Operator(name="range") as inner,)) as display:
                        yield display, inner
            stack.extend(getattr(found, f.name) for f in reversed(fields(found)) if f.name != "span")


def dotted(node: s.Term) -> tuple[str, s.Term | None] | None:
    """``a.b`` and ``f(x).b`` as a name with dots, and the argument in it if there is one; None for anything else."""
    path: list[str] = []
    index = None
    while True:
        match node:
            case s.Grouped():
                node = node.inner
            case s.Selection():
                path.append(node.field)
                node = node.record
            case s.Application():
                index, node = node.argument, node.function
            case s.Reference(decoration=""):
                return ".".join([node.name, *reversed(path)]), index
            case _:
                return None


def interval(binders: tuple[Binder, ...], condition: Term, body: Term) -> Term | None:
    """``{x : nat | a <= x <= b}`` as ``a..b``: a set that can be enumerated, and read.

    Only where the bounds are numbers written out.
    """
    if len(binders) != 1 or not isinstance(body, Variable) or body.name != binders[0].name:
        return None
    carrier = binders[0].carrier
    if not isinstance(carrier, Apply) or carrier.operator not in ("Int", "Nat", "Nat1"):
        return None
    least = {"Int": None, "Nat": 0, "Nat1": 1}[carrier.operator]
    greatest: int | None = None
    conjuncts = condition.operands if isinstance(condition, Apply) and condition.operator == "and" else (condition,)
    flat = [c for part in conjuncts for c in (part.operands if _is_and(part) else (part,))]  # type: ignore[attr-defined]
    for part in flat:
        match part:
            case Apply(operator="at_most" | "less" as op, operands=(Constant(value=int() as low), Variable(name=name))):
                if name != body.name:
                    return None
                low += op == "less"
                least = low if least is None else max(least, low)
            case Apply(
                operator="at_most" | "less" as op, operands=(Variable(name=name), Constant(value=int() as high))
            ):
                if name != body.name:
                    return None
                high -= op == "less"
                greatest = high if greatest is None else min(greatest, high)
            case _:
                return None
    if least is None or greatest is None:
        return None
    ends = (Constant(type=INT, value=least), Constant(type=INT, value=greatest))
    return Apply(type=SetType(INT), operator="range", operands=ends)


def constructor(node: s.Term, scope: TypingScope) -> ConstructorEntry | None:
    """The constructor that a name stands for; None for anything else."""
    node = s.bare(node)
    entry = scope.find(node.name) if isinstance(node, s.Reference) and not node.decoration else None
    return entry if isinstance(entry, ConstructorEntry) else None


def is_schema(term: Term) -> bool:
    """Whether a term is a schema, which is a predicate where one is expected."""
    return isinstance(term, Apply) and term.operator == "Records"


def _is_and(term: Term) -> bool:
    return isinstance(term, Apply) and term.operator == "and"


def settled(term: Term) -> Term:
    """*term*, of which every part has a type.

    Raises:
        Wrong: an empty collection has none.
    """
    stack = [term]
    while stack:
        part = stack.pop()
        if unknown_in(part.type):
            raise Wrong(messages.open_type(part.span or term.span))
        stack.extend(core.parts(part))
    return term
